"""Scenes in space without a load factor: unlimited ones, and one that only self-stress would support."""

import pytest
from speeds import slow

import masonry_opt as mo
from masonry_opt.solution.reasons import Code, Status

METHODS = ["static", "kinematic", "nonassociative", "incremental", "coulomb"]
FRICTION = mo.JointDefaults(friction=0.6)
#: Live loads towards a wall, onto the floor, and towards both.
SIDEWAYS = (1.0, 0.0, 0.0)
DOWNWARDS = [(0.0, 0.0, -1.0), (-0.6, 0.0, -0.8)]


def pushed(at: float, live: tuple[float, float, float] = (1.0, 0.0, 0.0)) -> mo.Solid:
    return mo.box("cube", (0, 1), (0, 1), (at, at + 1), unit_weight=1, live=live)


def walls(*sides: str) -> list[mo.Solid]:
    """Return fixed walls of height 3 on the given sides along x."""
    span = {"left": (-1, 0), "right": (1, 2)}
    return [mo.box(side, span[side], (-1, 2), (0, 3), fixed=True) for side in sides]


def floor(end: float = 3.0) -> mo.Solid:
    return mo.box("floor", (-3, end), (-3, 3), (-1, 0), fixed=True)


@pytest.mark.parametrize(
    ("method", "live"),
    [
        *((method, SIDEWAYS) for method in METHODS),
        ("static", DOWNWARDS[0]),
        *slow(("static", DOWNWARDS[1]), *((method, live) for method in METHODS[1:] for live in DOWNWARDS)),
    ],
)
def test_nothing_brings_down_a_box_that_is_pushed_against_fixed_walls(method, live):
    """A box between fixed walls is unlimited, with a proof for any flow rule.

    In no motion does the live load do work.
    """
    blocks = [pushed(0.0, live), floor(), *walls("left", "right")]
    result = mo.solve(mo.Scene(joints=FRICTION, blocks=blocks), method)
    assert result.status is Status.UNLIMITED
    assert result.load_factor is None
    assert result.solution.proven_none


def test_a_box_that_friction_alone_holds_between_walls_gets_no_load_factor():
    """A box that only friction could support between walls is locked with dilatancy and unstable without.

    No load presses the sides of the box against the walls.
    """
    blocks = [pushed(1.0, (0.0, -1.0, 0.0)), *walls("left", "right")]
    scene = mo.Scene(joints=FRICTION, blocks=blocks)
    assert mo.solve(scene, "static").status is Status.LOCKED
    result = mo.solve(scene)
    assert result.status is Status.UNSTABLE
    assert result.load_factor is None
    assert Code.WEDGED in [reason.code for reason in result.reasons]
