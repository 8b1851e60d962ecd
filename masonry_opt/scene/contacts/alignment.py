"""Common directions of joints that are parallel within the accuracy of the drawing.

A drawing fixes the direction of an edge no better than its tolerance over the length of the edge. Two beds of
a block that are drawn parallel thus differ by some angle. In a model of rigid blocks even the smallest angle
makes a wedge: a block that slides along one bed lifts off the other one, or is stopped by it. Joints whose
directions agree within their accuracies therefore get one common direction. Contact points stay where they
are, and equilibrium is exact for the directions used.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from masonry_opt.scene.rows import dots, lengths


@dataclass(frozen=True)
class AlignmentSettings:
    """Angles, in radians, that decide which joints get a common direction."""

    #: Largest angle by which a joint is turned, however short its edges are. A larger value aligns short joints
    #: of coarse surveys too, and takes longer to find groups among many directions.
    most_turn: float = 0.02
    #: Spread of a group that is rounding: its joints keep their directions to the last digit. A larger value
    #: leaves wedges of that angle in the model.
    rounding: float = 1e-12


DEFAULT = AlignmentSettings()


def aligned(
    normal: np.ndarray, accuracy: np.ndarray, settings: AlignmentSettings = DEFAULT
) -> tuple[np.ndarray, np.ndarray]:
    """Return the normals of joints after alignment, shape (joints, dim), and the angle by which each was
    turned, shape (joints,).

    ``normal`` holds unit normals, of which the sign does not matter, and ``accuracy`` the angle in radians
    within which the drawing fixes each of them. Groups form round the joints of the best accuracy first:

    1. The members agree with that joint within the sum of both accuracies.
    2. Their common direction is the mean, weighted by the inverse of the accuracies.
    3. While a member would turn by more than its own accuracy, the worst one leaves the group.

    No joint thus turns by more than its own accuracy, and groups do not chain round an arch of many joints.
    """
    accuracy = np.minimum(accuracy, settings.most_turn)
    turned, angle = normal.copy(), np.zeros(len(normal))
    if len(normal) < 2:
        return turned, angle
    tree = cKDTree(np.concatenate([normal, -normal]))
    free = np.ones(len(normal), dtype=bool)
    for leader in np.argsort(accuracy, kind="stable").tolist():
        while free[leader]:
            near = tree.query_ball_point(normal[leader], accuracy[leader] + accuracy.max())
            members = np.unique(np.array(near) % len(normal))
            members = members[free[members]]
            apart = _angles(normal[members], normal[leader])
            members = members[apart <= accuracy[leader] + accuracy[members]]
            members, direction = _group(normal, accuracy, members)
            if len(members) < 2:
                members = np.array([leader])
            free[members] = False
            spread = _angles(normal[members], direction)
            if len(members) > 1 and spread.max() > settings.rounding:
                turned[members] = np.sign(normal[members] @ direction)[:, None] * direction
                angle[members] = spread
    return turned, angle


def _group(
    normal: np.ndarray, accuracy: np.ndarray, members: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the members of a group that turn by no more than their accuracies, and their direction."""
    while True:
        # The best known member decides the sign in which normals are summed.
        best = normal[members[accuracy[members].argmin()]]
        alike = np.sign(normal[members] @ best)
        total = (alike / accuracy[members]) @ normal[members]
        direction = total / np.hypot.reduce(total)
        excess = _angles(normal[members], direction) - accuracy[members]
        if len(members) < 2 or excess.max() <= 0:
            return members, direction
        members = np.delete(members, int((excess / accuracy[members]).argmax()))


def _angles(normals: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Return the angles between lines along normals and a line along a direction, shape (normals,)."""
    across = normals - (normals @ direction)[:, None] * direction
    return np.arcsin(np.minimum(lengths(across), 1.0))


def square_to(vectors: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return unit vectors square to the normals, each as near as possible to its vector."""
    across = vectors - dots(vectors, normal)[:, None] * normal
    return across / lengths(across)[:, None]
