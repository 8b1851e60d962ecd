"""Associative limit analysis: one program, eq. (9) or eq. (10), linear unless joints can crush."""

from __future__ import annotations

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Answer, Found, certified
from masonry_opt.answer.reasons import Code
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.status import Status
from masonry_opt.methods.task import Task
from masonry_opt.problem.state import State
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.lp import LpAnswer, LpSize
from masonry_opt.standing.diagnosis import no_optimum


def associative(task: Task, formulation: str = "static", by_chords: bool = False) -> Solution:
    """Load factor, forces and mechanism under associative flow, by the dual program where the solver ends
    short in this one.

    Parameters
    ----------
    formulation: "static", eq. (9), or "kinematic", eq. (10).
    by_chords: whether joints crush by chords, as in every Coulomb answer, also where the solver takes the
        parabola.
    """
    problem, crushes = task.problem, bool(len(task.problem.crushing)) and not by_chords
    curved = task.solver.entry.conic and (crushes or problem.layout.round)
    answer, found, size = _solved(task, formulation, curved)
    solution = Solution(Status.OPTIMAL, Kind.ASSOCIATIVE, size=size, solver=task.solver)
    if _is_short(answer, found):
        dual = "kinematic" if formulation == "static" else "static"
        of_dual, beside, _ = _solved(task, dual, curved)
        if not _is_short(of_dual, beside):
            answer, found = of_dual, beside
            solution.add(Code.BY_DUAL, formulation=dual)
    if found is None:
        solution.found = Found(curved=curved)
        solution.status, why = no_optimum(problem, answer.solved.status, task.solver, task.effort)
        solution.reasons = [why]
    else:
        solution.found = found
        if answer.solved.failed:
            solution.add(Code.STOPPED_SHORT, word=answer.solved.status)
    return solution


def _solved(task: Task, formulation: str, curved: bool) -> tuple[LpAnswer, Answer | None, LpSize]:
    """What a solver ends with, with its certificate if it is a state, and the program's size."""
    problem, repeats = task.problem, task.kept.keeps

    def declared() -> Driver:
        return Driver(
            problem, formulation, task.solver, task.effort, of_load=True, repeats=repeats, curved=curved
        )

    def certificate(state: State | None) -> Answer | None:
        if state is None:
            return None
        return certified(problem, state.load_factor, state.q, state.d, problem.friction, curved)

    key = ("associative", formulation, task.solver.key, curved)
    driver = task.kept.of(key, problem, task.effort, declared)
    # A solver may reach the optimum but for its last digits.
    answer = driver.solve(nearly=True)
    found = certificate(answer.state)
    if curved and found and (answer.solved.failed or _is_short(answer, found)) and len(problem.crushing):
        # Once more with parabolas scaled by the forces that were found.
        again = driver.solve(nearly=True, near=found.q)
        if again.state is not None:
            answer, found = again, certificate(again.state)
    return answer, found, driver.size()


def _is_short(answer: LpAnswer, found: Answer | None) -> bool:
    """Whether the solver decided nothing, or its state is not borne out."""
    return bool(found.failing(Kind.ASSOCIATIVE)) if found else answer.solved.failed


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
