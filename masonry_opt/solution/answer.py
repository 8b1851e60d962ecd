"""Answers with their certificates, and proofs that no load factor exists.

Methods return answers; a certificate consists of the residuals of an answer. Residuals are computed from the
matrices alone, and are never taken from a solver.
"""

from dataclasses import asdict, dataclass
from enum import StrEnum
from math import inf
from typing import Any

import numpy as np
import scipy.sparse as sp

from masonry_opt.brief import brief
from masonry_opt.problem.laws import BY_FACES, Forms
from masonry_opt.problem.problem import Problem
from masonry_opt.solution.acceptance import LIMITS, Kind

#: Residuals of a block are divided by the largest force on this block, but at least by this fraction of the
#: total live load at collapse. Residuals of a joint are divided by the smaller of the divisors of its two
#: blocks. With a larger fraction, errors on blocks with small forces count less.
_SMALLEST_FORCE = 1e-4


@dataclass(frozen=True)
class Certificate:
    """Residuals of the conditions that a collapse state must satisfy; all are zero for an exact state.

    The state consists of a load factor λ, joint forces q and block velocities d.

    Attributes
    ----------
    equilibrium: largest entry of B q + λ f_L + f_D, over the total dead load.
    yield_: largest violation of the true friction law, of n ≥ 0 or of rocking, as a force in median
        block weights.
    flow: largest departure of Bᵀd from the flow rule, over the largest velocity.
    complementarity: Σ|z p|, relative to the work of the live load at λ = 1. The sum is the energy of faces
        that move although they are not at yield. For associative flow, the error of λ is at most this
        residual. The limits of acceptance apply to this value divided by |λ|. Rates of sliding faces are
        divided by max(1, μ) / max(1, slope of the flow rule).
    """

    equilibrium: float
    yield_: float
    flow: float
    complementarity: float

    def as_dict(self) -> dict[str, float]:
        """Return the residuals as a dictionary, keyed by the names that reports use.

        Returns
        -------
        dict
            The numbers ``equilibrium``, ``yield``, ``flow`` and ``complementarity``, without units.
        """
        return {name.rstrip("_"): value for name, value in asdict(self).items()}

    @property
    def worst(self) -> float:
        """Largest of the four residuals."""
        return max(self.as_dict().values())


def certify(
    problem: Problem, load_factor: float, q: np.ndarray, d: np.ndarray, slope: np.ndarray
) -> Certificate:
    """Return the residuals of a collapse state under a given flow rule.

    The state consists of the load factor, the joint forces q, shape (3c + t,), and the block velocities d,
    shape (3b,). The flow rule is defined by ``slope``, shape (k,): the ratio of opening to slip of the joints
    that can slide. The slope is μ for associative flow and tan φ₀ for the joints' own flow rule.
    """
    total_dead = problem.force_sizes(problem.dead).sum() or problem.live_norm
    z, p = problem.slacks(q), problem.rates(d, slope)
    # With a large μ, the slack of a sliding condition is about μ times the normal force n. At μ = 1e6, a
    # rounding error of 1e-14 in a slip rate would add 1e-8 n to the energy. Therefore divide slip rates by
    # max(1, μ) / max(1, slope). This divisor is 1 for associative flow, because the slope is then μ.
    steep = problem.steep / np.maximum(problem.limit_factors @ slope, 1.0)
    live_work = float(problem.live @ d) or problem.live_norm
    return Certificate(
        equilibrium=float(np.abs(problem.unbalanced(load_factor, q)).max() / total_dead),
        yield_=max(0.0, -float(z.min())),
        flow=float(np.abs(problem.departure(d, p, slope)).max() / (np.abs(d).max() or 1.0)),
        complementarity=problem.energy(q, p / steep) / abs(live_work),
    )


