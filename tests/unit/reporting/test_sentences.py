"""Every reason has a sentence, results list their facts by labels, and both use the right words in space."""

import json
import math
import re
from dataclasses import replace
from math import inf

import numpy as np
import pytest
from atlas.small_scenes import pebble
from drawn import labels
from mappings import mapped, mirrored
from scenes import CASES, block_on_floor, overhanging, pressed_down, small_wall, two_blocks
from scenes_in_space import box_on_floor
from speeds import slow

import masonry_opt as mo
from masonry_opt.drawing.elements import result_elements
from masonry_opt.drawing.page import page
from masonry_opt.methods.registry import METHODS
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.laws import BY_FACES
from masonry_opt.reporting.load_factors import certainty, own_name
from masonry_opt.reporting.sentences import message, numeral, sentences
from masonry_opt.reporting.summary import facts, motion
from masonry_opt.solution.answer import FinalState
from masonry_opt.solution.reasons import Code, reason, size_of
from masonry_opt.solution.sense import warnings_of
from masonry_opt.solvers.registry import SOLVERS

#: A value for each name that a reason can have, as in a result of `solve`.
VALUES = {
    "above": 1.44, "against": False, "associative": 0.6, "backing": True, "beside": "blocks", "carried": 0.4,
    "aligning": 0.003, "blocks": ["A"], "bound": 0.25, "by": 1e-6, "candidates": 12, "count": 7,
    "dilatancy": -2.0, "distance": 120.0, "draws": 12, "elastic": 0.9,
    "epsilon": 3e-9, "exact": True, "factor": 1.4434, "fall": 1e-3, "fill": 1,
    "first": str(mo.Status.CYCLING), "fixed": True, "forces": True, "friction": 0.5, "friction_angle": 0.6,
    "gap": 1e-4, "hangs": False, "highest": 0.5, "in_vain": False, "interrupted": True, "joints": 9000,
    "key": "strength", "kind": "tie", "kinematic_cuts": 1, "least": 0.4, "jumps": 2,
    "length": 0.5, "load": "dead", "load_factor": 0.5, "looped": False, "lowest": 0.4, "median": 22.0,
    "unique": False,
    "most": 0.6, "name": "rod", "names": ["lorry"], "not_carried": 0.5, "normal_forces": [12.5],
    "number": 3, "off": 0.1, "option": "contact_tolerance",
    "other": 22.0, "pairs": [["A", "B"]], "per_area": True, "period": 2, "rates": 100.0, "ratio": 1000.0,
    "remedies": ["beta=0.3"], "residuals": {"flow": 0.1}, "searched": False, "size": 3.0, "slip": 0.5,
    "scatter": 3.0, "states": 21,
    "static_cuts": 2, "status": str(mo.Status.LOCKED), "steps": 27, "stiffness": (0.4, 0.5), "stress": None,
    "time_limit": 60.0, "seconds": 20.0, "phase": "further starts", "last": 0.5,
    "gravity": 9.81, "extent": 3000.0,
    "unit_weight": 18.0, "value": 20.0, "weight": 1e8, "widths": [1e-3], "without": 1,
    "word": "unknown", "angle": 1e-3, "tolerance": 1e-3, "turn": 2e-3, "wedge": 0.01,
}  # fmt: skip


#: Number of solvers that a user of each method can choose from.
SOLVER_COUNT = {
    name: sum(method.solved_by(entry) for entry in SOLVERS.values()) for name, method in METHODS.items()
}


@pytest.mark.parametrize("code", Code)
def test_every_code_has_a_sentence(code):
    sentence = message([reason(code, **VALUES)])
    assert len(sentence.split()) >= 3
    assert not re.search(r"[{}]|\bNone\b|Code\.", sentence)


