"""Studies: computations of many scenes or many states, made with the functions that users call.

A study repeats solves for other values, positions, load cases or solvers, and has its own kind of answer.
Single solves belong to ``analysis`` and ``methods``, and the command line of a study to ``cli``.
"""
