"""Define the keys that scenes and case files share, and check that the values of the keys are consistent."""

import itertools
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, Tag

from masonry_opt.errors import CaseError
from masonry_opt.scene.blocks import Name, Positive, Record, Reference, Text
from masonry_opt.scene.joints import Joint, JointDefaults
from masonry_opt.scene.loads import GROUND, GROUPS, Earthquake, EdgeLoad, Load, LoadCase, Prop, Tie
from masonry_opt.scene.mistakes import did_you_mean, repeated
from masonry_opt.scene.road import Axles, Fill
from masonry_opt.scene.solids import ONE_OR_SEVERAL, AnyBlock, PlaneOrSpaceVector, Vector

Tilt = Annotated[
    Annotated[Literal["left", "right"], Tag("<one>")] | Annotated[Vector, Tag("<several>")], ONE_OR_SEVERAL
]

#: Sine of the angle to gravity below which a direction counts as parallel to gravity, so that it is refused.
_PARALLEL_TOLERANCE = 1e-9

#: Map from the dimension to the description of a point in error messages.
_POINT = {2: "two numbers, [x, y]", 3: "three numbers, [x, y, z]"}

#: Map from the dimension to the description of an earthquake's direction in error messages.
_DIRECTION_FORMS = {2: '"left" or "right"', 3: "an angle in plan or [x, y, z]"}


class SceneKeys(Record):
    """Keys that a scene and a case file have in common."""

    title: Text = ""
    source: Text = ""
    gravity: PlaneOrSpaceVector = (0.0, -1.0)
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
    load_cases: Annotated[list[LoadCase], Field(alias="load_case")] = []
    earthquake: Earthquake | None = None
    reference: dict[Name, Reference] = {}

    def model_post_init(self, _: Any) -> None:
        """Let gravity point vertically downwards if the scene does not specify gravity."""
        if "gravity" not in self.model_fields_set:
            # Write to ``__dict__``, because the record is immutable and an ordinary assignment would raise an
            # error.
            self.__dict__["gravity"] = (*[0.0] * (self.dimension - 1), -1.0)

    @property
    def dimension(self) -> Literal[2, 3]:
        """Return the number of coordinates of a point: 3 if the blocks are solids, otherwise 2."""
        return self.blocks[0].dimension if self.blocks else 2

    @property
    def down(self) -> np.ndarray:
        """Return the unit vector that points down, along gravity, shape (2,) or (3,)."""
        return _unit(np.array(self.gravity))

    @property
    def tilt_direction(self) -> np.ndarray | None:
        """Return the unit vector, perpendicular to gravity, along which tilting pushes the blocks.

        The result is None if the scene is not tilted, or if the given direction is parallel to gravity.
        """
        return None if self.tilt is None else self.sideways(self.tilt)

    def sideways(self, towards: str | tuple[float, ...]) -> np.ndarray | None:
        """Return a unit vector perpendicular to gravity, towards the left, the right or a given vector.

        The component of a given vector along gravity is removed.

        The result is None if the vector is parallel to gravity.
        """
        if isinstance(towards, str):
            x, y = self.down
            return np.array((-y, x) if towards == "right" else (y, -x))
        vector = np.array(towards, dtype=float)
        unit = _unit(vector) if vector.any() else self.down
        projection = unit - (unit @ self.down) * self.down
        return _unit(projection) if np.abs(projection).max() > _PARALLEL_TOLERANCE else None


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.hypot.reduce(vector)


