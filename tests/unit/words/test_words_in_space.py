"""Warnings of scenes in space, and what a summary tells of them."""

import dataclasses
import math

from scenes_in_space import box_on_floor

import masonry_opt as mo
from masonry_opt.answer.reasons import Code, reason, size_of
from masonry_opt.answer.sense import warnings_of
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.laws import BY_FACES
from masonry_opt.words.sentences import sentences
from masonry_opt.words.summary import facts


def warned(scene, code):
    found = warnings_of(assemble(scene), None)
    assert len(sentences(found)) == len(found)
    return next((warning.values for warning in found if warning.code is code), None)


def with_blocks(*blocks, **keys):
    scene = box_on_floor((1, 1, 1), **keys)
    return mo.Scene(joints=scene.joints, blocks=[*scene.blocks, *blocks])


def beside(name, x, weight=1.0, **keys):
    return mo.box(name, (x, x + 1), (0, 1), (0, 1), weight=weight, **keys)


def test_nothing_is_wrong_with_a_box():
    assert warnings_of(assemble(box_on_floor()), None) == ()


def test_weights_of_another_unit_are_told_per_volume():
    scene = with_blocks(beside("B", 2), beside("C", 4, weight=1000.0))
    assert warned(scene, Code.WEIGHTS_DIFFER) == {"blocks": ["C"], "ratio": 1000.0, "per": "volume"}


def test_faces_that_are_not_turned_one_way_are_told():
    """A tetrahedron one face of which is clockwise seen from outside, the others not; all turned is none."""
    faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 2, 3]]
    corners = [(2, 0, 0), (3, 0, 0), (2, 1, 0), (2, 0, 1)]
    mixed = mo.Solid(name="B", vertices=corners, faces=faces, weight=1)
    assert warned(with_blocks(mixed), Code.FACES_TURNED) == {"blocks": ["B"]}
    inwards = [face[::-1] for face in [*faces[:3], [0, 3, 2]]]
    all_inwards = mo.Solid(name="B", vertices=corners, faces=inwards, weight=1)
    assert warned(with_blocks(all_inwards), Code.FACES_TURNED) is None


def test_contact_points_are_no_joints():
    """A box on a floor has one joint of four points."""
    counted = size_of(assemble(box_on_floor()).problem)
    assert counted == {"contacts": 4}
    (words,) = sentences([reason(Code.NOT_EXPECTED, **counted)])
    assert "4 contact points" in words
    assert "joint" not in words


def test_the_summary_tells_contact_points_law_and_moments():
    scene = box_on_floor((2, 2, 1), 0.5, live_moment=(0, 0, 1))
    result = mo.solve(scene, "static", solver="highs")
    assert "1 block, 1 joint, 4 contact points" in result.summary
    known = facts(result)
    assert known["live load"] == "a force on 1 block; a moment on 1 block"
    assert "24" in known["friction"]
    assert f"{100 * (1 - math.cos(math.pi / 24)):.2g} %" in known["friction"]
    assert "24" not in facts(mo.solve(scene, "static"))["friction"]


def test_the_load_to_expect_tells_its_own_law():
    """It is that of the cone, as that of the answer beside it, unless that is of polygons."""
    result = mo.solve(box_on_floor((2, 2, 1), 0.5), "mcp")
    assert (result.friction_law, result.at_expected.friction_law) == ("cone", "cone")
    assert "to expect" not in facts(result)["friction"]
    found = dataclasses.replace(result.solution.answer, forms=BY_FACES)
    by_sides = dataclasses.replace(result, solution=dataclasses.replace(result.solution, found=found))
    assert by_sides.friction_law == "polygon of 24 sides"
    assert "to expect" in facts(by_sides)["friction"]


def test_what_meets_without_a_normal_is_told():
    assembly = assemble(with_blocks(beside("B", 1)))
    joints = dataclasses.replace(assembly.joints, without_normal=[(0, 2)])
    (warning,) = warnings_of(dataclasses.replace(assembly, joints=joints), None)
    assert warning.code is Code.WITHOUT_NORMAL
    assert warning.values == {"pairs": [["A", "B"]]}
    assert "'A'–'B'" in sentences([warning])[0]
