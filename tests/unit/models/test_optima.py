"""The optimum of each model is that of the problem's matrices, handed to SciPy as they stand."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from scenes import KINDS_OF_JOINTS, WALLS, declared
from scipy.optimize import linprog

import masonry_opt as mo
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.alternation import WEIGHT
from masonry_opt.methods.exact.refiner import Refiner
from masonry_opt.models.cvxpy_exact import CvxpyForces, CvxpyMotion, energy_costs
from masonry_opt.models.cvxpy_standing import CvxpyDriven
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import ShearLimits
from masonry_opt.solvers.cvxpy_engine import has_optimum
from masonry_opt.solvers.registry import find_solver

#: Two solvers, each to 1e-9 of numbers near one.
SAME = 1e-7

SCENES = KINDS_OF_JOINTS | {f"wall {number}": mo.load(WALLS[number - 1]) for number in (1,)}
PROBLEMS = {name: assemble(scene).problem for name, scene in SCENES.items()}


@pytest.fixture(params=PROBLEMS)
def problem(request):
    return PROBLEMS[request.param]


def least_of_forces(problem, load_cost, force_cost, at_yield=None):
    """min a λ + b·q: equilibrium, z ≥ 0, and z = 0 at yield."""
    held = np.zeros(problem.faces, dtype=bool) if at_yield is None else at_yield
    found = linprog(
        np.concatenate([[load_cost], force_cost]),
        A_eq=sp.vstack(
            [
                sp.hstack([problem.live[:, None], problem.B]),
                sp.hstack([np.zeros((held.sum(), 1)), problem.C(problem.friction)[held]]),
            ]
        ),
        b_eq=np.concatenate([-problem.dead, -problem.face_cohesion[held]]),
        A_ub=sp.hstack([np.zeros((problem.faces, 1)), -problem.C(problem.friction)]),
        b_ub=problem.face_cohesion,
        bounds=(None, None),
    )
    return found.fun if found.status == 0 else None


def least_of_motion(problem, cost, slope, velocity_cost=None, within=None):
    """min cost·p + velocity_cost·d: Bᵀd = D p and p ≥ 0, driven by the live load or within bounds of d."""
    b3, faces = 3 * problem.blocks, problem.faces
    rows, right = [sp.hstack([problem.B.T, -problem.D(slope)])], np.zeros(3 * problem.joints)
    if within is None:
        rows.append(np.concatenate([problem.live, np.zeros(faces)])[None, :])
        right = np.append(right, problem.live_norm)
    found = linprog(
        np.concatenate([np.zeros(b3) if velocity_cost is None else velocity_cost, cost]),
        A_eq=sp.vstack(rows),
        b_eq=right,
        bounds=[(None, None) if within is None else within] * b3 + [(0, None)] * faces,
    )
    return found.fun if found.status == 0 else None


def optimum(model):
    assert has_optimum(model.program, find_solver("cvxpy", None), Effort(), "test")
    return float(model.program.value)


def weaker_forces(problem):
    """Forces of less friction, under which nothing slides freely."""
    weaker = replace(problem.law, friction=0.8 * problem.friction)
    q = declared(replace(problem, law=weaker)).solve().state.q
    return q, np.maximum(problem.slacks(q), 0.0)


def test_eq_9_and_eq_10(problem):
    norm = problem.live_norm
    static = -least_of_forces(problem, -norm, np.zeros(3 * problem.joints)) / norm
    kinematic = least_of_motion(problem, problem.face_cohesion, problem.friction, -problem.dead) / norm
    assert static == pytest.approx(kinematic, abs=SAME)
    for formulation in ("static", "kinematic"):
        assert declared(problem, formulation).solve().state.load_factor == pytest.approx(static, abs=SAME)


def test_motion_for_slacks(problem):
    _, z = weaker_forces(problem)
    model = CvxpyMotion(problem, z, problem.dilatancy)
    expected = least_of_motion(problem, z, problem.dilatancy)
    assert optimum(model) == pytest.approx(expected, abs=SAME * problem.live_norm)
    # The rates that follow from the velocities leave the same, and no joint's ends pass into each other.
    d = model.mechanism.d.value
    p = problem.rates(d, problem.dilatancy)
    assert z @ p == pytest.approx(expected, abs=SAME * problem.live_norm)
    assert problem.by_kind(problem.B.T @ d)[:2].min() > -SAME
    found = Refiner(problem, Effort()).mechanism(z)
    assert z @ found[1] == pytest.approx(expected, abs=SAME)
    np.testing.assert_allclose(problem.B.T @ found[0], problem.D(problem.dilatancy) @ found[1], atol=SAME)


def test_a_wall_of_less_friction_leaves_energy():
    """Else the test above compares nothing with nothing."""
    problem = PROBLEMS["wall 1"]
    _, z = weaker_forces(problem)
    assert optimum(CvxpyMotion(problem, z, problem.dilatancy)) > 1e-3


def test_forces_for_rates(problem):
    """Of the associative mechanism, to rounding: of one to 1e-9 alone the program may be unbounded."""
    state = declared(problem, solver="highs").solve().state
    p = problem.rates(state.d, problem.friction)
    cohesion = problem.face_cohesion @ p
    energy = problem.C(problem.friction).T @ p
    expected = least_of_forces(problem, problem.live_norm / WEIGHT, energy) + cohesion
    model = CvxpyForces(problem, energy_costs(problem, p, WEIGHT))
    assert optimum(model) / WEIGHT + cohesion == pytest.approx(expected, abs=10 * SAME)
    q = Refiner(problem, Effort())._least_energy(p)
    balance = problem.B @ q + problem.dead
    load_factor = -float(problem.live @ balance) / float(problem.live @ problem.live)
    cost = problem.slacks(q) @ p + load_factor * problem.live_norm / WEIGHT
    assert cost == pytest.approx(expected, abs=10 * SAME)
    # What was set for this is set back: the least λ follows.
    refiner = Refiner(problem, Effort())
    nothing = np.zeros(problem.faces, dtype=bool)
    least = least_of_forces(problem, 1.0, np.zeros(3 * problem.joints))
    for _ in range(2):
        found = refiner.least(nothing, state.d)
        assert (found is None) == (least is None)
        if found is not None:
            assert found.load_factor == pytest.approx(least, abs=SAME)
        refiner._least_energy(p)


@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_what_a_force_drives(problem, turned):
    """The dead load drives nothing; turned upwards it lifts every block."""
    limits = ShearLimits.true(problem)
    force = turned * problem.dead
    model = CvxpyDriven(replace(problem, dead=force), limits)
    expected = -least_of_motion(problem, problem.face_cohesion, problem.friction, -force, within=(-1, 1))
    assert optimum(model) == pytest.approx(expected, abs=SAME * np.abs(problem.dead).sum())
    assert (expected > 0.1) == (turned < 0)
