"""Functions that prove the least load factor without a known state, and the folder of scenes for them."""

from pathlib import Path

import masonry_opt as mo
from masonry_opt.methods.bounds.least import prove_least
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.answer import Answer
from masonry_opt.solution.proof import Proof

FOLDER = Path(__file__).parent / "analysis" / "low_states"

SECONDS = 120.0  #: Time limit of a search in seconds; all tests end earlier.


def associative(scene: mo.Scene) -> float:
    return mo.solve(scene, "static").required()


def found_from_above(scene: mo.Scene) -> tuple[Answer, Proof]:
    """Return the least state and its proof, found from the associative load factor alone."""
    search = prove_least(Task(assemble(scene).problem), None, SECONDS, associative(scene))
    assert search.proof is not None, search.why
    assert search.best is not None
    return search.best, search.proof
