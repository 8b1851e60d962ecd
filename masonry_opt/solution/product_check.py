"""Lower bound on λ that multipliers of products prove, computed in exact arithmetic.

The bound is computed from the matrices of the problem, without code of the model that finds the multipliers.
The search for a proof also uses this module, to refine the multipliers.
:mod:`masonry_opt.solution.products` defines the products.
"""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import scipy.sparse as sp

from masonry_opt.problem.problem import Problem
from masonry_opt.solution.products import KINEMATIC_FACTORS, STATIC_FACTORS, ProductRelaxation

#: Linear form with exact coefficients: a dictionary from the index of each unknown to its coefficient.
ExactForm = dict[int, Fraction]

#: Kinds of static forms that are at least zero in every collapse state.
_NONNEGATIVE_STATICS = set(STATIC_FACTORS) - {"equilibrium"}

#: Kinds of kinematic forms that are at least zero in every collapse state.
_NONNEGATIVE_KINEMATICS = {"one", "rate", "opening"}

_ZERO = Fraction(0)


class InvalidProduct(Exception):
    """Error that is raised if a product of a proof may be negative, or has an invalid index."""


@dataclass(frozen=True)
class ProductBound:
    """Lower bound on λ that products prove. A bound that is valid for larger motions is lower."""

    value: Fraction  #: lower bound on λ before any ``decrease`` is subtracted
    #: Decrease of the lower bound if the sum of all velocities and rates grows by the mean velocity of the
    #: live load. It is zero if the multipliers have no rounding errors.
    decrease: Fraction

    def up_to(self, reach: float) -> Fraction:
        """Return the lower bound on λ if the sum of velocities and rates is at most ``reach``."""
        return self.value - Fraction(reach) * self.decrease


