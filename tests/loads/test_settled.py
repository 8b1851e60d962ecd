"""Tests of analyses that start after a settlement of given size, against geometry by hand and redrawn
scenes."""

import math

import numpy as np
import pytest
from scenes import block_on_floor
from settled_scenes import SINKS, beam, block, joined_circles

import masonry_opt as mo
from masonry_opt.errors import CaseError, OptionError
from masonry_opt.finite_motion.settled_state import settled_scene
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.blocks import rectangle


def corners_of(scene: mo.Scene) -> np.ndarray:
    """Return the ends of the joints after the settlement, in the scene's coordinates, shape (joints, 2,
    2)."""
    assembly = assemble(scene)
    ends = np.stack([assembly.joints.start, assembly.joints.end], axis=1)
    return ends + assembly.geometry.origin


@pytest.mark.slow
def test_openings_after_a_movement_of_20_mm():
    """The beam turns about (1, 1) by 0.02/4 and stays on the outer edge of R, so that both joints open by
    0.005."""
    settlement = mo.settle(beam(), "R", (0, -1), movement=0.02)
    widths = settlement.openings["opening_at_movement"]
    np.testing.assert_allclose(widths, [0.005, 0.005], rtol=1e-6)
    np.testing.assert_allclose(settlement.openings["opening"], [0.25, 0.25], rtol=1e-6)
    assert "after a movement of 0.02, in the length unit of the case" in settlement.facts()["openings"]
    assert settlement.as_dict()["movement"] == 0.02
    assert settlement.as_dict()["least"]["openings"][0]["opening_at_movement"] == pytest.approx(0.005)
    assert mo.settle(beam(), "R", (0, -1)).as_dict()["movement"] is None


@pytest.mark.parametrize("movement", [0, -0.02, math.nan, "20 mm", True])
def test_a_wrong_movement_is_refused(movement):
    with pytest.raises(OptionError, match="'movement' must be a length above zero"):
        mo.settle(beam(), "R", (0, -1), movement=movement)


def test_turns_is_true_or_false():
    with pytest.raises(OptionError, match=r"'turns' must be True or False \(found 'no'\)"):
        mo.settle(beam(), "R", (0, -1), turns="no")


def test_a_movement_that_turns_blocks_far_is_refused():
    """A movement of 0.4 turns the beam by 0.1, the largest rotation of a small motion."""
    with pytest.raises(OptionError, match=r"must be at most 0\.4, .*\(found 0\.5\)"):
        mo.settle(beam(), "R", (0, -1), movement=0.5)


@pytest.mark.slow
def test_a_beam_on_a_pier_that_has_sunk():
    """After R has settled, the beam rests between (1, 1) and (5, 0.98), and slides on inclined joints.

    Each joint lies on the bisecting line of a level pier and the beam, which is inclined by atan(1/200). The
    beam slides to the right at 10 tan(φ − 1/400).
    """
    after = settled_scene(beam(), SINKS)
    turn = after.settled.poses[-1, 2]
    assert turn == pytest.approx(-math.atan(0.02 / 4), abs=1e-6)
    (left, right) = corners_of(after)
    np.testing.assert_allclose(left[np.argmax(left[:, 0])], [1, 1], atol=2e-5)
    np.testing.assert_allclose(right[np.argmax(right[:, 0])], [5, 0.98], atol=2e-5)
    np.testing.assert_allclose(left[np.argmin(left[:, 0])], [0, 1 + 0.005 / 2], atol=3e-5)
    result = mo.solve(beam(), settled=SINKS)
    assert result.load_factor == pytest.approx(10 * math.tan(math.atan(0.6) - 0.0025), rel=1e-6)
    assert result.incremental == pytest.approx(result.load_factor, rel=1e-6)
    assert "settled: 'R' by (0, -0.02)" in result.case


