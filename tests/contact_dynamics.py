"""Scenes in the plane pushed by damped motion in time: blocks on springs that only press, with Coulomb slip.

A program beside the package, of whose code it takes the matrix of equilibrium and what contacts give. Slip is
remembered, and nothing is known of paths: :func:`load_carried` loads a wall by steps, and it must come to
rest under each; :func:`onset` raises the loads of several scenes side by side, slowly, and while they rest.
"""

from collections.abc import Iterable, Sequence

import numpy as np
import scipy.sparse as sp

from masonry_opt.methods.push.law import compliance
from masonry_opt.problem.problem import Problem

#: Stiffness of a contact, in median block weights over the unit of length.
STIFFNESS = 1e4
#: Share of the velocity left after a step; forces out of balance, over the largest load, of a wall at rest.
DAMPING, REST = 0.98, 1e-4
#: Steps after which it is first asked whether a wall falls, then each time after twice as many. It falls if
#: in the last half of them it has moved so many times as far as in the quarter before: 2 at a constant speed,
#: 1 where it slows down as 1/t; slow walls that come to rest reach 1.82.
FIRST, FALLS, MOST = 5_000, 1.9, 2_000_000
#: Of a load that grows: what it gains a step, over the highest to expect; forces out of balance, over the
#: largest of that load, above which it waits; steps between two looks at these. A scene falls where the load
#: has gained so little in so many steps; it is looked at up to so many times the highest to expect.
GAIN, WAITS, LOOK = 2e-5, 2e-3, 10
LITTLE, WINDOW, UP_TO = 5e-3, 100_000, 1.3
#: Friction of joints that cannot slide.
ROUGH = 1e9


class _Motion:
    """Blocks of problems in motion, side by side, from forces at rest (``settled``).

    Columns are the first points of all joints, then the second, then shears, then limited forces.
    """

    def __init__(
        self,
        problems: Sequence[Problem],
        stiffness: Sequence[np.ndarray],
        settled: Sequence[np.ndarray],
        damping: float = DAMPING,
    ) -> None:
        kinds = [np.repeat(range(4), [of.joints] * 3 + [of.matrices.limited]) for of in problems]
        order = np.argsort(np.concatenate(kinds), kind="stable")
        self.A = sp.csr_array(sp.block_diag([of.B for of in problems], "csc")[:, order])
        self.At, self.damping = sp.csr_array(self.A.T), damping
        self.joints = c = sum(of.joints for of in problems)
        stiff, rest = np.concatenate(stiffness)[order], np.concatenate(settled)[order]
        # A mass for each component of motion, with which a time step of one is stable.
        self.mass = 0.6 * (abs(self.A) @ (stiff * (abs(self.A).T @ np.ones(self.A.shape[0]))))
        self.normal, self.shear_stiffness = stiff[: 2 * c], stiff[2 * c :]
        self.pressed, self.shear = rest[: 2 * c], rest[2 * c :]
        self.friction = np.concatenate([_of_joints(of, of.friction, ROUGH) for of in problems])
        cohesion = [_of_joints(of, of.cohesion, 0.0) for of in problems]
        self.lowest = np.concatenate([*(-of for of in cohesion), *(of.lowest for of in problems)])
        self.highest = np.concatenate([*cohesion, *(of.highest for of in problems)])
        self.d, self.velocity = np.zeros((2, self.A.shape[0]))
        self.slid = np.zeros(len(self.shear))

    def step(self, load: np.ndarray) -> np.ndarray:
        """Forces out of balance under a load, after which blocks move by a step."""
        c, motion = self.joints, self.At @ self.d
        n = np.maximum(0.0, self.pressed - self.normal * motion[: 2 * c])
        held = np.zeros(len(self.shear))
        held[:c] = self.friction * (n[:c] + n[c:])
        slip = self.shear_stiffness * (motion[2 * c :] - self.slid)
        self.shear = np.clip(self.shear - slip, self.lowest - held, self.highest + held)
        self.slid = motion[2 * c :]
        force: np.ndarray = self.A @ np.concatenate([n, self.shear]) + load
        self.velocity = self.damping * self.velocity + force / self.mass
        self.d = self.d + self.velocity
        return force


def _of_joints(problem: Problem, values: np.ndarray, others: float) -> np.ndarray:
    by_joint = np.full(problem.joints, others)
    by_joint[problem.sliding] = values
    return by_joint


def load_carried(problem: Problem, load_factors: Iterable[float]) -> float:
    """The last of rising load factors under which a wall comes to rest, one after another."""
    extent = problem.matrices.extent
    stiffness = np.tile(STIFFNESS * extent / extent.mean(), 3)
    motion = _Motion([problem], [stiffness], [np.zeros(len(stiffness))])

    def rests(load: np.ndarray) -> bool:
        asked, moved, work = FIRST, np.inf, problem.live @ motion.d
        for number in range(MOST):
            force = motion.step(load)
            if number % 50 == 49 and np.abs(force).max() < REST * np.abs(load).max():
                return True
            if number + 1 == asked:
                before, moved = moved, problem.live @ motion.d - work
                work += moved
                if moved > FALLS * before:
                    return False
                asked *= 2
        raise AssertionError("neither falls nor comes to rest")

    assert rests(problem.dead), "falls under its weight"
    carried = 0.0
    for load_factor in load_factors:
        if not rests(problem.dead + load_factor * problem.live):
            break
        carried = load_factor
    return carried


def onset(
    problems: Sequence[Problem],
    settled: Sequence[np.ndarray],
    highest: Sequence[float],
    damping: float = DAMPING,
    most: int = MOST,
) -> np.ndarray:
    """The load factor at which a load that grows from forces at rest (``settled``) brings each of several
    problems down; NaN where it goes beyond ``UP_TO`` times the highest to expect, or steps run out."""
    motion = _Motion(problems, [1 / compliance(of) for of in problems], settled, damping)
    sizes = [of.dead.size for of in problems]
    starts, of_row = np.cumsum([0, *sizes[:-1]]), np.repeat(np.arange(len(problems)), sizes)
    top = np.array(highest)
    unit = top * np.array([of.force_sizes(of.live).max() for of in problems])
    dead, live = (np.concatenate([getattr(of, name) for of in problems]) for name in ("dead", "live"))
    gains, found = LOOK * GAIN * top, np.full(len(problems), np.nan)
    λ = np.zeros(len(problems))
    since, before = np.zeros((2, len(problems)))
    looked_at = np.ones(len(problems), bool)
    for number in range(LOOK, most, LOOK):
        for _ in range(LOOK):
            force = motion.step(dead + λ[of_row] * live)
        left = np.maximum.reduceat(np.abs(force), starts) / unit
        λ += np.where(looked_at & (left < WAITS), gains, 0.0)
        gained = λ > before + LITTLE * top
        before, since = np.where(gained, λ, before), np.where(gained, number, since)
        falls = looked_at & (number > since + WINDOW)
        found[falls] = λ[falls]
        looked_at &= ~falls & (λ < UP_TO * top)
        if not looked_at.any():
            break
    return found
