"""Record of a proof by products: a sum of products of static and kinematic forms that bounds λ from below.

The relaxation :class:`~masonry_opt.models.pyomo_products.PyomoProducts` explains the forms and its unknowns.
In every collapse state with λ₀ ≤ λ ≤ Λ, each product of a static and a kinematic form is zero, or at least
zero. Multipliers of the products satisfy the identity

    λ = bound + Σ multiplier · static form · kinematic form
              + Σ coefficient · static unknown · kinematic unknown.

In the last sum, each product of unknowns is zero by complementarity, or neither the product nor its
coefficient is negative. Therefore no collapse state has a load factor between λ₀ and the bound.
"""

from dataclasses import dataclass

import numpy as np

from masonry_opt.brief import brief

#: Names of the kinds of static forms, in the symbols of ``PyomoProducts``:
#:
#: - "one": the constant 1
#: - "load factor": λ
#: - "force": x₂, x₃ or z₀ of a joint, with index 3 · joint + 0, 1 or 2
#: - "other slack": z₁ = 2 (c + μ n) − z₀ of a joint
#: - "margin": n̂ − n of a joint
#: - "load margin": Λ − λ
#: - "load excess": λ − λ₀
#: - "equilibrium": a row of B q + λ f_L + f_D, which is zero
STATIC_FACTORS = (
    *("one", "load factor", "force", "other slack", "margin"),
    *("load margin", "load excess", "equilibrium"),
)

#: Names of the kinds of kinematic forms, in the symbols of ``PyomoProducts``:
#:
#: - "one": the constant 1
#: - "rate": u₂, u₃, p₀ or p₁ of a joint, with index 4 · joint + 0, 1, 2 or 3
#: - "velocity": an entry of d
#: - "opening": the opening of an edge of a joint, with the index of its rate u₂ or u₃
#: - "compatibility": an equation of a joint, with index 3 · joint + 0 or 1 for the edges, and + 2 for slip
#: - "live work": f_L·d − Σ|f_L|, which is zero
KINEMATIC_FACTORS = ("one", "rate", "velocity", "opening", "compatibility", "live work")


@dataclass(frozen=True, eq=False)
class NormalLimit:
    """Upper bound on the normal force of a joint, for all admissible forces with λ in a given range.

    The range is from λ₀ to Λ of :class:`ProductRelaxation`. The multipliers are a motion with
    Bᵀd − Nᵀ = C(μ)ᵀp and p ≥ 0. Every state of equilibrium satisfies n ≤ c·p − f_D·d − λ f_L·d.
    """

    joint: int  #: index of the joint
    value: float  #: upper bound on the normal force n
    d: np.ndarray  #: multiplier of each equation of equilibrium, shape (3b,)
    p: np.ndarray  #: multiplier of each yield condition, shape (faces,)

    __repr__ = brief


@dataclass(frozen=True, eq=False)
class ProductRelaxation:
    """Products of static and kinematic forms, with the multipliers that prove a lower bound on λ."""

    lowest: float  #: λ₀, zero or a load factor up to which earlier products exclude all states
    highest: float  #: Λ, a load factor slightly above the lowest known load factor
    limits: tuple[NormalLimit, ...]  #: upper bound n̂ on the normal force of each joint
    #: Static form of each product: the position of its kind in ``STATIC_FACTORS``, and its index as defined
    #: there. Shape (products, 2).
    static: np.ndarray
    #: Kinematic form of each product: the position of its kind in ``KINEMATIC_FACTORS``, and its index as
    #: defined there. Shape (products, 2).
    kinematic: np.ndarray
    multipliers: np.ndarray  #: multiplier of each product, shape (products,)
    #: Correction that is added to each multiplier, to reduce the multiplier's rounding error, shape
    #: (products,). Without corrections, the bound would be valid only for smaller motions.
    corrections: np.ndarray

    __repr__ = brief