def test_the_json_of_a_settled_scene_has_the_displaced_vertices():
    """The beam turns about (1, 1) by asin(0.02/4), and its lower right corner moves along a circle."""
    (row,) = mo.solve(beam(), "static", settled=SINKS).as_dict()["block_results"]
    vertices = np.array(row["vertices"])
    np.testing.assert_allclose(vertices[np.argmax(vertices[:, 0] - vertices[:, 1])], [5, 0.98], atol=3e-5)
    np.testing.assert_allclose(vertices.mean(axis=0), [row["x"], row["y"]], atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("turn", [-0.1, 0.05])
def test_a_block_on_a_floor_that_has_turned(turn):
    """On a floor that has rotated by r, λ = (b + h tan r)/(h − b tan r), as for a block that has rocked by
    −r."""
    b, h = 1.0, 2.0
    result = mo.solve(block_on_floor(b, h, friction=0.9), "static", settled={"floor": (0, 0, turn)})
    tangent = math.tan(turn)
    assert result.load_factor == pytest.approx((b + h * tangent) / (h - b * tangent), rel=1e-7)
    curve = mo.capacity(result, steps=4)
    assert curve.reaches_zero
    assert curve.table["rotation"].iloc[-1] == pytest.approx(math.atan(b / h) + turn, abs=1e-8)


@pytest.mark.slow
def test_a_pier_that_slides_leaves_a_shorter_joint():
    """If R moves by 0.02 below the beam, or with the beam on L, one joint is 0.98 long and the other 1."""
    lengths = assemble(settled_scene(beam(), {"R": (0.02, 0)})).joints.extent
    assert sorted(lengths) == pytest.approx([0.98, 1.0])
    with pytest.raises(
        OptionError, match=r"slides off block .*: use a smaller movement, such as 0\.5 times this movement"
    ):
        settled_scene(beam(), {"R": (1.5, 0)})


@pytest.mark.slow
def test_all_supports_that_sink_alike_change_nothing():
    result = mo.solve(beam(), settled={"L": (0, -0.3), "R": (0, -0.3)})
    assert result.load_factor == pytest.approx(6, rel=1e-6)
    assert "'L' by (0, -0.3), 'R' by (0, -0.3)" in result.case


@pytest.mark.slow
def test_units_and_mirror_images_do_not_matter():
    """The load factor is the same in millimetres and newtons, and for the mirror image of the scene.

    In the mirror image, the left pier settles under a push to the left.
    """
    expected = mo.solve(beam(), settled=SINKS).load_factor
    blocks = [one.replace(vertices=[(1e3 * x, 1e3 * y) for x, y in one.vertices]) for one in beam().blocks]
    blocks = [one if one.fixed else one.replace(weight=1e4, live=(1e3, 0)) for one in blocks]
    small = beam().replace(blocks=blocks)
    assert mo.solve(small, settled={"R": (0, -20)}).load_factor == pytest.approx(expected, rel=1e-6)
    blocks = [
        one.replace(vertices=[(5 - x, y) for x, y in one.vertices]) for one in beam(live=(-1, 0)).blocks
    ]
    mirrored = beam().replace(blocks=blocks)
    assert mo.solve(mirrored, settled=SINKS).load_factor == pytest.approx(expected, rel=1e-6)


def test_forces_after_the_settlement_are_the_preload():
    """The preload is the joint forces after the settlement.

    As R moves out, it slides below the beam. The beam presses least on R if it turns on the edges at x = 1
    and x = 5: with 10 · 1.5/4 = 3.75, so that friction is 0.6 · 3.75.
    """
    problem = assemble(settled_scene(beam(), {"R": (0.02, 0)})).problem
    assert problem.settled is not None
    shears = np.abs(problem.by_kind(problem.settled)[2]) * problem.force_unit
    assert shears == pytest.approx([2.25, 2.25], rel=1e-6)


def test_a_tie_runs_between_its_displaced_ends():
    """A tie runs between its displaced ends, and its force has the direction of this line.

    The beam turns about (1, 1) by −atan(1/200), so that its top at (2.5, 2) moves by (1, −1.5)/200. The tie
    from this point to (2.5, 5) is then inclined by 0.005 over 3.0075.
    """
    rod = mo.Tie(between=("beam", "ground"), at=((2.5, 2), (2.5, 5)), strength=1.0, prestress=0.5)
    after = assemble(settled_scene(beam().replace(ties=[rod]), SINKS))
    (force,) = after.limited
    top, far = (action.point + after.geometry.origin for action in force.actions)
    np.testing.assert_allclose(top, [2.505, 1.9925], atol=4e-5)
    np.testing.assert_allclose(far, [2.5, 5])
    np.testing.assert_allclose(force.actions[0].force, [-0.005 / 3.0075, 1], atol=2e-5)


@pytest.mark.parametrize(
    ("settled", "words"),
    [
        ({"pier": (0, -1)}, "settled: no block 'pier'; supports: L, R"),
        ({"beam": (0, -1)}, "block 'beam' is not a support: choose a block with 'fixed = true': L, R"),
        (
            {"R": (0, 0)},
            r"support 'R': .* finite numbers \(x, y\) or \(x, y, rotation\), not all of them zero",
        ),
        ({"R": (1,)}, "support 'R': the movement needs"),
        ({"R": (0, math.inf)}, "support 'R': the movement needs"),
        ({"R": "down"}, "support 'R': the movement needs"),
        ({}, "needs the movement of each support by name, such as"),
        ("R", "needs the movement of each support by name, such as"),
        (5, "needs the movement of each support by name, such as"),
        ([("R", (0, -1)), ("R", (0, 1))], "'settled' must name each support once"),
        ({"R": (0, -3.9)}, r"use a smaller movement, such as 0\.125 times this movement"),
    ],
)
def test_wrong_movements_are_refused(settled, words):
    with pytest.raises(OptionError, match=words):
        mo.solve(beam(), settled=settled)


def test_scenes_that_cannot_settle_are_refused():
    with pytest.raises(OptionError, match="needs a scene in the plane"):
        mo.solve(mo.extrude(beam(), 1), settled=SINKS)
    short = beam().replace(blocks={"R": {"vertices": rectangle(1.5, 2, 0, 1)}})
    with pytest.raises(OptionError, match="unstable under its dead load before its supports settle"):
        mo.solve(short, settled=SINKS)
    idle = beam().replace(blocks=[*beam().blocks, block("far", 9, 10, 0, 1, fixed=True)])
    with pytest.raises(OptionError, match="support 'far' touches no block that can move"):
        mo.solve(idle, settled={"far": (0, -1)})
    after = settled_scene(beam(), SINKS)
    with pytest.raises(OptionError, match="the supports have settled already: specify all movements at once"):
        mo.solve(after, settled=SINKS)
    further = after.replace(blocks=[*after.blocks, block("on top", 1, 2, 2, 3, weight=1)])
    with pytest.raises(CaseError, match="cannot change: first change the blocks of the original scene"):
        mo.solve(further)


@pytest.mark.slow
def test_load_cases_settle_each_under_its_own_dead_loads():
    cases = [{"name": name, "live": {"live": factor}} for name, factor in (("one", 1.0), ("two", 2.0))]
    answer = mo.solve_cases(beam().replace(load_cases=cases), "static", settled=SINKS)
    single = mo.solve(beam(), "static", settled=SINKS).load_factor
    found = [result.load_factor for result in answer.results.values()]
    assert found == pytest.approx([single, single / 2], rel=1e-6)


@pytest.mark.slow
def test_earthquakes_after_a_settlement(command, tmp_path):
    """The beam slides on joints inclined by 1/400: at tan(φ + 1/400) to the left, and at tan(φ − 1/400) to
    the right."""
    answer = mo.directions(beam(), "static", settled=SINKS)
    angle = math.atan(0.6)
    found = [result.load_factor for result in answer.results.values()]
    assert found == pytest.approx([math.tan(angle + 0.0025), math.tan(angle - 0.0025)], rel=1e-6)
    path = tmp_path / "beam.toml"
    mo.save(beam(), path)
    assert "settled: 'R' by (0, -0.02)" in command("directions", path, "--settled", "R:0,-0.02")
    with pytest.raises(OptionError, match="accept 'settled': solve, solve_cases, directions, crossing"):
        mo.sweep(beam(), {"joints.friction": [0.5]}, settled=SINKS)


@pytest.mark.slow
def test_the_commands_take_a_settlement(command, tmp_path):
    path = tmp_path / "beam.toml"
    mo.save(beam(), path)
    answer = command.json("solve", path, "--settled", "R:0,-0.02")
    assert answer["load_factor"] == pytest.approx(10 * math.tan(math.atan(0.6) - 0.0025), rel=1e-6)
    assert answer["case"].endswith("settled: 'R' by (0, -0.02)")
    text = command("settle", path, "--support", "R", "--direction", "0,-1", "--movement", "0.02")
    assert "after a movement of 0.02" in text
    assert "'beam' 0.005" in text
    form = "write NAME:X,Y or NAME:X,Y,ROTATION"
    for wrong in ("R", "R:1", "R:0,x", ":0,1", "R:0,0,0,0"):
        assert form in command.refused("solve", path, "--settled", wrong)
    axles = {"name": "one", "loads": [10.0], "road": [(0, 3), (5, 3)]}
    mo.save(beam(live=(0, 0)).replace(axles=[axles]), tmp_path / "bridge.toml")
    static = ("--method", "static")
    crossed = command("crossing", tmp_path / "bridge.toml", "--settled", "R:0,-0.02", *static, code=None)
    assert "settled: 'R' by (0, -0.02)" in crossed
    mo.save(block_on_floor(0.6, 3, friction=0.9), tmp_path / "block.toml")
    spectrum = tmp_path / "spectrum.csv"
    spectrum.write_text("0,0.2\n0.15,0.5\n9,0.03\n")
    given = "--settled", "floor:0,0,-0.05", "--spectrum", spectrum, "--code", "NTC 2018 SLC"
    curve = command.json("capacity", tmp_path / "block.toml", *given)
    assert curve["load_factor"] == pytest.approx(math.tan(math.atan(0.2) - 0.05), rel=1e-6)
    assert (curve["check"]["code"], curve["check"]["linear"]) == ("NTC 2018 SLC", None)
    assert "no block 'Q'" in command.refused("capacity", path, "--settled", "Q:0,1")


def turned(points: np.ndarray, about: np.ndarray, to: np.ndarray, angle: float) -> list[tuple[float, float]]:
    """Return points after a rotation about the point `about`, which moves to the point `to`."""
    rotation = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    return [tuple(point) for point in ((np.atleast_2d(points) - about) @ rotation.T + to).tolist()]


def two_spans() -> mo.Scene:
    """Return a bridge of two spans, 6 m and 4 m, on a pier of 1.2 m, without its fill."""
    big = mo.Arch(name="big", at=(0, 4), span=6, rise=1.5, thickness=0.45, voussoirs=31, unit_weight=22)
    small = mo.Arch(name="small", at=(6.2, 4), span=4, rise=1.0, thickness=0.45, voussoirs=21, unit_weight=22)
    pier = [(3, 0), (4.2, 0), (4.2, 4), (3.84, 4.27), (3.36, 4.27), (3, 4)]
    blocks = [
        *(one for arch in (big, small) for one in arch.replace(abutments=False).blocks()),
        mo.Block(name="pier", vertices=pier, unit_weight=22),
        block("footing", 2.5, 4.7, -1, 0, fixed=True),
        mo.Block(name="west", vertices=[(-8, 3), (-3, 3), (-3, 4), (-3.36, 4.27), (-8, 4.27)], fixed=True),
        mo.Block(name="east", vertices=[(8.2, 3), (14, 3), (14, 4.27), (8.56, 4.27), (8.2, 4)], fixed=True),
    ]
    return mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=blocks)


