"""The iteration: an infeasible primal-dual interior point for the complementarity problem.

Predictor and centring of Mehrotra (1992), several centrality correctors of Gondzio (1996), lengths of their
own for the steps of statics and of kinematics; what changes from step to step is a
:class:`~.schedule.Schedule`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from math import isfinite

import numpy as np

from masonry_opt.methods.mcp.edge_form import EdgeForm, Iterate, Products, moved
from masonry_opt.methods.mcp.newton import Elimination, NewtonSystem, Parts, SingularError
from masonry_opt.methods.mcp.schedule import NewtonStep, Schedule

#: Second-order terms are bounded by so many times the mean product, and correctors bring products to within
#: this factor of the centre's (Gondzio: 0.1 to 10).
_NEAR_CENTRE = 10.0

#: Correctors at most; none where steps are longer than this already; and by how much one must lengthen them.
_CORRECTORS, _LONG_ENOUGH, _GAIN = 5, 0.9, 0.01

#: A corrector aims at steps longer by this factor and this much.
_AIM_FACTOR, _AIM_MORE = 1.08, 0.08

#: Share of the way to the boundary that a step goes: at least, and at most.
_LEAST_SHARE, _MOST_SHARE = 0.9, 0.9995

#: Steps of a pass at most.
_MOST_STEPS = 300

#: Error of a step's linear equations at which their refinement ends.
_ACCURATE = 1e-12

#: Projections onto kinematics at the end, and what they may leave, over the largest velocity.
_PROJECTIONS, _ON_KINEMATICS = 3, 1e-12

#: Where contacts give, residuals up to this are left as they are, over the largest velocity. (A projection
#: takes a full factorisation: seven times the program on 3 × 9 openings.)
_LEFT_IN_MOTION = 1e-10


class Outcome(StrEnum):
    """How a pass ended."""

    SOLVED = "solved"
    STALLED = "steps too short"
    STEPS = "the gap lingers"
    LOST = "grew without end"
    SINGULAR = "singular matrix"
    WEIGHTLESS = "what moves weighs nothing"


@dataclass(frozen=True)
class Pass:
    """A pass: how it ended, its last iterate, that one's gap, and the last one inside all limits."""

    outcome: Outcome
    iterate: Iterate
    gap: float
    inside: Iterate


@dataclass(frozen=True)
class _Direction:
    step: Iterate
    error: float
    lengths: tuple[float, float]


def start(form: EdgeForm) -> Iterate:
    """Least forces that carry the dead load, edges and slacks raised to the mean weight or a tenth of the
    largest force at least; no load, no motion, unit rates. Slacks of chords grow with the strength, to some
    thousand times the weights: their rates are as much smaller, or their energy would be all of the gap."""
    problem = form.problem
    forces = form.least_forces.copy()
    weight = float(problem.force_sizes(problem.dead).mean()) or 1.0
    least = max(weight, 0.1 * float(np.abs(forces).max()))
    edges = forces[: form.edges]
    np.maximum(edges, least, out=edges)
    slacks = form.cohesion + form.slacks(forces, problem.friction)
    # f_L·d is a sum over components, which depends on the axes: unit rates are those along the live load.
    live, moments = problem.force_sizes(problem.live), problem.moments(problem.live)
    along = float(live.sum() + np.abs(moments).sum())
    rate = problem.live_norm / along
    room = np.maximum(form.room(forces), least)
    return Iterate(
        0.0,
        forces,
        np.maximum(slacks, least * form.steep),
        np.zeros_like(problem.dead),
        np.full_like(edges, rate),
        rate / form.steep,
        room,
        rate * least / room,
    )


def run(
    elimination: Elimination,
    brake: float,
    follow: Callable[[NewtonStep], None],
    begun: Iterate | None = None,
    forces_alone: bool = False,
) -> Pass:
    """One pass from the start to the end or to where it is given up.

    Parameters
    ----------
    brake: see :data:`~.schedule.BRAKES`.
    follow: called with every step.
    begun: where another pass ended, to go on from as long as steps are not very short.
    forces_alone: whether the motion at the end may be left as it is, for nobody asks.
    """
    form = elimination.form
    at = inside = begun or start(form)
    schedule = Schedule(form, at, brake)

    def ended(outcome: Outcome) -> Pass:
        return Pass(outcome, at, schedule.gap(at), inside)

    for iteration in range(1, _MOST_STEPS + 1):
        began = time.perf_counter()
        step = schedule.look(at, iteration)
        if schedule.lost(step):
            follow(step)
            return ended(Outcome.LOST)
        try:
            inside = at
            if schedule.ended(step):
                if not forces_alone:
                    at = _onto_kinematics(elimination, at, schedule)
                follow(replace(step, seconds=time.perf_counter() - began))
                return ended(Outcome.SOLVED)
            at, step = _advance(elimination, at, schedule, step)
        except SingularError:
            if schedule.singular():
                return ended(Outcome.SINGULAR)
            continue
        follow(replace(step, seconds=time.perf_counter() - began))
        if schedule.stalls(min(step.forces, step.velocities), at_once=begun is not None):
            return ended(Outcome.STALLED)
        if schedule.lingers(step):
            return ended(Outcome.STEPS)
    return ended(Outcome.STEPS)


