"""Define the scene: blocks, joint properties, gravity and loads, before any mathematics."""

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

#: Largest number of blocks for which a notebook displays a drawing. A larger scene is not drawn, because
#: notebooks store their pictures and would become large.
_MOST_DRAWN_BLOCKS = 2000


class Scene(SceneKeys):
    """Rigid blocks with loads and joint properties. The joints are computed from the geometry.

    ``scene["A"]`` is the block with that name.

    Parameters
    ----------
    blocks: At least one movable :class:`Block` and its supports, with unique names. A scene in space has
        :class:`Solid` records instead.
    joints: Properties of every joint (:class:`JointDefaults`, or a mapping with the same keys).
    exceptions: Records for joints with other properties (:class:`Joint`).
    gravity: Direction in which weights act; its length has no effect. The default is straight down: −y, in
        space −z.
    tolerance: Length below which gaps and overlaps between blocks are ignored (default: 1e-6 of the diagonal
        round the movable blocks). Raise it if coordinates are rounded.
    contact_tolerance: Largest gap or overlap of edges (in space: faces) that are in contact, for blocks that
        are drawn apart or into one another (default: the tolerance). The joint of two facing edges is their
        projection onto each other, in the middle of the gap. In contrast to a large ``tolerance``, it does
        not change small details and corners of the drawing.
    thickness: Thickness out of the plane (solids have their own). It multiplies all quantities per unit
        length or area of the plane: ``unit_weight``, cohesion, ``dilatancy_stress`` and edge loads, which are
        then per unit area or volume. The forces ``weight``, ``live`` and ``dead`` are not multiplied.
    tilt: "left" or "right": the side to which the ground is tilted until the scene collapses. The live load
        is the weight of every block, rotated by 90° from gravity to that side, and the load factor is the
        tangent of the tilt angle. A tilted scene may have only weights and friction. In space a direction
        ``[x, y, z]``, of which only the component perpendicular to gravity is used.
    edge_loads: Loads along edges (:class:`EdgeLoad`).
    loads: Forces on single blocks by name (:class:`Load`), in addition to the forces in the blocks' own keys.
    axles: Groups of axles that move along a road (:class:`Axles`), in the plane. Only
        :func:`~masonry_opt.crossing` uses them.
    fills: Earth between blocks and a road (:class:`Fill`); in the plane, with gravity straight down.
    ties, props: :class:`Tie` and :class:`Prop` records.
    load_cases: Load cases (:class:`LoadCase`): :func:`solve` solves one of them by its name,
        :func:`solve_cases` solves all.
    earthquake: The live load of a scene without load cases: :class:`Earthquake`.
    title, source: Title of the scene, and the source from which the scene is taken.
    reference: Published values by name (``associative``, ``nonassociative``, ``mcp``, ``mpec``, ...).

    Raises
    ------
    CaseError
        If the records contradict each other. The message names the record and the remedy. These are errors:

        - Two blocks have one name, no block can move, or nothing holds the blocks. Blocks are held by a fixed
          block, or by a tie or prop that ends at ``"ground"``.
        - An exception or a load names a block that does not exist, or a load acts on a fixed block.
        - A tilted scene has loads other than weights, or a scene with an earthquake has other live loads.
        - A load case names a group to which no load belongs.
        - A scene in space has keys of the plane (edge loads, fills, ``thickness``, ``strength``,
          ``dilatancy_stress``), or a scene in the plane has keys of space.
        - Fills lie above each other, or gravity is not straight down in a scene with fills.
    """

    _origin: str = "scene"
    _case: SceneKeys | None = None
    _load_case: LoadCase | None = None
    #: State after a settlement (see ``problem/settled.py``); None if no support has settled.
    _settled: Any = None

    def _mistakes(self) -> Iterator[str]:
        return inconsistencies(self)

    @property
    def fixed(self) -> np.ndarray:
        """Return a mask of the fixed blocks, shape (blocks,)."""
        return np.array([block.fixed for block in self.blocks])

    def __getitem__(self, name: str) -> Block | Solid:
        """Return the block with the given name.

        Raises CaseError if the scene has no such block.
        """
        by_name = {block.name: block for block in self.blocks}
        if name not in by_name:
            raise CaseError(f"{self.origin}: no block is named {name!r}{did_you_mean(str(name), by_name)}")
        return by_name[name]

    def __repr__(self) -> str:
        """Return two lines of text: the name of the scene, and the number of records of each kind."""
        lists = {name: value for name, value in vars(self).items() if isinstance(value, list) and value}
        facts = [
            counted(len(records), name.removesuffix("s").replace("_", " ")) for name, records in lists.items()
        ]
        facts.append(f"{self.fixed.sum()} of the blocks fixed")
        law = self.joints.model_dump(exclude_defaults=True)
        facts += [f"{key} {value:.4g}" for key, value in law.items() if isinstance(value, float)]
        facts += [key for key in ("tilt", "earthquake") if getattr(self, key)]
        if self.load_case:
            facts.append(f"in load case {self.load_case.name!r}")
        where = "the plane" if self.dimension == 2 else "space"
        return f"<Scene {self.called!r} in {where}\n {', '.join(facts)}>"

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """Return the HTML for a notebook: the text of ``repr`` and the drawing of ``mo.draw``."""
        # Import the package here: drawing depends on scenes, and a global import would be circular.
        import masonry_opt as mo

        text = repr(self)
        drawing = ""
        try:
            if len(self.blocks) > _MOST_DRAWN_BLOCKS:
                raise OptionError(
                    f"the scene has more than {_MOST_DRAWN_BLOCKS} blocks: call mo.draw(scene) to draw it"
                )
            drawing = (
                f'<img alt="{escape(self.called)}" style="max-width:100%" src="{mo.draw(self).source()}">'
            )
        except MasonryError as error:
            text += f"\n not drawn: {error}"
        return f'<pre style="white-space:pre-wrap">{escape(text)}</pre>{drawing}'

    def replace(self, **changes: Any) -> Self:
        """Return a copy of the scene with changed values, which are validated.

        The new scene has the same origin, load case and settlement of supports. A mapping changes only the
        keys of a record, or the records of a list, that it names: ``scene.replace(joints={"friction": 0.3},
        blocks={"A": {"weight": 3}})``. A key of ``joints`` or of ``earthquake`` needs no mapping if no other
        record of the scene has it: ``scene.replace(friction=0.3)``.

        Parameters
        ----------
        **changes: New values by the names of the scene's parameters.

        Returns
        -------
        Scene
            The changed copy.

        Raises
        ------
        CaseError
            If a key is unknown or ambiguous, or if a value is not valid.
        """
        scene = super().replace(**changes).read_from(self.origin, self.case).in_case_of(self)
        return scene if self.settled is None else scene.settled_as(self.settled)

    def in_case(self, name: str) -> Self:
        """Return the scene with the loads of one of its load cases, given by name.

        Parameters
        ----------
        name: Name of the load case.

        Returns
        -------
        Scene
            A copy of the scene, in which this load case is selected.

        Raises
        ------
        OptionError
            If the scene has no load case with this name.
        """
        by_name = {case.name: case for case in self.load_cases}
        if name in by_name:
            return self.with_load_case(by_name[name])
        if not by_name:
            raise OptionError(
                f"{self.origin}: the scene has no load cases, so {name!r} cannot be chosen: omit the name"
            )
        known_names = ", ".join(map(repr, by_name))
        suggestion = did_you_mean(str(name), by_name) or f"; there are: {known_names}"
        raise OptionError(f"{self.origin}: no load case {name!r}{suggestion}")

    def with_load_case(self, case: LoadCase | None) -> Self:
        """Return the scene in a given load case. The load case is not checked for unknown groups.

        Parameters
        ----------
        case: The load case, or None for no load case.

        Returns
        -------
        Scene
            A copy of the scene.
        """
        scene = self.model_copy()
        scene._load_case = case
        return scene

    def in_case_of(self, scene: "Scene") -> Self:
        """Return a copy of this scene with the selected load case of another scene.

        If the load case is in the list ``scene.load_cases``, the result has the load case with the same name
        from the list of this scene. Otherwise the result has the load case of ``scene`` itself.

        Parameters
        ----------
        scene: Scene whose load case is selected.

        Returns
        -------
        Scene
            A copy of this scene.

        Raises
        ------
        OptionError
            If this scene has no load case with the name.
        """
        case = scene.load_case
        return self.in_case(case.name) if case in scene.load_cases else self.with_load_case(case)

    def refuse_without_case(self) -> None:
        """Raise OptionError if the scene has load cases but none is selected.

        Without a selected load case, the acting loads are unknown.
        """
        if self.load_cases and self.load_case is None:
            raise OptionError(
                f"{self.origin}: the scene has load cases "
                f"({', '.join(repr(case.name) for case in self.load_cases)}): "
                "choose one with 'load_case' (--load-case; in Python, scene.in_case(name)), or "
                "compute all of them with 'solve' (mo.solve_cases)"
            )

    @property
    def load_case(self) -> LoadCase | None:
        """Return the selected load case, or None if no load case is selected."""
        return self._load_case

    @property
    def settled(self) -> Any:
        """Return the state of the scene after supports have settled, or None if no support has settled."""
        return self._settled

    def settled_as(self, state: Any) -> Self:
        """Return a copy of the scene in a given state after a settlement of supports.

        Parameters
        ----------
        state: State after the settlement, see ``problem/settled.py``.

        Returns
        -------
        Scene
            A copy of the scene.
        """
        scene = self.model_copy()
        scene._settled = state
        return scene

    @property
    def shaken_by(self) -> Earthquake | None:
        """Return the earthquake that is the only live load, or None if the live load is not an earthquake."""
        return self.earthquake if self._load_case is None else self._load_case.earthquake

    def shaken(self, quake: Earthquake) -> Self:
        """Return the scene shaken by an earthquake, which replaces all other live loads.

        The dead loads remain those of its load case. The result has no reference values, because reference
        values are load factors of other live loads.

        Parameters
        ----------
        quake: Earthquake that is the only live load.

        Returns
        -------
        Scene
            A copy of the scene without reference values.

        Raises
        ------
        CaseError
            If the direction of the earthquake is not valid in this scene.
        """
        mistake = wrong_direction(self, quake)
        if mistake:
            raise CaseError(f"{self.origin}: 'earthquake': {mistake}")
        without_reference = BaseModel.model_copy(self, update={"reference": {}})
        case = self.load_case
        if case:
            return without_reference.with_load_case(case.replace(live={}, earthquake=quake))
        # Do not validate the copy, because an earthquake together with other live loads would raise an error.
        return BaseModel.model_copy(without_reference, update={"earthquake": quake})

    def factor(self, kind: Kind, source: str, group: str | None = None) -> float:
        """Return the factor of a load group in the dead load or in the live load.

        Parameters
        ----------
        kind: "dead" or "live".
        source: Kind of load in the scene: "weight", "fill", "dead" or "live".
        group: Name of the load's own group, or None.

        Returns
        -------
        float
            The factor.
        """
        if kind == "live" and self.shaken_by is not None:
            return 0.0
        if self._load_case is not None:
            return self._load_case.factor(kind, group or source)
        return float((kind == "live") == (source == "live"))

    @property
    def factor_of_axles(self) -> float:
        """Return the factor of moving axle loads, which is 0 in a load case without axles."""
        return self.factor("live", "live", "axles")

    @property
    def moves_axles(self) -> bool:
        """Return True if moving axles are a live load in the selected load case.

        If no load case is selected, return True if moving axles are a live load in any load case. Axles do
        not move over a tilted ground, nor in an earthquake.
        """
        if not self.axles or self.tilt:
            return False
        cases = [] if self.load_case else self.load_cases
        scenes = [self.with_load_case(case) for case in cases] or [self]
        return any(scene.factor_of_axles for scene in scenes)

    @property
    def factor_of_pressure(self) -> float:
        """Return the number by which the selected load case multiplies the earth pressures of fills."""
        return 1.0 if self._load_case is None else self._load_case.pressure

    @property
    def shaking(self) -> np.ndarray | None:
        """Return the force of the earthquake on each unit of weight at λ = 1, shape (2,) or (3,).

        The result is None if there is no earthquake.
        """
        quake = self.shaken_by
        if quake is None:
            return None
        sideways = self.sideways(quake.towards)
        if sideways is None:
            return None
        return np.asarray(quake.coefficient * (sideways + quake.vertical * self.down))

    def in_plane(self) -> list[Block]:
        """Return the blocks of a plane scene.

        Returns
        -------
        list of Block
            The blocks.

        Raises
        ------
        OptionError
            If the scene is in space.
        """
        if self.dimension == 3:
            raise OptionError(
                f"{self.origin}: the blocks are solids, but this function needs a scene in the plane"
            )
        return [block for block in self.blocks if isinstance(block, Block)]

    def in_space(self) -> list[Solid]:
        """Return the blocks of a three-dimensional scene, which are solids.

        Returns
        -------
        list of Solid
            The solids.

        Raises
        ------
        OptionError
            If the scene is in the plane.
        """
        if self.dimension == 2:
            raise OptionError(f"{self.origin}: the blocks lie in the plane, but this function needs solids")
        return [block for block in self.blocks if isinstance(block, Solid)]

    @property
    def origin(self) -> str:
        """Return the path of the scene's case file, or ``"scene"`` if the scene has no case file.

        Error messages begin with this text.
        """
        return self._origin

    @property
    def called(self) -> str:
        """Return the name of the scene in results: its case file, or else its title, or else ``"scene"``.

        If supports have settled, their movements are added to the name.
        """
        name = self._origin if self._origin != "scene" else self.title or "scene"
        return name if self.settled is None else f"{name}, settled: {self.settled}"

    @property
    def case(self) -> SceneKeys | None:
        """Return the original content of the case file, in which generators are not expanded.

        The result is None if the scene was made in Python.
        """
        return self._case

    def read_from(self, origin: str | Path, case: SceneKeys | None = None) -> Self:
        """Return a copy of the scene that stores the name and the original content of its case file.

        Parameters
        ----------
        origin: Path of the case file, or another text that names the scene in error messages.
        case: Content of the case file, or None.

        Returns
        -------
        Scene
            A copy of the scene.
        """
        scene = self.model_copy()
        scene._origin, scene._case = str(origin), case
        return scene

    def __eq__(self, other: object) -> bool:
        """Return True if all values, the selected load cases and the settlements of two scenes are equal.

        Equal scenes may be read from different files.
        """
        is_equal = isinstance(other, Scene) and self.load_case == other.load_case
        is_equal = is_equal and self.settled is other.settled  # type: ignore[attr-defined]
        return is_equal and self.model_dump() == other.model_dump()  # type: ignore[attr-defined]
