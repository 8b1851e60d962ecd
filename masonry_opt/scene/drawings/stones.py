"""Blocks as they are drawn, what a drawing leaves open, and the scene that both make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import shapely

from masonry_opt.errors import CaseError, printable
from masonry_opt.scene.blocks import Block, Friction, JointDefaults, NonNegative, Point, Positive, Record
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.tables import as_path

#: Characters of a block's name; a record takes no more.
_LONGEST_NAME = 200


class Drawing(Record):
    """Values that a drawing leaves open, the same for all its blocks and joints: see :func:`read_dxf` and
    :func:`read_compas`."""

    friction: Friction
    unit_weight: NonNegative
    live: Point = (0.0, 0.0)
    tolerance: Positive | None = None


@dataclass(frozen=True)
class Stone:
    """A block as drawn: its polygon with holes, whether it is a support, its live force as a multiple of its
    weight, and the thickness of a solid."""

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
        keys: dict[str, Any] = {"fixed": True}
        if not self.fixed and self.thickness is None:
            keys = {"live_per_weight": self.live, "unit_weight": unit_weight}
        elif not self.fixed:
            weight = unit_weight * self.outline.area * self.thickness
            keys = {"live_per_weight": self.live, "weight": weight}
        return Block(name=self.name, vertices=outer, holes=holes, **keys)


def block_name(text: str) -> str:
    """The text as a block can be named: in one line, printable, not too long; empty if nothing is left."""
    return " ".join(printable(" ".join(text.split())).split())[:_LONGEST_NAME]


def listed(names: Sequence[str]) -> str:
    """The first ten names, as messages list them."""
    return ", ".join(names[:10]) + (", ..." if len(names) > 10 else "")


def scene_of(stones: Sequence[Stone], drawing: Drawing, path: Path) -> Scene:
    """The scene of a drawing's stones. Raises CaseError, beginning with the file, if they make none."""
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
    path = as_path(path, "a drawing")
    if path.suffix.lower() != suffix:
        raise CaseError(f"{path}: the name of such a drawing ends in {suffix}")
    return path
