"""Collapse of arches by enumeration: the thrust through four hinges that stays within the arch (Heyman)."""

from itertools import combinations

import numpy as np

import masonry_opt as mo


def radial_joints(arch: mo.Arch) -> np.ndarray:
    """Ends of the joints of a circular arch about the origin, as ``four_hinge_load_factors`` takes them."""
    angles = np.radians(np.linspace(*arch.angles, arch.voussoirs + 1))
    radial = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    half = arch.thickness / 2
    return np.stack([radial * (arch.radius - half), radial * (arch.radius + half)], axis=1)


def four_hinge_load_factors(joints: np.ndarray, weight: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Load factors of all such thrusts, for blocks that cannot slide under their weight and λ times it to the
    right.

    Collapse is the largest multiple of the load that a thrust within the arch carries, and the thrust at
    collapse passes through four hinges; so all that are found are the same.

    Parameters
    ----------
    joints: ends of the joints, from the left abutment to the right, intrados first, shape (blocks + 1, 2, 2).
    weight, at: of the blocks in that order, shape (blocks,), and where it acts, shape (blocks, 2).
    """
    zero = np.zeros(len(weight))
    left_of = np.arange(len(joints))[:, None] > np.arange(len(weight))  # joint, block
    # Moment about the origin and force of all that acts left of each joint.
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

        # Unknown: moment about the origin and force of the left abutment, and λ.
        matrix = np.stack([np.ones_like(x), y, -x, about(live)], axis=-1)
        regular = np.linalg.cond(matrix) < 1e12
        unknown = np.linalg.solve(matrix[regular], -about(dead)[regular][..., None])[..., 0]
        total = dead + unknown[:, 3, None, None] * live + unknown[:, None, :3]
        moment, fx, fy = np.moveaxis(total, -1, 0)
        # Where the thrust crosses a joint, as a part of it, and the pressure there.
        pressed = across[:, 1] * fx - across[:, 0] * fy
        begin = moment - joints[:, 0, 0] * fy + joints[:, 0, 1] * fx
        crossed = -begin / pressed
        inside = (np.abs(crossed - 0.5) <= 0.5 + 1e-9) & (pressed > 0)
        admissible = inside.all(axis=1) & (unknown[:, 3] > 0)
        found += unknown[admissible, 3].tolist()
    return np.array(found)
