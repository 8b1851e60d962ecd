"""The loop of Gilbert, Casapulla & Ahmed (2006), section 4.2, and its extensions.

The extensions are an exact state at the end, and remedies for runs that fail.

- ``steps``: the six steps of the paper.
- ``run``: one run of the loop; when it stops, and the exact state in which it ends.
- ``options``: the options of the method, and the parameters of a run.
- ``nonassociative``: the method, which begins another run if one fails.
"""
