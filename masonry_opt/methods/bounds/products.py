"""Proof that a load factor is the least, by products of statics and kinematics.

The conflicts of :mod:`masonry_opt.methods.bounds.search` combine yield conditions one after the other. A
relaxation by products treats all conditions at once, see
:class:`~masonry_opt.models.pyomo_products.PyomoProducts`. Its optimum is a lower bound on λ. On running
bonds, where proofs by conflicts are long, the optimum often equals the least load factor.

The multipliers of an interior-point method are not accurate enough for a proof. The relaxation is therefore
solved to a vertex (basic solution), whose multipliers are refined. The bound that they prove is computed in
exact arithmetic. A further relaxation includes only states above the last bound. The forces of these states
have smaller limits, so that an equal number of products may prove a higher bound.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import nextafter
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse.csgraph import shortest_path

from masonry_opt.effort import Effort
from masonry_opt.methods.bounds.conflicts import Statics
from masonry_opt.methods.bounds.settings import SETTINGS, ProofSettings
from masonry_opt.problem.problem import Problem, in_units_of_load
from masonry_opt.solution.product_check import ProductChecker, permits_products
from masonry_opt.solution.products import KINEMATIC_FACTORS, STATIC_FACTORS, NormalLimit, ProductRelaxation
from masonry_opt.solution.proof import REACH, Proof
from masonry_opt.solvers.highs import HighsSession, LinearProgram, Vertex
from masonry_opt.solvers.registry import LpSize, Verdict, find_solver

if TYPE_CHECKING:
    from masonry_opt.models.pyomo_products import Pairs, PyomoProducts

#: Products in the successive relaxations, one pair of largest distances for each relaxation:
#:
#: - Forces of a joint are multiplied by rates of all joints up to the first distance.
#: - Forces of a joint are multiplied by velocities of all blocks up to the second distance.
#:
#: A distance is a number of steps between adjacent blocks, see :func:`distances`. The next pair is used if
#: the bounds on λ still differ and time remains.
_RADII = ((0, 1), (0, 2), (0, 3), (1, 3), (2, 3), (2, 4), (3, 5))

#: Tolerance of the interior-point method, and of the crossover from its solution to a vertex.
_VERTEX_TOLERANCE = 1e-9

#: The programs limit λ to the lowest known λ, increased by this relative margin. Without a margin, the
#: feasible set would have no interior, which interior-point methods need.
_LOAD_FACTOR_MARGIN = 1e-4


def a_little_above(best: float) -> float:
    """Return the largest λ that the programs admit: slightly more than the lowest known load factor."""
    return best + _LOAD_FACTOR_MARGIN * max(abs(best), 1e-3)


def distances(problem: Problem) -> "Pairs":
    """Return the distances between joints, shape (c, c), and from joints to blocks, shape (c, b).

    A distance is a number of steps, each from one block to an adjacent block. Two joints of one block have
    the distance 0.
    """
    touches = problem.matrices.ends.toarray()
    between = shortest_path(touches @ touches.T, directed=False, unweighted=True)
    of_joint = [np.flatnonzero(column) for column in touches.T]
    to_blocks = np.array([between[blocks].min(axis=0) for blocks in of_joint])
    to_joints = np.array([to_blocks[:, blocks].min(axis=1) for blocks in of_joint]).T
    return to_joints, to_blocks


def number_of_products(selected: "Pairs") -> int:
    """Return the number of products of forces with rates and velocities in a relaxation."""
    return 12 * int(selected[0].sum()) + 9 * int(selected[1].sum())


def selections(problem: Problem, most: int) -> Iterator[tuple[tuple[int, int], "Pairs"]]:
    """Generate the products of each relaxation, by increasing size and up to ``most`` products.

    Yields the two largest distances of the products, and masks that select the pairs of joints, and of joints
    and blocks. Relaxations without further products are left out.
    """
    # Each joint is at distance 0 from itself. On large scenes these products alone are too many, and the
    # distances would need much memory.
    if number_of_products((np.ones(problem.joints), np.zeros(0))) > most:
        return
    to_joints, to_blocks = distances(problem)
    before = 0
    for radii in _RADII:
        selected = to_joints <= radii[0], to_blocks <= radii[1]
        products = number_of_products(selected)
        if before < products <= most:
            yield radii, selected
        before = products


def closes_much(before: float, after: float, load_factor: float, settings: ProofSettings) -> bool:
    """Return True if a relaxation that raised the lower bound on λ is worth repeating.

    ``load_factor`` is the lowest known λ, which is the upper bound.
    """
    return after - before > settings.worth_repeating * (load_factor - before)


@dataclass(frozen=True, eq=False)
class SolvedRelaxation:
    """Solution of a relaxation at a vertex, and the lower bound on λ that its multipliers prove."""

    bound: float  #: lower bound on λ of states whose motion is within ``REACH``
    model: "PyomoProducts"
    point: np.ndarray  #: value of each variable, in the order of ``model.product``
    size: LpSize  #: size of the linear program


class ProductChain:
    """Proof of a lower bound on λ by a sequence of relaxations, each solved to a vertex.

    Attributes
    ----------
    bound: load factor up to which the relaxations so far exclude all states from λ = 0 on.
    steps: each relaxation that raised the bound.
    selections: pairs of joints, and of joints and blocks, whose products the successive relaxations contain.
        It is empty if the scene has other yield conditions than sliding and rocking. Relaxations with too
        many products are left out.
    """

    def __init__(self, problem: Problem, effort: Effort, settings: ProofSettings = SETTINGS) -> None:
        self.bound = 0.0
        self.steps: list[ProductRelaxation] = []
        self._problem, self._effort, self._settings = problem, effort, settings
        self.selections: list[Pairs] = []
        if permits_products(problem):
            self.selections = [selected for _, selected in selections(problem, settings.most_products)]

    def raise_bound(self, load_factor: float, selected: "Pairs", seconds: float) -> SolvedRelaxation | None:
        """Solve one relaxation, and raise the bound if the relaxation proves a higher one.

        Parameters
        ----------
        load_factor: lowest load factor of all known exact states.
        selected: one of ``selections``.
        seconds: time limit of the relaxation.

        Returns
        -------
        SolvedRelaxation or None
            None if the relaxation proves nothing: statics does not limit the normal force of a joint, the
            time is over, or the solver fails.
        """
        # The import is local, because importing Pyomo takes half a second.
        from masonry_opt.models.pyomo_products import PyomoProducts

        problem, within = self._problem, (self.bound, a_little_above(load_factor))
        limits = self._normal_limits(within)
        if limits is None:
            return None
        with self._effort.measure("build"):
            largest = np.array([limit.value for limit in limits])
            model = PyomoProducts(problem, within, largest, selected)
        with self._effort.measure("compile"):
            lp = LinearProgram.of_pyomo(model.program)
        solver = find_solver("cvxpy", "highs-ipm", _VERTEX_TOLERANCE)
        session = HighsSession(lp, self._effort, "products", solver, run_crossover="on")
        verdict = session.run(seconds)
        self._effort.lp_solves += 1
        vertex = session.vertex() if verdict is Verdict.OPTIMAL else None
        if vertex is None:
            return None
        relaxation = _Recorder(problem, model, lp, within, limits).relaxation(vertex)
        proven = ProductChecker(problem, relaxation).bound().up_to(REACH)
        bound = float(proven)
        if bound > proven:  # rounded up
            bound = nextafter(bound, -np.inf)
        if bound > self.bound:
            self.bound = min(bound, within[1])
            self.steps.append(relaxation)
        columns = np.concatenate(list(lp.columns.values()))
        return SolvedRelaxation(bound, model, session.point()[columns], lp.size)

    def excluded(self, load_factor: float) -> float:
        """Return the load factor up to which a proof excludes states by products.

        This load factor is ``bound``, which may exceed the least load factor by rounding errors. A proof
        therefore never claims more than ``load_factor``, which is the lowest one of all known exact states.
        """
        return min(self.bound, load_factor)

    def proof(self, load_factor: float, bound: float) -> Proof:
        """Return the proof that no state has a load factor from 0 to ``bound`` ≤ ``self.bound``.

        The relaxations exclude load factors below ``self.bound``, but not this load factor itself. The bound
        of the proof is therefore slightly smaller than ``self.bound``, by a rounding error at least.
        """
        assert bound <= self.bound
        excluded = self.excluded(load_factor)
        return Proof(
            bound=min(bound, nextafter(excluded, 0.0)),
            load_factor=load_factor,
            conditions=self._problem.faces,
            conflicts=(),
            energy_bounds=(),
            senses=np.zeros((0, 2), dtype=int),
            relaxations=tuple(self.steps),
            excluded_by_products=excluded,
        )

    def _normal_limits(self, within: tuple[float, float]) -> tuple[NormalLimit, ...] | None:
        """Return upper bounds on the normal forces of all joints for an interval of λ.

        Return None if statics does not limit the normal force of a joint.
        """
        scaled = in_units_of_load(self._problem)
        statics = Statics(scaled, self._effort, self._settings)
        lowest, highest = within
        statics.set_range(lowest, highest)
        limits = []
        for joint in range(self._problem.joints):
            limit = statics.largest_normal_force(self._problem, joint, highest)
            if limit is None:
                return None
            limits.append(limit)
        return tuple(limits)


class _Recorder:
    """Builder of a :class:`ProductRelaxation` record from a solved relaxation, with refined multipliers."""

    def __init__(
        self,
        problem: Problem,
        model: "PyomoProducts",
        lp: LinearProgram,
        within: tuple[float, float],
        limits: tuple[NormalLimit, ...],
    ) -> None:
        self._problem, self._lp = problem, lp
        self._within, self._limits = within, limits
        columns = np.concatenate(list(lp.columns.values())).tolist()
        #: Column of each product of unknowns in the linear program.
        self._column = dict(zip(model.product, columns, strict=True))
        self._rows = np.concatenate([lp.rows[name] for name in model.factors_of_rows])
        pairs = [pair for own in model.factors_of_rows.values() for pair in own]
        self._static = np.array([(STATIC_FACTORS.index(of.name), of.number) for of, _ in pairs])
        self._kinematic = np.array([(KINEMATIC_FACTORS.index(of.name), of.number) for _, of in pairs])
        self._may_be_negative = np.isfinite(lp.row_upper[self._rows])

    def relaxation(self, vertex: Vertex) -> ProductRelaxation:
        """Return the products of the relaxation, with multipliers computed from a vertex.

        The multipliers solve the equations of the vertex. Their errors are computed exactly, from the
        matrices of the problem, and removed by two steps of iterative refinement. The second step remains a
        separate number, because it is smaller than the rounding errors of the multipliers.
        """
        multipliers = vertex.multipliers(self._lp.cost)
        multipliers = multipliers + vertex.multipliers(self._reduced_costs(multipliers))
        corrections = vertex.multipliers(self._reduced_costs(multipliers))
        return self._recorded(multipliers, corrections)

    def _reduced_costs(self, multipliers: np.ndarray) -> np.ndarray:
        """Return the reduced cost of each column, computed in exact arithmetic, shape (columns,).

        With exact multipliers of a vertex, the reduced costs of its basic columns are zero.
        """
        products = self._recorded(multipliers, np.zeros_like(multipliers))
        remaining = np.zeros(len(self._lp.cost))
        for pair, coefficient in ProductChecker(self._problem, products).coefficients().items():
            if pair in self._column:
                remaining[self._column[pair]] = float(coefficient)
        return remaining

    def _recorded(self, multipliers: np.ndarray, corrections: np.ndarray) -> ProductRelaxation:
        """Return the record of all products whose multiplier is not zero.

        Inequalities with a negative multiplier, which is a rounding error, are left out.
        """
        own, correction = multipliers[self._rows], corrections[self._rows]
        used = (own != 0) & (self._may_be_negative | (own + correction > 0))
        lowest, highest = self._within
        return ProductRelaxation(
            lowest=lowest,
            highest=highest,
            limits=self._limits,
            static=self._static[used],
            kinematic=self._kinematic[used],
            multipliers=own[used],
            corrections=correction[used],
        )
