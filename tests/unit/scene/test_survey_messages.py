"""Messages about surveyed drawings, whose corners have independent errors: which tolerance is meant."""

import itertools
import re
from dataclasses import replace

import numpy as np
import pytest
from brickwork import drawn_to_touch, facade, voussoirs
from drawing_errors import with_errors
from speeds import slow
from touching_solids import contacts_of, refusal

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.reporting.inputs import nearly_parallel
from masonry_opt.reporting.sentences import sentences
from masonry_opt.solution.reasons import Code
from masonry_opt.solution.sense import warnings_of
from masonry_opt.solution.wedges import wedges

#: Ten courses of two bricks of 240 × 65 mm with gaps of 10 mm, which have 53 joints.
WALL = facade(2, 10, length=0.24)

#: Largest error of a coordinate of a corner.
ERROR = 0.001


def surveyed(scene: mo.Scene, error: float = ERROR) -> mo.Scene:
    """Return a scene with independent errors of the corners of all movable blocks."""
    rng = np.random.default_rng(1)
    blocks = [
        block if block.fixed else block.replace(vertices=block.vertices + rng.uniform(-error, error, (4, 2)))
        for block in scene.blocks
    ]
    return scene.replace(blocks=blocks)


def advised(text: str, option: str) -> float:
    """Return the value of an option that a message advises."""
    return float(re.search(rf"'{option}' to ([\d.]+)", text)[1])


def bridged(scene: mo.Scene) -> list[str]:
    """Return the warnings about gaps that the tolerance closes."""
    found = warnings_of(assemble(scene), None)
    return list(sentences([warning for warning in found if warning.code is Code.BRIDGED_BY_TOLERANCE]))


@pytest.mark.parametrize("tolerance", [0.0135, 0.02])
def test_a_tolerance_as_large_as_the_mortar_is_named_in_a_survey_too(tolerance):
    """The advice has all joints and no further warning. Errors of 1 mm are removed by a tolerance of about
    3 mm."""
    scene = surveyed(WALL)
    (sentence,) = bridged(scene.replace(tolerance=tolerance))
    values = {option: advised(sentence, option) for option in ("contact_tolerance", "tolerance")}
    assert 0.01 < values["contact_tolerance"] < 0.014
    assert 2 * ERROR < values["tolerance"] < 5 * ERROR
    assert f"up to {values['contact_tolerance']:g} wide" in sentence
    assert len(contacts_of(scene.replace(**values)).first) == 53
    assert bridged(scene.replace(**values)) == []


def test_the_named_width_of_gaps_is_not_larger_than_the_advised_tolerance():
    (sentence,) = bridged(WALL.replace(tolerance=0.0101))
    assert "up to 0.01 wide" in sentence
    assert advised(sentence, "contact_tolerance") == 0.0101


def test_errors_of_touching_stones_are_not_mortar():
    """The gaps of these stones are due to the errors alone, so the tolerance is the right option."""
    scene = surveyed(drawn_to_touch(WALL)).replace(tolerance=6 * ERROR)
    assert len(contacts_of(scene).first) >= 53
    assert bridged(scene) == []


def test_a_survey_without_tolerances_is_advised_to_set_both():
    text = refusal(surveyed(WALL))
    values = {option: advised(text, option) for option in ("contact_tolerance", "tolerance")}
    assert 2 * ERROR < values["tolerance"] < 5 * ERROR
    assert len(contacts_of(surveyed(WALL).replace(**values)).first) == 53
    assert "survey" not in refusal(WALL)


@pytest.mark.parametrize(
    ("error", "meant"),
    [
        (0.0005, "if the blocks are meant to overlap, set only 'contact_tolerance'"),
        (ERROR, "if the drawing is a survey, set 'contact_tolerance'"),
    ],
)
def test_overlaps_of_a_survey_are_advised_to_set_both(error, meant):
    """The tolerance that closes all gaps exceeds 1 % of the width of a brick. Overlaps deeper than this width
    may be intended too."""
    scene = surveyed(drawn_to_touch(WALL), error)
    text = refusal(scene)
    assert meant in text
    _, _, survey = text.partition("if the drawing is a survey" if error == ERROR else "move the blocks apart")
    values = {option: advised(survey, option) for option in ("contact_tolerance", "tolerance")}
    assert 2 * error < values["tolerance"] < 5 * error
    assert len(contacts_of(scene.replace(**values)).first) == 53


def turned(scene: mo.Scene) -> list[dict[str, object]]:
    """Return the values of the warning about joints that the alignment turned."""
    return [each.values for each in warnings_of(assemble(scene), None) if each.code is Code.ALIGNED]


def test_joints_that_a_tolerance_turns_by_different_angles_are_named():
    """Joints of 60 voussoirs of different widths become parallel within a tolerance.

    Their rotations scatter like errors of a survey, so a survey with a tolerance is named too.
    """
    rng = np.random.default_rng(4)
    angle = np.exp(rng.uniform(np.log(0.006), np.log(0.03), 60)).cumsum()
    angle += (np.pi - angle[-1]) / 2
    ends = np.concatenate([[angle[0] - 0.02], angle])
    points = [np.array([[r * np.cos(t), r * np.sin(t)] for r in (7.75, 8.25)]) for t in ends]
    blocks = [
        mo.Block(name=f"v{k}", vertices=np.vstack([before, after[::-1]]).tolist(), unit_weight=20)
        for k, (before, after) in enumerate(itertools.pairwise(points))
    ]
    blocks[0] = blocks[0].replace(fixed=True)
    blocks[-1] = blocks[-1].replace(fixed=True)
    scene = mo.Scene(joints={"friction": 0.35}, blocks=blocks)
    (values,) = turned(scene.replace(tolerance=0.006))
    assert len(values["pairs"]) >= 10
    survey = surveyed(drawn_to_touch(WALL)).replace(tolerance=3 * ERROR)
    assert len(turned(survey)) == 1


