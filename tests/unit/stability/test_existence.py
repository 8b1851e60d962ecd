"""Proofs that no load factor exists: their kind, their residuals, and the joints that they name."""

import json
from dataclasses import replace

import numpy as np
import pytest
from atlas.random_scenes import random_scene
from atlas.small_scenes import rectangle
from scenes import block_on_floor, pressed_down, values_of

import masonry_opt as mo
from masonry_opt.drawing.elements import PICTURE_KINDS
from masonry_opt.effort import Effort
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import in_units_of_load
from masonry_opt.result import make_result
from masonry_opt.solution.acceptance import PROOF, Kind
from masonry_opt.solution.answer import (
    Existence,
    FinalState,
    InfeasibilityCertificate,
    certified,
    kinematic_residual,
    ray_residuals,
    static_residual,
)
from masonry_opt.solution.reasons import Code, Status
from masonry_opt.solution.sense import warnings_of
from masonry_opt.solution.solution import Solution
from masonry_opt.solvers.registry import find_solver
from masonry_opt.stability.existence import Cuts, existence

#: A block that is pushed sideways, and 1.5 times as hard downwards, on a floor of friction 2. It would slide
#: at λ = 2 (1 + 1.5 λ).
PUSHED = block_on_floor(width=4.0, height=1.0, friction=2.0, live=(1.0, -1.5))

COULOMB = ["coulomb", "nonassociative", "global"]


def plug(lean: float, live: tuple[float, float], friction: float = 0.5) -> mo.Scene:
    """Return a block between two fixed blocks that widens upwards by ``lean`` on each side."""
    return mo.Scene(
        joints={"friction": friction},
        blocks=[
            mo.Block(name="left", vertices=[(-2, 0), (0, 0), (-lean, 1), (-2, 1)], fixed=True),
            mo.Block(name="plug", vertices=[(0, 0), (1, 0), (1 + lean, 1), (-lean, 1)], weight=1, live=live),
            mo.Block(name="right", vertices=[(1, 0), (3, 0), (3, 1), (1 + lean, 1)], fixed=True),
        ],
    )


def of(scene: mo.Scene) -> InfeasibilityCertificate:
    found = existence(assemble(scene).problem, Effort())
    assert found is not None
    return found


@pytest.mark.parametrize("scene", [pressed_down(), plug(0.2, (0, -1))], ids=["pressed down", "wedged in"])
def test_no_mechanism(scene):
    found = of(scene)
    assert found.existence is Existence.NO_MECHANISM
    assert found.proven
    assert max(found.equilibrium, found.yield_) < PROOF
    for method in ("nonassociative", "coulomb"):
        result = mo.solve(scene, method)
        assert (result.status, result.load_factor) == (Status.UNLIMITED, None)


@pytest.mark.parametrize("method", COULOMB)
def test_friction_that_grows_with_the_load_is_proven_to_hold(method):
    """A mechanism exists, but the face that it moves cannot yield. The proof has one cut of each kind."""
    result = mo.solve(PUSHED, method)
    assert (result.status, result.infeasibility.existence) == (Status.UNLIMITED, Existence.NO_STATE)
    assert values_of(result, Code.JOINTS)["pairs"] == [["A", "floor"]]
    record = json.loads(result.to_json())["infeasibility"]
    assert record["proven"]
    assert record["cut_residual"] <= PROOF
    if method == "coulomb":  # the loop does not run at all
        assert result.lp_solves == 0
        assert result.solvers["existence"] == ["highs"]


def test_an_associative_answer_depends_on_statics_alone():
    result = mo.solve(PUSHED, "static")
    assert result.status is Status.LOCKED
    assert result.infeasibility.existence is Existence.UNBOUNDED
    assert not result.infeasibility.proven


@pytest.mark.parametrize("scene", [block_on_floor(), plug(0.8, (0, 1))])
def test_nothing_is_proven_where_a_load_factor_exists(scene):
    found = of(scene)
    assert found.existence is Existence.UNDECIDED
    assert found.equilibrium is None
    assert mo.solve(scene).infeasibility is None


