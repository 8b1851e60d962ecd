"""A wall pushed in steps, by damped motion in time: blocks on springs that only press, with Coulomb slip.

A program beside the package, of whose code it takes the matrix of equilibrium alone. The wall first comes to
rest under its weight; then the load grows by steps, and the wall must come to rest under each.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from masonry_opt.problem.problem import Problem

#: Stiffness of a contact, in median block weights over the unit of length.
STIFFNESS = 1e4
#: Share of the velocity left after a step; forces out of balance, over the largest load, of a wall at rest.
DAMPING, REST = 0.98, 1e-4
#: Steps after which it is first asked whether a wall falls, then each time after twice as many. It falls if
#: in the last half of them it has moved so many times as far as in the quarter before: 2 at a constant speed,
#: 1 where it slows down as 1/t; slow walls that come to rest reach 1.82.
FIRST, FALLS, MOST = 5_000, 1.9, 2_000_000
#: Friction of joints that cannot slide.
ROUGH = 1e9


@dataclass
class _Motion:
    d: np.ndarray
    velocity: np.ndarray
    shear: np.ndarray
    slid: np.ndarray


def load_carried(problem: Problem, load_factors: Iterable[float]) -> float:
    """The last of rising load factors under which a wall comes to rest, one after another."""
    A, c, extent = problem.B, problem.joints, problem.matrices.extent
    stiff = np.tile(STIFFNESS * extent / extent.mean(), 3)
    # A mass for each component of motion, with which a time step of one is stable.
    mass = 0.6 * (abs(A) @ (stiff * (abs(A).T @ np.ones(A.shape[0]))))
    friction, cohesion = np.full(c, ROUGH), np.zeros(c)
    friction[problem.sliding], cohesion[problem.sliding] = problem.friction, problem.cohesion

    def at_rest(load: np.ndarray, at: _Motion) -> _Motion | None:
        d, velocity, shear, slid = at.d, at.velocity, at.shear, at.slid
        asked, moved, work = FIRST, np.inf, problem.live @ d
        for number in range(MOST):
            motion = A.T @ d
            pressed = np.maximum(0.0, -stiff[: 2 * c] * motion[: 2 * c])
            most = cohesion + friction * (pressed[:c] + pressed[c:])
            shear = np.clip(shear - stiff[2 * c :] * (motion[2 * c :] - slid), -most, most)
            slid = motion[2 * c :]
            force = A @ np.concatenate([pressed, shear]) + load
            if number % 50 == 49 and np.abs(force).max() < REST * np.abs(load).max():
                return _Motion(d, velocity, shear, slid)
            velocity = DAMPING * velocity + force / mass
            d = d + velocity
            if number + 1 == asked:
                before, moved, work = moved, problem.live @ d - work, problem.live @ d
                if moved > FALLS * before:
                    return None
                asked *= 2
        raise AssertionError("neither falls nor comes to rest")

    still = np.zeros(A.shape[0])
    state = at_rest(problem.dead, _Motion(still, still, np.zeros(c), np.zeros(c)))
    assert state is not None, "falls under its weight"
    carried = 0.0
    for load_factor in load_factors:
        state = at_rest(problem.dead + load_factor * problem.live, state)
        if state is None:
            break
        carried = load_factor
    return carried
