"""The least load factor of a scene, with its proof, for users."""

from dataclasses import dataclass, replace
from pathlib import Path

from masonry_opt.analysis import solve
from masonry_opt.brief import brief
from masonry_opt.errors import OptionError
from masonry_opt.methods.bounds.least import prove_least as prove_least_state
from masonry_opt.methods.bounds.settings import BUDGET, SETTINGS
from masonry_opt.methods.task import Task
from masonry_opt.scene.mistakes import suggests_arguments
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.proof import Proof
from masonry_opt.suitability import refuse_without_live_load


@dataclass(frozen=True)
class LeastLoadFactor:
    """Lowest load factor that was found, and the proof that no collapse state has a lower load factor.

    If no state was found, a proof shows that no state has a load factor from 0 to ``proof.bound``.

    Attributes
    ----------
    load_factor: lowest load factor of the exact collapse states found; None if no state was found.
    proof: proof that no collapse state has a load factor from 0 to ``proof.bound``; None if unproven.
    why: reason why the proof is missing; empty if there is a proof.
    """

    load_factor: float | None
    proof: Proof | None
    why: str

    __repr__ = brief

    def __str__(self) -> str:
        if self.proof is None:
            return self._without_proof()
        means = self.proof.contents
        if self.load_factor is None:
            bound = self.proof.bound
            return f"no collapse state has a load factor from 0 to {bound:.6g}, proven by {means}"
        return f"λ = {self.load_factor:.6g} is the least load factor, proven by {means}"

    def _without_proof(self) -> str:
        """Return the text to print if the search ended without a proof."""
        if self.load_factor is None:
            return (
                f"no collapse state was found, and no proof by conflicts excludes collapse states: {self.why}"
            )
        return (
            f"λ = {self.load_factor:.6g} is the lowest load factor found, but it is not proven to be the "
            f"least: {self.why}"
        )


@suggests_arguments
def prove_least(
    scene: Scene | str | Path, seconds: float = 60.0, *, products: bool = True
) -> LeastLoadFactor:
    """Find the least load factor of a plane scene with Coulomb friction, and prove that it is the least.

    The search starts from the answer of the default method, which proves most scenes of up to 15 joints.
    The proof covers forces whose sum is at most a million times the sum of the loads, and motions whose sum
    is at most a million times the mean velocity of the live load; :func:`~masonry_opt.check_proof` computes
    the exact sizes. Most scenes of up to about 30 joints are proven within seconds.

    If no state is known, states are searched for up to the associative load factor. If forces within friction
    can carry any multiple of the live load, the search ends at ten times the last load factor of the load
    history.

    Parameters
    ----------
    scene: a scene, or the path of a case file.
    seconds: time limit of the search for the proof.
    products: False to look for a proof by conflicts alone, whose clauses ``mo.export`` can write for SAT
        solvers. Such proofs take much longer on bonds of more than 20 joints.

    Returns
    -------
    LeastLoadFactor
        The lowest load factor, and its proof or the reason why the proof is missing.

    Raises
    ------
    CaseError
        If the scene is wrong, or no block carries a live load.
    OptionError
        If the time limit is not a positive number.
    """
    if not isinstance(seconds, int | float) or not seconds > 0:
        raise OptionError(f"seconds must be a positive number (found {seconds!r})")
    result = solve(scene)
    refuse_without_live_load(result.assembly)
    if result.proof is not None and (products or not result.proof.relaxations):
        return LeastLoadFactor(result.load_factor, result.proof, "")
    answer = result.solution.answer
    known = answer if answer is not None and answer.exact else None
    upper = BUDGET.range_end(result.assembly.problem, result.associative, result.solution.load_history)
    if known is None and upper is None:
        return LeastLoadFactor(None, None, result.message)
    settings = SETTINGS if products else replace(SETTINGS, most_products=0)
    outcome = prove_least_state(Task(result.assembly.problem), known, seconds, upper, settings)
    load_factor = None if outcome.best is None else outcome.best.load_factor
    return LeastLoadFactor(load_factor, outcome.proof, outcome.why)
