"""Tests of the capacity curve: closed forms, arches by a second program, work, symmetry, and how curves
end."""

import itertools
import math

import numpy as np
import pytest
from four_bar import Body, load_factors
from mappings import mapped, turned
from scenes import CASES, block_on_floor, solved

import masonry_opt as mo
from masonry_opt.errors import NoLoadFactorError, OptionError
from masonry_opt.scene.blocks import rectangle
from masonry_opt.solution.motion import joint_motion
from masonry_opt.solution.reasons import Code

SPECTRUM = ((0.0, 0.2), (0.15, 0.5), (4.0, 0.03))
#: Tolerance of curves against closed forms.
CLOSE = 1e-9


def followed(scene: mo.Scene, steps: int = 10, **options) -> mo.Capacity:
    return mo.capacity(solved(scene, "static"), steps=steps, **options)


@pytest.mark.slow
@pytest.mark.parametrize(("b", "h"), [(0.3, 2.0), (2.0, 1.0)])
def test_a_rocking_block(b, h):
    """λ and the works of a rocking block agree with closed forms.

    About the corner, the weight has the lever (b cos θ − h sin θ)/2, and the live load λ W has the lever (h
    cos θ + b sin θ)/2. The works follow from the displacement of the centroid. The control point is the
    middle of the top.
    """
    curve = followed(block_on_floor(b, h, friction=3.0), block="A", point=(b / 2, h))
    theta, λ = curve.table["rotation"].to_numpy(), curve.table["load_factor"].to_numpy()
    s, c = np.sin(theta), np.cos(theta)
    for column, exact in (
        ("displacement", h * s + b / 2 * (1 - c)),
        ("live_work", (h * s + b * (1 - c)) / 2),
        ("dead_work", (h * (1 - c) - b * s) / 2),
    ):
        np.testing.assert_allclose(curve.table[column], exact, atol=CLOSE)
    assert len(λ) > 8
    np.testing.assert_allclose(λ, (b - h * np.tan(theta)) / (h + b * np.tan(theta)), atol=CLOSE)
    assert theta[-1] == pytest.approx(math.atan(b / h), abs=CLOSE)
    assert curve.end.code is Code.REACHES_ZERO
    assert λ[-1] == 0.0


def test_a_rocking_frame():
    """λ of a rocking frame is tan(α − θ), whatever its blocks weigh (Makris & Vassiliou 2013).

    The columns and the beam on them move in one direction: tan(α − θ) upwards for 1 sideways. The frame has
    four hinges of two bodies each, more than equilibrium requires.
    """
    curve = followed(mo.load(CASES / "makris_vassiliou" / "rocking_frame.toml"))
    theta = curve.table["rotation"].to_numpy()
    np.testing.assert_allclose(curve.table["load_factor"], np.tan(math.atan(1 / 4) - theta), atol=1e-8)
    assert curve.reaches_zero


@pytest.mark.slow
def test_a_dead_load_on_its_top_goes_with_it():
    """A dead load on the top of a block moves with the block.

    With N at x on the top, λ W (h c + b s)/2 = W (b c − h s)/2 + N ((b − x) c − h s). N is a point load, a
    load N/b along the edge, or a load that grows along the edge, with its resultant at 2b/3.
    """
    b, h, N = 1.0, 2.0, 1.5
    edge = {"start": (0, h), "end": (b, h)}
    for dead, at in (
        ({"loads": [mo.Load(block="A", dead=(0, -N), at=(b / 2, h))]}, b / 2),
        ({"edge_loads": [mo.EdgeLoad(force=(0, -N / b), **edge)]}, b / 2),
        ({"edge_loads": [mo.EdgeLoad(pressure=(0, 2 * N / b), **edge)]}, 2 * b / 3),
    ):
        curve = followed(block_on_floor(b, h, friction=3.0).model_copy(update=dead))
        theta = curve.table["rotation"].to_numpy()
        s, c = np.sin(theta), np.cos(theta)
        exact = ((b * c - h * s) / 2 + N * ((b - at) * c - h * s)) / ((h * c + b * s) / 2)
        np.testing.assert_allclose(curve.table["load_factor"], exact, atol=CLOSE)


