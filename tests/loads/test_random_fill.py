"""Random walls under fill that presses: certified, dual, and never above the associative load factor."""

import pytest
from atlas.held_scenes import filled

import masonry_opt as mo
from masonry_opt.answer.reasons import Status


@pytest.mark.parametrize("seed", range(4))
def test_static_and_kinematic_agree_and_coulomb_states_are_exact_and_no_higher(seed):
    scene = filled(seed)
    found = mo.solve(scene, expected=False)
    if found.load_factor is None:
        assert found.status in (Status.UNSTABLE, Status.JAMMED, Status.UNLIMITED)
        return
    static, kinematic = (mo.solve(scene, method, solver="highs") for method in ("static", "kinematic"))
    assert static.load_factor == pytest.approx(kinematic.load_factor, rel=1e-8)
    assert found.exact
    assert found.load_factor <= static.load_factor * (1 + 1e-8)
    forces = found.pressures
    room = 1e-9 * forces["highest"]
    assert (forces["force"] >= forces["lowest"] - room).all()
    assert (forces["force"] <= forces["highest"] + room).all()
