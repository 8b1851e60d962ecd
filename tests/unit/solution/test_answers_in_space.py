"""Tables of results in space are compared with closed forms of a box on a floor, and with equilibrium by
hand."""

import json
import math

import numpy as np
import pytest
from scenes import block_on_floor
from scenes_in_space import box_on_floor, corner_wall, pushed_box

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import certified
from masonry_opt.solution.motion import joint_motion
from masonry_opt.solution.reasons import Code, Status
from masonry_opt.solution.solution import Solution

#: Tolerances of comparisons. The residuals of a program of one box are below 1e-6. Cones are round, so the
#: direction of slip is accurate only to the square root of the residual.
EXACT = {"rel": 1e-6, "abs": 1e-6}
ROUND = {"rel": 1e-4, "abs": 1e-4}


def vectors(rows, prefix=""):
    return rows[[f"{prefix}{axis}" for axis in "xyz"]].to_numpy(float)


def moves(result):
    motion = joint_motion(result.assembly, result.solution)
    return [name for name in ("slides", "hinges", "separates", "crushes") if getattr(motion, name).any()]


def test_a_pushed_box_slides_along_the_push():
    """A box of weight 1 slides at λ = μ. The live load does work at the rate 1, so the slip is 1, along the
    push, and the joint opens by μ. Moment equilibrium places the resultant μ h/2 from the middle of the
    joint."""
    result = mo.solve(pushed_box((1, 2, 0.5), 0.6, 30), "static")
    assert result.load_factor == pytest.approx(0.6, **EXACT)
    push = np.array([math.cos(math.radians(30)), math.sin(math.radians(30)), 0])
    joint = result.joints.iloc[0]
    assert (joint["first"], joint["second"]) == ("A", "floor")
    assert vectors(joint, "v") == pytest.approx([*push[:2], 0.6], **ROUND)
    assert joint[["slip", "opening", "rotation"]].to_numpy(float) == pytest.approx([1, 0.6, 0], **ROUND)
    assert np.isnan(vectors(joint, "a")).all()
    assert vectors(joint, "f") == pytest.approx([0, 0, 1] - 0.6 * push, **ROUND)
    assert vectors(joint, "n") == pytest.approx([0, 0, 1], abs=1e-12)
    assert joint[["n", "s", "torsion"]].to_numpy(float) == pytest.approx([1, 0.6, 0], **ROUND)
    assert vectors(joint) == pytest.approx([0.5, 1, 0], abs=1e-12)
    assert vectors(joint, "p") == pytest.approx([0.5, 1, 0] + 0.6 * 0.25 * push, **ROUND)
    assert joint["area"] == pytest.approx(2)
    assert joint["utilisation"] == pytest.approx(1, abs=1e-6)
    points = result.contacts
    assert len(points) == 4
    assert vectors(points, "v") == pytest.approx(np.tile(vectors(joint, "v"), (4, 1)), **ROUND)
    assert vectors(points, "f").sum(axis=0) == pytest.approx(vectors(joint, "f"), abs=1e-9)
    assert vectors(result.blocks, "v") == pytest.approx(vectors(joint, "v")[None], **ROUND)
    assert moves(result) == ["slides"]


def test_a_tall_box_turns_about_its_edge():
    """A box of width a and height h overturns at λ = a/h. It turns at the rate 2/h about its edge at x = a,
    through which the resultant passes."""
    result = mo.solve(box_on_floor((0.5, 2, 2), 0.6), "static")
    assert result.load_factor == pytest.approx(0.25, **EXACT)
    joint = result.joints.iloc[0]
    assert vectors(joint, "w") == pytest.approx([0, 1, 0], **EXACT)
    assert joint[["rotation", "slip", "torsion"]].to_numpy(float) == pytest.approx([1, 0, 0], **EXACT)
    # at the centroid of the joint, half a width from the edge
    assert joint["opening"] == pytest.approx(0.25, **EXACT)
    assert vectors(joint, "a") == pytest.approx([0.5, 1, 0], **EXACT)
    assert vectors(joint, "p") == pytest.approx([0.5, 1, 0], **EXACT)
    assert vectors(result.blocks.iloc[0], "v") == pytest.approx([1, 0, 0.25], **EXACT)
    assert vectors(result.blocks.iloc[0], "w") == pytest.approx([0, 1, 0], **EXACT)
    assert moves(result) == ["hinges"]
    assembly = result.assembly
    hinge = joint_motion(assembly, result.solution).hinge + assembly.geometry.origin
    assert hinge == pytest.approx(np.array([[0.5, 1, 0]]), **EXACT)
    points = result.contacts.sort_values(["x", "y"])
    assert points["opening"].to_numpy() == pytest.approx([0.5, 0.5, 0, 0], **EXACT)
    assert points["utilisation"].isna().tolist() == [True, True, False, False]
    assert points["utilisation"].iloc[2:].max() >= 0.25 / 0.6 - 1e-6


