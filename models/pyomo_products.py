"""A linear relaxation of Coulomb collapse by products of statics and kinematics, in Pyomo."""

from collections.abc import Iterable, Iterator
from itertools import chain
from itertools import product as every
from typing import Any

import numpy as np
import pyomo.environ as pyo
from pyomo.core.expr import LinearExpression

from masonry_opt.problem.edges import EdgeFactors, Form
from masonry_opt.problem.problem import Problem

#: Joints (i, j) of whose forces and rates products are kept, shape (c, c); joints and blocks (i, e) of whose
#: forces and velocities they are, shape (c, b).
Pairs = tuple[np.ndarray, np.ndarray]


class PyomoProducts:
    """Level 1 of the reformulation–linearisation technique (Sherali & Adams 1990) for the MPEC, local.

    Statics in edge forces y = (x₂, x₃, z₀) of each joint (x₂ = n₁, x₃ = n₂, s = c + μ (n₁ + n₂) − z₀)
    and kinematics in rates v = (u₂, u₃, p₀, p₁) (opening of the edges beyond what sliding explains, slip)
    share nothing but complementarity:

        E y + λ f_L + f_D = 0,   y, z₁ = 2 (c + μ n) − z₀, n̂ − n, λ − λ₀, Λ − λ ≥ 0;
        Aᵀd = (u₂ + ψ (p₀ + p₁), u₃ + ψ (p₀ + p₁), p₁ − p₀),   f_L·d = Σ|f_L|,   v ≥ 0;
        x₂ u₂ = x₃ u₃ = z₀ p₀ = z₁ p₁ = 0.

    With a variable for each product that is kept, W = y v, V = y d, λ v, λ d, every product of a row of
    statics with a factor of kinematics (1, v, d), and of a row of kinematics with a factor of statics
    (1, λ, y), is a linear row, as is every product of two inequalities:

        min λ    s.t.    E W·ₖ + λvₖ f_L + vₖ f_D = 0,    E V·ₑ + λdₑ f_L + dₑ f_D = 0,    Aᵀ Vᵢ = G Wᵢ,
                         f_L·Vᵢ = Σ|f_L| yᵢ,   Aᵀ(λd) = G (λv),   f_L·(λd) = Σ|f_L| λ,
                         W, z₁ v, (n̂ − n) v, (λ − λ₀) v, (Λ − λ) v ≥ 0,
                         (yᵢ, z₁, n̂ − n) (Aᵀd)ₖ ≥ 0 (edges that only open),
                         and both sides without a factor.

    Every row that the products kept suffice for is declared, so the least λ never exceeds that of a Coulomb
    state with λ₀ ≤ λ ≤ Λ and n ≤ n̂, whichever products are kept; more of them can only raise it.

    ``within`` are λ₀ ≥ 0 and Λ, ``largest`` n̂ of each joint, ``inf`` where there is none, shape (c,).
    """

    def __init__(
        self, problem: Problem, within: tuple[float, float], largest: np.ndarray, kept: Pairs
    ) -> None:
        self.problem = problem
        factors = self.factors = EdgeFactors(problem)
        model = self.program = pyo.ConcreteModel()
        #: The variable of each product, by the numbers of its factors of statics and of kinematics.
        self.product: dict[tuple[int, int], Any] = {}
        one, unit = factors.one, factors.unit
        self._declare("force", [(i, unit) for i in factors.forces])
        self._declare("load_factor", [(factors.load_factor, unit)])
        self._declare("rate", [(one, k) for k in factors.rates])
        self._declare("velocity", [(one, e) for e in factors.velocities])
        self._declare("load_rate", [(factors.load_factor, k) for k in factors.rates])
        self._declare("load_velocity", [(factors.load_factor, e) for e in factors.velocities])
        near, moves = (np.argwhere(of).tolist() for of in kept)
        self._declare("force_rate", [(i, k) for a, j in near for i, k in factors.pairs(a, j)])
        pairs = (every(factors.forces_of(a), factors.velocities_of(b)) for a, b in moves)
        self._declare("force_velocity", list(chain.from_iterable(pairs)))
        model.load_factor[factors.load_factor, unit].bounds = within
        self._rows(within, largest)
        model.objective = pyo.Objective(expr=model.load_factor[factors.load_factor, unit])

    def _declare(self, name: str, pairs: list[tuple[int, int]]) -> None:
        """A variable for each product of that kind, ≥ 0 where both its factors are."""
        signed = self.factors.signed

        def bounds(_: Any, i: int, k: int) -> tuple[float | None, None]:
            return (None if (i in signed or k in self.factors.velocities) else 0.0), None

        variable = pyo.Var(pairs, bounds=bounds)
        setattr(self.program, name, variable)
        self.product.update(variable)

    def _rows(self, within: tuple[float, float], largest: np.ndarray) -> None:
        model, factors, one, unit = self.program, self.factors, self.factors.one, self.factors.unit
        force, motion = {one: 1.0}, {unit: 1.0}
        all_forces = [{i: 1.0} for i in factors.forces]
        all_rates = [{k: 1.0} for k in factors.rates]
        all_velocities = [{e: 1.0} for e in factors.velocities]
        room = [
            {one: largest[j], **dict.fromkeys(factors.forces_of(j)[:2], -1.0)}
            for j in np.flatnonzero(np.isfinite(largest)).tolist()
        ]
        slack = list(factors.other_slacks.values())
        equilibrium = list(factors.equilibrium())
        motions = [*factors.compatibility(), factors.live_work()]
        # z₁ and p₁ of each joint that slides; the other complementary products have no variable.
        nothing = [(form, {rate: 1.0}) for rate, form in factors.other_slacks.items()]
        # Statics times compatibility is a sum of other rows: of the rates of a joint one slip is enough.
        model.statics = self._constraint(every(equilibrium, [motion, *all_velocities]))
        with_rates = (
            (form, {rate: 1.0})
            for form, rate in every(equilibrium, factors.rates)
            if rate % 4 == 2 or not self._follows(form, rate)
        )
        model.statics_rate = self._constraint(with_rates)
        on_forces = [force, {factors.load_factor: 1.0}, *all_forces]
        model.kinematics = self._constraint(every(on_forces, motions))
        model.complementary = self._constraint(nothing)
        lowest, highest = within
        load_factors = [{one: highest, factors.load_factor: -1.0}]
        if lowest > 0:  # from 0 on these rows are the bounds of λ v
            load_factors.append({factors.load_factor: 1.0, one: -lowest})
        model.within = self._constraint(every([*slack, *room], [motion]), least=0.0)
        model.slack_rate = self._constraint(every([*slack, *room, *load_factors], all_rates), least=0.0)
        # Where the products with the rates themselves are kept these rows are their bounds.
        opening = list(factors.openings())
        kept = factors.at_rest.union(self.product)
        open_beyond = (
            (statics, form)
            for form, rate in opening
            for statics in [*all_forces, *slack, *room]
            if (min(statics), rate) not in kept and not set(statics) & factors.signed
        )
        model.opening = self._constraint(open_beyond, least=0.0)

    def _follows(self, statics: Form, rate: int) -> bool:
        """Whether all products of a row of statics with the motion of that rate's joint are kept."""
        moves = self.factors.motion_of(rate // 4)
        forces = [i for i in statics if i < self.factors.load_factor]
        return all(pair in self.product for pair in every(forces, moves))

    def _constraint(self, pairs: Iterable[tuple[Form, Form]], least: float | None = None) -> pyo.Constraint:
        """The products of forms, as rows = 0, or ≥ ``least``."""
        rows = [
            body == -constant if least is None else body >= least - constant
            for body, constant in self._expanded(pairs)
        ]
        return pyo.Constraint(range(len(rows)), rule=lambda _, row: rows[row])

    def _expanded(self, pairs: Iterable[tuple[Form, Form]]) -> Iterator[tuple[Any, float]]:
        """Each product as a linear expression and a constant, left out where a product in it is not kept."""
        known, at_rest, constants = self.product, self.factors.at_rest, (self.factors.one, self.factors.unit)
        for statics, motion in pairs:
            coefficients, variables, constant = [], [], 0.0
            for (i, a), (k, b) in every(statics.items(), motion.items()):
                variable = known.get((i, k))
                if variable is not None:
                    coefficients.append(a * b)
                    variables.append(variable)
                elif (i, k) == constants:
                    constant += a * b
                elif (i, k) not in at_rest:
                    break
            else:
                if variables:
                    yield LinearExpression(linear_coefs=coefficients, linear_vars=variables), constant