#: Methods whose results can have these codes. All other codes can occur with every method.
ONLY_OF = {
    Code.NOT_COMPUTED: {"coulomb", "nonassociative", "mpec", "global"},
    Code.NOT_HINGING: {"coulomb"},
    Code.NO_EXACT_STATE: {"global"},
    Code.NO_TIME: {"coulomb"},
    Code.NOTHING_SOLVED: {"mpec"},
    Code.FORCES_UNDECIDED: set(),
    Code.DILATANCY_LOCKS: {"static", "kinematic", "nonassociative", "coulomb"},
    Code.SOLVER_STOPPED: {"static", "kinematic", "nonassociative", "coulomb"},
}


@pytest.mark.parametrize("looped", [False, True])
@pytest.mark.parametrize("code", Code)
def test_advice_is_possible_and_not_followed_already(code, looped):
    """The advice in a sentence names neither the method that ended nor an unknown method. Each option that it
    names belongs to the method that ended or to a method that the sentence names."""
    options = {name: set(of.options.model_fields) if of.options else set() for name, of in METHODS.items()}
    for method in ONLY_OF.get(code, METHODS):
        sentence = message([reason(code, **VALUES | {"looped": looped, "exact": False})], method)
        others = re.findall(r"method '(\w+)'", sentence)
        assert set(others) <= set(METHODS) - {method}
        named = set(re.findall(r"'(\w+)'", sentence)) & set().union(*options.values())
        assert named <= set().union(*(options[name] for name in [method, *others]))
        if re.search(r"try another solver|solver can be chosen|choose", sentence):
            assert max(SOLVER_COUNT[name] for name in [method, *others]) > 1


#: Reasons with numbers or names that need formatting, and their sentences, by code.
WORDS = {
    Code.FALLS: (
        reason(Code.FALLS, blocks=["A", "B"]),
        "the dead load alone moves blocks 'A', 'B': support the falling blocks",
    ),
    Code.FRICTION_WOULD_HOLD: (
        reason(Code.FRICTION_WOULD_HOLD, pairs=[["A", "B"]], factor=1.44341, above=1.443, hangs=False),
        "'A'–'B' slides: the scene would be stable if the friction of all joints were at least 1.444 times "
        "as high",
    ),
    Code.PROVEN: (
        reason(Code.PROVEN, bound=-0.0, load_factor=-3e-17, rates=None, forces=False),
        "the least λ is proven: 0 ≤ λ ≤ 0",
    ),
    Code.JOINTS: (
        reason(Code.JOINTS, status=str(mo.Status.UNLIMITED), pairs=[[f"{n}", "X"] for n in range(8)]),
        "joints that carry the live load: '0'–'X', '1'–'X', '2'–'X', '3'–'X', '4'–'X' and 3 more",
    ),
    Code.CURVE: (
        reason(Code.CURVE, states=12, jumps=1),
        "load–displacement curve under an increasing load, in 12 load steps; 1 jump to another equilibrium, "
        "under constant load",
    ),
    Code.SPREAD: (
        reason(Code.SPREAD, draws=12, stiffness=(0.15, 0.25), stress=None, without=13),
        "the incremental λ is 0.15–0.25 with random stiffness of contacts, and none with random self-stress, "
        "in 12 draws each (13 of these load histories led to no collapse)",
    ),
}


@pytest.mark.parametrize("code", WORDS)
def test_words(code):
    given, words = WORDS[code]
    assert message([given]) == words


def test_each_part_that_the_time_limit_ended_has_a_line():
    solved = mo.solve(block_on_floor(), "static")
    ends = [
        reason(Code.TIME_LIMIT, seconds=7.0, phase=phase, carried=None, last=None)
        for phase in ("search", "search", "incremental analysis")
    ]
    stopped = replace(solved, solution=replace(solved.solution, reasons=tuple(ends)))
    first, second = facts(stopped)["time limit"].split("\n")
    assert first.endswith("raise the time limit")
    assert "incremental analysis" in second


