"""What the loop tries next where a run of it fails, in which order and how often."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

from masonry_opt.answer.status import Status
from masonry_opt.methods.loop.options import LoopParameters
from masonry_opt.solvers.registry import Solver, find_solver, rougher

#: Tolerance that a solver reaches where its own is too tight for a scene.
_LOOSER = 1e-7


@dataclass(frozen=True)
class Attempt:
    """What a run of the loop works with, and the option that was changed for it, such as "beta=0.3"."""

    parameters: LoopParameters
    solver: Solver
    remedy: str = ""


class Shortfall(StrEnum):
    """Why a load factor that a run converged to is not taken, while something is left to try."""

    INEXACT = "converged to no exact state"
    ROUGH = "converged roughly where the flow rule has no influence"


#: What to work with after a run that worked with this; None if that was tried.
Remedy = Callable[[Attempt], Attempt | None]


def _accurately(last: Attempt) -> Attempt | None:
    """Sub-problems solved as exactly as any program: a rough answer proves little."""
    if last.parameters.tolerance is None:
        return None
    parameters = replace(last.parameters, tolerance=None, early=False)
    return replace(last, parameters=parameters, remedy="sub_problems=accurate")


def less_slope(last: Attempt) -> Attempt | None:
    """A contracting limit |s| ≤ c - αμn also caps n at c / (αμ): less slope, less of a cap."""
    if last.parameters.alpha <= last.parameters.alpha_min:
        return None
    return _with(last, alpha=last.parameters.alpha / 3)


def _more_damping(last: Attempt) -> Attempt | None:
    return _with(last, beta=last.parameters.beta / 2)


def _cohesive_start(last: Attempt) -> Attempt | None:
    """Section 6.3: a start that dilatancy cannot lock."""
    if last.parameters.start == "cohesive":
        return None
    parameters = replace(last.parameters, start="cohesive")
    return replace(last, parameters=parameters, remedy="start=cohesive")


def _looser_solver(last: Attempt) -> Attempt | None:
    solver = rougher(last.solver, _LOOSER)
    if solver == last.solver or last.parameters.tolerance is not None:
        return None
    return replace(last, solver=solver, remedy=f"tolerance={_LOOSER:.0e}")


def _another_solver(last: Attempt) -> Attempt | None:
    name = "clarabel" if last.solver.name != "clarabel" else "highs-ipm"
    return replace(last, solver=find_solver("cvxpy", name), remedy=f"solver={name}")


def _with(last: Attempt, **changed: Any) -> Attempt:
    remedy = ", ".join(f"{name}={value:.2g}" for name, value in changed.items())
    return replace(last, parameters=replace(last.parameters, **changed), remedy=remedy)


#: What is tried after each way to fail, in this order, each entry once. Only what a scene of the atlas is
#: rescued by: more small cohesion, or less, helped 3 of 193 scenes, all of which a pass solves.
REMEDIES: dict[Status | Shortfall, tuple[Remedy, ...]] = {
    Status.LOCKED: (_cohesive_start,),
    Status.NO_STATE: (*(less_slope,) * 6, _accurately),
    Status.CYCLING: (_accurately, _more_damping, _another_solver),
    Status.ITERATION_LIMIT: (_accurately, _more_damping),
    Shortfall.INEXACT: (_accurately,),
    Status.SOLVER_FAILED: (_accurately, _looser_solver, _another_solver),
    Shortfall.ROUGH: (_accurately,),
}
