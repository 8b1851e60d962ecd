"""Marks of loads and of joints, by their motion and forces, are compared with values by hand and with
equilibrium."""

import numpy as np
import pytest
from atlas.small_scenes import rectangle
from drawn import arrows, elements_of, labels, marks, solved
from scenes import CASES, WALLS, block_on_floor, forces_of, on_a_corner, overhanging
from speeds import slow

import masonry_opt as mo
from masonry_opt.drawing.colours import IDLE_COLOUR, UTILISATION
from masonry_opt.drawing.elements import FULL_MOTION, counts, result_elements
from masonry_opt.drawing.forces import chains, thrust
from masonry_opt.drawing.marks import moved
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.motion import joint_motion
from masonry_opt.solution.reasons import Code

ARCH = CASES / "casapulla_lauro" / "arch.toml"


def test_a_face_that_separates_does_not_slide():
    """A block is pushed away from a wall: it slides on the floor and separates from the wall."""
    scene = block_on_floor(4, 2, 0.5)
    result = mo.solve(scene.replace(blocks=[*scene.blocks, rectangle("wall", -1, 0, 0, 3)]))
    motion = joint_motion(result.assembly, result.solution)
    on = {second: number for number, second in enumerate(result.joints["second"])}
    assert motion.slides.tolist() == [number == on["floor"] for number in range(2)]
    assert motion.separates.tolist() == [number == on["wall"] for number in range(2)]
    (face,), (bed,) = marks(result, "separates"), marks(result, "slides")
    # The mark is midway between the wall, at rest, and the block, moved to the right by 6 % of its width.
    assert face == pytest.approx(np.array([[0.12, 2], [0.12, 0]]))
    assert bed == pytest.approx(np.array([[0.12, 0], [4.12, 0]]))
    assert {"sliding joint", "separating joint"} <= set(labels(result))
    assert not {"hinging joint", "crushing joint"} & set(labels(result))


def test_an_arch_has_four_hinges():
    result = solved(ARCH)
    hinges = marks(result, "hinges")[:, 0]
    assert len(hinges) == 4
    # The hinge on the support does not move. It is at the extrados, 10.55 from the middle of the arch.
    assert hinges[np.argmin(hinges[:, 1])] == pytest.approx([10.55, 0], abs=1e-6)
    assert not len(marks(result, "slides"))
    assert "sliding joint" not in labels(result)


def test_a_toe_that_crushes_is_crossed():
    result = mo.solve(block_on_floor(1, 2, 0.8).replace(strength=4.0), "static")
    assert len(marks(result, "crushes")) == len(marks(result, "crosses")) == 1
    assert not len(marks(result, "slides"))
    assert "crushing joint" in labels(result)


def test_the_fastest_corner_moves_by_a_tenth_and_stays_in_the_picture():
    # A block of 1 × 2 overturns about its toe (1, 0). Its fastest corner is (0, 2), the farthest from the
    # toe.
    elements = result_elements(mo.solve(block_on_floor(1, 2, 0.8)))
    corners = np.array([[0, 2], [0, 0], [1, 0], [1, 2]]) - elements.assembly.geometry.origin
    after = moved(corners, elements.motion[0])
    assert after[0] - corners[0] == pytest.approx(FULL_MOTION * 2 * np.array([2, 1]) / np.sqrt(5))
    assert after[2] == pytest.approx(corners[2])
    low, high = elements.box([], 1.0)
    assert ((after > low) & (after < high)).all()


def motion_of(result):
    return joint_motion(result.assembly, result.solution)


@pytest.mark.slow
def test_a_block_that_turns_about_an_edge_hinges_whatever_presses_there():
    """In a pile of diamonds, some blocks rotate about a corner of a neighbour at rest without pressing on it,
    and another block separates. The scene has many mechanisms: one has three blocks that rotate in this way,
    another one two."""
    result = mo.solve(CASES / "paterson_zwick" / "diamond_4.toml")
    motion, joints = motion_of(result), result.joints
    farther = (joints["opening"] + joints["rotation"].abs() * joints["length"] / 2).to_numpy()
    nearer = (joints["opening"] - joints["rotation"].abs() * joints["length"] / 2).to_numpy()
    stays = (np.abs(nearer) < 1e-6) & (joints["slip"].abs().to_numpy() < 1e-6) & (farther > 0.1)
    idle = joints["n"].abs().to_numpy() < 1e-9
    assert (stays & idle).sum() >= 2
    assert motion.hinges[stays].all()
    assert not motion.separates[stays].any()
    assert motion.separates.any()


