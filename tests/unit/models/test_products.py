"""Products of statics and kinematics: no row cuts off a Coulomb state, and no multipliers prove too much."""

import numpy as np
import pytest
from atlas.random_scenes import random_scene
from scenes import CASES, UNCRUSHED, small_wall

import masonry_opt as mo
from masonry_opt.answer.acceptance import Kind
from masonry_opt.effort import Effort
from masonry_opt.methods.bracket.bounds import bounds_of, tightened
from masonry_opt.methods.bracket.relaxation import Distances
from masonry_opt.models.pyomo_products import PyomoProducts
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.edges import EdgeFactors
from masonry_opt.problem.problem import State
from masonry_opt.solvers.highs import LinearProgram

SCENES = UNCRUSHED | {
    "wedges": mo.load(CASES / "livesley" / "wedges.toml"),
    "cohesion": small_wall(2, 2, cohesion=0.05),
    "no cohesion": small_wall(2, 2),
    "dilatancy": small_wall(2, 2, dilatancy=0.1),
    "nothing slides": small_wall(2, 2, friction=float("inf")),
    "contraction": small_wall(2, 2, 0.3, dilatancy=-0.05),
    "cohesion and dilatancy": small_wall(2, 2, cohesion=0.1, dilatancy=0.3),
    **{f"{kind} {seed}": random_scene(kind, seed) for kind, seed in (("wall", 0), ("stack", 1), ("arch", 2))},
}


def exact_state(scene):
    """An exact Coulomb state of a scene."""
    result = mo.solve(scene, "refined")
    assert result.kind is Kind.EXACT
    problem, found = result.assembly.problem, result.solution
    return problem, State(found.load_factor, found.q, found.d, problem.rates(found.d, problem.dilatancy))


def declared(problem, highest, largest, radii, lowest=0.0):
    model = PyomoProducts(problem, (lowest, highest), largest, *Distances(problem).within(radii))
    return model, LinearProgram.of(model.program)


def factors_at(factors, state):
    """The factors of statics and of kinematics in a state."""
    problem, forces = factors.problem, factors.problem.by_kind(state.q).copy()
    forces[2, problem.sliding] = problem.slacks(state.q)[: len(problem.sliding)]
    statics = np.append(forces.T, [state.load_factor, 1.0])
    return statics, np.concatenate([factors.in_edges(state.p), state.d, [1.0]])


def point(model, lp, state):
    """The products of a state, by column."""
    statics, motion = factors_at(model.factors, state)
    i, k = np.array(list(model.product)).T
    x = np.full(len(lp.cost), np.nan)
    x[np.concatenate(list(lp.columns.values()))] = statics[i] * motion[k]
    return x


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in ("wedges", "contraction") else pytest.mark.slow)
        for name in SCENES
    ],
)
def test_a_coulomb_state_meets_every_row(name):
    problem, state = exact_state(SCENES[name])
    lowest, highest = 0.9 * max(state.load_factor, 0.0), state.load_factor * 1.001
    of = bounds_of(problem, highest, 100.0, Effort())
    above = tightened(of, problem, lowest, highest, Effort())
    for radii, within in (((0, 1), of), ((1, 2), of), ((0, 1), above)):
        model, lp = declared(problem, highest, within.normal, radii, within.lowest)
        x = point(model, lp, state)
        scale = max(1.0, np.abs(x).max())
        body = lp.matrix @ x
        assert (body >= lp.row_lower - 1e-7 * scale).all()
        assert (body <= lp.row_upper + 1e-7 * scale).all()
        assert (x >= lp.low - 1e-7 * scale).all()
        assert (x <= lp.high + 1e-7 * scale).all()


def test_rows_cut_off_a_state_that_is_not_complementary():
    """The associative answer of a wall moves faces that carry: its products do not meet every row."""
    result = mo.solve(small_wall(), "static")
    problem, found = result.assembly.problem, result.solution
    p = problem.rates(found.d, problem.friction)
    model, lp = declared(problem, 2 * found.load_factor, np.full(problem.joints, np.inf), (0, 1))
    body = lp.matrix @ point(model, lp, State(found.load_factor, found.q, found.d, p))
    assert max((lp.row_lower - body).max(), (body - lp.row_upper).max()) > 1e-3


@pytest.mark.parametrize("name", ["no cohesion", "one joint cannot slide", "dilatancy"])
def test_any_multipliers_prove_no_more_than_a_state_allows(name):
    """cost·x ≥ value − short·|x| at a state, for multipliers drawn at random."""
    problem, state = exact_state(SCENES[name])
    largest = bounds_of(problem, state.load_factor * 1.001, 100.0, Effort()).normal
    model, lp = declared(problem, state.load_factor * 1.001, largest, (0, 1))
    x = point(model, lp, state)
    rng = np.random.default_rng(1)
    for _ in range(20):
        value, short = lp.least(rng.normal(size=len(lp.row_lower)))
        assert value - short @ np.abs(x) <= lp.cost @ x + 1e-6 * (1 + np.abs(value))


@pytest.mark.parametrize("name", UNCRUSHED)
def test_edge_factors_are_the_problem_s(name):
    """The forms of statics and kinematics at any numbers whatever."""
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
    # Energy: what faces dissipate is what the products say.
    of_products = sum(statics[i] * motion[k] for i, k in factors.at_rest)
    slides_back = sum(
        sum(a * statics[i] for i, a in form.items()) * motion[rate]
        for rate, form in factors.other_slacks.items()
    )
    assert of_products + slides_back == pytest.approx(z @ p)
