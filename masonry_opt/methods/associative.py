"""Associative limit analysis: one linear program, eq. (9) or eq. (10)."""

from __future__ import annotations

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.explain.diagnosis import no_optimum
from masonry_opt.methods.task import Method, Task
from masonry_opt.solvers.driver import Driver


def associative(task: Task, formulation: str = "static") -> Solution:
    """Load factor, forces and mechanism under associative flow.

    Parameters
    ----------
    formulation: "static", eq. (9), or "kinematic", eq. (10).
    """
    problem = task.problem
    driver = Driver(problem, formulation, task.solver, task.effort, of_load=True)
    answer = driver.solve()
    solution = Solution(Status.OPTIMAL, Kind.ASSOCIATIVE, slope=problem.friction, size=driver.size())
    if answer.state is None:
        solution.status, why = no_optimum(problem, answer.solved.word, task.solver, task.effort)
        solution.reasons.append(why)
    else:
        solution.load_factor = answer.state.load_factor
        solution.take(answer.state)
    return solution


STATIC = Method("static", associative)
KINEMATIC = Method("kinematic", lambda task: associative(task, "kinematic"))