def struts(length: float, t: float = 0.3, h: float = 1.5, N: float = 2.0) -> mo.Scene:
    """Return two stacked blocks on a floor, whose top is held by a weightless strut of the given length.

    Their weights push both blocks to the right, and N acts on the top.
    """
    at, pushed = t + length, {"weight": 1, "live": (1, 0)}
    on_top = {"dead": (0, -N), "dead_at": (t / 2, 2 * h)}
    return mo.Scene(
        joints=mo.JointDefaults(friction=5.0),
        blocks=[
            mo.Block(name="floor", vertices=rectangle(-1, t + 1, -1, 0), fixed=True),
            mo.Block(name="lower", vertices=rectangle(0, t, 0, h), **pushed),
            mo.Block(name="upper", vertices=rectangle(0, t, h, 2 * h), **pushed, **on_top),
            mo.Block(name="strut", vertices=rectangle(t, at, 2 * h - 0.1, 2 * h), weight=0),
            mo.Block(name="wall", vertices=rectangle(at, at + 1, 0, 4 * h), fixed=True),
        ],
        tolerance=1e-9,
    )


def by_second_program(curve: mo.Capacity, order: list[str], rows: range) -> np.ndarray:
    """Return λ of the four-bar linkage at the rotations of its first body in the given rows.

    `order` names the blocks from ground to ground.
    """
    assembly, joints = curve.result.assembly, curve.result.assembly.joints
    names, block = assembly.names(assembly.movable), {each.name: each for each in assembly.scene.blocks}
    centre = assembly.geometry.centroid[assembly.movable] + assembly.geometry.origin
    hinged, touch = curve.joints(rows[0]).query("state == 'hinged'"), curve.steps[rows[0]].touch
    at_rest = np.where(touch[joints.first_point, None], joints.start, joints.end) + assembly.geometry.origin
    place = {frozenset((row.first, row.second)): complex(*at_rest[row.Index]) for row in hinged.itertuples()}
    pairs = [frozenset(pair) for pair in itertools.pairwise(order)]
    cuts = [number for number, pair in enumerate(pairs) if pair in place]
    bodies = []
    for first, last in itertools.pairwise(cuts):
        forces = []
        for name in order[first + 1 : last + 1]:
            own, centroid = block[name], centre[names.index(name)]
            down, push = np.array(assembly.scene.down), np.array(own.live_per_weight)
            forces += [
                (own.weight_at or centroid, own.weight * down, own.weight * push),
                (own.dead_at or centroid, own.dead, (0, 0)),
                (own.live_at or centroid, (0, 0), own.live),
            ]
        at, dead, live = (np.array([complex(*one[kind]) for one in forces]) for kind in range(3))
        bodies.append(Body(at, dead, live))
    first_block = names.index(order[cuts[0] + 1])
    turns = np.array([curve.poses(row)[first_block, 2] for row in rows])
    return load_factors(np.array([place[pairs[cut]] for cut in cuts]), bodies, turns)


def ideal(theta: np.ndarray, t: float, h: float, k: float, N: float, W: float = 1.0) -> np.ndarray:
    """Return λ of a wall whose top is held sideways on its outer corner, at the height k above the middle.

    The lower block turns outwards by θ about its outer corner T at the foot. The upper block turns back by φ
    about the inner end M of the joint between the blocks. M = T + (h s − t c, t s + h c), and k sin φ − t cos
    φ = h s − t c keeps the top above T. λ follows from the virtual work of the weights W, of N on the middle
    of the top, and of λ W sideways.
    """
    s, c = np.sin(theta), np.cos(theta)
    phi = np.arcsin((h * s - t * c) / math.hypot(k, t)) + math.atan2(t, k)
    sf, cf = np.sin(phi), np.cos(phi)
    rate = (h * c + t * s) / (k * cf + t * sf)
    mx, my = h * c + t * s, t * c - h * s  # Velocity of M.
    sideways = W * mx / 2 + W * (mx - rate * (t * sf + h * cf) / 2)
    of_upper = rate * (t * cf - h * sf) / 2
    upwards = W * my / 2 + W * (my + of_upper) + N * (my + rate * (t / 2 * cf - h * sf))
    return upwards / sideways


