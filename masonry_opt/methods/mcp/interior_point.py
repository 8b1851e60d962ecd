"""The iteration: an infeasible primal-dual interior point for the complementarity problem.

Predictor and centring of Mehrotra (1992), several centrality correctors of Gondzio (1996), lengths of their
own for the steps of statics and of kinematics. What makes it find Coulomb states: sliding contracts a little,
and less and less (as between the programs of the loop, section 4.2), and while the gap is large the matrix
stands between Newton's and that of an associative program (see :class:`~.rules.Rules`).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from math import inf, isfinite, sqrt

import numpy as np

from masonry_opt.methods.mcp.edge_form import EdgeForm, Iterate, IterateResiduals, Products, moved
from masonry_opt.methods.mcp.newton import Elimination, NewtonSystem, Parts, SingularError
from masonry_opt.methods.mcp.rules import (
    GAP,
    HIGHEST_AT_FIRST,
    KINEMATICS,
    LONG,
    LOST_GAP,
    LOST_GROWTH,
    LOST_LOAD,
    MOST_STEPS,
    NEWTON_BELOW,
    OVERSHOOT,
    RUNGS,
    SHORT,
    SHORTEST,
    STATICS,
    Rules,
)

#: Second-order terms are bounded by so many times the mean product, and correctors bring products to within
#: this factor of the centre's (Gondzio: 0.1 to 10).
_NEAR_CENTRE = 10.0

#: Correctors at most; none where steps are longer than this already; and by how much one must lengthen them.
_CORRECTORS, _LONG_ENOUGH, _GAIN = 5, 0.9, 0.01

#: A corrector aims at steps longer by this factor and this much.
_AIM_FACTOR, _AIM_MORE = 1.08, 0.08

#: Share of the way to the boundary that a step goes: at least, and at most.
_LEAST_SHARE, _MOST_SHARE = 0.9, 0.9995

#: On the matrix's diagonal: at least, at most, and the factors on it after a short and after a long step.
_LEAST_DIAGONAL, _MOST_DIAGONAL, _MORE, _LESS = 1e-10, 1e-4, 100.0, 0.1

#: The gap is measured at this λ at least.
_LEAST_LOAD = 1e-3

#: Projections onto kinematics at the end, and what they may leave, over the largest velocity.
_PROJECTIONS, _ON_KINEMATICS = 3, 1e-12

#: Where contacts give, residuals up to this are left as they are, over the largest velocity; and steps of
#: statics and of kinematics are as long as each other below this gap, or what forces move contacts by would
#: be left over. (A projection takes a full factorisation: seven times the program on 3 × 9 openings.)
_LEFT_IN_MOTION, _ALIKE_BELOW = 1e-10, 1e-6


@dataclass(frozen=True)
class NewtonStep:
    """One step of a pass, as it began.

    Attributes
    ----------
    iteration: counted from 1 in each attempt; a number is missing where the matrix had no factors and the
        step was tried again.
    load_factor: λ.
    gap: energy z·p of all faces, over the live load's work at |λ| (at 1e-3 at least).
    statics, yielding, motion: largest residuals: of equilibrium over the largest dead load (one at least), of
        slacks in the same units, and of the flow rule over the largest velocity (one at least).
    contraction: α.
    blend: θ.
    centring: σ, the share of the gap that is aimed at; NaN where the pass ended.
    forces, velocities: lengths of the step in statics and in kinematics.
    error: of the solution of the linear equations.
    full: whether they took a full factorisation.
    seconds: the step's time.
    attempt: which set of rules it belongs to.
    """

    iteration: int
    load_factor: float
    gap: float
    statics: float
    yielding: float
    motion: float
    contraction: float
    blend: float
    centring: float = np.nan
    forces: float = np.nan
    velocities: float = np.nan
    error: float = np.nan
    full: bool = False
    seconds: float = 0.0
    attempt: int = 1


class Outcome(StrEnum):
    """How a pass ended."""

    SOLVED = "solved"
    STALLED = "steps too short"
    STEPS = "the gap lingers"
    LOST = "grew without end"
    SINGULAR = "singular matrix"


@dataclass(frozen=True)
class Pass:
    """A pass: how it ended, its last iterate, and that one's gap."""

    outcome: Outcome
    iterate: Iterate
    gap: float


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
    forces[:2] = np.maximum(forces[:2], least)
    slacks = problem.cohesion + form.slacks(forces, problem.friction)
    # f_L·d is a sum over components, which depends on the axes: unit rates are those along the live load.
    live, moments = problem.force_sizes(problem.live), problem.moments(problem.live)
    along = float(live.sum() + np.abs(moments).sum())
    rate = problem.live_norm / along
    room = np.maximum(form.room(forces), least)
    return Iterate(
        0.0,
        forces,
        np.maximum(slacks, least),
        np.zeros_like(problem.dead),
        np.full_like(forces[:2], rate),
        np.full_like(slacks, rate),
        room,
        rate * least / room,
    )