def largest_acting(problem: Problem, load_factor: float, q: np.ndarray) -> np.ndarray:
    """Return the largest force that loads and joints exert on each block, shape (b,).

    The value is at least ``_SMALLEST_FORCE`` times the total live load at collapse.
    """
    loads = np.abs(problem.dead) + abs(load_factor * problem.live)
    loads = problem.forces(loads).max(axis=1)
    at_joints = np.abs([problem.normal_forces(q), *problem.shears(q)]).max(axis=0)
    carried = np.zeros(problem.blocks)
    block, joint = problem.matrices.ends.nonzero()
    np.maximum.at(carried, block, at_joints[joint])
    if problem.matrices.limited:
        limited = abs(problem.matrices.of_limited @ sp.diags_array(problem.of_forces(q)))
        from_limited = problem.forces(limited.max(axis=1).toarray()).max(axis=1)
        carried = np.maximum(carried, from_limited)
    smallest = _SMALLEST_FORCE * problem.load_factor_scale.divisor(load_factor) * problem.live_norm
    return np.maximum(np.maximum(loads, carried), smallest)


def of_lesser_block(problem: Problem, acting: np.ndarray) -> np.ndarray:
    """Return, for each joint, the smaller of the largest forces on its two blocks, shape (c,).

    ``acting`` contains the largest force on each movable block, shape (b,). Fixed blocks do not count.
    """
    lesser = np.full(problem.joints, inf)
    block, joint = problem.matrices.ends.nonzero()
    np.minimum.at(lesser, joint, acting[block])
    return lesser


def unbalanced_shares(problem: Problem, unbalanced: np.ndarray, acting: np.ndarray) -> np.ndarray:
    """Return the unbalanced force on each block, relative to the largest force on the block, shape (b,).

    ``unbalanced`` is the residual of equilibrium, shape (3b,); ``acting`` is :func:`largest_acting`. Each
    moment is converted to a force at the block's longest arm.
    """
    forces = np.abs(problem.forces(unbalanced)).max(axis=1) / acting
    moments = np.abs(problem.moments(unbalanced)).max(axis=1) / (acting * problem.matrices.longest_arm)
    shares: np.ndarray = np.maximum(forces, moments)
    return shares


def violation_shares(problem: Problem, z: np.ndarray, acting: np.ndarray) -> np.ndarray:
    """Return the violation of each yield condition, relative to forces on the blocks, shape (faces,).

    The violation is −z; a negative entry means that the condition is satisfied. The reference force of a
    joint is computed by :func:`of_lesser_block`. The reference force of a force limit is the smallest entry
    of ``acting``, the result of :func:`largest_acting`.
    """
    at_faces = of_lesser_block(problem, acting)[problem.face_joint]
    return np.append(-z[: len(at_faces)] / at_faces, -z[problem.table.limits] / acting.min())


@dataclass(frozen=True, eq=False, kw_only=True)
class FinalState:
    """Joint forces and block velocities at the end of a method; each is None if unknown."""

    q: np.ndarray | None = None  #: joint forces, shape (3c + t,)
    d: np.ndarray | None = None  #: block velocities, shape (3b,)
    #: Ratio of opening to slip of each joint that can slide, in the flow rule of the mechanism, shape (k,).
    slope: np.ndarray | None = None
    #: Classes that evaluate the friction law (as linear conditions or as a cone) and the strength law (as
    #: chords or as a parabola).
    forms: Forms = BY_FACES

    __repr__ = brief


