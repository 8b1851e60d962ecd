"""Associative limit analysis: one program, eq. (9) or eq. (10), linear unless joints can crush."""

from __future__ import annotations

from dataclasses import replace

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Answer, Found, certified
from masonry_opt.answer.reasons import Code, reason
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
    reasons = []
    if _is_short(answer, found):
        dual = "kinematic" if formulation == "static" else "static"
        of_dual, beside, _ = _solved(task, dual, curved)
        if not _is_short(of_dual, beside):
            answer, found = of_dual, beside
            reasons.append(reason(Code.BY_DUAL, formulation=dual))
    if found is None:
        status, why = no_optimum(problem, answer.solved.status, task.solver, task.effort)
        reasons = [why]
    else:
        status = Status.OPTIMAL
        if answer.solved.failed:
            reasons.append(reason(Code.STOPPED_SHORT, word=answer.solved.status))
    return Solution(
        status,
        Kind.ASSOCIATIVE,
        tuple(reasons),
        found or Found(curved=curved),
        size=size,
        solver=task.solver,
    )


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


def with_associative(task: Task, of: Solution) -> Solution:
    """A Coulomb answer with the associative load factor beside it, by the usual solver, unless it was looked
    for before; that stays None where no answer is borne out."""
    if of.associative_ended is not None or of.associative is not None:
        return of
    own = Task(task.problem, kept=task.kept)
    task.effort.begins("associative load factor")
    task.effort.uses(own.solver.name, "associative")
    with task.effort.measure("associative"):
        solution = associative(own, by_chords=True).accepted()
    return replace(of, associative=solution.load_factor, associative_ended=solution.status)