class ProductChecker:
    """Checker of a proof: multiplies out products of static and kinematic forms in exact arithmetic.

    The static unknowns are x₂, x₃ and z₀ of each joint, then λ, then 1. The kinematic unknowns are u₂, u₃,
    p₀ and p₁ of each joint, then d, then 1.
    """

    def __init__(self, problem: Problem, products: ProductRelaxation) -> None:
        self._products = products
        joints = self._joints = problem.joints
        self._load_factor, self._static_one = 3 * joints, 3 * joints + 1
        self._first_velocity = 4 * joints
        self._kinematic_one = 4 * joints + problem.B.shape[0]
        self._rows = _entries_of(sp.csr_array(problem.B))
        self._columns = _entries_of(sp.csr_array(problem.B.T))
        self._friction, self._cohesion, self._dilatancy = (
            [Fraction(value) for value in values.tolist()]
            for values in (problem.friction, problem.cohesion, problem.dilatancy)
        )
        self._dead, self._live = (
            [Fraction(value) for value in load.tolist()] for load in (problem.dead, problem.live)
        )
        self._live_norm = Fraction(problem.live_norm)
        self._lowest, self._highest = Fraction(products.lowest), Fraction(products.highest)
        self._limit = {limit.joint: Fraction(limit.value) for limit in products.limits}

    def coefficients(self) -> dict[tuple[int, int], Fraction]:
        """Return the coefficients of λ − Σ multiplier · static form · kinematic form, multiplied out.

        The keys are pairs of a static and a kinematic unknown, and the values are the coefficients of their
        product. Raise InvalidProduct if a product has a multiplier that it may not have, and KeyError if a
        joint has no limit on its normal force.
        """
        coefficients: dict[tuple[int, int], Fraction] = defaultdict(Fraction)
        coefficients[self._load_factor, self._kinematic_one] = Fraction(1)
        for multiplier, statics, motion in self._products_with_forms():
            for i, a in statics.items():
                of_unknown = multiplier * a
                for k, b in motion.items():
                    coefficients[i, k] -= of_unknown * b
        return coefficients

    def bound(self) -> ProductBound:
        """Return the lower bound on λ that the multipliers prove.

        Raise InvalidProduct or KeyError as :meth:`coefficients` does.
        """
        coefficients = self.coefficients()
        value = coefficients.pop((self._static_one, self._kinematic_one), _ZERO)
        of_load_factor = coefficients.pop((self._load_factor, self._kinematic_one), _ZERO)
        by_motion: dict[int, Fraction] = defaultdict(Fraction)
        for (i, k), coefficient in coefficients.items():
            is_velocity = self._first_velocity <= k < self._kinematic_one
            shortfall = abs(coefficient) if is_velocity else max(-coefficient, _ZERO)
            if shortfall and not self._is_at_rest(i, k):
                by_motion[k] += shortfall * self._largest(i)
        value -= by_motion.pop(self._kinematic_one, _ZERO)
        value += min(of_load_factor * self._lowest, of_load_factor * self._highest)
        # ``reach`` limits the rates of rocking. The openings u₂ and u₃ are twice these rates.
        decreases = (
            2 * own if k < self._first_velocity and k % 4 < 2 else own for k, own in by_motion.items()
        )
        return ProductBound(value, max(decreases, default=_ZERO))

    def _products_with_forms(self) -> Iterator[tuple[Fraction, ExactForm, ExactForm]]:
        """Check each product, and yield its multiplier, static form and kinematic form."""
        products = self._products
        static_forms: dict[tuple[int, int], ExactForm] = {}
        kinematic_forms: dict[tuple[int, int], ExactForm] = {}
        table = (products.static, products.kinematic, products.multipliers, products.corrections)
        for first, second, rounded, correction in zip(*(array.tolist() for array in table), strict=True):
            statics, motion = tuple(first), tuple(second)
            multiplier = Fraction(rounded) + Fraction(correction)
            self._refuse_invalid(STATIC_FACTORS[statics[0]], statics[1], motion, multiplier)
            if statics not in static_forms:
                static_forms[statics] = self._static_form(STATIC_FACTORS[statics[0]], statics[1])
            if motion not in kinematic_forms:
                kinematic_forms[motion] = self._kinematic_form(KINEMATIC_FACTORS[motion[0]], motion[1])
            yield multiplier, static_forms[statics], kinematic_forms[motion]

    def _refuse_invalid(
        self, statics: str, index: int, motion: tuple[int, int], multiplier: Fraction
    ) -> None:
        """Raise InvalidProduct unless a product is always zero, or never negative with a multiplier ≥ 0."""
        kinematics = KINEMATIC_FACTORS[motion[0]]
        is_equation = statics == "equilibrium" or kinematics in ("compatibility", "live work")
        is_complementary = (statics, kinematics, motion[1]) == ("other slack", "rate", 4 * index + 3)
        if is_equation or is_complementary:
            return
        is_nonnegative = statics in _NONNEGATIVE_STATICS and kinematics in _NONNEGATIVE_KINEMATICS
        if kinematics == "opening" and self._dilatancy[_checked(motion[1] // 4, self._joints)] < 0:
            is_nonnegative = False
        if multiplier < 0 or not is_nonnegative:
            raise InvalidProduct(
                f"the product of '{statics}' and '{kinematics}', times its multiplier, can be negative"
            )

    def _static_form(self, name: str, index: int) -> ExactForm:
        """Return the static form of a given kind and index, as defined at ``STATIC_FACTORS``."""
        one, load_factor, joints = self._static_one, self._load_factor, self._joints
        if name == "equilibrium":
            return self._equilibrium(_checked(index, len(self._rows)))
        if name == "force":
            return {_checked(index, 3 * joints): Fraction(1)}
        edges = (3 * _checked(index, joints), 3 * index + 1)
        forms: dict[str, ExactForm] = {
            "one": {one: Fraction(1)},
            "load factor": {load_factor: Fraction(1)},
            "other slack": {
                **dict.fromkeys(edges, 2 * self._friction[index]),
                3 * index + 2: Fraction(-1),
                one: 2 * self._cohesion[index],
            },
            "margin": {**dict.fromkeys(edges, Fraction(-1)), one: self._limit[index]},
            "load margin": {load_factor: Fraction(-1), one: self._highest},
            "load excess": {load_factor: Fraction(1), one: -self._lowest},
        }
        return forms[name]

    def _equilibrium(self, row: int) -> ExactForm:
        """Return a row of B q + λ f_L + f_D as a linear form in the static unknowns.

        The shear force of a joint is s = c + μ (x₂ + x₃) − z₀.
        """
        form: ExactForm = defaultdict(Fraction)
        form[self._load_factor] += self._live[row]
        form[self._static_one] += self._dead[row]
        for column, entry in self._rows[row]:
            kind, joint = divmod(column, self._joints)
            if kind < 2:
                form[3 * joint + kind] += entry
                continue
            form[3 * joint] += entry * self._friction[joint]
            form[3 * joint + 1] += entry * self._friction[joint]
            form[3 * joint + 2] -= entry
            form[self._static_one] += entry * self._cohesion[joint]
        return form

    def _kinematic_form(self, name: str, index: int) -> ExactForm:
        """Return the kinematic form of a given kind and index, as defined at ``KINEMATIC_FACTORS``."""
        if name == "one":
            return {self._kinematic_one: Fraction(1)}
        if name == "rate":
            return {_checked(index, self._first_velocity): Fraction(1)}
        if name == "velocity":
            velocities = self._kinematic_one - self._first_velocity
            return {self._first_velocity + _checked(index, velocities): Fraction(1)}
        if name == "live work":
            work = {self._first_velocity + e: live for e, live in enumerate(self._live) if live}
            return {**work, self._kinematic_one: -self._live_norm}
        if name == "opening":
            joint, edge = divmod(index, 4)
            if edge > 1:
                raise InvalidProduct("the index of an opening must be that of u₂ or u₃ of a joint")
            return self._motion(_checked(joint, self._joints), edge)
        joint, kind = divmod(index, 3)
        form = self._motion(_checked(joint, self._joints), kind)
        first, second = 4 * joint + 2, 4 * joint + 3
        if kind == 2:
            return {**form, first: Fraction(1), second: Fraction(-1)}
        dilatancy = self._dilatancy[joint]
        return {**form, 4 * joint + kind: Fraction(-1), first: -dilatancy, second: -dilatancy}

    def _motion(self, joint: int, kind: int) -> ExactForm:
        """Return an edge opening (``kind`` 0 or 1) or the slip (2) as a linear form in the velocities."""
        column = self._columns[kind * self._joints + joint]
        return {self._first_velocity + row: entry for row, entry in column}

    def _is_at_rest(self, i: int, k: int) -> bool:
        """Return True if complementarity requires that static unknown i times kinematic unknown k is zero.

        These products are x₂u₂, x₃u₃ and z₀p₀ of a joint.
        """
        joint, kind = divmod(i, 3)
        return i < self._load_factor and k == 4 * joint + kind

    def _largest(self, i: int) -> Fraction:
        """Return an upper bound on the static unknown with index i."""
        if i >= self._load_factor:
            return self._highest if i == self._load_factor else Fraction(1)
        joint, kind = divmod(i, 3)
        normal = self._limit[joint]
        return normal if kind < 2 else 2 * (self._cohesion[joint] + self._friction[joint] * normal)


def _entries_of(matrix: sp.csr_array) -> list[list[tuple[int, Fraction]]]:
    """Return a list for each row of a matrix: the column and the exact value of each nonzero entry."""
    rows = []
    for start, end in zip(matrix.indptr[:-1].tolist(), matrix.indptr[1:].tolist(), strict=True):
        values = map(Fraction, matrix.data[start:end].tolist())
        rows.append(list(zip(matrix.indices[start:end].tolist(), values, strict=True)))
    return rows


def _checked(index: int, count: int) -> int:
    """Return an index, or raise InvalidProduct if it is not below ``count``."""
    if not 0 <= index < count:
        raise InvalidProduct("a product refers to a force, rate or equation that the scene does not have")
    return index


def permits_products(problem: Problem) -> bool:
    """Return True if proofs by products are possible for a problem.

    The scene must be plane. Each joint must be able to slide, with a constant dilatancy, and have no other
    yield conditions than sliding and rocking. No tie, prop or other force with limits may act.
    """
    c = problem.joints
    is_plain = problem.faces == 4 * c and problem.B.shape[1] == 3 * c
    constant = not problem.layout.round and not problem.dilatancy_depends_on_stress
    return bool(is_plain and constant and np.array_equal(problem.sliding, np.arange(c)))