@dataclass(frozen=True, eq=False, kw_only=True)
class Answer(FinalState):
    """Load factor with joint forces, mechanism and the residuals of all conditions.

    Create answers only with :func:`certified`, which computes the residuals of each state in one place.
    """

    load_factor: float  #: load factor λ
    q: np.ndarray  #: joint forces, shape (3c + t,)
    d: np.ndarray  #: block velocities, shape (3b,)
    slope: np.ndarray  #: ratio of opening to slip of each joint that can slide, shape (k,)
    certificate: Certificate  #: residuals of the scene as a whole
    residuals: dict[str, float]  #: residuals, keyed by the names of their limits in ``Limits``

    __repr__ = brief

    def failing(self, kind: Kind) -> dict[str, float | None]:
        """Return the residuals that exceed the limits for a kind of answer."""
        return LIMITS[kind].failing(self.residuals)

    @property
    def exact(self) -> bool:
        """True if the answer is an exact state."""
        return not self.failing(Kind.EXACT)

    def certified_by(self, problem: Problem, slope: np.ndarray) -> "Answer":
        """Return the answer with its residuals computed for another flow rule or other joint laws.

        ``slope`` defines the flow rule, shape (k,), and ``problem`` the laws. The answer itself is returned
        if neither differs from its own.
        """
        if self.forms == problem.forms and np.array_equal(self.slope, slope):
            return self
        return certified(problem, self.load_factor, self.q, self.d, slope)


def certified(
    problem: Problem, load_factor: float, q: np.ndarray, d: np.ndarray, slope: np.ndarray | None = None
) -> Answer:
    """Return an answer that consists of a given state and its residuals under a given flow rule.

    See :func:`certify` for the parameters. By default, the flow rule is that of the joints at the forces q.
    Residuals of the certificate are relative to median weights and total loads, so they hide errors on a very
    light block. If a light block carries the live load, however, this block alone determines λ. Therefore the
    answer has additional residuals, relative to the forces on each block and each joint.
    """
    slope = problem.dilatancy_at(problem.normal_forces(q)) if slope is None else slope
    certificate = certify(problem, load_factor, q, d, slope)
    unbalanced = problem.unbalanced(load_factor, q)
    live_work = float(problem.live @ d)
    unbalanced_work = float(np.abs(unbalanced * d).sum())
    acting = largest_acting(problem, load_factor, q)
    divisor = problem.load_factor_scale.divisor(load_factor)
    residuals = {
        **certificate.as_dict(),
        "complementarity": certificate.complementarity / divisor,
        # The work of the live load may be zero if all entries of the live load are below the tolerance of the
        # solver. The residual is then infinite.
        "work": unbalanced_work / live_work / divisor if live_work > 0 else inf,
        "block": float(unbalanced_shares(problem, unbalanced, acting).max()),
        "joint": float(violation_shares(problem, problem.slacks(q), acting).max(initial=0.0)),
    }
    return Answer(
        load_factor=float(load_factor) + 0.0,  # turns −0.0 into 0.0
        q=q,
        d=d,
        slope=slope,
        forms=problem.forms,
        certificate=certificate,
        residuals=residuals,
    )


class Existence(StrEnum):
    """Statements about the existence of a collapse load factor λ ≥ 0 with the joints' own flow rule.

    In this flow rule, the opening rate of a sliding joint is its dilatancy times its slip rate.
    """

    NO_MECHANISM = "no load factor exists: the live load does no positive work in any mechanism"
    #: In every mechanism, the joints that move cannot all be at yield in one state of equilibrium.
    NO_STATE = "no load factor exists: no mechanism is compatible with a state of equilibrium"
    UNBOUNDED = "undecided: every multiple of the live load can be carried, but a mechanism exists"
    UNDECIDED = (
        "undecided: a mechanism exists, and no forces were found that carry every multiple of the live load"
    )

    @property
    def proven(self) -> bool:
        """True if it is proven that no load factor λ ≥ 0 exists."""
        return self in (Existence.NO_MECHANISM, Existence.NO_STATE)