def test_what_opens_and_slips_and_carries_nothing_separates():
    """A keystone is pulled out. An edge of a joint stays in contact but presses on nothing, so the joint
    separates."""
    result = mo.solve(CASES / "closed_forms" / "keystone.toml")
    motion = motion_of(result)
    idle = result.joints["n"].abs().to_numpy() < 1e-9
    opens = result.joints["opening"].to_numpy() > 0.01
    assert (idle & opens).any()
    assert motion.separates[idle & opens].all()


def extruded_and_rough(scene):
    """Return an extruded scene without sliding contact points, and therefore without cones."""
    return mo.extrude(scene.replace(friction=np.inf))


@pytest.mark.parametrize("shaped", [lambda scene: scene, mo.extrude, extruded_and_rough])
@pytest.mark.parametrize("beyond", [1.0, *slow(1e-3), 1e-5])
def test_a_block_that_falls_off_an_edge_turns_about_it(beyond, shaped):
    """By hand: the centroid of a block of 3 by 1 is 0.5 above an edge and a beyond it. The block starts to
    rotate like a pendulum, while friction holds the edge. Its rotation is a / ((3² + 1²) / 12 + a² + 0.5²) of
    gravity (0.48 for a = 1)."""
    result = mo.solve(shaped(overhanging(beyond)))
    assert [reason.code for reason in result.reasons] == [Code.FALLS, Code.NO_FRICTION_HOLDS]
    motion, block = motion_of(result), result.blocks.iloc[0]
    speed = beyond / (10 / 12 + beyond**2 + 0.25)
    # In space, a rotation from x to z is about -y.
    up, turns, sense = ("vy", "omega", -1) if result.contacts is None else ("vz", "wy", 1)
    assert block[turns] == pytest.approx(sense * speed, rel=1e-4)
    assert block[["vx", up]].to_numpy(float) == pytest.approx([0.5 * speed, -beyond * speed], rel=1e-4)
    assert (motion.hinges[0], motion.slides[0], motion.separates[0]) == (True, False, False)
    hinge = motion.hinge[0] + result.assembly.geometry.origin
    assert hinge[[0, -1]] == pytest.approx([1.5 - beyond, 0])


def test_a_block_that_slides_off_keeps_its_friction():
    """A block is on a slope of 1 in 2 with friction 0.2, under associative flow. Its speed is the component
    of gravity along the direction in which it slides and lifts off."""
    block = mo.Block(name="A", vertices=[(0, 0), (2, 1), (1, 3), (-1, 2)], weight=1, live=(1, 0))
    ground = mo.Block(name="ground", vertices=[(-4, -2), (6, 3), (6, -3)], fixed=True)
    result = mo.solve(mo.Scene(joints={"friction": 0.2}, blocks=[block, ground]))
    motion = motion_of(result)
    slope, friction_angle = np.arctan(0.5), np.arctan(0.2)
    speed = np.hypot(result.blocks["vx"][0], result.blocks["vy"][0])
    assert speed == pytest.approx(np.sin(slope - friction_angle), rel=1e-6)
    assert (motion.slides[0], motion.hinges[0], motion.separates[0]) == (True, False, False)


@pytest.mark.parametrize("floor_first", [False, True])
def test_weight_and_push_meet_the_floor_below_their_resultant(floor_first):
    # A block of 4 × 2 and weight 3 slides under a push of 0.5 × 3 to the right at its centroid, (2, 1). The
    # resultant of both has the slope 1 : 2 and meets the floor at x = 2.5, where the floor reacts.
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
    """The resultants balance the forces, and the moments about the centroid, of all blocks."""
    result = mo.solve(scene)
    assembly, joints = result.assembly, result.assembly.joints
    resultant, point = thrust(result)
    # In these scenes without cohesion, a joint without compression carries no force.
    acts = np.isfinite(point[:, 0])
    largest = np.abs(resultant).max()
    assert np.abs(resultant[~acts]).max(initial=0.0) < 1e-5 * largest
    left = forces_of(assembly, "dead") + result.load_factor * forces_of(assembly, "live")
    for row, index in enumerate(assembly.movable):
        for side, sign in ((joints.first, 1.0), (joints.second, -1.0)):
            own = acts & (side == index)
            force = sign * resultant[own]
            arm = point[own] - assembly.geometry.centroid[index] - assembly.geometry.origin
            left[row] += [*force.sum(axis=0), (arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]).sum()]
    assert np.abs(left).max() < 1e-5 * largest


