"""The incremental analysis: load factors by hand, memory of contacts, preload, invariance, and loads without
limit."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from atlas.random_scenes import random_scene
from mappings import mapped, mirrored, shuffled, turned
from scenes import CASES, block_on_floor, on_floor, overhanging, small_wall, two_blocks
from scenes_in_space import corner_wall, pushed_box
from speeds import slow

import masonry_opt as mo
from masonry_opt.methods.incremental.analysis import End, IncrementalAnalysis, IncrementalResult
from masonry_opt.methods.incremental.collapse_state import find_collapse_state
from masonry_opt.methods.incremental.contact_law import mean_force_and_compliance
from masonry_opt.methods.incremental.equilibrium import Equilibrium, EquilibriumSolver
from masonry_opt.methods.incremental.settings import IncrementalSettings
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.blocks import rectangle


def analysed(scene: mo.Scene, **settings: float) -> IncrementalResult:
    return IncrementalAnalysis(assemble(scene).problem, IncrementalSettings(**settings)).run()


@cache
def analysed_once(made: Callable[[], mo.Scene]) -> IncrementalResult:
    """Return the analysis of the scene that a function returns, which several tests compare with others."""
    return analysed(made())


def two_blocks_by_hand(friction: float) -> float:
    """Return the load factor at which A slides below B, from springs under every joint end.

    Block B closes its joints by b0 + b1 x, and block A by a0 + a1 x. The stiffness of springs is the length
    of their joints: 1 at x = 0, 1, 2, 3 below B, and 3 at x = 2, 5 below A. Four equations balance forces and
    moments about x = 0, y = 0.5. For any force N between A and B, the shears μ N above A and μ (1 + N) below
    it add the moment μ / 2.
    """
    below_b = [(0, np.array([1, 0, 0, 0])), (1, np.array([1, 1, 0, 0]))]
    between = [(x, np.array([1, x, -1, -x])) for x in (2, 3)]
    below_a = [(x, 3 * np.array([0, 0, 1, x])) for x in (2, 5)]
    on_b, on_a = below_b + between, [*below_a, *((x, -force) for x, force in between)]
    matrix = [
        sum(force for _, force in on_b),
        sum(x * force for x, force in on_b),
        sum(force for _, force in on_a),
        sum(x * force for x, force in on_a),
    ]
    closing = np.linalg.solve(matrix, [1, 1.5, 1, 3.5 + friction / 2])
    pressed = float(sum(force for _, force in between) @ closing)
    return friction * (1 + 2 * pressed)


def test_two_blocks_by_hand():
    result = analysed(two_blocks(0.1))
    assert result.end is End.COLLAPSE
    assert result.load_factor == pytest.approx(two_blocks_by_hand(0.1), rel=1e-9)
    assert result.state.exact
    assert result.carried <= result.load_factor <= result.not_carried


@pytest.mark.parametrize(
    ("friction", "expected"),
    [(0.6, 0.5), (0.3, 0.3)],
    ids=["it overturns: width / height", "it slides: friction"],
)
def test_a_block_by_hand(friction, expected):
    assert analysed(block_on_floor(friction=friction)).load_factor == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("angle", [0.0, 30.0, 47.0])
def test_a_box_that_slides_by_hand(angle):
    """The box slides at λ = μ in every direction, because friction in space is a cone."""
    result = analysed(pushed_box((2.0, 2.0, 1.0), 0.3, angle))
    assert result.load_factor == pytest.approx(0.3, rel=1e-9)
    assert result.state.exact


def test_a_block_of_limited_strength_by_hand():
    """By hand, the block fails when the moment λ · 1 reaches n (1 - n / (f_c L)) / 2 = 0.375. Chords are at
    most 0.65 % below this value."""
    problem = assemble(block_on_floor()).problem
    law = replace(problem.law, crushing=np.array([0]), crushing_force=np.array([4.0]))
    result = IncrementalAnalysis(replace(problem, law=law)).run()
    assert 0.375 * (1 - 0.0065) <= result.load_factor <= 0.375


def test_a_tie_that_yields_by_hand():
    """A wide block slides at λ = μ + T, where T is the strength of a horizontal rod through its centroid."""
    tie = mo.Tie(between=("A", "ground"), at=((0.5, 0.5), (-4, 0.5)), strength=0.4)
    block = mo.Block(name="A", vertices=rectangle(0, 4, 0, 1), weight=1, live=(1, 0))
    result = analysed(on_floor(block, friction=0.3, ties=[tie]))
    assert result.load_factor == pytest.approx(0.7, rel=1e-9)


def test_preload_of_a_symmetric_beam():
    """A beam is on three equal piers, and each end of each joint carries a sixth of its weight. Statics alone
    do not determine these forces."""
    piers = [mo.Block(name=f"pier {x}", vertices=rectangle(x, x + 1, 0, 1), fixed=True) for x in (0, 2, 4)]
    beam = mo.Block(name="beam", vertices=rectangle(0, 5, 1, 2), weight=1, live=(1, 0))
    problem = assemble(mo.Scene(joints=mo.JointDefaults(friction=0.5), blocks=[beam, *piers])).problem
    preload = IncrementalAnalysis(problem).preload
    np.testing.assert_allclose(preload.response.forces[:2], 1 / 6, rtol=1e-9)


def test_forces_under_the_dead_load_depend_on_what_the_contacts_remember():
    """After a push is removed, a shear remains, because the floor remembers the slip of one edge."""
    problem = assemble(two_blocks(0.1)).problem
    solver = EquilibriumSolver(problem)
    rest = solver.equilibrate(solver.at_rest(), problem.dead)
    pushed = solver.equilibrate(rest.state, problem.dead + 0.18 * problem.live)
    back = solver.equilibrate(pushed.state, problem.dead)
    assert isinstance(back, Equilibrium)
    assert pushed.response.sliding.any()
    assert not back.response.sliding.any()
    assert np.abs(back.response.forces - rest.response.forces).max() > 1e-2
    again = solver.equilibrate(back.state, problem.dead + 0.18 * problem.live)
    np.testing.assert_allclose(again.response.forces, pushed.response.forces, atol=1e-6)


def test_forces_that_are_known_from_rest_are_the_preload():
    problem = assemble(two_blocks(0.1)).problem
    analysis = IncrementalAnalysis(problem)
    settled = analysis.solver.law.of_problem(analysis.preload.response.forces)
    again = IncrementalAnalysis(replace(problem, settled=settled)).run()
    assert again.load_factor == pytest.approx(two_blocks_by_hand(0.1), rel=1e-9)


def test_a_block_without_support_does_not_carry_its_weight():
    result = analysed(overhanging())
    assert result.end is End.UNSTABLE
    assert result.load_factor is None


def test_a_load_within_the_cone_of_friction_has_no_limit():
    """The resultant has a slope of at most 0.2 / 1, within friction, and meets the floor within the joint for
    every λ."""
    result = analysed(block_on_floor(width=2.0, height=1.0, live=(0.2, -1.0)))
    assert result.end is End.UNBOUNDED
    assert result.load_factor is None
    assert len(result.history.steps) <= 3


def test_a_wedged_scene_has_no_limit():
    """The stones jam: above some load, the response is linear without limit, as another program confirms."""
    result = analysed(random_scene("arch", 1_400_012))
    assert result.end is End.UNBOUNDED


SCENES = {
    "arch": lambda: random_scene("arch", 1_400_003),
    "wall": lambda: random_scene("wall", 1_400_003),
    "cohesion": lambda: small_wall(cohesion=0.05),
}


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
@pytest.mark.parametrize(
    ("change", "factor"),
    [
        (lambda scene: mapped(scene, turned(1.1), turned(1.1)), 1.0),
        (lambda scene: mapped(scene, mirrored, mirrored), 1.0),
        *slow((shuffled, 1.0)),
        *slow((lambda scene: mapped(scene, lambda v: (20 * v[0], 20 * v[1]), length=20.0), 1.0)),
        (lambda scene: mapped(scene, dead=50.0, live=25.0), 2.0),
    ],
    ids=["turned", "mirrored", "renumbered", "larger", "heavier"],
)
def test_the_load_factor_depends_on_no_axes_units_or_numbers(scene, change, factor):
    before, after = analysed_once(scene), analysed(change(scene()))
    assert after.end is before.end is End.COLLAPSE
    assert after.load_factor == pytest.approx(factor * before.load_factor, rel=1e-7)


def test_history_of_two_blocks():
    """The scene becomes softer from one load step to the next. Block A begins to slide below B and on the
    floor."""
    history = analysed(two_blocks(0.1)).history
    assert history.load_factors[0] == history.displacements[0] == 0
    assert (np.diff(history.load_factors) > 0).all()
    softness = np.diff(history.displacements) / np.diff(history.load_factors)
    assert len(softness) > 1
    assert (np.diff(softness) > 0).all()
    assert history.jumps == 0
    begins = [(after.sliding & ~before.sliding).sum() for before, after in pairwise(history.steps)]
    assert sum(begins) == 1


def test_states_between_load_steps_are_interpolated():
    problem = assemble(two_blocks(0.1)).problem
    history = IncrementalAnalysis(problem).run().history
    low, high = history.steps[-2:]
    d, forces = history.state_at((low.load_factor + high.load_factor) / 2)
    np.testing.assert_allclose(d, (low.d + high.d) / 2)
    np.testing.assert_allclose(forces, (low.forces + high.forces) / 2)
    load_factor = (low.load_factor + high.load_factor) / 2
    assert np.abs(problem.unbalanced(load_factor, forces)).max() < 1e-6
    with pytest.raises(ValueError, match=r"does not contain the load factor .*: choose a"):
        history.state_at(history.load_factors[-1] + 0.1)


def test_progress_is_called_with_each_load_step():
    steps = []
    result = IncrementalAnalysis(assemble(two_blocks(0.1)).problem).run(steps.append)
    assert tuple(steps) == result.history.steps


def test_two_programs_find_the_exact_state_from_the_collapse():
    """If the mechanism is unique, displacement control and the two programs find the same state."""
    analysis = IncrementalAnalysis(assemble(block_on_floor(friction=0.3)).problem)
    result = analysis.run()
    state = find_collapse_state(analysis.solver, result.collapse)
    assert state.load_factor == pytest.approx(0.3, rel=1e-9)
    without = replace(result, state=None)
    assert without.with_state(state).load_factor == pytest.approx(0.3, rel=1e-9)
    lower = replace(state, load_factor=0.2)
    assert without.with_state(lower).state is None
    assert without.with_state(lower).state_in_motion is lower
    assert without.with_state(replace(state, load_factor=0.4)) is without


@pytest.mark.parametrize(
    ("work", "limit", "is_collapse"),
    [(0.0, 1.0, False), (0.9, 1.0, False), (1.1, 1.0, True), (1.1, 0.9, False), (-1.1, 1.0, False)],
)
def test_unbalanced_forces_explain_an_excess_up_to_their_work(work, limit, is_collapse):
    """A state lies 1e-4 below the load that is carried. The work and its limit are in units of 1e-4."""
    analysis = IncrementalAnalysis(assemble(block_on_floor(friction=0.3)).problem)
    result = analysis.run()
    d = result.state.d
    lower = replace(result.state, load_factor=result.carried - 1e-4)
    unbalanced = 1e-4 * work * d / (d @ d)
    found = replace(result, state=None, unbalanced=unbalanced, most_excess=1e-4 * limit + 1e-9)
    assert (found.with_state(lower).state is lower) == is_collapse


def test_softer_contacts_change_displacements_alone():
    """With a tenth of all stiffnesses, the load factor is the same and the displacements are ten times as
    large."""
    problem = assemble(two_blocks(0.1)).problem
    _, compliance = mean_force_and_compliance(problem)
    usual, soft = (IncrementalAnalysis(problem, compliance=c * compliance).run() for c in (1.0, 10.0))
    assert soft.load_factor == pytest.approx(usual.load_factor, rel=1e-9)
    assert soft.history.state_at(0.1)[0] == pytest.approx(10 * usual.history.state_at(0.1)[0], rel=1e-6)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("size", [1e-4, 1.0, 1e4])
def test_blocks_with_many_joints_on_parallel_ties(size):
    """A slab hangs by 128 teeth on a comb, which vertical ties hold: the comb can move sideways.

    The joints of the slab carry one weight, as do those of a stone on the floor. The mean force at the two
    ends of a joint is therefore 1/129.
    """
    teeth = 128
    corners = [(0, 4), (2 * teeth, 4)]
    for left in range(2 * teeth - 2, -2, -2):
        corners += [(left + 2, 2), (left + 1, 2), (left + 1, 1), (left, 1)]
    scaled = [(size * x, size * y) for x, y in corners]
    blocks = [
        mo.Block(name="comb", vertices=scaled, weight=4),
        mo.Block(name="slab", vertices=rectangle(0, size * 2 * teeth, 0, size), weight=4),
        mo.Block(name="floor", vertices=rectangle(-9 * size, -8 * size, -size, 0), fixed=True),
        mo.Block(name="stone", vertices=rectangle(-9 * size, -8 * size, 0, size), weight=4),
    ]
    ends = [((x, 4 * size), (x, 9 * size)) for x in (0.0, 2.0 * teeth * size)]
    ties = [mo.Tie(between=("comb", "ground"), at=at, strength=50) for at in ends]
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.5), blocks=blocks, ties=ties)
    mean_force, _ = mean_force_and_compliance(assemble(scene).problem)
    assert mean_force == pytest.approx(1 / (teeth + 1), rel=1e-9)


def test_walls_in_space_end_in_an_exact_state():
    result = analysed(corner_wall(2, 2, 3))
    assert result.end is End.COLLAPSE
    assert result.state is not None
    assert result.state.exact
    assert math.isfinite(result.not_carried)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_a_peak_above_the_exact_state_is_bisected(tolerance):
    """Two wedges carry 0.1577, above the exact state at 0.1325, in which they then move.

    A program that follows the equilibrium path, with joints rounded by a hundredth of the mean force, reaches
    a maximum of 0.157699. The load carried differs from this value by the rounding, about 3e-5.
    """
    result = analysed(mo.load(CASES / "gilbert" / "wedge_blocks.toml"), tolerance=tolerance)
    assert result.end is End.COLLAPSE
    assert result.state is None
    assert result.carried == pytest.approx(0.157699, rel=1e-4)
    assert result.carried < result.not_carried < (1 + tolerance) * result.carried


def test_an_exact_state_below_the_load_that_is_carried_is_no_limit():
    """With a fine tolerance, the analysis ends at the same load as with the default tolerance."""
    scene = random_scene("tessellation", 7530005)
    usual, fine = analysed(scene), analysed(scene, tolerance=1e-5)
    assert fine.end is End.COLLAPSE
    assert fine.carried == pytest.approx(usual.carried, rel=1e-5)
