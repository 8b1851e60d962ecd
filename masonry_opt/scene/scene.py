"""The scene: blocks, joint properties and gravity, before any mathematics."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, PrivateAttr, model_validator

from masonry_opt.errors import CaseError
from masonry_opt.scene.blocks import (
    Block,
    Joint,
    JointDefaults,
    Name,
    Point,
    Positive,
    Record,
    Reference,
    Text,
)
from masonry_opt.scene.loads import EdgeLoad, Load


class SceneKeys(Record):
    """The keys that a scene and a case file share."""

    title: Text = ""
    source: Text = ""
    gravity: Point = (0.0, -1.0)
    tolerance: Positive | None = None
    thickness: Positive = 1.0
    tilt: Literal["left", "right"] | None = None
    joints: JointDefaults
    blocks: Annotated[list[Block], Field(alias="block")] = []
    exceptions: Annotated[list[Joint], Field(alias="joint")] = []
    edge_loads: Annotated[list[EdgeLoad], Field(alias="edge_load")] = []
    loads: Annotated[list[Load], Field(alias="load")] = []
    reference: dict[Name, Reference] = {}


class Scene(SceneKeys):
    """Rigid blocks and their joint properties; the joints are found from the geometry.

    Parameters
    ----------
    blocks:
        At least one fixed and one movable :class:`Block`, with unique names.
    joints:
        Properties of every joint (:class:`JointDefaults`, or a mapping with the same keys).
    exceptions:
        :class:`Joint` records for the joints that differ.
    gravity:
        Direction in which weights act (only the direction counts), default straight down.
    tolerance:
        Length below which gaps and overlaps between blocks are nothing; raise it for coordinates that
        were rounded (default: 1e-6 of the diagonal round the movable blocks).
    thickness:
        Out of the plane. What is per unit length in the plane is then per unit area, and what is per unit
        area per unit volume: ``unit_weight``, cohesion, ``dilatancy_stress`` and edge loads are multiplied
        by it. ``weight``, ``live`` and ``dead`` are forces as they are.
    tilt:
        "left" or "right": the ground is tilted until the scene falls to that side. The live load is every
        block's weight, turned a quarter from gravity to that side, and the load factor the tangent of the
        tilt. Goes with weights and friction alone.
    edge_loads:
        :class:`EdgeLoad` records: loads along edges.
    loads:
        :class:`Load` records: forces on single blocks by name, beside those the blocks have.
    title, source:
        What the scene is and where it comes from.
    reference:
        Published values by name (``associative``, ``nonassociative``, ``mcp``, ``mpec``, ...).

    Raises
    ------
    CaseError
        If names repeat, no block is fixed or none can move, an exception or load names no block, a load a
        fixed one, or a scene to be tilted has what does not tilt.
    """

    _origin: str = PrivateAttr(default="scene")
    _case: SceneKeys | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _consistent(self) -> Scene:
        if math.hypot(*self.gravity) == 0:
            raise ValueError("'gravity' needs a direction, such as [0, -1]")
        if not self.blocks:
            raise ValueError("the scene has no block: add [[block]] tables or a generator such as [wall]")
        numbers: dict[str, int] = {}
        for number, block in enumerate(self.blocks, start=1):
            if (first := numbers.setdefault(block.name, number)) != number:
                raise ValueError(
                    f"blocks no. {first} and no. {number} are both named '{block.name}': rename one "
                    "(a generator names its blocks itself: '1-1', ..., 'base'; give it a 'name' of its own)"
                )
        fixed = [block.fixed for block in self.blocks]
        if not any(fixed):
            raise ValueError("no block is fixed: mark the support with 'fixed = true'")
        if all(fixed):
            raise ValueError("every block is fixed: nothing can move")
        known = {block.name: block for block in self.blocks}
        for mistake in (self._wrong_exception(known), self._wrong_load(known), self._wrong_tilt()):
            if mistake:
                raise ValueError(mistake)
        return self

    def _wrong_exception(self, known: Mapping[str, Block]) -> str | None:
        pairs: set[frozenset[str]] = set()
        for exception in self.exceptions:
            where, pair = f"joint between {list(exception.between)}", frozenset(exception.between)
            if unknown := [name for name in exception.between if name not in known]:
                return f"{where}: {_no_block(unknown[0], known)}"
            if len(pair) == 1:
                return f"{where}: needs two different blocks"
            if pair in pairs:
                return f"{where} is given twice"
            pairs.add(pair)
            try:
                exception.over(self.joints)
            except CaseError as error:
                return f"{where}: {str(error).removeprefix('JointDefaults: ')}"
        return None

    def _wrong_load(self, known: Mapping[str, Block]) -> str | None:
        weighed: set[str] = set()
        for number, load in enumerate(self.loads, start=1):
            if load.block not in known:
                return f"load no. {number}: {_no_block(load.block, known)}"
            if known[load.block].fixed:
                return f"load no. {number}: block '{load.block}' is fixed: load one that can move"
            if load.weight is not None:
                if load.block in weighed:
                    return f"load no. {number}: gives block '{load.block}' a second 'weight'"
                weighed.add(load.block)
        return None

    def _wrong_tilt(self) -> str | None:
        if not self.tilt:
            return None
        # Tilted by θ, weights are cos θ (W + tan θ W'), W' the weights turned a quarter: λ = tan θ if all
        # else grows with cos θ too. Other forces do not, nor does what joints resist without being pressed.
        why = [
            f"block '{block.name}' has a force '{force}', which does not tilt"
            for block in self.blocks
            for force in ("live", "live_per_weight", "dead")
            if any(getattr(block, force))
        ]
        why += [
            f"a 'load' on block '{load.block}' is a force, which does not tilt"
            for load in self.loads
            if load.live is not None or load.dead is not None
        ]
        why += ["an 'edge_load' does not tilt"] * len(self.edge_loads)
        properties: list[JointDefaults | Joint] = [self.joints, *self.exceptions]
        for joint in properties:
            resisting = {
                "cohesion": joint.cohesion,
                "strength": joint.strength,
                "dilatancy_stress": joint.dilatancy_stress and joint.dilatancy,
            }
            why += [f"'{key}' does not grow with the weights" for key, value in resisting.items() if value]
        return f"'tilt' needs a scene of weights and friction alone: {why[0]}: take it away" if why else None

    @property
    def origin(self) -> str:
        """The case file the scene was read from, or ``"scene"``; errors begin with it."""
        return self._origin

    @property
    def called(self) -> str:
        """What results call the scene: its case file, else its title, else ``"scene"``."""
        return self._origin if self._origin != "scene" else self.title or "scene"

    @property
    def case(self) -> SceneKeys | None:
        """The case file as it was read, its generators not expanded; None of a scene made in Python."""
        return self._case

    def read_from(self, origin: str | Path, case: SceneKeys | None = None) -> Scene:
        """The same scene with the file it was read from, and the content of that."""
        scene = self.model_copy()
        scene._origin, scene._case = str(origin), case
        return scene

    def __eq__(self, other: object) -> bool:
        """Scenes are equal if their keys are, wherever they were read from."""
        return isinstance(other, Scene) and self.model_dump() == other.model_dump()


def _no_block(name: str, known: Iterable[str]) -> str:
    close = difflib.get_close_matches(name, list(known), n=1)
    return f"no block '{name}'" + (f"; did you mean '{close[0]}'?" if close else "")
