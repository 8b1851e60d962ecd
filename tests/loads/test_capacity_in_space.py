"""Tests of the capacity curve in space: a body that turns about an edge, against the plane and closed
forms."""

import math

import numpy as np
import pytest
from mappings import turned
from scenes import CASES, block_on_floor, on_floor, solved
from scipy.optimize import brentq
from speeds import slow

import masonry_opt as mo
from masonry_opt.errors import OptionError
from masonry_opt.scene.blocks import rectangle
from masonry_opt.scene.solids import prism
from masonry_opt.solution.reasons import Code

SPECTRUM = ((0.0, 0.2), (0.15, 0.5), (4.0, 0.03))
#: Tolerance of curves against closed forms, and of the onset that a solver found.
CLOSE = 1e-9


def followed(scene: mo.Scene, steps: int = 10, **options) -> mo.Capacity:
    return mo.capacity(solved(scene, "static"), steps=steps, **options)


def courses() -> mo.Scene:
    wall = {"block": (0.6, 0.4), "courses": [[1]], "repeat": 6}
    blocks = mo.Wall(**wall, unit_weight=10.0, live_per_weight=(1, 0)).blocks()
    return mo.Scene(joints=mo.JointDefaults(friction=0.8), blocks=blocks)


@pytest.mark.slow
@pytest.mark.parametrize(
    "scene", [block_on_floor(0.6, 3.0, friction=3.0), courses()], ids=["block", "courses"]
)
def test_as_the_plane_s_on_extruded_scenes(scene):
    plane, space = followed(scene), followed(mo.extrude(scene, 0.5))
    assert space.load_factor == pytest.approx(plane.load_factor, abs=CLOSE)
    assert space.displacement == pytest.approx(plane.displacement, abs=CLOSE)
    assert space.end.code is Code.REACHES_ZERO
    assert space.table["rotation"].iloc[-1] == pytest.approx(plane.table["rotation"].iloc[-1], abs=CLOSE)
    for name in ("dead_work", "live_work"):
        works = [curve.table[name].iloc[-1] / np.abs(curve.dead.force).sum() for curve in (plane, space)]
        assert works[0] == pytest.approx(works[1], abs=CLOSE)
    checks = [curve.check(SPECTRUM) for curve in (plane, space)]
    numbers = ("mass_fraction", "acceleration", "displacement", "ultimate", "secant", "demand_acceleration")
    for name in numbers:
        # The rates in the plane are those of a linear program.
        assert getattr(checks[1], name) == pytest.approx(getattr(checks[0], name), rel=1e-7)
    (last,) = [row for row in space.joints().itertuples() if row.state == "hinged"]
    assert (last.x, last.z) == pytest.approx((0.6, 0.0), abs=CLOSE)
    assert last.angle == pytest.approx(space.table["rotation"].iloc[-1])
    assert {*space.joints()["state"]} <= {"hinged", "closed"}


@pytest.mark.parametrize("space", [False, True])
def test_every_state_is_reported(space):
    """The callback receives the number and λ of every state after the state at rest."""
    scene, reported = block_on_floor(0.6, 3.0, friction=3.0), []
    curve = followed(
        mo.extrude(scene, 0.5) if space else scene, progress=lambda *state: reported.append(state)
    )
    assert reported == [*enumerate(curve.table["load_factor"])][1:]


@pytest.mark.parametrize("option", ["presolve", "simplex_strategy"])
def test_statics_are_asked_again_with_other_options(failing, option):
    """If the simplex method fails on a static program, the program is solved without presolve, and then with
    the primal simplex method.

    The first failure occurred for a front of 91 stones, the second failure for a survey of 54 stones.
    """
    default, last = {"presolve": ("choose", "off"), "simplex_strategy": (1, 4)}[option]
    scene = mo.extrude(block_on_floor(0.6, 3.0, friction=3.0), 0.5)
    whole, asked = followed(scene), []

    def fails(session, _):
        asked.append(session._highs.getOptionValue(option)[1])
        return asked[-1] != last

    failing("highs", fails)
    again = mo.capacity(mo.solve(scene, "static", incremental=False), steps=10)
    assert {*asked} == {default, last}
    assert again.end.code is Code.REACHES_ZERO
    assert again.table["load_factor"].to_numpy() == pytest.approx(whole.table["load_factor"].to_numpy())


