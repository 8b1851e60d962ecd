"""Collapse load factors of arches by enumeration of the thrust lines through four hinges (Heyman)."""

from itertools import combinations

import numpy as np

import masonry_opt as mo


def radial_joints(arch: mo.Arch) -> np.ndarray:
    """Return the ends of the joints of a circular arch about the origin for ``four_hinge_load_factors``."""
    angles = np.radians(np.linspace(*arch.angles, arch.voussoirs + 1))
    radial = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    half = arch.thickness / 2
    return np.stack([radial * (arch.radius - half), radial * (arch.radius + half)], axis=1)


def four_hinge_load_factors(joints: np.ndarray, weight: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return the load factors of all thrust lines through four hinges that lie within the arch.

    Blocks cannot slide. Their loads are their weight, and λ times their weight to the right. The collapse
    load factor is the largest load factor of all thrust lines within the arch. The thrust line at collapse
    passes through four hinges, so all load factors returned are equal.

    Parameters
    ----------
    joints: ends of the joints, from the left abutment to the right, intrados first, shape (blocks + 1, 2, 2).
    weight: weights of the blocks in the order of the joints, shape (blocks,).
    at: points at which the weights act, shape (blocks, 2).
    """
    zero = np.zeros(len(weight))
    left_of = np.arange(len(joints))[:, None] > np.arange(len(weight))  # shape (joints, blocks)
    # Moment about the origin, and force, of all loads to the left of each joint.
    dead = left_of @ np.stack([-weight * at[:, 0], zero, -weight], axis=1)
    live = left_of @ np.stack([-weight * at[:, 1], weight, zero], axis=1)
    chosen = np.array(list(combinations(range(len(joints)), 4)))
    across = joints[:, 1] - joints[:, 0]
    found: list[float] = []
    for sides in ((0, 1, 0, 1), (1, 0, 1, 0)):
        hinge = joints[chosen, np.array(sides)]
        x, y = hinge[..., 0], hinge[..., 1]

        def about(load, x=x, y=y):
            moment, fx, fy = np.moveaxis(load[chosen], -1, 0)
            return moment - x * fy + y * fx

        # The unknowns are the moment about the origin and the force of the left abutment, and λ.
        matrix = np.stack([np.ones_like(x), y, -x, about(live)], axis=-1)
        regular = np.linalg.cond(matrix) < 1e12
        unknown = np.linalg.solve(matrix[regular], -about(dead)[regular][..., None])[..., 0]
        total = dead + unknown[:, 3, None, None] * live + unknown[:, None, :3]
        moment, fx, fy = np.moveaxis(total, -1, 0)
        # Position at which the thrust crosses a joint, as a fraction of its length, and the normal force.
        pressed = across[:, 1] * fx - across[:, 0] * fy
        begin = moment - joints[:, 0, 0] * fy + joints[:, 0, 1] * fx
        crossed = -begin / pressed
        inside = (np.abs(crossed - 0.5) <= 0.5 + 1e-9) & (pressed > 0)
        admissible = inside.all(axis=1) & (unknown[:, 3] > 0)
        found += unknown[admissible, 3].tolist()
    return np.array(found)
