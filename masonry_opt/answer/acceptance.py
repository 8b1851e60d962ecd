"""When an answer is good enough: one table of limits on residuals, asked once of each answer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from math import inf

import numpy as np

from masonry_opt.answer.certificate import certify
from masonry_opt.problem.problem import Problem


class Kind(StrEnum):
    """Kinds of answer, by what can be demanded of them."""

    #: An optimum of eq. (9) or eq. (10).
    ASSOCIATIVE = "associative"
    #: The loop's: exact forces on a mechanism leave next to nothing (with rough sub-problems up to 1e-3 of
    #: complementarity). Where there are none it keeps its last sub-problem, which turns shear limits about
    #: the normal forces before: a tenth of a block's weight is what the published parameters leave on the
    #: walls of Table 1, and the small cohesion's share, taken off λ and not off the forces, some 1e-4 of
    #: equilibrium and complementarity. Sliding contracts by 10⁻³ μ of its slip by construction, and a slip
    #: may be ten times the largest block velocity: a long block that turns slips at a far joint.
    LOOP = "loop"
    #: The paper's loop, stopped by its own rule and without an exact end: it leaves up to some per cent, and
    #: at a joint that does not slide half of its block's forces, so that yield is limited joint by joint.
    BARE_LOOP = "bare loop"
    #: The one pass's: exact, but for what it leaves of complementarity: some 1e-9 on small scenes, up to 1e-5
    #: on façades, where no mechanism moves only faces that the forces found bring to yield.
    ONE_PASS = "one pass"
    #: The MPEC's: exact, but for what its last relaxation leaves of complementarity (by default some 1e-8).
    RELAXED = "relaxed"
    #: A state of forces and a mechanism that meet every condition to rounding.
    EXACT = "exact"


@dataclass(frozen=True)
class Limits:
    """What an answer's residuals may be at most.

    Attributes
    ----------
    equilibrium, yield_, flow: as the certificate has them.
    complementarity, work: energy of what moves without being at yield, and work of forces out of balance,
        over |λ| (over ``SMALLEST`` at least).
    block: force out of balance on any one block, over the largest that acts on it.
    joint: violation of the true law at any one joint, over the largest force on the lesser of its blocks.
    """

    equilibrium: float
    yield_: float
    flow: float
    complementarity: float
    work: float
    block: float
    joint: float

    def as_dict(self) -> dict[str, float]:
        """The limits by the names that residuals have in reports."""
        return {field.name.rstrip("_"): getattr(self, field.name) for field in fields(self)}

    def failing(self, residuals: Mapping[str, float | None]) -> dict[str, float | None]:
        """Those of the residuals that exceed their limits; one that is missing or no number does too."""
        most = self.as_dict()
        return {name: value for name, value in residuals.items() if value is None or not value <= most[name]}


#: The table. Four digits of λ are those in which published associative load factors agree.
LIMITS: dict[Kind, Limits] = {
    Kind.ASSOCIATIVE: Limits(1e-4, 1e-4, 1e-4, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.LOOP: Limits(1e-3, 0.1, 1e-2, 1e-2, work=5e-2, block=5e-2, joint=0.5),
    Kind.BARE_LOOP: Limits(1e-2, inf, 5e-2, 5e-2, work=5e-2, block=5e-2, joint=1.0),
    Kind.ONE_PASS: Limits(1e-8, 1e-8, 1e-8, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.RELAXED: Limits(1e-6, 1e-6, 1e-6, 1e-4, work=1e-3, block=1e-3, joint=1e-3),
    Kind.EXACT: Limits(1e-8, 1e-8, 1e-8, 1e-8, work=1e-3, block=1e-3, joint=1e-3),
}

#: Of the four answers to an associative problem that ``check`` compares: relative difference of their load
#: factors, and what any of their conditions may leave.
AGREEMENT, DUALITY = 1e-7, 1e-6

#: What decides on the way to an answer, which must meet the table all the same. Energy of what moves without
#: being at yield, over |λ|, up to which the loop's forces and mechanism belong together (else it begins
#: again); and the largest residual with which a sub-problem's state bears its load factor out.
MOST_ENERGY, BORNE_OUT = 1e-3, 1e-3

#: What an inequality that proves that no load factor exists may leave of its conditions: it then holds for
#: all forces, and motions, that are not a hundred million times larger than what the loads and their work
#: measure.
PROOF = 1e-8

#: Relative gap at which a bracket is closed; and how far λ may lie outside of certified bounds: the four
#: digits of the associative limits.
CLOSED, OUTSIDE = 1e-5, 1e-4

#: By how much a state's forces may exceed the limits below which a bound holds, relative and in median block
#: weights; and what a point that certifies a bound may leave of its equations, in units of the load.
BEYOND_LIMITS, FEASIBLE = 1e-6, 1e-11

#: That a scene stands, in median block weights. Forces of another scene show it with this room inside yield,
#: and this much out of balance: far less than the room, so that forces that leave nothing are near.
ROOM, UNBALANCED = 1e-5, 1e-8

#: Energy, in median block weights, that forces and mechanism of a margin under dead load may be apart: what
#: the margin may be off by.
MARGIN_ENERGY = 1e-4

#: Load factors below this are judged, and compared with each other, as if they were this large.
SMALLEST = 1e-2

#: Forces below this share of the live load at collapse do not matter, whatever acts on their block.
_NO_MATTER = 1e-4


def over_load_factor(complementarity: float | None, load_factor: float) -> float | None:
    """The certificate's complementarity as a share of |λ|."""
    return None if complementarity is None else complementarity / max(abs(load_factor), SMALLEST)