def drawn_again(scene: mo.Scene, spread: float, crown_hinge: int) -> mo.Scene:
    """Return the bridge after its east abutment has moved out, with hinges at both springings and at the
    crown.

    The two halves of the small arch turn about (4.2, 4) and (8.2, 4). They meet at the intersection of two
    circles about these points, after the voussoir whose number is ``crown_hinge``. The tolerance closes the
    cracks, so that joints lie on the bisecting lines of their edges.
    """
    left, right = np.array([4.2, 4.0]), np.array([8.2, 4.0])
    away = right + np.array([spread, 0.0])
    ends = (np.array(scene[f"small v{number}"].vertices) for number in (crown_hinge, crown_hinge + 1))
    first, second = ends
    distance = np.hypot(*(first[:, None] - second).transpose(2, 0, 1)).min(axis=1)
    crown = max(first[distance < 1e-9], key=lambda point: point[1])
    radii = np.hypot(*(crown - left)), np.hypot(*(crown - right))
    sunk = joined_circles((left, radii[0]), (away, radii[1]), crown)
    angles = [
        math.atan2(*(sunk - to)[::-1]) - math.atan2(*(crown - at)[::-1])
        for at, to in ((left, left), (right, away))
    ]
    blocks = []
    for one in scene.blocks:
        motion = None
        if one.name == "east":
            motion = right, away, 0.0
        elif one.name.startswith("small"):
            first = int(one.name.split("v")[1]) <= crown_hinge
            motion = (left, left, angles[0]) if first else (right, away, angles[1])
        if motion is not None:
            keys = {"vertices": turned(np.array(one.vertices), *motion)}
            if one.weight_at is not None:
                keys["weight_at"] = turned(np.array(one.weight_at), *motion)[0]
            one = one.replace(**keys)
        blocks.append(one)
    return mo.Scene(joints=scene.joints, blocks=blocks, tolerance=0.0075)


