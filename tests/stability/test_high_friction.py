"""Friction so high that nothing slides under pressure: answers do not depend on it, nor on its size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scenes import WALLS

import masonry_opt as mo
from masonry_opt.answer.answer import certified
from masonry_opt.problem.assembly import assemble

HIGH = (1e5, 1e6)


@pytest.mark.parametrize("friction", HIGH)
def test_default_gives_a_state_that_holds(friction: float) -> None:
    """Statics of eq. (9) bound it; exact states may lie lower, where blocks that part slide along each other,
    which associative flow at such friction forbids."""
    result = mo.solve(mo.load(WALLS[0]).replace(friction=friction), expected=False)
    assert result.exact
    assert result.certificate.worst <= 1e-8
    assert result.load_factor <= result.associative * (1 + 1e-6)


def pressed(friction: float) -> tuple[mo.Scene, np.ndarray]:
    """A cube on the ground, lifted off it at ten times its weight, and its motion: upwards and along."""
    ground = mo.Block(name="ground", vertices=[(-5, -1), (9, -1), (9, 0), (-5, 0)], fixed=True)
    cube = mo.Block(name="A", vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], weight=1, live=(0.1, 1))
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=[ground, cube]), np.array([1.0, 1, 0])


@pytest.mark.parametrize("friction", [1.0, 1e6])
def test_certificate_knows_shear_in_a_joint_that_opens(friction: float) -> None:
    """n = 1e-9 leaves next to no energy in the opening; but with μ = 1e6 it may carry a shear of 1e-3, by
    which λ is off."""
    scene, d = pressed(friction)
    problem = assemble(scene).problem
    d = d * problem.live_norm / float(problem.live @ d)
    n = 1e-9
    q = np.array([n, 0.0, 0.0])
    answer = certified(problem, 1.0, q, d)
    assert (answer.certificate.complementarity > 1e-8) == (friction > 1)


def test_certificate_counts_slip_of_rounding_as_rounding() -> None:
    """n = 1 with μ = 1e6 has a slack of 1e6, and a slip of 1e-13 is none."""
    scene, _ = pressed(1e6)
    problem = assemble(scene).problem
    for slip, taken in ((1e-13, True), (1e-6, False)):
        d = np.array([slip, 0.0, 0.0])
        live = replace(problem, live=np.array([0.0, 0.0, 1.0]), dead=problem.dead)
        energy = certified(live, 1.0, np.array([1.0, 0, 0]), d).certificate.complementarity
        assert (energy <= 1e-8) == taken
