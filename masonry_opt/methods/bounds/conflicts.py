"""The two linear programs of a proof, and conflicts from their Farkas multipliers.

Statics and kinematics share only the conditions z_i p_i = 0. The program of statics is infeasible if no
forces with 0 ≤ λ ≤ ``highest`` bring a set of conditions to yield together. The program of kinematics is
infeasible if in no mechanism the rates of a set of conditions are all zero. The multipliers of an infeasible
program identify the few conditions that cause the contradiction. A conflict is used only if it is confirmed
by weak duality, with residuals computed from the matrices of the problem.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from math import inf

import numpy as np
import scipy.sparse as sp

from masonry_opt.effort import Effort
from masonry_opt.methods.bounds.settings import ProofSettings
from masonry_opt.methods.exact.refiner import programs
from masonry_opt.problem.problem import Problem, Scaled
from masonry_opt.solution.products import NormalLimit
from masonry_opt.solution.proof import REACH, Conflict, EnergyBound, KinematicConflict, StaticConflict
from masonry_opt.solvers.highs import SMALLEST_COEFFICIENT, HighsSession, LinearProgram
from masonry_opt.solvers.registry import Verdict

#: Key of ``result.solvers`` for the solver that finds the conflicts of a proof.
_CONFLICTS_PURPOSE = "conflicts"

#: Largest residual of multipliers with which HiGHS may report a program as infeasible. A larger value does no
#: harm, because every conflict is verified. A smaller value leaves more programs undecided.
_RAY_RESIDUAL = 1e-7

#: Largest residual of a conflict, relative to the residual that the proof check allows. The check computes
#: residuals in exact arithmetic, without the rounding errors of the residual computed here. With a larger
#: value, the check might therefore reject conflicts.
_SAFETY = 0.5


class Undecided(Exception):
    """Error that is raised if it remains undecided whether a collapse state with a lower λ exists."""


def total_load(problem: Problem, highest: float) -> float:
    """Return the sum of the magnitudes of all loads at the load factor ``highest``.

    Safety margins and the largest forces within the range of a proof are multiples of this sum.
    """
    return float(np.abs(problem.dead).sum() + highest * np.abs(problem.live).sum())


def friction_excess(problem: Problem) -> np.ndarray:
    """Return friction minus dilatancy, μ − tan ψ, of each sliding condition, shape (2k,) for k joints."""
    return np.tile(problem.friction - problem.dilatancy, len(problem.layout.senses))


def senses_of(problem: Problem) -> np.ndarray:
    """Return the indices of each joint's two sliding conditions, one per direction of slip, shape (k, 2)."""
    first = np.arange(len(problem.sliding))
    return np.column_stack([first, first + len(first)])


def live_range(problem: Problem, d: np.ndarray, within: tuple[float, float]) -> float:
    """Return the least power of the live load λ f_L in a mechanism, over an interval of λ.

    The mechanism ``d`` consists of block velocities, shape (3b,).
    """
    work = float(problem.live @ d)
    return min(within[0] * work, within[1] * work)


@dataclass(frozen=True, eq=False)
class Refutation:
    """Row multipliers that prove a linear program infeasible, and the yield conditions that they involve.

    ``blamed`` are the conditions that contradict each other according to the multipliers.
    """

    ray: np.ndarray  #: row multipliers that prove infeasibility, shape (rows,)
    #: True for each yield condition whose slack (in statics) or rate (in kinematics) the program sets to
    #: zero, shape (faces,).
    restricted: np.ndarray
    #: True for each restricted yield condition that the proof of infeasibility needs, shape (faces,).
    blamed: np.ndarray


