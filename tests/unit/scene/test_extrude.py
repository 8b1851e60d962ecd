"""Scenes in the plane are extruded into space with their shapes and properties, or refused."""

import pytest
import shapely
from mappings import mapped
from scenes import CASES, block_on_floor, irregular, small_wall, two_blocks
from scenes_in_space import volume

import masonry_opt as mo
from masonry_opt.scene.geometry import geometry

FLOOR = mo.Block(name="floor", vertices=[(-9, -1), (9, -1), (9, 0), (-9, 0)], fixed=True)
SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]


def on_floor(*blocks, joints=None, **keys):
    return mo.Scene(joints=joints or {"friction": 0.5}, blocks=[*blocks, FLOOR], **keys)


def stone(**keys):
    return on_floor(mo.Block(**{"name": "A", "weight": 1} | keys))


SCENES = {
    "wall": small_wall(3, 2),
    "no two edges alike": irregular(),
    "clockwise": stone(vertices=SQUARE[::-1]),
    "notched": stone(vertices=L_SHAPE),
    "notched and clockwise": stone(vertices=L_SHAPE[::-1]),
    "parts that overlap": stone(parts=[SQUARE, [(0.5, 0.5), (3, 0.5), (3, 2), (0.5, 2)]]),
    "parts apart": stone(parts=[SQUARE, [(3, 0), (4, 0), (3, 2)]]),
    "hole": stone(vertices=[(0, 0), (3, 0), (3, 3), (0, 3)], holes=[[(1, 1), (2, 1), (1.5, 2)]]),
    "straight corners": stone(vertices=[(0, 0), (0.5, 0), *SQUARE[1:]]),
    "arch": mo.load(CASES / "oppenheim" / "seven_voussoirs.toml"),
    "far away": mapped(stone(vertices=L_SHAPE), lambda v: (1e4 + v[0], v[1] - 1e4)),
}


@pytest.mark.parametrize("thickness", [None, 0.7])
@pytest.mark.parametrize("name", SCENES)
def test_solids_are_the_polygons_with_a_thickness(name, thickness):
    plane = SCENES[name]
    space, shapes = mo.extrude(plane, thickness), geometry(plane)
    depth = thickness or plane.thickness
    assert [block.name for block in space.blocks] == [block.name for block in plane.blocks]
    for index, block in enumerate(space.in_space()):
        parts, flat = block.polyhedra, shapely.transform(shapes.polygons[index], lambda p: p + shapes.origin)
        # The projection along y is the shape of all cuts across y.
        drawn = [shapely.MultiPoint(part.vertices[:, [0, 2]]).convex_hull for part in parts]
        assert shapely.union_all(drawn).symmetric_difference(flat).area <= 1e-9 * flat.area
        # Parts do not overlap. They are convex with outward normals: the volume of each is the area of its
        # outline times the depth.
        assert sum(polygon.area for polygon in drawn) == pytest.approx(flat.area, rel=1e-9)
        for part, polygon in zip(parts, drawn, strict=True):
            assert volume(part) == pytest.approx(polygon.area * depth, rel=1e-9)
            assert set(part.vertices[:, 1]) == {0.0, depth}
        assert block.fixed == plane.blocks[index].fixed


def test_properties_of_joints_are_kept_and_cohesion_in_total():
    """The total cohesion of a joint is preserved: 0.8 per unit of area in a scene 0.5 thick becomes 0.8 × 0.5
    / 0.2 in solids 0.2 thick. Weights and loads are covered by the tests of loads in space."""
    plane = on_floor(
        mo.Block(name="A", vertices=L_SHAPE, unit_weight=6, live=(1, 0.5)),
        mo.Block(name="B", vertices=[(0, 3), (1, 3), (1, 4)], weight=2),
        joints={"friction": 0.6, "cohesion": 0.8, "dilatancy": 0.1},
        thickness=0.5,
        gravity=(1, -2),
        tolerance=1e-5,
        exceptions=[
            {"between": ("A", "floor"), "friction": float("inf")},
            {"between": ("B", "A"), "cohesion": 0.1, "dilatancy": 0.2},
        ],
        title="a stone",
        source="by hand",
        reference={"associative": {"value": 1, "source": "none"}},
    )
    space = mo.extrude(plane, 0.2)
    assert space.in_space()[0].weight == 6 * 4 * 0.5
    assert space.gravity == (1, 0, -2)
    assert space.joints == mo.JointDefaults(friction=0.6, cohesion=2.0, dilatancy=0.1)
    weak = mo.Joint(between=("B", "A"), cohesion=0.25, dilatancy=0.2)
    assert space.exceptions == [plane.exceptions[0], weak]
    assert (space.title, space.source, space.tolerance) == ("a stone", "by hand", 1e-5)
    assert (space.thickness, space.reference) == (1, {})
    # By default, the solids are as thick as the scene, and all properties stay the same.
    as_thick = mo.extrude(plane)
    assert as_thick.joints.cohesion == 0.8
    assert as_thick.in_space()[0].corners()[:, 1].max() == 0.5


@pytest.mark.parametrize(("side", "expected"), [("right", (0.8, 0, 0.6)), ("left", (-0.8, 0, -0.6))])
def test_a_tilt_is_to_the_side_it_was(side, expected):
    """The direction of the tilt is at a right angle to gravity, (0.6, -0.8), on the same side as in the
    plane."""
    plane = block_on_floor(live=(0, 0)).model_copy(update={"tilt": side, "gravity": (3.0, -4.0)})
    space = mo.extrude(plane, 3)
    assert space.tilt_direction == pytest.approx(expected, rel=1e-14)
    assert space.tilt_direction[[0, 2]] == pytest.approx(plane.tilt_direction, rel=1e-14)


def test_a_scene_is_taken_by_its_path_and_written_in_space(tmp_path):
    path = CASES / "gilbert" / "two_blocks.toml"
    space = mo.extrude(path, 2)
    assert space.origin == str(path)
    assert space == mo.extrude(mo.load(path), 2)
    mo.save(space, tmp_path / "space.toml")
    assert mo.load(tmp_path / "space.toml") == space


@pytest.mark.parametrize("thickness", [0, -1, float("nan"), float("inf"), "1", True])
def test_a_thickness_is_a_positive_number(thickness):
    with pytest.raises(mo.OptionError, match="'thickness'"):
        mo.extrude(two_blocks(), thickness)


def test_what_belongs_in_the_plane_is_in_space_or_no_shape_is_refused():
    """Edge loads, scenes in space and outlines that cross themselves cannot be extruded. The tests of solids
    cover all other keys that only scenes in the plane have."""
    load = mo.EdgeLoad(start=(0, 2), end=(1, 2), pressure=1)
    with pytest.raises(mo.OptionError, match="'edge_load'"):
        mo.extrude(block_on_floor().replace(edge_loads=[load]))
    with pytest.raises(mo.OptionError):
        mo.extrude(mo.extrude(two_blocks()))
    crossed = mo.Block(name="crossed", vertices=[(0, 0), (1, 1), (1, 0), (0, 1.5)], weight=1)
    with pytest.raises(mo.CaseError, match="'crossed'"):
        mo.extrude(on_floor(crossed))