def test_a_wedge_that_locks_itself_is_clamped():
    """Half of the wedge's angle is below the friction angle, so self-stress could carry any pull. But the
    wedge comes out at its own weight without forces in its joints, so nothing is proven."""
    scene = plug(0.2, (0, 1))
    found = of(scene)
    assert found.existence is Existence.UNBOUNDED
    assert set(found.clamped) == {0, 1}
    assert mo.solve(scene).load_factor == pytest.approx(1.0, rel=1e-7)


@pytest.mark.parametrize("shaped", [lambda scene: scene, mo.extrude], ids=["plane", "space"])
def test_friction_between_fixed_faces_is_named(shaped):
    """Only friction between parallel fixed faces carries the block, and no load causes the compression
    there."""
    result = mo.solve(shaped(plug(0.0, (0, -1))))
    assert result.load_factor is None
    # The numbers are those of joints, not of contact points.
    assert set(result.infeasibility.clamped) == {0, 1}
    assert result.infeasibility.existence is Existence.UNBOUNDED
    named = values_of(result, Code.CLAMPED)["pairs"]
    pairs = {frozenset(("left", "plug")), frozenset(("right", "plug"))}
    assert {frozenset(pair) for pair in named} == pairs
    (warning,) = [warning for warning in result.warnings if warning.code is Code.HELD_BY_CLAMPING]
    assert {frozenset(pair) for pair in warning.values["pairs"]} == pairs
    # Without a solution, there is no warning.
    assert warnings_of(result.assembly, None) == ()


def test_what_only_wedging_would_hold_falls_and_is_named():
    result = mo.solve(plug(-0.1, (0, -1)))
    assert (result.status, result.incremental) == (Status.UNSTABLE, None)
    assert values_of(result.at_incremental, Code.WEDGED)["blocks"] == ["plug"]
    assert values_of(result, Code.WEDGED) == {"load_factor": None, "blocks": ["plug"]}


def test_dilatancy_that_falls_with_stress_is_no_reason_to_claim_more():
    law = {"friction": 2.0, "dilatancy": 0.1, "dilatancy_stress": (0.1, 1.0)}
    assert of(PUSHED.replace(joints=law)).existence is Existence.UNBOUNDED
    assert of(pressed_down().replace(joints=law)).existence is Existence.NO_MECHANISM


@pytest.mark.parametrize("of", [("stack", 8), pytest.param(("arch", 28), marks=pytest.mark.slow)])
def test_random_scenes_that_jam(of):
    result = mo.solve(random_scene(*of))
    assert result.status is Status.UNLIMITED
    assert result.infeasibility.existence is Existence.NO_STATE
    assert 0 < result.infeasibility.cut_residual <= PROOF


@pytest.mark.parametrize("kind", ["stack", pytest.param("wall", marks=pytest.mark.slow)])
def test_no_proof_where_a_state_is_known(kind):
    """If a random scene has a certified load factor, the cuts must not exclude it."""
    for seed in range(2):
        result = mo.solve(random_scene(kind, seed))
        if result.load_factor is not None and result.load_factor >= 0:
            problem = in_units_of_load(result.assembly.problem).problem
            assert not Cuts(problem, 200, Effort()).exclude


@pytest.mark.slow
def test_a_search_that_is_cut_short_proves_nothing():
    problem = in_units_of_load(assemble(random_scene("arch", 28)).problem).problem
    assert Cuts(problem, 1000, Effort()).exclude
    assert not Cuts(problem, 10, Effort()).exclude


