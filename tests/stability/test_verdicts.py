"""Random scenes of every kind and load against a second program: whether they stand, and up to what load.

Of 1,000 scenes at once: ``python benchmarks/second_program.py``.
"""

import pytest
from second_program import random_of_any_kind, verdict_on

#: Seeds that nothing is tuned on, and of the first eight those that take a second at most.
FIRST, FAST = 910_000, (0, 2, 3, 4)


@pytest.mark.parametrize(
    "seed", [pytest.param(FIRST + n, marks=() if n in FAST else pytest.mark.slow) for n in range(16)]
)
def test_no_verdict_is_wrong_or_left_open(seed):
    assert verdict_on(random_of_any_kind(seed)) in ("agrees", "on the edge")
