"""Joints in space against those that another program finds: cells of Voronoi diagrams, and plane scenes."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull, Voronoi
from scipy.spatial.transform import Rotation
from touching_solids import contacts_of, hull, moved, scene

import masonry_opt as mo
from masonry_opt.scene.contacts.find import find_joints
from masonry_opt.scene.geometry import geometry


def cells(count, seed):
    """Cells of random points in a unit cube, one of them fixed, and of each two that share a face its area
    and number of corners. Points mirrored at its sides bound the cells."""
    points = np.random.default_rng(seed).random((count, 3))
    mirrored = [
        np.where(np.arange(3) == axis, 2 * side - points, points) for axis in range(3) for side in (0, 1)
    ]
    diagram = Voronoi(np.concatenate([points, *mirrored]))
    corners = [diagram.vertices[diagram.regions[diagram.point_region[number]]] for number in range(count)]
    blocks = [hull(f"{number}", own, fixed=number == 0) for number, own in enumerate(corners)]
    faces = {}
    for pair, face in zip(diagram.ridge_points.tolist(), diagram.ridge_vertices, strict=True):
        if max(pair) < count:
            own, normal = diagram.vertices[face], points[pair[1]] - points[pair[0]]
            # Seen along a coordinate axis it is smaller by that component of the normal.
            axis = int(np.abs(normal).argmax())
            seen = ConvexHull(np.delete(own, axis, axis=1)).volume
            area = seen * np.linalg.norm(normal) / abs(normal[axis])
            faces[min(pair), max(pair)] = area, len(face)
    return scene(*blocks), faces


@pytest.mark.parametrize("seed", [1])
@pytest.mark.parametrize("turned", [False, True])
def test_cells_of_a_voronoi_diagram_share_its_faces(seed, turned):
    blocks, faces = cells(100, seed)
    found = contacts_of(moved(blocks, Rotation.random(random_state=seed).as_matrix()) if turned else blocks)
    tolerance = 3e-6
    shared = {(i, j): a for i, j, a in zip(found.first, found.second, found.extent, strict=True)}
    corners = dict(zip(shared, np.bincount(found.joint), strict=True))
    assert len(shared) == len(found.first)  # one joint a pair
    assert shared.keys() <= faces.keys()
    # What is missing is narrower than ten tolerances; corners nearer than a tolerance are one.
    assert all(faces[pair][0] < 10 * tolerance for pair in faces.keys() - shared.keys())
    for pair, area in shared.items():
        assert area == pytest.approx(faces[pair][0], abs=tolerance)
    assert np.mean([corners[pair] == faces[pair][1] for pair in shared]) > 0.97
    assert (found.gaps, found.without_normal) == ({}, [])


@pytest.mark.parametrize(
    "case",
    [
        "casapulla_lauro/arch",
        "examples/segmental_arch_on_columns",
        "ferris_tinloi/wall_6",
        "gilbert/wedge_blocks",
        "paterson_zwick/diamond_4",
    ],
)
@pytest.mark.parametrize("turned", [False, True])
def test_a_plane_scene_extruded_has_its_joints_as_polygons(case, turned):
    plane = mo.load(f"cases/{case}.toml")
    joints = find_joints(plane, geometry(plane))
    solid = mo.extrude(plane, 0.7)
    found = contacts_of(moved(solid, Rotation.random(random_state=4).as_matrix()) if turned else solid)
    expected = sorted(zip(joints.first, joints.second, joints.extent * 0.7, strict=True))
    shared = sorted(zip(found.first, found.second, found.extent, strict=True))
    np.testing.assert_allclose(shared, expected, rtol=1e-6)
    np.testing.assert_array_equal(np.bincount(found.joint), 4)


def test_a_corner_on_an_edge_in_the_plane_is_an_edge_on_a_face_in_space():
    floor = mo.Block(name="floor", vertices=[(-9, -1), (9, -1), (9, 0), (-9, 0)], fixed=True)
    wedge = mo.Block(name="A", vertices=[(1, 0), (2, 1), (0, 1)], weight=1)
    plane = mo.Scene(joints=mo.JointDefaults(friction=0.5), blocks=[wedge, floor])
    assert find_joints(plane, geometry(plane)).extent == pytest.approx([0])
    found = contacts_of(mo.extrude(plane, 2.0))
    assert found.extent == pytest.approx([0])
    assert np.ptp(found.point, axis=0) == pytest.approx([0, 2, 0])