def test_the_line_of_thrust_runs_through_an_arch_from_support_to_support():
    result = solved(ARCH)
    line = marks(result, "line", "thrust")
    assert line.shape == (27, 2, 2)
    points, times = np.unique(line.reshape(-1, 2).round(9), axis=0, return_counts=True)
    assert sorted(times) == [1, 1] + [2] * 26
    # The points are between intrados and extrados. Voussoirs have straight edges.
    radius = np.hypot(*points.T)
    assert (radius > 9.45 - 1e-6).all()
    assert (radius < 10.55 + 1e-6).all()
    assert points[times == 1][:, 1] == pytest.approx([0, 0], abs=1e-9)
    # Only the resultants on the two supports are drawn, to show the size of the forces.
    assert len(marks(result, "resultants", "thrust")) == 2


def test_a_wall_has_no_chain_and_a_column_has_one():
    wall = assemble(mo.load(WALLS[0]))
    assert len(chains(wall, np.ones(wall.problem.joints, dtype=bool))) == 0
    column = assemble(mo.load(CASES / "closed_forms" / "dam_overturns.toml"))
    # The top lift has one joint, and three lifts are between two joints.
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
    assert drawn.get(IDLE_COLOUR, 0) == np.isnan(used).sum()


def test_forces_start_at_the_centroid_and_end_on_a_face_that_they_push():
    scene = block_on_floor(2, 3, live=(1.0, 0.0), dead=(0.0, -2.0), dead_at=(0.5, 3.0))
    (weight,), (live,), (dead,) = (arrows(scene, kind) for kind in ("weight", "live", "dead"))
    # The longest arrow of each kind has 9 % of the larger side of the scene.
    assert weight == pytest.approx(np.array([[1, 1.5], [1, 1.5 - 0.27]]))
    assert live == pytest.approx(np.array([[1, 1.5], [1.27, 1.5]]))
    assert dead == pytest.approx(np.array([[0.5, 3.27], [0.5, 3]]))


def test_every_load_of_a_block_has_an_arrow_where_it_acts():
    """A block has its own force and two loads, one of them at a point inside the block.

    The weight, a dead and a live load act downwards at the centroid. Their arrows are side by side, at
    distances of 2 % of the larger side of the scene.
    """
    loads = [mo.Load(block="A", live=(2, 0), at=(0.5, 2.5)), mo.Load(block="A", live=(0, -1), dead=(0, -1))]
    scene = block_on_floor(2, 3).replace(loads=loads)
    assert arrows(scene, "live") == pytest.approx(
        np.array([[[1, 1.5], [1.135, 1.5]], [[0.5, 2.5], [0.77, 2.5]], [[0.88, 1.5], [0.88, 1.365]]])
    )
    assert arrows(scene, "dead") == pytest.approx(np.array([[[0.94, 1.5], [0.94, 1.23]]]))
    assert arrows(scene, "weight") == pytest.approx(np.array([[[1, 1.5], [1, 1.23]]]))


def test_arrows_go_with_their_points_and_keep_their_direction():
    # A block of 1 × 2 overturns about its toe (1, 0). Its fastest corner, (0, 2), moves by 6 % of 2.
    result = mo.solve(block_on_floor(1, 2, 0.8))
    (tail, tip) = arrows(result, "live")[0]
    turn = 0.12 / np.sqrt(5)
    assert tail == pytest.approx([0.5 + turn * 1, 1 + turn * 0.5])
    assert tip - tail == pytest.approx([0.18, 0])


def test_all_weights_of_many_blocks_have_one_arrow_but_where_they_push():
    ((tail, tip),) = arrows(WALLS[0], "weight")
    assert (tip - tail)[0] == pytest.approx(0)
    assert (tip - tail)[1] < 0
    assert len(arrows(WALLS[0], "live")) == 33
    assert "direction of all weights" in labels(WALLS[0])
    tilted = block_on_floor(2, 3, live=(0.0, 0.0)).replace(tilt="left")
    ((tail, tip),) = arrows(tilted, "live")
    assert tip - tail == pytest.approx([-0.27, 0])


