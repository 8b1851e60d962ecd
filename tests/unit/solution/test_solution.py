"""A solution stores facts in fields, and its reasons express the same facts in words."""

from math import inf

from masonry_opt.methods.exact.search import StateRecord
from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.reasons import LOAD_FACTORS, Code, Status
from masonry_opt.solution.solution import Solution


def found(*load_factors, lowest=inf):
    """Return a record of states with these load factors, from twice as many starts."""
    met = StateRecord(LoadFactorScale())
    met.load_factors = list(load_factors)
    met.candidates = 2 * len(load_factors)
    met.lowest = min(lowest, *load_factors)
    return met


def test_starts_and_states_are_fields_with_the_values_of_their_reasons():
    solution = found(0.3, 0.2, lowest=-0.1).recorded_in(Solution(Status.CONVERGED, Kind.EXACT))
    assert (solution.starts, solution.exact_states, solution.below_zero) == (4, 2, -0.1)
    states = solution.values_of(Code.STATES_MET)
    assert states == {"candidates": 4, "count": 2, "least": 0.2, "most": 0.3}
    assert solution.values_of(Code.BELOW_ZERO) == {"load_factor": -0.1}


def test_without_a_state_nothing_is_recorded():
    solution = StateRecord(LoadFactorScale()).recorded_in(Solution(Status.SOLVER_FAILED, Kind.EXACT))
    assert (solution.starts, solution.exact_states, solution.reasons) == (None, None, ())


def test_another_end_drops_the_facts_of_earlier_reasons():
    before = Solution(
        Status.CONVERGED,
        Kind.INCREMENTAL,
        starts=4,
        exact_states=2,
        below_zero=-0.1,
        is_only_state=True,
        interrupted=True,
        followed_to_end=True,
        peak=0.4,
    )
    ended = before.ended(Status.SOLVER_FAILED, Code.UNDECIDED, word="no end was found", steps=3, looped=False)
    new = Solution(Status.SOLVER_FAILED, Kind.INCREMENTAL)
    for name in vars(new):
        if name not in ("reasons", "state"):
            assert getattr(ended, name) == getattr(new, name), name


def test_load_factors_among_the_values_of_reasons_are_those_that_reasons_have():
    met = found(0.3, 0.2, lowest=-0.1)
    for reason in met.reasons:
        assert set(LOAD_FACTORS[reason.code]) <= reason.values.keys()
