"""Associative limit analysis: one program, eq. (9) or eq. (10), linear unless joints can crush."""

from __future__ import annotations

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Found, certified
from masonry_opt.answer.reasons import Code
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.methods.task import Task
from masonry_opt.solvers.driver import Driver
from masonry_opt.standing.diagnosis import no_optimum


def associative(task: Task, formulation: str = "static", by_chords: bool = False) -> Solution:
    """Load factor, forces and mechanism under associative flow.

    Parameters
    ----------
    formulation: "static", eq. (9), or "kinematic", eq. (10).
    by_chords: whether joints crush by chords, as in every Coulomb answer, also where the solver takes the
        parabola.
    """
    problem = task.problem
    crushes = bool(len(problem.crushing)) and not by_chords
    curved = task.solver.entry.conic and (crushes or problem.layout.round)

    def declared() -> Driver:
        repeats = task.kept.keeps
        return Driver(
            problem, formulation, task.solver, task.effort, of_load=True, repeats=repeats, curved=curved
        )

    key = ("associative", formulation, task.solver.key, curved)
    driver = task.kept.of(key, problem, task.effort, declared)
    # With cones of friction a solver may reach the optimum but for its last digits.
    answer = driver.solve(nearly=curved and problem.layout.round)
    solution = Solution(Status.OPTIMAL, Kind.ASSOCIATIVE, size=driver.size(), solver=task.solver)
    if answer.state is None:
        solution.found = Found(curved=curved)
        solution.status, why = no_optimum(problem, answer.solved.status, task.solver, task.effort)
        solution.reasons.append(why)
    else:
        state = answer.state
        solution.found = certified(problem, state.load_factor, state.q, state.d, problem.friction, curved)
        if answer.solved.failed:
            solution.add(Code.STOPPED_SHORT, word=answer.solved.status)
    return solution


def kinematic(task: Task) -> Solution:
    """The same by eq. (10)."""
    return associative(task, "kinematic")


def set_beside(task: Task, of: Solution) -> bool:
    """Set the associative load factor beside a Coulomb answer, by the usual solver, unless it was looked for
    before; it stays None if there is none that its certificate bears out. Returns whether the program, if it
    was solved now, has no limit."""
    if of.associative_sought or of.associative is not None:
        return False
    of.associative_sought = True
    own = Task(task.problem, kept=task.kept)
    task.effort.begins("associative load factor")
    task.effort.uses(own.solver.name, "associative")
    with task.effort.measure("associative"):
        solution = associative(own, by_chords=True)
    of.associative = solution.load_factor if solution.accept() else None
    return solution.status in (Status.UNLIMITED, Status.LOCKED)
