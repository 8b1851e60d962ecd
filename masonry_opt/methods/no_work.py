"""Collapse in which the live load does no work, such as that of a block which the dead load pushes aside once
the live load has lifted enough of it.

Mechanisms are scaled by f_L·d = Σ|f_L|: with f_L·d ≤ 0 no method has one. But the loads at λ₀ are the same if
a share σ of the dead load grows with the live load,

    λ f_L + f_D = λ (f_L + σ f_D / λ₀) + (1 - σ) f_D    where λ = λ₀,

and mechanisms are then scaled by work that the dead load does. What a method finds at λ₀ itself is a state of
the scene as it is. At another λ the loads are s = 1 + σ (λ / λ₀ - 1) times those at λ / s, and where friction
alone limits forces, so is the state.

The lowest values of limited forces (active pressure of a fill, prestress of a tie) count as dead load here.
They may be all that drives the mechanism, as where a fill pushes aside a stack that the live load lifts.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from math import inf, isfinite, nan
from typing import Any

import numpy as np

from masonry_opt.answer.acceptance import LIMITS
from masonry_opt.answer.answer import Answer
from masonry_opt.answer.only_state import is_only_load_factor
from masonry_opt.answer.reasons import LOAD_FACTORS, Code, Status, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import APART, ZERO
from masonry_opt.methods.associative import associative
from masonry_opt.methods.exact.alternation import ExactPrograms
from masonry_opt.methods.task import Task
from masonry_opt.problem.problem import Problem, in_units_of_load
from masonry_opt.solvers.driver import Kept
from masonry_opt.solvers.registry import find_solver

#: Work of the live load and energy z·p, over the work of the dead load, up to which they are rounding. (The
#: loop's sliding contracts by 10⁻³ μ.)
_ROUNDING = 1e-3

#: σ in turn, where the mechanism does not move against the live load. With a half the loop fails on 11 of 67
#: random scenes, passes on none with a tenth; on two blocks in space it fails with three quarters and more.
_SHARES = 0.75, 0.5

_MOST = 8  #: λ₀ tried at most; the first, the associative load factor, is most often the answer.

#: Names of the fields in a method's step records that hold load factors.
_LOAD_FACTORS_OF_STEPS = ("load_factor", "bound")

#: Reasons that hold only for the loads under which they were found, and so not for the scene itself.
_OF_OTHER_LOADS = frozenset(
    {
        *(Code.PROVEN, Code.WITHIN_IMPOSED, Code.TOUCHES_IMPOSED),
        *(Code.OUT_OF_TIME, Code.OUT_OF_TIME_WITHIN_IMPOSED),
        *(Code.RAY, Code.LEVEL, Code.CURVE),
    }
)


def without_work(task: Task, run: Callable[[Task], Solution], before: Solution | None) -> Solution | None:
    """Return the solution of a method where the live load does no work, or None.

    None is returned if the associative forces go with no mechanism of that kind. ``before`` is the method's
    solution, without a load factor, of the scene as it is, if the method was run.
    """
    scene = task.problem
    task = replace(task, problem=scene.with_lowest_forces_as_load)
    given = _associative_and_work(task)
    if given is None:
        return None
    upper, work = given
    shares = (share + (1 - share) * max(-work, 0.0) for share in _SHARES)
    tried = (_growing(task, run, upper, share) for share in shares)
    found = next((one for one in tried if one is not None), None)
    if found is None or found.answer is None:
        return None
    found = replace(found, found=replace(found.answer, q=found.answer.q + scene.lowest_forces))
    if before is None or before.curve is None:
        return found
    of_curve = (said for said in before.reasons if said.code is Code.CURVE)
    return replace(found, curve=before.curve).telling(*of_curve)


def _growing(task: Task, run: Callable[[Task], Solution], upper: float, share: float) -> Solution | None:
    """The same with a share of the dead load growing, from the associative load factor on."""
    problem = task.problem
    alike = not problem.face_cohesion.any() and not problem.dilatancy_depends_on_stress
    load_factor, last = upper, (0.0, 0.0)
    for _ in range(_MOST):
        at = load_factor
        growing, rest = problem.live + share / at * problem.dead, (1 - share) * problem.dead
        moved = replace(problem, live=growing, dead=rest)
        solution = run(replace(task, problem=moved, kept=Kept(), expected=None)).accepted()
        answer = solution.answer
        if answer is None:
            return None
        size, work = _size(answer.load_factor, at, share), _live_work(problem, answer.load_factor, answer.d)
        # On one mechanism loads at yield lie on a line, through zero where friction alone limits forces.
        slope = (answer.load_factor - last[1]) / (size - last[0] or ZERO)
        load_factor, last = answer.load_factor + (1 - size) * slope, (size, answer.load_factor)
        if min(size, load_factor) <= ZERO or work > _ROUNDING:
            return None
        if alike or abs(size - 1) <= LIMITS[solution.kind].equilibrium:
            # Residuals are shares of loads and velocities, whatever their size.
            d = answer.d * problem.live_norm / float(problem.dead @ answer.d)
            found = replace(answer, load_factor=load_factor, q=answer.q / size, d=d)
            solution = _as_of_scene(solution, found, alike, at, share)
            solution = replace(solution, associative=upper, associative_ended=Status.OPTIMAL)
            is_only = is_only_load_factor(problem, load_factor)
            return solution.telling_first(reason(Code.NO_WORK, fixed=is_only, against=work < -APART))
    return None


def _associative_and_work(task: Task) -> tuple[float, float] | None:
    """The associative load factor, and the live load's work there over the dead load's in a mechanism of the
    joints' own flow rule that goes with its forces, if the dead load drives one without work."""
    problem = task.problem.by_cone
    upper = associative(Task(task.problem, kept=task.kept), by_chords=True)
    answer = upper.accepted().answer
    if answer is None or answer.load_factor <= ZERO or not problem.dead.any():
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
    if max(energy / float(problem.dead @ d), work) > _ROUNDING:
        return None
    return answer.load_factor, work


