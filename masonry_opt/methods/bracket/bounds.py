"""Largest forces and rates of all states with λ in an interval, proven from multipliers and dual rays."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from masonry_opt.answer.acceptance import BEYOND_LIMITS
from masonry_opt.effort import Effort
from masonry_opt.models.cvxpy_exact import CvxpyForces, CvxpyMotion
from masonry_opt.problem.edges import EdgeFactors
from masonry_opt.problem.faces import selection
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.solvers.highs import HighsSession
from masonry_opt.solvers.registry import Verdict

_PURPOSE = "bounds"  #: What HiGHS does here, as a result tells it.
_TIMES_LOADS = 10.0  #: Where statics set no limit, forces are assumed to be at most so many times all loads.
_BEYOND = 1e9  #: A mechanism that only rates and velocities this large could make is none.


@dataclass(frozen=True)
class StateBounds:
    """Largest forces and rates of all states with lowest ≤ λ ≤ Λ."""

    lowest: float
    normal: np.ndarray  #: normal force of each joint, shape (c,)
    forces: np.ndarray  #: magnitudes of x₂, x₃ and z₀ (or s) of each joint, flat, shape (3c,)
    rates: float  #: sum of all slips and edge openings
    #: Whether statics and kinematics imply them; else some are assumed, and what follows holds below only.
    forces_derived: bool
    rates_derived: bool

    def allow(self, q: np.ndarray, rates: float) -> bool:
        """Whether a state's forces (3c,) and the sum of its rates stay below what is assumed."""
        first, second, shear = np.abs(q.reshape(3, -1))
        forces, most = np.stack([first + second, shear]), np.stack([self.normal, self.forces[2::3]])
        within = self.forces_derived or bool((forces <= most + BEYOND_LIMITS * (1 + most)).all())
        return within and (self.rates_derived or rates < self.rates)


def bounds_of(problem: Problem, highest: float, assumed_rates: float, effort: Effort) -> StateBounds:
    """Bounds over all states with 0 ≤ λ ≤ ``highest``: the largest forces that statics allow, and the largest
    rates that kinematics allow each face while raising the blocks takes no more than the live load gives;
    sliding with the other sense at rest. Nothing is lost by that where dilatancy is not negative: at yield in
    both senses a joint carries nothing and may open instead (without friction and cohesion it must not
    dilate)."""
    normal, forces, derived = _force_limits(problem, (0.0, highest), effort)
    rates = _most_rates(problem, highest, effort)
    slips_either_way = (problem.dilatancy > 0) & (problem.friction == 0) & (problem.cohesion == 0)
    rates_derived = bool(np.isfinite(rates) and (problem.dilatancy >= 0).all() and not slips_either_way.any())
    rates = rates if rates_derived else assumed_rates
    return StateBounds(0.0, normal, forces, rates, forces_derived=derived, rates_derived=rates_derived)


def tightened(
    of: StateBounds, problem: Problem, lowest: float, highest: float, effort: Effort
) -> StateBounds:
    """The same with the forces of the states with ``lowest`` ≤ λ ≤ ``highest`` alone: the nearer λ is to what
    statics can carry, the less self-stress goes with it."""
    normal, forces, derived = _force_limits(problem, (lowest, highest), effort)
    if not derived:
        # An assumption must not take the place of what is proven of more states.
        return replace(of, lowest=lowest)
    normal, forces = np.minimum(normal, of.normal), np.minimum(forces, of.forces)
    return replace(of, lowest=lowest, normal=normal, forces=forces)