def inconsistencies(scene: SceneKeys) -> Iterator[str]:
    """Generate an error message for each inconsistency of a scene, with the most important first.

    Later checks assume that earlier checks pass, so only the first message is reliable.
    """
    if not any(scene.gravity):
        yield "'gravity' needs a direction, such as [0, -1], or [0, 0, -1] for solids"
    if not scene.blocks:
        yield "the scene has no block: add [[block]] tables or a generator such as [wall]"
    names = [block.name for block in scene.blocks]
    for name in repeated(names):
        first, second, *_ = [number for number, block_name in enumerate(names, start=1) if block_name == name]
        yield (
            f"blocks no. {first} and no. {second} are both named '{name}': "
            "rename one of them, or give each generator its own 'name'"
        )
    is_fixed = {block.name: block.fixed for block in scene.blocks}
    yield from _without_support(scene, is_fixed)
    if all(is_fixed.values()):
        yield "every block is fixed: the scene needs at least one movable block"
    yield from _wrong_dimension(scene)
    yield from _wrong_exceptions(scene, is_fixed)
    yield from _wrong_loads(scene, is_fixed)
    for name in repeated(group.name for group in scene.axles):
        yield f"two groups of axles are named '{name}': rename one of them"
    yield from _wrong_fills(scene)
    yield from _wrong_struts(scene, is_fixed)
    if scene.tilt and scene.tilt_direction is None:
        yield "'tilt' needs a direction that is not parallel to gravity"
    for obstacle in _tilt_obstacles(scene) if scene.tilt else ():
        yield (
            "'tilt' is allowed only if all loads are weights and joints resist by friction alone, "
            f"but {obstacle}: remove this load or property, or remove 'tilt'"
        )
    yield from _wrong_cases(scene)


def _without_support(scene: SceneKeys, is_fixed: Mapping[str, bool]) -> Iterator[str]:
    """Generate an error message if the scene has no fixed block, and no tie or prop ends at the ground.

    A tie or prop that ends at "ground" ends at the block of this name if the scene has such a block.
    """
    if any(is_fixed.values()):
        return
    if GROUND in is_fixed:
        yield f"no block is fixed, not even the block named '{GROUND}': mark the support with 'fixed = true'"
    elif not any(GROUND in strut.between for strut in (*scene.ties, *scene.props)):
        yield f"no block is fixed: mark the support with 'fixed = true', or end a tie at \"{GROUND}\""


def _wrong_dimension(scene: SceneKeys) -> Iterator[str]:
    """Generate an error message for each key or block that does not fit the dimension of the scene."""
    first = scene.blocks[0]
    for block in scene.blocks:
        if block.dimension != scene.dimension:
            flat_block, solid_block = sorted((first, block), key=lambda mixed_block: mixed_block.dimension)
            yield (
                f"block '{solid_block.name}' is a solid, but block '{flat_block.name}' lies in the plane: "
                "use only one of the two kinds ('extrude' converts a scene in the plane to solids)"
            )
    if len(scene.gravity) != scene.dimension:
        yield f"'gravity' needs {_POINT[scene.dimension]}, like the points of block '{first.name}'"
    yield from _wrong_load_dimension(scene)
    is_in_space = scene.dimension == 3
    if scene.tilt and isinstance(scene.tilt, str) == is_in_space:
        yield "'tilt' needs a direction, [x, y, z]" if is_in_space else '\'tilt\' needs "left" or "right"'
    if is_in_space and "thickness" in scene.model_fields_set:
        yield (
            f"'thickness' is only for scenes in the plane, but block '{first.name}' is a solid: "
            "remove 'thickness'"
        )
    if is_in_space:
        yield from of_plane_alone(scene)


def _wrong_load_dimension(scene: SceneKeys) -> Iterator[str]:
    """Generate an error message for each load whose vectors do not fit the dimension of the scene."""
    for number, load in enumerate(scene.loads, start=1):
        label = f"load no. {number} on block '{load.block}'"
        for key in ("live", "dead", "at"):
            vector = getattr(load, key)
            if vector and len(vector) != scene.dimension:
                yield f"{label}: '{key}' needs {_POINT[scene.dimension]}"
        for key in ("live_moment", "dead_moment"):
            if getattr(load, key) and scene.dimension == 2:
                yield f"{label} has '{key}', which is only for solids: remove it"


def of_plane_alone(scene: SceneKeys) -> Iterator[str]:
    """Generate an error message for each key of a scene in space that only plane scenes may have.

    The key ``thickness`` is not checked.
    """
    if scene.edge_loads:
        yield "'edge_load' is only for scenes in the plane: give the resultant forces as 'load'"
    if scene.axles:
        yield "'axles' are only for scenes in the plane: remove them"
    if scene.fills:
        yield "'fill' is only for scenes in the plane: give its weight and pressure as 'load'"
    for joint in (scene.joints, *scene.exceptions):
        label = f"joint between {list(joint.between)}" if isinstance(joint, Joint) else "'joints'"
        for key in ("strength", "dilatancy_stress"):
            if getattr(joint, key) is not None:
                yield f"{label}: '{key}' is only for joints in the plane: remove it"


