"""The uppermost edges below a line, such as a road's."""

from dataclasses import dataclass

import numpy as np
import shapely

from masonry_opt.errors import CaseError
from masonry_opt.scene.geometry import Geometry
from masonry_opt.scene.scene import Scene


@dataclass(frozen=True)
class Profile:
    """Pieces of the uppermost edges below a line, from left to right; both are straight along a piece.

    Relative to the geometry's origin, each of shape (pieces, 2), of the pieces' left and right ends.
    """

    x: np.ndarray  #: of the edges
    y: np.ndarray  #: of the edges; NaN where there is none
    line: np.ndarray  #: height of the line
    edge: np.ndarray  #: index of the edge, shape (pieces,); -1 where there is none
    block: np.ndarray  #: index of its block in the scene, shape (pieces,); -1 where there is none

    @property
    def depth(self) -> np.ndarray:
        """Of the edges below the line, at least 0."""
        return np.maximum(self.line - self.y, 0.0)


def profile_below(scene: Scene, shapes: Geometry, points: np.ndarray, where: str) -> Profile:
    """The uppermost edges of a scene's blocks, fixed ones too, below a line through points from left to
    right, relative to the geometry's origin, shape (points, 2).

    Raises CaseError, which calls the line ``where``, if it runs through a block.
    """
    _refuse_through(scene, shapes, points, where)
    tail, tip, owner = shapes.edges
    upper = np.flatnonzero(tip[:, 0] < tail[:, 0])  # of an edge with the block to its left
    tail, tip, owner = tail[upper], tip[upper], owner[upper]
    at = np.unique(np.concatenate([points[:, 0], tail[:, 0], tip[:, 0]]))
    at = at[(at >= points[0, 0]) & (at <= points[-1, 0])]
    # Pieces shorter than what is nothing belong to their neighbours.
    at = at[np.r_[True, np.diff(at) > shapes.tolerance]]
    edge = _uppermost(tail, tip, (at[1:] + at[:-1]) / 2, points, 2 * shapes.tolerance)
    # A piece begins where the edge or the slope of the line changes.
    slope = np.searchsorted(points[1:-1, 0], (at[1:] + at[:-1]) / 2)
    begins = np.r_[True, (edge[1:] != edge[:-1]) | (slope[1:] != slope[:-1])]
    edge, starts = edge[begins], at[:-1][begins]
    x = np.column_stack([starts, np.r_[starts[1:], at[-1]]])
    tail, tip = tail[edge], tip[edge]
    y = tail[:, 1:] + (x - tail[:, :1]) * ((tip - tail)[:, 1:] / (tip - tail)[:, :1])
    found = edge >= 0
    line = np.interp(x, points[:, 0], points[:, 1])
    numbers = (np.where(found, of[edge], -1) for of in (upper, owner))
    return Profile(x, np.where(found[:, None], y, np.nan), line, *numbers)


def _uppermost(
    tail: np.ndarray, tip: np.ndarray, x: np.ndarray, points: np.ndarray, above: float
) -> np.ndarray:
    """Of edges the highest at each abscissa that is no more than so much above the line, shape (x,); -1
    where there is none."""
    high = np.interp(x, points[:, 0], points[:, 1]) + above
    low = np.full_like(high, min(tail[:, 1].min(), tip[:, 1].min()) - 1.0)
    plumb = shapely.linestrings(np.stack([np.column_stack([x, x]), np.column_stack([low, high])], axis=2))
    edges = shapely.linestrings(np.stack([tail, tip], axis=1))
    number, edge = shapely.STRtree(edges).query(plumb, predicate="intersects")
    share = (x[number] - tail[edge, 0]) / (tip[edge, 0] - tail[edge, 0])
    rising = np.argsort(tail[edge, 1] + share * (tip[edge, 1] - tail[edge, 1]), kind="stable")
    found = np.full(len(x), -1)
    found[number[rising]] = edge[rising]  # the highest is written last
    return found


def _refuse_through(scene: Scene, shapes: Geometry, points: np.ndarray, where: str) -> None:
    line = shapely.linestrings(points)
    met = np.flatnonzero(shapely.intersects(line, shapes.polygons))
    inner = shapely.buffer(shapes.polygons[met], -2 * shapes.tolerance)
    for index in met[shapely.intersects(line, inner)]:
        raise CaseError(
            f"{scene.origin}: {where} runs through block '{scene.blocks[index].name}': it must lie on the "
            "blocks or above them"
        )
