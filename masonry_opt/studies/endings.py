"""How a run ends that came to no result of its own: words in the tables of sweeps and comparisons."""

from __future__ import annotations

#: By an error of the user's, by any other, without a word.
REFUSED, CRASHED, DIED = "refused", "crashed", "died"