def _wrong_exceptions(scene: SceneKeys, is_fixed: Mapping[str, bool]) -> Iterator[str]:
    """Generate an error message for each mistake in ``exceptions``, the joint properties of block pairs."""
    pairs: set[frozenset[str]] = set()
    for exception in scene.exceptions:
        label, pair = f"joint between {list(exception.between)}", frozenset(exception.between)
        for name in exception.between:
            if name not in is_fixed:
                yield f"{label}: no block is named '{name}'{did_you_mean(name, is_fixed)}"
        if len(pair) == 1:
            yield f"{label}: needs two different blocks"
        if pair in pairs:
            yield f"{label} is given twice: remove one of the two entries"
        pairs.add(pair)
        try:
            exception.over(scene.joints)
        except CaseError as error:
            yield f"{label}: {str(error).removeprefix('JointDefaults: ')}"


def _wrong_loads(scene: SceneKeys, is_fixed: Mapping[str, bool]) -> Iterator[str]:
    """Generate an error message for each mistake in the loads on blocks."""
    weighed_blocks: set[str] = set()
    for number, load in enumerate(scene.loads, start=1):
        if load.block not in is_fixed:
            yield f"load no. {number}: no block is named '{load.block}'{did_you_mean(load.block, is_fixed)}"
            continue
        if is_fixed[load.block]:
            yield f"load no. {number} acts on block '{load.block}', which is fixed: name a movable block"
        if load.weight is not None:
            if load.block in weighed_blocks:
                yield (
                    f"load no. {number} sets the 'weight' of block '{load.block}', but another load sets it "
                    "too: remove one of the two weights"
                )
            weighed_blocks.add(load.block)


def _wrong_fills(scene: SceneKeys) -> Iterator[str]:
    """Generate an error message for each mistake in the fills."""
    if scene.fills and (scene.gravity[0] != 0 or scene.gravity[1] > 0):
        yield "a 'fill' needs gravity that points straight down: set 'gravity' to [0, -1]"
    roads = [fill.road for fill in scene.fills]
    ends = sorted((road[0][0], road[-1][0], number) for number, road in enumerate(roads, start=1))
    for (_, end, left), (start, _, right) in itertools.pairwise(ends):
        if start < end:
            yield f"fill no. {left} and no. {right} overlap: end one fill where the other begins"


def _wrong_struts(scene: SceneKeys, is_fixed: Mapping[str, bool]) -> Iterator[str]:
    """Generate an error message for each mistake in the ends of ties and props."""
    for number, strut in (*enumerate(scene.ties, start=1), *enumerate(scene.props, start=1)):
        label = f"{type(strut).__name__.lower()} no. {number} between {list(strut.between)}"
        for name in strut.between:
            if name not in is_fixed and name != GROUND:
                suggestion = did_you_mean(name, is_fixed)
                yield f"{label}: no block is named '{name}'{suggestion} (\"{GROUND}\" is the fixed ground)"
        if all(is_fixed.get(name, True) for name in strut.between):
            yield f"{label} has no effect, because both ends are fixed: remove it"
        if len(strut.at[0]) != scene.dimension:
            yield f"{label}: 'at' needs points of {_POINT[scene.dimension]}"


def _tilt_obstacles(scene: SceneKeys) -> Iterator[str]:
    """Generate a clause of an error message for each load or property that a tilted scene must not have.

    If the ground is tilted by θ, the weights are cos θ (W + tan θ W'), where W' are the weights W rotated by
    90°. Therefore λ = tan θ if all other forces are proportional to cos θ too. Forces that do not tilt are
    not proportional to cos θ. Neither are joint resistances that do not depend on the normal force.
    """
    for block in scene.blocks:
        for force in block.LOADS:
            if any(getattr(block, force)):
                yield f"block '{block.name}' has a force '{force}', which does not tilt with the scene"
    for load in scene.loads:
        if load.is_force:
            yield f"a 'load' on block '{load.block}' is a force, which does not tilt with the scene"
    yield from ["an 'edge_load' does not tilt with the scene"] * len(scene.edge_loads)
    yield from ["'axles' do not tilt with the scene"] * len(scene.axles)
    yield from ["a 'fill' does not tilt with the scene"] * len(scene.fills)
    yield from ["the scene has a tie or prop, whose force is not proportional to the weights"] * len(
        [*scene.ties, *scene.props]
    )
    properties: list[JointDefaults | Joint] = [scene.joints, *scene.exceptions]
    for joint in properties:
        for key in ("cohesion", "strength", "dilatancy_stress"):
            if getattr(joint, key) and (key != "dilatancy_stress" or joint.dilatancy):
                yield f"'{key}' adds a joint resistance that is not proportional to the weights"


