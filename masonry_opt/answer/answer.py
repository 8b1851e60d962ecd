"""A state and its certificate, made together: what methods hand on and results show; proofs that there is no
load factor. Residuals are of matrices alone, never of a solver."""

from dataclasses import asdict, dataclass
from enum import StrEnum
from math import inf
from typing import Any

import numpy as np
import scipy.sparse as sp

from masonry_opt.answer.acceptance import LIMITS, SMALLEST, Kind, over_load_factor
from masonry_opt.problem.laws import BY_FACES, Forms
from masonry_opt.problem.problem import Of, Problem

#: Forces below this share of the live load at collapse do not matter, whatever acts on their block.
_NO_MATTER = 1e-4


@dataclass(frozen=True)
class Certificate:
    """Residuals of a load factor λ, joint forces q and block velocities d; zero is exact.

    Attributes
    ----------
    equilibrium: largest entry of B q + λ f_L + f_D, over the total dead load.
    yield_: largest violation of the true friction law, of n ≥ 0 or of rocking, as a force in median
        block weights.
    flow: largest departure of Bᵀd from the flow rule, over the largest velocity.
    complementarity: Σ|z p| over the live load's work: energy of what moves without being at yield,
        in units of λ. (For associative flow: by how much λ can be off.) Where friction exceeds one, and what
        sliding opens, slacks of sliding are counted as normal forces.
    """

    equilibrium: float
    yield_: float
    flow: float
    complementarity: float

    def as_dict(self) -> dict[str, float]:
        """The four residuals by the names used in reports."""
        return {name.rstrip("_"): value for name, value in asdict(self).items()}

    @property
    def worst(self) -> float:
        """The largest of the four."""
        return max(self.as_dict().values())


def certify(
    problem: Problem, load_factor: float, q: np.ndarray, d: np.ndarray, slope: np.ndarray
) -> Certificate:
    """Residuals of joint forces q (3c,) and block velocities d (3b,) under a flow rule, which demands the
    slope (k,), opening per unit slip, of joints that can slide: μ if associative, tan φ₀ for their own."""
    total_dead = problem.force_sizes(problem.dead).sum() or problem.live_norm
    z, p = problem.slacks(q), problem.rates(d, slope)
    # With μ = 1e6 slip of 1e-14, rounding, would waste 1e-8 of a force.
    steep = problem.steep / np.maximum(problem.limit_factors @ slope, 1.0)
    live_work = float(problem.live @ d) or problem.live_norm
    return Certificate(
        equilibrium=float(np.abs(problem.unbalanced(load_factor, q)).max() / total_dead),
        yield_=max(0.0, -float(z.min())),
        flow=float(np.abs(problem.departure(d, p, slope)).max() / (np.abs(d).max() or 1.0)),
        complementarity=problem.energy(q, p / steep) / abs(live_work),
    )


def largest_acting(problem: Problem, load_factor: float, q: np.ndarray) -> np.ndarray:
    """Largest force (a load, n or s) that acts on each block, or the least that matters, shape (b,)."""
    loads = np.abs(problem.dead) + abs(load_factor * problem.live)
    loads = problem.forces(loads).max(axis=1)
    at_joints = np.abs([problem.normal_forces(q), *problem.shears(q)]).max(axis=0)
    carried, (block, joint) = np.zeros(problem.blocks), problem.matrices.ends.nonzero()
    np.maximum.at(carried, block, at_joints[joint])
    if problem.matrices.limited:
        limited = abs(problem.matrices.of_limited @ sp.diags_array(problem.of_forces(q)))
        held = problem.forces(limited.max(axis=1).toarray()).max(axis=1)
        carried = np.maximum(carried, held)
    least = _NO_MATTER * max(abs(load_factor), SMALLEST) * problem.live_norm
    return np.maximum(np.maximum(loads, carried), least)


def of_lesser_block(problem: Problem, acting: np.ndarray) -> np.ndarray:
    """Of each joint, the largest force on that of its movable blocks that carries less, shape (c,)."""
    lesser, (block, joint) = np.full(problem.joints, inf), problem.matrices.ends.nonzero()
    np.minimum.at(lesser, joint, acting[block])
    return lesser


@dataclass(frozen=True, eq=False, kw_only=True)
class Found:
    """Forces and velocities that a method ended with, without a load factor; None where it found none."""

    q: np.ndarray | None = None  #: joint forces, shape (3c,)
    d: np.ndarray | None = None  #: block velocities, shape (3b,)
    #: Opening per unit slip under the flow rule of the velocities, shape (k,).
    slope: np.ndarray | None = None
    forms: Forms = BY_FACES  #: by which laws friction and strength limited them


@dataclass(frozen=True, eq=False, kw_only=True)
class Answer(Found):
    """A load factor with its forces and mechanism, and what they leave of every condition. Made by
    :func:`certified` alone: each state has one certificate."""

    load_factor: float
    q: np.ndarray
    d: np.ndarray
    slope: np.ndarray
    certificate: Certificate  #: residuals of the scene as a whole
    residuals: dict[str, float]  #: everything that the limits of acceptance are for

    def failing(self, kind: Kind) -> dict[str, float | None]:
        """Residuals that exceed the limits of a kind of answer."""
        return LIMITS[kind].failing(self.residuals)

    @property
    def exact(self) -> bool:
        """Whether it is an exact state."""
        return not self.failing(Kind.EXACT)

    def certified_by(self, problem: Problem, slope: np.ndarray) -> "Answer":
        """Return the state under a flow rule (k,) and a problem's laws, itself if they are its own."""
        if self.forms == problem.forms and np.array_equal(self.slope, slope):
            return self
        return certified(problem, self.load_factor, self.q, self.d, slope)