@pytest.mark.parametrize("plan", [*slow(0.0), 0.7], ids=["along x", "oblique"])
@pytest.mark.parametrize("strength", [None, 3.0])
def test_a_front_that_overturns(plan, strength):
    """λ of a front that overturns agrees with moments about its foot, for any direction in plan.

    λ W (h c + b s)/2 = W (b c − h s)/2 + T times the distance of the tie from the foot. The tie runs from
    height y on the back of the front to a point 4 behind. Its end on the front moves with the front.
    """
    b, h, t, W, y, far = 0.6, 3.0, 0.8, 40.0, 2.5, -4.0
    about = turned(plan)

    def at(x, across, up):
        return (*about((x, across)), up)

    foot, head = ([at(x, across, up) for x, across in ((0, 0), (b, 0), (b, t), (0, t))] for up in (0, h))
    front = mo.Solid(name="front", **prism(head, foot), weight=W)
    floor = mo.box("floor", (-9, 9), (-9, 9), (-1, 0), fixed=True)
    rod = {"between": ("front", "ground"), "at": (at(0, t / 2, y), at(far, t / 2, y))}
    ties = [] if strength is None else [mo.Tie(**rod, strength=strength)]
    made = {"joints": mo.JointDefaults(friction=2.0), "blocks": [front, floor], "ties": ties}
    push = {"direction": [*about((1, 0)), 0.0]}
    curve = followed(mo.Scene(**made, earthquake=push), block="front")
    theta, T = curve.table["rotation"].to_numpy(), strength or 0.0
    c, s = np.cos(theta), np.sin(theta)
    x, z = y * s - b * c, y * c + b * s  # Position of the anchor, from the foot.
    along = np.array([far - b - x, y - z]) / np.hypot(far - b - x, y - z)
    held = W * (b * c - h * s) / 2 + T * (x * along[1] - z * along[0])
    np.testing.assert_allclose(curve.table["load_factor"], held / (W * (h * c + b * s) / 2), atol=CLOSE)
    assert curve.load_factor == pytest.approx((W * b / 2 + T * y) / (W * h / 2), abs=CLOSE)
    found = curve.check(SPECTRUM)
    assert (found.mass_fraction, found.mass) == pytest.approx((1.0, W / 9.81), abs=1e-8)
    assert found.displacement == curve.displacement
    if strength is None:
        assert curve.displacement == pytest.approx(b / 2, abs=CLOSE)
        assert not found.struts
        return
    # At d*_u, the centroid of the front has moved by 0.4 of its displacement at λ = 0.
    turn = brentq(lambda a: b * (1 - np.cos(a)) / 2 + h * np.sin(a) / 2 - found.ultimate, 0, 0.5)
    x, z = y * np.sin(turn) - b * np.cos(turn), y * np.cos(turn) + b * np.sin(turn)
    (tie,) = found.struts
    assert tie.change == pytest.approx(np.hypot(x - far + b, z - y) + far, abs=1e-3 * tie.change)
    assert tie.share == pytest.approx(tie.change / -far)
    assert f"tie '{tie.name}' must lengthen by {tie.change:.4g} (" in str(found)


PARTS = {"A": (0, 1), "B": (1, 2)}


@pytest.mark.slow
def test_a_prestressed_tie_that_slackens_pulls_with_its_prestress():
    """A tie in front of a wall slackens and pulls the wall over with its prestress: λ = 0.5 − 0.1.

    A tie within the wall that never yields has no effect.
    """
    front = [
        mo.box(name, (0, 1), (0, 1), z, weight=0.5, live_per_weight=(1, 0, 0)) for name, z in PARTS.items()
    ]
    within = mo.Tie(between=("A", "B"), at=((0.5, 0.5, 0.5), (0.5, 0.5, 1.5)))
    floor = mo.box("floor", (-5, 9), (-1, 2), (-1, 0), fixed=True)
    tie = mo.Tie(between=("A", "ground"), at=((1, 0.5, 1), (5, 0.5, 1)), strength=9.0, prestress=0.1)
    made = mo.Scene(joints=mo.JointDefaults(friction=3.0), blocks=[*front, floor], ties=[tie, within])
    curve = followed(made)
    assert curve.load_factor == pytest.approx(0.5 - 0.1, abs=CLOSE)
    assert curve.reaches_zero


@pytest.mark.slow
def test_a_front_that_leaves_its_returns():
    """A front leaves its return walls as if they were not there, if its state is that of Coulomb friction.

    With associative flow, the front drags on the return walls, and the curve is refused because joints slide.
    """
    sides = {"left": (0, 0.6), "right": (3.4, 4)}
    push = {"unit_weight": 18, "live_per_weight": (1, 0, 0)}
    blocks = [mo.box("front", (0, 0.6), (0, 4), (0, 6), **push)]
    blocks += [mo.box(name, (-3, 0), y, (0, 6), **push) for name, y in sides.items()]
    ground = mo.box("ground floor", (-6, 9), (-1, 5), (-1, 0), fixed=True)
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=[*blocks, ground])
    curve = mo.capacity(mo.solve(scene, incremental=False), steps=4, block="front")
    assert (curve.load_factor, curve.displacement) == pytest.approx((0.6 / 6, 0.6 / 2), abs=CLOSE)
    states = {
        frozenset(pair): state for *pair, state in curve.joints()[["first", "second", "state"]].to_numpy()
    }
    assert {states[frozenset(("front", name))] for name in sides} == {"separated"}
    with pytest.raises(OptionError, match="joints slide: 'front'"):
        followed(scene)


