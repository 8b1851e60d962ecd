"""The contact law: elastic contacts without tension, Coulomb friction, and permanent slip.

A contact deforms elastically from the forces that it remembers. The trial forces n~ and s~ are the forces
without opening or slip. With the stiffnesses k_n and k_s, the friction μ, the cohesion c and dilatancy tan ψ,
the return mapping (Simo & Hughes, Computational Inelasticity, 1998, section 1.4.2) finds the slip P ≥ 0:

    (1)  n_i = max(0, n~_i + k_n tan ψ P)        at each contact point i of the joint
    (2)  L   = c + μ Σ n_i                       limit of the shear
    (3)  |s| = |s~| - k_s P ≤ L                  with P = 0 if |s~| ≤ c + μ Σ max(0, n~_i)
    (4)  s   = |s| s~ / |s~|                     radial return; in the plane this is the sign of s~

In the plane a joint has two contact points and one shear, in space one contact point and two shears. If the
joint does not dilate, P follows directly from (2) and (3). Otherwise |s~| - k_s P - L(P) is piecewise linear
and decreases with P, and Newton's method ends after a few iterations.

Joints of limited strength: instead of (1), the normal forces of both contact points are the admissible forces
nearest to the trial forces, within the chords of the strength parabola. Crushing is elastic: the contact does
not remember it.

Limited forces (ties, props, earth): T = min(highest, max(lowest, T~)). Yield is remembered, but slack is not:
a slack rod takes up force again at the length at which it lost its force.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.problem.faces import CHORDS
from masonry_opt.problem.problem import Problem


def mean_force_and_compliance(
    problem: Problem, settings: IncrementalSettings | None = None
) -> tuple[float, np.ndarray]:
    """Return the mean contact force under the dead load, and the elastic compliances, shape (3c + t,).

    Under the mean force a joint of mean length (in space: mean area) closes by one unit. The stiffness is
    proportional to the length or area. As is typical of stone, it is half as large in shear as in the normal
    direction. The mean force is computed from the least-squares solution of equilibrium under the dead load.

    Forces without limits hold a support that settles. A support moves only as prescribed, so these forces are
    stiffer than a tie by the factor 1 / ``tolerance``, and their deformation is negligible.
    """
    settings = settings or IncrementalSettings()
    c, t, points = problem.joints, problem.matrices.limited, problem.layout.points
    products = problem.B @ problem.B.T
    # Regularise the matrix: increase each diagonal entry by a fixed fraction of its value. A constant
    # increase would be lost by rounding in large entries, which belong to blocks with many joints or long
    # lever arms.
    added = settings.regularisation * np.maximum(products.diagonal(), 1.0)
    blocks = products + sp.diags_array(added)
    forces = problem.B.T @ spsolve(blocks.tocsc(), -problem.dead)
    # If no blocks touch, only ties carry the load: use the mean force of the ties.
    at_contacts = problem.at_points(forces) if c else problem.of_forces(forces)
    mean_force = float(np.abs(at_contacts).mean()) or 1.0
    extent = np.append(problem.matrices.extent, np.ones(t))
    normal = extent.mean() / extent / mean_force
    shear = np.tile(2 / points * normal[:c], 3 - points)
    holds = np.isinf(problem.lowest) & np.isinf(problem.highest)
    limited = normal[c:] / 2 * np.where(holds, settings.tolerance, 1.0)
    return mean_force, np.concatenate([np.tile(normal[:c], points), shear, limited])


@dataclass(frozen=True)
class Response:
    """Response of all contacts to trial forces: contact forces, derivatives, and the state of each joint."""

    #: Forces of the contacts, shape (3, m): one column per joint, then one per limited force, such as the
    #: force of a tie. The rows of a joint are n₁, n₂ and s (in space n, s and t). A limited force is in the
    #: third row; the other rows are zero.
    forces: np.ndarray
    tangent: np.ndarray  #: derivative of ``forces`` with respect to the trial forces, shape (3, 3, m)
    #: Trial forces with which the next load step or time step starts, shape (3, m). Permanent slip is
    #: subtracted from the deformation that causes these forces.
    remembered: np.ndarray
    sliding: np.ndarray  #: True for each closed joint at its friction limit, shape (c,)
    open: np.ndarray  #: True for each joint without normal force, shape (c,)


class ContactLaw:
    """Contact law of all joints and limited forces of a problem: the return mapping, eqs (1) to (4)."""

    def __init__(
        self,
        problem: Problem,
        compliance: np.ndarray,
        mean_force: float = 1.0,
        settings: IncrementalSettings | None = None,
    ) -> None:
        """Set up the law of a problem.

        ``compliance`` is the elastic deformation per unit of each force of the problem, shape (3c + t,).
        ``mean_force`` is the mean contact force under the dead load.
        """
        settings = settings or IncrementalSettings()
        self._rounding, self._iterations = settings.rounding, settings.newton_iterations
        self._touching = self._rounding * mean_force
        joints = problem.joints
        self.joints, self.points = joints, problem.layout.points
        self.stiffness = 1 / by_joint(compliance, joints, fill=1.0)
        self.can_slide = np.isin(np.arange(joints), problem.sliding)
        self.friction, self.dilatancy, self.cohesion = np.zeros((3, joints))
        self.friction[problem.sliding] = problem.friction
        self.dilatancy[problem.sliding] = problem.dilatancy
        self.cohesion[problem.sliding] = problem.cohesion
        self.strength = StrengthPolygon(problem.crushing, problem.crushing_force)
        bounded = np.isfinite(problem.lowest), np.isfinite(problem.highest)
        self._yields_at_lowest = bounded[0] & (problem.lowest != 0)
        self._yields_at_highest = bounded[1] & (problem.highest != 0)
        self.lowest, self.highest = problem.lowest, problem.highest
        self._dilates = bool(self.dilatancy.any())
        self._opening_stiffness = self.stiffness[0, :joints] * self.dilatancy
        self._shear_stiffness = self.stiffness[2, :joints]

    @property
    def count(self) -> int:
        """Number of joints and limited forces, m."""
        return self.stiffness.shape[1]

    def of_problem(self, forces: np.ndarray) -> np.ndarray:
        """Convert forces of shape (3, m) to the order of the problem, shape (3c + t,).

        This is the inverse of :func:`by_joint`.
        """
        return np.concatenate([forces[:2, : self.joints].ravel(), forces[2]])

    def respond(self, trial: np.ndarray) -> Response:
        """Return the response of all contacts to given trial forces, shape (3, m)."""
        forces, remembered = np.zeros((2, *trial.shape))
        tangent = np.zeros((3, *trial.shape))
        joints = slice(self.joints)
        at_limit = self._map_joints(
            trial[:, joints], forces[:, joints], tangent[:, :, joints], remembered[:, joints]
        )
        if self.joints < self.count:
            self._limit_forces(trial, forces, tangent, remembered)
        is_open = self._all_points(forces[: self.points, joints] == 0)
        return Response(forces, tangent, remembered, at_limit & ~is_open, is_open)

    def _limit_forces(
        self, trial: np.ndarray, forces: np.ndarray, tangent: np.ndarray, remembered: np.ndarray
    ) -> None:
        """Write the response of the limited forces into ``forces``, ``tangent`` and ``remembered``.

        Limited forces are the forces of ties and props, and earth pressure.
        """
        limited = slice(self.joints, None)
        free = trial[2, limited]
        forces[2, limited] = np.clip(free, self.lowest, self.highest)
        tangent[2, 2, limited] = ~self._yield(free) & (free >= self.lowest) & (free <= self.highest)
        slack = (free < self.lowest) & (self.lowest == 0)
        remembered[2, limited] = np.where(slack, free, forces[2, limited])

    def _yield(self, free: np.ndarray) -> np.ndarray:
        """Return a mask of the limited forces that yield under their trial forces, shape (t,).

        A rod with a limit of zero does not yield at this limit, because it only becomes slack.
        """
        at_lowest, at_highest = self._yields_at_lowest, self._yields_at_highest
        lowest, highest = self.lowest[at_lowest], self.highest[at_highest]
        yields = np.zeros(free.shape, dtype=bool)
        yields[at_lowest] |= free[at_lowest] <= lowest + self._rounding * np.abs(lowest)
        yields[at_highest] |= free[at_highest] >= highest - self._rounding * np.abs(highest)
        return yields

    def _map_joints(
        self, trial: np.ndarray, forces: np.ndarray, tangent: np.ndarray, remembered: np.ndarray
    ) -> np.ndarray:
        """Write the joints' response, eqs (1) to (4), into ``forces``, ``tangent`` and ``remembered``.

        Return True for each joint at its friction limit, shape (c,).
        """
        normal, shear = slice(self.points), slice(self.points, 3)
        size = np.abs(trial[2]) if self.points == 2 else np.hypot(trial[1], trial[2])
        n, tangent[normal, normal] = self._press(trial[normal])
        limit = self.cohesion + self.friction * self._sum_of_points(n)
        # A joint without any force sticks. Otherwise every joint would slide before the dead load is applied.
        untouched = (size <= self._touching) & ~self._all_points(trial[normal] < -self._touching)
        slides = self.can_slide & (size >= (1 - self._rounding) * limit) & ~untouched
        remembered[normal] = trial[normal]
        if self._dilates:
            slip = self._find_slip(trial[normal], size, slides)
            remembered[normal] += self._opening_stiffness * slip
            n, tangent[normal, normal] = self._press(remembered[normal])
            limit = self.cohesion + self.friction * self._sum_of_points(n)
        divisor = np.where(size > 0, size, 1.0)
        direction = trial[shear] / divisor
        ratio = np.where(slides, limit / divisor, 1.0)
        forces[normal], forces[shear] = n, ratio * trial[shear]
        remembered[shear] = forces[shear]
        self._add_slip_tangent(tangent, direction, ratio, slides)
        return slides

    def _add_slip_tangent(
        self, tangent: np.ndarray, direction: np.ndarray, ratio: np.ndarray, slides: np.ndarray
    ) -> None:
        """Add the derivatives of shear forces to a tangent that contains the derivatives of normal forces."""
        normal, shear = slice(self.points), slice(self.points, 3)
        pressed = self._sum_of_points(tangent[normal, normal])
        limit_rate = slides * self.friction * pressed
        if self._dilates:
            opens = self._opening_stiffness
            total = self._shear_stiffness + self.friction * opens * pressed.sum(axis=0)
            slip_by_normal, slip_by_size = -limit_rate / total, slides / total
            pressed_by_slip = opens * tangent[normal, normal].sum(axis=1)
            limit_by_slip = self.friction * opens * pressed.sum(axis=0)
            tangent[normal, normal] += pressed_by_slip[:, None] * slip_by_normal
            tangent[normal, shear] = pressed_by_slip[:, None] * slip_by_size * direction
            limit_rate = limit_rate + limit_by_slip * slip_by_normal
            tangent[shear, shear] = direction[:, None] * direction * (limit_by_slip * slip_by_size)
        tangent[shear, normal] = direction[:, None] * limit_rate
        if self.points == 2:
            tangent[2, 2] += ~slides
            return
        across = np.eye(2)[:, :, None] - direction[:, None] * direction
        tangent[shear, shear] += np.where(slides, ratio * across, np.eye(2)[:, :, None])

    def _sum_of_points(self, values: np.ndarray) -> np.ndarray:
        """Return the sum of values over the contact points of each joint.

        The values have one row for each contact point. An addition is faster than a sum over two rows.
        """
        total: np.ndarray = values[0] + values[1] if self.points == 2 else values[0]
        return total

    def _all_points(self, values: np.ndarray) -> np.ndarray:
        """Return a mask of the joints for which a condition is true at all contact points, shape (c,)."""
        result: np.ndarray = values[0] & values[1] if self.points == 2 else values[0]
        return result

    def _press(self, trial: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the normal forces that result from trial forces, eq. (1), and their derivatives.

        Slip is not considered here: callers add the effect of the opening that slip causes to the trial
        forces. The normal forces have shape (points, c). Their derivatives with respect to the trial forces
        have shape (points, points, c).
        """
        closed = trial >= -self._touching
        forces, rates = np.maximum(trial, 0.0), np.zeros((self.points, *trial.shape))
        for point in range(self.points):
            rates[point, point] = closed[point]
        crushing = self.strength.joints
        if len(crushing):
            forces[:, crushing], rates[:, :, crushing] = self.strength.project(trial[:, crushing])
        return forces, rates

    def _find_slip(self, trial: np.ndarray, size: np.ndarray, slides: np.ndarray) -> np.ndarray:
        """Return the slip P ≥ 0 of each joint, shape (c,), by Newton's method safeguarded by bisection."""
        stiff, opens = self._shear_stiffness, self._opening_stiffness
        low, high = np.zeros_like(size), size / stiff
        # Stop when the slip changes by less than this value. Rounding errors limit the accuracy, because
        # ``excess`` is a small difference of large terms.
        rounding = 1e-15 * high
        slip = low
        for _ in range(self._iterations):
            n, pressed = self._press(trial + opens * slip)
            excess = slides * (size - stiff * slip - self.cohesion - self.friction * n.sum(axis=0))
            low, high = np.where(excess > 0, slip, low), np.where(excess < 0, slip, high)
            step = excess / (stiff + self.friction * opens * pressed.sum(axis=(0, 1)))
            if (np.abs(step) <= rounding).all():
                break
            newton = slip + step
            slip = np.where((newton >= low) & (newton <= high), newton, (low + high) / 2)
        return slides * slip


