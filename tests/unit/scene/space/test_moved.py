"""The joints of a scene in space do not depend on how it lies, is numbered, measured or drawn."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from touching_solids import box, contacts_of, hull, in_triangles, joints, moved, parted, scene

#: Square prisms turned on each other, solids of parts, a wedge on its edge, a cone on its tip, a crossing.
TURNED = [(0.7, 0, 0), (0, 0.7, 0), (-0.7, 0, 0), (0, -0.7, 0)]
SCENE = scene(
    parted("L", ((0, 3), (0, 1), (0, 1)), ((0, 1), (1, 3), (0, 1))),
    box("in its corner", (1, 2.2), (1, 2.5), (0, 1)),
    hull("turned", [(x + 0.6, y + 1.8, z) for x, y, _ in TURNED for z in (1, 2.1)]),
    parted("ring", *((x, y, (0, 0.5)) for x, y in [((4, 8), (0, 1)), ((7, 8), (1, 4)), ((4, 7), (3, 4))])),
    hull("wedge", [(5, 2.5, 0), (6, 1.5, 0), *((5.5 + x, 2 + y, 0.8) for x, y, _ in TURNED)]),
    hull("cone", [(2.1, 0.4, 1), (1.8, 0, 2), (2.5, 0.1, 2), (2, 0.9, 2)]),
    hull("ridge", [(x, y, z) for x in (-4, -2) for y, z in ((-1, 0), (0, 1), (1, 0))]),
    hull("across", [(-3 + x, y, z) for y in (-1, 1) for x, z in ((-1, 2), (0, 1), (1, 2))]),
    box("floor", (-5, 9), (-5, 5), (-1, 0), fixed=True),
)


ANY = Rotation.random(random_state=7).as_matrix()
UNTURNED = np.eye(3)
MIRROR = np.diag([1.0, -1.0, 1.0])


def seen_back(blocks, matrix=UNTURNED, shift=(0, 0, 0)):
    """Joints in order of names and places, as they were before corners were multiplied by a matrix and
    shifted: names, area, normal into the one whose name is less, and contact points."""
    scale = abs(np.linalg.det(matrix)) ** (1 / 3)
    found = []
    for pair, area, normal, points in joints(blocks):
        into_less = normal if pair[0] < pair[1] else -normal
        points = np.round((points - shift) @ np.linalg.inv(matrix).T, 6) + 0.0
        places = sorted(map(tuple, points.tolist()))
        found.append((tuple(sorted(pair)), places, area / scale**2, into_less @ matrix / scale))
    return sorted(found, key=lambda joint: joint[:2])


def assert_same(found, expected):
    assert [joint[:2] for joint in found] == [joint[:2] for joint in expected]
    for (*_, area, normal), (*_, as_before, before) in zip(found, expected, strict=True):
        assert area == pytest.approx(as_before, rel=1e-9)
        assert normal == pytest.approx(before, abs=1e-9)


EXPECTED = seen_back(SCENE)


def test_the_scene_has_joints_of_every_kind():
    kinds = [(*pair, len(places), area > 0) for pair, places, area, _ in EXPECTED]
    assert kinds == [
        ("L", "cone", 1, False),
        ("L", "floor", 6, True),
        ("L", "in its corner", 4, True),
        ("L", "in its corner", 4, True),
        ("L", "turned", 6, True),
        ("across", "ridge", 1, False),
        ("floor", "in its corner", 4, True),
        ("floor", "ridge", 4, True),
        ("floor", "ring", 8, True),
        ("floor", "wedge", 2, False),
        ("in its corner", "turned", 3, True),
    ]


@pytest.mark.parametrize(
    ("matrix", "shift"),
    [
        (ANY, (0, 0, 0)),
        (MIRROR, (0, 0, 0)),
        (ANY @ MIRROR, (1, 2, 3)),
        (1e3 * np.eye(3), (0, 0, 0)),
        (1e-3 * ANY, (0, 0, 0)),
        (np.eye(3), (1e4, -1e4, 1e4)),
    ],
)
def test_joints_turn_with_the_scene(matrix, shift):
    assert_same(seen_back(moved(SCENE, matrix, shift), matrix, shift), EXPECTED)


def test_tangents_and_the_order_of_contact_points_turn_with_the_scene():
    one, other = contacts_of(SCENE), contacts_of(moved(SCENE, ANY))
    frame = np.stack([one.normal, one.tangent, np.cross(one.normal, one.tangent)], axis=1)
    np.testing.assert_allclose(
        frame @ np.moveaxis(frame, 1, 2), np.tile(np.eye(3), (len(frame), 1, 1)), atol=1e-12
    )
    np.testing.assert_allclose(one.tangent @ ANY.T, other.tangent, atol=1e-9)
    # Seen from the first corner: the middle of the scene is another point of it.
    np.testing.assert_allclose((one.point - one.point[0]) @ ANY.T, other.point - other.point[0], atol=1e-9)


@pytest.mark.parametrize("matrix", [np.eye(3), ANY])
def test_joints_do_not_depend_on_numbers_or_on_faces_in_triangles(matrix):
    blocks = moved(SCENE, matrix)
    renumbered = blocks.model_copy(update={"blocks": blocks.blocks[::-1]})
    assert_same(seen_back(renumbered, matrix), EXPECTED)
    assert_same(seen_back(in_triangles(blocks), matrix), EXPECTED)