@pytest.mark.parametrize(("length", "near"), [(2.0, 0.1), (20.0, 0.01)])
def test_a_wall_of_two_blocks_between_floors(length, near):
    """λ agrees with the second program, and approaches that of a wall with a fixed top as the strut grows.

    The curve ends when the strut carries no force.
    """
    curve = followed(struts(length))
    λ, order = curve.table["load_factor"].to_numpy(), ["floor", "lower", "upper", "strut", "wall"]
    np.testing.assert_allclose(λ, by_second_program(curve, order, range(len(λ))), atol=1e-8)
    theta = -np.array([curve.poses(row)[0, 2] for row in range(len(λ))])
    assert np.abs(λ - ideal(theta, 0.3, 1.5, 1.4, 2.0)).max() < near * λ[0]
    assert curve.end.code is Code.BRANCHES
    assert λ[-1] < λ[0] / 5


def test_an_arch_by_a_second_program():
    """λ of an arch that is loaded on a haunch agrees with the second program while four joints hinge.

    The curve itself determines which joints hinge between two events.
    """
    loads = {"unit_weight": 1, "point_loads": [mo.PointLoad(voussoir=4, force=(0, -10))]}
    ring = mo.Arch(radius=10, angles=(157.5, 22.5), thickness=1.5, voussoirs=15, **loads)
    curve = followed(mo.Scene(joints=mo.JointDefaults(friction=2.0), blocks=ring.blocks(thickness=1.0)))
    *voussoirs, first, last = (block.name for block in curve.result.assembly.scene.blocks)
    order = [first, *voussoirs, last]
    λ, compared = curve.table["load_factor"].to_numpy(), 0
    events = [0, *np.flatnonzero(curve.table["event"] != ""), len(λ) - 1]
    for first, last in itertools.pairwise(events):
        rows = range(first, last + 1)
        if (curve.joints(rows[0])["state"] == "hinged").sum() == 4:
            np.testing.assert_allclose(λ[list(rows)], by_second_program(curve, order, rows), atol=1e-7 * λ[0])
            compared += len(rows)
    assert compared > 8
    assert curve.reaches_zero


@pytest.mark.slow
def test_the_curve_does_not_depend_on_axes_and_units():
    """The curve is the same for a scene that is rotated, in millimetres and newtons, with its blocks in
    another order."""
    scene, about = mo.load(CASES / "oppenheim" / "seven_voussoirs.toml"), turned(0.7)
    units = {"dead": 1e3, "live": 2e3, "length": 1000, "order": np.arange(9)[::-1]}
    other = mapped(scene, lambda v: tuple(1000 * x + 5000 for x in about(v)), about, **units)
    before, after = (followed(one, steps=8).table for one in (mapped(scene), other))
    # The steps between events differ, so that only the rows at events are compared.
    before, after = (table[(table["event"] != "") | (table.index == 0)] for table in (before, after))
    assert list(after["event"]) == list(before["event"])
    scales = {"displacement": 1e3, "rotation": 1, "load_factor": 1 / 2, "dead_work": 1e6, "live_work": 2e6}
    for column, scale in scales.items():
        top = np.abs(before[column]).max() * scale
        np.testing.assert_allclose(after[column], scale * before[column], atol=1e-6 * top)


