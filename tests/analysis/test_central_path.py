"""The path of centres, which ends where a pass that only lowers the products stalls."""

import pytest
from atlas.large_scenes import rubble
from scenes import CASES, pressed_down

import masonry_opt as mo
from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import certified
from masonry_opt.methods.mcp.central_path import CentralPath
from masonry_opt.problem.assembly import assemble


def cubes(friction: float) -> mo.Scene:
    """One cube on the other, on the ground, each pushed by its weight."""
    column = [
        mo.Block(name=str(y), vertices=[(0, y), (1, y), (1, y + 1), (0, y + 1)], weight=1, live=(1, 0))
        for y in range(2)
    ]
    ground = mo.Block(name="ground", vertices=[(-3, -1), (4, -1), (4, 0), (-3, 0)], fixed=True)
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=[*column, ground])


@pytest.mark.parametrize(
    ("friction", "load_factor"), [(0.4, 0.4), (0.6, 0.5)], ids=["slides", "overturns about its toe"]
)
def test_path_ends_at_the_closed_form(friction: float, load_factor: float) -> None:
    """Two cubes overturn as one at half their width over their height, the upper slides at friction."""
    *_, last = CentralPath(assemble(cubes(friction)).problem).centres()
    assert last.is_end
    assert last.state.load_factor == pytest.approx(load_factor, rel=1e-8)


def test_end_is_a_state_of_friction() -> None:
    """Certified by the residuals of the true law, with no program in between, below the associative value."""
    problem = assemble(mo.load(CASES / "ferris_tinloi" / "wall_1.toml")).problem
    *_, last = CentralPath(problem).centres()
    state = last.state
    assert not certified(problem, state.load_factor, state.q, state.d).failing(Kind.ONE_PASS)
    assert 0.638 < state.load_factor < 0.64286


def test_path_does_not_begin_where_nothing_collapses() -> None:
    """Pressed down, nothing moves: λ is unlimited."""
    assert not list(CentralPath(assemble(pressed_down()).problem).centres())


@pytest.mark.slow
def test_default_follows_the_path_where_no_pass_leads_to_a_state() -> None:
    """Of rubble walls of 60 stones from seed 170000 on the third: 17 passes lead to none."""
    result = mo.solve(rubble(60, 170002))
    assert result.exact
    assert result.load_factor < result.associative
