"""Blocks as they are drawn, and the scene that they make with what a drawing leaves open."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

import shapely

from masonry_opt.errors import CaseError, printable
from masonry_opt.scene.blocks import Block, NonNegative, Positive, Record
from masonry_opt.scene.joints import Friction, JointDefaults
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import PlaneOrSpaceVector, Solid
from masonry_opt.scene.tables import as_path

#: Characters of a block's name; a record takes no more.
_LONGEST_NAME = 200


class Drawing(Record):
    """Values that a drawing leaves open, the same for all its blocks and joints."""

    friction: Friction
    unit_weight: NonNegative
    tolerance: Positive | None = None
    contact_tolerance: Positive | None = None

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Self:
        """With those of the arguments of a reader that are given, and are values of such a drawing."""
        return cls(**{key: given[key] for key in cls.model_fields if given.get(key) is not None})


class FlatDrawing(Drawing):
    """Beside them the live load of a drawing in the plane: see :func:`read_dxf` and :func:`read_compas`."""

    live: PlaneOrSpaceVector = (0.0, 0.0)

    def block(self, name: str, outline: shapely.Polygon, fixed: bool, **keys: Any) -> Block:
        """The block of an outline with holes: a support, or one with this unit weight, which ``keys``
        override."""
        outer, *holes = [
            [(float(x), float(y)) for x, y in ring.coords[:-1]]
            for ring in (outline.exterior, *outline.interiors)
        ]
        loads = {"unit_weight": self.unit_weight} | keys
        return Block(name=name, vertices=outer, holes=holes, **({"fixed": True} if fixed else loads))


def block_name(text: str) -> str:
    """The text as a block can be named: in one line, printable, not too long; empty if nothing is left."""
    return " ".join(printable(" ".join(text.split())).split())[:_LONGEST_NAME]


@contextmanager
def naming(what: str) -> Iterator[None]:
    """Makes what is wrong with a file or a block a CaseError that begins with it."""
    try:
        yield
    except ValueError as error:
        named = str(error).startswith(what)
        raise CaseError(error if named else f"{what} {error}") from None


def scene_of(blocks: Sequence[Block | Solid], drawing: Drawing, path: Path) -> Scene:
    """The scene of a drawing's blocks. Raises CaseError if they make none."""
    return Scene(
        source=f"drawn in {block_name(path.name)}",
        joints=JointDefaults(friction=drawing.friction),
        blocks=list(blocks),
        tolerance=drawing.tolerance,
        contact_tolerance=drawing.contact_tolerance,
    ).read_from(path)


def drawing_path(path: str | Path, suffix: str) -> Path:
    """The path of a drawing. Raises CaseError if it is none, or its name does not end as it should."""
    path = as_path(path, "a drawing")
    if path.suffix.lower() != suffix:
        raise CaseError(f"{path}: the name of such a drawing ends in {suffix}")
    return path
