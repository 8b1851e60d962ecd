"""Where the blocks of a scene are: their sizes, centroids and corners, and the boxes round them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np

from masonry_opt.scene.scene import Scene

#: Lengths below this fraction of the diagonal round the movable blocks are nothing: gaps, overlaps,
#: joints, corners.
RELATIVE_TOLERANCE = 1e-6

#: Neighbours nearer than this, over the width of the smaller block, were surely meant to touch, and overlaps
#: no deeper come of rounded coordinates.
NEAR_MISS = 1e-2

#: So are those within so many tolerances: coordinates that need one are now and then off by a little more.
_NEAR_TOLERANCES = 3


def frame_of(scene: Scene, corners: np.ndarray, block: np.ndarray) -> tuple[np.ndarray, float]:
    """Origin and tolerance of the shapes of a scene, given corners and the block of each. Supports may reach
    far beyond what stands on them: the movable blocks give both."""
    fixed = np.array([block.fixed for block in scene.blocks])
    movable = corners[~fixed[block]]
    low, high = movable.min(axis=0), movable.max(axis=0)
    tolerance = scene.tolerance or RELATIVE_TOLERANCE * float(np.hypot.reduce(high - low))
    # Digits already lost in the coordinates themselves bound what can be told apart.
    return (low + high) / 2, max(tolerance, 8 * float(np.spacing(np.abs(corners).max())))


class Common(NamedTuple):
    """A piece that two blocks have in common: how far they must be moved apart, its centroid and size."""

    depth: float
    middle: np.ndarray
    size: float


@dataclass(frozen=True)
class Extents(ABC):
    """Shapes of a scene, moved so that the middle of its movable blocks is the origin (far coordinates lose
    digits). Points have two components in the plane, three in space.

    Attributes
    ----------
    origin: that middle in the scene's own coordinates, shape (2,) or (3,).
    tolerance: length below which the scene has no detail.
    contact_tolerance: gap or overlap of sides that face each other up to which they touch.
    size: area of each block, in space volume: what a ``unit_weight`` refers to, shape (blocks,).
    centroid: of each block, relative to ``origin``, shape (blocks, 2) or (blocks, 3).
    convex: whether each is convex, in space one convex part, shape (blocks,).
    mixed: blocks whose faces were not all given turned one way, and were turned; none in the plane.
    """

    origin: np.ndarray
    tolerance: float
    contact_tolerance: float
    size: np.ndarray
    centroid: np.ndarray
    convex: np.ndarray
    mixed: np.ndarray

    #: Where blocks overlap, and what they may do about that beside moving, given the depth.
    within: ClassVar[str] = "over an area"
    remedy: ClassVar[str] = ""
    #: Where blocks meet without a joint.
    meeting: ClassVar[str] = "corner on corner alone, where a joint needs an edge"
    #: Share of the smaller block in an overlap from which on it lies within the other, as errors say.
    inside: ClassVar[float] = np.inf
    #: Gap that may be a joint of mortar that was left out, over the width of a block.
    mortar: ClassVar[float] = 0.0
    #: Pairs that overlap, after which no more are looked for: the scene is refused anyway.
    enough: ClassVar[float] = np.inf

    @property
    @abstractmethod
    def corners(self) -> tuple[np.ndarray, np.ndarray]:
        """Corners of all blocks, shape (corners, 2) or (corners, 3), and the block of each, rising."""

    @abstractmethod
    def outside(self, blocks: np.ndarray, points: np.ndarray) -> np.ndarray:
        """How far points lie outside of the convex hulls of blocks, one each, shape (points,)."""

    @abstractmethod
    def away(self, block: int, point: np.ndarray) -> float:
        """How far a point lies outside of a block."""

    @abstractmethod
    def nearest(self, block: int) -> tuple[int, float]:
        """The block nearest to a block, and its distance."""

    @abstractmethod
    def overlaps(self, pairs: np.ndarray) -> Iterator[tuple[int, Common]]:
        """Number of the pair, rising, and pieces that pairs of blocks (indices, shape (pairs, 2)) have in
        common, deeper than the contact tolerance."""

    @cached_property
    def boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest coordinates of each block, shape (blocks, 2) or (blocks, 3) each."""
        points, block = self.corners
        first = np.searchsorted(block, np.arange(len(self.size)))
        return np.minimum.reduceat(points, first), np.maximum.reduceat(points, first)

    @property
    def width(self) -> np.ndarray:
        """Side of a square, or cube, of the size of each block, shape (blocks,)."""
        return self.size ** (1 / len(self.origin))

    @property
    def reach(self) -> np.ndarray:
        """Gap up to which each block's neighbours were surely meant to touch it, shape (blocks,)."""
        return np.maximum(_NEAR_TOLERANCES * self.contact_tolerance, NEAR_MISS * self.width)
