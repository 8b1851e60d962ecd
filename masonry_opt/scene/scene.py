"""The scene: blocks, joint properties and gravity, before any mathematics."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, PrivateAttr, Tag, model_validator

from masonry_opt.errors import CaseError, OptionError
from masonry_opt.scene.axles import Axles
from masonry_opt.scene.blocks import ONE_OR_SEVERAL, Block, Name, Positive, Record, Reference, Text
from masonry_opt.scene.fill import Fill
from masonry_opt.scene.joints import Joint, JointDefaults
from masonry_opt.scene.load_cases import Earthquake, Kind, LoadCase, LoadCases, wrong_cases
from masonry_opt.scene.loads import EdgeLoad, Load
from masonry_opt.scene.mistakes import did_you_mean
from masonry_opt.scene.solids import AnyBlock, Direction, Solid, Vector
from masonry_opt.scene.ties import Prop, Tie, wrong_strut

Tilt = Annotated[
    Annotated[Literal["left", "right"], Tag("<one>")] | Annotated[Vector, Tag("<several>")], ONE_OR_SEVERAL
]

#: Sine of the angle to gravity below which the direction of a tilt is gravity's own.
_ALONG_GRAVITY = 1e-9


class SceneKeys(Record):
    """The keys that a scene and a case file share."""

    title: Text = ""
    source: Text = ""
    gravity: Direction = (0.0, -1.0)
    tolerance: Positive | None = None
    contact_tolerance: Positive | None = None
    thickness: Positive = 1.0
    tilt: Tilt | None = None
    joints: JointDefaults
    blocks: Annotated[list[AnyBlock], Field(alias="block")] = []
    exceptions: Annotated[list[Joint], Field(alias="joint")] = []
    edge_loads: Annotated[list[EdgeLoad], Field(alias="edge_load")] = []
    loads: Annotated[list[Load], Field(alias="load")] = []
    axles: list[Axles] = []
    fills: Annotated[list[Fill], Field(alias="fill")] = []
    ties: Annotated[list[Tie], Field(alias="tie")] = []
    props: Annotated[list[Prop], Field(alias="prop")] = []
    load_cases: LoadCases = []
    earthquake: Earthquake | None = None
    reference: dict[Name, Reference] = {}

    @model_validator(mode="after")
    def _down_by_default(self) -> Self:
        if self.dimension == 3 and "gravity" not in self.model_fields_set:
            self.__dict__["gravity"] = (0.0, 0.0, -1.0)  # records are frozen once they are made
        return self

    @property
    def dimension(self) -> Literal[2, 3]:
        """Numbers of a point: 3 if the blocks are solids."""
        return 3 if self.blocks and isinstance(self.blocks[0], Solid) else 2


class Scene(SceneKeys):
    """Rigid blocks and their joint properties; the joints are found from the geometry.

    Parameters
    ----------
    blocks:
        At least one fixed and one movable :class:`Block`, with unique names; for a scene in space
        :class:`Solid` in place of each.
    joints:
        Properties of every joint (:class:`JointDefaults`, or a mapping with the same keys).
    exceptions:
        :class:`Joint` records for the joints that differ.
    gravity:
        Direction in which weights act (only the direction counts), default straight down: -y, in space -z.
    tolerance:
        Length below which gaps and overlaps between blocks are nothing; raise it for coordinates that
        were rounded (default: 1e-6 of the diagonal round the movable blocks).
    contact_tolerance:
        In space: faces of two blocks that face each other touch if they stand no farther apart than this, or
        reach no deeper into each other, for blocks that are drawn apart or into one another. Small details
        stay, other than with a large ``tolerance`` (default: the tolerance).
    thickness:
        Out of the plane (solids have their own). What is per unit length in the plane is then per unit area,
        and what is per unit area per unit volume: ``unit_weight``, cohesion, ``dilatancy_stress`` and edge
        loads are multiplied by it. ``weight``, ``live`` and ``dead`` are forces as they are.
    tilt:
        "left" or "right": the ground is tilted until the scene falls to that side. The live load is every
        block's weight, turned a quarter from gravity to that side, and the load factor the tangent of the
        tilt. Goes with weights and friction alone. In space a direction ``[x, y, z]``, of which the part
        square to gravity counts.
    edge_loads:
        :class:`EdgeLoad` records: loads along edges.
    loads:
        :class:`Load` records: forces on single blocks by name, beside those the blocks have.
    axles:
        :class:`Axles` records: groups of axles that move along a road, for :func:`~masonry_opt.crossing`
        alone; in the plane.
    fills:
        :class:`Fill` records: earth between blocks and a road; in the plane, with gravity straight down.
    ties, props:
        :class:`Tie` and :class:`Prop` records.
    load_cases:
        :class:`LoadCase` records, of which :func:`solve` takes one by its name and :func:`solve_cases` all.
    earthquake:
        The live load of a scene without load cases: :class:`Earthquake`.
    title, source:
        What the scene is and where it comes from.
    reference:
        Published values by name (``associative``, ``nonassociative``, ``mcp``, ``mpec``, ...).

    Raises
    ------
    CaseError
        If names repeat, no block is fixed or none can move, an exception or load names no block, a load a
        fixed one, a scene to be tilted has what does not tilt, one of an earthquake live loads, a load case
        names a group that no load has, or a scene in space what belongs in the plane (edge loads, fills,
        ``thickness``, ``strength``, ``dilatancy_stress``) or the other way round; if fills lie above each
        other, or gravity is not straight down.
    """

    _origin: str = PrivateAttr(default="scene")
    _case: SceneKeys | None = PrivateAttr(default=None)
    _load_case: LoadCase | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _consistent(self) -> Scene:
        if not any(self.gravity):
            raise ValueError("'gravity' needs a direction, such as [0, -1], of solids [0, 0, -1]")
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
        if mistake := (
            self._wrong_dimension()
            or self._wrong_exception(known)
            or self._wrong_load(known)
            or self._wrong_axles()
            or self._wrong_fill()
            or wrong_strut(self)
            or self._wrong_tilt()
            or wrong_cases(self)
        ):
            raise ValueError(mistake)
        return self

    def _wrong_dimension(self) -> str | None:
        """What is of the plane in a scene in space, or the other way round."""
        first, space = self.blocks[0], self.dimension == 3
        for block in self.blocks:
            if isinstance(block, Solid) != space:
                solid, flat = (first, block) if space else (block, first)
                return (
                    f"block '{solid.name}' is a solid and block '{flat.name}' lies in the plane: give all of "
                    "a scene the one or the other ('extrude' makes solids of a scene in the plane)"
                )
        needed = "needs three numbers, [x, y, z]" if space else "needs two numbers, [x, y]"
        if len(self.gravity) != self.dimension:
            return f"'gravity' {needed}, as block '{first.name}' does"
        for number, load in enumerate(self.loads, start=1):
            where = f"load no. {number} on block '{load.block}'"
            for key in ("live", "dead", "at"):
                if (value := getattr(load, key)) and len(value) != self.dimension:
                    return f"{where}: '{key}' {needed}"
            for key in ("live_moment", "dead_moment"):
                if getattr(load, key) and not space:
                    return f"{where}: '{key}' is for solids: take it away"
        if self.tilt and isinstance(self.tilt, str) == space:
            return "'tilt' needs a direction, [x, y, z]" if space else '\'tilt\' needs "left" or "right"'
        if space and "thickness" in self.model_fields_set:
            return f"'thickness' is for scenes in the plane: block '{first.name}' is a solid"
        if not space and self.contact_tolerance is not None:
            return "'contact_tolerance' is for scenes in space: give 'tolerance'"
        return self.of_plane_alone() if space else None

    def of_plane_alone(self) -> str | None:
        """What the scene has, beside its thickness, that none in space can have, in one sentence."""
        if self.edge_loads:
            return "an 'edge_load' is for scenes in the plane: give the resultants as 'load'"
        if self.axles:
            return "'axles' move over scenes in the plane: take them away"
        if self.fills:
            return "a 'fill' is for scenes in the plane: give what it weighs and presses as 'load'"
        properties: list[tuple[str, JointDefaults | Joint]] = [("'joints'", self.joints)]
        properties += [(f"joint between {list(one.between)}", one) for one in self.exceptions]
        for where, joint in properties:
            for key in ("strength", "dilatancy_stress"):
                if getattr(joint, key) is not None:
                    return f"{where}: '{key}' is for joints in the plane: take it away"
        return None

    def _wrong_exception(self, known: Mapping[str, Block | Solid]) -> str | None:
        pairs: set[frozenset[str]] = set()
        for exception in self.exceptions:
            where, pair = f"joint between {list(exception.between)}", frozenset(exception.between)
            if unknown := [name for name in exception.between if name not in known]:
                return f"{where}: no block '{unknown[0]}'{did_you_mean(unknown[0], known)}"
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

    def _wrong_load(self, known: Mapping[str, Block | Solid]) -> str | None:
        weighed: set[str] = set()
        for number, load in enumerate(self.loads, start=1):
            if load.block not in known:
                return f"load no. {number}: no block '{load.block}'{did_you_mean(load.block, known)}"
            if known[load.block].fixed:
                return f"load no. {number}: block '{load.block}' is fixed: load one that can move"
            if load.weight is not None:
                if load.block in weighed:
                    return f"load no. {number}: gives block '{load.block}' a second 'weight'"
                weighed.add(load.block)
        return None

    def _wrong_axles(self) -> str | None:
        names = [group.name for group in self.axles]
        twice = [name for name in names if names.count(name) > 1]
        return f"two groups of axles are named '{twice[0]}': rename one" if twice else None

    def _wrong_fill(self) -> str | None:
        if self.fills and (self.gravity[0] != 0 or self.gravity[1] > 0):
            return "a 'fill' needs gravity straight down, [0, -1]"
        ends = sorted(
            (fill.road[0][0], fill.road[-1][0], number) for number, fill in enumerate(self.fills, start=1)
        )
        for (_, end, one), (start, _, other) in itertools.pairwise(ends):
            if start < end:
                return f"fill no. {one} and no. {other} lie above each other: end one where the other begins"
        return None

    def _wrong_tilt(self) -> str | None:
        if not self.tilt:
            return None
        # Tilted by θ, weights are cos θ (W + tan θ W'), W' the weights turned a quarter: λ = tan θ if all
        # else grows with cos θ too. Other forces do not, nor does what joints resist without being pressed.
        why = [
            f"block '{block.name}' has a force '{force}', which does not tilt"
            for block in self.blocks
            for force in block.LOADS
            if any(getattr(block, force))
        ]
        why += [
            f"a 'load' on block '{load.block}' is a force, which does not tilt"
            for load in self.loads
            if load.is_force
        ]
        why += ["an 'edge_load' does not tilt"] * len(self.edge_loads)
        why += ["'axles' do not tilt"] * len(self.axles)
        why += ["a 'fill' does not tilt"] * len(self.fills)
        why += ["a tie or prop does not grow with the weights"] * len([*self.ties, *self.props])
        properties: list[JointDefaults | Joint] = [self.joints, *self.exceptions]
        for joint in properties:
            resisting = {
                "cohesion": joint.cohesion,
                "strength": joint.strength,
                "dilatancy_stress": joint.dilatancy_stress and joint.dilatancy,
            }
            why += [f"'{key}' does not grow with the weights" for key, value in resisting.items() if value]
        if self.tilt_direction is None:
            return "'tilt' needs a direction that is not that of gravity"
        return f"'tilt' needs a scene of weights and friction alone: {why[0]}: take it away" if why else None

    def replace(self, **changes: Any) -> Self:
        """A scene with other values, checked as a call checks them, read from the same file and in the same
        load case; this one stays as it is.

        A mapping changes the keys of a record, or the records of a list, that it names:
        ``scene.replace(joints={"friction": 0.3}, blocks={"A": {"weight": 3}})``. A key of ``joints`` or of
        ``earthquake`` needs no mapping if nothing else in the scene has it: ``scene.replace(friction=0.3)``.

        Raises
        ------
        CaseError
            If a key is unknown or may be one of several, or a call with these values would raise it.
        """
        return super().replace(**changes).read_from(self.origin, self.case).in_case_of(self)

    def in_case(self, name: str) -> Self:
        """The scene in one of its load cases, by name. Raises OptionError if it has no such case."""
        by_name = {case.name: case for case in self.load_cases}
        if name in by_name:
            return self.under(by_name[name])
        there = (
            f"; there are: {', '.join(map(repr, by_name))}"
            if by_name
            else ": it has none; leave the name out"
        )
        raise OptionError(f"{self.origin}: no load case {name!r}{there}")

    def under(self, case: LoadCase | None) -> Self:
        """The scene under a load case, whose groups and directions it knows."""
        scene = self.model_copy()
        scene._load_case = case
        return scene

    def in_case_of(self, other: Scene) -> Self:
        """The scene in the load case that another one, from which it was made, is in."""
        case = other.load_case
        return self.in_case(case.name) if case in other.load_cases else self.under(case)

    @property
    def load_case(self) -> LoadCase | None:
        """The load case that it is in; None: loads act as they are given."""
        return self._load_case

    @property
    def shaken_by(self) -> Earthquake | None:
        """The earthquake that it is in, which is then its one live load."""
        return self.earthquake if self._load_case is None else self._load_case.earthquake

    def factor(self, kind: Kind, given: str, group: str | None = None) -> float:
        """What loads of a group, given as "weight", "dead" or "live", are multiplied by as dead or live."""
        if kind == "live" and self.shaken_by is not None:
            return 0.0
        if self._load_case is not None:
            return self._load_case.factor(kind, group or given)
        return float((kind == "live") == (given == "live"))

    @property
    def factor_of_axles(self) -> float:
        """What axles are multiplied by where they cross: 0 in a load case that does not name them."""
        return self.factor("live", "live", "axles")

    @property
    def shaking(self) -> np.ndarray | None:
        """Push of an earthquake over the weights that it pushes, shape (2,) or (3,); None without one."""
        quake = self.shaken_by
        if quake is None or (sideways := self.sideways(quake.direction, quake.vector)) is None:
            return None
        return np.asarray(quake.coefficient * (sideways + quake.vertical * self.down))

    @property
    def down(self) -> np.ndarray:
        """Unit vector of gravity, shape (2,) or (3,)."""
        return _unit(np.array(self.gravity))

    @property
    def tilt_direction(self) -> np.ndarray | None:
        """Unit vector square to gravity, shape (2,) or (3,), in which a tilted scene is pushed; None if it is
        not tilted, or only along gravity."""
        return None if self.tilt is None else self.sideways(self.tilt, self.tilt)

    def sideways(self, side: object, vector: Iterable[object]) -> np.ndarray | None:
        """Unit vector square to gravity to a side, "left" or "right", or in space towards a vector; None if
        that is along gravity."""
        if isinstance(side, str):
            x, y = self.down
            return np.array((-y, x) if side == "right" else (y, -x))
        given = np.array(vector, dtype=float)
        towards = _unit(given) if given.any() else self.down
        sideways = towards - (towards @ self.down) * self.down
        return _unit(sideways) if np.abs(sideways).max() > _ALONG_GRAVITY else None

    def in_plane(self) -> list[Block]:
        """The blocks of a scene in the plane. Raises OptionError of one in space."""
        if self.dimension == 3:
            raise OptionError(f"{self.origin}: its blocks are solids: this is for scenes in the plane")
        return [block for block in self.blocks if isinstance(block, Block)]

    def in_space(self) -> list[Solid]:
        """The blocks of a scene in space. Raises OptionError of one in the plane."""
        if self.dimension == 2:
            raise OptionError(f"{self.origin}: its blocks lie in the plane: this is for solids")
        return [block for block in self.blocks if isinstance(block, Solid)]

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

    def read_from(self, origin: str | Path, case: SceneKeys | None = None) -> Self:
        """The same scene with the file it was read from, and the content of that."""
        scene = self.model_copy()
        scene._origin, scene._case = str(origin), case
        return scene

    def __eq__(self, other: object) -> bool:
        """Scenes are equal if their keys are, wherever they were read from."""
        same = isinstance(other, Scene) and self.load_case == other.load_case
        return same and self.model_dump() == other.model_dump()  # type: ignore[attr-defined]


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.hypot.reduce(vector)