class Theory(ABC):
    """Base class of the two linear programs of a proof, in which chosen slacks or rates can be set to 0."""

    def __init__(self, scaled: Scaled, lp: LinearProgram, effort: Effort, settings: ProofSettings) -> None:
        self._problem, self._scaled, self._settings = scaled.problem, scaled, settings
        self._session = HighsSession(
            lp,
            effort,
            _CONFLICTS_PURPOSE,
            presolve="off",
            simplex_scale_strategy=0,
            small_matrix_value=SMALLEST_COEFFICIENT,
            threads=1,
        )
        self._session.accept_rays_up_to(_RAY_RESIDUAL)
        self._restricted = np.zeros(scaled.problem.faces, dtype=bool)

    def _solve(self) -> Verdict:
        """Solve the linear program within its time limit."""
        return self._session.solve(self._settings.longest_program)

    @abstractmethod
    def _restrict(self, conditions: np.ndarray) -> None:
        """Set the slacks (in statics) or the rates (in kinematics) of marked yield conditions to zero.

        ``conditions`` is the mask of these conditions, shape (faces,). A condition with zero slack is at
        yield. The slacks or rates of all other conditions can be positive.
        """

    @abstractmethod
    def _needed(self, ray: np.ndarray, rounding: float) -> np.ndarray:
        """Return a mask of the yield conditions that a proof of infeasibility needs, shape (faces,).

        Multipliers up to ``rounding`` times the largest multiplier count as zero.
        """

    @abstractmethod
    def _confirmed(
        self, ray: np.ndarray, blamed: np.ndarray, problem: Problem, highest: float
    ) -> Conflict | None:
        """Return the conflict that the multipliers prove by weak duality, or None if they prove no conflict.

        The proof is verified with the matrices of ``problem``, which is in the units of the scene. All
        residuals must be small enough for the proof.
        """

    def conflict(self, refutation: Refutation, problem: Problem, highest: float) -> Conflict | None:
        """Return the conflict that a refutation proves: a set of contradicting yield conditions.

        If the blamed conditions do not suffice, the conflict names all restricted conditions with a
        multiplier. None is returned if the matrices do not confirm the conflict. The problem and the largest
        load factor are in the units of the scene, which differ from those of the program.
        """
        shortest = self._confirmed(refutation.ray, refutation.blamed, problem, highest)
        if shortest is not None:
            return shortest
        return self._confirmed(
            refutation.ray, self._needed(refutation.ray, 0.0) & refutation.restricted, problem, highest
        )

    def refutes(self, conditions: np.ndarray) -> Refutation | None:
        """Set marked slacks or rates to zero. If the program is then infeasible, return a refutation.

        ``conditions`` is the mask of the yield conditions whose slacks or rates are set to zero, shape
        (faces,). Return None if the program is feasible. Raise Undecided if HiGHS does not decide whether the
        program is feasible, or returns no multipliers.
        """
        if not np.array_equal(conditions, self._restricted):
            self._restrict(conditions)
            self._restricted = conditions.copy()
        verdict = self._solve()
        if verdict is Verdict.OPTIMAL:
            return None
        ray = self._session.dual_ray() if verdict is Verdict.INFEASIBLE else None
        if ray is None:
            raise Undecided(f"HiGHS ended with status '{verdict.name.lower()}' and returned no multipliers")
        blamed = self._needed(ray, self._settings.rounding) & conditions
        return Refutation(ray, self._restricted, blamed)


