"""A state and its certificate, of matrices alone, made together: what methods hand on and results show."""

from dataclasses import asdict, dataclass
from math import inf

import numpy as np
import scipy.sparse as sp

from masonry_opt.answer.acceptance import LIMITS, SMALLEST, Kind, over_load_factor
from masonry_opt.problem.laws import BY_FACES, Forms
from masonry_opt.problem.problem import Problem

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
    flow: largest departure of Bᵀd (and what elastic contacts give) from the flow rule, over the largest
        velocity.
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
    z, p = problem.slacks(q), problem.rates(d, slope, q)
    # With μ = 1e6 slip of 1e-14, rounding, would waste 1e-8 of a force.
    steep = problem.steep / np.maximum(problem.limit_factors @ slope, 1.0)
    live_work = float(problem.live @ d) or problem.live_norm
    return Certificate(
        equilibrium=float(np.abs(problem.unbalanced(load_factor, q)).max() / total_dead),
        yield_=max(0.0, -float(z.min())),
        flow=float(np.abs(problem.departure(d, p, slope, q)).max() / (np.abs(d).max() or 1.0)),
        complementarity=problem.energy(q, p / steep) / abs(live_work),
    )


def largest_acting(problem: Problem, load_factor: float, q: np.ndarray) -> np.ndarray:
    """Largest force (a load, n or s) that acts on each block, or the least that matters, shape (b,)."""
    loads = np.abs(problem.dead) + abs(load_factor * problem.live)
    loads = problem.forces(loads).max(axis=1)
    at_joints = np.abs([problem.normal_forces(q), *problem.shears(q)]).max(axis=0)
    carried, (block, joint) = np.zeros(problem.blocks), problem.touching
    np.maximum.at(carried, block, at_joints[joint])
    if problem.matrices.limited:
        limited = abs(problem.matrices.of_limited @ sp.diags_array(problem.of_forces(q)))
        held = problem.forces(limited.max(axis=1).toarray()).max(axis=1)
        carried = np.maximum(carried, held)
    least = _NO_MATTER * max(abs(load_factor), SMALLEST) * problem.live_norm
    return np.maximum(np.maximum(loads, carried), least)


def of_lesser_block(problem: Problem, acting: np.ndarray) -> np.ndarray:
    """Of each joint, the largest force on that of its movable blocks that carries less, shape (c,)."""
    lesser, (block, joint) = np.full(problem.joints, inf), problem.touching
    np.minimum.at(lesser, joint, acting[block])
    return lesser


def _balance(problem: Problem, unbalanced: np.ndarray, acting: np.ndarray) -> float:
    """Largest force out of balance on a block, of a moment at its longest arm, over the largest there."""
    forces = np.abs(problem.forces(unbalanced)).max(axis=1) / acting
    moments = np.abs(problem.moments(unbalanced)).max(axis=1) / (acting * problem.matrices.longest_arm)
    return float(np.maximum(forces, moments).max())


def _yielding(problem: Problem, z: np.ndarray, acting: np.ndarray) -> float:
    """Largest violation of yield over the largest force on the lesser of a joint's blocks."""
    least = of_lesser_block(problem, acting)
    of_joints = slice(len(problem.face_joint))
    violation = -z[of_joints] / least[problem.face_joint]
    limits = -z[problem.table.limits].min(initial=np.inf) / acting.min()
    return float(max(violation.max(), limits, 0.0))


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
    compliance: np.ndarray | None  #: of the contacts under which it was certified, as a problem has it
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
        """The same state under a flow rule, shape (k,), and the contacts and laws of a problem: itself if all
        are its own."""
        same = self.compliance is problem.compliance and self.forms == problem.forms
        if same and np.array_equal(self.slope, slope):
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
    residuals = {
        **certificate.as_dict(),
        "complementarity": over_load_factor(certificate.complementarity, load_factor),
        # A live load that drives nothing: its entries are below what the solver takes for zero.
        "work": over_load_factor(wasted / work, load_factor) if work > 0 else inf,
        "block": _balance(problem, unbalanced, acting),
        "joint": _yielding(problem, problem.slacks(q), acting),
    }
    return Answer(
        load_factor=float(load_factor) + 0.0,  # no minus before a zero
        q=q,
        d=d,
        slope=slope,
        forms=problem.forms,
        compliance=problem.compliance,
        certificate=certificate,
        residuals=residuals,
    )
