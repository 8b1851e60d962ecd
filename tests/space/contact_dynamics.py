"""Blocks in space pushed from rest: springs that only press, with Coulomb slip, in viscous motion.

The blocks first come to rest under their weight; then the load grows, and they must come to rest under each.
Displacements are small: contact points and directions stay. Every time step is an implicit one, solved by
Newton's method: B q + load = viscosity, where at each point n = k max(0, −opening), and the shear is the last
one less k/2 times the slip since, returned to the cone |(s, t)| ≤ c + μ n (Simo and Hughes, Computational
Inelasticity, 1998, ch. 2, with the normal force of the end of the step). As the geometry stays, forces at
rest do not depend on k: it is 1 on the mean area of a point. What acts where is `second_program`'s.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from second_program import Points, points_of

import masonry_opt as mo

#: Stiffness in shear over that of the normal.
SHEAR_STIFFNESS = 0.5
#: Forces out of balance, over the mean weight of a block, of blocks at rest.
REST = 1e-6
#: They fall once they have moved under a load by so many times what the mean weight presses a point in.
FALLS = 1e5
#: First time step after a new load, in viscosity over stiffness; the shortest that is tried.
FIRST_STEP, SHORTEST = 10.0, 1e-6


@dataclass(frozen=True)
class State:
    """Displacements, shape (6 × free bodies,), and forces (n, s, t), shape (points, 3), of blocks at rest."""

    moved: np.ndarray
    forces: np.ndarray


@dataclass(frozen=True)
class Springs:
    """What holds one wall: friction and stiffness of its contact points, cohesion of each as a force."""

    wall: Points
    friction: float
    cohesion: np.ndarray
    stiffness: np.ndarray

    def forces(self, moved: np.ndarray, last: State) -> tuple[np.ndarray, sp.csc_array]:
        """Forces at the points, shape (points, 3), and minus their derivatives by the motion there."""
        k, points = self.stiffness, len(self.stiffness)
        motion = (self.wall.B.T @ moved).reshape(points, 3)
        since = motion[:, 1:] - (self.wall.B.T @ last.moved).reshape(points, 3)[:, 1:]
        pressing = motion[:, 0] < 0
        normal = np.where(pressing, -k * motion[:, 0], 0.0)
        trial = last.forces[:, 1:] - SHEAR_STIFFNESS * k[:, None] * since
        size, most = np.hypot(*trial.T), self.friction * normal + self.cohesion
        slides = size > most
        share = np.where(slides, most / np.where(slides, size, 1.0), 1.0)
        along = trial / np.where(slides, size, 1.0)[:, None]
        tangent = np.zeros((points, 3, 3))
        tangent[:, 0, 0] = k * pressing
        across = np.eye(2) - slides[:, None, None] * along[:, :, None] * along[:, None, :]
        tangent[:, 1:, 1:] = (SHEAR_STIFFNESS * k * share)[:, None, None] * across
        tangent[:, 1:, 0] = (k * self.friction * (pressing & slides))[:, None] * along
        blocks = sp.bsr_array((tangent, np.arange(points), np.arange(points + 1)))
        return np.column_stack([normal, share[:, None] * trial]), sp.csc_array(blocks)

    def step(self, load: np.ndarray, drag: np.ndarray, last: State, guess: np.ndarray) -> State | None:
        """State after a time step, from a guess of its displacements; None where Newton does not end."""
        B, moved = self.wall.B, guess
        for _ in range(20):
            forces, tangent = self.forces(moved, last)
            rest = B @ forces.ravel() + load - drag * (moved - last.moved)
            if np.abs(rest).max() < REST / 10 * self.unit:
                return State(moved, forces)
            moved = moved + spla.spsolve(B @ tangent @ B.T + sp.diags_array(drag), rest)
        return None

    @property
    def unloaded(self) -> State:
        return State(np.zeros(len(self.wall.dead)), np.zeros((len(self.stiffness), 3)))

    @property
    def unit(self) -> float:
        return float(np.abs(self.wall.dead).sum() / (len(self.wall.dead) / 6))

    def at_rest(self, load: np.ndarray, begin: State) -> State | None:
        """Blocks come to rest from a state under a load; None where they fall.

        Time steps double while Newton's method ends. Drag on each component of motion is as the stiffness
        against it, so that time counts in viscosity over stiffness. Raises ArithmeticError where no time step
        is short enough.
        """
        shear = SHEAR_STIFFNESS * self.stiffness
        stiff = self.wall.B**2 @ np.column_stack([self.stiffness, shear, shear]).ravel()
        state, duration, velocity = begin, FIRST_STEP, np.zeros_like(begin.moved)
        while duration > SHORTEST:
            drag = stiff / duration
            new = self.step(load, drag, state, state.moved + duration * velocity)
            if new is None:
                duration /= 4
                continue
            velocity = (new.moved - state.moved) / duration
            state = new
            if np.abs(stiff * velocity).max() < REST * self.unit:
                return state
            if np.abs(state.moved - begin.moved).max() > FALLS * self.unit:
                return None
            duration *= 2
        raise ArithmeticError("no time step is short enough")


def of_scene(scene: mo.Scene) -> Springs:
    """Springs as stiff as their contact points have area, in units of force of the scene's own."""
    wall, joints = points_of(scene), scene.joints
    return Springs(wall, joints.friction, joints.cohesion * wall.share, wall.share / wall.share.mean())


def load_carried(scene: mo.Scene, increment: float = 0.01, least: float = 5e-4) -> float:
    """Greatest load factor under which the blocks come to rest, to within the least increment.

    The load grows by increments, halved after each under which they fall. Raises ArithmeticError where they
    fall under their weight, or neither fall nor come to rest.
    """
    springs = of_scene(scene)
    wall, state = springs.wall, springs.at_rest(springs.wall.dead, springs.unloaded)
    if state is None:
        raise ArithmeticError("falls under its weight")
    carried = 0.0
    while increment >= least:
        new = springs.at_rest(wall.dead + (carried + increment) * wall.live, state)
        if new is None:
            increment /= 2
        else:
            carried, state = carried + increment, new
    return carried
