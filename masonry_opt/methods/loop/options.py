"""Define the options of the loop, and the parameters of one run."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import Field, Strict, model_validator

from masonry_opt.methods.task import Options
from masonry_opt.solvers.registry import Solver

#: Options of the preset "paper": the values of the paper's section 5, without the exact state at the end. The
#: paper does not say what to do after an infeasible sub-problem. In this case, the preset runs the loop again
#: with a smaller slope α of the shear limits.
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

#: Default parameters of a run of the loop with accurate sub-problems, from section 5 of the paper.
_ACCURATE: dict[str, Any] = {"alpha": 0.3, "shrink": 0.5, "beta": 0.6, "tolerance": None}

#: Default parameters of a run of the loop with rough sub-problems. Compared with accurate sub-problems, the
#: solver has a larger tolerance, and α decreases in fewer steps: 0.1, 0.01, 0.001.
_ROUGH: dict[str, Any] = {"alpha": 0.1, "shrink": 0.1, "beta": 0.8, "tolerance": 1e-4}

#: Smallest number of joints at which sub-problems are rough (solved to a large tolerance) by default, if the
#: solver can stop early.
ROUGH_FROM = 1000


class LoopOptions(Options):
    """Options of the loop.

    Attributes
    ----------
    preset: "paper" for the loop as in the paper, with the values of ``PAPER`` and without the exact state
        at the end. Options that are set as well replace the values of the preset.
    sub_problems: "accurate" or "rough". The default is "rough" from 1000 joints (in space contact points),
        with a solver that can stop early (Clarabel). Otherwise the default is "accurate".

        - "accurate": the parameters of section 5 (alpha 0.3, halved; beta 0.6). Sub-problems are solved with
          the solver's usual tolerance.
        - "rough": a shorter series (alpha 0.1, 0.01, 0.001; beta 0.8) of sub-problems solved to 1e-4, in
          units of the load. The series ends as soon as exact forces are found with almost no energy z·p in a
          mechanism near the last one. The load factor may be lower or higher than with accurate sub-problems:
          on the walls of Table 1 from 3 % below to 16 % above. Method "mpec" always starts from accurate
          sub-problems.
    alpha: first slope of the contracting shear limit, relative to μ: a small value, 0 ≤ alpha ≤ 1.
    alpha_min: smallest slope, relative to μ. The slope shrinks to this value and then stays constant (the
        last step may undershoot it once).
    beta: weight of the newest normal forces against the forces before, 0 < beta ≤ 1.
    tol: relative change of λ at which the loop stops.
    c0: small cohesion, relative to the largest normal force of the first sub-problem in the joint's connected
        component. This force counts up to 1000 times the largest force on the joint's own blocks.
    start: first sub-problem: "associative", or "cohesive" (|s| ≤ trial_cohesion).
    trial_cohesion: cohesion of the cohesive start, relative to the median dead load of a block. It is raised
        as long as the first sub-problem is infeasible.
    max_iterations: largest number of sub-problems in a run of the loop.
    always: True to run the loop even if the associative answer obeys the joints' own flow rule. The loop may
        then find a lower load factor.
    finish: True to end with exact forces. One more linear program finds forces at which the faces with
        nonzero rates are at yield, with the nearest load factor. After rough sub-problems two programs are
        solved. The first finds forces of low λ that leave little energy in faces with nonzero rates that are
        not at yield. The second finds the mechanism that leaves least energy for these forces.
    remedies: changes that are tried if a run of the loop fails: "all", "slope" (only a smaller slope, after
        an infeasible sub-problem), or "none". A rough associative answer is always solved again accurately.
    revise: function that replaces the rule for the shear limits (section 6.4). It takes a
        ``LimitUpdate`` and returns the next ``ShearLimits``, both of the module
        ``masonry_opt.methods.loop.steps``.
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
    def _of_preset(cls, options: Any) -> Any:
        """Return the options. With preset "paper", options that are not set get the values of the preset."""
        has_preset = isinstance(options, dict) and options.get("preset") == "paper"
        return PAPER | options if has_preset else options

    def parameters(self, joints: int, solver: Solver) -> "LoopParameters":
        """Return the parameters of the first run, which depend on the number of joints and on the solver."""
        rough_by_default = joints >= ROUGH_FROM and solver.entry.stops_early
        rough = self.sub_problems == "rough" or (self.sub_problems is None and rough_by_default)
        overrides = self.model_dump(exclude={"preset", "sub_problems"}, exclude_none=True)
        return LoopParameters(**(_ROUGH if rough else _ACCURATE) | overrides)


class LoopParameters(LoopOptions):
    """Options of one run of the loop of linear programs.

    Options that the user does not set have defaults that depend on the number of joints and on the solver.
    """

    alpha: float
    beta: float
    shrink: float  #: ratio of α to α in the previous sub-problem; 1/2 in the paper
    #: Tolerance of the solver for infeasibility and duality gap, or None for the solver's usual tolerance.
    tolerance: float | None


@dataclass(frozen=True)
class Attempt:
    """Parameters and solver of one run of the loop of linear programs."""

    parameters: LoopParameters
    solver: Solver
    remedy: str = ""  #: changed option of this run, such as "beta=0.3"; "" for the first run
    number: int = 1  #: number of the run, from 1
