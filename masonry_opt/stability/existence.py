"""Prove that no load factor exists, and give the reasons why an analysis ended without a load factor.

The proof that no mechanism is compatible with a state of equilibrium is a branch and cut on the faces (yield
conditions) with nonzero rates. In a Coulomb state with λ ≥ 0, each face either is at yield, or has a rate of
zero. Linear programs refute choices of faces with nonzero rates. Their Farkas multipliers identify the few
faces that cause the contradiction. These faces form combinatorial Benders cuts (Codato & Fischetti 2006) of
two kinds:

- faces that cannot all be at yield in one state;
- faces of which at least one must have a nonzero rate.

If the cuts exclude every choice, no Coulomb state exists. Each cut is certified from the matrices.
"""

from contextlib import suppress
from dataclasses import replace

import numpy as np

from masonry_opt.effort import Effort
from masonry_opt.models.cvxpy_exact import CvxpyMotion, CvxpyNoForces, CvxpyNoMotion
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.problem import Problem, in_units_of_load
from masonry_opt.solution.acceptance import PROOF
from masonry_opt.solution.answer import (
    Existence,
    InfeasibilityCertificate,
    kinematic_residual,
    ray_residuals,
    static_residual,
)
from masonry_opt.solution.motion import moving_names
from masonry_opt.solution.reasons import Code, Status, reason
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.thresholds import LISTED_JOINT_SHARE
from masonry_opt.solvers.highs import HighsSession
from masonry_opt.solvers.registry import Solver, Verdict
from masonry_opt.stability.diagnosis import locking_joints

#: Largest number of joints of a scene for which this module tries to prove that no load factor exists. For
#: larger scenes, no proof is sought.
_RAYS_UP_TO = 2000

#: Largest number of joints of a scene for which branch and cut tries to prove that no load factor exists. For
#: larger scenes, branch and cut is skipped.
_CUTS_UP_TO = 100

#: Branch and cut stops without a proof if its number of linear programs times the number of joints exceeds
#: this limit. Most random scenes in which joints jam need 5 to 400 programs, and a few need up to 3300.
_MOST_WORK = 120_000

#: Key of ``result.solvers`` for the solver that decides if a load factor exists.
_EXISTENCE_PURPOSE = "existence"

#: Rate of a face (yield condition) above which branch and cut regards the rate as nonzero. Mechanisms are
#: scaled such that the live load does the work Σ|f_L|. Proofs are valid with any value, because the residual
#: of each cut is compared with ``PROOF``.
_MOVING_RATE = 1e-9

#: A cut of branch and cut contains the faces (yield conditions) whose Farkas multipliers exceed this fraction
#: of the largest multiplier. With a larger fraction, cuts have fewer faces, but perhaps residuals that are
#: too large for a proof.
_TO_BLAME = 1e-9

#: Number of the latest cuts that determine on which face (yield condition) the search branches: the search
#: selects the face that occurs in most of the latest cuts.
_OF_LATE = 200

#: Value of a face (yield condition) in branch and cut: it is not yet decided if its rate is zero.
_OPEN = -1

#: Value of a face (yield condition) in branch and cut: its rate is zero.
_RESTING = 0

#: Value of a face (yield condition) in branch and cut: its rate may be nonzero, so it must be at yield.
_MOVING = 1


class _Undecided(Exception):
    """Exception that is raised if branch and cut ends without a proof.

    Either a choice of faces with nonzero rates cannot be refuted, the residual of a cut is too large, or too
    many programs were solved.
    """


