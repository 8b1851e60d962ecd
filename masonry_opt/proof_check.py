"""Check of a proof that no collapse state has a lower load factor, independent of the program that found it.

The check uses the matrices of the scene, and no code of the search. (The search uses one part of the check,
the expansion of products in :mod:`masonry_opt.solution.product_check`.) Every conflict and every sum of
products is recomputed in exact arithmetic: floating-point numbers are binary fractions, and so are their sums
and products. Another SAT solver than that of the search decides that no assignment satisfies all clauses.
"""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from pysat.solvers import Glucose4

from masonry_opt.brief import brief
from masonry_opt.errors import OptionError
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.case_file import load
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.product_check import InvalidProduct, ProductChecker, permits_products
from masonry_opt.solution.products import KINEMATIC_FACTORS, STATIC_FACTORS, NormalLimit, ProductRelaxation
from masonry_opt.solution.proof import REACH, EnergyBound, KinematicConflict, Proof, StaticConflict


@dataclass(frozen=True)
class ProofCheck:
    """Result of the check of a proof: the states that the proof excludes, and the faults of the proof.

    Attributes
    ----------
    bound: load factor up to which the proof excludes states.
    faults: one sentence for each fault of the proof; empty if the proof is correct.
    static, kinematic: numbers of static and of kinematic conflicts in the proof.
    products: number of products in the proof.
    reach: limit on the forces and velocities of the excluded states; infinite if there are no residuals.
        The proof excludes all states with λ from 0 to ``bound`` that satisfy two conditions. The sum of the
        forces is at most ``reach`` times the sum of all loads. The sum of the velocities and rates is at most
        ``reach`` times the mean velocity of the live load.
    """

    bound: float
    faults: tuple[str, ...]
    static: int
    kinematic: int
    products: int
    reach: float

    __repr__ = brief

    @property
    def holds(self) -> bool:
        """True if the proof is valid, that is, if the check found no fault."""
        return not self.faults

    def __str__(self) -> str:
        if self.faults:
            return "the proof does NOT hold: " + "; ".join(self.faults)
        parts = []
        if self.products:
            parts.append(f"{self.products} products of a static and a kinematic form")
        if self.static or self.kinematic or not parts:
            parts.append(f"{self.static} static and {self.kinematic} kinematic conflicts of yield conditions")
        return (
            f"proven: no collapse state has a load factor from 0 to {self.bound:.9g}. The proof consists of "
            f"{' and '.join(parts)}, checked in exact arithmetic. It covers all states within two "
            f"limits. The sum of forces is at most {self.reach:.1e} times the sum of loads. The sum of "
            f"velocities and rates is at most {self.reach:.1e} times the mean velocity of the live load"
        )


def check_proof(scene: Scene | str | Path, proof: Proof | str | Path | None) -> ProofCheck:
    """Check that no collapse state of a plane scene has a load factor from 0 to the bound of a proof.

    Parameters
    ----------
    scene: a scene, or the path of a case file.
    proof: a proof, or the path of a file that ``Proof.save`` wrote.

    Returns
    -------
    ProofCheck
        The faults of the proof, and the states that it excludes. Its property ``holds`` is True if there is
        no fault.

    Raises
    ------
    CaseError
        If the scene is wrong, or the file is no proof.
    OptionError
        If ``proof`` is None, as in a result without a proof.
    """
    if proof is None:
        raise OptionError(
            "there is no proof to check: 'result.proof' is None if the analysis found no proof; "
            "mo.prove_least searches longer for a proof than mo.solve"
        )
    problem = assemble(scene if isinstance(scene, Scene) else load(scene)).problem
    return check(problem, proof if isinstance(proof, Proof) else Proof.load(proof))


