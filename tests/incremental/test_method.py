"""Method "incremental" compared with calculations by hand, another program and contact dynamics."""

import numpy as np
import pytest
from atlas.random_scenes import random_scene
from contact_dynamics import QUICK, collapse_load
from mappings import SAME
from residuals import residuals
from scenes import (
    CASES,
    KINDS_OF_JOINTS,
    TABLE_1,
    WALLS,
    block_on_floor,
    overhanging,
    pressed_down,
    small_wall,
    solved,
    two_blocks,
    values_of,
)
from scenes_in_space import box_on_floor, corner_wall

import masonry_opt as mo
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.methods.registry import METHODS
from masonry_opt.models.pyomo_mcp import PyomoMcp
from masonry_opt.problem.problem import State
from masonry_opt.solution.load_history import LoadStep
from masonry_opt.solution.reasons import Code
from masonry_opt.solvers.registry import MATRICES

#: Incremental load factors of the walls of Table 1 by an independent program with the same matrices, which
#: follows the equilibrium path without the history of slip. With this history, as in explicit dynamics, wall
#: 5 changes by 0.4 % (dynamics: 0.2154 to 0.2157) and the other walls change by at most 0.3 %.
WALLS_BY_PATH = [0.64154, 0.56401, 0.35582, 0.26374, 0.21439, 0.2964]
SLIP_REMEMBERED = 5e-3

#: Load factors at the end of the load history, by the equilibrium path of another program, to the digits
#: shown. The value of harmonic_3 is by hand.
CASES_BY_PATH = {
    "gilbert/two_blocks": 0.18844,
    "livesley/wedges": 1.28034,
    "closed_forms/pulled_stone": 1.60690,
    "page/prestwood": 0.51883,
    "paterson_zwick/harmonic_3": 1 / 9,
    "bridges/arch_with_fill": 77.7566,
}


@pytest.mark.parametrize("path", TABLE_1)
def test_walls_of_table_1(path):
    result = solved(path, "incremental")
    known = WALLS_BY_PATH[WALLS.index(path)]
    assert result.incremental == pytest.approx(known, rel=SLIP_REMEMBERED)
    assert result.exact


@pytest.mark.parametrize("case", CASES_BY_PATH)
def test_cases_end_in_an_exact_state(case):
    result = solved(CASES / f"{case}.toml", "incremental")
    assert result.exact
    assert result.end == result.load_factor == pytest.approx(CASES_BY_PATH[case], rel=3e-5)
    assert result.incremental >= result.end


@pytest.mark.parametrize(
    ("scene", "by_hand"),
    [(box_on_floor((1.0, 2.0, 3.0), 0.3), 0.3), (box_on_floor((1.0, 2.0, 3.0), 0.6), 1 / 3)],
    ids=["slides", "tips"],
)
def test_boxes_in_space_by_hand(scene, by_hand):
    result = mo.solve(scene, "incremental")
    assert result.reasons[0].code is Code.COLLAPSE
    assert result.load_factor == pytest.approx(by_hand, rel=1e-8)


@pytest.mark.parametrize("scene", [two_blocks(), box_on_floor((2, 2, 1), 0.5)], ids=["plane", "space"])
def test_without_an_exact_state_the_load_factor_is_a_range(certificates, scene):
    """If the certificate of the exact state fails, the result is a range that contains the exact load factor.

    The range lies between a load that is carried and a load that is not.
    """
    exact = solved(scene, "incremental").load_factor
    certificates(1e-6, "complementarity")
    result = mo.solve(scene, "incremental")
    found = values_of(result, Code.RANGE)
    assert found["carried"] <= exact <= found["not_carried"]
    assert found["not_carried"] / found["carried"] - 1 <= IncrementalSettings().tolerance
    assert result.load_factor == result.incremental == found["carried"]
    assert result.end is None
    problem, q = result.assembly.problem, result.solution.q
    assert np.abs(problem.unbalanced(result.load_factor, q)).max() < 1e-6
    assert problem.by_cone.slacks(q).min() > -1e-12


def test_a_load_that_has_no_limit():
    result = mo.solve(pressed_down(), "incremental")
    assert result.load_factor is None
    assert Code.UNBOUNDED in [reason.code for reason in result.reasons]


def test_a_scene_that_falls_from_rest():
    assert mo.solve(overhanging(), "incremental").status is mo.Status.UNSTABLE


def test_settings_are_an_option():
    """With at most 3 small increments, the load factor remains undecided; a dictionary is refused."""
    wide = IncrementalSettings(increment=0.01, smallest_increment=0.01, increments=3)
    result = mo.solve(two_blocks(), "incremental", settings=wide)
    assert result.load_factor is None
    assert values_of(result, Code.UNDECIDED)["steps"] <= 4
    assert "'increments' permits" in result.message
    assert "set a larger value in mo.IncrementalSettings" in result.message
    with pytest.raises(mo.OptionError, match="settings"):
        mo.solve(two_blocks(), "incremental", settings={"tolerance": 0.1})