class Cuts:
    """Branch-and-cut search that tries to prove that a stable scene has no Coulomb state with λ ≥ 0.

    The problem is in units of its load.

    A *choice*, shape (faces,), has one of three values for each face (yield condition):

    - ``_MOVING``: the rate of the face may be nonzero, so the face must be at yield;
    - ``_RESTING``: the rate of the face is zero;
    - ``_OPEN``: it is not yet decided if the rate is zero.

    The search for cuts solves at most ``most_programs`` linear programs.

    Attributes
    ----------
    exclude: True if the cuts exclude every choice, so that no Coulomb state exists.
    residual: largest residual of the conditions of a cut.
    static: number of sets of faces that cannot all be at yield in one state.
    kinematic: number of sets of faces of which at least one has a nonzero rate in every mechanism in which
        the live load does work.
    """

    def __init__(self, problem: Problem, most_programs: int, effort: Effort) -> None:
        self.problem, self.effort = problem, effort
        self._most_programs = effort.lp_solves + most_programs
        self._motion, self._no_motion = CvxpyMotion(problem), CvxpyNoMotion(problem, problem.dilatancy)
        self._no_forces = CvxpyNoForces(problem)
        self._mechanisms, self._kinematics, self._statics = (
            HighsSession(model.program, effort, _EXISTENCE_PURPOSE)
            for model in (self._motion, self._no_motion, self._no_forces)
        )
        # A cut states that at least one of its faces has a rate of zero, or that at least one has a nonzero
        # rate. Each kind of cut has a matrix of shape (cuts, faces). Each cut requires a linear program, so
        # ``most_programs`` rows suffice.
        self._rows = {implied: np.zeros((most_programs, problem.faces)) for implied in (_RESTING, _MOVING)}
        self._count = {_RESTING: 0, _MOVING: 0}
        self.residual, self.exclude = 0.0, False
        with suppress(_Undecided):
            self._refute(np.full(problem.faces, _OPEN))
            self.exclude = True
        self.static, self.kinematic = self._count[_RESTING], self._count[_MOVING]

    def _refute(self, choice: np.ndarray) -> None:
        """Prove that no Coulomb state has the zero and nonzero rates that ``choice`` assumes.

        The array ``choice`` states for each face whether its rate may be nonzero, see :class:`Cuts`. Raises
        _Undecided if the proof fails.
        """
        branch = self._branch(choice)
        while branch is not None:
            # First try the branch in which the rate may be nonzero. The yield condition must then hold with
            # equality, so this branch excludes more states.
            choice[branch] = _MOVING
            self._refute(choice.copy())
            choice[branch] = _RESTING
            branch = self._branch(choice)

    def _branch(self, choice: np.ndarray) -> int | None:
        """Return the face on which to branch next; None if ``choice`` already excludes every Coulomb state.

        All values that the cuts imply are first added to ``choice``. Raises _Undecided if all faces
        with nonzero rates in a mechanism of the choice can be at yield in one state.
        """
        while self._follows(choice):
            moving = choice == _MOVING
            if moving.any() and self._static_cut(moving) is not None:
                return None
            rates = self._mechanism(choice)
            if rates is None:
                self._kinematic_cut(choice == _RESTING)
                return None
            cut = self._static_cut(moving | (rates > _MOVING_RATE))
            if cut is None:
                # No cut excludes this choice of faces with nonzero rates, because all of them can be at yield
                # in one state. The proof fails.
                raise _Undecided
            open_faces = [face for face in cut if choice[face] == _OPEN]
            if len(open_faces) > 1:
                # Branch on the face that occurs in most of the latest cuts, because this keeps the search
                # short.
                blame = self._rows[_RESTING][max(self._count[_RESTING] - _OF_LATE, 0) :].sum(axis=0)
                return max(open_faces, key=lambda face: (blame[face], rates[face]))
        return None

    def _follows(self, choice: np.ndarray) -> bool:
        """Set open entries of a choice to values that cuts imply; return False if a cut excludes the choice.

        The cuts imply an entry if they require that the rate of its face is zero, or is nonzero.
        """
        changed = True
        while changed:
            changed = False
            for implied, count in self._count.items():
                rows = self._rows[implied][:count]
                is_met = rows @ (choice == implied) > 0
                open_counts = rows @ (choice == _OPEN)
                if (~is_met & (open_counts == 0)).any():
                    return False
                forced = (choice == _OPEN) & rows[~is_met & (open_counts == 1)].any(axis=0)
                choice[forced] = implied
                changed |= bool(forced.any())
        return True

    def _mechanism(self, choice: np.ndarray) -> np.ndarray | None:
        """Return rates p, shape (faces,), of a mechanism with few nonzero rates, or None if none is found.

        Faces with nonzero rates in the choice have low costs; faces with zero rates in the choice keep zero
        rates.
        """
        p = self._motion.mechanism.p
        self._mechanisms.set_most(p, np.where(choice == _RESTING, 0.0, np.inf))
        self._mechanisms.set_costs(p, np.where(choice == _MOVING, 0.01, 1.0))
        return self._mechanisms.values(p) if self._solved(self._mechanisms) else None

    def _static_cut(self, at_yield: np.ndarray) -> frozenset[int] | None:
        """Find faces that cannot all be at yield in one state, add them as a cut, and return them.

        The faces of the cut are among those of the mask ``at_yield``. None is returned if all faces of the
        mask can be at yield in one state, or if the solver finds no optimum.
        """
        model = self._no_forces
        self._statics.set_most(model.r, np.where(at_yield, np.inf, 0.0))
        if not self._solved(self._statics):
            return None
        d, p, r = (self._statics.values(variable) for variable in (model.d, model.p, model.r))
        blamed = r - p > _TO_BLAME * max(r.max(), 1.0)
        self._keep(_RESTING, static_residual(self.problem, d, p - r, blamed), blamed)
        return frozenset(np.flatnonzero(blamed).tolist())

    def _kinematic_cut(self, motionless: np.ndarray) -> None:
        """Find faces of which at least one has a nonzero rate in every mechanism, and add them as a cut.

        The mechanisms are those in which the live load does work. The faces of the cut are among the faces
        with zero rates, for which the mask ``motionless``, shape (faces,), is True.
        """
        model = self._no_motion
        self._kinematics.set_most(model.v, np.where(motionless, np.inf, 0.0))
        if not self._solved(self._kinematics):
            raise _Undecided
        q, v = self._kinematics.values(model.q), self._kinematics.values(model.v)
        blamed = v > _TO_BLAME * max(v.max(), 1.0)
        self._keep(_MOVING, kinematic_residual(self.problem, q, blamed), blamed)

    def _keep(self, implied: int, residual: float, blamed: np.ndarray) -> None:
        """Store a cut: faces whose rates cannot all be zero, or cannot all be nonzero, in one Coulomb state.

        ``implied`` is ``_MOVING`` if at least one rate must be nonzero, and ``_RESTING`` if at least one must
        be zero. ``blamed``, shape (faces,), is True for the faces of the cut.

        Raises _Undecided if the residual is too large for a proof.
        """
        if not residual <= PROOF:
            raise _Undecided
        self.residual = max(self.residual, residual)
        self._rows[implied][self._count[implied], blamed] = 1.0
        self._count[implied] += 1

    def _solved(self, session: HighsSession) -> bool:
        """Solve a linear program, and return True if the solver finds an optimum."""
        if self.effort.lp_solves >= self._most_programs:
            raise _Undecided
        return session.solve() is Verdict.OPTIMAL