def test_a_twisted_box_slips_round_its_middle():
    """All corners of a square are a/√2 from its middle. The limit of the torsion is therefore μ W a/√2 for
    any distribution of the weight W over the corners."""
    result = mo.solve(box_on_floor((1, 1, 1), 0.6, live=(0, 0, 0), live_moment=(0, 0, 1)), "static")
    assert result.load_factor == pytest.approx(0.6 / math.sqrt(2), **EXACT)
    joint, points = result.joints.iloc[0], result.contacts
    assert joint["torsion"] == pytest.approx(-result.load_factor, **EXACT)
    assert joint[["s", "slip"]].to_numpy(float) == pytest.approx([0, 0], abs=1e-6)
    assert vectors(joint, "a") == pytest.approx([0.5, 0.5, 0], **EXACT)
    turn = vectors(joint, "w")
    assert turn[:2] == pytest.approx([0, 0], abs=1e-6)
    beside = vectors(points) - [0.5, 0.5, 0]
    assert vectors(points, "v")[:, :2] == pytest.approx(np.cross(turn, beside)[:, :2], **EXACT)
    assert points["slip"].to_numpy() == pytest.approx(np.full(4, turn[2] / math.sqrt(2)), **EXACT)
    assert moves(result) == ["slides"]


def test_opening_by_dilatancy_is_that_of_the_sides_where_they_hold():
    """A plate turns about a point 10 from its corner. One end slips towards a corner of the friction polygon,
    the other 7.5° from there, along a side. With the polygon, dilatancy opens both ends alike, and the joint
    slides. With the cone, one end would open 0.9 % more, and the joint would also hinge."""
    length = 10 * math.tan(math.radians(7.5))
    assembly = assemble(box_on_floor((length, 0.01, 0.1), 0.9))
    problem = assembly.problem
    # The rotation about the x axis opens a point of the base by 0.9 times its slip along x.
    turn, arm = np.array([0.9, 0.0, 1.0]), np.array([length / 2, 10.005, 0.05])
    d = np.concatenate([np.cross(turn, arm), problem.length_unit * turn])
    found = certified(problem, 0.0, np.zeros(problem.B.shape[1]), d, problem.friction)
    assert found.certificate.flow < 1e-12
    motion = joint_motion(assembly, Solution(Status.OPTIMAL, Kind.ASSOCIATIVE, state=found))
    assert (motion.slides.all(), motion.hinges.any(), motion.separates.any()) == (True, False, False)


@pytest.mark.parametrize("method", ["static", pytest.param("coulomb", marks=pytest.mark.slow)])
def test_resultants_balance_weight_and_load_of_each_block(method):
    """The resultants of the joints balance the loads on each block: forces, and moments about the centroid.
    Each joint contributes its resultant at the point of action, and its torsion."""
    result = mo.solve(corner_wall(2, 2, 3), method)
    problem, joints = result.assembly.problem, result.joints
    acts = np.where(joints[["px"]].isna(), vectors(joints), vectors(joints, "p"))
    force, torque = vectors(joints, "f"), joints[["torsion"]].to_numpy() * vectors(joints, "n")
    left = (problem.dead + result.load_factor * problem.live).reshape(12, 6)
    left *= problem.force_unit * np.repeat([1.0, problem.length_unit], 3)
    for row, (name, middle) in enumerate(zip(result.blocks["block"], vectors(result.blocks), strict=True)):
        sign = (joints[["first"]] == name).to_numpy() * 1.0 - (joints[["second"]] == name).to_numpy()
        left[row, :3] += (sign * force).sum(axis=0)
        left[row, 3:] += (sign * (np.cross(acts - middle, force) + torque)).sum(axis=0)
    assert np.abs(left).max() < 1e-7