@pytest.mark.parametrize(("voussoirs", "rise"), [(40, 1.5), (60, 0.665), (100, 2.0)])
def test_a_fine_arch_that_a_tolerance_flattens_is_named(voussoirs, rise):
    """The joints of the arch differ by 0.009 to 0.03 rad, and become parallel within a tolerance of 1 cm."""
    arch = mo.Arch(span=10, rise=rise, thickness=0.5, voussoirs=voussoirs, unit_weight=20)
    scene = mo.Scene(joints={"friction": 0.3}, blocks=arch.blocks())
    (values,) = turned(scene.replace(tolerance=0.01))
    assert len(values["pairs"]) >= 10
    assert turned(scene.replace(tolerance=0.001)) == []


@pytest.mark.parametrize(
    ("number", "scatter", "survey"), [(2, 4.0, False), (97, 4.0, True), (97, 1.0, False)]
)
def test_many_wedges_of_scattered_angles_are_compared_with_errors_of_a_survey(number, scatter, survey):
    values = {"pairs": [("A", "B")] * number, "angle": 0.007, "tolerance": 0.01, "scatter": scatter}
    sentence = nearly_parallel(values)
    assert "if the joints should be parallel, set 'tolerance' to 0.01" in sentence
    assert ("the angles scatter like errors of a survey" in sentence) == survey


ARCH = mo.Arch(span=10, rise=0.665, thickness=0.5, voussoirs=60, unit_weight=20, live_per_weight=(1, 0))
COURSES = [[1] * 4, [0.5, 1, 1, 1, 0.5]] * 2
BOND = mo.Wall(block=(0.5, 0.25), weight=1, live_per_weight=(1, 0), courses=COURSES)


@pytest.mark.parametrize(
    ("drawn", "error", "survey"), [*slow((ARCH, 0.0, False)), (ARCH, 0.001, False), (BOND, 0.001, True)]
)
def test_the_voussoirs_of_an_arch_are_not_compared_with_errors_of_a_survey(drawn, error, survey):
    """A flat arch of 60 voussoirs has 60 nearly equal wedges of 0.0088 rad, also with small errors.

    The stones of a bond with errors are wedges of very different angles. All joints carry their friction
    limit.
    """
    scene = mo.Scene(joints={"friction": 0.3}, blocks=drawn.blocks())
    if error > 0:
        measured = with_errors(scene, error, 0)
        # Close the gaps, and leave the joints as wedges.
        scene = measured.replace(contact_tolerance=measured.tolerance, tolerance=1e-6)
    result = mo.solve(scene, "nonassociative")
    joints = result.size.joints
    q = np.append(np.full(2 * joints, 0.5), np.full(joints, 0.3))
    at_limit = replace(result.solution, state=replace(result.solution.answer, q=q))
    (warning,) = (each for each in wedges(result.assembly, at_limit) if each.code is Code.NEARLY_PARALLEL)
    assert len(warning.values["pairs"]) >= 10
    assert (warning.values["scatter"] > 2) == survey
    assert ("errors of a survey" in nearly_parallel(warning.values)) == survey


def ring(gap: float, **keys: object) -> mo.Scene:
    """Return an extruded ring of 15 voussoirs whose corners have independent errors, also out of their
    faces."""
    rng = np.random.default_rng(0)
    solids = mo.extrude(voussoirs(15, gap), thickness=0.5)
    blocks = [
        block.replace(vertices=np.add(block.vertices, rng.uniform(-ERROR, ERROR, np.shape(block.vertices))))
        for block in solids.blocks
    ]
    return solids.replace(blocks=blocks, **keys)


def test_a_tolerance_that_hides_the_joints_of_a_survey_is_lowered():
    """Sides of 0.3 m are narrower than ten times a tolerance of 0.06. The gaps of up to 2 mm are not the
    cause."""
    scene = ring(0.0, tolerance=0.06)
    text = refusal(scene)
    assert "its sides that face 'v1' are narrower than ten times 'tolerance': lower 'tolerance' to" in text
    assert len(contacts_of(scene.replace(tolerance=advised(text, "tolerance"))).first) == 16


def test_a_tolerance_is_replaced_or_removed_but_not_both():
    text = refusal(ring(0.01, tolerance=0.06))
    assert "also set 'tolerance' to" in text
    assert "and otherwise remove 'tolerance'" in text
    assert text.count("remove") == 1
    assert "which makes 16 joints across gaps" in text


@pytest.mark.filterwarnings("error")
def test_edges_at_faces_narrower_than_the_tolerance_form_no_contact():
    """Such an edge has one face, so the sector that its block occupies is not known."""
    text = refusal(ring(0.0, tolerance=0.03, contact_tolerance=0.03))
    assert "narrower than ten times 'tolerance'" in text