#: Width b and height h of a block of weight 1 on a floor, and its displacement under a unit horizontal force
#: at its centroid. The unit of length is the closing of the joint under half the weight. The joint shears by
#: twice the force, and the rotation adds (h/b)² times the force.
WIDE = 1.0
HIGH = 2.0
SOFT = 2 + (HIGH / WIDE) ** 2


@pytest.mark.parametrize(("friction", "collapse"), [(0.3, 0.3), (0.7, WIDE / HIGH)], ids=["slides", "tips"])
def test_a_block_is_elastic_up_to_its_first_event_by_hand(friction, collapse):
    """The load–displacement curve of a block is linear up to collapse, with the stiffness by hand, to 1e-7.

    A block that tips is elastic until one end of its joint opens. The two springs of a joint open at the
    moment n b / 2, which is the collapse load. Springs along the whole joint would open at n b / 6.
    """
    curve = solved(block_on_floor(WIDE, HIGH, friction), "incremental", curve=True).curve
    assert curve["load_factor"].iloc[-1] == pytest.approx(collapse, rel=1e-3)
    np.testing.assert_allclose(curve["load_factor"], curve["displacement"] / SOFT, rtol=1e-7)
    assert not curve["jump"].any()


def test_a_curve_begins_under_the_dead_load():
    """The displacement of the curve does not include the displacement under the dead load.

    The live load is inclined, and the stiffness by hand is compared to 1e-7.
    """
    across, down = 1.0, 0.25
    curve = solved(block_on_floor(WIDE, HIGH, 0.3, live=(across, -down)), "incremental", curve=True).curve
    assert curve["load_factor"][0] == curve["displacement"][0] == 0
    way = np.hypot(across, down) * curve["displacement"]
    np.testing.assert_allclose(curve["load_factor"], way / (across**2 * SOFT + down**2), rtol=1e-7)
    assert curve["load_factor"].iloc[-1] == pytest.approx(0.3 / (across - 0.3 * down), rel=1e-3)


def test_a_curve_rises_to_the_incremental_load_factor():
    plain, result = (solved(WALLS[0], "incremental", **given) for given in ({}, {"curve": True}))
    curve = result.curve
    assert plain.curve is None
    assert result.load_factor == plain.load_factor
    assert (np.diff(curve["load_factor"]) > 0).all()
    assert curve["load_factor"].iloc[-1] == pytest.approx(plain.load_factor, rel=1e-2)
    found = values_of(result, Code.CURVE)
    assert (found["states"], found["jumps"]) == (len(curve), curve["jump"].sum())
    for column, moves in (("starts_sliding", "sliding"), ("starts_opening", "opening")):
        started = [tuple(pair) for pairs in curve[column] for pair in pairs]
        assert len(started) == len(set(started)) >= curve[moves].max()


def test_a_curve_depends_on_no_units():
    base = small_wall(6, 4)
    one, other = (
        solved(scene, "incremental", curve=True).curve for scene in (base, SAME["in millimetres"](base))
    )
    np.testing.assert_allclose(one["displacement"], other["displacement"], rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(one["load_factor"], other["load_factor"], rtol=1e-6)
    assert one[["sliding", "opening"]].equals(other[["sliding", "opening"]])


def test_steps_are_told_as_they_are_made_and_are_the_rows_of_the_history():
    """Each load step is reported once, and the reported steps are the rows of the default's history."""
    steps: list[LoadStep] = []
    history = mo.solve(small_wall(2, 1), progress=steps.append).history
    assert [step.iteration for step in steps] == history["iteration"].tolist()
    assert [step.load_factor for step in steps] == history["load_factor"].tolist()
    assert [step.displacement for step in steps] == pytest.approx(history["displacement"].tolist())
    assert history["iteration"].tolist() == list(range(1, len(steps) + 1))
    begun = ("begins_to_slide", "begins_to_open", "begins_to_stick")
    assert not any(history[column][0] for column in begun)
    assert any(history["begins_to_open"])


@pytest.mark.parametrize("method", ["coulomb", "incremental"])
def test_an_interrupt_goes_through(method):
    def interrupt(step):
        if step.iteration == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        mo.solve(small_wall(), method, progress=interrupt, incremental=False)


@pytest.mark.slow
def test_two_runs_are_the_same_to_the_bit():
    one, other = (mo.solve(small_wall(2, 2), incremental=False) for _ in range(2))
    assert one.load_factor == other.load_factor
    np.testing.assert_array_equal(one.solution.q, other.solution.q)
    np.testing.assert_array_equal(one.solution.d, other.solution.d)
    assert one.history.equals(other.history)


@pytest.mark.parametrize("method", [name for name, method in METHODS.items() if MATRICES in method.solvers])
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow if name == "strength" else ()) for name in KINDS_OF_JOINTS],
)
def test_what_methods_on_matrices_end_with_is_a_state_of_the_declared_problem(name, method):
    """The final state satisfies all equations and complementary pairs of the model in Pyomo, to 1e-8."""
    result = solved(KINDS_OF_JOINTS[name], method)
    assert (result.model, result.solver) == (MATRICES, "newton")
    problem, found = result.assembly.problem, result.solution.state
    p = problem.rates(found.d, problem.dilatancy)
    left = residuals(PyomoMcp(problem), State(result.load_factor, found.q, found.d, p))
    forces, speeds = np.abs(found.q).max(), np.abs(found.d).max()
    np.testing.assert_allclose(left.equilibrium, 0, atol=1e-8 * forces)
    np.testing.assert_allclose(left.compatibility, 0, atol=1e-8 * speeds)
    assert left.live_work == pytest.approx(0, abs=1e-8 * problem.live_norm)
    assert left.z.min() >= -1e-8 * forces
    assert left.p.min() >= -1e-8 * speeds
    assert left.z @ left.p <= 1e-8 * result.load_factor * problem.live_norm


