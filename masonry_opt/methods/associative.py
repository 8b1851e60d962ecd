"""Associative limit analysis: one program, eq. (9) or eq. (10), linear unless joints can crush."""

from dataclasses import replace

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Answer, Found, certified
from masonry_opt.answer.reasons import Code, Status, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import Problem, State
from masonry_opt.solvers.driver import LpAnswer
from masonry_opt.solvers.registry import LpSize
from masonry_opt.standing.diagnosis import no_optimum


def associative(task: Task, formulation: str = "static", by_chords: bool = False) -> Solution:
    """Load factor, forces and mechanism under associative flow, by the "static" formulation, eq. (9), or the
    "kinematic" one, eq. (10); by the dual program where the solver ends short. Joints crush by chords, as in
    every Coulomb answer, if so asked or the solver does not take the parabola."""
    problem = task.problem
    if task.solver.entry.conic:
        problem = problem.by_cone if by_chords else problem.by_cone.by_parabola
    answer, found, size = _solved(task, problem, formulation)
    if _is_short(answer, found):
        dual = "kinematic" if formulation == "static" else "static"
        of_dual, beside, _ = _solved(task, problem, dual)
        if not _is_short(of_dual, beside):
            answer, found = of_dual, beside
    solution = Solution(Status.OPTIMAL, Kind.ASSOCIATIVE, size=size, solver=task.solver)
    word = answer.solved.status
    if found is None:
        status, why = no_optimum(task.problem, word, task.solver, task.effort)
        return replace(solution, status=status, reasons=(why,), found=Found(forms=problem.forms))
    reasons = (reason(Code.STOPPED_SHORT, word=word),) if answer.solved.failed else ()
    return replace(solution, reasons=reasons, found=found)


def _solved(task: Task, problem: Problem, formulation: str) -> tuple[LpAnswer, Answer | None, LpSize]:
    """What a solver ends with, with its certificate if it is a state, and the program's size."""

    def certificate(state: State | None) -> Answer | None:
        return certified(problem, state.load_factor, state.q, state.d, problem.friction) if state else None

    how = {"of_load": True, "repeats": task.kept.keeps}
    driver = task.kept.driver(problem, formulation, task.solver, task.effort, **how)
    # A solver may reach the optimum but for its last digits.
    answer = driver.solve(nearly=True)
    found = certificate(answer.state)
    if problem.by_strength.conic and found and (answer.solved.failed or _is_short(answer, found)):
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
    """A Coulomb answer with the associative load factor beside it, unless it was looked for before; None
    where no answer is borne out."""
    if of.associative_ended is not None or of.associative is not None:
        return of
    own = Task(task.problem, kept=task.kept)
    task.effort.begins("associative load factor")
    task.effort.uses(own.solver.name, "associative")
    with task.effort.measure("associative"):
        solution = associative(own, by_chords=True).accepted()
    return replace(of, associative=solution.load_factor, associative_ended=solution.status)
