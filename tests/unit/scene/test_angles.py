"""Friction and dilatancy in degrees."""

from __future__ import annotations

import math

import pytest

import masonry_opt as mo


def test_angles_are_kept_as_tangents():
    joints = mo.JointDefaults(friction_angle=33.0, dilatancy_angle=30)
    assert joints.friction == pytest.approx(0.6494075931975106, rel=1e-15)
    assert joints.dilatancy == pytest.approx(1 / math.sqrt(3), rel=1e-15)
    assert joints == mo.JointDefaults(friction=joints.friction, dilatancy=joints.dilatancy)
    exception = mo.Joint(between=("A", "B"), friction_angle=60)
    assert exception.friction == pytest.approx(math.sqrt(3), rel=1e-15)
    assert exception.over(joints).friction == exception.friction
    assert exception.over(joints).dilatancy == joints.dilatancy


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"friction": 0.5, "friction_angle": 30}, "'friction' or 'friction_angle', not both"),
        ({"friction": 0.5, "dilatancy": 0.0, "dilatancy_angle": 0}, "'dilatancy' or 'dilatancy_angle'"),
        ({"friction_angle": 90}, "'friction_angle': must be less than 90"),
        ({"friction_angle": -1}, "'friction_angle': must be 0"),
        ({"friction_angle": "30"}, "'friction_angle': must be a number"),
        ({"friction_angle": True}, "'friction_angle': must be a number"),
        ({"friction_angle": math.nan}, "'friction_angle'"),
        ({"friction_angle": 30, "dilatancy_angle": 31}, "'dilatancy' must not exceed 'friction'"),
        ({}, "missing key 'friction'"),
    ],
)
def test_wrong_angles_are_refused_in_one_line(given, words):
    with pytest.raises(mo.CaseError, match=words) as error:
        mo.JointDefaults(**given)
    assert "\n" not in str(error.value)