@dataclass(frozen=True)
class InfeasibilityCertificate:
    """Proof that no load factor exists, or forces that show how every multiple of the live load is carried.

    Both have residuals, which are computed from the matrices alone.

    Attributes
    ----------
    existence: statement on the existence of a load factor.
    equilibrium, yield_: residuals of forces that carry the live load alone within the true friction without
        cohesion. If no mechanism exists, the forces stay within the joints' own dilatancy.
        None if no such forces exist.
    clamped: indices of the joints in self-stress, the most stressed first. Indices refer to joints of the
        problem; in a result they are rows of ``Result.joints``. The self-stress is the sum of two sets of
        forces, which carry the live load and the opposite of the live load.
    static_cuts: number of sets of faces that cannot all be at yield in one state.
    kinematic_cuts: number of sets of faces of another kind: at least one face of each set must have a nonzero
        rate. Together with the static cuts they exclude every choice of faces with nonzero rates.
    cut_residual: largest residual of the multipliers that exclude these sets.
    """

    existence: Existence
    equilibrium: float | None = None
    yield_: float | None = None
    clamped: tuple[int, ...] = ()
    static_cuts: int = 0
    kinematic_cuts: int = 0
    cut_residual: float = 0.0

    __repr__ = brief

    @property
    def proven(self) -> bool:
        """True if it is proven that no collapse load factor λ ≥ 0 exists with the joints' own flow rule.

        The joints' own flow rule has the dilatancy of the scene. In associative flow the dilatancy equals
        the friction.
        """
        return self.existence.proven

    def as_dict(self) -> dict[str, Any]:
        """Return all attributes and ``proven`` as a dictionary, keyed by the names that reports use."""
        own = {"clamped": list(self.clamped), "existence": str(self.existence), "proven": self.proven}
        return {name.rstrip("_"): value for name, value in asdict(self).items()} | own


def ray_residuals(
    problem: Problem, q: np.ndarray, slope: np.ndarray, motionless: np.ndarray | bool = False
) -> tuple[float, float]:
    """Return the residuals of joint forces q that carry the live load alone, if cohesion is ignored.

    The residuals are those of B q + f_L = 0 and of C(slope) q ≥ 0, each divided by Σ|f_L|. The joint forces q
    have shape (3c + t,). The second condition is not tested for the faces (yield conditions) for which
    ``motionless``, shape (faces,), is True.
    """
    equilibrium = float(np.abs(problem.B @ q + problem.live).max())
    violation = np.where(motionless, 0.0, -(problem.C(slope) @ q))
    return equilibrium / problem.live_norm, float(violation.max(initial=0.0)) / problem.live_norm


def kinematic_residual(problem: Problem, q: np.ndarray, motionless: np.ndarray) -> float:
    """Return the residual of a proof that at least one of the given faces must have a nonzero rate.

    The proof is valid for mechanisms in which the live load does positive work. The given faces (yield
    conditions) are those for which ``motionless``, shape (faces,), is True. A residual of zero proves that
    f_L·d ≤ 0 in every mechanism in which the rates of all given faces are zero. The residual is the larger
    value of :func:`ray_residuals` with the joints' own flow rule.
    """
    return max(ray_residuals(problem, q, problem.dilatancy, motionless))


def static_residual(problem: Problem, d: np.ndarray, p: np.ndarray, at_yield: np.ndarray) -> float:
    """Return the residual of a proof that given yield conditions cannot all be active in a state with λ ≥ 0.

    The given yield conditions are the faces for which ``at_yield`` (faces,) is True. The proof is a motion d
    (3b,) with rates p (faces,) that satisfies three conditions: Bᵀd = C(μ)ᵀp, p ≥ 0 on all other faces, and
    f_L·d ≥ 0. The residual is the largest violation of a condition, divided by the energy f_D·d − c·p that
    the motion gains. The residual is infinite if the motion gains no energy.
    """
    gain = float(problem.dead @ d - problem.face_cohesion @ p)
    if not gain > 0:
        return inf
    departure = float(np.abs(problem.departure(d, p, problem.friction)).max())
    backwards = float(np.where(at_yield, 0.0, -p).max(initial=0.0))
    against = max(0.0, -float(problem.live @ d) / problem.live_norm)
    return max(departure, backwards, against) / gain
