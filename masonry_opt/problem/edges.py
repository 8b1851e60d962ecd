"""Write the statics and kinematics of a plane problem as linear forms in edge forces and edge openings.

The forms are the factors of the products in the relaxation of :mod:`masonry_opt.models.pyomo_products`.
"""

from collections.abc import Iterator
from functools import cached_property
from itertools import product

import numpy as np

from masonry_opt.problem.problem import Problem

#: Linear form of numbered unknowns: a dictionary from the index of each unknown to its coefficient.
Form = dict[int, float]

#: Magnitude below which an entry of the equilibrium matrix B counts as zero. Entries of B are near one;
#: smaller entries are rounding errors.
_ZERO_COEFFICIENT = 1e-14


class EdgeFactors:
    """Static and kinematic equations of a plane problem.

    Each equation is a linear form of numbered unknowns (see ``Form``). The unknowns and the constant 1 are
    called *factors*, because the relaxation multiplies them.

    - Statics: x₂ = n₁, x₃ = n₂ and z₀ of each joint, then λ, then 1. Here z₀ is the slack of sliding in the
      positive direction, or the shear s if the joint cannot slide.
    - Kinematics: u₂, u₃, p₀, p₁ of each joint, then d, then 1. Here u = 2 p are the openings of the edges by
      rocking, and p₀ and p₁ the sliding rates; a joint that cannot slide has no index for them.

    ``forces``, ``load_factor`` and ``static_unit`` are the indices of the factors of statics; ``rates``,
    ``velocities`` and ``kinematic_unit`` are the indices of the factors of kinematics. The two units are
    the indices of the constant 1. The factors in ``signed`` may be negative. Products of the pairs in
    ``at_rest`` are zero by complementarity, eq. (8).
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        c = problem.joints
        self.forces = range(3 * c)
        self.load_factor = 3 * c
        self.static_unit = 3 * c + 1
        self.velocities = range(4 * c, 4 * c + problem.B.shape[0])
        self.kinematic_unit = self.velocities.stop
        self._rows_per_block = problem.layout.rows
        self._touches = problem.matrices.ends.toarray()
        slides = self._slides = np.isin(np.arange(c), problem.sliding).tolist()
        self.rates = [4 * j + f for j in range(c) for f in range(4 if slides[j] else 2)]
        self.signed = {3 * j + 2 for j in range(c) if not slides[j]}
        self.at_rest = {(3 * j + f, 4 * j + f) for j in range(c) for f in range(3 if slides[j] else 2)}
        # Collect friction, cohesion and dilatancy of each joint, with zero for a joint that cannot slide.
        properties = np.zeros((3, c))
        properties[:, problem.sliding] = problem.friction, problem.cohesion, problem.dilatancy
        self._friction, self._cohesion, self._dilatancy = properties.tolist()
        self._columns = [problem.B[:, kind].toarray() for kind in np.arange(3 * c).reshape(3, -1)]

    def forces_of(self, joint: int) -> range:
        """Return the indices of a joint's force unknowns."""
        return range(3 * joint, 3 * joint + 3)

    def rates_of(self, joint: int) -> range:
        """Return the indices of a joint's rate unknowns."""
        return range(4 * joint, 4 * joint + (4 if self._slides[joint] else 2))

    def velocities_of(self, block: int) -> range:
        """Return the indices of a block's velocity unknowns."""
        return self.velocities[self._rows_per_block * block :][: self._rows_per_block]

    def pairs(self, first: int, second: int) -> Iterator[tuple[int, int]]:
        """Return all pairs of a force unknown of the first joint and a rate unknown of the second joint.

        Pairs whose product is zero by complementarity are left out.
        """
        pairs = product(self.forces_of(first), self.rates_of(second))
        return (pair for pair in pairs if pair not in self.at_rest)

    def motion_of(self, joint: int) -> list[int]:
        """Return the indices of the velocity unknowns of the blocks that a joint touches."""
        blocks = np.flatnonzero(self._touches[:, joint]).tolist()
        return [e for block in blocks for e in self.velocities_of(block)]

    @cached_property
    def other_slacks(self) -> dict[int, Form]:
        """Return the slack z₁ of each joint against sliding in the negative direction.

        Each slack is a linear form of the factors of statics: z₁ = 2 (c + μ n) − z₀ ≥ 0. The key of each form
        is the number of the rate p₁, which is complementary to the slack.
        """
        forms = {}
        for j in self.problem.sliding.tolist():
            first, second, slack = self.forces_of(j)
            shared = 2 * self._friction[j]
            form = {first: shared, second: shared, slack: -1.0, self.static_unit: 2 * self._cohesion[j]}
            forms[4 * j + 3] = {i: a for i, a in form.items() if a}
        return forms

    def equilibrium(self) -> Iterator[Form]:
        """Generate the equilibrium equations B q + λ f_L + f_D = 0, one linear form for each row of B."""
        x2, x3, s = self._columns
        for row, (live, dead) in enumerate(zip(self.problem.live, self.problem.dead, strict=True)):
            form: Form = {self.load_factor: float(live), self.static_unit: float(dead)}
            for j in np.flatnonzero(self._touches[row // self._rows_per_block]).tolist():
                first, second, third = self.forces_of(j)
                shear = float(s[row, j])
                form[first] = float(x2[row, j]) + self._friction[j] * shear
                form[second] = float(x3[row, j]) + self._friction[j] * shear
                form[third] = -shear if self._slides[j] else shear
                form[self.static_unit] += self._cohesion[j] * shear
            yield {
                i: a for i, a in form.items() if abs(a) > _ZERO_COEFFICIENT or (i >= self.load_factor and a)
            }

    def compatibility(self) -> Iterator[Form]:
        """Generate the compatibility equations of each joint, which relate its motion to its rates.

        The three equations are Aᵀd − G v = 0: the velocities d of the blocks move the joint as its rates
        v = (u, p) do. The first two equations are for the openings of the joint's two edges; the third is for
        its slip.
        """
        for j in range(self.problem.joints):
            rates = self.rates_of(j)
            for kind in range(3):
                form = self._motion(j, kind)
                if kind < 2:
                    form[rates[kind]] = -1.0
                if len(rates) == 4:
                    slip_terms = (-self._dilatancy[j],) * 2 if kind < 2 else (1.0, -1.0)
                    form |= {k: a for k, a in zip(rates[2:], slip_terms, strict=True) if a}
                yield form

    def openings(self) -> Iterator[tuple[Form, int]]:
        """Generate the opening of each joint edge, with the index of the edge's rocking rate u₂ or u₃.

        An opening is a row of Aᵀd, a linear form of the velocities d, and cannot be negative. Joints with
        negative dilatancy are left out, because their edges can close.
        """
        for j in range(self.problem.joints):
            if self._dilatancy[j] >= 0:
                for edge in range(2):
                    yield self._motion(j, edge), 4 * j + edge

    def live_work(self) -> Form:
        """Return the equation f_L·d − Σ|f_L| = 0, which scales the velocities, as a linear form."""
        live = self.problem.live
        form = {self.velocities.start + int(row): float(live[row]) for row in np.flatnonzero(live)}
        return {**form, self.kinematic_unit: -self.problem.live_norm}

    def _motion(self, joint: int, kind: int) -> Form:
        """Return one motion of a joint, an opening or the slip, as a linear form of the velocities.

        Kinds 0 and 1 are the openings of the joint's edges; kind 2 is its slip.
        """
        column = self._columns[kind][:, joint]
        rows = np.flatnonzero(np.abs(column) > _ZERO_COEFFICIENT)
        return {self.velocities.start + int(row): float(column[row]) for row in rows}

    def joint_forces(self, y: np.ndarray) -> np.ndarray:
        """Convert the force unknowns x₂, x₃ and z₀ of all joints to joint forces q, shape (3c,).

        ``y`` has the three unknowns of the first joint, then of the second, and so on, shape (3c,). For a
        joint that cannot slide, the third unknown is the shear s instead of z₀.
        """
        problem = self.problem
        x2, x3, last = y.reshape(-1, 3).T.copy()
        n = x2 + x3
        sliding = problem.sliding
        last[sliding] = problem.cohesion + problem.friction * n[sliding] - last[sliding]
        return np.concatenate([x2, x3, last])

    def in_edges(self, p: np.ndarray) -> np.ndarray:
        """Convert the rates p of all yield conditions to u₂, u₃, p₀ and p₁ of each joint, shape (4c,).

        u₂ and u₃ are the openings of a joint's edges by rocking. p₀ and p₁ are its sliding rates in both
        directions, which are 0 if the joint cannot slide. The argument p has shape (faces,).
        """
        problem = self.problem
        table = problem.table
        v = np.zeros((problem.joints, 4))
        v[:, :2] = 2 * p[table.rocks].reshape(2, -1).T
        v[problem.sliding, 2:] = p[table.slides].reshape(2, -1).T
        return v.ravel()
