"""What a drawing does not say, and the scene that its outlines make with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import shapely

from masonry_opt.errors import CaseError, printable
from masonry_opt.scene.blocks import Block, Friction, JointDefaults, NonNegative, Point, Positive, Record
from masonry_opt.scene.scene import Scene

#: Characters of a block's name; a record takes no more.
_LONGEST_NAME = 200


class Drawing(Record):
    """What a drawing leaves open: the same for all its blocks and joints.

    Parameters
    ----------
    friction:
        Of every joint, μ = tan φ.
    unit_weight:
        Weight per unit area; of solids, per unit volume.
    live:
        Live force on every movable block as a multiple of its weight, ``[fx, fy]``, at the centroid.
    tolerance:
        Length below which gaps are nothing, between ends of lines and between blocks.

    Raises
    ------
    CaseError
        If a value is out of range.
    """

    friction: Friction
    unit_weight: NonNegative
    live: Point = (0.0, 0.0)
    tolerance: Positive | None = None


@dataclass(frozen=True)
class Stone:
    """A block as drawn.

    Attributes
    ----------
    name: of the block.
    outline: its polygon, with its holes.
    fixed: whether it is a support.
    live: live force as a multiple of its weight.
    thickness: of a solid; None for what is flat.
    """

    name: str
    outline: shapely.Polygon
    fixed: bool
    live: Point
    thickness: float | None = None

    def block(self, unit_weight: float) -> Block:
        """The block of a scene; of a solid, ``weight`` is unit weight times area times thickness."""
        outer, *holes = [
            [(float(x), float(y)) for x, y in ring.coords[:-1]]
            for ring in (self.outline.exterior, *self.outline.interiors)
        ]
        if self.fixed:
            return Block(name=self.name, vertices=outer, holes=holes, fixed=True)
        solid = None if self.thickness is None else unit_weight * self.outline.area * self.thickness
        return Block(
            name=self.name,
            vertices=outer,
            holes=holes,
            live_per_weight=self.live,
            unit_weight=unit_weight if solid is None else None,
            weight=solid,
        )


def block_name(text: str) -> str:
    """The text as a block can be named: in one line, printable, not too long; empty if nothing is left."""
    return " ".join(printable(" ".join(text.split())).split())[:_LONGEST_NAME]


def scene_of(stones: Sequence[Stone], drawing: Drawing, path: Path) -> Scene:
    """The scene of a drawing's stones.

    Raises CaseError, beginning with the file, if they make no scene.
    """
    try:
        scene = Scene(
            source=f"drawn in {block_name(path.name)}",
            joints=JointDefaults(friction=drawing.friction),
            blocks=[stone.block(drawing.unit_weight) for stone in stones],
            tolerance=drawing.tolerance,
        )
    except CaseError as error:
        raise CaseError(f"{path}: {error}") from None
    return scene.read_from(path)


def drawing_path(path: str | Path, suffix: str) -> Path:
    """The path of a drawing. Raises CaseError if it is none, or its name does not end as it should."""
    try:
        path = Path(path)
    except TypeError:
        raise CaseError(
            f"the path of a drawing is text or a pathlib.Path (found {type(path).__name__})"
        ) from None
    if path.suffix.lower() != suffix:
        raise CaseError(f"{path}: the name of such a drawing ends in {suffix}")
    return path
