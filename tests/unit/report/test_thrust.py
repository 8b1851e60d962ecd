"""Where joints carry what: by hand, and in equilibrium with the loads."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from scenes import CASES, block_on_floor, on_a_corner, overhanging

import masonry_opt as mo
from masonry_opt.report.thrust import thrust


@pytest.mark.parametrize("floor_first", [False, True])
def test_weight_and_push_meet_the_floor_below_their_resultant(floor_first):
    # A block of 4 × 2 and weight 3 slides at the push 0.5 × 3 to the right at its centroid, (2, 1). The
    # line of both runs through there at 1 : 2 and meets the floor at x = 2.5; the floor pushes back.
    scene = block_on_floor(4, 2, 0.5, weight=3.0, live=(3.0, 0.0))
    if floor_first:
        scene = scene.model_copy(update={"blocks": scene.blocks[::-1]})
    result = mo.solve(scene)
    carried = thrust(result)
    on_block = -carried.force if floor_first else carried.force
    assert on_block == pytest.approx(np.array([[-1.5, 3.0]]), abs=1e-6)
    assert carried.point == pytest.approx(np.array([[2.5, 0.0]]), abs=1e-6)


@pytest.mark.parametrize(
    "scene", [CASES / "casapulla_lauro" / "arch.toml", on_a_corner()], ids=["arch", "corner on an edge"]
)
def test_resultants_balance_the_loads_of_every_block(scene):
    """Forces and moments about the centroid, from the blocks as they are given."""
    result = mo.solve(scene)
    scene, joints = result.assembly.scene, result.assembly.joints
    carried = thrust(result)
    # A joint that nothing presses together carries nothing in these scenes, without cohesion.
    acts = np.isfinite(carried.point[:, 0])
    largest = np.abs(carried.force).max()
    assert np.abs(carried.force[~acts]).max(initial=0.0) < 1e-5 * largest
    for index in result.assembly.movable:
        block = scene.blocks[index]
        polygon = shapely.Polygon(block.vertices)
        centroid = np.array(polygon.centroid.coords[0])
        weight = np.array([0.0, -block.weight_of(polygon.area * scene.thickness)])
        live = result.load_factor * np.array(block.live)
        of_weight = weight + result.load_factor * -weight[1] * np.array(block.live_per_weight)
        points = [np.array(at or centroid) for at in (block.weight_at, block.live_at)]
        forces = [*zip((of_weight, live), points, strict=True)]
        for side, sign in ((joints.first, 1.0), (joints.second, -1.0)):
            own = acts & (side == index)
            forces += zip(sign * carried.force[own], carried.point[own], strict=True)
        force = sum(force for force, _ in forces)
        arms = [(force, at - centroid) for force, at in forces]
        moment = sum(arm[0] * force[1] - arm[1] * force[0] for force, arm in arms)
        assert [*force, moment] == pytest.approx([0.0] * 3, abs=1e-5 * largest)


def test_without_forces_nothing_acts():
    carried = thrust(mo.solve(overhanging()))
    assert np.isnan(carried.force).all()
    assert np.isnan(carried.point).all()
