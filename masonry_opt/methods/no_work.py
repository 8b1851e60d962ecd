"""Find collapse states in which the live load does no work.

An example is a block that the dead load pushes aside once the live load has lifted enough of it.

All methods scale mechanisms by f_L·d = Σ|f_L|, and so find none with f_L·d ≤ 0. The loads at λ₀ are however
equal if a fraction σ of the dead load grows with the live load:

    λ f_L + f_D = λ (f_L + σ f_D / λ₀) + (1 - σ) f_D    for λ = λ₀

Mechanisms are then scaled by the work of the dead load too. A state that a method finds at λ₀ itself is a
state of the scene. At another λ the loads are s = 1 + σ (λ / λ₀ - 1) times the loads at λ / s. If only
friction limits forces, then the forces are s times those of a state at λ / s.

The lowest values of limited forces (active pressure of a fill, prestress of a tie) count as dead load here.
They alone may drive the mechanism, for example if a fill pushes aside a stack that the live load lifts.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from math import inf, isfinite, nan
from typing import Any

import numpy as np

from masonry_opt.methods.associative import associative
from masonry_opt.methods.exact.alternation import ExactPrograms
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import Problem, in_units_of_load
from masonry_opt.solution.acceptance import LIMITS, Kind
from masonry_opt.solution.answer import Answer
from masonry_opt.solution.only_state import is_only_load_factor
from masonry_opt.solution.reasons import LOAD_FACTORS, Code, Status, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.thresholds import LEAST_OPPOSING_WORK
from masonry_opt.solvers.driver import ProgramCache
from masonry_opt.solvers.registry import find_solver

#: The work of the live load, and the energy z·p (slacks times rates of the yield conditions), count as zero
#: below this fraction of the dead load's work. In the mechanisms of the loop of linear programs, z·p is of
#: this size instead of zero, because a sliding joint closes by 10⁻³ μ when it slips by 1.
_NEGLIGIBLE_WORK = 1e-3

#: Fractions σ of the dead load that grow in proportion to the live load, in the order in which they are
#: tried. If the live load does negative work, the fractions are increased, so that the growing loads together
#: do positive work. With smaller fractions the loop of linear programs fails more often: with 0.5 on 11 of 67
#: random scenes, with 0.1 on all scenes. The smaller fraction is tried too, because with 0.75 or more the
#: loop fails on a scene in space with two blocks.
_DEAD_LOAD_SHARES = 0.75, 0.5

#: Largest number of estimates of the load factor in the search for a collapse without work of the live load.
#: After this number the search ends without an answer. Usually the first estimate, the associative load
#: factor, is the answer.
_MOST_LOAD_FACTORS = 8

#: If the modified loads are at most this fraction of the scene's loads, they count as zero.
_LEAST_SIZE = 1e-6

#: Fields of a method's step records that contain load factors. These load factors are converted, so that they
#: refer to the loads of the scene.
_LOAD_FACTORS_OF_STEPS = ("load_factor", "bound")

#: Codes of reasons that are valid only for the modified loads of this module. Reasons with these codes are
#: not copied to the solution for the loads of the scene.
_OF_OTHER_LOADS = frozenset(
    {
        *(Code.PROVEN, Code.WITHIN_IMPOSED, Code.TOUCHES_IMPOSED),
        *(Code.OUT_OF_TIME, Code.OUT_OF_TIME_WITHIN_IMPOSED),
        *(Code.COLLAPSE, Code.RANGE, Code.CURVE),
    }
)


def without_work(task: Task, run: Callable[[Task], Solution], before: Solution | None) -> Solution | None:
    """Return the solution of a collapse in which the live load does no work.

    The result is None if the associative forces permit no mechanism without work of the live load, or if the
    method finds no solution. ``before`` is the method's solution of the unchanged scene, without a load
    factor; it is None if the method was not run.
    """
    scene = task.problem
    task = replace(task, problem=scene.with_lowest_forces_as_load)
    load_factor_and_work = _associative_and_work(task)
    if load_factor_and_work is None:
        return None
    upper, work = load_factor_and_work
    shares = (share + (1 - share) * max(-work, 0.0) for share in _DEAD_LOAD_SHARES)
    solutions = (_growing(task, run, upper, share) for share in shares)
    solution = next((solution for solution in solutions if solution is not None), None)
    if solution is None or solution.answer is None:
        return None
    answer = replace(solution.answer, q=solution.answer.q + scene.lowest_forces)
    solution = replace(solution, state=answer)
    if solution.kind is not Kind.INCREMENTAL:
        return solution
    if before is None:
        return replace(solution, history=(), tells_curve=False)
    # Keep the load history of ``before`` and the reasons that describe its curve. The history was computed
    # under the original loads of the scene.
    of_curve = (entry for entry in before.reasons if entry.code is Code.CURVE)
    return replace(solution, history=before.history, tells_curve=before.tells_curve).telling(*of_curve)


def _growing(task: Task, run: Callable[[Task], Solution], upper: float, share: float) -> Solution | None:
    """Solve the scene under modified loads, in which a fraction of the dead load grows with the live load.

    The modified loads equal the loads of the scene at an estimate λ₀ of the load factor. The first estimate
    is the associative load factor ``upper``. Further estimates are extrapolated, until the load factor of the
    modified loads equals its estimate. None is returned if the method finds no answer, if the live load does
    work, or if the load factor falls to zero.
    """
    problem = task.problem
    alike = not problem.face_cohesion.any() and not problem.dilatancy_depends_on_stress
    load_factor, last = upper, (0.0, 0.0)
    for _ in range(_MOST_LOAD_FACTORS):
        at = load_factor
        growing, constant = problem.live + share / at * problem.dead, (1 - share) * problem.dead
        moved = replace(problem, live=growing, dead=constant)
        solution = run(replace(task, problem=moved, cache=ProgramCache(), incremental=None)).accepted()
        answer = solution.answer
        if answer is None:
            return None
        size, work = _size(answer.load_factor, at, share), _live_work(problem, answer.load_factor, answer.d)
        # The size is the ratio of the modified loads to the loads of the scene; both are equal at size 1.
        # Extrapolate λ linearly to size 1, which gives the next estimate λ₀. For a given mechanism, λ is a
        # linear function of the size. The first extrapolation starts from λ = 0 at size 0.
        slope = (answer.load_factor - last[1]) / (size - last[0] or _LEAST_SIZE)
        load_factor, last = answer.load_factor + (1 - size) * slope, (size, answer.load_factor)
        if size <= _LEAST_SIZE or load_factor <= problem.load_factor_scale.zero or work > _NEGLIGIBLE_WORK:
            return None
        if alike or abs(size - 1) <= LIMITS[solution.kind].equilibrium:
            # Scale the forces and velocities to the loads of the scene. The certificate remains valid,
            # because its residuals are relative.
            d = answer.d * problem.live_norm / float(problem.dead @ answer.d)
            scaled = replace(answer, load_factor=load_factor, q=answer.q / size, d=d)
            solution = _as_of_scene(solution, scaled, alike, at, share)
            solution = replace(solution, associative=upper, associative_ended=Status.OPTIMAL)
            is_only = is_only_load_factor(problem, load_factor)
            return solution.telling_first(
                reason(Code.NO_WORK, fixed=is_only, against=work < -LEAST_OPPOSING_WORK)
            )
    return None


def _associative_and_work(task: Task) -> tuple[float, float] | None:
    """Return the associative load factor, and the ratio of the live load's work to the dead load's work.

    The work is done in a mechanism that the dead load drives. The mechanism obeys the joints' own flow rule
    and is complementary to the associative forces. None is returned if this mechanism does not exist, or if
    the live load does positive work in it.
    """
    problem = task.problem.by_cone
    upper = associative(Task(task.problem, cache=task.cache), by_chords=True)
    answer = upper.accepted().answer
    if answer is None or answer.load_factor <= problem.load_factor_scale.zero or not problem.dead.any():
        return None
    driven, solver = in_units_of_load(replace(problem, live=problem.dead)), find_solver("cvxpy", None)
    nearly, purpose = problem.by_friction.conic, "mechanism without work"
    programs = ExactPrograms(driven, [solver], task.effort, purpose, nearly)
    d = programs.motion(answer.q / driven.force)
    if d is None:
        return None
    slope = problem.dilatancy_at(problem.normal_forces(answer.q))
    energy = problem.energy(answer.q, problem.rates(d, slope))
    work = _live_work(problem, answer.load_factor, d)
    if max(energy / float(problem.dead @ d), work) > _NEGLIGIBLE_WORK:
        return None
    return answer.load_factor, work


def _size(load_factor: float, at: float, share: float) -> float:
    """Return the ratio s of the modified loads to the loads of the scene.

    The modified loads at λ are s times the loads of the scene at λ / s. The ratio s is 1 at λ = ``at``.
    ``share`` is the fraction of the dead load that grows with the live load.
    """
    return 1 + share * (load_factor / at - 1)


def _live_work(problem: Problem, load_factor: float, d: np.ndarray) -> float:
    """Return the ratio of the live load's work to the dead load's work, in a motion d of shape (3b,).

    The live load is multiplied by the load factor. The absolute value of the dead load's work is used.
    """
    return load_factor * float(problem.live @ d) / abs(float(problem.dead @ d))


def _as_of_scene(solution: Solution, answer: Answer, alike: bool, at: float, share: float) -> Solution:
    """Return the solution for the scene's loads that corresponds to a solution for modified loads.

    If the modified loads are s times those of the scene, a load factor λ becomes λ / s, or NaN if the loads
    vanish. ``alike`` is True if a state remains valid when loads and forces are scaled. If it is False,
    reasons that contain load factors are omitted. Proofs, notes of the log, and reasons that describe a load
    history are always omitted.
    """

    def of_scene(values: Mapping[str, Any], names: Iterable[str]) -> dict[str, Any]:
        """Convert load factors from the modified loads to the loads of the scene.

        ``names`` are the keys of the load factors in ``values``. Missing values and None are left out.
        """
        load_factors = {name: values[name] for name in names if values.get(name) is not None}
        sizes = {name: _size(value, at, share) for name, value in load_factors.items()}
        return {
            name: load_factors[name] / size if size > _LEAST_SIZE else nan for name, size in sizes.items()
        }

    reasons = []
    for entry in solution.reasons:
        values = of_scene(entry.values, LOAD_FACTORS.get(entry.code, ()))
        if entry.code not in _OF_OTHER_LOADS and all(alike and value >= 0 for value in values.values()):
            reasons.append(reason(entry.code, **entry.values | values))
    history = tuple(
        replace(step, **of_scene(vars(step), _LOAD_FACTORS_OF_STEPS)) for step in solution.history
    )
    # Omit notes, such as "proven by 3 conflicts", because they are valid only for the modified loads.
    log = tuple(replace(step, note="", **of_scene(vars(step), ["load_factor"])) for step in solution.log)
    solution = replace(solution, bound=None, bound_derived=False, proof=None, history=history, log=log)
    below_zero = inf
    if any(entry.code is Code.BELOW_ZERO for entry in reasons):
        value = of_scene(vars(solution), ("below_zero",))["below_zero"]
        below_zero = value if isfinite(value) else inf
    solution = replace(solution, below_zero=below_zero, followed_to_end=False, peak=None)
    return replace(solution, status=Status.CONVERGED, reasons=tuple(reasons), state=answer)