class StrengthPolygon:
    """Polygon of the pairs (n₁, n₂) of normal forces that a joint of limited strength can carry.

    The polygon is convex: chords of the strength parabola limit the moment in both directions. Both contact
    points have the same stiffness, so that the return mapping is the projection onto the polygon. Forces are
    divided by the crushing force, so that one polygon is valid for all joints.
    """

    def __init__(self, joints: np.ndarray, crushing_force: np.ndarray) -> None:
        self.joints = joints  #: indices of the joints of limited strength, shape (l,)
        self._crushing_force = crushing_force  #: crushing force f_c L of each joint in ``joints``, shape (l,)

    @cached_property
    def _sides(self) -> "PolygonSides":
        """Sides of the polygon of admissible normal forces, in counter-clockwise order."""
        # Each corner is the intersection of two chords of the strength parabola, at the relative normal force
        # x = n / (f_c L).
        slope, constant = CHORDS.slope, CHORDS.constant
        inner = (constant[1:] - constant[:-1]) / (slope[:-1] - slope[1:])
        x = np.concatenate([[0.0], inner, [1.0]])
        moment = np.concatenate([[0.0], slope[:-1] * inner + constant[:-1], [0.0]])
        # Divided by f_c L, the forces n₁ and n₂ at a corner of the polygon are (x ± moment) / 2. The moment
        # is relative to f_c L²/2.
        upper = np.stack([(x + moment) / 2, (x - moment) / 2], axis=1)
        return PolygonSides(np.concatenate([upper, upper[-2:0:-1, ::-1]]))

    def project(self, trial: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the admissible normal forces nearest to the trial forces, and their derivatives.

        The forces have shape (2, l). The derivatives with respect to the trial forces have shape (2, 2, l).
        """
        points, sides = trial / self._crushing_force, self._sides
        distances = sides.distances(points)
        outside = np.flatnonzero(distances.max(axis=0) > 0)
        forces, rates = trial.copy(), np.zeros((2, *trial.shape))
        rates[0, 0] = rates[1, 1] = 1.0
        if len(outside):
            nearest, rates[:, :, outside] = sides.project(points[:, outside], distances[:, outside])
            forces[:, outside] = nearest * self._crushing_force[outside]
        return forces, rates


class PolygonSides:
    """Convex polygon onto which points can be projected. Its sides are in counter-clockwise order."""

    def __init__(self, corners: np.ndarray) -> None:
        sides = np.roll(corners, -1, axis=0) - corners
        self._corners = corners  #: first corner of each side, shape (sides, 2)
        self._length = np.hypot(sides[:, 0], sides[:, 1])
        self._along = sides / self._length[:, None]  #: direction of each side, shape (sides, 2)
        # The sides run counter-clockwise, so the outward normal of each side points to its right.
        self._outward = np.stack([self._along[:, 1], -self._along[:, 0]], axis=1)

    def distances(self, points: np.ndarray) -> np.ndarray:
        """Return the signed distances of points from the lines through the sides, shape (sides, points).

        The points have shape (2, points). Distances are positive on the outer side of a line.
        """
        of_corners = (self._outward * self._corners).sum(axis=1)
        distances: np.ndarray = self._outward @ points - of_corners[:, None]
        return distances

    def project(self, points: np.ndarray, distances: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Project outside points onto the polygon, and return the projected points and their derivatives.

        The points have shape (2, points), before and after the projection. The derivatives of the projected
        points with respect to the outside points have shape (2, 2, points). ``distances`` are the distances
        of the outside points from the lines through the sides, shape (sides, points).
        """
        place = self._along @ points - (self._along * self._corners).sum(axis=1)[:, None]
        within = np.clip(place, 0.0, self._length[:, None])
        nearest = (distances**2 + (place - within) ** 2).argmin(axis=0)
        at = within[nearest, np.arange(points.shape[1])]
        along = self._along[nearest].T
        on_side = (at > 0) & (at < self._length[nearest])
        return self._corners[nearest].T + at * along, on_side * along[:, None] * along


def by_joint(values: np.ndarray, joints: int, fill: float = 0.0) -> np.ndarray:
    """Rearrange values (3c + t,) to shape (3, m): one column for each joint, then one per limited force."""
    table = np.full((3, len(values) - 2 * joints), fill)
    table[:2, :joints] = values[: 2 * joints].reshape(2, joints)
    table[2] = values[2 * joints :]
    return table