def test_several_reasons_are_one_message():
    result = mo.solve(two_blocks(), "nonassociative", max_iterations=2, remedies="none")
    assert len(result.reasons) == 2
    assert result.message == "; ".join(message([reason], result.method) for reason in result.reasons)
    assert mo.solve(two_blocks(), "static").message == ""


@pytest.mark.parametrize(
    ("value", "spec", "text"),
    [
        *((-0.0, ".6g", "0"), (-0.0, "g", "0"), (-0.0, ".1e", "0"), (-4e-8, ".7f", "0.0000000")),
        *((-4e-4, "+.3f", "0.000"), (4e-4, "+.3f", "0.000"), (0.01, "+.3f", "+0.010")),
        *(
            (-6e-8, ".7f", "-0.0000001"),
            (-1e-17, ".6g", "-1e-17"),
            (-inf, ".6g", "-inf"),
            (inf, ".7f", "inf"),
        ),
        *((1234567.25, ".7f", "1234567.2500000"), (1.5e300, ".7f", "1.5000000e+300")),
        (-2e12, "+.3f", "-2.000e+12"),
    ],
)
def test_no_sign_before_a_zero_and_no_digits_that_are_none(value, spec, text):
    assert numeral(value, spec) == text


def warned(scene, code):
    found = warnings_of(assemble(scene), None)
    assert len(sentences(found)) == len(found)
    return next((warning.values for warning in found if warning.code is code), None)


def with_blocks(*blocks):
    return mo.Scene(joints={"friction": 0.6}, blocks=[*box_on_floor((1, 1, 1)).blocks, *blocks])


def test_faces_that_are_not_turned_one_way_are_told():
    """A tetrahedron with one face of the wrong orientation causes a warning. A tetrahedron whose faces are
    all turned inwards causes none."""
    faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 2, 3]]
    corners = [(2, 0, 0), (3, 0, 0), (2, 1, 0), (2, 0, 1)]
    mixed = mo.Solid(name="B", vertices=corners, faces=faces, weight=1)
    assert warned(with_blocks(mixed), Code.FACES_TURNED) == {"blocks": ["B"]}
    inwards = [face[::-1] for face in [*faces[:3], [0, 3, 2]]]
    all_inwards = mo.Solid(name="B", vertices=corners, faces=inwards, weight=1)
    assert warned(with_blocks(all_inwards), Code.FACES_TURNED) is None
    assert warnings_of(assemble(box_on_floor()), None) == ()


def test_contact_points_are_no_joints():
    """A box on a floor has one joint with four contact points, and messages count the contact points."""
    counted = size_of(assemble(box_on_floor()).problem)
    assert counted == {"contacts": 4}
    (words,) = sentences([reason(Code.NOT_COMPUTED, **counted)])
    assert "4 contact points" in words
    assert "joint" not in words


def test_the_summary_tells_contact_points_law_and_moments():
    scene = box_on_floor((2, 2, 1), 0.5, live_moment=(0, 0, 1))
    result = mo.solve(scene, "static", solver="highs")
    assert "1 block, 1 joint, 4 contacts\n" in result.summary
    known = facts(result)
    assert known["live load"] == "a force on 1 block; a moment on 1 block"
    assert "24" in known["friction"]
    assert f"{100 * (1 - math.cos(math.pi / 24)):.2g} %" in known["friction"]
    assert "24" not in facts(mo.solve(scene, "static"))["friction"]


@pytest.mark.slow
def test_the_incremental_load_factor_names_its_own_law():
    """The incremental load factor uses the cone of friction. The summary says so only if the answer itself
    uses the polygon."""
    result = mo.solve(box_on_floor((2, 2, 1), 0.5), "coulomb")
    assert (result.friction_law, result.at_incremental.friction_law) == ("cone", "cone")
    assert "incremental" not in facts(result)["friction"]
    found = replace(result.solution.answer, forms=BY_FACES)
    by_sides = replace(result, solution=replace(result.solution, state=found))
    assert by_sides.friction_law == "polygon of 24 sides"
    assert "incremental" in facts(by_sides)["friction"]


