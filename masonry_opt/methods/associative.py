"""Associative limit analysis: one program, eq. (9) or eq. (10), linear unless joints can crush.

Modules that declare programs are imported where they are used: modelling languages take seconds.
"""

from dataclasses import replace

import numpy as np

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Answer, Found, certified
from masonry_opt.answer.reasons import Code, Status, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.refiner import programs
from masonry_opt.methods.exact.settings import SEARCH
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import Problem, State
from masonry_opt.solvers.driver import LpAnswer
from masonry_opt.solvers.highs import HighsSession
from masonry_opt.solvers.registry import LpSize, Verdict

_BESIDE = "associative"  #: Name of the solver's use for the load factor beside a Coulomb answer.

#: Smallest entry of the matrix that HiGHS keeps. If larger, joints askew by less contradict each other.
_SMALLEST_ENTRY = 1e-12


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
        from masonry_opt.standing.diagnosis import no_optimum

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
    """Return a Coulomb solution with the associative load factor beside it, unless it was computed before.

    The load factor is None if no answer is within the limits of an associative one.
    """
    if of.associative_ended is not None or of.associative is not None:
        return of
    task.effort.begins("associative load factor")
    with task.effort.measure("associative"):
        answer = _by_simplex(task.problem, task.effort)
        if answer is not None:
            return replace(of, associative=answer.load_factor, associative_ended=Status.OPTIMAL)
        own = Task(task.problem, kept=task.kept)
        task.effort.uses(own.solver.name, _BESIDE)
        solution = associative(own, by_chords=True).accepted()
    return replace(of, associative=solution.load_factor, associative_ended=solution.status)


def _by_simplex(problem: Problem, effort: Effort) -> Answer | None:
    """Return the associative answer of a scene in the plane from its matrices, without a modelling language.

    Return None for scenes in space, for large ones, and if the simplex method finds no answer.
    """
    if problem.layout.round or problem.joints > SEARCH.simplex_up_to:
        return None
    statics = HighsSession(programs(problem)[0], Effort(), _BESIDE, small_matrix_value=_SMALLEST_ENTRY)
    effort.uses("highs", _BESIDE)
    statics.set_costs("load_factor", np.array([-problem.live_norm]))
    if statics.solve() is not Verdict.OPTIMAL:
        return None
    # The duals of equilibrium are the velocities of the mechanism, eq. (10).
    d = -statics.multipliers()[: len(problem.dead)]
    load_factor = float(statics.values("load_factor")[0])
    answer = certified(problem, load_factor, statics.values("q"), d, problem.friction)
    return None if answer.failing(Kind.ASSOCIATIVE) else answer
