"""Whether a scene stands under its dead load, and why a program of statics or kinematics has no optimum."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from masonry_opt.answer.acceptance import ROOM, UNBALANCED
from masonry_opt.answer.reasons import Code, Reason, reason
from masonry_opt.answer.status import Status
from masonry_opt.answer.thresholds import DRIVES, NAMED, SLIDES
from masonry_opt.effort import Effort
from masonry_opt.models.cvxpy_standing import CvxpyDriven, CvxpyFalling, CvxpyStanding
from masonry_opt.models.cvxpy_terms import ShearParameters
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.kept import Kept
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.scene.extents import boxes
from masonry_opt.solvers.cvxpy_engine import CvxpyEngine, has_optimum
from masonry_opt.solvers.registry import Solver, find_solver, in_cvxpy, taking_cones

#: What a solver does here, as a result tells it.
DEAD_LOAD, DIAGNOSIS = "dead load", "diagnosis"


class DeadLoadUndecided(Exception):
    """The solver could not decide whether the scene stands; the message is its status."""


@dataclass
class _Standing:
    """Eq. (9) without live load, compiled, with the last forces (3c,) that carried the dead load."""

    model: CvxpyStanding
    parameters: ShearParameters
    engine: CvxpyEngine
    forces: np.ndarray | None = None
    stands: bool = False

    def under(self, problem: Problem, effort: Effort) -> _Standing:
        """The same in another scene (see :class:`~masonry_opt.problem.kept.Kept`)."""
        self.stands = self.forces is not None and _carries(problem, self.forces)
        if not self.stands:
            self.parameters.set(ShearLimits.true(problem))
            self.engine.restart(effort)
        return self


def falling_mechanism(
    problem: Problem, solver: Solver, effort: Effort, kept: Kept | None = None
) -> np.ndarray | None:
    """Block velocities with which blocks fall under dead load alone, shape (3b,); None if all stand.

    The scene stands if eq. (9) without live load has a state. Else the mechanism is the bounded dual ray.
    Every analysis asks first, since a largest λ may exist where λ = 0 is no equilibrium.

    Parameters
    ----------
    solver: what the analysis was asked to use; see :func:`~masonry_opt.solvers.registry.in_cvxpy`.
    kept: programs of the analyses before this one.

    Raises
    ------
    DeadLoadUndecided
        If the solver fails on both.
    """
    chosen, limits = taking_cones(solver, problem.layout.round), ShearLimits.true(problem)
    kept = kept or Kept()

    def declared() -> _Standing:
        parameters = ShearParameters(limits)
        model = CvxpyStanding(problem, parameters)
        engine = CvxpyEngine(model.program, chosen, effort, DEAD_LOAD, repeats=kept.keeps)
        return _Standing(model, parameters, engine)

    # Live loads do not matter here: programs of those that share the dead load are one.
    unloaded = replace(problem, live=problem.dead)
    standing = kept.of((DEAD_LOAD, chosen.key), unloaded, effort, declared)
    if standing.stands:
        return None
    solved = standing.engine.solve()
    if solved.optimal:
        standing.forces = standing.model.statics.q.value
        return None
    driven = _driven(problem, problem.dead, limits, chosen, effort, DEAD_LOAD)
    if driven is None:
        raise DeadLoadUndecided(solved.status)
    power, velocities = driven
    # A scene may stand so narrowly that no solver finds a state with room around it.
    return velocities if power > DRIVES else None


def _carries(problem: Problem, q: np.ndarray) -> bool:
    """Whether forces carry the dead load with room to spare, so that no program is needed."""
    room = float((problem.slacks(q, curved=problem.layout.round) / problem.face_arm).min(initial=np.inf))
    return room > ROOM and float(np.abs(problem.unbalanced(0.0, q)).max()) < UNBALANCED


def as_it_falls(assembly: Assembly, falling: np.ndarray, effort: Effort) -> np.ndarray:
    """Block velocities (3b,) with which a scene begins to fall; the given ones if the solver fails.

    The given mechanism, of most power, may lift blocks off corners that they turn about.
    """
    problem = assembly.problem
    low, high = boxes(assembly.geometry)
    square = (high - low)[assembly.movable] ** 2
    # About each axis by the two extents across it; in the plane about one that has none.
    across = square.sum(axis=1)[:, None] - (square if problem.layout.round else 0.0)
    gyration = np.sqrt(across / 12) / problem.length_unit
    inertia = float(problem.force_sizes(problem.dead) @ problem.by_block(falling**2).sum(axis=1))
    scale = min(max(inertia / float(problem.dead @ falling), 1.0), 1 / DRIVES)
    model = CvxpyFalling(problem, ShearLimits.true(problem), gyration, scale)
    if not has_optimum(model.program, in_cvxpy(find_solver("cvxpy", None)), effort, DEAD_LOAD):
        return falling
    return np.asarray(model.mechanism.d.value) / scale


def no_optimum(problem: Problem, solver_status: str, solver: Solver, effort: Effort) -> tuple[Status, Reason]:
    """Status and reason where eq. (9) or (10) has no optimum, of a scene that stands.

    The program is unlimited if the live load drives no mechanism; else its solver failed, whatever the
    solver's own status. The effort is told the solver, and no programs.
    """
    effort.begins("why there is no load factor")
    own = Effort()
    own_flow = _driven_by_live_load(problem, problem.dilatancy, solver, own)
    associative = _driven_by_live_load(problem, problem.friction, solver, own)
    effort.credit(own)
    if own_flow is None or associative is None or associative[0] > DRIVES:
        return Status.SOLVER_FAILED, reason(Code.SOLVER_STOPPED, word=solver_status)
    if own_flow[0] > DRIVES:
        return Status.LOCKED, reason(Code.DILATANCY_LOCKS)
    return Status.UNLIMITED, reason(Code.NO_MECHANISM)


def locking_joints(
    problem: Problem, status: Status, q: np.ndarray | None, solver: Solver, effort: Effort
) -> np.ndarray:
    """Indices of the joints that keep the live load from causing collapse, most important first; empty if
    the solver fails.

    Locked: joints that slide in the mechanism under the joints' own flow rule, by how far they cannot open as
    associative flow demands. Unlimited, jammed: joints that carry the live load alone, with shear limited by
    dilatancy or by friction, by normal force; if none do in a jammed scene, those whose force ``q`` grew.
    """
    none = np.array([], dtype=int)
    if status is Status.LOCKED:
        driven = _driven_by_live_load(problem, problem.dilatancy, solver, effort)
        if driven is None:
            return none
        d = driven[1]
        departure = problem.departure(d, problem.rates(d, problem.friction), problem.friction)
        cannot_open = np.abs(problem.by_kind(departure)[0])
        amount = np.where(problem.slip_speed(d) > SLIDES * np.abs(d).max(), cannot_open, 0.0)
    elif status in (Status.UNLIMITED, Status.JAMMED):
        slope = problem.dilatancy if status is Status.UNLIMITED else problem.friction
        # The live load in place of the dead.
        limits = ShearLimits(slope, np.zeros_like(slope))
        loaded = replace(problem.recession_cone, dead=problem.live / problem.live_norm)
        carrying = CvxpyStanding(loaded, limits)
        if has_optimum(carrying.program, taking_cones(solver, problem.layout.round), effort, DIAGNOSIS):
            q = carrying.statics.forces()[1]
        elif status is Status.UNLIMITED or q is None:
            return none
        amount = np.abs(problem.normal_forces(q))
    else:
        return none
    order = np.argsort(-amount, kind="stable")
    return order[amount[order] > max(NAMED * amount.max(), DRIVES)]


def _driven_by_live_load(
    problem: Problem, slope: np.ndarray, solver: Solver, effort: Effort
) -> tuple[float, np.ndarray] | None:
    """:func:`_driven` by the live load of unit sum, with an opening per unit slip (k,)."""
    limits, push = ShearLimits(slope, np.zeros_like(slope)), problem.live / problem.live_norm
    return _driven(
        problem.recession_cone, push, limits, taking_cones(solver, problem.layout.round), effort, DIAGNOSIS
    )


def _driven(
    problem: Problem,
    force: np.ndarray,
    limits: ShearLimits,
    solver: Solver,
    effort: Effort,
    purpose: str,
) -> tuple[float, np.ndarray] | None:
    """Power, zero if nothing moves, and block velocities (3b,) of the mechanism that a force drives; None if
    the solver fails."""
    model = CvxpyDriven(problem, force, limits)
    if not has_optimum(model.program, solver, effort, purpose):
        return None
    return float(model.program.value), np.asarray(model.mechanism.d.value)