def crown_hinge_of(after: mo.Scene) -> int:
    """Return the number of voussoirs that turn with the first one: of 21 the 10th or the 11th, by
    symmetry."""
    turns = {one.name: pose[2] for one, pose in zip(after.blocks, after.settled.poses, strict=True)}
    number = sum(abs(turns[f"small v{k}"] - turns["small v1"]) < 1e-9 for k in range(1, 22))
    assert number in (10, 11)
    return number


@pytest.mark.slow
def test_a_settled_bridge_of_two_spans_against_its_geometry_drawn_again():
    """After the east abutment has moved out by 20 mm, λ of a load on one voussoir equals λ of the redrawn
    bridge."""
    scene = two_spans()
    after = settled_scene(scene, {"east": (0.02, 0)})
    again = drawn_again(scene, 0.02, crown_hinge_of(after))
    for name in ("small v8", "big v10", "small v14"):
        change = {name: {"live": (0.0, -1.0)}}
        before = mo.solve(scene.replace(blocks=change), "static").load_factor
        expected = mo.solve(again.replace(blocks=change), "static").load_factor
        found = mo.solve(after.replace(blocks=change), "static").load_factor
        assert found == pytest.approx(expected, rel=1e-7)
        assert abs(before / expected - 1) > 0.01


@pytest.mark.slow
def test_axles_cross_a_settled_bridge():
    """On a settled bridge, the worst position of an axle has the load factor of a crossing of the redrawn
    bridge."""
    axles = [{"name": "one", "loads": [10.0], "road": [(-3, 6), (8, 6)]}]
    scene = two_spans()
    answer = mo.crossing(scene.replace(axles=axles), method="static", settled={"east": (0.02, 0)})
    hinge = crown_hinge_of(answer.worst.assembly.scene)
    again = mo.crossing(drawn_again(scene, 0.02, hinge).replace(axles=axles), method="static")
    assert answer.load_factor == pytest.approx(again.load_factor, rel=1e-5)
    assert answer.worst.load_factor == pytest.approx(answer.load_factor, rel=1e-6)
    assert "settled: 'east' by (0.02, 0)" in str(answer)


@pytest.mark.slow
def test_a_load_at_the_edge_of_a_displaced_block_is_no_warning():
    """A load on the top of the beam moves with the beam and causes no warning; a load above the top causes
    one."""
    scene = beam(live_at=(2.5, 2.0))
    assert mo.solve(scene, "static", settled={"R": (0.0, -0.2)}).warning_sentences == ()
    lifted = beam(live_at=(2.5, 2.1))
    (sentence,) = mo.solve(lifted, "static", settled={"R": (0.0, -0.2)}).warning_sentences
    assert "acts 0.1 outside the block" in sentence
