"""Certified bounds on the associative load factor enclose closed forms and published values, closely."""

import dataclasses

import numpy as np
import pytest
from atlas.random_scenes_in_space import KINDS, random_scene_in_space
from atlas.small_scenes import block, chute, confined, overhanging
from scenes import CASES, block_on_floor, small_wall, two_blocks
from scenes_in_space import box_on_floor, corner_wall, pushed_box
from speeds import slow_after

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.solvers.driver import Driver
from masonry_opt.studies.compare.accuracy import LARGEST_BOUND_WIDTH, certified_bounds

#: Relative rounding error of a bound in double precision.
_ROUNDING = 1e-12

#: Width, height and friction of blocks.
BLOCKS = [(1, 2, 0.6), (1, 2, 0.4), (3, 1, 0.7), (1, 4, 0.1)]
NINE, ONE = np.tan(np.radians([9, 1]))


@pytest.mark.parametrize(
    ("scene", "load_factor", "rounding"),
    [
        # A block overturns or slides at min(w / h, μ); with cohesion, at μ + c L / W with L = 3 and W = 1.
        *((block_on_floor(w, h, mu), min(w / h, mu), _ROUNDING) for w, h, mu in BLOCKS),
        (block_on_floor(3, 0.2, 0.3).replace(cohesion=0.05), 0.3 + 0.05 * 3, _ROUNDING),
        # The load factor is 2.5 μ by Fig. 6 of the paper; one joint cannot slide.
        (two_blocks(0.1), 0.25, _ROUNDING),
        # The load factor is 1 + (t9 − t1) / (t9 + t1) with t(x) = tan x°, Fig. 8 of the paper. The corners in
        # the case file have 12 digits.
        (mo.load(CASES / "livesley" / "wedges.toml"), 1 + (NINE - ONE) / (NINE + ONE), 1e-10),
        # The load factor is that of Table 1 of the paper, to its last digit.
        (mo.load(CASES / "ferris_tinloi" / "wall_1.toml"), 0.64286, 5e-6 / 0.64286),
        # In space a box slides at λ = μ in any direction.
        *((pushed_box((4.0, 4.0, 1.0), 0.3, angle), 0.3, _ROUNDING) for angle in (0.0, 20.0)),
    ],
)
def test_bounds_hold_what_is_known(scene, load_factor, rounding):
    bounds = certified_bounds(assemble(scene).problem)
    assert bounds.lower <= load_factor * (1 + rounding)
    assert bounds.upper >= load_factor * (1 - rounding)
    assert bounds.width <= LARGEST_BOUND_WIDTH


@pytest.mark.parametrize("scene", [small_wall(), corner_wall(2, 2, 2)])
def test_bounds_hold_whatever_the_solver_says(monkeypatch, scene):
    """With errors of 1e-3 in the answers of the solver, bounds are wider but still valid."""
    problem = assemble(scene).problem
    sharp = certified_bounds(problem)
    solve, rng = Driver.solve, np.random.default_rng(0)

    def wrong(driver, nearly=False):
        answer = solve(driver, nearly)
        state = answer.state
        off = dataclasses.replace(
            state,
            load_factor=state.load_factor * 1.001,
            q=state.q + 1e-3 * rng.standard_normal(state.q.shape),
            d=state.d + 1e-3 * rng.standard_normal(state.d.shape),
        )
        return dataclasses.replace(answer, state=off)

    monkeypatch.setattr(Driver, "solve", wrong)
    loose = certified_bounds(problem)
    assert loose.finite
    assert loose.width > 1e-6
    assert loose.lower <= sharp.lower + _ROUNDING
    assert loose.upper >= sharp.upper - _ROUNDING


@pytest.mark.slow
def test_a_facade_is_certified_at_default_settings():
    """The associative λ of a façade with 2 × 6 openings is certified to 2e-7 at the default tolerance."""
    path = CASES / "gilbert" / "facade_2x6.toml"
    bounds = certified_bounds(assemble(mo.load(path)).problem)
    assert bounds.width < 2e-7
    found = mo.solve(path, "static").load_factor
    assert found == pytest.approx(bounds.lower, rel=2e-7)
    assert found == pytest.approx(bounds.upper, rel=2e-7)


@pytest.mark.parametrize(
    ("scene", "falls"),
    [
        (overhanging()(CASES), True),
        # The blocks are locked by dilatancy, loaded without work, and pressed on the ground.
        *((made(CASES), False) for made in (confined(0.5), chute(), block(1, 1, 0.5, live=(0.0, -1.0)))),
        (box_on_floor((1.0, 1.0, 1.0), 0.3, live=(0, 0, -1)), False),
        # A dead force equal to the weight acts along the floor, as on a ramp of 45°.
        (box_on_floor((1.0, 1.0, 1.0), 0.3, dead=(1, 0, 0)), True),
    ],
)
def test_what_falls_or_carries_any_load_has_no_bounds(scene, falls):
    bounds = certified_bounds(assemble(scene).problem)
    assert (bounds.unstable, bounds.unlimited, bounds.finite) == (falls, not falls, False)


COHESIVE = mo.JointDefaults(friction=0.5, cohesion=0.02)
WALLS_IN_SPACE = [
    corner_wall(3, 2, 4),
    corner_wall(2, 2, 3).model_copy(update={"joints": COHESIVE}),
    *(random_scene_in_space(kind, 0) for kind in KINDS),
]


@pytest.mark.parametrize("scene", slow_after(2, WALLS_IN_SPACE))
def test_bounds_in_space_are_close(scene):
    """Bounds in space are closer than 1e-8 and enclose the associative load factor, to 1e-7."""
    bounds = certified_bounds(assemble(scene).problem)
    assert bounds.width <= 1e-8
    found = mo.solve(scene, "static").load_factor
    assert bounds.lower * (1 - 1e-7) <= found <= bounds.upper * (1 + 1e-7)