class Statics(Theory):
    """Linear program of admissible forces for 0 ≤ λ ≤ ``highest``, with chosen conditions at yield."""

    def __init__(self, scaled: Scaled, effort: Effort, settings: ProofSettings) -> None:
        forces, _ = programs(scaled.problem)
        super().__init__(scaled, forces, effort, settings)
        self._height = scaled.problem.B.shape[0]
        self._lowest = 0.0  # lower limit of λ in the linear program, before scaling

    def set_range(self, lowest: float, highest: float) -> None:
        """Set the smallest and the largest load factor of the program, in the units of the scene."""
        self._lowest = lowest
        unit = self._scaled.load_factor
        self._session.set_bounds("load_factor", lowest / unit, highest / unit)

    def slacks(self) -> np.ndarray:
        """Return the slack of each face at the present optimum, divided by max(1, μ), shape (faces,)."""
        z = self._problem.slacks(self._session.values("q"))
        return np.maximum(z, 0.0) / self._problem.steep

    def point(self) -> tuple[float, np.ndarray]:
        """Return the load factor and the forces, shape (3c + t,), at the present optimum, in scaled units."""
        return float(self._session.values("load_factor")[0]), self._session.values("q")

    def least(self, moving: np.ndarray) -> tuple[float, np.ndarray] | None:
        """Return the least λ at which a set of conditions can be at yield together, and the forces at this λ.

        The mask of these conditions is ``moving``, shape (faces,). Load factor and forces are in scaled
        units. Return None if HiGHS finds no optimum.
        """
        self._restrict(moving)
        self._restricted = moving.copy()
        self._session.set_costs("load_factor", np.ones(1))
        try:
            return self.point() if self._solve() is Verdict.OPTIMAL else None
        finally:
            self._session.set_costs("load_factor", np.zeros(1))

    def _restrict(self, conditions: np.ndarray) -> None:
        self._session.set_room("yield", np.where(conditions, 0.0, np.full(len(conditions), inf)))

    def _needed(self, ray: np.ndarray, rounding: float) -> np.ndarray:
        of_yield = ray[self._height :]
        return np.asarray(of_yield > rounding * np.abs(of_yield).max(initial=0.0))

    def _confirmed(
        self, ray: np.ndarray, blamed: np.ndarray, problem: Problem, highest: float
    ) -> StaticConflict | None:
        proof = self._verified(ray, problem, highest, np.zeros(problem.B.shape[1]), blamed)
        if proof is None:
            return None
        d, p, _ = proof
        return StaticConflict(np.flatnonzero(p < 0), d, p)

    def least_friction(
        self, problem: Problem, condition: int, highest: float
    ) -> EnergyBound | StaticConflict | None:
        """Return a lower bound on the friction energy per unit slip of a sliding condition.

        This energy is (μ − tan ψ) n. The bound is for forces at which the condition is at yield. If the
        condition cannot be at yield, a conflict is returned instead. None is returned if HiGHS has no answer,
        or if the matrices do not confirm the bound or the conflict.
        """
        sliders, alone = len(problem.sliding), np.arange(problem.faces) == condition
        cost = friction_excess(problem)[condition] * problem.N[[condition % sliders]].toarray()[0]
        verdict = self._solve_for(cost, alone)
        if verdict is Verdict.INFEASIBLE:
            ray = self._session.dual_ray()
            return None if ray is None else self._confirmed(ray, alone, problem, highest)
        if verdict is not Verdict.OPTIMAL:
            return None
        proof = self._verified(self._session.multipliers(), problem, highest, cost, alone)
        if proof is None:
            return None
        d, p, value = proof
        return EnergyBound(condition, value - self._settings.margin * total_load(problem, highest), d, p)

    def largest_normal_force(self, problem: Problem, joint: int, highest: float) -> NormalLimit | None:
        """Return an upper bound on the normal force of a joint that can slide.

        ``joint`` is the position of the joint among the joints that can slide. The result is None if the
        normal force is unlimited, if HiGHS has no answer, or if the matrices do not confirm the bound.
        """
        nothing = np.zeros(problem.faces, dtype=bool)
        cost = -problem.N[[joint]].toarray()[0]
        if self._solve_for(cost, nothing) is not Verdict.OPTIMAL:
            return None
        proof = self._verified(self._session.multipliers(), problem, highest, cost, nothing)
        if proof is None:
            return None
        d, p, value = proof
        margin = self._settings.margin * total_load(problem, highest)
        return NormalLimit(int(problem.sliding[joint]), margin - value, d, p)

    def _solve_for(self, cost: np.ndarray, at_yield: np.ndarray) -> Verdict:
        """Minimise cost·q over the admissible forces at which the conditions ``at_yield`` are at yield.

        ``cost`` has the shape (3c + t,), and ``at_yield`` the shape (faces,). Later programs have no costs.
        """
        self._session.set_costs("q", cost)
        self._restrict(at_yield)
        self._restricted = at_yield
        try:
            return self._solve()
        finally:
            self._session.set_costs("q", np.zeros_like(cost))

    def _verified(
        self, ray: np.ndarray, problem: Problem, highest: float, cost: np.ndarray, at_yield: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, float] | None:
        """Convert row multipliers to velocities d and rates p that prove a lower bound on the product cost·q.

        Return d, p and the bound. If these d and p prove no bound, rates of the size of rounding errors are
        set to zero, and all other values are corrected. None is returned if the residuals are still too
        large.
        """
        d, p = -ray[: self._height], -ray[self._height :] / problem.steep
        proof = self._proven(d, p, problem, highest, cost, at_yield)
        if proof is not None:
            return proof
        p = np.where(at_yield, p, np.maximum(p, 0.0))
        p = np.where(np.abs(p) <= self._settings.rounding * np.abs(p).max(initial=0.0), 0.0, p)
        d, p = _without_departure(problem, d, p, problem.B.T @ d + cost - problem.true_yield.T @ p)
        return self._proven(d, p, problem, highest, cost, at_yield)

    def _proven(
        self,
        d: np.ndarray,
        p: np.ndarray,
        problem: Problem,
        highest: float,
        cost: np.ndarray,
        at_yield: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, float] | None:
        """Return d, p and the lower bound on cost·q that they prove, or None if they prove no lower bound.

        The velocities d have shape (3b,), the rates p have shape (faces,). Negative rates are set to zero,
        except for the conditions ``at_yield``, which are at yield. The residuals of d and p must be small,
        otherwise nothing is proven. They are compared with the bound if ``cost`` is zero, and otherwise with
        the margin that is later subtracted from the bound.
        """
        p = np.where(at_yield, p, np.maximum(p, 0.0))
        load = total_load(problem, highest)
        departure = problem.B.T @ d + cost - problem.true_yield.T @ p
        gain = float(problem.dead @ d - problem.face_cohesion @ p) + live_range(
            problem, d, (self._lowest, highest)
        )
        allowed = self._settings.margin * load if cost.any() else gain
        if np.abs(departure).max() * REACH * load > _SAFETY * allowed:
            return None
        return d, p, gain


