"""Tests of ground that is tilted until blocks on it fall: a block rocks at atan(b / h), slides at atan(μ)."""

import json
import math

import pytest
from scenes import block_on_floor, small_wall, solved
from speeds import slow

import masonry_opt as mo


def block(width, height, friction, side, **keys):
    """Return a block of weight 7 on a floor that will be tilted."""
    return block_on_floor(width, height, friction, **({"weight": 7, "live": (0, 0)} | keys)).replace(
        tilt=side
    )


@pytest.mark.parametrize("method", ["static", "coulomb"])
@pytest.mark.parametrize("side", [*slow("left"), "right"])
@pytest.mark.parametrize(
    ("width", "height", "friction", "degrees"),
    [
        (1, 3, 0.6, math.degrees(math.atan(1 / 3))),
        (2, 2.5, 1.0, math.degrees(math.atan(0.8))),
        (1, 1, 0.6, math.degrees(math.atan(0.6))),
    ],
)
def test_a_block_rocks_or_slides_at_the_angle_known(width, height, friction, degrees, side, method):
    result = solved(block(width, height, friction, side), method)
    assert result.tilt_angle == pytest.approx(degrees, rel=1e-7)
    assert json.loads(result.to_json())["tilt_angle"] == result.tilt_angle
    # The block falls to the side to which the ground is tilted.
    assert math.copysign(1, result.blocks["vx"][0]) == (1 if side == "right" else -1)


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_weight_off_the_middle_tilts_with_its_block(side):
    """The weight acts 0.2 right of the middle and at height 0.5: λ is 0.3 / 0.5 to the right, 0.7 / 0.5 to
    the left."""
    scene = block(1, 2, 5.0, side, weight_at=(0.7, 0.5))
    expected = 0.3 / 0.5 if side == "right" else 0.7 / 0.5
    assert solved(scene, "static").load_factor == pytest.approx(expected, rel=1e-7)


def test_a_wall_tilts_as_under_its_weight_sideways():
    given = small_wall(4, 3)
    unloaded = [stone.model_copy(update={"live_per_weight": (0.0, 0.0)}) for stone in given.blocks]
    tilted = mo.Scene(joints=given.joints, blocks=unloaded, tilt="right")
    plain = solved(given, "static")
    assert solved(tilted, "static").load_factor == pytest.approx(plain.load_factor, rel=1e-9)
    assert plain.tilt_angle is None


@pytest.mark.parametrize(
    ("words", "keys"),
    [
        ("'cohesion'", {"joints": {"cohesion": 1.0}}),
        ("'strength'", {"joints": {"strength": 9.0}}),
        ("'cohesion'", {"exceptions": [{"between": ("A", "floor"), "cohesion": 1.0}]}),
        ("'dilatancy_stress'", {"joints": {"dilatancy": 0.1, "dilatancy_stress": (1.0, 2.0)}}),
        ("'edge_load'", {"edge_loads": [{"start": (0, 2), "end": (1, 2), "pressure": 1}]}),
        ("'tilt'", {"tilt": "up"}),
        ("'live'", {"blocks": {"A": {"live": (1.0, 0.0)}}}),
        ("'dead'", {"blocks": {"A": {"dead": (0.0, -1.0)}}}),
    ],
)
def test_what_does_not_grow_with_the_weights_is_refused(words, keys):
    with pytest.raises(mo.CaseError, match=words):
        block(1, 2, 0.5, "right").replace(**keys)
