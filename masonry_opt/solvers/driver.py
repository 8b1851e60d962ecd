"""One interface to every model and solver, so that an analysis does not know which it drives."""

from __future__ import annotations

from typing import Protocol

from masonry_opt.effort import Stopwatch
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.solvers.cvxpy_driver import CvxpyDriver
from masonry_opt.solvers.lp import Answer, LpSize
from masonry_opt.solvers.pyomo_driver import PyomoDriver
from masonry_opt.solvers.registry import Solver


class Driver(Protocol):
    """A declared model and the solver that answers it.

    Attributes
    ----------
    watch: where its time goes.
    """

    watch: Stopwatch

    @property
    def solves(self) -> int:
        """How often it was solved."""

    def set_shear_limits(self, limits: ShearLimits) -> None:
        """Change the model's shear limits, and nothing else."""

    def solve(self) -> Answer:
        """Solve with the present shear limits."""

    def size(self) -> LpSize:
        """Rows, columns and non-zeros of the linear program."""


def declare(
    problem: Problem,
    formulation: str,
    solver: Solver,
    watch: Stopwatch,
    limits: ShearLimits | None = None,
) -> Driver:
    """Declare a formulation ("static" or "kinematic") in the solver's language.

    ``limits`` default to the joints' own, with associative flow.
    """
    limits = limits or ShearLimits.associative(problem)
    if solver.language == "pyomo":
        return PyomoDriver(problem, formulation, limits, solver, watch)
    return CvxpyDriver(problem, formulation, limits, solver, watch)
