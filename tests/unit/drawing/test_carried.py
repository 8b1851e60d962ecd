"""What joints carry, and where: by hand, in equilibrium with the loads, and as it is drawn."""

import numpy as np
import pytest
import shapely
from drawn import marks, solved
from scenes import CASES, WALLS, block_on_floor, on_a_corner

import masonry_opt as mo
from masonry_opt.drawing.carried import chains, thrust
from masonry_opt.drawing.colours import IDLE, UTILISATION
from masonry_opt.drawing.elements import result_elements
from masonry_opt.problem.assembly import assemble

ARCH = CASES / "casapulla_lauro" / "arch.toml"


@pytest.mark.parametrize("floor_first", [False, True])
def test_weight_and_push_meet_the_floor_below_their_resultant(floor_first):
    # A block of 4 × 2 and weight 3 slides at the push 0.5 × 3 to the right at its centroid, (2, 1). The
    # line of both runs through there at 1 : 2 and meets the floor at x = 2.5; the floor pushes back.
    scene = block_on_floor(4, 2, 0.5, weight=3.0, live=(3.0, 0.0))
    if floor_first:
        scene = scene.model_copy(update={"blocks": scene.blocks[::-1]})
    result = mo.solve(scene)
    resultant, point = thrust(result)
    on_block = -resultant if floor_first else resultant
    assert on_block == pytest.approx(np.array([[-1.5, 3.0]]), abs=1e-6)
    assert point == pytest.approx(np.array([[2.5, 0.0]]), abs=1e-6)


@pytest.mark.parametrize("scene", [ARCH, on_a_corner()], ids=["arch", "corner on an edge"])
def test_resultants_balance_the_loads_of_every_block(scene):
    """Forces and moments about the centroid, from the blocks as they are given."""
    result = mo.solve(scene)
    scene, joints = result.assembly.scene, result.assembly.joints
    resultant, point = thrust(result)
    # A joint that nothing presses together carries nothing in these scenes, without cohesion.
    acts = np.isfinite(point[:, 0])
    largest = np.abs(resultant).max()
    assert np.abs(resultant[~acts]).max(initial=0.0) < 1e-5 * largest
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
            forces += zip(sign * resultant[own], point[own], strict=True)
        force = sum(force for force, _ in forces)
        arms = [(force, at - centroid) for force, at in forces]
        moment = sum(arm[0] * force[1] - arm[1] * force[0] for force, arm in arms)
        assert [*force, moment] == pytest.approx([0.0] * 3, abs=1e-5 * largest)


def test_the_line_of_thrust_runs_through_an_arch_from_support_to_support():
    result = solved(ARCH)
    line = marks(result, "line", "thrust")
    assert line.shape == (27, 2, 2)
    points, times = np.unique(line.reshape(-1, 2).round(9), axis=0, return_counts=True)
    assert sorted(times) == [1, 1] + [2] * 26
    # Between intrados and extrados; voussoirs have straight edges.
    radius = np.hypot(*points.T)
    assert (radius > 9.45 - 1e-6).all()
    assert (radius < 10.55 + 1e-6).all()
    assert points[times == 1][:, 1] == pytest.approx([0, 0], abs=1e-9)
    # The resultants on supports say how large all are.
    assert len(marks(result, "resultants", "thrust")) == 2


def test_a_wall_has_no_chain_and_a_column_has_one():
    wall = assemble(mo.load(WALLS[0]))
    assert len(chains(wall, np.ones(wall.problem.joints, dtype=bool))) == 0
    column = assemble(mo.load(CASES / "closed_forms" / "dam_overturns.toml"))
    # The top lift has one joint; three lifts lie between two.
    assert len(chains(column, np.ones(column.problem.joints, dtype=bool))) == 3
    assert len(chains(column, np.zeros(column.problem.joints, dtype=bool))) == 0


def test_every_joint_has_the_colour_of_its_utilisation():
    result = solved(WALLS[0])
    used = result.joints["utilisation"].to_numpy()
    drawn = {each.colour: len(each.points) for each in result_elements(result).layers["utilisation"]}
    edges = np.linspace(0, 1, len(UTILISATION) + 1)
    edges[-1] = np.inf
    expected = np.histogram(used[~np.isnan(used)], edges)[0]
    assert [drawn.get(colour, 0) for colour in UTILISATION] == expected.tolist()
    assert drawn.get(IDLE, 0) == np.isnan(used).sum()
