"""A wall pushed in steps, by damped motion in time: blocks on springs that only press, with Coulomb slip.

A program beside the package, of whose code it takes the matrix of equilibrium alone. The wall first comes to
rest under its weight; then the load grows by steps, and the wall must come to rest under each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from masonry_opt.problem.problem import Problem

#: Stiffness of a contact, in median block weights over the unit of length.
STIFFNESS = 1e4
#: Share of the velocity left after a step; forces out of balance, over the largest load, of a wall at rest;
#: steps after which a wall that is not at rest falls.
DAMPING, REST, FALLS = 0.98, 1e-4, 20_000


@dataclass
class _Motion:
    d: np.ndarray
    velocity: np.ndarray
    shear: np.ndarray
    slid: np.ndarray


def load_carried(problem: Problem, step: float, share: float) -> float:
    """Largest load factor that a wall carries from rest, to a share of itself.

    Parameters
    ----------
    step: first step of the load factor, halved each time the wall falls.
    """
    edges = problem.table.from_edges
    A = sp.csr_array(problem.B @ edges)
    c = problem.joints
    stiff = np.tile(STIFFNESS * problem.half_length / problem.half_length.mean(), 3)
    # A mass for each component of motion, with which a time step of one is stable.
    mass = 0.6 * (abs(A) @ (stiff * (abs(A).T @ np.ones(A.shape[0]))))
    friction, cohesion = np.full(c, np.inf), np.zeros(c)
    friction[problem.sliding], cohesion[problem.sliding] = problem.friction, problem.cohesion

    def at_rest(load: np.ndarray, at: _Motion) -> _Motion | None:
        d, velocity, shear, slid = at.d, at.velocity, at.shear, at.slid
        for number in range(FALLS):
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
        return None

    still = np.zeros(A.shape[0])
    state = at_rest(problem.dead, _Motion(still, still, np.zeros(c), np.zeros(c)))
    assert state is not None, "falls under its weight"
    carried = 0.0
    while step > share * max(carried, 1e-3):
        pushed = at_rest(problem.dead + (carried + step) * problem.live, state)
        if pushed is None:
            step /= 2
        else:
            carried, state = carried + step, pushed
    return carried