def _size(load_factor: float, at: float, share: float) -> float:
    """s: the loads over those of the scene at λ / s."""
    return 1 + share * (load_factor / at - 1)


def _live_work(problem: Problem, load_factor: float, d: np.ndarray) -> float:
    """Work of the live load at a load factor in a motion (3b,), over the size of that of the dead load."""
    return load_factor * float(problem.live @ d) / abs(float(problem.dead @ d))


def _as_of_scene(solution: Solution, found: Answer, alike: bool, at: float, share: float) -> Solution:
    """Return a solution with the scene's answer, and with its load factors λ turned into those of the scene.

    Under loads s times those of the scene a load factor becomes λ / s, NaN where the loads have vanished.
    ``alike`` is True if states under loads of another size are states of the scene; else reasons with load
    factors are left out. Proofs and load histories do not carry over.
    """

    def of_scene(values: Mapping[str, Any], names: Iterable[str]) -> dict[str, float]:
        given = {name: values[name] for name in names if values.get(name) is not None}
        sizes = {name: _size(value, at, share) for name, value in given.items()}
        return {name: given[name] / size if size > ZERO else nan for name, size in sizes.items()}

    reasons = []
    for said in solution.reasons:
        values = of_scene(said.values, LOAD_FACTORS.get(said.code, ()))
        if said.code not in _OF_OTHER_LOADS and all(alike and value >= 0 for value in values.values()):
            reasons.append(reason(said.code, **said.values | values))
    history = tuple(
        replace(step, **of_scene(vars(step), _LOAD_FACTORS_OF_STEPS)) for step in solution.history
    )
    solution = replace(solution, bound=None, bound_derived=False, history=history)
    below_zero = inf
    if any(said.code is Code.BELOW_ZERO for said in reasons):
        value = of_scene(vars(solution), ("below_zero",))["below_zero"]
        below_zero = value if isfinite(value) else inf
    solution = replace(solution, below_zero=below_zero, followed_to_end=False, peak=None)
    return replace(solution, status=Status.CONVERGED, reasons=tuple(reasons), found=found)