def _wrong_cases(scene: SceneKeys) -> Iterator[str]:
    """Generate an error message for each mistake in the load cases and the earthquake of a scene."""
    groups = {load.group for load in scene.loads} | {load.group for load in scene.edge_loads}
    known_groups = [*GROUPS, *sorted(name for name in groups if name is not None)]
    names: set[str] = set()
    for number, case in enumerate(scene.load_cases, start=1):
        label = f"load_case no. {number} ('{case.name}')"
        if case.name in names:
            yield f"{label}: another load case has the same name: rename one of the two load cases"
        names.add(case.name)
        yield from (f"{label}: {mistake}" for mistake in _wrong_groups(scene, case, known_groups))
    yield from _wrong_earthquakes(scene)
    if scene.tilt and (scene.load_cases or scene.earthquake):
        yield "'tilt' must be the only live load: remove 'tilt', or remove the load cases and the earthquake"
    if scene.earthquake and scene.load_cases:
        yield "a scene with load cases must have 'earthquake' in a [[load_case]]: move the earthquake there"
    for live in _live_loads(scene) if scene.earthquake else ():
        yield (
            f"'earthquake' must be the only live load, but {live} has a live load too: remove this load, "
            "or move the earthquake to a [[load_case]], which omits other live loads by default"
        )


def _wrong_groups(scene: SceneKeys, case: LoadCase, known_groups: list[str]) -> Iterator[str]:
    """Generate an error message for each load group that a load case names but the scene does not have."""
    for key in ("dead", "live"):
        unknown_groups = [group for group in getattr(case, key) if group not in known_groups]
        if unknown_groups:
            suggestion = (
                did_you_mean(unknown_groups[0], known_groups)
                or f"; the groups are: {', '.join(known_groups)}"
            )
            yield f"'{key}' names group '{unknown_groups[0]}', but no load has this group{suggestion}"
    if "axles" in case.live and scene.dimension == 3:
        yield "'live' names 'axles', which are only for scenes in the plane: remove them"


def _wrong_earthquakes(scene: SceneKeys) -> Iterator[str]:
    """Generate an error message for each wrong direction of an earthquake, in the scene or a load case."""
    earthquakes = [("'earthquake'", scene.earthquake)]
    for number, case in enumerate(scene.load_cases, start=1):
        earthquakes.append((f"load_case no. {number} ('{case.name}'): 'earthquake'", case.earthquake))
    for label, earthquake in earthquakes:
        mistake = None if earthquake is None else wrong_direction(scene, earthquake)
        if mistake:
            yield f"{label}: {mistake}"


def wrong_direction(scene: SceneKeys, quake: Earthquake) -> str | None:
    """Return the error message for a wrong direction of an earthquake, or None if the direction is valid."""
    if isinstance(quake.direction, str) == (scene.dimension == 3):
        return f"'direction' needs {_DIRECTION_FORMS[scene.dimension]}"
    if scene.sideways(quake.towards) is None:
        return "'direction' must not be parallel to gravity"
    return None


def _live_loads(scene: SceneKeys) -> Iterator[str]:
    """Iterate over the names of the live loads other than an earthquake."""
    for block in scene.blocks:
        if any(any(getattr(block, key, ())) for key in ("live", "live_per_weight", "live_moment")):
            yield f"block '{block.name}'"
    for number, load in enumerate(scene.loads, start=1):
        if load.has_force("live"):
            yield f"load no. {number}"
    for number, line in enumerate(scene.edge_loads, start=1):
        if line.kind == "live":
            yield f"edge_load no. {number}"