def certified(
    problem: Problem, load_factor: float, q: np.ndarray, d: np.ndarray, slope: np.ndarray | None = None
) -> Answer:
    """A state under a flow rule, by default the joints' own at these forces; parameters are of ``certify``.

    The certificate is relative to median weights and total loads, in which a very light block disappears.
    Where it carries the live load it sets λ alone: hence the residuals block by block.
    """
    slope = problem.dilatancy_at(problem.normal_forces(q)) if slope is None else slope
    certificate = certify(problem, load_factor, q, d, slope)
    unbalanced, work = problem.unbalanced(load_factor, q), float(problem.live @ d)
    acting, wasted = largest_acting(problem, load_factor, q), float(np.abs(unbalanced * d).sum())
    # Of moments the forces that they are at the block's longest arm.
    forces = np.abs(problem.forces(unbalanced)).max(axis=1) / acting
    moments = np.abs(problem.moments(unbalanced)).max(axis=1) / (acting * problem.matrices.longest_arm)
    z, at_joints = problem.slacks(q), of_lesser_block(problem, acting)[problem.face_joint]
    violation = float((-z[: len(at_joints)] / at_joints).max())
    beyond_limits = float(-z[problem.table.limits].min(initial=inf) / acting.min())
    residuals = {
        **certificate.as_dict(),
        "complementarity": over_load_factor(certificate.complementarity, load_factor),
        # A live load that drives nothing: its entries are below what the solver takes for zero.
        "work": over_load_factor(wasted / work, load_factor) if work > 0 else inf,
        "block": float(np.maximum(forces, moments).max()),
        "joint": max(violation, beyond_limits, 0.0),
    }
    return Answer(
        load_factor=float(load_factor) + 0.0,  # no minus before a zero
        q=q,
        d=d,
        slope=slope,
        forms=problem.forms,
        certificate=certificate,
        residuals=residuals,
    )


class Existence(StrEnum):
    """What is proven of a load factor λ ≥ 0 at which blocks move under the joints' own flow rule."""

    NO_MECHANISM = "none exists: no mechanism lets the live load do work"
    NO_STATE = "none exists: no mechanism goes with a state of equilibrium"  #: faces never yield together
    UNBOUNDED = "not decided: statics carry any multiple of the live load, and a mechanism exists"
    UNDECIDED = "not decided: a mechanism exists, and no forces carry every multiple of the live load"

    @property
    def proven(self) -> bool:
        """Whether it is proven that no such load factor exists."""
        return self in (Existence.NO_MECHANISM, Existence.NO_STATE)


@dataclass(frozen=True)
class InfeasibilityCertificate:
    """Proof that no load factor exists, or the forces that leave it unbounded, with residuals; zero is exact.

    Attributes
    ----------
    existence: what is proven.
    equilibrium, yield_: :func:`ray_residuals` of forces that carry the live load alone within the true
        friction without cohesion (where there is no mechanism: within the joints' own dilatancy). None
        without such forces.
    clamped: joints in self-stress, by their numbers in the problem, of a result by those in
        ``Result.joints``, the most stressed first: other forces carry the opposite of the live load, and the
        sum of both balances itself.
    static_cuts, kinematic_cuts: numbers of sets of faces that cannot come to yield together, and of sets of
        which one face must move. Together they leave no choice of moving faces.
    cut_residual: the largest :func:`static_residual` or :func:`kinematic_residual` of these sets.
    """

    existence: Existence
    equilibrium: float | None = None
    yield_: float | None = None
    clamped: tuple[int, ...] = ()
    static_cuts: int = 0
    kinematic_cuts: int = 0
    cut_residual: float = 0.0

    proven = Of[bool]("existence")  #: whether no load factor λ ≥ 0 exists under the joints' own flow rule

    def as_dict(self) -> dict[str, Any]:
        """Everything by the names used in reports, and whether it is a proof."""
        own = {"clamped": list(self.clamped), "existence": str(self.existence), "proven": self.proven}
        return {name.rstrip("_"): value for name, value in asdict(self).items()} | own


def ray_residuals(
    problem: Problem, q: np.ndarray, slope: np.ndarray, still: np.ndarray | bool = False
) -> tuple[float, float]:
    """Residuals of B q + f_L = 0 and, on all faces but those ``still`` (faces,), of C(slope) q ≥ 0, as forces
    over Σ|f_L|, for joint forces q (3c,)."""
    equilibrium = float(np.abs(problem.B @ q + problem.live).max())
    violation = np.where(still, 0.0, -(problem.C(slope) @ q))
    return equilibrium / problem.live_norm, float(violation.max(initial=0.0)) / problem.live_norm


def kinematic_residual(problem: Problem, q: np.ndarray, still: np.ndarray) -> float:
    """The larger of :func:`ray_residuals` under the joints' own flow rule: zero shows that f_L·d ≤ 0 unless
    one of the faces ``still`` (faces,) moves."""
    return max(ray_residuals(problem, q, problem.dilatancy, still))


def static_residual(problem: Problem, d: np.ndarray, p: np.ndarray, held: np.ndarray) -> float:
    """Residual of Bᵀd = C(μ)ᵀp, of p ≥ 0 on all faces but those ``held`` at yield (faces,), and of f_L·d ≥ 0,
    for a motion d (3b,) with rates p (faces,), over the energy f_D·d − c·p that it gains: zero shows that no
    state with λ ≥ 0 brings these faces to yield together. Infinite if it gains none."""
    gain = float(problem.dead @ d - problem.face_cohesion @ p)
    if not gain > 0:
        return inf
    departure = float(np.abs(problem.departure(d, p, problem.friction)).max())
    backwards = float(np.where(held, 0.0, -p).max(initial=0.0))
    against = max(0.0, -float(problem.live @ d) / problem.live_norm)
    return max(departure, backwards, against) / gain