def test_water_pushes_more_the_deeper():
    water = mo.EdgeLoad(start=(0, 0), end=(0, 3), pressure=(3.0, 0.0), kind="live")
    scene = block_on_floor(2, 3, live=(0.0, 0.0)).replace(edge_loads=[water])
    rows = arrows(scene, "live")
    tip, length = rows[:, 1], rows[:, 1, 0] - rows[:, 0, 0]
    assert tip[:, 0] == pytest.approx(np.zeros(len(rows)))
    assert length / length.max() == pytest.approx(1 - tip[:, 1] / 3)
    elements, kind = elements_of(scene)
    low, high = elements.box(elements.shown(kind), 0.0) + elements.assembly.geometry.origin
    assert ((rows >= low) & (rows <= high)).all()
    (along,) = marks(scene, "live", shape="line")
    assert np.array(along) == pytest.approx(rows[[0, -1], 0])
    assert "live load, times λ" in labels(scene)


@pytest.mark.slow
@pytest.mark.parametrize("along_an_edge", [False, True])
def test_a_state_under_dead_load_alone_is_shown_without_the_live_load(along_an_edge):
    """A scene that falls, and the two ends of a margin, are drawn without the live load. The scene itself is
    drawn with it."""
    scene = block_on_floor(dead=(0.9, 0.0))
    if along_an_edge:
        push = mo.EdgeLoad(start=(0, 0), end=(0, 2), force=(1, 0), kind="live")
        scene = block_on_floor(dead=(0.9, 0.0), live=(0.0, 0.0)).replace(edge_loads=[push])
    falls = mo.solve(scene, "static")
    margin = mo.least(lambda mu: block_on_floor(friction=mu, dead=(0.4, 0.0)), 0.1, 0.9, samples=0)
    for result in (falls, margin.fails.result, margin.holds.result):
        assert not len(marks(result, "live"))
        assert len(arrows(result, "dead")) == 1
        assert "live load, times λ" not in labels(result)
        assert "further dead load" in labels(result)
    assert len(arrows(scene, "live")) > 0
    assert "live load, times λ" in labels(mo.solve(block_on_floor(), "static"))


def beside(*blocks):
    """Return a block of 2 × 3 on a floor, with its lower left corner at the origin, and more blocks beside
    it."""
    scene = block_on_floor(2, 3)
    return scene.replace(blocks=[*scene.blocks, *blocks])


#: In GAP, faces of height 2 are 0.001 apart. In CORNER, a corner of C touches a corner of B.
GAP = beside(rectangle("B", 2.001, 0, 4, 2, weight=1))
CORNER = beside(rectangle("B", 2, 0, 4, 2, weight=1), rectangle("C", 4, 2, 5, 3, weight=1))


def test_joints_found_are_drawn_and_counted():
    assert len(marks(WALLS[0], "joint")) == 83
    assert mo.draw(WALLS[0]).axes[0].get_title().endswith("33 blocks, 1 support, 83 joints")


def test_a_small_gap_is_marked_as_no_joint():
    (gap,) = marks(GAP, "gaps")
    assert np.sort(gap[:, 1]) == pytest.approx([0, 2], abs=0.01)
    assert gap[:, 0] == pytest.approx([2, 2], abs=0.002)
    assert len(marks(GAP, "joint")) == 2
    assert "small gap: no joint" in labels(GAP)
    assert "1 small gap" in counts(assemble(GAP))
    assert "small gap: no joint" not in labels(WALLS[0])


def test_corners_on_corners_and_on_edges_have_marks_of_their_own():
    assert marks(CORNER, "corners") == pytest.approx(np.array([[[4, 2]]]))
    assert "corner on corner: no joint" in labels(CORNER)
    assert any("only at their corners" in text.get_text() for text in mo.draw(CORNER).texts)
    assert marks(on_a_corner(), "joint", shape="square") == pytest.approx(np.array([[[1, 0]]]))
    assert len(marks(on_a_corner(), "joint", shape="line")) == 3
    assert {"joint", "joint of a corner on an edge"} <= set(labels(on_a_corner()))


def test_a_block_that_touches_nothing_is_drawn_and_named():
    scene = beside(rectangle("far up", 0, 5, 1, 6, weight=1))
    with pytest.raises(mo.CaseError):
        mo.solve(scene)
    figure = mo.draw(scene, names=True)
    assert "far up" in {text.get_text() for text in figure.axes[0].texts}
    assert any("'far up' touches no other block" in text.get_text() for text in figure.texts)
    alone = scene.model_copy(update={"blocks": scene.blocks[1:]})
    assert counts(assemble(alone, floating=True)) == "1 block, 1 support, 0 joints"
    mo.draw(alone)
