"""Why an analysis ended without a load factor: proof that there is none, and reasons with names.

That no mechanism goes with a state of equilibrium is shown by branch and cut on which faces move. In a
Coulomb state with λ ≥ 0 each face moves and is at yield, or does not move. Linear programs refute choices,
and their Farkas multipliers tell which few faces are to blame (combinatorial Benders cuts; Codato & Fischetti
2006): faces that cannot come to yield together, and faces of which one must move. Where the cuts leave no
choice there is no such state. Each cut is certified from the matrices.
"""

from contextlib import suppress
from dataclasses import replace

import numpy as np

from masonry_opt.answer.acceptance import PROOF
from masonry_opt.answer.answer import (
    Existence,
    InfeasibilityCertificate,
    kinematic_residual,
    ray_residuals,
    static_residual,
)
from masonry_opt.answer.motion import moving_names
from masonry_opt.answer.reasons import Code, Status, reason
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import NAMED
from masonry_opt.effort import Effort
from masonry_opt.models.cvxpy_exact import CvxpyMotion, CvxpyNoForces, CvxpyNoMotion
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.problem import Problem, in_units_of_load
from masonry_opt.solvers.highs import HighsSession
from masonry_opt.solvers.registry import Solver, Verdict
from masonry_opt.standing.diagnosis import locking_joints

#: Joints up to which rays are looked for, and up to which mechanisms are excluded by branching; and linear
#: programs times joints after which that is given up (random scenes that jam take 5 to 400 programs, some
#: up to 3300).
_RAYS_UP_TO, _CUTS_UP_TO = 2000, 100
_MOST_WORK = 120_000

_PURPOSE = "existence"  #: What a solver does here, as a result tells it.

#: A face with a rate above this moves in a mechanism in which the live load does the work Σ|f_L|. This is no
#: gate: the cut concluded from it must leave no more than PROOF.
_MOVES = 1e-9

_TO_BLAME = 1e-9  #: Share of the largest multiplier above which a face is to blame.
_OF_LATE = 200  #: Cuts that count in the choice of a face to branch on.
_OPEN, _STILL, _MOVING = -1, 0, 1  #: What a choice says of a face.


class _Undecided(Exception):
    """No proof: a choice is not refuted, a cut not borne out by its residual, or programs were too many."""