@pytest.mark.parametrize("in_space", [False, True])
def test_blocks_that_meet_end_the_curve(in_space):
    """A block of height h rocks towards a wall at the distance g from its foot, and meets it at h sin θ = g.

    In the plane the curve ends at this state. In space it ends at the step before.
    """
    g, h = 0.2, 2.0
    scene = block_on_floor(1.0, h, friction=3.0)
    wall = mo.Block(name="wall", vertices=rectangle(1 + g, 2, 0, 3), fixed=True)
    scene = scene.replace(blocks=[*scene.blocks, wall])
    curve = followed(mo.extrude(scene, 0.5) if in_space else scene, steps=40)
    assert curve.end.code is Code.BLOCKS_MEET
    assert {*curve.end.values["blocks"]} == {"A", "wall"}
    last, step = curve.table["rotation"].iloc[-1], curve.table["rotation"].iloc[1]
    if in_space:
        assert math.sin(last) < g / h < math.sin(last + step) + 1e-3
    else:
        assert last == pytest.approx(math.asin(g / h), rel=1e-4)
    assert curve.displacement is None
    assert not curve.check(SPECTRUM).complete


def test_a_program_that_fails_ends_the_curve_with_what_to_do(failing):
    failing("highs")
    curve = followed(block_on_floor(1.0, 2.0, friction=3.0))
    assert curve.end.code is Code.FORCES_UNDECIDED
    assert "'steps'" in curve.message


@pytest.mark.parametrize(
    ("scene", "code"),
    [
        (block_on_floor(friction=0.4), Code.JOINTS_SLIDE),
        ("gilbert/two_blocks", Code.NOT_HINGING),
        ("closed_forms/keystone", Code.BRANCHES),
    ],
    ids=["slides", "below the associative", "comes free"],
)
def test_what_has_no_finite_motion_stops_at_the_onset(scene, code):
    scene = mo.load(CASES / f"{scene}.toml") if isinstance(scene, str) else scene
    curve = mo.capacity(mo.solve(scene, incremental=False))
    assert curve.end.code is code
    assert (len(curve.table), curve.reaches_zero, curve.displacement) == (1, False, None)
    assert curve.table["load_factor"][0] == curve.load_factor
    with pytest.raises(NoLoadFactorError):
        curve.check([(0, 0.1), (9, 0.1)])


def test_a_curve_that_ends_because_joints_slide_says_by_how_much():
    """With associative flow the block opens by 0.4 per unit of slip, so that 1/√1.16 of its speed is slip."""
    curve = mo.capacity(mo.solve(block_on_floor(friction=0.4), "static"))
    assert "the largest slip is 93 % of the speed of the fastest corner" in curve.message
    assert curve.message.endswith("(a joint with a slip of up to 0.2 % counts as a hinge)")
    (named,) = curve.plot().legends[0].get_texts()
    assert named.get_text() == "onset of collapse, without a curve"
    assert curve.end.values["slip"] == pytest.approx(1 / math.hypot(1, 0.4), rel=1e-6)
    below = mo.capacity(mo.solve(mo.load(CASES / "gilbert/two_blocks.toml"), incremental=False))
    assert 0.002 < below.end.values["slip"] < 2


def surveyed(scene: mo.Scene, size: float, seed: int) -> mo.Scene:
    """Return the scene with random errors of the given size in the corners of all blocks."""
    rng = np.random.default_rng(seed)
    corners = {block.name: np.array(block.vertices) for block in scene.blocks}
    moved = {name: at + size * rng.standard_normal(at.shape) for name, at in corners.items()}
    blocks = {name: {"vertices": [tuple(at) for at in of.tolist()]} for name, of in moved.items()}
    return scene.replace(blocks=blocks, tolerance=8 * size)


def pushed_arch(friction: float) -> mo.Scene:
    ring = mo.Arch(radius=2, angles=(150, 25), thickness=0.35, voussoirs=6, unit_weight=20)
    blocks = [block if block.fixed else block.replace(live_per_weight=(1.0, 0.0)) for block in ring.blocks()]
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=blocks)


def kerbed(height: float) -> mo.Scene:
    """Return a block on a floor that turns about a kerb at its foot.

    The foot slips by the height of the kerb per unit of rotation.
    """
    kerb = mo.Block(name="kerb", vertices=rectangle(0.6, 3, -1, height), fixed=True)
    floor = mo.Block(name="floor", vertices=rectangle(-3, 0.6, -1, 0), fixed=True)
    block = mo.Block(name="A", vertices=rectangle(0, 0.6, 0, 2), weight=10, live_per_weight=(1, 0))
    return mo.Scene(joints={"friction": 0.7}, blocks=[block, floor, kerb], tolerance=1e-6)