def run(elimination: Elimination, rules: Rules, follow: Callable[[NewtonStep], None]) -> Pass:
    """One pass from the start to the end or to where it is given up.

    Parameters
    ----------
    follow: called with every step.
    """
    form = elimination.form
    at, schedule = start(form), _Schedule(form, rules)
    most = max(LOST_GAP, LOST_GROWTH * _gap(form, at))

    def ended(outcome: Outcome) -> Pass:
        return Pass(outcome, at, _gap(form, at))

    for iteration in range(1, MOST_STEPS + 1):
        began = time.perf_counter()
        step = schedule.look(at, iteration)
        if not isfinite(step.gap) or step.gap > most or schedule.lost(at):
            follow(step)
            return ended(Outcome.LOST)
        try:
            if schedule.ended(step):
                at = _onto_kinematics(elimination, at, schedule)
                follow(replace(step, seconds=time.perf_counter() - began))
                return ended(Outcome.SOLVED)
            at, step = _advance(elimination, at, schedule, step)
        except SingularError:
            if schedule.diagonal >= _MOST_DIAGONAL:
                return ended(Outcome.SINGULAR)
            schedule.diagonal = min(_MORE * schedule.diagonal, _MOST_DIAGONAL)
            continue
        follow(replace(step, seconds=time.perf_counter() - began))
        if schedule.learn(min(step.forces, step.velocities)) >= rules.most_short_steps:
            return ended(Outcome.STALLED)
        if schedule.lingers(step):
            return ended(Outcome.STEPS)
    return ended(Outcome.STEPS)


def _gap(form: EdgeForm, at: Iterate) -> float:
    return at.energy / (form.problem.live_norm * max(abs(at.load_factor), _LEAST_LOAD))


class _Schedule:
    """What changes from step to step: contraction, blend, diagonal.

    Attributes
    ----------
    slope, friction: of the flow rule, and of the shear limits in the matrix, shape (k,).
    residuals: of the iterate looked at.
    """

    def __init__(self, form: EdgeForm, rules: Rules) -> None:
        self.form, self.rules, problem = form, rules, form.problem
        self.diagonal, self._rung, self._short = _LEAST_DIAGONAL, 0, 0
        self._contraction = inf
        self._halved = (0, inf)
        self._turns = problem.dilatancy < problem.friction
        self._largest = max(float(np.abs(problem.dead).max()), 1.0)
        self._most_load = LOST_LOAD * max(float(np.abs(problem.dead).sum()), 1.0) / problem.live_norm
        self.slope = self.friction = problem.dilatancy
        self.residuals: IterateResiduals

    def look(self, at: Iterate, iteration: int) -> NewtonStep:
        """Set slopes by the gap, and record what the iterate leaves."""
        problem, gap = self.form.problem, _gap(self.form, at)
        alpha, theta = self._contracts(gap), self._blends(gap)
        self.slope = problem.dilatancy - np.where(self._turns, alpha * problem.friction, 0.0)
        self.friction = theta * problem.friction + (1 - theta) * self.slope
        left = self.residuals = self.form.residuals(at, self.slope)
        return NewtonStep(
            iteration,
            at.load_factor,
            gap,
            float(np.abs(left.statics).max()) / self._largest,
            max(float(np.abs(of).max(initial=0.0)) for of in (left.yielding, left.crushing)) / self._largest,
            float(np.abs(left.motion).max()) / max(float(np.abs(at.d).max()), 1.0),
            alpha,
            theta,
        )

    def _contracts(self, gap: float) -> float:
        rules = self.rules
        if not self._turns.any() or gap < rules.dilates_truly:
            return 0.0
        alpha = max(rules.least_contraction, rules.contraction * min(1.0, sqrt(gap)))
        # Near the end a gap that grows for a step must not undo what was reached.
        self._contraction = min(alpha, self._contraction) if gap < NEWTON_BELOW else alpha
        return self._contraction

    def _blends(self, gap: float) -> float:
        if not self.rules.ladder:
            return self.rules.blend if gap > self.rules.blend_above else 1.0
        if gap < NEWTON_BELOW:
            return 1.0
        if gap > self.rules.blend_above:
            self._rung = max(self._rung, HIGHEST_AT_FIRST)
        return RUNGS[self._rung]

    def lost(self, at: Iterate) -> bool:
        """Whether λ has left what can be an answer."""
        return abs(at.load_factor) > self._most_load

    def ended(self, step: NewtonStep) -> bool:
        """Whether the iterate is an answer."""
        exact = max(step.statics, step.yielding) < STATICS and step.motion < KINEMATICS
        return step.gap < GAP and step.contraction == 0 and exact

    def centre(self, at: Iterate, predicted: float, gap: float) -> float:
        """σ: the share of the gap to aim at, given the predictor's energy."""
        energy = at.energy
        sigma = min(max((predicted / energy) ** 3, OVERSHOOT * GAP / gap), 1.0)
        if self.rules.brake and gap > NEWTON_BELOW:
            left = self.residuals
            weighs = (
                np.abs(left.yielding * at.slip).sum()
                + np.abs(left.crushing * at.crushed).sum()
                + np.abs(left.motion * at.x).sum()
                + np.abs(left.statics * at.d).sum()
            )
            sigma = max(sigma, min(1.0, self.rules.brake * float(weighs) / energy))
        return sigma

    def lingers(self, step: NewtonStep) -> bool:
        """Whether the gap has not halved for longer than the rules allow."""
        if step.gap < self._halved[1] / 2:
            self._halved = (step.iteration, step.gap)
        return step.iteration - self._halved[0] > self.rules.patience

    def learn(self, length: float) -> int:
        """Adapt to the length of a step; the number of very short ones in a row."""
        if length < SHORT:
            self._rung = min(self._rung + 1, len(RUNGS) - 1)
            self.diagonal = min(_MORE * self.diagonal, _MOST_DIAGONAL)
        elif length > LONG:
            self._rung = max(self._rung - 1, 0)
            self.diagonal = max(_LESS * self.diagonal, _LEAST_DIAGONAL)
        self._short = self._short + 1 if length < SHORTEST else 0
        return self._short