def residuals(
    problem: Problem,
    load_factor: float,
    q: np.ndarray,
    d: np.ndarray,
    slope: np.ndarray,
    by_parabola: bool = False,
) -> dict[str, float]:
    """Everything that ``Limits`` limit, of an answer under a flow rule (see :func:`~.certificate.certify`).

    The certificate measures forces in median weights and total loads, in which a block very much lighter
    than the others disappears. If it carries the live load, λ is its alone: hence each block for itself.
    """
    left = _of_certificate(problem, load_factor, q, d, slope, by_parabola)
    unbalanced = problem.unbalanced(load_factor, q)
    work, scale = float(problem.live @ d), max(abs(load_factor), SMALLEST)
    acting = largest_acting(problem, load_factor, q)
    wasted = float(np.abs(unbalanced * d).sum())
    return {
        **left,
        # A live load that drives nothing: its entries are below what the solver takes for zero.
        "work": wasted / work / scale if work > 0 else inf,
        "block": _balance(problem, unbalanced, acting),
        "joint": _yielding(problem, problem.slacks(q, by_parabola), q, acting),
    }


def passes(
    problem: Problem,
    kind: Kind,
    load_factor: float,
    q: np.ndarray,
    d: np.ndarray,
    slope: np.ndarray,
    by_parabola: bool = False,
) -> bool:
    """Whether an answer is within the limits of a kind; what is soonest computed is asked first."""
    given = load_factor, q, d, slope, by_parabola
    limits = LIMITS[kind]
    return not limits.failing(_of_certificate(problem, *given)) and not limits.failing(
        residuals(problem, *given)
    )


def _of_certificate(
    problem: Problem,
    load_factor: float,
    q: np.ndarray,
    d: np.ndarray,
    slope: np.ndarray,
    by_parabola: bool,
) -> dict[str, float]:
    """The certificate's residuals, complementarity as a share of |λ|."""
    certificate = certify(problem, load_factor, q, d, slope, by_parabola)
    share = certificate.complementarity / max(abs(load_factor), SMALLEST)
    return {**certificate.as_dict(), "complementarity": share}


def largest_acting(problem: Problem, load_factor: float, q: np.ndarray) -> np.ndarray:
    """Largest force (a load, n or s) that acts on each block, or the least that matters, shape (b,)."""
    loads = np.abs(problem.dead) + abs(load_factor * problem.live)
    loads = problem.forces(loads).max(axis=1)
    at_joints = np.abs(problem.by_kind(q)[: problem.layout.dimension]).max(axis=0)
    carried, (block, joint) = np.zeros(problem.blocks), problem.touching
    np.maximum.at(carried, block, at_joints[joint])
    least = _NO_MATTER * max(abs(load_factor), SMALLEST) * problem.live_norm
    return np.maximum(np.maximum(loads, carried), least)


def of_lesser_block(problem: Problem, acting: np.ndarray) -> np.ndarray:
    """Of each joint, the largest force on that of its movable blocks that carries less, shape (c,)."""
    lesser, (block, joint) = np.full(problem.joints, inf), problem.touching
    np.minimum.at(lesser, joint, acting[block])
    return lesser


def _balance(problem: Problem, unbalanced: np.ndarray, acting: np.ndarray) -> float:
    """Largest force out of balance on a block over the largest that acts on it; a moment over that force
    at the longest arm."""
    forces = np.abs(problem.forces(unbalanced)).max(axis=1) / acting
    moments = np.abs(problem.moments(unbalanced)).max(axis=1) / (acting * problem.matrices.longest_arm)
    return float(np.maximum(forces, moments).max())


def _yielding(problem: Problem, z: np.ndarray, q: np.ndarray, acting: np.ndarray) -> float:
    """Largest violation of yield over the largest force on the lesser of a joint's blocks."""
    least = of_lesser_block(problem, acting)
    violation = -z / problem.face_arm / least[problem.face_joint]
    tension = -problem.normal_forces(q) / least
    return float(max(violation.max(), tension.max(), 0.0))