@pytest.mark.parametrize(
    "scene",
    [
        surveyed(pushed_arch(0.7), 1e-4, 1),
        surveyed(pushed_arch(0.4), 1e-4, 2),
        surveyed(block_on_floor(1, 2, friction=0.7), 1e-5, 3),
        surveyed(block_on_floor(1, 2, friction=0.4), 1e-5, 4),
        kerbed(1e-3),
        kerbed(0.1),
    ],
)
def test_a_joint_slides_here_if_it_slides_in_the_result(scene):
    """A capacity curve and a result agree on whether joints slide.

    Slip below the threshold of a result does not count, as at a kerb of 1/2000 of the block's height.
    """
    result = solved(scene, "static")
    slides = joint_motion(result.assembly, result.solution).slides.any()
    end = mo.capacity(result, steps=4).end
    assert (end.code in (Code.JOINTS_SLIDE, Code.NOT_HINGING)) == slides


def test_below_the_associative_load_factor_no_joint_is_said_to_slide_that_does_not():
    """The slip of the foot lowers λ by less than 1/200, and results call the joint a hinge, as the curve
    does."""
    result = solved(kerbed(1e-3), "coulomb", incremental=False)
    assert not joint_motion(result.assembly, result.solution).slides.any()
    curve = mo.capacity(result)
    assert curve.end.code is Code.NOT_HINGING
    assert 0.99 * result.associative < result.load_factor < (1 - 1e-4) * result.associative
    assert "slide" not in curve.message
    assert "associative load factor (0.301965)" in curve.message


def bonded_wall(friction: float) -> mo.Scene:
    """Return a wall of five courses, 1 wide and 1.25 high, with stones of 0.5 and half stones in every
    second course."""
    blocks = [mo.Block(name="floor", vertices=rectangle(-3, 4, -1, 0), fixed=True)]
    for course in range(5):
        ends = [0, 0.5, 1] if course % 2 == 0 else [0, 0.25, 0.75, 1]
        for left, right in itertools.pairwise(ends):
            shape = rectangle(left, right, course / 4, (course + 1) / 4)
            keys = {"unit_weight": 20, "live_per_weight": (1, 0)}
            blocks.append(mo.Block(name=f"{course}-{left}", vertices=shape, **keys))
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=blocks)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.7, 1.5])
def test_a_mechanism_of_coulomb_friction_below_the_associative_load_factor_is_followed(friction):
    """A mechanism of Coulomb friction is followed, and its λ agrees with the closed form.

    Half of the wall, above a stair of joints from (1, 0.25) to (0, 1), turns about (1, 0.25). Its centroid is
    at (0.625, 0.875). Joints of the stair that slip open at once, and head joints in the stair carry no
    force.
    """
    result = solved(bonded_wall(friction), "coulomb", incremental=False)
    assert result.load_factor < 0.99 * result.associative
    curve = mo.capacity(result, steps=10)
    theta = curve.table["rotation"].to_numpy()
    s, c = np.sin(theta), np.cos(theta)
    exact = (0.375 * c - 0.625 * s) / (0.625 * c + 0.375 * s)
    np.testing.assert_allclose(curve.table["load_factor"], exact, atol=1e-7)
    assert curve.reaches_zero
    # The curve ends with the centroid of the moving half above the corner. The displacement is the mean of
    # the whole wall.
    assert curve.displacement == pytest.approx(0.375 / 2, abs=CLOSE)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_survey_of_a_wall_with_errors_of_2_mm_is_followed(seed):
    """Errors of 2 mm in corners of stones of 500 × 250 mm change λ and the displacement by up to 2 %."""
    result = solved(surveyed(bonded_wall(0.7), 2e-3, seed), "coulomb", incremental=False)
    curve = mo.capacity(result, steps=10)
    assert curve.reaches_zero, curve.message
    assert curve.load_factor == pytest.approx(0.6, rel=0.02)
    assert curve.displacement == pytest.approx(0.1875, rel=0.02)