def check(problem: Problem, proof: Proof) -> ProofCheck:
    """Check a proof against the matrices of a problem, and return the result."""
    faults = _faults_of_form(problem, proof)
    reach = float("inf")
    if not faults:
        checker = _Checker(problem, proof)
        faults, reach = checker.faults(), checker.reach
        if not faults and not checker.reaches_bound and _is_satisfiable(proof):
            faults = ["the clauses do not exclude all states, because an assignment satisfies all clauses"]
    kinds = [isinstance(conflict, StaticConflict) for conflict in proof.conflicts]
    numbers = sum(kinds), len(kinds) - sum(kinds), proof.product_count
    return ProofCheck(proof.bound, tuple(faults), *numbers, reach)


def _faults_of_form(problem: Problem, proof: Proof) -> list[str]:
    """Return a list with the first fault in the form of a proof, or [] if the form is correct.

    The form is faulty if the proof is malformed, or if it does not match the scene of the problem.
    """
    if problem.layout.round or problem.dilatancy_depends_on_stress:
        return ["proofs exist only for plane scenes whose dilatancy does not depend on stress"]
    if not 0 < proof.bound < proof.load_factor:
        return [f"the bound {proof.bound:.9g} is not between 0 and the load factor {proof.load_factor:.9g}"]
    height, width = problem.B.shape
    if proof.conditions != problem.faces:
        return [f"the proof has {proof.conditions} yield conditions, but the scene has {problem.faces}"]
    arrays = [(np.asarray(proof.senses, dtype=float).ravel(), 2 * len(proof.senses))]
    indices = [proof.senses.ravel()]
    limits = tuple(limit for step in proof.relaxations for limit in step.limits)
    for item in (*proof.conflicts, *proof.energy_bounds, *limits):
        if isinstance(item, KinematicConflict):
            arrays.append((np.append(item.q, [item.load_factor, item.weight]), width + 2))
        else:
            arrays += [(item.d, height), (item.p, problem.faces)]
        if not isinstance(item, NormalLimit):
            own = item.condition if isinstance(item, EnergyBound) else item.conditions
            indices.append(np.atleast_1d(own))
    for step in proof.relaxations:
        arrays += [(array, len(step.multipliers)) for array in (step.multipliers, step.corrections)]
    if any(array.shape != (size,) or not np.isfinite(array).all() for array, size in arrays):
        return ["some multipliers of the proof are missing, or are not finite numbers"]
    every = np.concatenate(indices)
    if len(every) and (every.min() < 0 or every.max() >= problem.faces):
        return ["the proof refers to a yield condition that the scene does not have"]
    return _faults_of_products_form(problem, proof)


def _faults_of_products_form(problem: Problem, proof: Proof) -> list[str]:
    """Return a list with the first fault in the data of the products of a proof, or []."""
    if not 0 <= proof.excluded_by_products <= proof.load_factor:
        return [
            f"'excluded_by_products' is {proof.excluded_by_products:.9g}, but must be between 0 and the load "
            f"factor {proof.load_factor:.9g}"
        ]
    if proof.relaxations and not permits_products(problem):
        return [
            "proofs by products exist only for joints that slide and rock, without ties, props and crushing"
        ]
    if not all(_is_well_formed(step, problem.joints) for step in proof.relaxations):
        return ["the products of the proof have unknown factors, or some factors or force limits are missing"]
    return []


def _is_well_formed(step: ProductRelaxation, joints: int) -> bool:
    """Return True if a relaxation has arrays of correct shapes, known kinds and finite force limits."""
    size = len(step.multipliers)
    if step.static.shape != (size, 2) or step.kinematic.shape != (size, 2):
        return False
    for factors, kinds in ((step.static, STATIC_FACTORS), (step.kinematic, KINEMATIC_FACTORS)):
        if (factors < 0).any() or (factors[:, 0] >= len(kinds)).any():
            return False
    if not np.isfinite([step.lowest, step.highest, *(limit.value for limit in step.limits)]).all():
        return False
    return sorted(limit.joint for limit in step.limits) == list(range(joints))


