"""The scene: blocks, joint properties and gravity, before any mathematics; in one of its load cases."""

from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any, Self

import numpy as np
from pydantic import BaseModel

from masonry_opt.errors import CaseError, MasonryError, OptionError, counted
from masonry_opt.scene.blocks import Block
from masonry_opt.scene.keys import SceneKeys, inconsistencies, wrong_direction
from masonry_opt.scene.loads import Earthquake, Kind, LoadCase
from masonry_opt.scene.mistakes import did_you_mean
from masonry_opt.scene.solids import Solid

_DRAWN = 2000  #: Blocks above which a notebook, which keeps all that it shows, shows no drawing.


class Scene(SceneKeys):
    """Rigid blocks and their joint properties; the joints are found from the geometry. ``scene["A"]`` is the
    block of that name.

    Raises CaseError if names repeat, no block is fixed or none can move, an exception or load names no block,
    a load a fixed one, a scene to be tilted has what does not tilt, one of an earthquake live loads, a load
    case names a group that no load has, or a scene in space what belongs in the plane (edge loads, fills,
    ``thickness``, ``strength``, ``dilatancy_stress``) or the other way round; if fills lie above each other,
    or gravity is not straight down.

    Parameters
    ----------
    blocks: At least one fixed and one movable :class:`Block`, with unique names; for a scene in space
        :class:`Solid` in place of each.
    joints: Properties of every joint (:class:`JointDefaults`, or a mapping with the same keys).
    exceptions: Records for the joints that differ (:class:`Joint`).
    gravity: Direction in which weights act (only the direction counts), default straight down: -y, in space
        -z.
    tolerance: Length below which gaps and overlaps between blocks are nothing; raise it for coordinates that
        were rounded (default: 1e-6 of the diagonal round the movable blocks).
    contact_tolerance: In space: faces of two blocks that face each other touch if they stand no farther apart
        than this, or reach no deeper into each other, for blocks that are drawn apart or into one another.
        Small details stay, other than with a large ``tolerance`` (default: the tolerance).
    thickness: Out of the plane (solids have their own). What is per unit length in the plane is then per unit
        area, and what is per unit area per unit volume: ``unit_weight``, cohesion, ``dilatancy_stress`` and
        edge loads are multiplied by it. ``weight``, ``live`` and ``dead`` are forces as they are.
    tilt: "left" or "right": the ground is tilted until the scene falls to that side. The live load is every
        block's weight, turned a quarter from gravity to that side, and the load factor the tangent of the
        tilt. Goes with weights and friction alone. In space a direction ``[x, y, z]``, of which the part
        square to gravity counts.
    edge_loads: Loads along edges (:class:`EdgeLoad`).
    loads: Forces on single blocks by name (:class:`Load`), beside those the blocks have.
    axles: Groups of axles that move along a road (:class:`Axles`), for :func:`~masonry_opt.crossing` alone;
        in the plane.
    fills: Earth between blocks and a road (:class:`Fill`); in the plane, with gravity straight down.
    ties, props: :class:`Tie` and :class:`Prop` records.
    load_cases: Of them (:class:`LoadCase`) :func:`solve` takes one by its name, :func:`solve_cases` all.
    earthquake: The live load of a scene without load cases: :class:`Earthquake`.
    title, source: What the scene is and where it comes from.
    reference: Published values by name (``associative``, ``nonassociative``, ``mcp``, ``mpec``, ...).
    """

    _origin: str = "scene"
    _case: SceneKeys | None = None
    _load_case: LoadCase | None = None

    def _mistakes(self) -> Iterator[str]:
        return inconsistencies(self)

    @property
    def fixed(self) -> np.ndarray:
        """Which blocks are fixed, shape (blocks,)."""
        return np.array([block.fixed for block in self.blocks])

    def __getitem__(self, name: str) -> Block | Solid:
        """The block of a name. Raises CaseError if there is none."""
        by_name = {block.name: block for block in self.blocks}
        if name not in by_name:
            raise CaseError(f"{self.origin}: no block is named {name!r}{did_you_mean(str(name), by_name)}")
        return by_name[name]

    def __repr__(self) -> str:
        """Two lines: what it is called, and how many records of each kind it has."""
        lists = {name: of for name, of in vars(self).items() if isinstance(of, list) and of}
        said = [counted(len(of), name.removesuffix("s").replace("_", " ")) for name, of in lists.items()]
        said.append(f"{self.fixed.sum()} of the blocks fixed")
        law = self.joints.model_dump(exclude_defaults=True)
        said += [f"{key} {value:.4g}" for key, value in law.items() if isinstance(value, float)]
        said += [key for key in ("tilt", "earthquake") if getattr(self, key)]
        if self.load_case:
            said.append(f"in load case {self.load_case.name!r}")
        where = "the plane" if self.dimension == 2 else "space"
        return f"<Scene {self.called!r} in {where}\n {', '.join(said)}>"

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """What a notebook shows: these lines, and what ``mo.draw`` draws."""
        # By way of the package, which imports names when they are wanted: what draws stands above scenes.
        import masonry_opt as mo

        said, drawn = repr(self), ""
        try:
            if len(self.blocks) > _DRAWN:
                raise OptionError(f"its blocks are more than {_DRAWN}; mo.draw(scene) draws them")
            drawn = f'<img alt="{escape(self.called)}" style="max-width:100%" src="{mo.draw(self).source()}">'
        except MasonryError as error:
            said += f"\n not drawn: {error}"
        return f'<pre style="white-space:pre-wrap">{escape(said)}</pre>{drawn}'

    def replace(self, **changes: Any) -> Self:
        """A scene with other values, checked as a call checks them, read from the same file and in the same
        load case; this one stays as it is.

        A mapping changes the keys of a record, or the records of a list, that it names:
        ``scene.replace(joints={"friction": 0.3}, blocks={"A": {"weight": 3}})``. A key of ``joints`` or of
        ``earthquake`` needs no mapping if nothing else in the scene has it: ``scene.replace(friction=0.3)``.

        Raises CaseError if a key is unknown or may be one of several, or a call with these values would.
        """
        return super().replace(**changes).read_from(self.origin, self.case).in_case_of(self)

    def in_case(self, name: str) -> Self:
        """The scene in one of its load cases, by name. Raises OptionError if it has no such case."""
        by_name = {case.name: case for case in self.load_cases}
        if name in by_name:
            return self.with_load_case(by_name[name])
        there = ", ".join(map(repr, by_name))
        what = f"there are: {there}" if there else "it has none: leave the name out"
        raise OptionError(f"{self.origin}: no load case {name!r}; {what}")

    def with_load_case(self, case: LoadCase | None) -> Self:
        """The scene in a load case, whose groups and directions it knows."""
        scene = self.model_copy()
        scene._load_case = case
        return scene

    def in_case_of(self, other: "Scene") -> Self:
        """The scene in the load case that another one, from which it was made, is in."""
        case = other.load_case
        return self.in_case(case.name) if case in other.load_cases else self.with_load_case(case)

    def refuse_without_case(self) -> None:
        """Raise OptionError if it has load cases and is in none of them: which loads act is not known."""
        if self.load_cases and self.load_case is None:
            raise OptionError(
                f"{self.origin}: has load cases: name one of them, 'load_case' (--load-case): "
                f"{', '.join(case.name for case in self.load_cases)} (in Python scene.in_case(name) is the "
                "scene in one, and mo.solve_cases solves all, as the command solve does)"
            )

    @property
    def load_case(self) -> LoadCase | None:
        """The load case that it is in; None: loads act as they are given."""
        return self._load_case

    @property
    def shaken_by(self) -> Earthquake | None:
        """The earthquake that it is in, which is then its one live load."""
        return self.earthquake if self._load_case is None else self._load_case.earthquake

    def shaken(self, quake: Earthquake) -> Self:
        """Return the scene in an earthquake in place of all other live loads, with the dead loads of its load
        case. It has no reference values: those are load factors of other live loads.

        Raises CaseError if the scene cannot be in that earthquake.
        """
        if mistake := wrong_direction(self, quake):
            raise CaseError(f"{self.origin}: 'earthquake': {mistake}")
        without = BaseModel.model_copy(self, update={"reference": {}})
        if case := self.load_case:
            return without.with_load_case(case.replace(live={}, earthquake=quake))
        # Beside other live loads, which no longer act, a scene that is checked takes none.
        return BaseModel.model_copy(without, update={"earthquake": quake})

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
    def factor_of_pressure(self) -> float:
        """What the pressures of fills are multiplied by."""
        return 1.0 if self._load_case is None else self._load_case.pressure

    @property
    def shaking(self) -> np.ndarray | None:
        """Push of an earthquake over the weights that it pushes, shape (2,) or (3,); None without one."""
        quake = self.shaken_by
        if quake is None or (sideways := self.sideways(quake.towards)) is None:
            return None
        return np.asarray(quake.coefficient * (sideways + quake.vertical * self.down))

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
