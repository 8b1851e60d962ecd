"""Statics and kinematics as linear forms in edge forces and edge openings."""

from collections.abc import Iterator
from functools import cached_property
from itertools import product as every

import numpy as np

from masonry_opt.problem.problem import Problem

Form = dict[int, float]  #: A linear form: coefficients by number of the factor.
_NOTHING = 1e-14  #: Coefficients below this are rounding.


class EdgeFactors:
    """Numbers of the factors of statics and of kinematics, and the rows that they meet.

    Statics: x₂ = n₁, x₃ = n₂ and z₀ (the shear s where a joint cannot slide) of each joint, then λ, then 1.
    Kinematics: u₂, u₃, p₀, p₁ of each joint, then d, then 1, with u = 2 p of rocking rates p; p₀ and p₁ where
    it slides. ``forces``, ``load_factor``, ``one`` and ``rates``, ``velocities``, ``unit`` number them;
    ``signed`` factors of statics may be negative, products of ``at_rest`` are zero in Coulomb states.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        c = problem.joints
        self.forces = range(3 * c)
        self.load_factor, self.one = 3 * c, 3 * c + 1
        self.velocities = range(4 * c, 4 * c + problem.B.shape[0])
        self.unit = self.velocities.stop
        self._of_block = problem.layout.rows
        self._touches = problem.matrices.ends.toarray()
        slides = self._slides = np.isin(np.arange(c), problem.sliding).tolist()
        self.rates = [4 * j + f for j in range(c) for f in range(4 if slides[j] else 2)]
        self.signed = {3 * j + 2 for j in range(c) if not slides[j]}
        self.at_rest = {(3 * j + f, 4 * j + f) for j in range(c) for f in range(3 if slides[j] else 2)}
        of_slide = np.zeros((3, c))
        of_slide[:, problem.sliding] = problem.friction, problem.cohesion, problem.dilatancy
        self._friction, self._cohesion, self._dilatancy = of_slide.tolist()
        self._columns = [problem.B[:, kind].toarray() for kind in np.arange(3 * c).reshape(3, -1)]

    def forces_of(self, joint: int) -> range:
        """Factors of statics of a joint."""
        return range(3 * joint, 3 * joint + 3)

    def rates_of(self, joint: int) -> range:
        """Rates of a joint."""
        return range(4 * joint, 4 * joint + (4 if self._slides[joint] else 2))

    def velocities_of(self, block: int) -> range:
        """Velocities of a block."""
        return self.velocities[self._of_block * block :][: self._of_block]

    def pairs(self, first: int, second: int) -> Iterator[tuple[int, int]]:
        """Products of the forces of one joint and the rates of another that are not zero."""
        products = every(self.forces_of(first), self.rates_of(second))
        return (pair for pair in products if pair not in self.at_rest)

    def motion_of(self, joint: int) -> list[int]:
        """Velocities of the blocks of a joint."""
        blocks = np.flatnonzero(self._touches[:, joint]).tolist()
        return [e for block in blocks for e in self.velocities_of(block)]

    @cached_property
    def other_slacks(self) -> dict[int, Form]:
        """z₁ = 2 (c + μ n) − z₀ ≥ 0 by the rate p₁ that it is complementary to."""
        forms = {}
        for j in self.problem.sliding.tolist():
            first, second, slack = self.forces_of(j)
            shared = 2 * self._friction[j]
            form = {first: shared, second: shared, slack: -1.0, self.one: 2 * self._cohesion[j]}
            forms[4 * j + 3] = {i: a for i, a in form.items() if a}
        return forms

    def equilibrium(self) -> Iterator[Form]:
        """B q + λ f_L + f_D = 0, a row for each component of each block."""
        x2, x3, s = self._columns
        for row, (live, dead) in enumerate(zip(self.problem.live, self.problem.dead, strict=True)):
            form: Form = {self.load_factor: float(live), self.one: float(dead)}
            for j in np.flatnonzero(self._touches[row // self._of_block]).tolist():
                first, second, third = self.forces_of(j)
                shear = float(s[row, j])
                form[first], form[second] = (float(x[row, j]) + self._friction[j] * shear for x in (x2, x3))
                form[third] = -shear if self._slides[j] else shear
                form[self.one] += self._cohesion[j] * shear
            yield {i: a for i, a in form.items() if abs(a) > _NOTHING or (i >= self.load_factor and a)}

    def compatibility(self) -> Iterator[Form]:
        """Aᵀd − G v = 0, three rows for each joint: its edges, its slip."""
        for j in range(self.problem.joints):
            rates = self.rates_of(j)
            for kind in range(3):
                form = self._motion(j, kind)
                if kind < 2:
                    form[rates[kind]] = -1.0
                if len(rates) == 4:
                    of_slip = (-self._dilatancy[j],) * 2 if kind < 2 else (1.0, -1.0)
                    form |= {k: a for k, a in zip(rates[2:], of_slip, strict=True) if a}
                yield form

    def openings(self) -> Iterator[tuple[Form, int]]:
        """(Aᵀd) of the edges that cannot but open (ψ ≥ 0), each with the rate u of that edge."""
        for j in range(self.problem.joints):
            if self._dilatancy[j] >= 0:
                for edge in range(2):
                    yield self._motion(j, edge), 4 * j + edge

    def live_work(self) -> Form:
        """f_L·d − Σ|f_L| = 0."""
        live = self.problem.live
        form = {self.velocities.start + int(row): float(live[row]) for row in np.flatnonzero(live)}
        return {**form, self.unit: -self.problem.live_norm}

    def _motion(self, joint: int, kind: int) -> Form:
        column = self._columns[kind][:, joint]
        rows = np.flatnonzero(np.abs(column) > _NOTHING)
        return {self.velocities.start + int(row): float(column[row]) for row in rows}

    def joint_forces(self, y: np.ndarray) -> np.ndarray:
        """The joint forces q (3c,) of forces x₂, x₃, z₀ (or s)."""
        problem = self.problem
        x2, x3, last = y.reshape(-1, 3).T.copy()
        at, n = problem.sliding, x2 + x3
        last[at] = problem.cohesion + problem.friction * n[at] - last[at]
        return np.concatenate([x2, x3, last])

    def in_edges(self, of_faces: np.ndarray) -> np.ndarray:
        """Face rates, shape (faces,), as u₂, u₃, p₀, p₁ of each joint (0 where one cannot slide), flat."""
        problem, table = self.problem, self.problem.table
        v = np.zeros((problem.joints, 4))
        v[:, :2] = 2 * of_faces[table.rocks].reshape(2, -1).T
        v[problem.sliding, 2:] = of_faces[table.slides].reshape(2, -1).T
        return v.ravel()
