"""Tests of supports that settle: reactions by hand, in the plane and in space."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from mappings import mapped, turned
from scenes import CASES, block_between_walls

import masonry_opt as mo
from masonry_opt.scene.blocks import rectangle
from masonry_opt.solution.reasons import Status
from masonry_opt.studies.settle.bound import Bound

DOWN = (0.0, -1.0)
RIGHT = (1.0, 0.0)
#: Tolerance of reactions, relative to the weight of all blocks: the error that solvers leave.
CLOSE = 1e-7


def block(name: str, left: float, right: float, bottom: float, top: float, **keys: object) -> mo.Block:
    return mo.Block(name=name, vertices=rectangle(left, right, bottom, top), **keys)


def beam(friction: float = 0.6, weight: float = 10.0, **given: object) -> mo.Scene:
    """Return a beam of 5 × 1 on piers at its ends, whose tops are 1 wide; the weight of a pier does not
    count."""
    blocks = [
        block("L", 0, 1, 0, 1, fixed=True),
        block("R", 4, 5, 0, 1, fixed=True, weight=7.0),
        block("beam", 0, 5, 1, 2, weight=weight, **given),
    ]
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=blocks)


def reactions(found: mo.Settlement) -> list[float]:
    """Return the reaction by the method asked, the incremental and the associative one, of the least and
    greatest end."""
    ends = (found.least, found.greatest)
    return [value for end in ends for value in (end.reaction, end.incremental, end.associative)]


def one_answer(least: float, greatest: float, weight: float = 10.0) -> object:
    return pytest.approx([least] * 3 + [greatest] * 3, abs=CLOSE * weight)


#: Remark on a reaction if other exact states may have a reaction closer to the reaction at rest.
NOT_PROVEN = (
    "this reaction is not proven to be the limit: other exact states may have a reaction closer to the "
    "reaction at rest"
)

IN_BOTH = pytest.mark.parametrize(
    "in_space", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["plane", "space"]
)


@pytest.mark.slow
@IN_BOTH
def test_a_beam_on_two_piers(in_space):
    """The reactions of R agree with moments by hand, in the plane and in space.

    As R settles, the beam turns about the inner edge of L (x = 1) and touches R only at its outer edge
    (x = 5): 4 R = 1.5 W. As R is pushed up, the beam turns about the outer edge of L and touches R at its
    inner edge: 4 R = 2.5 W.
    """
    scene, down = (mo.extrude(beam(), 1.5), (0, 0, -1)) if in_space else (beam(), DOWN)
    found = mo.settle(scene, "R", down)
    assert found.status is Status.STABLE
    assert found.usable
    assert reactions(found) == one_answer(3.75, 6.25)
    assert found.at_rest == pytest.approx(5.0)
    assert set(found.least.rows()[0]["moves"]) == {"beam", "R"}
    for kind, of in found.least.results.items():
        assert of.certificate is not None, kind
    # In the opposite direction the reaction has the opposite sign, and the least is the greatest.
    back = mo.settle(scene, "R", tuple(-part for part in down))
    assert reactions(back) == one_answer(-6.25, -3.75)


@pytest.mark.slow
@IN_BOTH
def test_a_pier_that_turns_too(in_space):
    """The reactions of a pier that can also rotate agree with moments by hand.

    The force of the beam on R passes through the centroid of R at x = 4.5, 0.5 below the joint. Shear moves
    the point of action in the joint away from x = 4.5. The shear is at most 0.6 of the lesser normal force.
    Least: R (4.5 + 0.3 − 1) = 1.5 W. Greatest, if L slides: 4.5 R − 0.5 · 0.6 (W − R) = 2.5 W.
    """
    scene, down = (mo.extrude(beam(), 1.5), (0, 0, -1)) if in_space else (beam(), DOWN)
    found = mo.settle(scene, "R", down, turns=True)
    assert reactions(found) == one_answer(15 / 3.8, 28 / 4.8)


def with_solution(end: Bound, **changes: object) -> Bound:
    """Return the end with changes to the solution of the method asked."""
    return replace(end, result=replace(end.result, solution=replace(end.result.solution, **changes)))


@pytest.mark.slow
def test_what_is_known_of_each_reaction():
    """The table and the command line state the certainty of each reaction: it is called the limit only if
    proven."""
    found = mo.settle(beam(), "R", RIGHT)
    known = found.table.set_index(["end", "kind"])["certainty"]
    for end in ("least", "greatest"):
        assert NOT_PROVEN in known[end, "coulomb"]
        assert "equilibrium is lost" in known[end, "incremental"]
        furthest = "in this direction of movement, no state has a reaction farther from the reaction at rest"
        assert known[end, "associative"] == furthest
        first, *others = found.facts()[end].splitlines()
        assert "(found, not proven)" in first
        assert [line.split()[0] for line in others[1:]] == ["incremental", "associative"]
    assert found.warning_sentences == ()
    assert found.facts()["reactions"] == "in the force unit of the case"
    assert found.facts()["at rest"].endswith("with elastic contacts")
    proven = with_solution(found.least, is_only_state=True)
    certainty = proven.rows()[0]["certainty"]
    assert certainty.endswith("proven: no other exact state has a reaction closer to the reaction at rest")
    assert "(proven)" in replace(found, least=proven).facts()["least"]
    by_statics = mo.settle(beam(), "R", RIGHT, method="static").facts()["least"]
    assert by_statics.splitlines()[0].startswith("-3 (associative)")


@pytest.mark.slow
def test_states_nearer_to_rest_and_across_it_are_warned_of():
    """Warnings report a load history that ends nearer to rest, and a state on the other side of rest.

    The load history is made to end at half the reaction that was found, and the state to lie beyond the
    reaction at rest.
    """
    found = mo.settle(beam(), "R", RIGHT)
    least, half = found.least, 0.5 * found.least.result.load_factor
    history = least.result.solution.incremental
    ended = replace(history, state=replace(history.state, load_factor=half), peak=None)
    nearer = replace(found, least=with_solution(least, incremental=ended))
    (warning,) = nearer.as_dict()["warnings"]
    assert (warning["code"], warning["end"]) == ("history ends nearer", "least")
    assert [warning["reaction"], warning["incremental"]] == pytest.approx([-2.25, -1.125], abs=1e-6)
    assert "may collapse before the computed value is reached" in warning["sentence"]
    beyond = replace(found, least=with_solution(least, below_zero=-half))
    (warning,) = beyond.as_dict()["warnings"]
    assert (warning["code"], warning["end"]) == ("state across rest", "least")
    assert [warning["reaction"], warning["at_rest"]] == pytest.approx([1.125, 0.0], abs=1e-6)
    assert "the scene would fall" in warning["sentence"]


@pytest.mark.slow
def test_piers_that_settle_alike_bear_the_weight():
    assert reactions(mo.settle(beam(), ["L", "R"], (0, -3))) == one_answer(10, 10)


@pytest.mark.slow
def test_a_pier_pulled_away_under_a_beam():
    """The reactions of a pier that is pulled away are friction forces by hand.

    With associative flow, friction on both piers acts, under half of the weight each: μ W / 2. Without
    dilatancy, R slides off under its least normal force, 3.75, or under any force up to W / 2.
    """
    found = mo.settle(beam(), "R", RIGHT)
    assert found.at_rest == pytest.approx(0.0, abs=1e-9)
    for end, sign in ((found.least, -1), (found.greatest, 1)):
        assert end.associative == pytest.approx(sign * 0.6 * 5.0, abs=1e-6)
        assert end.reaction == pytest.approx(sign * 0.6 * 3.75, abs=1e-6)
        assert 0.6 * 3.75 < sign * end.incremental < 0.6 * 5.0


def rafters() -> mo.Scene:
    """Return two rafters that lean on each other, with joints of length 0.5 at the crown and at the feet."""
    left = [(-2.5, 0), (-2, 0), (0, 1.5), (0, 2)]
    blocks = [
        mo.Block(name="left", vertices=left, weight=3),
        mo.Block(name="right", vertices=[(-x, y) for x, y in left[::-1]], weight=3),
        block("L", -3, -1.5, -1, 0, fixed=True),
        block("R", 1.5, 3, -1, 0, fixed=True),
    ]
    return mo.Scene(joints=mo.JointDefaults(friction=2.0), blocks=blocks)


@pytest.mark.slow
@IN_BOTH
def test_openings_of_three_hinges(tmp_path, in_space):
    """The openings of a frame with three hinges agree with geometry by hand.

    The hinges are at the inner edges of the feet, 4 apart, and at the upper end of the crown joint, 2 above.
    As R moves by 1, each half turns by 1 / (2 · 2). The joints at the feet are 0.5 long and open by 0.5 / 4,
    and the joint at the crown opens by twice as much.
    """
    scene, right = (mo.extrude(rafters(), 0.8), (1, 0, 0)) if in_space else (rafters(), RIGHT)
    found = mo.settle(scene, "R", right, method="static")
    frame = found.openings
    assert frame["opening"].tolist() == pytest.approx([0.25, 0.125, 0.125], rel=1e-6)
    assert not frame["sliding"].any()
    assert [{*pair} for pair in frame[["first", "second"]].to_numpy()[:1]] == [{"left", "right"}]
    assert frame.loc[0, ["x", "z" if in_space else "y"]].tolist() == pytest.approx([0, 1.5], abs=1e-9)
    assert found.least.result.joints.loc[frame["joint"], "first"].tolist() == frame["first"].tolist()
    assert "'left'–'right' 0.25" in str(found)
    record = json.loads(found.to_json())["least"]["openings"]
    assert [row["opening"] for row in record] == frame["opening"].tolist()
    written = [text.get_text() for axes in found.plot().axes for text in axes.texts]
    assert written.count("0.125") == 2
    moved = mo.settle(scene, "R", right, method="static", movement=0.02).plot()
    written = [text.get_text() for axes in moved.axes for text in axes.texts]
    assert written.count("0.0025") == 2
    assert "after a movement of 0.02" in " ".join(text.get_text() for text in moved.texts).replace("\n", " ")
    found.save(tmp_path / "a.html")
    assert "Lengths and forces are in the units of the case." in (tmp_path / "a.html").read_text("utf-8")
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert "Openings per unit of support movement, at the least reaction" in page
    assert "_at_movement" not in page  # the headings are words
    # The lines of a text stay apart: states of the least reaction, each on a line of its own.
    assert "white-space: pre-line" in page


@pytest.mark.slow
def test_openings_of_a_beam_that_turns_or_slides():
    """The openings of a beam that turns or slides agree with geometry by hand.

    As R settles by 1, the beam turns by 1 / 4 about x = 1 and touches R at x = 5 only. In the opposite
    direction, it turns by as much about x = 0 and touches R at x = 4. If R is pulled away, it slides by 1.
    """
    found = mo.settle(beam(), "R", DOWN)
    for end in found.ends.values():
        assert end.openings["opening"].tolist() == pytest.approx([0.25, 0.25], rel=1e-6)
    assert sorted(found.openings["x"]) == pytest.approx([0, 4])
    assert sorted(found.greatest.openings["x"]) == pytest.approx([1, 5])
    slid = mo.settle(beam(), "R", RIGHT).openings
    assert slid[["opening", "sliding"]].to_numpy().tolist() == [pytest.approx([0, 1], abs=1e-6)]


def wedged(*floor: mo.Block) -> mo.Scene:
    """Return a block of weight 10 between two walls."""
    walls = [block("L", -1, 0, -1, 1, fixed=True), block("R", 1, 2, -1, 1, fixed=True)]
    return mo.Scene(
        joints=mo.JointDefaults(friction=0.6), blocks=[*walls, *floor, block("A", 0, 1, 0, 1, weight=10)]
    )


@pytest.mark.slow
def test_coordinates_of_an_arch_that_begin_at_zero_are_zero():
    """The joints at the abutments are at y = 0, but the trigonometric functions of the arch yield 1e-15."""
    found = mo.settle(f"{CASES}/casapulla_lauro/arch.toml", "abutment 2", RIGHT, method="static")
    at_abutments = found.greatest.openings.query("second.str.startswith('abutment')")
    assert at_abutments["x"].abs().tolist() == pytest.approx([9.45, 9.45])
    assert at_abutments["y"].tolist() == [0.0, 0.0]
    result = found.least.result
    assert result.joints.query("second.str.startswith('abutment')")["y"].tolist() == [0.0, 0.0]
    assert result.blocks.set_index("block").loc["v14", "x"] == 0.0


def test_a_reaction_without_limit_is_said_to_be_so():
    found = mo.settle(wedged(block("floor", 0, 1, -1, 0, fixed=True)), "R", RIGHT)
    assert found.least.associative == pytest.approx(0.0, abs=1e-6)
    assert found.greatest.reaction is found.greatest.associative is None
    assert found.greatest.unlimited
    assert found.greatest.result.status is Status.UNLIMITED
    assert found.usable
    table = found.table.set_index(["end", "kind"])
    assert math.isnan(table.loc[("greatest", "associative"), "reaction"])
    assert not found.least.unlimited


def test_a_necessary_reaction_is_above_zero():
    """A block that hangs between two walls by friction needs the reaction R = W/(2 μ)."""
    found = mo.settle(wedged(), "R", RIGHT, method="static")
    assert found.least.reaction == found.least.associative == pytest.approx(10 / 1.2, abs=1e-6)
    assert found.least.incremental is None
    assert list(found.least.results) == ["associative"]
    assert found.greatest.unlimited


def test_a_scene_that_no_reaction_holds(tmp_path, command):
    """No reaction holds a beam that extends beyond both piers by more than half of its length."""
    scene = beam().replace(blocks={"R": {"vertices": rectangle(1.2, 1.4, 0, 1)}})
    found = mo.settle(scene, "R", DOWN)
    assert found.status is Status.UNSTABLE
    assert not found.usable
    assert found.least is found.greatest is None
    assert len(found.table) == 0
    assert [*found.fallen.reasons[0].values["blocks"]] == ["beam"]
    found.save(tmp_path / "falls.html")
    mo.save(scene, tmp_path / "falls.toml")
    asked = ("settle", tmp_path / "falls.toml", "--support", "R", "--direction", "0,-1")
    record = command.json(*asked, code=1)
    assert record["least"] is record["greatest"] is None
    assert record["fallen"]["reasons"][0]["code"] == "falls"


def test_an_arch_that_no_reaction_through_the_centroid_holds():
    """No friction holds an arch if the reaction of its support must pass through the support's centroid.

    No block is reported as hanging, because the support that turns carries the arch.
    """
    found = mo.settle("cases/casapulla_lauro/arch.toml", "abutment 2", RIGHT, turns=True)
    assert found.status is Status.UNSTABLE
    assert found.at_rest is None
    assert [reason.code for reason in found.fallen.reasons] == ["falls", "no friction holds"]


def table(**keys: object) -> mo.Scene:
    """Return a slab of weight 12 on four legs of 0.4 × 0.4, whose inner edges are 2.6 and 1.6 apart."""
    legs = [
        mo.Solid(name=f"{x}{y}", box=[[3 * x, 3 * x + 0.4], [2 * y, 2 * y + 0.4], [0, 1]], fixed=True)
        for x in (0, 1)
        for y in (0, 1)
    ]
    slab = mo.Solid(name="slab", box=[[0, 3.4], [0, 2.4], [1, 1.3]], weight=12, **keys)
    return mo.Scene(joints=mo.JointDefaults(friction=0.6), blocks=[*legs, slab])


@pytest.mark.slow
def test_legs_of_a_table():
    """The reactions of legs of a table agree with moments by hand.

    The least reaction of one leg is zero. Its reaction is greatest if its neighbour along x carries nothing:
    about the outer edges of the far legs, 3 R = 1.7 W. Two legs at one end share the reaction of a pier, from
    3 R = (1.7 − 0.4) W to 3 R = 1.7 W.
    """
    down = (0, 0, -1)
    assert reactions(mo.settle(table(), "11", down)) == one_answer(0.0, 6.8, 12)
    assert reactions(mo.settle(table(), ["00", "01", "10", "11"], down)) == one_answer(12, 12, 12)
    both = mo.settle(table(), ["10", "11"], down)
    assert reactions(both) == one_answer(5.2, 6.8, 12)
    speeds = both.least.result.blocks.set_index("block").loc[["10", "11"]]
    assert speeds["vz"].nunique() == 1 or np.ptp(speeds["vz"]) < 1e-9
    assert np.abs(speeds[["vx", "vy", "wx", "wy", "wz"]].to_numpy()).max() < 1e-9


@pytest.mark.slow
def test_live_loads_of_the_scene_are_left_out_and_dead_ones_kept():
    loaded = beam(live=(3.0, 0.0), live_per_weight=(1.0, 0.0), dead=(0.0, -10.0), dead_at=(2.5, 1.5))
    more = mo.Load(block="beam", live=(0.0, 5.0), dead=(0.0, -10.0))
    edge = mo.EdgeLoad(start=(0, 2), end=(5, 2), force=(0.0, 1.0), kind="live")
    scene = loaded.replace(loads=[more], edge_loads=[edge])
    assert reactions(mo.settle(scene, "R", DOWN)) == one_answer(3 * 3.75, 3 * 6.25, 30)


@pytest.mark.slow
def test_dead_loads_of_a_load_case_act():
    case = {"name": "full", "dead": {"weight": 1.0, "floor": 2.0}, "live": {"live": 1.0}}
    floor = mo.Load(block="beam", live=(0.0, -5.0), group="floor")
    scene = beam(live=(1.0, 0.0)).replace(loads=[floor], load_cases=[case])
    found = mo.settle(scene, "R", DOWN, load_case="full")
    assert reactions(found) == one_answer(2 * 3.75, 2 * 6.25, 20)
    assert found.plot()
    with pytest.raises(mo.OptionError, match="has load cases"):
        mo.settle(scene, "R", DOWN)


@pytest.mark.slow
def test_a_load_on_a_support_is_left_to_the_ground():
    """A line load acts on the beam and on a shoulder of R, and the share of the shoulder does not count."""
    shoulder = [(4, 0), (7, 0), (7, 2), (5.5, 2), (5.5, 1), (4, 1)]
    line = mo.EdgeLoad(start=(0, 2), end=(7, 2), pressure=2.0)
    scene = beam().replace(blocks={"R": {"vertices": shoulder}}, edge_loads=[line])
    found = mo.settle(scene, "R", DOWN)
    # The beam still ends at x = 5.
    assert reactions(found) == one_answer(2 * 3.75, 2 * 6.25, 20)
    assert found.at_rest == pytest.approx(10.0)


@pytest.mark.slow
def test_turned_and_in_other_units():
    """Reactions do not depend on axes and units: the scene is rotated by 0.7 rad, with lengths × 1e3 and
    forces × 1e6."""
    turn, direction, factor = turned(0.7), (1.0, -1.0), 1e6
    given = beam()
    other = mapped(given, lambda v: turn((1e3 * v[0], 1e3 * v[1])), turn, dead=factor, length=1e3)
    of = np.array(reactions(mo.settle(other, "R", turn(direction)))) / factor
    # The incremental analysis reaches its plateau only to within 0.3 %.
    same = reactions(mo.settle(given, "R", direction))
    assert of[[0, 2, 3, 5]] == pytest.approx([same[k] for k in (0, 2, 3, 5)], abs=1e-6)
    assert of[[1, 4]] == pytest.approx([same[1], same[4]], abs=3e-3 * 10)


@pytest.mark.slow
def test_a_tie_between_support_and_beam():
    """The reactions of R agree with moments by hand if a tie between R and the beam yields at T.

    The tie is at x = 4.5. The normal force N follows from 4 N = 1.5 W + 3.5 T or 2.5 W + 4.5 T, and
    R = N − T.
    """
    rod = mo.Tie(between=("R", "beam"), at=((4.5, 0.5), (4.5, 1.5)), strength=1.0)
    found = mo.settle(beam().replace(ties=[rod]), "R", DOWN)
    assert reactions(found) == one_answer(18.5 / 4 - 1, 29.5 / 4 - 1)
    assert bool(found.least.result.ties.loc[0, "yields"])


@pytest.mark.parametrize(
    ("support", "direction", "said"),
    [
        ("Q", DOWN, "no block 'Q'"),
        ("Rr", DOWN, "did you mean 'R'"),
        ("beam", DOWN, "is not a support"),
        ("R", (0, 0), "not all of them zero"),
        ("R", (0, 0, -1), "two numbers"),
        ("R", (0, float("nan")), "two numbers"),
        ("R", "down", "two numbers"),
        ("R", None, "two numbers"),
        ("far", DOWN, "touches no block"),
        (["R", "R"], DOWN, "once"),
        ([], DOWN, "once"),
    ],
)
def test_wrong_supports_and_directions(support, direction, said):
    far = block("far", 20, 21, 0, 1, fixed=True)
    scene = beam().replace(blocks=[*beam().blocks, far])
    with pytest.raises(mo.OptionError, match=said):
        mo.settle(scene, support, direction)


def test_wrong_direction_in_space_and_wrong_options():
    with pytest.raises(mo.OptionError, match="three numbers"):
        mo.settle(table(), "11", DOWN)
    with pytest.raises(mo.OptionError, match="no option 'speed'"):
        mo.settle(beam(), "R", DOWN, speed=1)
    found = mo.settle(beam(), "R", DOWN, method="static")
    with pytest.raises(mo.OptionError, match="'least' or 'greatest'"):
        found.plot(end="middle")
    with pytest.raises(mo.OptionError, match="choose from associative"):
        found.plot(kind="coulomb")


@pytest.mark.slow
def test_command_and_files(tmp_path, command):
    mo.save(beam(), tmp_path / "beam.toml")
    asked = ("settle", tmp_path / "beam.toml", "--support", "R", "--direction", "0,-1")
    record = command.json(*asked, "--plot", tmp_path / "beam.html")
    assert record["status"] == "stable"
    assert record["usable"] is True
    assert record["supports"] == ["R"]
    assert [record["least"]["reaction"], record["greatest"]["incremental"]] == pytest.approx([3.75, 6.25])
    assert set(record["least"]["results"]) == {"coulomb", "incremental", "associative"}
    assert record["least"]["results"]["coulomb"]["certificate"]
    page = (tmp_path / "beam.html").read_text(encoding="utf-8")
    assert page.count("data:image/svg+xml") == 2
    for name, more in (("least.png", ()), ("greatest.svg", ["--greatest"])):
        command(*asked, "--method", "static", "--plot", tmp_path / name, *more)
        assert (tmp_path / name).stat().st_size > 1000
    for wrong in (("--greatest",), ("--plot", tmp_path / "a.txt"), ("--direction", "down")):
        command.refused(*asked, *wrong)


def test_a_result_whose_support_settles_has_no_capacity_curve():
    result = mo.settle(beam(), "R", (0, -1), method="static").least.result
    with pytest.raises(mo.OptionError, match="while a support settles: call"):
        mo.capacity(result)


@pytest.mark.filterwarnings("error")
def test_a_mechanism_in_which_no_support_moves_has_no_openings():
    """A block of weight 4 hangs between two walls with μ = 2. It slides down if the walls press it with less
    than 4 / (2 μ) = 1. The walls do not move in this mechanism."""
    settled = mo.settle(block_between_walls(2.0), "left", direction=(-1, 0))
    assert settled.least.reaction == pytest.approx(1.0, rel=1e-6)
    assert not len(settled.openings)
    facts = settled.facts()
    assert facts["openings"].startswith("none, because no support moves")
    assert facts["at rest"].startswith("not found: blocks at rest")