def topped() -> mo.Scene:
    """Return two stacked blocks with a load near the edge of the upper one: their joint opens as they
    lean."""
    push = {"live_per_weight": (1, 0)}
    low = mo.Block(name="low", vertices=rectangle(0, 1, 0, 2), weight=10, **push)
    on_it = {"weight": 1, "dead": (0, -1), "dead_at": (0.9, 3)} | push
    return on_floor(low, mo.Block(name="up", vertices=rectangle(0.5, 1, 2, 3), **on_it), friction=5.0)


@pytest.mark.slow
def test_it_ends_before_the_state_at_which_another_joint_opens():
    """In space the curve ends one step before another joint opens; in the plane it continues after this
    state."""
    plane, space = followed(topped()), followed(mo.extrude(topped(), 0.5), steps=40)
    opens = plane.table.loc[plane.table["event"] == "joint opens", "displacement"].iloc[0]
    assert space.end.code is Code.JOINT_OPENS
    assert [{*pair} for pair in space.end.values["pairs"]] == [{"low", "up"}]
    last, step = space.table["displacement"].iloc[-1], space.table["displacement"].iloc[1]
    assert last < opens < last + 1.1 * step
    assert space.displacement is None


def test_what_does_not_turn_about_one_edge_is_refused_by_name():
    frame = mo.load(CASES / "makris_vassiliou" / "rocking_frame.toml")
    for scene, words in (
        (block_on_floor(friction=0.1), "joints slide: 'A'–'floor'"),
        (frame, "several bodies move"),
    ):
        with pytest.raises(OptionError, match=words):
            followed(mo.extrude(scene, 0.5))
    with pytest.raises(OptionError, match="three numbers"):
        followed(mo.extrude(block_on_floor(friction=3.0), 0.5), block="A", point=(0, 1))


@pytest.mark.slow
def test_the_command_and_pictures(command, tmp_path):
    case, picture = CASES / "space" / "pushed_box.toml", tmp_path / "row.png"
    record = command.json("capacity", case, "--steps", "4")
    assert record["displacement"] == pytest.approx(0.4, abs=CLOSE)
    followed(mo.load(case), steps=4).save(picture, row=3)
    assert picture.stat().st_size > 1000


@pytest.mark.slow
@pytest.mark.parametrize(
    ("live", "up", "friction"), [((1, 0, 0), 0.22, 1.5), ((1, 0, 0), 0.22, 20.0), ((1, 0, -0.3), -0.1, 20.0)]
)
def test_a_load_that_comes_to_lead_through_the_edge(live, up, friction):
    """λ grows without limit up to the rotation at which the load passes through the edge.

    The third block stays on the edge up to this rotation, and the curve ends locked. The first two slide on
    the edge before.
    """
    base, top = mo.box("base", (0, 1), (0, 1), (-1, 0), fixed=True), ("T", (0, 1.6), (0, 1), (0, 1))
    joints, load = mo.JointDefaults(friction=friction), mo.Load(block="T", live=live, at=(1.6, 0.5, up))
    curve = followed(mo.Scene(joints=joints, blocks=[base, mo.box(*top, weight=1.6)], loads=[load]), steps=40)
    turn = curve.table["rotation"].to_numpy()
    through = math.atan(up / 0.6) + math.atan(-live[2])
    theta = np.append(turn, min(turn[-1] + turn[1], through - 1e-5))
    c, s = np.cos(theta), np.sin(theta)
    load_factor = 1.6 * (0.2 * c - 0.5 * s) / (up * c - 0.6 * s - live[2] * (0.6 * c + up * s))
    np.testing.assert_allclose(curve.table["load_factor"], load_factor[:-1], rtol=1e-8)
    onto = 1.6 - load_factor * live[2]
    holds = load_factor * c + onto * s <= friction * (onto * c - load_factor * s)
    assert holds[:-1].all()
    if live[2]:
        assert (curve.end.code, holds[-1]) == (Code.LOCKS, True)
        assert turn[-1] == pytest.approx(through, rel=2e-3)
    else:
        assert (curve.end.code, holds[-1]) == (Code.JOINTS_SLIDE, False)
        assert [{*pair} for pair in curve.end.values["pairs"]] == [{"T", "base"}]