@pytest.mark.parametrize(
    "scene",
    [
        two_blocks().replace(joints={"dilatancy": 0.1}),
        small_wall(friction=float("inf")),
        block_on_floor(friction=0.0),
    ],
    ids=["all dilate", "nothing slides", "no friction"],
)
def test_where_the_flow_rule_is_associative_no_lower_state_is_spoken_of(scene):
    """If the flow rule is associative, all methods solve the same problem. The same reason then proves that
    no state is lower."""
    coulomb, linear = mo.solve(scene, "coulomb"), mo.solve(scene, "static")
    assert coulomb.exact
    assert coulomb.load_factor == pytest.approx(linear.load_factor, rel=1e-6, abs=1e-6)
    assert certainty(coulomb) == certainty(linear)
    assert certainty(coulomb).endswith("so no state has a lower load factor")
    assert [own_name(result) for result in (coulomb, linear)] == ["least, proven", "associative"]


def table(result):
    """Return the rows of the table of load factors in a summary: a dictionary from the name to the value and
    remark."""
    rows = [re.split(r" {2,}", line.strip()) for line in result.summary.splitlines() if line.startswith("  ")]
    return {row[0]: tuple(row[1:]) for row in rows if len(row) == 3}


def with_load_factor(result, load_factor):
    found = replace(result.solution.answer, load_factor=load_factor)
    return replace(result, solution=replace(result.solution, state=found))


def test_the_summary_leads_with_three_load_factors(no_proof):
    """By hand, the lowest λ is 1.5 μ and the associative one is 2.5 μ, for μ = 0.1. The incremental λ is the
    second row, and no row is called the collapse load."""
    result = mo.solve(two_blocks(), "coulomb")
    rows = table(result)
    assert list(rows) == ["lowest found", "incremental", "associative"]
    numbers = [float(number) for number, _ in rows.values()]
    assert numbers == pytest.approx([0.15, result.incremental, 0.25], rel=1e-5)
    assert result.summary.splitlines()[1] == "load factor λ"
    assert f"from {result.solution.starts} starts; not proven to be the least" in rows["lowest found"][1]
    for word in ("safe", "collapses when", "expected in a test"):
        assert word not in result.details


def test_a_state_far_below_the_load_history_is_described_without_advice(no_proof):
    """The line is missing for a proven least state, a negative λ, settled supports, and whole collapses."""
    found = with_load_factor(mo.solve(two_blocks(), "coulomb"), 0.05)
    line = facts(found)["self-stress"]
    assert line.startswith("1 block moves at this λ if the joint forces are those of this collapse state; ")
    assert line.endswith(f"passes this λ without collapse, and the incremental λ is {found.incremental:.6g}")
    assert "use" not in line
    assembly = found.assembly
    settled = replace(assembly, problem=replace(assembly.problem, settled=found.solution.q))
    proven = replace(found.solution, is_only_state=True)
    others = (
        replace(found, assembly=settled),
        replace(found, assembly=replace(assembly, at_rest=assembly)),
        replace(found, solution=proven),
        with_load_factor(found, -0.05),
        with_load_factor(found, 0.1),
    )
    assert all("self-stress" not in facts(other) for other in others)


def test_a_proof_replaces_the_remark_on_starts():
    """By hand, λ = 1.5 μ is the least load factor, for any self-stress of the state."""
    result = mo.solve(two_blocks(), "coulomb")
    value, remark = table(result)["least, proven"]
    assert float(value) == pytest.approx(0.15, rel=1e-5)
    assert remark == "exact collapse state; proven: no state has a lower load factor"
    assert "at the least: " in result.summary
    assert "not proven" not in result.summary