class Cuts:
    """Cuts that exclude every Coulomb state with λ ≥ 0, as far as they are found within ``most_programs``
    linear programs, of a scene that stands, in units of its load.

    ``exclude`` tells whether they leave no choice, ``residual`` is the largest that any of them leaves of its
    conditions, and ``static`` and ``kinematic`` are how many there are: sets of faces that cannot come to
    yield together, and of which one moves in every mechanism that lets the live load do work. A *choice* is
    by face whether it moves and is at yield, or does not move, or is open, shape (faces,).
    """

    def __init__(self, problem: Problem, most_programs: int, effort: Effort) -> None:
        self.problem, self.effort = problem, effort
        self._most_programs = effort.lp_solves + most_programs
        self._motion, self._no_motion = CvxpyMotion(problem), CvxpyNoMotion(problem, problem.dilatancy)
        self._no_forces = CvxpyNoForces(problem)
        self._mechanisms, self._kinematics, self._statics = (
            HighsSession(model.program, effort, _PURPOSE)
            for model in (self._motion, self._no_motion, self._no_forces)
        )
        # By what one of their faces must be, as rows over the faces: as many as there may be programs.
        self._rows = {implied: np.zeros((most_programs, problem.faces)) for implied in (_STILL, _MOVING)}
        self._count = {_STILL: 0, _MOVING: 0}
        self.residual, self.exclude = 0.0, False
        with suppress(_Undecided):
            self._refute(np.full(problem.faces, _OPEN))
            self.exclude = True
        self.static, self.kinematic = self._count[_STILL], self._count[_MOVING]

    def _refute(self, choice: np.ndarray) -> None:
        """Return if no Coulomb state agrees with a choice; raise _Undecided if that is not shown."""
        while (branch := self._branch(choice)) is not None:
            # The face at yield first, which few states of equilibrium allow.
            choice[branch] = _MOVING
            self._refute(choice.copy())
            choice[branch] = _STILL

    def _branch(self, choice: np.ndarray) -> int | None:
        """The face to branch on, after all that cuts imply is added to ``choice``; None if it is refuted."""
        while self._follows(choice):
            moving = choice == _MOVING
            if moving.any() and self._static_cut(moving) is not None:
                return None
            rates = self._mechanism(choice)
            if rates is None:
                self._kinematic_cut(choice == _STILL)
                return None
            cut = self._static_cut(moving | (rates > _MOVES))
            if cut is None:
                raise _Undecided  # these faces can move and come to yield together
            open_faces = [face for face in cut if choice[face] == _OPEN]
            if len(open_faces) > 1:
                # The face that most of the last cuts name: branching on it closes the tree soonest.
                blame = self._rows[_STILL][max(self._count[_STILL] - _OF_LATE, 0) :].sum(axis=0)
                return max(open_faces, key=lambda face: (blame[face], rates[face]))
        return None

    def _follows(self, choice: np.ndarray) -> bool:
        """Add to a choice what the cuts imply; False if it contradicts one."""
        changed = True
        while changed:
            changed = False
            for implied, count in self._count.items():
                rows = self._rows[implied][:count]
                met, left = rows @ (choice == implied) > 0, rows @ (choice == _OPEN)
                if (~met & (left == 0)).any():
                    return False
                forced = (choice == _OPEN) & rows[~met & (left == 1)].any(axis=0)
                choice[forced] = implied
                changed |= bool(forced.any())
        return True

    def _mechanism(self, choice: np.ndarray) -> np.ndarray | None:
        """Rates (faces,) of a mechanism of few moving faces, preferably those that move anyway."""
        p = self._motion.mechanism.p
        self._mechanisms.set_most(p, np.where(choice == _STILL, 0.0, np.inf))
        self._mechanisms.set_costs(p, np.where(choice == _MOVING, 0.01, 1.0))
        return self._mechanisms.values(p) if self._solved(self._mechanisms) else None

    def _static_cut(self, held: np.ndarray) -> frozenset[int] | None:
        """Those of some faces that cannot come to yield together; None if all can."""
        model = self._no_forces
        self._statics.set_most(model.r, np.where(held, np.inf, 0.0))
        if not self._solved(self._statics):
            return None
        d, p, r = (self._statics.values(variable) for variable in (model.d, model.p, model.r))
        blamed = r - p > _TO_BLAME * max(r.max(), 1.0)
        self._keep(_STILL, static_residual(self.problem, d, p - r, blamed), blamed)
        return frozenset(np.flatnonzero(blamed).tolist())

    def _kinematic_cut(self, still: np.ndarray) -> None:
        """Those of some faces of which one must move."""
        model = self._no_motion
        self._kinematics.set_most(model.v, np.where(still, np.inf, 0.0))
        if not self._solved(self._kinematics):
            raise _Undecided
        q, v = self._kinematics.values(model.q), self._kinematics.values(model.v)
        blamed = v > _TO_BLAME * max(v.max(), 1.0)
        self._keep(_MOVING, kinematic_residual(self.problem, q, blamed), blamed)

    def _keep(self, implied: int, residual: float, blamed: np.ndarray) -> None:
        """Keep a cut that its residual bears out: no state has none of its faces as ``implied``."""
        if not residual <= PROOF:
            raise _Undecided
        self.residual = max(self.residual, residual)
        self._rows[implied][self._count[implied], blamed] = 1.0
        self._count[implied] += 1

    def _solved(self, session: HighsSession) -> bool:
        if self.effort.lp_solves >= self._most_programs:
            raise _Undecided
        return session.solve() is Verdict.OPTIMAL


def existence(problem: Problem, effort: Effort, of_mechanism: bool = True) -> InfeasibilityCertificate | None:
    """Proof for a scene that stands, as far as there is one; None if it has too many joints. Mechanisms are
    excluded too if asked for: an associative load factor depends on statics alone."""
    if problem.joints > _RAYS_UP_TO:
        return None
    effort.begins("is there a load factor at all?")
    own = effort.beside()
    found = _found(in_units_of_load(problem).problem, own, of_mechanism)
    effort.add("solve", own.seconds["solve"])
    return found