def test_residuals_see_what_is_wrong():
    """In a block that is pressed down on a floor, n₁ + n₂ = 1. Errors of 0.01 in a force and in a shear
    appear in the residuals."""
    problem = assemble(pressed_down()).problem
    n = problem.live_norm * np.array([0.5, 0.5, 0.0])
    assert max(ray_residuals(problem, n, problem.dilatancy)) < 1e-15
    nobody = np.zeros(problem.faces, dtype=bool)
    assert kinematic_residual(problem, n, nobody) < 1e-15
    short = 0.99 * n
    assert ray_residuals(problem, short, problem.dilatancy)[0] == pytest.approx(0.01)
    sheared = n + np.array([0.0, 0.0, 0.01 * problem.live_norm])
    assert ray_residuals(problem, sheared, problem.dilatancy)[1] == pytest.approx(0.01)
    tilting = 0.01 * 1.0 / problem.length_unit  # the moment of the shear about the centroid
    assert kinematic_residual(problem, sheared, nobody) == pytest.approx(tilting)
    assert kinematic_residual(problem, sheared, ~nobody) == pytest.approx(tilting)


def test_a_motion_that_gains_no_energy_shows_nothing():
    """The block of weight 1 sinks by 1 and gains the energy 1 while its edges penetrate the floor: they
    cannot be at yield together. If the block rises, it gains no energy."""
    problem = assemble(block_on_floor()).problem
    sinks = np.array([0.0, -1.0, 0.0])
    weight = -problem.dead[1]
    p = problem.rates(sinks, problem.friction)
    p[-2:] = (problem.B.T @ sinks)[:2] / 2
    held = np.arange(problem.faces) >= problem.faces - 2
    assert weight > 0
    assert static_residual(problem, sinks, p, held) < 1e-12
    assert static_residual(problem, sinks, p, np.zeros_like(held)) > 0.1
    assert static_residual(problem, -sinks, -p, held) == np.inf
    assert static_residual(replace(problem, dead=0.5 * problem.dead), sinks, p, held) < 1e-12


def slot(blocks: int) -> mo.Scene:
    """Return blocks in a row between a floor and a roof, the first of them pushed along. Another block is
    outside."""
    row = [
        rectangle(f"b{number}", number, 0, number + 1, 1, weight=1, live=(0 if number else 1, 0))
        for number in range(blocks)
    ]
    row += [rectangle("outside", -5, 0, -4, 1, weight=1), rectangle("floor", -9, -1, 20, 0)]
    return mo.Scene(joints={"friction": 0.5}, blocks=[*row, rectangle("roof", -2, 1, 20, 2)])


@pytest.mark.parametrize("blocks", [1, 4])
def test_dilatancy_names_the_joints_that_lock_and_no_others(blocks):
    """The joints of each block between floor and roof are named, but not that of the block outside."""
    result = mo.solve(slot(blocks), "static")
    assert result.status is Status.LOCKED
    named = values_of(result, Code.JOINTS)
    assert named["status"] == str(result.status)
    expected = {(f"b{number}", other) for number in range(blocks) for other in ("floor", "roof")}
    assert {tuple(pair) for pair in named["pairs"]} == expected
    assert values_of(result, Code.DILATANCY_LOCKS) == {}


@pytest.mark.parametrize(("status", "moves"), [*((one, True) for one in Status), (Status.UNSTABLE, False)])
def test_every_status_can_be_drawn(status, moves):
    assembly = assemble(slot(2))
    problem = assembly.problem
    q, d = np.ones(3 * problem.joints), np.linspace(-1, 1, 3 * problem.blocks)
    found = FinalState(q=q, d=d) if moves else FinalState()
    found = certified(problem, 0.5, q, d) if status.usable else found
    solution = Solution(status, Kind.ASSOCIATIVE, state=found)
    result = make_result(assembly, solution, Effort(), "static", find_solver("cvxpy", None))
    # Draw answers and unstable scenes in every kind of picture.
    for kind in PICTURE_KINDS if status in (Status.OPTIMAL, Status.UNSTABLE) else PICTURE_KINDS[:1]:
        title = result.plot(kind).axes[0].get_title()
        has_other_title = status.usable or status is Status.STABLE
        assert (f"no load factor ({status})" in title) != has_other_title