def test_other_methods_lead_with_their_own_load_factor(no_proof):
    assert list(table(mo.solve(two_blocks(), "static"))) == ["associative"]
    assert list(table(mo.solve(two_blocks(), "incremental"))) == ["incremental", "associative"]
    loop = table(mo.solve(two_blocks(), "nonassociative"))
    assert list(loop) == ["found", "incremental", "associative"]
    assert "that is not exact: its residuals are too large (flow" in loop["found"][1]
    off = mo.solve(two_blocks(), "coulomb", incremental=False)
    assert list(table(off)) == ["lowest found", "associative"]


def test_a_state_above_the_end_of_the_load_history_is_not_called_the_lowest(no_proof):
    """A state above the incremental load factor is called "found". A difference by rounding does not
    count."""
    result = mo.solve(two_blocks(), "coulomb")
    assert next(iter(table(with_load_factor(result, (1 + 1e-8) * result.incremental)))) == "lowest found"
    above = table(with_load_factor(result, 0.2))
    assert next(iter(above)) == "found"
    assert "the load history ends in a state with a lower load factor" in above["found"][1]


def test_what_is_left_after_the_peak_is_said():
    result = mo.solve(two_blocks(), "coulomb")
    expected = replace(result.solution.incremental, peak=0.21)
    after_peak = replace(result, solution=replace(result.solution, incremental=expected))
    value, remark = table(after_peak)["incremental"]
    assert value == "0.21"
    assert remark.endswith(
        f"after the collapse begins, the moving blocks carry only λ = {result.incremental:.6g}"
    )
    assert own_name(result.at_incremental) == "incremental"
    assert own_name(after_peak.at_incremental) == "after incremental collapse"


def test_a_missing_incremental_load_factor_is_explained():
    result = mo.solve(two_blocks(), "coulomb")
    why = reason(Code.NOT_COMPUTED, joints=9000)
    expected = replace(result.solution.incremental, state=FinalState(), reasons=(why,), followed_to_end=False)
    odd = replace(result, solution=replace(result.solution, incremental=expected))
    value, remark = table(odd)["incremental"]
    assert message([why]) in remark
    assert value == "none"
    assert message([why]) not in result.summary


def test_an_incremental_load_factor_within_a_range_is_told_with_both_ends():
    result = mo.solve(two_blocks(), "coulomb")
    why = reason(Code.RANGE, steps=7, jumps=0, carried=0.188, not_carried=0.1882)
    expected = replace(result.solution.incremental, reasons=(why,), followed_to_end=False)
    value, remark = table(replace(result, solution=replace(result.solution, incremental=expected)))[
        "incremental"
    ]
    assert value == f"{result.incremental:.6g}"
    assert "between λ = 0.188 and 0.1882" in remark


def test_friction_is_not_named_where_it_does_not_act():
    """A block is pressed straight down onto a floor, so that only the compression of the joint grows with the
    load."""
    for method in ("coulomb", "incremental", "nonassociative"):
        result = mo.solve(pressed_down(), method)
        assert result.status is mo.Status.UNLIMITED
        assert "the compression of joints grows" in result.summary
        assert "friction" not in result.summary
    assert not any("friction" in str(status) for status in mo.Status)


def test_a_tilted_ground_is_said_with_each_load_factor():
    """If the ground tilts, the load factor is also printed as an angle. A block on a slope slides at tan α =
    μ."""
    scene = block_on_floor(friction=0.3, live=(0, 0)).replace(tilt="left")
    result = mo.solve(scene, "static")
    assert "tilted to the left" in result.summary.splitlines()[1]
    assert table(result)["associative"][0] == f"0.3 ({math.degrees(math.atan(0.3)):.4f}°)"