def _force_limits(
    problem: Problem, within: tuple[float, float], effort: Effort
) -> tuple[np.ndarray, np.ndarray, bool]:
    """Largest normal forces, the magnitudes of all edge forces, and whether none of them is assumed. Programs
    find the largest of those that limit all others: n of every joint, and s where a joint cannot slide."""
    forces = CvxpyForces(problem, within=within)
    session, q = HighsSession(forces.program, effort, _PURPOSE), forces.statics.q
    c, highest = problem.joints, within[1]
    cannot_slide = np.setdiff1d(np.arange(c), problem.sliding)
    of_shears = selection(2 * c + cannot_slide, problem.table.width)
    targets = sp.vstack([problem.table.normal_sums, of_shears]).toarray()
    steep = max(1.0, float(problem.friction.max(initial=0.0)))
    # Every force is at most so many times 1 + the sum of the targets.
    share = steep + float(problem.cohesion.max(initial=0.0))
    values, short = np.zeros((2, len(targets)))
    columns = session.columns(q)
    for number, target in enumerate(targets):
        for sign in (1.0, -1.0) if number >= c else (1.0,):
            session.set_costs(q, -sign * target)
            if session.solve() is not Verdict.OPTIMAL:
                values[number] = np.inf
                break
            least, lacks = session.least()
            elsewhere = float(np.delete(lacks, columns).sum()) * max(highest, 1.0)
            values[number] = max(values[number], -least + elsewhere)
            short[number] = max(short[number], float(lacks[columns].sum()) * share)
    assumed = _TIMES_LOADS * float(np.abs(problem.dead).sum() + highest * problem.live_norm)
    found = np.isfinite(values)
    bounds = _with_what_is_short(np.where(found, values, assumed), np.where(found, short, 0.0))
    proven = np.isfinite(bounds)
    bounds = np.where(proven, bounds, assumed)
    normal, shear = bounds[:c], np.zeros(c)
    shear[problem.sliding] = 2 * ShearLimits.true(problem).at(normal[problem.sliding])
    shear[cannot_slide] = bounds[c:]
    return normal, np.stack([normal, normal, shear], axis=1).ravel(), bool((found & proven).all())


def _with_what_is_short(values: np.ndarray, short: np.ndarray) -> np.ndarray:
    """Bounds of x ≥ 0 from xⱼ ≤ valuesⱼ + shortⱼ (1 + Σ x); ``inf`` where Σ x cannot pay what is short."""
    if short.sum() >= 0.5:
        return np.where(short == 0.0, values, np.inf)
    total = float((values.sum() + short.sum()) / (1 - short.sum()))
    return np.asarray(values + short * (1 + total))


def _most_rates(problem: Problem, highest: float, effort: Effort) -> float:
    """Largest sum of slips and edge openings over the mechanisms on which raising the blocks takes at most
    ``highest`` times the live load's work; ``inf`` where the solver finds no largest of some face."""
    motion = CvxpyMotion(problem, raising=highest * problem.live_norm)
    session, mechanism = HighsSession(motion.program, effort, _PURPOSE), motion.mechanism
    slides, faces = problem.table.slides.stop, problem.faces
    of_rates, of_velocities = session.columns(mechanism.p), session.columns(mechanism.d)
    values, short, of_motion = np.zeros(faces), np.zeros(faces), np.zeros((faces, len(of_velocities)))
    for face in range(faces):
        most = np.full(faces, np.inf)
        if face < slides:
            most[(face + slides // 2) % slides] = 0.0
        session.set_most(mechanism.p, most)
        session.set_costs(mechanism.p, -np.eye(1, faces, face)[0])
        verdict = session.solve()
        if verdict is Verdict.INFEASIBLE:
            value, lacks = session.contradiction()
            if value > _BEYOND * lacks.sum():
                continue  # at rest in every such mechanism: there is none
        if verdict is not Verdict.OPTIMAL:
            return float(np.inf)
        least, lacks = session.least()
        values[face] = max(-least, 0.0)
        short[face], of_motion[face] = lacks[of_rates].max(), lacks[of_velocities]
    short += of_motion @ np.abs(velocities_by_rates(problem)).max(axis=1)
    return float(EdgeFactors(problem).in_edges(_with_what_is_short(values, short)).sum())


def velocities_by_rates(problem: Problem) -> np.ndarray:
    """d = M p for all velocities d and face rates p that kinematics allow, shape (3b, faces)."""
    return np.asarray(np.linalg.pinv(problem.B.T.toarray()) @ problem.D(problem.dilatancy).toarray())