@pytest.mark.slow
def test_what_it_is_not_for_is_refused():
    rocks = solved(block_on_floor(friction=3.0), "static")
    strength = mo.JointDefaults(friction=3.0, strength=50.0)
    tie = mo.Tie(between=("A", "ground"), at=((0.5, 1.5), (-4, 1.5)), strength=0.1)
    for scene, word in (
        (block_on_floor().model_copy(update={"joints": strength}), "strength"),
        (
            block_on_floor(friction=3.0).model_copy(update={"ties": [tie]}),
            r"take account of \[\[tie\]\] 'A\|ground'",
        ),
    ):
        with pytest.raises(OptionError, match=word):
            mo.capacity(solved(scene, "static"))
    points = [{"block": "A", "point": point} for point in ((1, 0), (1,), ("1", "high"), (math.nan, 1))]
    for options in ({"block": "B"}, {"point": (0, 1)}, {"steps": 1}, {"steps": True}, *points):
        with pytest.raises(OptionError):
            mo.capacity(rocks, **options)
    with pytest.raises(NoLoadFactorError):
        mo.capacity(solved(block_on_floor(live=(0, -1)), "static"))
    curve = followed(block_on_floor(friction=3.0), steps=2)
    for row in (1000, "last"):
        for shown in (curve.plot, curve.joints, curve.poses):
            with pytest.raises(OptionError, match="there is no row"):
                shown(row)


@pytest.mark.slow
def test_the_command(command, tmp_path):
    case, picture = CASES / "oppenheim" / "seven_voussoirs.toml", tmp_path / "curve.svg"
    spectrum = tmp_path / "spectrum.csv"
    spectrum.write_text("# T, S_e\n" + "\n".join(f"{T},{a}" for T, a in SPECTRUM))
    record = command.json("capacity", case, "--steps", "8", "--plot", picture, "--spectrum", spectrum)
    assert picture.stat().st_size > 1000
    assert record["load_factor"] == pytest.approx(0.37, abs=1e-4)
    assert (record["reaches_zero"], record["end"]) == (True, {"code": "reaches zero"})
    assert record["displacement"] == record["curve"][-1]["displacement"] > 0
    events = [row["event"] for row in record["curve"] if row["event"]]
    assert events == ["joint opens", "joint closes", "reaches zero"]
    assert set(record["check"]) == set(mo.KinematicCheck.__dataclass_fields__)
    command("capacity", case, "--steps", "4", "--table")
    command("capacity", CASES / "gilbert" / "two_blocks.toml", code=1)
    spectrum.write_text("# T, S_e\n0,0.2\nT;S_e\n")
    assert "spectrum.csv: line 3:" in command.refused("capacity", case, "--spectrum", spectrum)
    for wrong in (["--point", "1"], ["--spectrum", "none"], ["--plot", "a.b"]):
        command.refused("capacity", case, *wrong)


@pytest.mark.slow
def test_pictures_show_the_curve_and_the_blocks_displaced(tmp_path):
    curve = followed(mo.load(CASES / "oppenheim" / "seven_voussoirs.toml"), steps=8)
    (axes,) = curve.plot().axes
    assert (axes.get_ylabel(), len(axes.lines[0].get_xdata())) == ("load factor λ", len(curve.table))
    drawn = curve.plot(row=-1).axes[0]
    corners = np.concatenate([path.vertices for group in drawn.collections for path in group.get_paths()])
    hinges = curve.joints(-1).query("state == 'hinged'")[["x", "y"]].to_numpy()
    apart = np.hypot(*(corners[None] - hinges[:, None]).transpose(2, 0, 1)).min(axis=1)
    assert apart.max() < 1e-9
    curve.save(tmp_path / "row.png", row=3)
    with pytest.raises(OptionError):
        curve.save(tmp_path / "row.html")
