"""The least Coulomb load factor of a plane scene, with a proof by conflict learning."""

import time
from dataclasses import dataclass

from masonry_opt.answer.acceptance import SMALLEST
from masonry_opt.answer.answer import Answer
from masonry_opt.answer.proof import Proof
from masonry_opt.answer.thresholds import ZERO
from masonry_opt.methods.bounds.conflicts import Undecided
from masonry_opt.methods.bounds.search import ConflictSearch, OutOfTime
from masonry_opt.methods.bounds.settings import SETTINGS, ProofSettings
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import Problem


@dataclass(frozen=True)
class LeastSearch:
    """End of a search for the least load factor."""

    best: Answer | None  #: lowest exact state: the known one, or a lower one that the search found
    proof: Proof | None  #: that no state is lower; None if the search ended without a proof
    why: str  #: why there is no proof; empty with a proof
    programs: int = 0  #: linear programs that the search solved


def refusal(problem: Problem) -> str:
    """Return why a problem has no proof by conflicts; an empty string if it may have one."""
    if problem.layout.round:
        return "proofs are for scenes in the plane: in space friction is a cone"
    if problem.dilatancy_depends_on_stress:
        return "the dilatancy depends on stress, and proofs need a constant flow rule"
    if (problem.dilatancy > problem.friction).any():
        return "a joint dilates by more than its friction, so that sliding would create energy"
    return ""


def prove_least(
    task: Task,
    known: Answer | None,
    seconds: float,
    upper: float | None = None,
    settings: ProofSettings = SETTINGS,
) -> LeastSearch:
    """Search for a state with 0 ≤ λ below the lowest state known, and prove that none exists.

    Parameters
    ----------
    task: the problem. Its effort counts the linear programs.
    known: the lowest exact state known; None if none is known.
    seconds: time limit of the search.
    upper: load factor that no state exceeds, such as the associative one; needed without a known state.
    settings: settings of the search.
    """
    refused = refusal(task.problem)
    if refused:
        return LeastSearch(known, None, refused)
    if known is not None:
        start = known.load_factor
    elif upper is not None:
        # The interval that the search examines includes a state at the upper bound itself.
        start = upper + 2 * settings.gap * max(upper, SMALLEST)
    else:
        return LeastSearch(None, None, "neither an exact state nor an upper bound is known")
    if start <= ZERO:
        return LeastSearch(known, None, "the lowest state known has a load factor of zero or less")
    search = ConflictSearch(task, start, time.perf_counter() + seconds, settings)
    proof, why = None, ""
    try:
        search.run()
        proof = search.proof()
    except OutOfTime:
        why = f"the search did not end within {seconds:g} s or {settings.most_programs} linear programs"
    except Undecided as error:
        why = str(error)
    return LeastSearch(search.best or known, proof, why, search.programs)
