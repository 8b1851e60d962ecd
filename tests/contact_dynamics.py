"""Explicit contact dynamics of blocks in the plane and in space, compiled by Numba.

The program increases the live load on rigid blocks until they fall. It thus computes the incremental load
factor by simulation. Displacements are small: contact points and directions stay as drawn.

The model:

- A contact is a linear spring in compression only, n = max(0, −k·opening). Its stiffness k is proportional
  to the length or area of the contact.
- The shear of a joint (in space, of a contact point) is elastic, half as stiff as all normal forces of the
  joint together. After each time step, a return mapping enforces |s| ≤ c + μ n, so that slip is irreversible.
- Ties, props and earth pressures are springs whose force stays between its limits.
- Each time step reduces all velocities by a constant factor (damping). Masses are chosen so that explicit
  time steps of length one are stable. A common factor of all stiffness changes no force at rest.
- The dead load grows from zero, together with prestress and the least earth pressures. Then the live load
  grows. A load does not grow while the unbalanced forces are large.

The package supplies the positions of joints, the loads, friction and cohesion. The equilibrium matrix is that
of :mod:`second_program`. The model has neither dilatancy nor limited compressive strength.
"""

from dataclasses import dataclass
from functools import cache
from math import inf

import numpy as np
import scipy.sparse as sp
from second_program import program

import masonry_opt as mo
from masonry_opt.problem.assembly import Assembly, assemble


@dataclass(frozen=True)
class DynamicsSettings:
    """Rules for the growth of the load and for collapse. The defaults are slow and accurate."""

    #: Fraction of the velocity that remains after a time step. With a larger value, blocks swing further.
    damping: float = 0.98
    #: Growth of a load in a time step, relative to the whole load. A faster load overshoots more.
    gain: float = 5e-6
    #: Largest unbalanced force at which the load still grows, relative to the largest load component. A
    #: larger value detects a slow collapse later, at a load that is too high by about this force.
    waiting: float = 5e-4
    #: Largest unbalanced force of a scene at rest, relative to the largest load component.
    rest: float = 1e-4
    #: Largest number of time steps without growth of the load, after which a scene counts as fallen. A
    #: smaller number takes slow motions that come to rest for a collapse.
    patience: int = 1_000_000
    #: Growth of the load, relative to the whole load, after which the count of waiting steps restarts.
    progress: float = 5e-3
    #: Displacement since the last restart of the count at which a scene counts as fallen, relative to the
    #: largest load over the mean stiffness of a block. A smaller value takes large slips for a collapse.
    far: float = 1e5


DEFAULTS = DynamicsSettings()
#: Largest number of time steps, after which a scene counts as undecided.
LONGEST = 1_000_000_000
#: Coarse settings for tests: errors of 0.3 % where collapse is sudden.
QUICK = DynamicsSettings(gain=2e-5, patience=200_000, far=1e4)


class FallsUnderItsWeight(ArithmeticError):
    """The scene finds no equilibrium under its dead load."""


class Undecided(ArithmeticError):
    """The scene neither falls nor comes to rest within the allowed number of time steps."""


def collapse_load(scene: mo.Scene, highest: float, settings: DynamicsSettings = DEFAULTS) -> float:
    """Return the load factor under which a scene falls as its live load grows from zero.

    The load factor is ``inf`` if the scene comes to rest under the load factor ``highest``. The load grows by
    ``settings.gain`` times ``highest`` in a time step, so a value near the result is more accurate. Raises
    FallsUnderItsWeight if the scene does not carry its dead load.
    """
    return collapse_load_of(assemble(scene), highest, settings)


def collapse_load_of(assembly: Assembly, highest: float, settings: DynamicsSettings = DEFAULTS) -> float:
    """Return the load factor under which an assembly falls; :func:`collapse_load` explains the arguments."""
    motion = _Motion(assembly, settings)
    if motion.raise_load(np.zeros_like(motion.dead), motion.dead, preloads=True) < 1.0:
        raise FallsUnderItsWeight(assembly.scene.title)
    share = motion.raise_load(motion.dead, highest * motion.live)
    return inf if share >= 1.0 else share * highest


