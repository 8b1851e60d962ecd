"""Joints and small gaps found in a scene before it is solved, and what looks unintended."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
import shapely

from masonry_opt.answer.sense import warnings_of
from masonry_opt.drawing.colours import GAP, JOINT, MARKED
from masonry_opt.drawing.marks import Marks, joint_marks
from masonry_opt.errors import CaseError, counted
from masonry_opt.problem.assembly import Assembly, SpaceAssembly
from masonry_opt.scene.contacts.floating import refuse_floating
from masonry_opt.scene.space.shapes import Shapes
from masonry_opt.words.sentences import sentences

#: Points along an edge of a solid at which it is held against another block.
_SAMPLES = 9


def found_marks(assembly: Assembly, shrink: float) -> Iterable[Marks]:
    """Joints, corners that meet in no joint, and small gaps."""
    (ends, _), width = assembly.joints.lines(), 2.0 * shrink
    if isinstance(assembly, SpaceAssembly):
        in_point, corners, gaps = "joint in a point", *unjoined(assembly)
    else:
        in_point = "joint of a corner on an edge"
        corners, gaps = meeting_corners(assembly), near_misses(assembly)
    yield from joint_marks("joint", "joint", JOINT, width, ends, in_point=in_point)
    if len(corners):
        label = "corner on corner: no joint"
        yield Marks("corners", label, "cross", MARKED, 3.0 * width, corners[:, None])
    if len(gaps):
        yield Marks("gaps", "small gap: no joint", "line", GAP, 2.6, gaps, dashes=(1.6, 1.1))


def counts(assembly: Assembly) -> str:
    """Numbers of blocks, supports, joints, small gaps and edges that fill touches, in words."""
    movable = len(assembly.movable)
    numbers = {
        "block": movable,
        "support": len(assembly.scene.blocks) - movable,
        "joint": len(assembly.joints.first),
        "small gap": len(assembly.joints.gaps),
    }
    told = [(noun, number) for noun, number in numbers.items() if number or noun == "joint"]
    said = [counted(number, noun) for noun, number in told]
    if touched := len(assembly.filled_pieces):
        said.append(f"{counted(touched, 'edge')} touched by fill")
    return ", ".join(said)


def near_misses(assembly: Assembly) -> np.ndarray:
    """Lengths of edge along which blocks face each other across a small gap, relative to the geometry's
    origin, shape (lengths, 2, 2)."""
    shapes, found = assembly.geometry, [np.empty((0, 2, 2))]
    for pair, gap in assembly.joints.gaps.items():
        one, other = shapes.polygons[list(pair)]
        # A little more than the largest width, which keeps their ends.
        reach = 1.01 * gap
        facing = shapely.intersection(shapely.boundary(one), shapely.buffer(other, reach))
        lines = shapely.get_parts(shapely.line_merge(facing))
        # Without stubs round corners.
        lines = shapely.simplify(lines[shapely.length(lines) > 2 * reach], 2 * reach)
        corners = [shapely.get_coordinates(line) for line in lines]
        found += [np.stack([line[:-1], line[1:]], axis=1) for line in corners]
    return np.concatenate(found)


def meeting_corners(assembly: Assembly) -> np.ndarray:
    """Points where blocks meet corner on corner, off the joints of the two, relative to the geometry's
    origin, shape (points, 2)."""
    shapes, joints = assembly.geometry, assembly.joints
    found = [np.empty((0, 2))]
    for first, second in joints.without_normal:
        one, other = (np.unique(shapely.get_coordinates(shapes.polygons[i]), axis=0) for i in (first, second))
        apart = np.hypot(*(one[:, None] - other[None]).transpose(2, 0, 1))
        own = (joints.first == first) & (joints.second == second)
        shared = shapely.multilinestrings(np.stack([joints.start[own], joints.end[own]], axis=1))
        points = one[(apart <= 2 * shapes.tolerance).any(axis=1)]
        # The distance to no line at all is NaN.
        off = ~(shapely.distance(shared, shapely.points(points)) <= 2 * shapes.tolerance)
        found.append(points[off])
    return np.concatenate(found)


def unjoined(assembly: SpaceAssembly) -> tuple[np.ndarray, np.ndarray]:
    """In space, relative to the geometry's origin: corners of blocks that meet others without a normal, shape
    (points, 3), and lengths of edges that face another block across a small gap, shape (lengths, 2, 3)."""
    shapes, contacts = assembly.geometry, assembly.joints
    every, of_corner = shapes.corners
    start, end, face = shapes.faces.sides()
    share = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    points, lengths = [np.empty((0, 3))], [np.empty((0, 2, 3))]
    for pair in contacts.without_normal:
        for one, other in (pair, pair[::-1]):
            own = every[of_corner == one]
            points.append(own[_beside(shapes, other, own) <= 2 * shapes.tolerance])
    for pair, gap in contacts.gaps.items():
        for one, other in (pair, pair[::-1]):
            for side in np.flatnonzero(shapes.faces.block[face] == one):
                along = (1 - share) * start[side] + share * end[side]
                near = _beside(shapes, other, along) <= 1.01 * gap
                both = near[:-1] & near[1:]
                lengths.append(np.stack([along[:-1], along[1:]], axis=1)[both])
    return np.concatenate(points), np.concatenate(lengths)


def _beside(shapes: Shapes, block: int, points: np.ndarray) -> np.ndarray:
    return shapes.outside(np.full(len(points), block), points)


def doubts(assembly: Assembly) -> Iterator[str]:
    """Sentences on blocks that touch nothing, which no analysis takes, and on what looks unintended."""
    scene, joints = assembly.scene, assembly.joints
    try:
        refuse_floating(scene, assembly.geometry, joints.first, joints.second, joints.gaps)
    except CaseError as error:
        yield str(error)
    yield from sentences(warnings_of(assembly, None))
