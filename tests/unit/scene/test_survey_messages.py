"""Messages about surveyed drawings, whose corners have independent errors: which tolerance is meant."""

import re

import numpy as np
import pytest
from brickwork import drawn_to_touch, facade
from touching_solids import contacts_of

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.reporting.inputs import nearly_parallel
from masonry_opt.reporting.sentences import sentences
from masonry_opt.solution.reasons import Code
from masonry_opt.solution.sense import warnings_of

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


def message(scene: mo.Scene) -> str:
    with pytest.raises(mo.CaseError) as refusal:
        contacts_of(scene)
    return str(refusal.value)


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
    text = message(surveyed(WALL))
    values = {option: advised(text, option) for option in ("contact_tolerance", "tolerance")}
    assert 2 * ERROR < values["tolerance"] < 5 * ERROR
    assert len(contacts_of(surveyed(WALL).replace(**values)).first) == 53
    assert "survey" not in message(WALL)


@pytest.mark.parametrize(
    ("error", "meant"),
    [
        (0.0005, "if the blocks are drawn to overlap, 'contact_tolerance' alone is sufficient"),
        (ERROR, "if the drawing is a survey, set 'contact_tolerance'"),
    ],
)
def test_overlaps_of_a_survey_are_advised_to_set_both(error, meant):
    """The tolerance that closes all gaps exceeds 1 % of the width of a brick. Overlaps deeper than this width
    may be intended too."""
    scene = surveyed(drawn_to_touch(WALL), error)
    text = message(scene)
    assert meant in text
    _, _, survey = text.partition("if the drawing is a survey" if error == ERROR else "move the blocks apart")
    values = {option: advised(survey, option) for option in ("contact_tolerance", "tolerance")}
    assert 2 * error < values["tolerance"] < 5 * error
    assert len(contacts_of(scene.replace(**values)).first) == 53


def test_many_wedges_are_called_errors_of_a_survey():
    def said(number: int) -> str:
        return nearly_parallel({"pairs": [("A", "B")] * number, "angle": 0.007, "tolerance": 0.01})

    assert "; if the joints should be parallel, set 'tolerance' to 0.01" in said(2)
    assert "so many wedges are usually errors of a survey: set 'tolerance' to 0.01," in said(97)