class _Motion:
    """Springs, masses and the state of motion of one scene, as arrays for compiled code.

    There are three columns for each slider: n₁, n₂ and s of a joint in the plane, or n, s and t of a contact
    point in space. The columns of limited forces follow.
    """

    def __init__(self, assembly: Assembly, settings: DynamicsSettings) -> None:
        joints, space = assembly.joints, assembly.scene.dimension == 3
        joint = joints.joint if space else np.arange(len(joints.first))
        if np.any(joints.dilatancy) or (np.isfinite(joints.strength) & (joints.extent > 0)).any():
            raise ValueError("contact dynamics has neither dilatancy nor limited strength")
        statics = sp.csc_array(program(assembly, inside=True)[0])
        sliders, limited = len(joint), len(assembly.limited)
        in_turn = np.arange(3 * sliders).reshape(3, sliders).T.ravel()
        columns = statics[:, np.append(in_turn, 3 * sliders + np.arange(limited))]
        stiffness = _stiffness(assembly, joint)
        self.columns = columns.indptr, columns.indices, columns.data
        # By Gershgorin's theorem, no squared frequency exceeds 1/0.6. Explicit steps are stable up to 4.
        row_sums = abs(columns) @ (stiffness * (abs(columns).T @ np.ones(columns.shape[0])))
        mass = 0.6 * np.where(row_sums > 0, row_sums, 1.0)
        area = joints.extent if space else joints.extent * assembly.scene.thickness
        share = (area / np.bincount(joint, minlength=len(area)))[joint]
        cohesion = np.nan_to_num(joints.cohesion[joint] * share / assembly.problem.force_unit)
        limits = np.array([(each.lowest, each.highest) for each in assembly.limited]).reshape(-1, 2)
        limits = limits / assembly.problem.force_unit
        self.law = stiffness, joints.friction[joint], cohesion, limits, 1 if space else 2
        self.dead, self.live, self.settings = assembly.problem.dead, assembly.problem.live, settings
        self.mass, self.shears = mass, np.zeros(columns.shape[1])
        self.moved, self.velocity = np.zeros(len(mass)), np.zeros(len(mass))
        self.stiffness = float(np.mean(row_sums))  # mean stiffness against the motion of a block

    def raise_load(self, base: np.ndarray, increment: np.ndarray, preloads: bool = False) -> float:
        """Return the share of a load increment that the scene carries in addition to a base load.

        The share is 1 if the scene comes to rest under the whole increment. With ``preloads``, limited forces
        that must act, such as prestress, grow with the increment. Raises Undecided if the scene neither falls
        nor comes to rest.
        """
        of, largest = self.settings, max(np.abs(base).max(), np.abs(increment).max())
        far = of.far * largest / self.stiffness
        share = _compiled()(
            *self.columns,
            *self.law,
            self.mass,
            (self.moved, self.velocity, self.shears),
            (base, increment, preloads),
            (of.damping, of.gain, of.waiting * largest, of.rest * largest, of.progress, far),
            of.patience,
        )
        if np.isnan(share):
            raise Undecided(f"no rest within {of.patience} steps, and no motion without end")
        return float(share)


def _stiffness(assembly: Assembly, joint: np.ndarray) -> np.ndarray:
    """Return the stiffness of each column.

    The stiffness of a contact point is its length or area, divided by the median. The stiffness of a shear is
    half of that of all normal forces of its joint. A limited force has twice the median stiffness. A force
    without limits, which holds a support that settles, has a thousand times as much.
    """
    extent = assembly.joints.extent
    share = (extent / np.bincount(joint, minlength=len(extent)))[joint]
    median = float(np.median(share[share > 0])) if share.any() else 1.0
    of_point = np.where(share > 0, share / median, 1.0)
    in_plane = assembly.scene.dimension == 2
    of_slider = of_point[:, None] * np.array([1.0, 1.0, 1.0] if in_plane else [1.0, 0.5, 0.5])
    holds = [force.lowest == -inf and force.highest == inf for force in assembly.limited]
    return np.append(of_slider.ravel(), np.where(holds, 2000.0, 2.0))


