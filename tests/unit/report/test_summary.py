"""What a result is said to be: facts by their labels, compared with each other, not read."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from atlas.small_scenes import pebble
from drawn import labels
from mappings import mapped, mirrored
from scenes import CASES, block_on_floor, overhanging, small_wall, two_blocks

import masonry_opt as mo
from masonry_opt.answer.answer import Found
from masonry_opt.answer.reasons import Code, reason
from masonry_opt.drawing.elements import result_elements
from masonry_opt.drawing.page import page
from masonry_opt.words.sentences import message
from masonry_opt.words.summary import facts


def associative():
    """Two blocks whose joints dilate as classical limit analysis assumes."""
    scene = two_blocks()
    return scene.model_copy(update={"joints": mo.JointDefaults(friction=0.1, dilatancy=0.1)})


@pytest.mark.parametrize(
    "scene",
    [associative(), small_wall(friction=float("inf")), block_on_floor(friction=0.0)],
    ids=["all dilate", "nothing slides", "no friction"],
)
def test_where_the_flow_rule_is_associative_no_lower_state_is_spoken_of(scene):
    """All methods answer one question there, and say the same of it."""
    one_pass, linear = mo.solve(scene, "mcp"), mo.solve(scene, "static")
    assert one_pass.exact
    assert one_pass.load_factor == pytest.approx(linear.load_factor, rel=1e-6, abs=1e-6)
    assert facts(one_pass)["how sure"] == facts(linear)["how sure"]


def numbers(result):
    """The numbers of the line of load factors, without those of remarks."""
    told = re.sub(r"\(.*?\)", "", facts(result)["load factors"])
    return [float(number) for number in re.findall(r"[\d.]+", told)]


def test_the_three_load_factors_stand_in_one_line():
    result = mo.solve(two_blocks(), "mcp")
    assert numbers(result) == pytest.approx([0.15, result.expected, 0.25], rel=1e-4)
    assert numbers(result.at_expected) == numbers(result)[1:]
    assert len(facts(result)["load factors"].splitlines()) == 1
    assert "load factors" not in facts(mo.solve(two_blocks(), "static"))


def test_what_is_above_the_load_to_expect_is_not_called_safe():
    """But by rounding, where both are one and said once."""
    result = mo.solve(two_blocks(), "mcp")

    def said(load_factor):
        found = replace(result.solution.answer, load_factor=load_factor)
        line = facts(replace(result, solution=replace(result.solution, found=found)))["load factors"]
        return [part.split(" 0.")[0] for part in line.split(" · ")]

    (safe, expected, _), (both, _) = said(0.15), said((1 + 1e-8) * result.expected)
    assert both == f"{safe} and {expected}"
    assert said(0.2)[0] not in (safe, both)


@pytest.mark.parametrize("code", [Code.NO_PLATEAU, Code.NOT_EXPECTED])
def test_no_plateau_and_none_are_said_by_their_reason(code):
    result = mo.solve(two_blocks(), "mcp")
    why = reason(code, give=1e-6, change=0.02, softer=10.0, load_factor=7.0, joints=9000)
    found = result.solution.expected.found if code is Code.NO_PLATEAU else Found()
    expected = replace(result.solution.expected, found=found, reasons=[why])
    odd = replace(result, solution=replace(result.solution, expected=expected))
    assert message([why]) in facts(odd)["load factors"]
    assert message(result.at_expected.reasons) not in facts(result)["load factors"]
    assert numbers(odd)[:: 2 if odd.expected else 1] == [0.15, 0.25]


def test_which_law_crushes_joints_is_said_with_every_load_factor():
    """The parabola itself or chords; and of a Coulomb answer that what stands beside it crushes alike."""
    weak = block_on_floor().replace(joints={"strength": 8.0})
    said = [
        facts(mo.solve(weak, method, **how))["crushing"]
        for method, how in (("static", {}), ("static", {"solver": "highs"}), ("mcp", {}))
    ]
    assert len(set(said)) == 3
    assert "crushing" not in facts(mo.solve(block_on_floor(), "mcp"))


@pytest.fixture(scope="module")
def failed():
    """A state that its certificate does not bear out: a pebble on a boulder of 10⁸ times its weight."""
    result = mo.solve(
        pebble(1e4, push_both=False)(CASES), "nonassociative", start="cohesive", remedies="slope"
    )
    assert result.status is mo.Status.SOLVER_FAILED
    assert result.history["load_factor"].notna().any()
    return result


def test_nothing_moves_in_words_and_numbers(failed):
    assert "moves" not in facts(failed)
    assert "moves" not in failed.details
    assert failed.blocks[["vx", "vy", "omega"]].isna().all(axis=None)
    assert failed.joints[["n", "s", "m", "slip", "opening", "utilisation"]].isna().all(axis=None)
    told = json.loads(failed.to_json())
    assert {row["vx"] for row in told["block_results"]} == {None}


def test_nothing_moves_in_pictures_and_pages(failed):
    assert not result_elements(failed).movement
    assert not any("joint" in label for label in labels(failed))
    assert "tried" not in failed.plot().axes[0].get_title()
    (slider,) = [line for line in page(failed).splitlines() if 'id="moved"' in line]
    assert " disabled" in slider


#: A zero with a sign, and one of what is said to be many.
SIGNED = re.compile(r"(?<![\w.])-0(\.0*)?(e[+-]\d+)?(?![\w.])")
MANY = re.compile(r"(?<![\d.e+-])1 (?!is\b|was\b|has\b|hinges\b|slides\b|separates\b|crushes\b)[a-z]+s\b")


def below_zero():
    """Two blocks with their coordinates below zero, and with a sign before each zero."""
    return mapped(two_blocks(), mirrored, lambda v: (-v[0], v[1] or -0.0))


SCENES = {
    "mirrored": below_zero,
    "no friction": lambda: block_on_floor(friction=0.0),
    "slides": lambda: block_on_floor(4, 2, 0.5),
    "falls": overhanging,
    "wall": lambda: small_wall(2, 2),
    "tilted": lambda: mo.Scene.model_validate(
        block_on_floor(friction=0.0, live=(0, 0)).model_dump() | {"tilt": "left"}
    ),
}


@pytest.mark.parametrize("method", ["static", "mcp", "nonassociative"])
@pytest.mark.parametrize("name", SCENES)
def test_results_have_no_signed_zero_and_count_one_as_one(name, method):
    result = mo.solve(SCENES[name](), method)
    for frame in (result.joints, result.blocks, result.history):
        numbers = frame.select_dtypes("float64").to_numpy()
        assert not (np.signbit(numbers) & (numbers == 0)).any()
    told = [result.summary, result.details, result.to_json(), repr(result.load_factor)]
    assert [text for text in told if SIGNED.search(text)] == []
    assert not MANY.search(result.details)


def test_a_load_factor_of_many_digits_is_short(tmp_path):
    """λ = 0.5 · 10²⁴ exactly: eight digits and a power of ten, in words as in JSON."""
    scene = block_on_floor(live=(1e-24, 0.0))
    result = mo.solve(scene, "static")
    assert result.load_factor == pytest.approx(0.5e24, rel=1e-6)
    for text in (result.details, result.plot().axes[0].get_title(), result._repr_html_()):
        assert not re.search(r"\d{12}", text)
    (printed,) = re.findall(r"λ = (\S+)", result.summary.splitlines()[1])
    assert float(printed) == pytest.approx(result.load_factor, rel=1e-6)
    assert json.loads(result.to_json())["load_factor"] == result.load_factor