def _without_departure(
    problem: Problem, d: np.ndarray, p: np.ndarray, departure: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Correct velocities d and rates p by the least change that removes a departure from the flow rule."""
    support = np.flatnonzero(p)
    rows = np.hstack([problem.B.T.toarray(), -problem.true_yield[support].T.toarray()])
    change = np.linalg.lstsq(rows, -departure, rcond=1e-12)[0]
    p = p.copy()
    p[support] += change[len(d) :]
    return d + change[: len(d)], p


class Kinematics(Theory):
    """Linear program that searches for a mechanism that the loads can drive at a λ of at most ``highest``.

    The rates of chosen conditions can be set to zero. The constraints are Bᵀd = D(tan ψ) p, f_L·d = Σ|f_L|,
    p ≥ 0 and e·p − f_D·d ≤ highest Σ|f_L|. In a collapse state λ f_L·d = c·p + Σ (μ − tan ψ) n γ − f_D·d, in
    which γ is the slip of each joint that slides. The energy e of a condition, shape (faces,), is its
    cohesion c. For sliding the least (μ − tan ψ) n is added. All values are in scaled units.
    """

    def __init__(self, scaled: Scaled, energy: np.ndarray, effort: Effort, settings: ProofSettings) -> None:
        problem = scaled.problem
        self.energy = energy
        super().__init__(scaled, driven_motion(problem, energy), effort, settings)
        self._flow = problem.D(problem.dilatancy).T.tocsr()

    def set_highest(self, highest: float) -> None:
        """Set the largest λ at which the loads may drive a mechanism, in units of the scaled problem."""
        self._session.set_upper_bound_of_row("energy", highest * self._problem.live_norm)

    def motion(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the rates, shape (faces,), and the velocities, shape (3b,), at the present optimum."""
        return np.maximum(self._session.values("p"), 0.0), self._session.values("d")

    def _restrict(self, conditions: np.ndarray) -> None:
        self._session.set_most("p", np.where(conditions, 0.0, np.full(len(conditions), inf)))

    def _needed(self, ray: np.ndarray, rounding: float) -> np.ndarray:
        # The multipliers are joint forces q, a load factor, and the weight w of the energies e. The proof
        # needs a zero rate only for yield conditions whose resistance C(tan ψ) q + w e is negative.
        resistance = self._flow @ ray[: self._flow.shape[1]] - min(ray[-1], 0.0) * self.energy
        return np.asarray(resistance < -rounding * np.abs(resistance).max(initial=0.0))

    def _confirmed(
        self, ray: np.ndarray, blamed: np.ndarray, problem: Problem, highest: float
    ) -> KinematicConflict | None:
        width = problem.B.shape[1]
        weight = max(-float(ray[-1]), 0.0)
        q, load_factor = ray[:width] * self._scaled.force, float(ray[width]) * self._scaled.load_factor
        energy = self.energy * self._scaled.force
        gain = (load_factor - weight * highest) * problem.live_norm
        if gain <= 0:
            return None
        conflict = self._proven(q, load_factor, weight, blamed, problem, gain)
        if conflict is not None:
            return conflict
        flow = problem.C(problem.dilatancy)
        resistance = flow @ q + weight * energy
        small = np.abs(resistance) <= self._settings.rounding * np.abs(resistance).max(initial=0.0)
        unbalanced = problem.B @ q + load_factor * problem.live + weight * problem.dead
        q = q + _balancing(problem, flow, unbalanced, np.where(small, resistance, 0.0))
        return self._proven(q, load_factor, weight, blamed, problem, gain)

    def _proven(
        self,
        q: np.ndarray,
        load_factor: float,
        weight: float,
        blamed: np.ndarray,
        problem: Problem,
        gain: float,
    ) -> KinematicConflict | None:
        """Return the conflict that is proven by the joint forces q, or None if their residuals are too large.

        The shape of q is (3c + t,).
        """
        resistance = problem.C(problem.dilatancy) @ q + weight * self.energy * self._scaled.force
        unbalanced = problem.B @ q + load_factor * problem.live + weight * problem.dead
        lacks = float(np.maximum(-resistance[~blamed], 0.0).max(initial=0.0))
        if max(float(np.abs(unbalanced).max()), lacks) * REACH > _SAFETY * gain:
            return None
        return KinematicConflict(np.flatnonzero(blamed), q, load_factor, weight)


def _balancing(
    problem: Problem, flow: sp.csr_array, unbalanced: np.ndarray, resistance: np.ndarray
) -> np.ndarray:
    """Return the least change of forces that restores equilibrium and makes chosen resistances zero.

    The change has shape (3c + t,). The resistance of a yield condition is its entry of C(tan ψ) q + weight ·
    e, see :meth:`Kinematics._needed`. The argument ``resistance``, shape (faces,), contains the resistances
    that are of the size of rounding errors. They become zero. For all other yield conditions, the argument
    is zero.
    """
    support = np.flatnonzero(resistance)
    rows = np.vstack([problem.B.toarray(), flow[support].toarray()])
    change: np.ndarray = np.linalg.lstsq(rows, np.append(-unbalanced, -resistance[support]), rcond=1e-12)[0]
    return change


def driven_motion(problem: Problem, energy: np.ndarray) -> LinearProgram:
    """Return the linear program that searches for a mechanism that the loads can drive at some load factor.

    The program is built from the matrices of the problem. CVXPY declares it as
    :class:`~masonry_opt.models.cvxpy_exact.CvxpyDrivenMotion`. The columns are "p" and "d". The row "energy"
    is the energy balance, whose upper bound is set later.
    """
    _, motion = programs(problem)
    row = sp.csc_array(np.append(energy, -problem.dead)[None, :])
    count = motion.matrix.shape[0]
    return replace(
        motion,
        matrix=sp.vstack([motion.matrix, row], format="csc"),
        row_lower=np.append(motion.row_lower, -inf),
        row_upper=np.append(motion.row_upper, inf),
        rows={**motion.rows, "energy": np.array([count], dtype=np.int32)},
    )