def test_which_law_holds_is_told():
    """In the direction normal to a side, 7.5° from an axis of the contact, the polygon has cos(π/24) times
    the friction of the cone. Each result names its law."""
    scene = pushed_box((2, 2, 1), 0.5, 7.5)
    cone, polygon = mo.solve(scene, "static"), mo.solve(scene, "static", solver="highs")
    assert (cone.friction_law, polygon.friction_law) == ("cone", "polygon of 24 sides")
    assert cone.load_factor == pytest.approx(0.5, rel=1e-7)
    assert polygon.load_factor == pytest.approx(0.5 * math.cos(math.pi / 24), rel=1e-9)
    unlimited = mo.solve(box_on_floor((1, 2, 3), math.inf), "static")
    assert unlimited.friction_law == ""
    assert unlimited.load_factor == pytest.approx(1 / 3, rel=1e-6)


@pytest.mark.slow
def test_json_has_the_same_keys_and_contact_points():
    space, plane = mo.solve(box_on_floor(), "coulomb"), mo.solve(block_on_floor(2, 2, 0.5), "coulomb")
    record, of_plane = json.loads(space.to_json()), json.loads(plane.to_json())
    assert set(record) - set(of_plane) == {"contact_results"}
    assert set(of_plane) <= set(record)
    assert plane.contacts is None
    assert (record["joints"], record["size"]["contacts"], len(record["contact_results"])) == (1, 4, 4)
    assert of_plane["size"]["contacts"] is None
    assert of_plane["friction_law"] == ""
    shared = {"first", "second", "x", "y", "n", "s", "slip", "opening", "rotation", "utilisation"}
    assert shared <= set(record["joint_results"][0]) & set(of_plane["joint_results"][0])


def ridge(name, x):
    """Return a fixed prism with an edge along y at height 0."""
    vertices = [(x + dx, y, z) for y in (-1.0, 2.0) for dx, z in ((-0.1, -1.0), (0.1, -1.0), (0.0, 0.0))]
    faces = [[0, 1, 2], [3, 5, 4], [0, 3, 4, 1], [1, 4, 5, 2], [2, 5, 3, 0]]
    return mo.Solid(name=name, vertices=vertices, faces=faces, fixed=True)


def test_a_box_on_two_edges_turns_about_one():
    """A box of height h = 1 on ridges 0.4 apart overturns at λ = 0.4. It turns about the ridge in the
    direction of the push at the rate 2/h. At the other ridge, it opens by 2/h times the distance of the
    ridges."""
    box = mo.box("A", (-1, 1), (0, 1), (0, 1), weight=1.0, live=(1, 0, 0))
    scene = mo.Scene(joints={"friction": 0.6}, blocks=[box, ridge("left", -0.2), ridge("right", 0.2)])
    result = mo.solve(scene, "static")
    assert result.load_factor == pytest.approx(0.4, **EXACT)
    motion, joints = joint_motion(result.assembly, result.solution), result.joints
    assert joints["second"].tolist() == ["left", "right"]
    assert joints["area"].tolist() == [0, 0]
    assert len(result.contacts) == 4
    assert motion.hinges.tolist() == [False, True]
    assert motion.separates.tolist() == [True, False]
    assert not motion.slides.any()
    hinge = motion.hinge[1] + result.assembly.geometry.origin
    assert hinge == pytest.approx([0.2, 0.5, 0], abs=1e-9)
    assert joints["opening"].to_numpy() == pytest.approx([0.8, 0], **EXACT)
    assert vectors(joints, "w") == pytest.approx(np.array([[0, 2, 0]] * 2), **EXACT)
    assert vectors(joints, "p")[1] == pytest.approx([0.2, 0.5, 0], **EXACT)
    assert np.isnan(vectors(joints, "p")[0]).all()


def test_an_answer_short_of_the_solver_s_tolerance_is_told_and_as_good_as_it_gets():
    """No solver reaches a tolerance of 1e-15. The answer is the state at which the solver stopped, not a
    state computed with a looser tolerance."""
    result = mo.solve(corner_wall(2, 2, 3), "static", tolerance=1e-15)
    assert [reason.code for reason in result.reasons] == [Code.STOPPED_SHORT]
    assert result.certificate.complementarity < 1e-10
