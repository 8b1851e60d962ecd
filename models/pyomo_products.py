"""Linear relaxation of the MPEC by products of static and kinematic variables, in Pyomo."""

from collections.abc import Iterable
from itertools import chain, product
from typing import Any, NamedTuple

import numpy as np
import pyomo.environ as pyo
from pyomo.core.expr import LinearExpression

from masonry_opt.problem.edges import EdgeFactors, Form
from masonry_opt.problem.problem import Problem

#: Two masks of the products for which the relaxation has variables. Entry (i, j) of the first mask, shape
#: (joints, joints), selects the forces of joint i times the rates of joint j. Entry (i, e) of the second
#: mask, shape (joints, blocks), selects the forces of joint i times the velocities of block e.
Pairs = tuple[np.ndarray, np.ndarray]


class Factor(NamedTuple):
    """Linear form of statics or kinematics, which is one of the two factors of a row of the relaxation."""

    name: str  #: kind of the form, from ``STATIC_FACTORS`` or ``KINEMATIC_FACTORS``
    number: int  #: number of the form among all forms of this kind
    form: Form


class PyomoProducts:
    """Linear relaxation of the MPEC by the reformulation–linearisation technique (RLT), level 1.

    The technique (Sherali & Adams 1990) replaces products of variables by new variables.

    The static unknowns of each joint are the edge forces y = (x₂, x₃, z₀), with x₂ = n₁, x₃ = n₂ and
    s = c + μ (n₁ + n₂) − z₀. The kinematic unknowns are the rates v = (u₂, u₃, p₀, p₁): openings of the edges
    without the opening due to sliding, and slips. Only complementarity connects statics with kinematics:

        E y + λ f_L + f_D = 0,   y, z₁ = 2 (c + μ n) − z₀, n̂ − n, λ − λ₀, Λ − λ ≥ 0;
        Aᵀd = (u₂ + ψ (p₀ + p₁), u₃ + ψ (p₀ + p₁), p₁ − p₀),   f_L·d = Σ|f_L|,   v ≥ 0;
        x₂ u₂ = x₃ u₃ = z₀ p₀ = z₁ p₁ = 0.

    The relaxation has variables for selected products: W = y v, V = y d, λ v and λ d. Then three kinds of
    products are linear rows: a row of statics times a factor of kinematics (1, v, d), a row of kinematics
    times a factor of statics (1, λ, y), and two inequalities times each other:

        min λ    s.t.    E W·ₖ + λvₖ f_L + vₖ f_D = 0,    E V·ₑ + λdₑ f_L + dₑ f_D = 0,    Aᵀ Vᵢ = G Wᵢ,
                         f_L·Vᵢ = Σ|f_L| yᵢ,   Aᵀ(λd) = G (λv),   f_L·(λd) = Σ|f_L| λ,
                         W, z₁ v, (n̂ − n) v, (λ − λ₀) v, (Λ − λ) v ≥ 0,
                         (yᵢ, z₁, n̂ − n) (Aᵀd)ₖ ≥ 0 (edges that only open),
                         and both sides without a factor.

    A row is declared only if all of its products have variables. For any selection of products, the least λ
    is therefore a lower bound on the load factors of all Coulomb states with λ₀ ≤ λ ≤ Λ and n ≤ n̂. More
    products never reduce this bound.

    ``within`` contains λ₀ ≥ 0 and Λ. ``largest`` is n̂ of each joint, shape (c,); it is ``inf`` for a joint
    without a limit. ``selected`` selects the products.
    """

    def __init__(
        self, problem: Problem, within: tuple[float, float], largest: np.ndarray, selected: Pairs
    ) -> None:
        self.problem = problem
        factors = self.factors = EdgeFactors(problem)
        model = self.program = pyo.ConcreteModel()
        #: Pyomo variable of each product, by the indices of the static factor and of the kinematic factor.
        self.product: dict[tuple[int, int], Any] = {}
        #: Static and kinematic factor of each row, by the name of the row's constraint.
        self.factors_of_rows: dict[str, list[tuple[Factor, Factor]]] = {}
        static_unit, kinematic_unit = factors.static_unit, factors.kinematic_unit
        self._declare("force", [(i, kinematic_unit) for i in factors.forces])
        self._declare("load_factor", [(factors.load_factor, kinematic_unit)])
        self._declare("rate", [(static_unit, k) for k in factors.rates])
        self._declare("velocity", [(static_unit, e) for e in factors.velocities])
        self._declare("load_rate", [(factors.load_factor, k) for k in factors.rates])
        self._declare("load_velocity", [(factors.load_factor, e) for e in factors.velocities])
        near, moves = (np.argwhere(mask).tolist() for mask in selected)
        self._declare("force_rate", [(i, k) for a, j in near for i, k in factors.pairs(a, j)])
        pairs = (product(factors.forces_of(a), factors.velocities_of(b)) for a, b in moves)
        self._declare("force_velocity", list(chain.from_iterable(pairs)))
        model.load_factor[factors.load_factor, kinematic_unit].bounds = within
        self._rows(within, largest)
        model.objective = pyo.Objective(expr=model.load_factor[factors.load_factor, kinematic_unit])

    def _declare(self, name: str, pairs: list[tuple[int, int]]) -> None:
        """Declare a variable for the product of each pair of factors.

        The lower bound of the variable is 0 if neither factor can be negative.
        """
        signed = self.factors.signed

        def bounds(_: Any, i: int, k: int) -> tuple[float | None, None]:
            return (None if (i in signed or k in self.factors.velocities) else 0.0), None

        variable = pyo.Var(pairs, bounds=bounds)
        setattr(self.program, name, variable)
        self.product.update(variable)

    def _rows(self, within: tuple[float, float], largest: np.ndarray) -> None:
        """Declare the rows of the relaxation, except rows that contain a product without a variable."""
        model = self.program
        factors = self.factors
        static_unit, kinematic_unit = factors.static_unit, factors.kinematic_unit
        force = Factor("one", 0, {static_unit: 1.0})
        motion = Factor("one", 0, {kinematic_unit: 1.0})
        load_factor = Factor("load factor", 0, {factors.load_factor: 1.0})
        all_forces = [Factor("force", i, {i: 1.0}) for i in factors.forces]
        all_rates = [Factor("rate", k, {k: 1.0}) for k in factors.rates]
        first_velocity = factors.velocities.start
        all_velocities = [Factor("velocity", e - first_velocity, {e: 1.0}) for e in factors.velocities]
        margins = [  # margin n̂ − n of each joint whose normal force n has an upper bound n̂
            Factor("margin", j, {static_unit: largest[j], **dict.fromkeys(factors.forces_of(j)[:2], -1.0)})
            for j in np.flatnonzero(np.isfinite(largest)).tolist()
        ]
        slacks = [Factor("other slack", rate // 4, form) for rate, form in factors.other_slacks.items()]
        equilibrium = [Factor("equilibrium", row, form) for row, form in enumerate(factors.equilibrium())]
        compatibility = [
            Factor("compatibility", row, form) for row, form in enumerate(factors.compatibility())
        ]
        motions = [*compatibility, Factor("live work", 0, factors.live_work())]
        # Complementarity of z₁ and p₁ needs the row z₁ p₁ = 0, because z₁ is a linear form of several
        # unknowns. The factors of x₂ u₂, x₃ u₃ and z₀ p₀ are single unknowns. By complementarity these
        # products are zero in all rows, so that they need no variables.
        complementary = [
            (slack, Factor("rate", rate, {rate: 1.0}))
            for slack, rate in zip(slacks, factors.other_slacks, strict=True)
        ]
        model.statics = self._constraint("statics", product(equilibrium, [motion, *all_velocities]))
        # Multiply each equilibrium row by the rates of each joint. Rows multiplied by p₀, whose index
        # satisfies ``rate % 4 == 2``, are always declared. Rows multiplied by u₂, u₃ or p₁ are omitted if
        # compatibility implies them.
        with_rates = (
            (row, rate)
            for row, rate in product(equilibrium, all_rates)
            if rate.number % 4 == 2 or not self._follows(row.form, rate.number)
        )
        model.statics_rate = self._constraint("statics_rate", with_rates)
        static_factors = [force, load_factor, *all_forces]
        model.kinematics = self._constraint("kinematics", product(static_factors, motions))
        model.complementary = self._constraint("complementary", complementary)
        lowest, highest = within
        load_factors = [Factor("load margin", 0, {static_unit: highest, factors.load_factor: -1.0})]
        if lowest > 0:  # for λ₀ = 0, the lower bound 0 of each variable λ v replaces the row
            excess = {factors.load_factor: 1.0, static_unit: -lowest}
            load_factors.append(Factor("load excess", 0, excess))
        limits = [*slacks, *margins]
        model.within = self._constraint("within", product(limits, [motion]), least=0.0)
        of_rates = product([*limits, *load_factors], all_rates)
        model.slack_rate = self._constraint("slack_rate", of_rates, least=0.0)
        # Each row requires that the product of an edge opening and an edge force, slack or margin is at least
        # 0. Omit the row if the product is known to be zero, or has a variable with the lower bound 0.
        with_variable = factors.at_rest.union(self.product)
        open_beyond = (
            (statics, Factor("opening", rate, form))
            for form, rate in factors.openings()
            for statics in [*all_forces, *limits]
            if (min(statics.form), rate) not in with_variable and not set(statics.form) & factors.signed
        )
        model.opening = self._constraint("opening", open_beyond, least=0.0)

    def _follows(self, statics: Form, rate: int) -> bool:
        """Return True if compatibility implies the row that is an equilibrium row times a rate of a joint.

        ``statics`` is the linear form of the row, and ``rate`` is the index of u₂, u₃ or p₁. The new row is
        implied if the relaxation has variables for the products of all forces in the row with the velocities
        of the joint's blocks. It then follows from the equilibrium row times these velocities and times p₀.
        """
        moves = self.factors.motion_of(rate // 4)
        forces = [i for i in statics if i < self.factors.load_factor]
        return all(pair in self.product for pair in product(forces, moves))

    def _constraint(
        self, name: str, pairs: Iterable[tuple[Factor, Factor]], least: float | None = None
    ) -> pyo.Constraint:
        """Return a constraint that bounds the product of each pair of linear forms, or sets it to zero.

        Each product is equal to 0 if ``least`` is None, and otherwise at least ``least``. The factors of each
        row are stored in ``factors_of_rows``, by the name of the constraint.
        """
        rows = []
        self.factors_of_rows[name] = []
        for statics, motion in pairs:
            expanded = self._expanded(statics.form, motion.form)
            if expanded is not None:
                body, constant = expanded
                rows.append(body == -constant if least is None else body >= least - constant)
                self.factors_of_rows[name].append((statics, motion))
        return pyo.Constraint(range(len(rows)), rule=lambda _, row: rows[row])

    def _expanded(self, statics: Form, motion: Form) -> tuple[Any, float] | None:
        """Expand the product of two linear forms into a sum of products of unknowns.

        Variables replace the products of unknowns, so the sum is a linear expression and a constant. The
        result is None if a product has no variable and is not known to be zero, or if all products are zero.
        """
        constants = (self.factors.static_unit, self.factors.kinematic_unit)
        coefficients, variables, constant = [], [], 0.0
        for (i, a), (k, b) in product(statics.items(), motion.items()):
            variable = self.product.get((i, k))
            if variable is not None:
                coefficients.append(a * b)
                variables.append(variable)
            elif (i, k) == constants:
                constant += a * b
            elif (i, k) not in self.factors.at_rest:
                return None
        if not variables:
            return None
        return LinearExpression(linear_coefs=coefficients, linear_vars=variables), constant