def test_which_law_crushes_joints_is_said_with_every_load_factor():
    """Three crushing laws have three descriptions: the exact parabola, chords of the parabola, and the law of
    the Coulomb answer. A scene without a strength has none."""
    weak = block_on_floor().replace(joints={"strength": 8.0})
    how = (("static", {}), ("static", {"solver": "highs"}), ("coulomb", {}))
    said = {facts(mo.solve(weak, method, **options))["crushing"] for method, options in how}
    assert len(said) == 3
    assert "crushing" not in facts(mo.solve(block_on_floor(), "coulomb"))


def test_nothing_moves_in_a_state_that_its_certificate_does_not_bear_out():
    """If a certificate rejects a state, the result reports no motion: neither in words, tables and JSON nor
    in pictures and pages. The scene is a pebble on a boulder of 10⁸ times its weight."""
    scene = pebble(1e4, push_both=False)(CASES)
    failed = mo.solve(scene, "nonassociative", start="cohesive", remedies="slope")
    assert failed.status is mo.Status.SOLVER_FAILED
    assert failed.history["load_factor"].notna().any()
    assert motion(failed) is None
    assert not re.search(r"\bmoves?\b", failed.details)
    assert failed.blocks[["vx", "vy", "omega"]].isna().all(axis=None)
    assert failed.joints[["n", "s", "m", "slip", "opening", "utilisation"]].isna().all(axis=None)
    record = json.loads(failed.to_json())
    assert {row["vx"] for row in record["block_results"]} == {None}
    assert not result_elements(failed).movement
    assert not any("joint" in label for label in labels(failed))
    assert "tried" not in failed.plot().axes[0].get_title()
    (slider,) = [line for line in page(failed).splitlines() if 'id="moved"' in line]
    assert " disabled" in slider


#: Patterns of two mistakes: a zero with a minus sign, and a plural after the number 1.
SIGNED = re.compile(r"(?<![\w.])-0(\.0*)?(e[+-]\d+)?(?![\w.])")
MANY = re.compile(r"(?<![\d.e+-])1 (?!is\b|was\b|has\b|hinges\b|slides\b|crushes\b|moves\b|opens\b)[a-z]+s\b")


SCENES = {
    # The mirrored scene has negative coordinates, and every zero has a minus sign.
    "mirrored": lambda: mapped(two_blocks(), mirrored, lambda v: (-v[0], v[1] or -0.0)),
    "no friction": lambda: block_on_floor(friction=0.0),
    "slides": lambda: block_on_floor(4, 2, 0.5),
    "falls": overhanging,
    "wall": lambda: small_wall(2, 2),
    "tilted": lambda: block_on_floor(friction=0.0, live=(0, 0)).replace(tilt="left"),
}


@pytest.mark.parametrize("method", ["static", "coulomb", *slow("nonassociative")])
@pytest.mark.parametrize("name", SCENES)
def test_results_have_no_signed_zero_and_count_one_as_one(name, method):
    result = mo.solve(SCENES[name](), method)
    for frame in (result.joints, result.blocks, result.history):
        numbers = frame.select_dtypes("float64").to_numpy()
        assert not (np.signbit(numbers) & (numbers == 0)).any()
    texts = [result.summary, result.details, result.to_json(), repr(result.load_factor)]
    assert [text for text in texts if SIGNED.search(text)] == []
    assert not MANY.search(result.details)


def test_a_load_factor_of_many_digits_is_short(tmp_path):
    """For λ = 0.5 · 10²⁴, texts contain fewer than twelve digits in a row and a power of ten. JSON contains
    the exact number."""
    scene = block_on_floor(live=(1e-24, 0.0))
    result = mo.solve(scene, "static")
    assert result.load_factor == pytest.approx(0.5e24, rel=1e-6)
    for text in (result.details, result.plot().axes[0].get_title(), result._repr_html_()):
        assert not re.search(r"\d{12}", text)
    (printed, _) = table(result)["associative"]
    assert float(printed) == pytest.approx(result.load_factor, rel=1e-6)
    assert json.loads(result.to_json())["load_factor"] == result.load_factor