@cache
def _compiled():
    """Return :func:`_raise_load` in machine code.

    Numba is imported here, because that takes half a second, and few of the tests need it.
    """
    import numba

    return numba.njit(cache=True)(_raise_load)


def _raise_load(  # noqa: C901, PLR0912, PLR0913, PLR0915 - one compiled loop over time steps
    pointers, rows, values, stiffness, friction, cohesion, limits, points, mass, state, loads, rules, patience
):
    """Return the share of the load increment that is carried in addition to the base load.

    The function takes explicit time steps. The share is NaN if the scene still moves under the whole load
    after ``patience`` steps.
    """
    moved, velocity, shears = state
    base, increment, preloads = loads
    damping, gain, waiting, rest, progress, far = rules
    sliders, columns, size = len(friction), len(stiffness), len(mass)
    force, origin = np.empty(size), moved.copy()
    share, reached, since = 0.0, 0.0, 0
    for number in range(LONGEST):
        force[:] = base + share * increment
        for slider in range(sliders):
            first = 3 * slider
            pressed = 0.0
            for column in range(first, first + points):
                opening = 0.0
                for entry in range(pointers[column], pointers[column + 1]):
                    opening += values[entry] * moved[rows[entry]]
                if opening < 0.0:
                    normal = -stiffness[column] * opening
                    pressed += normal
                    for entry in range(pointers[column], pointers[column + 1]):
                        force[rows[entry]] += normal * values[entry]
            squared = 0.0
            for column in range(first + points, first + 3):
                slip = 0.0
                for entry in range(pointers[column], pointers[column + 1]):
                    slip += values[entry] * velocity[rows[entry]]
                shears[column] -= stiffness[column] * slip
                squared += shears[column] ** 2
            most = np.inf
            if np.isfinite(friction[slider]):
                most = cohesion[slider] + friction[slider] * pressed
            factor = 1.0
            if squared > most * most:
                factor = most / np.sqrt(squared)
            for column in range(first + points, first + 3):
                shears[column] *= factor
                for entry in range(pointers[column], pointers[column + 1]):
                    force[rows[entry]] += shears[column] * values[entry]
        for column in range(3 * sliders, columns):
            stretch = 0.0
            for entry in range(pointers[column], pointers[column + 1]):
                stretch += values[entry] * velocity[rows[entry]]
            number_of = column - 3 * sliders
            held = shears[column] - stiffness[column] * stretch
            low, high = limits[number_of, 0], limits[number_of, 1]
            if preloads:
                # A force that must act grows with the dead load.
                if low > 0.0:
                    low *= share
                if high < 0.0:
                    high *= share
            shears[column] = min(max(held, low), high)
            for entry in range(pointers[column], pointers[column + 1]):
                force[rows[entry]] += shears[column] * values[entry]
        unbalanced, moves = 0.0, 0.0
        for row in range(size):
            unbalanced = max(unbalanced, abs(force[row]))
            velocity[row] = damping * velocity[row] + force[row] / mass[row]
            moved[row] += velocity[row]
            moves = max(moves, abs(moved[row] - origin[row]))
        if share >= 1.0 and unbalanced < rest:
            return 1.0
        if unbalanced < waiting and share < 1.0:
            share = min(1.0, share + gain)
        if share > reached + progress:
            reached, since = share, number
            origin[:] = moved
        if moves > far or (share < 1.0 and number - since > patience):
            return min(share, 1.0 - 1e-12)
        if number - since > patience:
            return np.nan
    return np.nan