class _Checker:
    """Checker of one proof, which recomputes the conflicts of the proof in exact arithmetic."""

    def __init__(self, problem: Problem, proof: Proof) -> None:
        self._problem, self._proof = problem, proof
        self._B, self._C = _Exact.of(problem.B), _Exact.of(problem.C(problem.friction))
        self._flow = _Exact.of(problem.C(problem.dilatancy))
        self._dead, self._live = _exact(problem.dead), _exact(problem.live)
        self._cohesion = _exact(problem.face_cohesion)
        self._bound = Fraction(proof.bound)
        #: Load factor up to which products exclude all states; the conflicts exclude states above it.
        self._lowest = Fraction(0)
        self._load = sum(map(abs, self._dead)) + self._bound * sum(map(abs, self._live))
        self._sliders = len(problem.sliding)
        #: ``ProofCheck.reach`` for the conflicts checked so far; infinite if they have no residuals.
        self.reach = float("inf")
        self._energy: list[Fraction | None] = list(self._cohesion)

    @property
    def reaches_bound(self) -> bool:
        """True if the products alone exclude all states up to the bound of the proof."""
        return self._lowest > self._bound

    def faults(self) -> list[str]:
        """Return one sentence for each fault of the proof.

        The method checks the products, the pairs of sliding directions, the energy bounds and the conflicts.
        """
        faults = self._faults_of_products()
        faults += [
            f"yield conditions {pair} do not belong to the two opposite sliding directions of one joint"
            for pair in self._wrong_senses()
        ]
        faults += self._faults_of_energy()
        for number, conflict in enumerate(self._proof.conflicts, start=1):
            if isinstance(conflict, StaticConflict):
                fault = self._fault_of_statics(conflict)
            else:
                fault = self._fault_of_kinematics(conflict)
            if fault:
                faults.append(f"conflict no. {number}: {fault}")
        return faults

    def _faults_of_products(self) -> list[str]:
        """Check the relaxations by products one after the other, and return their faults."""
        faults = []
        for number, step in enumerate(self._proof.relaxations, start=1):
            following = [Fraction(other.lowest) for other in self._proof.relaxations[number:]]
            fault = self._fault_of_step(step, min([*following, self._bound]))
            if fault:
                faults.append(f"relaxation no. {number}: {fault}")
        if not faults and self._lowest < Fraction(self._proof.excluded_by_products):
            faults.append(
                f"the relaxations do not exclude all states up to λ = {self._proof.excluded_by_products:.9g}"
            )
        return faults

    def _fault_of_step(self, step: ProductRelaxation, needed: Fraction) -> str:
        """Return the fault of a relaxation; if it has none, update the excluded interval and return "".

        ``needed`` is the load factor up to which the following relaxations, or the proof, need this one.
        """
        lowest, highest = Fraction(step.lowest), Fraction(step.highest)
        if not 0 <= lowest <= self._lowest or highest < self._bound:
            return (
                f"its interval of load factors must start between 0 and {float(self._lowest):.9g}, and "
                f"end at or above the bound {float(self._bound):.9g}"
            )
        for limit in step.limits:
            row = self._problem.N[[limit.joint]].toarray()[0]
            cost = [-Fraction(entry) for entry in row.tolist()]
            fault = self._fault_of_duals(
                limit.d, limit.p, set(), cost, -Fraction(limit.value), (lowest, highest)
            )
            if fault:
                return f"the limit on the normal force of joint {limit.joint} is not proven: {fault}"
        try:
            proven = ProductChecker(self._problem, step).bound()
        except InvalidProduct as error:
            return str(error)
        excluded = min(proven.up_to(REACH), highest)
        if excluded <= self._lowest:
            return "it excludes no load factors beyond those that earlier relaxations exclude"
        self._lowest = excluded
        if proven.decrease:
            excess = proven.value - min(needed, excluded)
            self.reach = min(self.reach, float(excess / proven.decrease))
        return ""

    def _wrong_senses(self) -> list[list[int]]:
        """Return the pairs of yield conditions that are not the two sliding directions of one joint."""
        sliders = self._sliders
        pairs = self._proof.senses.tolist()
        return [
            [first, second] for first, second in pairs if not (first < sliders and second == first + sliders)
        ]

    def _faults_of_energy(self) -> list[str]:
        """Check the energy bounds and return their faults.

        The bounds are added to the energies of the sliding conditions.
        """
        problem, faults = self._problem, []
        proven = {bound.condition: bound for bound in self._proof.energy_bounds}
        for condition in range(2 * self._sliders):
            joint = condition % self._sliders
            friction, dilatancy = problem.friction[joint].item(), problem.dilatancy[joint].item()
            excess = Fraction(friction) - Fraction(dilatancy)
            least: Fraction | None = Fraction(0) if excess >= 0 else None
            if condition in proven:
                bound = proven[condition]
                least = Fraction(bound.value)
                if fault := self._fault_of_bound(bound, excess, joint):
                    faults.append(f"energy bound of condition {condition}: {fault}")
            own = self._energy[condition]
            self._energy[condition] = None if least is None or own is None else own + least
        stray = [condition for condition in proven if condition >= 2 * self._sliders]
        return faults + [
            f"yield condition {condition} has an energy bound, but only conditions of sliding can have one"
            for condition in stray
        ]

    def _fault_of_bound(self, bound: EnergyBound, excess: Fraction, joint: int) -> str:
        row = self._problem.N[[joint]].toarray()[0]
        cost = [excess * Fraction(entry) for entry in row.tolist()]
        at_yield = {bound.condition}
        return self._fault_of_duals(bound.d, bound.p, at_yield, cost, Fraction(bound.value), self._within)

    def _fault_of_statics(self, conflict: StaticConflict) -> str:
        nothing = [Fraction(0)] * self._problem.B.shape[1]
        at_yield = set(conflict.conditions.tolist())
        return self._fault_of_duals(conflict.d, conflict.p, at_yield, nothing, Fraction(0), self._within)

    @property
    def _within(self) -> tuple[Fraction, Fraction]:
        """Interval of load factors in which the conflicts exclude all states."""
        return min(Fraction(self._proof.excluded_by_products), self._bound), self._bound

    def _fault_of_duals(
        self,
        d: np.ndarray,
        p: np.ndarray,
        at_yield: set[int],
        cost: list[Fraction],
        least: Fraction,
        within: tuple[Fraction, Fraction],
    ) -> str:
        """Return the fault if dual multipliers do not prove the inequality cost·q > least, otherwise "".

        The multipliers of the equations of equilibrium are d, shape (3b,), and those of the yield conditions
        are p, shape (faces,). The inequality must be valid for all forces q with three properties:

        - They are in equilibrium with the loads at a load factor in the interval ``within``.
        - They violate no yield condition (z ≥ 0).
        - They are at yield (z = 0) in the conditions ``at_yield``.

        All such forces satisfy cost·q ≥ f_D·d − c·p + λ f_L·d + departure·q, where
        departure = Bᵀd + cost − C(μ)ᵀp.
        """
        motion, rates = _exact(d), _exact(p)
        if any(rate < 0 and condition not in at_yield for condition, rate in enumerate(rates)):
            return "a multiplier is negative, although its yield condition is not assumed to be at yield"
        of_motion, of_rates = self._B.transposed_times(motion), self._C.transposed_times(rates)
        residual = max(
            (abs(a + own - b) for a, own, b in zip(of_motion, cost, of_rates, strict=True)),
            default=Fraction(0),
        )
        live_work = _dot(self._live, motion)
        gain = (
            _dot(self._dead, motion)
            - _dot(self._cohesion, rates)
            + min(within[0] * live_work, within[1] * live_work)
        )
        return self._outweighed(gain - least, residual * self._load, "static")

    def _fault_of_kinematics(self, conflict: KinematicConflict) -> str:
        """Return the fault if a kinematic conflict does not prove its clause, otherwise "".

        With the multipliers q, λ' and w, all mechanisms with f_L·d = Σ|f_L| have
        d·(B q + λ' f_L + w f_D) = (C(tan ψ) q)·p + λ' Σ|f_L| + w f_D·d, and f_D·d ≥ e·p − bound Σ|f_L| in all
        states up to the bound.
        """
        forces, load_factor, weight = _exact(conflict.q), *_exact([conflict.load_factor, conflict.weight])
        if weight < 0:
            return "the multiplier of the energy balance is negative"
        if weight > 0 and None in self._energy:
            return (
                "the energy balance needs a lower bound on the energy that each yield condition dissipates, "
                "but at least one such bound is missing"
            )
        internal = self._B.times(forces)
        unbalanced = max(
            abs(own + load_factor * live + weight * dead)
            for own, live, dead in zip(internal, self._live, self._dead, strict=True)
        )
        named, lacks = set(conflict.conditions.tolist()), Fraction(0)
        for condition, own in enumerate(self._flow.times(forces)):
            energy = self._energy[condition] if weight > 0 else Fraction(0)
            assert energy is not None
            if condition not in named:
                lacks = max(lacks, -(own + weight * energy))
        gain = (load_factor - weight * self._bound) * Fraction(self._problem.live_norm)
        return self._outweighed(gain, max(unbalanced, lacks), "kinematic")

    def _outweighed(self, gain: Fraction, residual: Fraction, kind: str) -> str:
        """Return the reason why multipliers do not prove a conflict or an energy bound; "" if they do."""
        if gain <= 0:
            return f"the {kind} multipliers do not lead to a contradiction"
        if residual * Fraction(REACH) >= gain:
            return f"the residuals of the {kind} multipliers are too large for a proof"
        if residual > 0:
            self.reach = min(self.reach, float(gain / residual))
        return ""