@pytest.mark.parametrize(
    "scene",
    [
        pytest.param(mo.load(WALLS[1]), id="wall_2", marks=pytest.mark.slow),
        # The stone slips under the dead load, and has exact states from λ = 1.3 on.
        pytest.param(mo.load(CASES / "closed_forms" / "pulled_stone.toml"), id="pulled_stone"),
        # The wall has an exact state at a seventh of its incremental load factor.
        pytest.param(random_scene("wall", 77006), id="77006", marks=pytest.mark.slow),
    ],
)
def test_contact_dynamics_carries_it_to_a_hundredth(scene):
    load_factor = solved(scene, "incremental").load_factor
    assert collapse_load(scene, 1.3 * load_factor, QUICK) == pytest.approx(load_factor, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [910017, 910061, 910064, 860067])
def test_contact_dynamics_carries_scenes_that_lose_load_as_they_move(seed):
    """Contact dynamics agrees to 1 % if the load falls after the onset of collapse.

    The blocks move on under a load that is a ninth lower, much lower, or below zero.
    """
    scene = random_scene("tessellation", seed)
    expected = mo.solve(scene, "incremental").incremental
    assert collapse_load(scene, 1.3 * expected, QUICK) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("method", ["incremental", "coulomb", "nonassociative"])
def test_nothing_weighs_anything(method):
    """A block without weight and cohesion has λ = 0, to 1e-6, because any load moves it."""
    result = mo.solve(block_on_floor(weight=0.0), method)
    assert abs(result.load_factor) < 1e-6


def spread(case, draws):
    return values_of(mo.solve(case, "incremental", spread=draws), Code.SPREAD)


@pytest.mark.slow
def test_two_blocks_bear_any_load_of_their_continuum_by_self_stress():
    """Random self-stress of the two blocks spreads λ over the whole range of exact states, 0.15 to 0.25.

    The range is that of Gilbert et al. (2006); 0.25 is the associative load factor.
    """
    found = spread(CASES / "gilbert" / "two_blocks.toml", 30)
    least, most = found["stress"]
    assert 0.15 - 1e-6 <= least < 0.16
    assert 0.24 < most <= 0.25 + 1e-6
    # With equal contacts, the load history from rest ends at 0.1884.
    assert least < found["stiffness"][0] < 0.1884 < found["stiffness"][1] < most
    assert found["without"] == 0


@pytest.mark.slow
@pytest.mark.parametrize(("number", "least", "most"), [(1, 0.6391, 0.6430), (5, 0.2100, 0.2297)])
def test_ranges_of_walls_are_those_of_an_independent_program(number, least, most):
    """The spread of two walls under random self-stress lies within the range of an independent program.

    In 60 draws, that program found 0.6410 to 0.6429 (wall 1), 0.2104 to 0.2296 (wall 5), or a lower state.
    """
    found = spread(WALLS[number - 1], 10)
    for low, high in (found["stress"], found["stiffness"]):
        assert least <= low <= high <= most
    assert found["stress"][1] - found["stress"][0] > 1e-3


@pytest.mark.slow
def test_a_corner_in_space():
    """The incremental load factor of a corner wall is that of another program, 0.351867439, to 0.5 %.

    The other program follows the equilibrium path.
    """
    result = mo.solve(corner_wall(3, 2, 4, 0.6), "incremental")
    assert result.incremental == pytest.approx(0.351867439, rel=SLIP_REMEMBERED)
