"""Collapse load factor of an arch under fill by virtual work, with four hinges along two smooth curves.

The calculation uses neither voussoirs nor a linear program. It integrates the weights of the ring and of
strips of fill, the live load and the earth pressure along the curves. It then searches for the mechanism
with the least load factor.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, product

import numpy as np
from scipy.integrate import cumulative_trapezoid


@dataclass(frozen=True)
class ArchUnderFill:
    """An arch between immovable abutments, under fill and a level road.

    A live load of 1 acts on the left half of the road.

    Parameters
    ----------
    span, rise: span and rise of the intrados, a circle or a parabola, symmetric about x = 0, above y = 0.
    cover: depth of the fill over the crown.
    unit_weight, fill_weight: unit weights of the ring and of the fill; 0 for an arch without fill.
    load_at: abscissa of the live load.
    spread: tangent of the angle to the vertical within which the load spreads; 0 is straight down.
    active, passive: coefficients of active and passive earth pressure; a passive of 0 means no pressure.
    backing: height of the top of the backing; its unit weight and its pressure coefficients follow.
    steps: number of steps along the arch, equal in angle (circle) or in span (parabola). Hinges lie at the
        ends of the steps.
    """

    span: float
    rise: float
    thickness: float
    cover: float
    width: float
    unit_weight: float
    fill_weight: float
    load_at: float
    parabolic: bool = False
    spread: float = 0.0
    active: float = 0.0
    passive: float = 0.0
    backing: float = -math.inf
    backing_weight: float = 0.0
    backing_active: float = 0.0
    backing_passive: float = 0.0
    steps: int = 600

    @cached_property
    def intrados(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return points of the intrados, normals, lengths per unit of the parameter, and curvatures."""
        u, half = np.linspace(-1, 1, self.steps + 1), self.span / 2
        if self.parabolic:
            length = np.hypot(half, 2 * self.rise * u)
            normal = np.column_stack([2 * self.rise * u, np.full_like(u, half)]) / length[:, None]
            return (
                np.column_stack([half * u, self.rise * (1 - u**2)]),
                normal,
                length,
                2 * self.rise * half / length**3,
            )
        radius = (half**2 + self.rise**2) / (2 * self.rise)
        angle = math.asin(half / radius)
        normal = np.column_stack([np.sin(u * angle), np.cos(u * angle)])
        points = radius * normal + [0, self.rise - radius]
        return points, normal, np.full_like(u, radius * angle), np.full_like(u, 1 / radius)

    @cached_property
    def back(self) -> np.ndarray:
        """Return the points of the extrados."""
        points, normal, _, _ = self.intrados
        return points + self.thickness * normal

    @property
    def road(self) -> float:
        return self.rise + self.thickness + self.cover

    @cached_property
    def dead(self) -> np.ndarray:
        """Return the weight to the left of each joint, and its moment about x = 0, shape (2, joints)."""
        (points, normal, length, curvature), t = self.intrados, self.thickness
        area = length * (t + curvature * t**2 / 2)
        moment = points[:, 0] * area + normal[:, 0] * length * (t**2 / 2 + curvature * t**3 / 3)
        u = np.linspace(-1, 1, self.steps + 1)
        ring = [cumulative_trapezoid(each, u, initial=0) for each in (area, moment)]
        x, stress = self.back[:, 0], self.stress(self.back[:, 1])
        fill = [cumulative_trapezoid(each, x, initial=0) for each in (stress, stress * x)]
        return self.width * (self.unit_weight * np.array(ring) + np.array(fill))

    def stress(self, y: np.ndarray) -> np.ndarray:
        """Return the vertical stress from the fill and the backing at each height."""
        backed = np.maximum(self.backing - y, 0.0)
        return self.fill_weight * (self.road - y - backed) + self.backing_weight * backed

    @cached_property
    def live(self) -> np.ndarray:
        """Return the live load to the left of each joint, and its moment about x = 0, shape (2, joints).

        The load is spread uniformly over the tangent of the angle to the vertical.
        """
        x, depth = self.back[:, 0], self.road - self.back[:, 1]
        if self.spread:
            tangent = np.clip((x - self.load_at) / depth, -self.spread, self.spread)
            left = (tangent / self.spread + 1) / 2
            return np.array([left, cumulative_trapezoid(x, left, initial=0)])
        left = (x > self.load_at).astype(float)
        return np.array([left, left * self.load_at])

    def load_factors(self, hinges: np.ndarray) -> np.ndarray:
        """Return the load factors of four-hinge mechanisms, given by their joints, shape (4, tries).

        From left to right, the hinges lie at the intrados, the extrados, the intrados and the extrados.
        The load factor is infinite if the hinges do not open while the load moves down.
        """
        a, b, c, d = hinges
        inner = self.intrados[0]
        (ax, ay), (bx, by), (cx, cy), (dx, dy) = inner[a].T, self.back[b].T, inner[c].T, self.back[d].T
        with np.errstate(divide="ignore", invalid="ignore"):
            # The middle part turns counter-clockwise by 1 about the intersection of the lines AB and DC.
            across = (bx - ax) * (cy - dy) - (by - ay) * (cx - dx)
            on = ((dx - ax) * (cy - dy) - (dy - ay) * (cx - dx)) / across
            ix, iy = ax + on * (bx - ax), ay + on * (by - ay)
            left, right = (bx - ix) / (bx - ax), (cx - ix) / (cx - dx)
            parts = ((a, b, left, ax, ay), (b, c, np.ones_like(ix), ix, iy), (c, d, right, dx, dy))
            dead, live = (
                -sum(
                    turn * (load[1, end] - load[1, start] - x * (load[0, end] - load[0, start]))
                    for start, end, turn, x, _ in parts
                )
                for load in (self.dead, self.live)
            )
            if self.passive:
                dead = dead + sum(self._pressure(*part) for part in parts)
            opens = (left < 0) & (right < 0) & (live > 0)
            return np.where(opens, -dead / live, math.inf)

    def _pressure(
        self, start: np.ndarray, end: np.ndarray, turn: np.ndarray, _: np.ndarray, centre: np.ndarray
    ) -> np.ndarray:
        """Return the power of the earth pressure on a part; it is passive if the part moves into the fill."""
        y, step = (self.back[1:, 1] + self.back[:-1, 1]) / 2, np.arange(self.steps)
        force = self.width * self.stress(y) * np.diff(self.back[:, 1])
        moved = -turn[:, None] * (y - centre[:, None]) * force
        passive = np.where(y < self.backing, self.backing_passive, self.passive)
        power = (
            np.where(moved < 0, passive, np.where(y < self.backing, self.backing_active, self.active)) * moved
        )
        return np.where((step >= start[:, None]) & (step < end[:, None]), power, 0.0).sum(axis=1)

    def load_factor(self) -> float:
        """Return the least load factor of all mechanisms.

        The search begins with the best mechanism on a coarse choice of joints, without earth pressure. It
        then moves all hinges at once by smaller and smaller steps.
        """
        some = np.unique(np.linspace(0, self.steps, 25).round().astype(int))
        coarse = np.array([*combinations(some, 4)]).T
        best = coarse[:, np.argmin(replace(self, passive=0.0).load_factors(coarse))]
        moves, step = np.array([*product((-1, 0, 1), repeat=4)]).T, self.steps // 16
        while step:
            tries = np.clip(best[:, None] + step * moves, 0, self.steps)
            tries = tries[:, (np.diff(tries, axis=0) > 0).all(axis=0)]
            better = tries[:, np.argmin(self.load_factors(tries))]
            if self.load_factors(better[:, None])[0] < self.load_factors(best[:, None])[0]:
                best = better
            else:
                step //= 2
        return float(self.load_factors(best[:, None])[0])
