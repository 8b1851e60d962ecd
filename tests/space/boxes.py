"""Walls of boxes in space, and what two programs beside the package need of them: contact points and loads.

Nothing of the package is used here. Boxes lie along the axes; gravity is −z.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp


@dataclass(frozen=True)
class Boxes:
    """Boxes along the axes: least and greatest coordinates, shape (blocks, 3), and which are fixed."""

    low: np.ndarray
    high: np.ndarray
    fixed: np.ndarray

    @property
    def centre(self) -> np.ndarray:
        return (self.low + self.high) / 2

    @property
    def volume(self) -> np.ndarray:
        return np.prod(self.high - self.low, axis=1)


@dataclass(frozen=True)
class Contacts:
    """Contact points of bodies of any shape.

    Attributes
    ----------
    first, second: the two bodies, shape (points,).
    at: where they touch, shape (points, 3).
    frame: the normal, out of the first body, and two directions of shear, shape (points, 3, 3), a row each.
    area: what each point has of the area of its joint, shape (points,).
    """

    first: np.ndarray
    second: np.ndarray
    at: np.ndarray
    frame: np.ndarray
    area: np.ndarray


@dataclass(frozen=True)
class Pushed:
    """Bodies that stand under dead and are pushed by λ times live loads.

    Attributes
    ----------
    B: forces and moments about its centroid on each free body, six rows a body, of the forces at each contact
        point, three columns a point (normal, pressing > 0, and two shears), as they act on its second body.
    dead, live: loads, shape (6 × free bodies,), so that B q + λ live + dead = 0.
    area: of the contact points, shape (points,).
    """

    B: sp.csc_array
    dead: np.ndarray
    live: np.ndarray
    area: np.ndarray


def contacts(boxes: Boxes) -> Contacts:
    """The corners of each rectangle that opposite faces of two boxes share, of all pairs."""
    first, second, at, axes, area = [], [], [], [], []
    for one in range(len(boxes.low)):
        for axis in range(3):
            across = [(axis + 1) % 3, (axis + 2) % 3]
            low = np.maximum(boxes.low[one], boxes.low)[:, across]
            high = np.minimum(boxes.high[one], boxes.high)[:, across]
            touch = np.isclose(boxes.high[one, axis], boxes.low[:, axis]) & (high - low > 1e-9).all(axis=1)
            for other in np.flatnonzero(touch & ~(boxes.fixed & boxes.fixed[one])):
                for u in (low[other, 0], high[other, 0]):
                    for v in (low[other, 1], high[other, 1]):
                        corner = np.empty(3)
                        corner[axis], corner[across] = boxes.high[one, axis], (u, v)
                        first.append(one)
                        second.append(other)
                        at.append(corner)
                        axes.append([axis, *across])
                        area.append(np.prod(high[other] - low[other]) / 4)
    return Contacts(np.array(first), np.array(second), np.array(at), np.eye(3)[axes], np.array(area))


def push(boxes: Boxes, direction: tuple[float, float, float], touching: Contacts | None = None) -> Pushed:
    """Boxes of unit weight 1, pushed at their centroids by λ times their weight along a direction."""
    direction_ = np.asarray(direction) / np.linalg.norm(direction)
    load = np.zeros((2, len(boxes.low), 6))
    load[0, :, 2] = -boxes.volume
    load[1, :, :3] = np.outer(boxes.volume, direction_)
    return pushed(touching or contacts(boxes), boxes.centre, boxes.fixed, load[0], load[1])


def pushed(
    touching: Contacts, centroid: np.ndarray, fixed: np.ndarray, dead: np.ndarray, live: np.ndarray
) -> Pushed:
    """Bodies of any shape; loads are forces and moments about the centroid, shape (bodies, 6)."""
    points = len(touching.at)
    row = np.where(fixed, -1, np.cumsum(~fixed) - 1)
    B = sp.csc_array((6 * int((~fixed).sum()), 3 * points))
    for body, sign in ((touching.first, -1.0), (touching.second, 1.0)):
        arm = (touching.at - centroid[body])[:, None]
        wrench = sign * np.concatenate([touching.frame, np.cross(arm, touching.frame)], axis=2)
        free = ~fixed[body]
        rows = np.broadcast_to(6 * row[body][:, None, None] + np.arange(6), wrench.shape)[free]
        columns = np.broadcast_to(np.arange(3 * points).reshape(points, 3, 1), wrench.shape)[free]
        B = B + sp.csc_array((wrench[free].ravel(), (rows.ravel(), columns.ravel())), shape=B.shape)
    return Pushed(B, dead[~fixed].ravel(), live[~fixed].ravel(), touching.area)


def single_box(a: float, b: float, h: float) -> Boxes:
    """A box a × b × h that stands in the middle of the ground."""
    return _on_ground([((-a / 2, -b / 2, 0.0), (a / 2, b / 2, h))])


def corner_wall(along_x: int, along_y: int, courses: int) -> Boxes:
    """An L of blocks 2 × 1 × 1 from the origin, legs as long as so many blocks along x and y.

    Even courses run through the corner along x, odd ones along y; half blocks make the free ends flush.
    """
    blocks = []
    for z in range(courses):
        odd = z % 2
        blocks += [((u, 0, z), (v, 1, z + 1)) for u, v in _row(odd, 2 * along_x)]
        blocks += [((0, u, z), (1, v, z + 1)) for u, v in _row(1 - odd, 2 * along_y)]
    return _on_ground(blocks)


def facade(length: int, depth: int, courses: int) -> Boxes:
    """A U of blocks 2 × 1 × 1: a front of a length along x, and returns towards +y to a depth from its face.

    The front runs through both corners in even courses, the returns do in odd ones; free ends are flush.
    """
    blocks = []
    for z in range(courses):
        odd = z % 2
        blocks += [((u, 0, z), (v, 1, z + 1)) for u, v in _row(odd, length - odd)]
        for x in (0, length - 1):
            blocks += [((x, u, z), (x + 1, v, z + 1)) for u, v in _row(1 - odd, depth)]
    return _on_ground(blocks)


def _row(start: int, end: int) -> list[tuple[int, int]]:
    return [(at, min(at + 2, end)) for at in range(start, end, 2)]


def _on_ground(blocks: Sequence[tuple[tuple[float, ...], tuple[float, ...]]]) -> Boxes:
    low, high = (np.array([block[end] for block in blocks], dtype=float) for end in (0, 1))
    ground = np.array([[*(low.min(axis=0)[:2] - 1), -1.0], [*(high.max(axis=0)[:2] + 1), 0.0]])
    fixed = np.zeros(len(low) + 1, dtype=bool)
    fixed[-1] = True
    return Boxes(np.vstack([low, ground[0]]), np.vstack([high, ground[1]]), fixed)
