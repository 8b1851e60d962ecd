"""Options of the loop, and the parameters that a run works with."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import Field, Strict, model_validator

from masonry_opt.methods.task import Options
from masonry_opt.solvers.registry import Solver

#: The preset "paper": section 5, "unless stated otherwise", and neither an exact end nor remedies. A
#: sub-problem without a state, which the paper does not mention, makes the loop begin again with less slope.
PAPER: dict[str, Any] = {
    "sub_problems": "accurate",
    "alpha": 0.3,
    "alpha_min": 0.001,
    "beta": 0.6,
    "tol": 1e-5,
    "c0": 1e-5,
    "finish": False,
    "remedies": "slope",
}

#: What a run with accurate or rough sub-problems works with, where nothing else is given.
_ACCURATE: dict[str, Any] = {"alpha": 0.3, "shrink": 0.5, "beta": 0.6, "tolerance": None}
_ROUGH: dict[str, Any] = {"alpha": 0.1, "shrink": 0.1, "beta": 0.8, "tolerance": 1e-4}

ROUGH_FROM = 1000  #: Joints from which on sub-problems are solved roughly, with a solver that can.


class LoopOptions(Options):
    """Parameters of the loop.

    Attributes
    ----------
    preset: "paper": the paper's loop and nothing else (:data:`PAPER`); what is given beside it counts.
    sub_problems: "accurate": section 5's parameters (alpha 0.3, halved; beta 0.6), sub-problems solved as
        exactly as any program. "rough": a shorter series (alpha 0.1, 0.01, 0.001; beta 0.8) of roughly solved
        sub-problems (1e-4, in units of the load), which ends as soon as exact forces leave next to no energy
        in a mechanism near its last one. It may end lower or higher (on the walls of Table 1 from 3 % below
        to 16 % above); other methods start from accurate ones. Default: rough from 1000 joints (in space
        contact points) on, with a solver that stops early when it is asked to (Clarabel).
    alpha: slope of the contracting shear limit over μ, at first: a small value, 0 ≤ alpha ≤ 1.
    alpha_min: from there on the slope stays at this value (the last step may undershoot it once).
    beta: weight of the newest normal forces against those before, 0 < beta ≤ 1.
    tol: relative change of λ at which the loop stops.
    c0: small cohesion, as a fraction of the largest normal force of the first sub-problem (of each
        part of the scene that stands by itself; of 1000 times what acts on a joint's own blocks at most).
    start: first sub-problem: "associative", or "cohesive" (|s| ≤ trial_cohesion).
    trial_cohesion: of the cohesive start, in median block weights; raised while no state exists.
    max_iterations: sub-problems before a run of the loop gives up.
    always: run the loop even where the associative answer obeys the joints' own flow rule: a lower
        load factor may exist elsewhere in the scene.
    finish: end with exact forces: one more linear program finds, of the states that hold the mechanism
        found at yield, the one with the nearest load factor. After rough sub-problems two do: forces that
        leave least energy in faces that move without being at yield, then the mechanism that leaves least for
        them.
    remedies: what is tried where a run of the loop fails: "all", "slope" (only begin again with less
        slope, after a sub-problem without a state), or "none". Whatever is asked, an associative answer that
        was found roughly is solved accurately.
    revise: another way to turn the shear limits (section 6.4): called with a
        :class:`~masonry_opt.methods.loop.steps.LimitUpdate`, returns the next ``ShearLimits``.
    """

    preset: Literal["paper"] | None = None
    sub_problems: Literal["accurate", "rough"] | None = None
    alpha: Annotated[float, Strict(), Field(ge=0, le=1)] | None = None
    alpha_min: Annotated[float, Strict(), Field(ge=0, le=1)] = 0.001
    beta: Annotated[float, Strict(), Field(gt=0, le=1)] | None = None
    tol: Annotated[float, Strict(), Field(gt=0, lt=1)] = 1e-5
    c0: Annotated[float, Strict(), Field(ge=0, lt=1)] = 1e-5
    start: Literal["associative", "cohesive"] = "associative"
    trial_cohesion: Annotated[float, Strict(), Field(gt=0)] = 1.0
    max_iterations: Annotated[int, Strict(), Field(ge=1)] = 200
    always: Annotated[bool, Strict()] = False
    finish: Annotated[bool, Strict()] = True
    remedies: Literal["all", "slope", "none"] = "all"
    revise: Callable[[Any], Any] | None = None

    @model_validator(mode="before")
    @classmethod
    def _of_preset(cls, given: Any) -> Any:
        paper = isinstance(given, dict) and given.get("preset") == "paper"
        return PAPER | given if paper else given

    def parameters(self, joints: int, solver: Solver) -> "LoopParameters":
        """The parameters of a first run on a scene with so many joints, with a solver."""
        by_default = joints >= ROUGH_FROM and solver.entry.stops_early
        rough = self.sub_problems == "rough" or (self.sub_problems is None and by_default)
        given = self.model_dump(exclude={"preset", "sub_problems"}, exclude_none=True)
        return LoopParameters(**(_ROUGH if rough else _ACCURATE) | given)


class LoopParameters(LoopOptions):
    """What one run of the loop works with: the options, decided for a scene and a solver."""

    alpha: float
    beta: float
    shrink: float  #: factor on alpha from one sub-problem to the next (the paper: 1/2)
    #: Feasibility and gap asked of the solver of sub-problems; None: the solver's own.
    tolerance: float | None


@dataclass(frozen=True)
class Attempt:
    """What a run of the loop works with."""

    parameters: LoopParameters
    solver: Solver
    remedy: str = ""  #: the option that was changed for it, such as "beta=0.3"
    number: int = 1