def _advance(
    elimination: Elimination, at: Iterate, schedule: Schedule, step: NewtonStep
) -> tuple[Iterate, NewtonStep]:
    """Predict, centre, correct, and go."""
    system = NewtonSystem(elimination, at, schedule.friction, schedule.diagonal, _ACCURATE)
    products = at.products
    predictor = _direction(system, at, schedule, Products(*(-own for own in products)))
    predicted = moved(at, predictor.lengths, predictor.step).energy
    sigma = schedule.centre(at, predicted, step.gap)
    mean = at.energy / sum(own.size for own in products)
    centre, most = sigma * mean, _NEAR_CENTRE * mean
    second_order = predictor.step.products
    aims = Products(
        *(
            centre - own - np.clip(second, -most, most)
            for own, second in zip(products, second_order, strict=True)
        )
    )
    direction = _direction(system, at, schedule, aims)
    direction = _corrected(system, at, schedule, aims, direction, centre)
    if not isfinite(direction.error):
        raise SingularError("no finite solution")
    share = min(max(_LEAST_SHARE, 1 - step.gap), _MOST_SHARE)
    forces, motion = (1.0 if length == 1 else share * length for length in direction.lengths)
    if step.gap < schedule.alike_below:
        forces = motion = min(forces, motion)
    record = replace(
        step, centring=sigma, forces=forces, velocities=motion, error=direction.error, full=system.full
    )
    return moved(at, (forces, motion), direction.step), record


def _corrected(
    system: NewtonSystem,
    at: Iterate,
    schedule: Schedule,
    aims: Products,
    direction: _Direction,
    centre: float,
) -> _Direction:
    """Gondzio's correctors: bring the products of a longer step back to the centre's neighbourhood."""
    low, high = centre / _NEAR_CENTRE, _NEAR_CENTRE * centre
    for _ in range(_CORRECTORS):
        if min(direction.lengths) > _LONG_ENOUGH:
            break
        forces, rates = (min(1.0, _AIM_FACTOR * length + _AIM_MORE) for length in direction.lengths)
        reached = moved(at, (forces, rates), direction.step).products
        aims = Products(*(aim + _back(own, low, high) for aim, own in zip(aims, reached, strict=True)))
        candidate = _direction(system, at, schedule, aims)
        gained = min(candidate.lengths) >= min(direction.lengths) + _GAIN
        if not gained or sum(candidate.lengths) < sum(direction.lengths):
            break
        direction = candidate
    return direction


def _back(products: np.ndarray, low: float, high: float) -> np.ndarray:
    """What brings products between two bounds; those above by no more than the upper one."""
    return np.maximum(np.clip(products, low, high) - products, -high)


def _direction(system: NewtonSystem, at: Iterate, schedule: Schedule, by: Products) -> _Direction:
    """The step that makes the residuals vanish and changes the products so."""
    left, form = schedule.residuals, schedule.form
    motion, edges = -left.motion, slice(form.edges)
    motion[edges] += by.edges / at.x[edges] + form.crushes(
        (by.crushing + at.crushed * left.crushing) / at.room
    )
    sliding = by.sliding + at.slip * left.yielding
    solution, error = system.solve(Parts(-left.statics, sliding, motion, -left.work))
    room = form.chords(solution.joints) - left.crushing
    step = Iterate(
        solution.load,
        solution.joints,
        form.slacks(solution.joints, schedule.friction) - left.yielding,
        solution.blocks,
        (by.edges - at.opening * solution.joints[edges]) / at.x[edges],
        solution.sliding,
        room,
        (by.crushing - at.crushed * room) / at.room,
    )
    forces = _to_boundary((at.x[edges], at.z, at.room), (step.x[edges], step.z, step.room))
    rates = _to_boundary((at.opening, at.slip, at.crushed), (step.opening, step.slip, step.crushed))
    return _Direction(step, error, (forces, rates))


def _to_boundary(values: tuple[np.ndarray, ...], steps: tuple[np.ndarray, ...]) -> float:
    """The longest step up to one that keeps all values ≥ 0."""
    fastest = max(float((-step / value).max(initial=0.0)) for value, step in zip(values, steps, strict=True))
    # Never exactly onto the boundary: the next step divides by forces, slacks and rates.
    return min(1 / fastest, 1 - 1e-12) if fastest > 1 - 1e-12 else 1.0


def _onto_kinematics(elimination: Elimination, at: Iterate, schedule: Schedule) -> Iterate:
    """The nearest motion that follows the flow rule, rates weighted by p/z: large where faces move, next to
    nothing where they stand still. The same equations as a step's, with the flow rule's slope in both."""
    form = elimination.form
    nothing = np.zeros_like(schedule.residuals.statics)
    slope, diagonal = form.problem.dilatancy, schedule.diagonal
    system = NewtonSystem(elimination, at, slope, diagonal, _ON_KINEMATICS, full=True, rigid=True)
    moves, most = at, _LEFT_IN_MOTION if form.compliance.any() else _ON_KINEMATICS
    for _ in range(_PROJECTIONS):
        left = form.residuals(moves)
        if np.abs(left.motion).max() <= most * max(float(np.abs(moves.d).max()), 1.0):
            break
        solution, _ = system.solve(Parts(nothing, np.zeros_like(at.slip), -left.motion, -left.work))
        step = Iterate(
            0.0,
            np.zeros_like(at.x),
            np.zeros_like(at.z),
            solution.blocks,
            -at.opening * solution.joints[: form.edges] / at.x[: form.edges],
            solution.sliding,
            np.zeros_like(at.room),
            -at.crushed * form.chords(solution.joints) / at.room,
        )
        moves = moved(moves, (0.0, 1.0), step)
    return moves
