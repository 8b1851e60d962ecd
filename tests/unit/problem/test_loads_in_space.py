"""Forces and moments on solids, by hand; those of extruded scenes, from the plane."""

from typing import NamedTuple

import numpy as np
import pytest
from scenes import CASES, irregular
from scenes_in_space import box_on_floor

import masonry_opt as mo
from masonry_opt.problem.loads import loads, weights
from masonry_opt.scene.geometry import geometry


class Shapes(NamedTuple):
    """Of boxes, or of what is extruded."""

    origin: np.ndarray
    centroid: np.ndarray
    size: np.ndarray


def of_boxes(scene):
    """Seen from an origin of no meaning."""
    corners = np.array([block.box for block in scene.in_space()])
    origin = np.array([0.3, -0.2, 0.7])
    return Shapes(origin, corners.mean(axis=2) - origin, np.prod(corners[..., 1] - corners[..., 0], axis=1))


def acting(scene, kind, shapes=None):
    """Rows fx, fy, fz, mx, my, mz of one kind on the first block, the only one that moves."""
    shapes, movable = shapes or of_boxes(scene), np.array([0])
    return getattr(loads(scene, shapes, movable), kind).about(shapes.centroid[movable])


# A box 1 × 2 × 3 has its centroid in (0.5, 1, 1.5).
BY_HAND = {
    "weight": ({"weight": None, "unit_weight": 5}, "weight", [0, 0, -30, 0, 0, 0]),
    # 30 down at an arm of (0.5, -1, 0): r × f = (30, 15, 0).
    "weight at an edge": ({"weight": 30, "weight_at": (1, 0, 1.5)}, "weight", [0, 0, -30, 30, 15, 0]),
    "force": ({"live": (1, 2, 3)}, "live", [1, 2, 3, 0, 0, 0]),
    # At the farthest corner, arm (0.5, 1, 1.5).
    "force through the centroid": ({"live": (1, 2, 3), "live_at": (1, 2, 3)}, "live", [1, 2, 3, 0, 0, 0]),
    # Arm (-0.5, -1, 1.5): r × (4, 0, 0) = (0, 1.5·4, 1·4).
    "force at a corner": ({"dead": (4, 0, 0), "dead_at": (0, 0, 3)}, "dead", [4, 0, 0, 0, 6, 4]),
    "moment": ({"live": (0, 0, 0), "live_moment": (1, -2, 3)}, "live", [0, 0, 0, 1, -2, 3]),
    "moment and force": (
        {"dead": (0, 4, 0), "dead_at": (0.5, 1, 3), "dead_moment": (7, 1, 0)},
        "dead",
        [0, 4, 0, 7 - 6, 1, 0],
    ),
    # Twice the weight of 30 along y at the arm of (0.5, -1, 0): r × (0, 60, 0) = (0, 0, 30).
    "multiple of the weight": (
        {"weight": 30, "weight_at": (1, 0, 1.5), "live": (0, 0, 0), "live_per_weight": (0, 2, 0)},
        "live",
        [0, 60, 0, 0, 0, 30],
    ),
    "nothing": ({"live": (0, 0, 0)}, "dead", [0, 0, 0, 0, 0, 0]),
}


@pytest.mark.parametrize("name", BY_HAND)
def test_forces_and_moments_on_a_box(name):
    keys, kind, expected = BY_HAND[name]
    assert acting(box_on_floor((1, 2, 3), **keys), kind) == pytest.approx(expected, abs=1e-14)


def test_loads_by_name_add_up_and_take_moments():
    """At the top's middle, arm (0, 0, 1.5): (0, 1.5·2, 0); at the centroid; a weight in place of its own."""
    scene = box_on_floor((1, 2, 3), live=(1, 0, 0), dead_moment=(0, 0, 1))
    more = [
        mo.Load(block="A", live=(2, 0, 0), at=(0.5, 1, 3)),
        mo.Load(block="A", live=(0, 1, 0), live_moment=(0, 0, 5), dead_moment=(0, 2, 0)),
        mo.Load(block="A", weight=7),
    ]
    scene = scene.model_copy(update={"loads": more})
    assert acting(scene, "live") == pytest.approx([3, 1, 0, 0, 3, 5])
    assert acting(scene, "dead") == pytest.approx([0, 0, 0, 0, 2, 1])
    assert acting(scene, "weight") == pytest.approx([0, 0, -7, 0, 0, 0])
    assert weights(scene, of_boxes(scene), np.array([0])).tolist() == [7]


def test_weights_act_along_gravity_and_tilt_square_to_it():
    """Of 10 along (0, -0.6, -0.8); towards -y up the slope: (0, -0.8, 0.6)."""
    scene = box_on_floor(weight=10, live=(0, 0, 0))
    scene = scene.model_copy(update={"gravity": (0.0, -3.0, -4.0), "tilt": (0.0, -5.0, 0.0)})
    assert acting(scene, "weight") == pytest.approx([0, -6, -8, 0, 0, 0])
    assert acting(scene, "live") == pytest.approx([0, -8, 6, 0, 0, 0])


@pytest.mark.parametrize(
    "plane",
    [
        irregular(),
        mo.load(CASES / "oppenheim" / "seven_voussoirs.toml"),
        mo.load(CASES / "goodman_bray" / "slope.toml"),
        mo.load(CASES / "beer_johnston" / "wedge_raises.toml"),
        mo.Scene(
            joints={"friction": 1},
            thickness=0.3,
            gravity=(1, -3),
            blocks=[
                mo.Block(
                    name="A",
                    vertices=[(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)],
                    unit_weight=4,
                    live_per_weight=(0.5, 0),
                    live=(1, 1),
                    live_at=(0, 3),
                    dead=(-1, 0),
                    dead_at=(2, 0),
                ),
                mo.Block(name="floor", vertices=[(0, 0), (3, 0), (3, -1)], fixed=True),
            ],
            loads=[mo.Load(block="A", live=(0, 3), dead=(1, 0), at=(1, 1))],
        ),
    ],
    ids=lambda scene: scene.title[:20],
)
@pytest.mark.parametrize("thickness", [None, 0.5])
def test_loads_of_an_extruded_scene_are_those_in_the_plane(plane, thickness):
    """The moment m of the plane, from x to y, is -m about the y of space."""
    space, flat = mo.extrude(plane, thickness), geometry(plane)
    depth = thickness or plane.thickness
    middle = np.full(len(flat.centroid), depth / 2)
    shapes = Shapes(
        np.array([flat.origin[0], 0, flat.origin[1]]),
        np.column_stack([flat.centroid[:, 0], middle, flat.centroid[:, 1]]),
        flat.size * depth,
    )
    movable = np.flatnonzero([not block.fixed for block in plane.blocks])
    for kind in ("weight", "dead", "live"):
        given = getattr(loads(plane, flat, movable), kind).about(flat.centroid[movable]).reshape(-1, 3)
        lifted = getattr(loads(space, shapes, movable), kind).about(shapes.centroid[movable]).reshape(-1, 6)
        expected = np.zeros_like(lifted)
        expected[:, [0, 2]], expected[:, 4] = given[:, :2], -given[:, 2]
        assert np.abs(lifted - expected).max() <= 1e-13 * max(np.abs(expected).max(), 1)