def _found(problem: Problem, effort: Effort, of_mechanism: bool) -> InfeasibilityCertificate:
    # Dilatancy that falls with stress allows what less of it does.
    falls = problem.dilatancy_depends_on_stress
    own_flow = np.minimum(problem.dilatancy, 0.0) if falls else problem.dilatancy
    if against := _ray(problem, own_flow, effort):
        return InfeasibilityCertificate(Existence.NO_MECHANISM, *against[1])
    ray = _ray(problem, problem.friction, effort)
    if ray is None:
        # Statics are bounded: the method failed, and there is nothing to prove.
        return InfeasibilityCertificate(Existence.UNDECIDED)
    certificate = InfeasibilityCertificate(Existence.UNBOUNDED, *ray[1])
    if opposite := _ray(replace(problem, live=-problem.live), problem.friction, effort):
        n = problem.normal_forces(ray[0] + opposite[0])
        order = np.argsort(-n, kind="stable")
        stressed = tuple(order[n[order] > NAMED * n.max()].tolist())
        certificate = replace(certificate, clamped=stressed)
    # Cuts are of faces, which in space are sides inside the cone: they would prove nothing of it.
    of_cone = problem.by_cone.by_friction.conic
    if not of_mechanism or falls or of_cone or problem.joints > _CUTS_UP_TO:
        return certificate
    cuts = Cuts(problem, _MOST_WORK // problem.joints, effort)
    if not cuts.exclude:
        return certificate
    certificate = replace(certificate, existence=Existence.NO_STATE, cut_residual=cuts.residual)
    return replace(certificate, static_cuts=cuts.static, kinematic_cuts=cuts.kinematic)


def _ray(
    problem: Problem, slope: np.ndarray, effort: Effort
) -> tuple[np.ndarray, tuple[float, float]] | None:
    """Forces (3c,) that carry the live load alone with shear limits of a slope (k,) and without cohesion, and
    their residuals; None if none were found that their residuals bear out."""
    model = CvxpyNoMotion(problem, slope)
    session = HighsSession(model.program, effort, _PURPOSE)
    session.set_most(model.v, np.zeros(problem.faces))
    if session.solve() is not Verdict.OPTIMAL:
        return None
    q = session.values(model.q)
    left = ray_residuals(problem, q, slope)
    return (q, left) if max(left) <= PROOF else None


def explained(
    assembly: Assembly, solution: Solution, solver: Solver, effort: Effort, associative: bool
) -> Solution:
    """A solution without a load factor, with what is proven of that, and the joints that carry the load."""
    found = solution.infeasibility
    if found is None:
        if solution.associative is None or associative:
            found = existence(assembly.problem, effort, of_mechanism=not associative)
        else:  # statics are bounded
            found = InfeasibilityCertificate(Existence.UNDECIDED)
        solution = replace(solution, infeasibility=found)
    if found and not associative:
        if solution.status is not Status.UNSTABLE:
            solution = _as_proven(solution, found)
        if found.clamped:
            solution = solution.telling(reason(Code.CLAMPED, pairs=assembly.pairs(np.array(found.clamped))))
    locking = locking_joints(assembly.problem, solution.status, solution.q, solver, Effort())
    if not len(locking):
        return solution
    return solution.telling(reason(Code.JOINTS, status=str(solution.status), pairs=assembly.pairs(locking)))


def withdrawn(assembly: Assembly, solution: Solution, rests: bool) -> Solution:
    """A solution without its load factor, which is below zero, or of a scene that does not carry its dead
    load from rest: ``rests`` tells whether it does, or is held by wedging alone."""
    if rests:
        without = solution.withdrawn(Status.BELOW_ZERO, Code.BELOW_ZERO)
        if solution.load_factor is not None:
            without = replace(without, below_zero=solution.load_factor)
        if solution.peak is None:
            return without
        # The load history passed through loads that the scene carries before it ended below zero.
        history = (said for said in solution.reasons if said.code in (Code.RAY, Code.LEVEL))
        return replace(without.telling(*history), followed_to_end=True, peak=solution.peak)
    moving = [] if solution.d is None else moving_names(assembly, solution.d)
    return solution.withdrawn(Status.UNSTABLE, Code.WEDGED, blocks=moving)


def _as_proven(solution: Solution, found: InfeasibilityCertificate) -> Solution:
    """A solution with what is proven as status and reasons."""
    if found.existence is Existence.NO_MECHANISM and solution.status is not Status.UNLIMITED:
        return replace(solution, status=Status.UNLIMITED).telling_first(reason(Code.NO_MECHANISM))
    if found.existence is Existence.NO_STATE:
        why = reason(Code.NO_COLLAPSE, static_cuts=found.static_cuts, kinematic_cuts=found.kinematic_cuts)
        return replace(solution, status=Status.UNLIMITED).telling_first(why)
    unbounded = found.existence is Existence.UNBOUNDED
    return solution.telling(reason(Code.CARRIES_ANY)) if unbounded else solution
