"""Optima of models are those of the problem's matrices, and rows of products exclude no collapse state."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.sparse as sp
from atlas.random_scenes import random_scene
from scenes import CASES, KINDS_OF_JOINTS, UNCRUSHED, WALLS, declared, small_wall
from scipy.optimize import linprog

import masonry_opt as mo
from masonry_opt.effort import Effort
from masonry_opt.methods.bounds.products import distances
from masonry_opt.methods.bracket.relaxation import bounds_of, tightened
from masonry_opt.methods.exact.refiner import Refiner
from masonry_opt.methods.exact.settings import SEARCH
from masonry_opt.models.cvxpy_exact import CvxpyForces, CvxpyMotion
from masonry_opt.models.cvxpy_standing import CvxpyDriven
from masonry_opt.models.pyomo_products import PyomoProducts
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.edges import EdgeFactors
from masonry_opt.problem.problem import ShearLimits, State
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solvers.cvxpy_engine import has_optimum
from masonry_opt.solvers.highs import LinearProgram
from masonry_opt.solvers.registry import find_solver

#: Tolerance of comparisons of two solvers, each with a tolerance of 1e-9, for numbers near 1.
SAME = 1e-7


@pytest.fixture(scope="module", params=[*KINDS_OF_JOINTS, "wall 1"])
def problem(request):
    scene = KINDS_OF_JOINTS.get(request.param) or mo.load(WALLS[0])
    return assemble(scene).problem


def least_of_forces(problem, load_cost, force_cost):
    """Return the least a λ + b·q subject to equilibrium and z ≥ 0, or None if there is no optimum."""
    found = linprog(
        np.append(load_cost, force_cost),
        A_eq=sp.hstack([problem.live[:, None], problem.B]),
        b_eq=-problem.dead,
        A_ub=sp.hstack([np.zeros((problem.faces, 1)), -problem.C(problem.friction)]),
        b_ub=problem.face_cohesion,
        bounds=(None, None),
    )
    return found.fun if found.status == 0 else None


def least_of_motion(problem, cost, slope, velocity_cost=None, within=None):
    """Return the least cost·p + velocity_cost·d subject to Bᵀd = D p and p ≥ 0, or None if there is no
    optimum.

    The live load drives the motion, or d is within bounds.
    """
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


def test_eq_9_and_eq_10(problem):
    norm = problem.live_norm
    static = -least_of_forces(problem, -norm, np.zeros(3 * problem.joints)) / norm
    kinematic = least_of_motion(problem, problem.face_cohesion, problem.friction, -problem.dead) / norm
    assert static == pytest.approx(kinematic, abs=SAME)
    for formulation in ("static", "kinematic"):
        assert declared(problem, formulation).solve().state.load_factor == pytest.approx(static, abs=SAME)


def test_motion_for_slacks(problem):
    # With these forces, of less friction, no joint slides freely.
    weaker = replace(problem.law, friction=0.8 * problem.friction)
    z = np.maximum(problem.slacks(declared(replace(problem, law=weaker)).solve().state.q), 0.0)
    model = CvxpyMotion(problem, z, problem.dilatancy)
    expected = least_of_motion(problem, z, problem.dilatancy)
    # Otherwise, both optima could be zero. Wall 1 has 33 blocks, more than each of the other scenes.
    assert expected > 1e-3 or problem.blocks < 33
    assert optimum(model) == pytest.approx(expected, abs=SAME * problem.live_norm)
    # The rates of the velocities have the same cost, and no ends of joints penetrate.
    d = model.mechanism.d.value
    p = problem.rates(d, problem.dilatancy)
    assert z @ p == pytest.approx(expected, abs=SAME * problem.live_norm)
    assert problem.by_kind(problem.B.T @ d)[:2].min() > -SAME
    p, d = Refiner(problem, Effort()).mechanism(z)
    assert z @ p == pytest.approx(expected, abs=SAME)
    np.testing.assert_allclose(problem.B.T @ d, problem.D(problem.dilatancy) @ p, atol=SAME)


def test_forces_for_rates(problem):
    """The rates are those of the associative mechanism, to rounding errors. With errors of 1e-9, the program
    may be unbounded."""
    state = declared(problem, solver="highs").solve().state
    p = problem.rates(state.d, problem.friction)
    cohesion = problem.face_cohesion @ p
    energy = problem.C(problem.friction).T @ p
    expected = least_of_forces(problem, problem.live_norm / SEARCH.weight, energy) + cohesion
    model = CvxpyForces(problem, problem.energy_costs(p, SEARCH.weight))
    assert optimum(model) / SEARCH.weight + cohesion == pytest.approx(expected, abs=10 * SAME)
    refiner, costs = Refiner(problem, Effort()), problem.energy_costs(p, SEARCH.weight)
    assert refiner._forces_at(*costs)
    q = refiner.statics.values("q")
    balance = problem.B @ q + problem.dead
    load_factor = -float(problem.live @ balance) / float(problem.live @ problem.live)
    cost = problem.slacks(q) @ p + load_factor * problem.live_norm / SEARCH.weight
    assert cost == pytest.approx(expected, abs=10 * SAME)
    # The costs are reset afterwards, so the least λ is found again.
    nothing = np.zeros(problem.faces, dtype=bool)
    least = least_of_forces(problem, 1.0, np.zeros(3 * problem.joints))
    for _ in range(2):
        found = refiner.least(nothing, state.d)
        assert (found is None) == (least is None)
        if found is not None:
            assert found.load_factor == pytest.approx(least, abs=SAME)
        refiner._forces_at(*costs)


@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_what_a_force_drives(problem, turned):
    """The dead load drives no motion. Reversed, it lifts every block."""
    limits = ShearLimits.true(problem)
    force = turned * problem.dead
    model = CvxpyDriven(replace(problem, dead=force), limits)
    expected = -least_of_motion(problem, problem.face_cohesion, problem.friction, -force, within=(-1, 1))
    assert optimum(model) == pytest.approx(expected, abs=SAME * np.abs(problem.dead).sum())
    assert (expected > 0.1) == (turned < 0)


OF_PRODUCTS = UNCRUSHED | {
    "wedges": mo.load(CASES / "livesley" / "wedges.toml"),
    "cohesion": small_wall(2, 2, cohesion=0.05),
    "no cohesion": small_wall(2, 2),
    "dilatancy": small_wall(2, 2, dilatancy=0.1),
    "nothing slides": small_wall(2, 2, friction=float("inf")),
    "contraction": small_wall(2, 2, 0.3, dilatancy=-0.05),
    "cohesion and dilatancy": small_wall(2, 2, cohesion=0.1, dilatancy=0.3),
    **{f"{kind} {seed}": random_scene(kind, seed) for kind, seed in (("wall", 0), ("stack", 1), ("arch", 2))},
}


@cache
def exact_state(name):
    """Return the problem of a scene and its exact Coulomb state."""
    result = mo.solve(OF_PRODUCTS[name], "coulomb")
    assert result.kind is Kind.EXACT
    problem, found = result.assembly.problem, result.solution
    return problem, State(found.load_factor, found.q, found.d, problem.rates(found.d, problem.dilatancy))


def products_of(problem, highest, largest, radii, lowest=0.0):
    kept = tuple(away <= radius for away, radius in zip(distances(problem), radii, strict=True))
    model = PyomoProducts(problem, (lowest, highest), largest, kept)
    return model, LinearProgram.of_pyomo(model.program)


def factors_at(factors, state):
    """Return the factors of statics and of kinematics in a state."""
    problem, forces = factors.problem, factors.problem.by_kind(state.q).copy()
    forces[2, problem.sliding] = problem.slacks(state.q)[: len(problem.sliding)]
    statics = np.append(forces.T, [state.load_factor, 1.0])
    return statics, np.concatenate([factors.in_edges(state.p), state.d, [1.0]])


def point(model, lp, state):
    """Return the products of a state, by column."""
    statics, motion = factors_at(model.factors, state)
    i, k = np.array(list(model.product)).T
    x = np.full(len(lp.cost), np.nan)
    x[np.concatenate(list(lp.columns.values()))] = statics[i] * motion[k]
    return x


FAST = ("wedges", "contraction")
SLOW = [pytest.param(name, marks=pytest.mark.slow) for name in OF_PRODUCTS if name not in FAST]


@pytest.mark.parametrize("name", [*FAST, *SLOW])
def test_a_coulomb_state_meets_every_row(name):
    problem, state = exact_state(name)
    lowest, highest = 0.9 * max(state.load_factor, 0.0), state.load_factor * 1.001
    of = bounds_of(problem, highest, 100.0, Effort())
    above = tightened(of, problem, lowest, highest, Effort())
    for radii, within in (((0, 1), of), ((1, 2), of), ((0, 1), above)):
        model, lp = products_of(problem, highest, within.normal, radii, within.lowest)
        x = point(model, lp, state)
        scale = max(1.0, np.abs(x).max())
        body = lp.matrix @ x
        assert (body >= lp.row_lower - 1e-7 * scale).all()
        assert (body <= lp.row_upper + 1e-7 * scale).all()
        assert (x >= lp.low - 1e-7 * scale).all()
        assert (x <= lp.high + 1e-7 * scale).all()


def test_rows_cut_off_a_state_that_is_not_complementary():
    """The associative answer of a wall moves faces that carry forces, so its products violate some row."""
    result = mo.solve(small_wall(), "static")
    problem, found = result.assembly.problem, result.solution
    p = problem.rates(found.d, problem.friction)
    model, lp = products_of(problem, 2 * found.load_factor, np.full(problem.joints, np.inf), (0, 1))
    body = lp.matrix @ point(model, lp, State(found.load_factor, found.q, found.d, p))
    assert max((lp.row_lower - body).max(), (body - lp.row_upper).max()) > 1e-3


@pytest.mark.parametrize("name", [*FAST, "one joint cannot slide"])
def test_any_multipliers_prove_no_more_than_a_state_allows(name):
    """For random multipliers, cost·x ≥ value − short·|x| at a state."""
    problem, state = exact_state(name)
    largest = bounds_of(problem, state.load_factor * 1.001, 100.0, Effort()).normal
    model, lp = products_of(problem, state.load_factor * 1.001, largest, (0, 1))
    x = point(model, lp, state)
    rng = np.random.default_rng(1)
    for _ in range(20):
        value, short = lp.least(rng.normal(size=len(lp.row_lower)))
        assert value - short @ np.abs(x) <= lp.cost @ x + 1e-6 * (1 + np.abs(value))


@pytest.mark.parametrize("name", UNCRUSHED)
def test_edge_factors_are_the_problem_s(name):
    """The forms of statics and kinematics agree with the problem at arbitrary numbers."""
    problem, rng = assemble(UNCRUSHED[name]).problem, np.random.default_rng(3)
    factors = EdgeFactors(problem)
    q, d = rng.normal(size=3 * problem.joints), rng.normal(size=3 * problem.blocks)
    p = rng.uniform(size=problem.faces)
    statics, motion = factors_at(factors, State(0.7, q, d, p))
    balance = [sum(a * statics[i] for i, a in form.items()) for form in factors.equilibrium()]
    np.testing.assert_allclose(balance, problem.unbalanced(0.7, q), atol=1e-12)
    z = problem.slacks(q)
    others = [sum(a * statics[i] for i, a in form.items()) for form in factors.other_slacks.values()]
    np.testing.assert_allclose(others, z[len(problem.sliding) : 2 * len(problem.sliding)], atol=1e-12)
    expected = problem.departure(d, p, problem.dilatancy).reshape(3, -1).T.ravel()
    left = [sum(a * motion[k] for k, a in form.items()) for form in factors.compatibility()]
    np.testing.assert_allclose(left, expected, atol=1e-12)
    work = sum(a * motion[k] for k, a in factors.live_work().items())
    assert work == pytest.approx(problem.live @ d - problem.live_norm)
    # The energy that the faces dissipate is that of the products.
    of_products = sum(statics[i] * motion[k] for i, k in factors.at_rest)
    for rate, form in factors.other_slacks.items():
        of_products += sum(a * statics[i] for i, a in form.items()) * motion[rate]
    assert of_products == pytest.approx(z @ p)
