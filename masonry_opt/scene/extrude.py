"""Extrude scenes in the plane to scenes in space."""

import math
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import shapely

from masonry_opt.errors import OptionError
from masonry_opt.scene.blocks import Block, Point, Record
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.geometry import Geometry, geometry
from masonry_opt.scene.joints import Joint, JointDefaults
from masonry_opt.scene.keys import of_plane_alone
from masonry_opt.scene.loads import Earthquake
from masonry_opt.scene.outlines import convex_pieces
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import Solid, prism

_J = TypeVar("_J", Joint, JointDefaults)
#: Keys of a scene whose records contain forces and points.
_FORCES = ("loads", "ties", "props")


def extrude(scene: Scene | str | Path, thickness: float | None = None) -> Scene:
    """Extrude a scene in the plane to a scene of solids.

    A point (x, y) of the plane becomes the points (x, t, y), with t from 0 to the thickness. The total
    weights, loads and cohesion of the joints do not depend on the thickness. Forces act at half the
    thickness. Friction, dilatancy, exceptions, gravity, tilt and tolerances do not change. Published values
    are left out, because they refer to the scene in the plane. Blocks with notches, parts or holes become
    solids of several convex parts.

    Parameters
    ----------
    scene: A scene in the plane, or the path of its case file.
    thickness: Thickness of the solids. The default is the thickness of the scene, with which unit weights and
        cohesion do not change.

    Returns
    -------
    Scene
        The scene in space.

    Raises
    ------
    CaseError
        If a block's polygon is wrong.
    OptionError
        If the thickness is not a positive number, if the scene is already in space, or if it has keys that
        exist only in the plane: edge loads, ``strength``, ``dilatancy_stress``.
    """
    scene = as_scene(scene)
    depth = scene.thickness if thickness is None else thickness
    if isinstance(depth, bool) or not isinstance(depth, int | float) or not 0 < depth < math.inf:
        raise OptionError(f"'thickness' of solids must be a positive number (found {depth!r})")
    blocks, shapes = scene.in_plane(), geometry(scene)
    for mistake in of_plane_alone(scene):
        raise OptionError(f"{scene.origin}: {mistake}")
    cohesion = scene.thickness / depth
    sideways = scene.tilt_direction
    solid = Scene(
        title=scene.title,
        source=scene.source,
        gravity=_in_space(scene.gravity),
        tolerance=scene.tolerance,
        contact_tolerance=scene.contact_tolerance,
        tilt=None if sideways is None else _in_space(sideways.tolist()),
        joints=_scaled_joint(scene.joints, cohesion),
        blocks=[_solid(block, shapes, index, scene.thickness, depth) for index, block in enumerate(blocks)],
        exceptions=[_scaled_joint(joint, cohesion) for joint in scene.exceptions],
        **{
            name: [type(record)(**_keys_in_space(record, depth)) for record in getattr(scene, name)]
            for name in _FORCES
        },
        load_cases=[
            case.replace(earthquake=_quake_in_space(scene, case.earthquake)) for case in scene.load_cases
        ],
        earthquake=_quake_in_space(scene, scene.earthquake),
    ).read_from(scene.origin)
    case = scene.load_case
    return solid.in_case(case.name) if case else solid


def _quake_in_space(scene: Scene, quake: Earthquake | None) -> Earthquake | None:
    """Return an earthquake with its direction converted from the plane to space."""
    if quake is None:
        return None
    sideways = scene.sideways(quake.towards)
    if sideways is None:
        return None
    return quake.replace(direction=_in_space(sideways.tolist()))


def _in_space(vector: Any, at: float = 0.0) -> Any:
    """Convert a plane vector (x, y), or each vector of a tuple, to the vector (x, ``at``, y) in space."""
    if isinstance(vector[0], tuple):
        return tuple(_in_space(part, at) for part in vector)
    return (vector[0], at, vector[1])


def _scaled_joint(joint: _J, factor: float) -> _J:
    """Return the properties of a joint with its cohesion multiplied by a factor."""
    return joint.replace(cohesion=joint.cohesion * factor) if joint.cohesion else joint


def _keys_in_space(record: Record, depth: float) -> dict[str, Any]:
    """Return the values that are set in a record, by key, with vectors converted from the plane to space.

    The coordinate y is 0 for forces, and half the depth for points.
    """
    keys = {key: getattr(record, key) for key in record.model_fields_set}
    for key, value in keys.items():
        if value is not None and key in (*Block.LOADS, "at", "weight_at", "live_at", "dead_at"):
            keys[key] = _in_space(value, 0.0 if key in Block.LOADS else depth / 2)
    return keys


def _solid(block: Block, shapes: Geometry, index: int, thickness: float, depth: float) -> Solid:
    """Return a block of the plane as a solid of a given depth."""
    keys = _keys_in_space(block, depth)
    if block.weight is not None or block.unit_weight is not None:
        keys["weight"] = block.weight_of(float(shapes.size[index]) * thickness)
    for key in ("unit_weight", "vertices", "parts", "holes"):
        keys.pop(key, None)
    parts = [_prism(ring, depth) for ring in _rings(block, shapes, index)]
    return Solid(**keys, **(parts[0] if len(parts) == 1 else {"parts": parts}))


def _rings(block: Block, shapes: Geometry, index: int) -> list[list[Point]]:
    """Return the rings of a block's convex pieces: corners in the scene's coordinates, counter-clockwise."""
    polygon, origin = shapes.polygons[index], shapes.origin
    outline = [shapely.get_coordinates(polygon)[:-1]]
    pieces = outline if shapes.convex[index] else convex_pieces(polygon, shapes.tolerance)
    # Take corners from the scene, because its coordinates have no rounding errors. The scene does not contain
    # the points at which outlines of parts or holes cross. Compute these crossing points.
    corners = np.array([point for ring in [*block.rings, *block.holes] for point in ring], dtype=float)
    corner_at = dict(zip(map(tuple, corners - origin), map(tuple, corners.tolist()), strict=True))
    return [
        [corner_at.get(tuple(corner)) or tuple((corner + origin).tolist()) for corner in piece]
        for piece in pieces
    ]


def _prism(ring: list[Point], depth: float) -> dict[str, Any]:
    """Return the prism over a counter-clockwise convex polygon, from y = 0 to a given depth."""
    x, y = ({point[axis] for point in ring} for axis in (0, 1))
    if len(ring) == 4 and len(x) == len(y) == 2:
        return {"box": (tuple(sorted(x)), (0.0, depth), tuple(sorted(y)))}
    return prism(*([_in_space(point, at) for point in ring] for at in (0.0, depth)))