def _advance(
    elimination: Elimination, at: Iterate, schedule: _Schedule, step: NewtonStep
) -> tuple[Iterate, NewtonStep]:
    """Predict, centre, correct, and go."""
    system = NewtonSystem(
        elimination, at, schedule.slope, schedule.friction, schedule.diagonal, schedule.rules.exact
    )
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
    if elimination.form.compliance.any() and step.gap < _ALIKE_BELOW:
        forces = motion = min(forces, motion)
    record = replace(
        step, centring=sigma, forces=forces, velocities=motion, error=direction.error, full=system.full
    )
    return moved(at, (forces, motion), direction.step), record


def _corrected(
    system: NewtonSystem,
    at: Iterate,
    schedule: _Schedule,
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


def _direction(system: NewtonSystem, at: Iterate, schedule: _Schedule, by: Products) -> _Direction:
    """The step that makes the residuals vanish and changes the products so."""
    left, form = schedule.residuals, schedule.form
    motion = -left.motion
    motion[:2] += by.edges / at.x[:2] + form.crushes((by.crushing + at.crushed * left.crushing) / at.room)
    sliding = by.sliding + at.slip * left.yielding
    solution, error = system.solve(Parts(-left.statics, sliding, motion, -left.work))
    room = form.chords(solution.joints) - left.crushing
    step = Iterate(
        solution.load,
        solution.joints,
        form.slacks(solution.joints, schedule.friction) - left.yielding,
        solution.blocks,
        (by.edges - at.opening * solution.joints[:2]) / at.x[:2],
        solution.sliding,
        room,
        (by.crushing - at.crushed * room) / at.room,
    )
    forces = _to_boundary((at.x[:2], at.z, at.room), (step.x[:2], step.z, step.room))
    rates = _to_boundary((at.opening, at.slip, at.crushed), (step.opening, step.slip, step.crushed))
    return _Direction(step, error, (forces, rates))


def _to_boundary(values: tuple[np.ndarray, ...], steps: tuple[np.ndarray, ...]) -> float:
    """The longest step up to one that keeps all values ≥ 0."""
    fastest = max(float((-step / value).max(initial=0.0)) for value, step in zip(values, steps, strict=True))
    # Never exactly onto the boundary: the next step divides by forces, slacks and rates.
    return min(1 / fastest, 1 - 1e-12) if fastest > 1 - 1e-12 else 1.0


def _onto_kinematics(elimination: Elimination, at: Iterate, schedule: _Schedule) -> Iterate:
    """The nearest motion that follows the flow rule, rates weighted by p/z: large where faces move, next to
    nothing where they stand still. The same equations as a step's, with the flow rule's slope in both."""
    form, slope = elimination.form, schedule.slope
    nothing = np.zeros_like(schedule.residuals.statics)
    system = NewtonSystem(
        elimination, at, slope, slope, schedule.diagonal, _ON_KINEMATICS, full=True, rigid=True
    )
    moves, most = at, _LEFT_IN_MOTION if form.compliance.any() else _ON_KINEMATICS
    for _ in range(_PROJECTIONS):
        left = form.residuals(moves, slope)
        if np.abs(left.motion).max() <= most * max(float(np.abs(moves.d).max()), 1.0):
            break
        solution, _ = system.solve(Parts(nothing, np.zeros_like(at.slip), -left.motion, -left.work))
        step = Iterate(
            0.0,
            np.zeros_like(at.x),
            np.zeros_like(at.z),
            solution.blocks,
            -at.opening * solution.joints[:2] / at.x[:2],
            solution.sliding,
            np.zeros_like(at.room),
            -at.crushed * form.chords(solution.joints) / at.room,
        )
        moves = moved(moves, (0.0, 1.0), step)
    return moves