def existence(problem: Problem, effort: Effort, of_mechanism: bool = True) -> InfeasibilityCertificate | None:
    """Try to prove that a stable scene has no load factor, and return the result as a certificate.

    The result is None if the scene has too many joints. If ``of_mechanism`` is True, branch and cut also
    tries to exclude all mechanisms. Pass False for associative flow, because statics alone then determine
    whether a load factor exists.
    """
    if problem.joints > _RAYS_UP_TO:
        return None
    effort.begins("existence of a load factor")
    own = effort.separate_counter()
    certificate = _proof(in_units_of_load(problem).problem, own, of_mechanism)
    effort.add("solve", own.seconds["solve"])
    return certificate


def _proof(problem: Problem, effort: Effort, of_mechanism: bool) -> InfeasibilityCertificate:
    """Return the certificate of :func:`existence` for a problem that is scaled by its load."""
    dilatancy_falls = problem.dilatancy_depends_on_stress
    # A dilatancy that falls with stress is unknown in a collapse state. The proof uses its smallest possible
    # value: zero, or the given dilatancy if it is negative.
    own_flow = np.minimum(problem.dilatancy, 0.0) if dilatancy_falls else problem.dilatancy
    against_mechanisms = _ray(problem, own_flow, effort)
    if against_mechanisms:
        return InfeasibilityCertificate(Existence.NO_MECHANISM, *against_mechanisms[1])
    ray = _ray(problem, problem.friction, effort)
    if ray is None:
        # No joint forces were found that balance the live load alone, so λ may be limited. A collapse state
        # may therefore exist, although the analysis has not found one.
        return InfeasibilityCertificate(Existence.UNDECIDED)
    certificate = InfeasibilityCertificate(Existence.UNBOUNDED, *ray[1])
    opposite = _ray(replace(problem, live=-problem.live), problem.friction, effort)
    if opposite:
        n = problem.normal_forces(ray[0] + opposite[0])
        order = np.argsort(-n, kind="stable")
        stressed = tuple(order[n[order] > LISTED_JOINT_SHARE * n.max()].tolist())
        certificate = replace(certificate, clamped=stressed)
    # In space, the faces of a cut are sides of polygons inside the friction cones. Such cuts prove nothing
    # about the cones, so branch and cut is skipped.
    has_cones = problem.by_cone.by_friction.conic
    if not of_mechanism or dilatancy_falls or has_cones or problem.joints > _CUTS_UP_TO:
        return certificate
    cuts = Cuts(problem, _MOST_WORK // problem.joints, effort)
    if not cuts.exclude:
        return certificate
    certificate = replace(certificate, existence=Existence.NO_STATE, cut_residual=cuts.residual)
    return replace(certificate, static_cuts=cuts.static, kinematic_cuts=cuts.kinematic)


def _ray(
    problem: Problem, slope: np.ndarray, effort: Effort
) -> tuple[np.ndarray, tuple[float, float]] | None:
    """Return joint forces that balance the live load alone, and the residuals of equilibrium and yield.

    The forces have the shape (3c + t,). ``slope`` is the slope of the shear limits, shape (k,); cohesion is
    ignored. The result is None if no forces are found, or if their residuals are too large for a proof.
    """
    model = CvxpyNoMotion(problem, slope)
    session = HighsSession(model.program, effort, _EXISTENCE_PURPOSE)
    session.set_most(model.v, np.zeros(problem.faces))
    if session.solve() is not Verdict.OPTIMAL:
        return None
    q = session.values(model.q)
    residuals = ray_residuals(problem, q, slope)
    return (q, residuals) if max(residuals) <= PROOF else None


def explained(
    assembly: Assembly, solution: Solution, solver: Solver, effort: Effort, associative: bool
) -> Solution:
    """Add to a solution the reasons why the scene has no load factor, and return the solution.

    The reasons state the proof that no load factor exists, if there is a proof, and the joints that prevent
    the live load from causing collapse. ``associative`` is True if the method assumes associative flow.
    """
    certificate = solution.infeasibility
    if certificate is None:
        if solution.associative is None or associative:
            certificate = existence(assembly.problem, effort, of_mechanism=not associative)
        else:
            # An associative load factor exists and limits λ. A proof that the scene carries every multiple of
            # the live load is therefore impossible.
            certificate = InfeasibilityCertificate(Existence.UNDECIDED)
        solution = replace(solution, infeasibility=certificate)
    if certificate and not associative:
        if solution.status is not Status.UNSTABLE:
            solution = _as_proven(solution, certificate)
        if certificate.clamped:
            pairs = assembly.pairs(np.array(certificate.clamped))
            solution = solution.telling(reason(Code.CLAMPED, pairs=pairs))
    locking = locking_joints(assembly.problem, solution.status, solution.q, solver, Effort())
    if not len(locking):
        return solution
    return solution.telling(reason(Code.JOINTS, status=str(solution.status), pairs=assembly.pairs(locking)))


def withdrawn(assembly: Assembly, solution: Solution, rests: bool) -> Solution:
    """Remove the load factor of a solution, add the reason for the removal, and return the solution.

    If ``rests`` is True, the scene carries its dead load from rest, and the load factor is below zero.
    Otherwise only forces between wedged blocks could carry the dead load.
    """
    if rests:
        without = solution.withdrawn(Status.BELOW_ZERO, Code.BELOW_ZERO)
        if solution.load_factor is not None:
            without = replace(without, below_zero=solution.load_factor)
        if solution.peak is None:
            return without
        # Keep the reasons that describe the load history: although λ is withdrawn, the scene carried all load
        # factors up to the peak of the load history.
        of_history = (entry for entry in solution.reasons if entry.code in (Code.COLLAPSE, Code.RANGE))
        return replace(without.telling(*of_history), followed_to_end=True, peak=solution.peak)
    moving = [] if solution.d is None else moving_names(assembly, solution.d)
    return solution.withdrawn(Status.UNSTABLE, Code.WEDGED, blocks=moving)


def _as_proven(solution: Solution, certificate: InfeasibilityCertificate) -> Solution:
    """Return a copy of a solution, with a status and a reason that state what the certificate proves."""
    if certificate.existence is Existence.NO_MECHANISM and solution.status is not Status.UNLIMITED:
        return replace(solution, status=Status.UNLIMITED).telling_first(reason(Code.NO_MECHANISM))
    if certificate.existence is Existence.NO_STATE:
        cuts = {"static_cuts": certificate.static_cuts, "kinematic_cuts": certificate.kinematic_cuts}
        return replace(solution, status=Status.UNLIMITED).telling_first(reason(Code.NO_COLLAPSE, **cuts))
    is_unbounded = certificate.existence is Existence.UNBOUNDED
    return solution.telling(reason(Code.CARRIES_ANY)) if is_unbounded else solution
