"""Methods "static" and "kinematic": associative limit analysis by one program, eq. (9) or eq. (10).

The program is linear in the plane, unless joints can crush.
"""

from dataclasses import replace

import numpy as np

from masonry_opt.effort import Effort
from masonry_opt.methods.exact.refiner import last_refiner_of, programs
from masonry_opt.methods.exact.settings import SEARCH
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import Problem, State
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import Answer, FinalState, certified
from masonry_opt.solution.reasons import Code, Status, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solvers.driver import LpAnswer
from masonry_opt.solvers.highs import SMALLEST_COEFFICIENT, HighsSession
from masonry_opt.solvers.registry import LpSize, Verdict

#: Key of ``result.solvers`` under which a Coulomb result lists the solver of the associative load factor.
_ASSOCIATIVE_PURPOSE = "associative"


def associative(task: Task, formulation: str = "static", by_chords: bool = False) -> Solution:
    """Return the load factor, the forces and the mechanism under associative flow.

    If the solver ends without a certified optimum, the dual formulation is solved too.

    Parameters
    ----------
    task : Task
        Problem and solver.
    formulation : str
        "static" for eq. (9), or "kinematic" for eq. (10).
    by_chords : bool
        If True, crushing is limited by chords, as in every Coulomb answer. If False, it is limited by the
        parabola if the solver accepts one.
    """
    problem = task.problem
    if task.solver.entry.conic:
        problem = problem.by_cone if by_chords else problem.by_cone.by_parabola
    answer, state, size = _solved(task, problem, formulation)
    if _is_short(answer, state):
        dual = "kinematic" if formulation == "static" else "static"
        dual_answer, dual_state, _ = _solved(task, problem, dual)
        if not _is_short(dual_answer, dual_state):
            answer, state = dual_answer, dual_state
    solution = Solution(Status.OPTIMAL, Kind.ASSOCIATIVE, size=size, solver=task.solver)
    word = answer.solved.status
    if state is None:
        # The import is local because it takes seconds and few analyses need it.
        from masonry_opt.stability.diagnosis import no_optimum

        status, why = no_optimum(task.problem, word, task.solver, task.effort)
        return replace(solution, status=status, reasons=(why,), state=FinalState(forms=problem.forms))
    reasons = (reason(Code.STOPPED_SHORT, word=word),) if answer.solved.failed else ()
    return replace(solution, reasons=reasons, state=state)


def _solved(task: Task, problem: Problem, formulation: str) -> tuple[LpAnswer, Answer | None, LpSize]:
    """Return the answer of the solver, the state with its certificate, and the size of the program.

    The size consists of the numbers of rows, columns and nonzeros. The state is None if the solver returns no
    point.
    """

    def with_certificate(state: State | None) -> Answer | None:
        """Return a state with its certificate for associative flow, or None if there is no state."""
        return certified(problem, state.load_factor, state.q, state.d, problem.friction) if state else None

    how = {"of_load": True, "repeats": task.cache.keeps}
    driver = task.cache.driver(problem, formulation, task.solver, task.effort, **how)
    # Accept a nearly optimal point, because its certificate later shows whether the point is accurate enough.
    answer = driver.solve(nearly=True)
    state = with_certificate(answer.state)
    if problem.by_strength.conic and state and (answer.solved.failed or _is_short(answer, state)):
        # Solve again for more accuracy. The constraints that limit crushing are now scaled by the normal
        # forces of the first solution.
        second_answer = driver.solve(nearly=True, near=state.q)
        if second_answer.state is not None:
            answer, state = second_answer, with_certificate(second_answer.state)
    return answer, state, driver.size()


def _is_short(answer: LpAnswer, state: Answer | None) -> bool:
    """Return True if the solver failed, or if the residuals of its state are too large."""
    return bool(state.failing(Kind.ASSOCIATIVE)) if state else answer.solved.failed


def kinematic(task: Task) -> Solution:
    """Solve the kinematic formulation of associative flow, eq. (10)."""
    return associative(task, "kinematic")


def with_associative(task: Task, of: Solution) -> Solution:
    """Add the associative load factor to a Coulomb solution if it is missing.

    The associative load factor is None if no answer has residuals small enough to be accepted.
    """
    if of.associative_ended is not None or of.associative is not None:
        return of
    task.effort.begins("associative load factor")
    with task.effort.measure("associative"):
        answer = _by_simplex(task)
        if answer is not None:
            return replace(of, associative=answer.load_factor, associative_ended=Status.OPTIMAL)
        own = Task(task.problem, cache=task.cache)
        task.effort.uses(own.solver.name, _ASSOCIATIVE_PURPOSE)
        solution = associative(own, by_chords=True).accepted()
    return replace(of, associative=solution.load_factor, associative_ended=solution.status)


def _by_simplex(task: Task) -> Answer | None:
    """Solve a plane scene with associative flow by the simplex method.

    The program is built from the matrices, without a modelling language. If exact states of the same problem
    were looked for before, the simplex method starts from the last forces of this search. None is returned
    for scenes in space, for large scenes, and if the simplex method finds no answer.
    """
    problem = task.problem
    if problem.layout.round or problem.joints > SEARCH.simplex_up_to:
        return None
    refiner = last_refiner_of(task)
    program = programs(problem)[0] if refiner is None else refiner.statics.lp
    statics = HighsSession(program, Effort(), _ASSOCIATIVE_PURPOSE, small_matrix_value=SMALLEST_COEFFICIENT)
    if refiner is not None:
        statics.start_from(refiner.statics)
    task.effort.uses("highs", _ASSOCIATIVE_PURPOSE)
    statics.set_costs("load_factor", np.array([-problem.live_norm]))
    if statics.solve() is not Verdict.OPTIMAL:
        return None
    # Up to their sign, the dual variables of equilibrium are the velocities of the mechanism, eq. (10).
    d = -statics.multipliers()[: len(problem.dead)]
    load_factor = float(statics.values("load_factor")[0])
    answer = certified(problem, load_factor, statics.values("q"), d, problem.friction)
    return None if answer.failing(Kind.ASSOCIATIVE) else answer