class _Exact:
    """Sparse matrix whose entries are fractions."""

    def __init__(self, shape: tuple[int, int], entries: list[tuple[int, int, Fraction]]) -> None:
        self._shape, self._entries = shape, entries

    @classmethod
    def of(cls, matrix: sp.csr_array) -> "_Exact":
        """Convert the entries of a matrix to fractions, without rounding."""
        coo = matrix.tocoo()
        rows, columns, values = coo.row.tolist(), coo.col.tolist(), coo.data.tolist()
        return cls(matrix.shape, list(zip(rows, columns, map(Fraction, values), strict=True)))

    def times(self, vector: list[Fraction]) -> list[Fraction]:
        """Return the product of the matrix with a vector."""
        product = [Fraction(0)] * self._shape[0]
        for row, column, value in self._entries:
            if vector[column]:
                product[row] += value * vector[column]
        return product

    def transposed_times(self, vector: list[Fraction]) -> list[Fraction]:
        """Return the product of the transposed matrix with a vector."""
        product = [Fraction(0)] * self._shape[1]
        for row, column, value in self._entries:
            if vector[row]:
                product[column] += value * vector[row]
        return product


def _exact(values: np.ndarray | list[float]) -> list[Fraction]:
    """Convert floating-point numbers to fractions, without rounding."""
    return [Fraction(value) for value in np.asarray(values, dtype=float).tolist()]


def _dot(first: list[Fraction], second: list[Fraction]) -> Fraction:
    return sum((a * b for a, b in zip(first, second, strict=True) if a and b), Fraction(0))


def _is_satisfiable(proof: Proof) -> bool:
    """Return True if an assignment of true or false to the yield conditions satisfies all clauses."""
    with Glucose4(bootstrap_with=proof.clauses()) as solver:
        return bool(solver.solve())
