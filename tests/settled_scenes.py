"""Scenes whose supports settle, and the geometry of their settled states, for several tests."""

import math

import numpy as np

import masonry_opt as mo
from masonry_opt.scene.blocks import rectangle

#: Settlement of the right pier of the beam, as horizontal and vertical displacement.
SINKS = {"R": (0.0, -0.02)}


def block(name: str, left: float, right: float, bottom: float, top: float, **keys: object) -> mo.Block:
    return mo.Block(name=name, vertices=rectangle(left, right, bottom, top), **keys)


def beam(**given: object) -> mo.Scene:
    """Return a beam of 5 × 1, pushed to the right, on two piers of width 1 at its ends."""
    blocks = [
        block("L", 0, 1, 0, 1, fixed=True),
        block("R", 4, 5, 0, 1, fixed=True),
        block("beam", 0, 5, 1, 2, **{"weight": 10, "live": (1, 0)} | given),
    ]
    return mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=blocks)


def joined_circles(
    one: tuple[np.ndarray, float], other: tuple[np.ndarray, float], near: np.ndarray
) -> np.ndarray:
    """Return the intersection of two circles that is nearer to a third point."""
    (a, from_a), (b, from_b) = one, other
    along = b - a
    length = np.hypot(*along)
    at = (from_a**2 - from_b**2 + length**2) / (2 * length)
    off = math.sqrt(from_a**2 - at**2)
    unit = along / length
    across = np.array([-unit[1], unit[0]])
    points = (a + at * unit + side * off * across for side in (1, -1))
    return min(points, key=lambda point: float(np.hypot(*(point - near))))
