"""Forces at edges are the declared problem in other unknowns; Newton's equations are solved; and what methods
on matrices end with is a state of the declared problem."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from residuals import residuals
from scenes import KINDS_OF_JOINTS, solved, values_of
from scenes_in_space import box_on_floor

from masonry_opt.answer.reasons import Code
from masonry_opt.methods.mcp.edge_form import EdgeForm, Iterate, moved
from masonry_opt.methods.mcp.newton import Elimination, NewtonSystem, Parts
from masonry_opt.methods.mcp.passes import Passes, unit_compliance
from masonry_opt.methods.registry import METHODS
from masonry_opt.models.pyomo_mcp import PyomoMcp
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.state import State
from masonry_opt.solvers.registry import MATRICES

#: Methods in whose results no modelling language stands.
ON_MATRICES = [name for name, method in METHODS.items() if MATRICES in method.solvers]

PROBLEMS = {name: assemble(scene).problem for name, scene in KINDS_OF_JOINTS.items()}

#: Sums of some tens of numbers near one.
ROUNDING = 1e-12
#: What a solution may leave of Newton's equations, over the largest entry of their right-hand side.
SOLVED = 1e-9
#: What a state may leave of the declared conditions, over the largest force or velocity: as of exact answers.
STATE = 1e-8


@pytest.fixture(params=PROBLEMS)
def rigid(request) -> EdgeForm:
    return EdgeForm(PROBLEMS[request.param])


@pytest.fixture(params=[0.0, 0.3], ids=["rigid", "giving"])
def form(request, rigid) -> EdgeForm:
    if not request.param:
        return rigid
    return rigid.giving(request.param * unit_compliance(rigid.problem, rigid.least_forces))


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(11)


def interior(form: EdgeForm, rng: np.random.Generator) -> Iterate:
    """A point with all forces, slacks and rates between 0.5 and 2, that meets no equation."""
    c, k = form.problem.joints, len(form.problem.sliding)
    x = np.vstack([rng.uniform(0.5, 2, (2, c)), rng.normal(size=(1, c))])
    rates = rng.uniform(0.5, 2, (2, c)), rng.uniform(0.5, 2, (2, k))
    z, d = rng.uniform(0.5, 2, (2, k)), rng.normal(size=3 * form.problem.blocks)
    return Iterate(0.7, x, z, d, *rates, *rng.uniform(0.5, 2, (2, form.G.shape[0])))


def random_parts(form: EdgeForm, rng: np.random.Generator) -> Parts:
    problem = form.problem
    sizes = (3 * problem.blocks, (2, len(problem.sliding)), (3, problem.joints))
    return Parts(*(rng.normal(size=size) for size in sizes), float(rng.normal()))


def flat(parts: Parts) -> np.ndarray:
    return np.concatenate([np.ravel(part) for part in parts])


def assert_same_iterate(one: Iterate, other: Iterate) -> None:
    for name in vars(one):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), atol=ROUNDING, err_msg=name)


def assert_as_declared(form: EdgeForm, at: Iterate) -> None:
    """The residuals are the declared ones, of the same state."""
    problem, k, c = form.problem, len(form.problem.sliding), form.problem.joints
    ours = form.residuals(at)
    declared = residuals(PyomoMcp(problem), form.state(at))
    np.testing.assert_allclose(ours.statics, declared.equilibrium, atol=ROUNDING)
    np.testing.assert_allclose(ours.motion.ravel(), declared.compatibility, atol=ROUNDING * max(np.abs(at.d)))
    assert ours.work == pytest.approx(declared.live_work, abs=ROUNDING)
    # Slacks of sliding and crushing are unknowns of their own; those of rocking are twice the forces.
    np.testing.assert_allclose(at.z.ravel() - ours.yielding.ravel(), declared.z[: 2 * k], atol=ROUNDING)
    np.testing.assert_allclose(2 * at.x[:2].ravel(), declared.z[2 * k : 2 * (k + c)], atol=ROUNDING)
    np.testing.assert_allclose(at.room - ours.crushing, declared.z[2 * (k + c) :], atol=ROUNDING)
    met = replace(at, z=at.z - ours.yielding, room=at.room - ours.crushing).products
    products = np.concatenate([met.sliding.ravel(), met.edges.ravel(), met.crushing])
    np.testing.assert_allclose(products, declared.z * declared.p, atol=ROUNDING)


def test_residuals_are_the_declared_ones(form, rng):
    assert_as_declared(form, interior(form, rng))


@pytest.mark.parametrize("name", PROBLEMS)
def test_residuals_of_an_answer_are_the_declared_ones_and_vanish(name):
    """Kinematics by the rates that the certificate gives an answer: its flow is 1e-8 at most."""
    result = solved(KINDS_OF_JOINTS[name])
    problem, solution = result.assembly.problem, result.solution
    p = problem.rates(solution.d, problem.dilatancy)
    form = EdgeForm(problem)
    at = form.iterate(State(result.load_factor, solution.q, solution.d, p))
    assert_as_declared(form, at)
    left = form.residuals(at)
    np.testing.assert_allclose(left.yielding, 0, atol=ROUNDING)
    assert np.abs(left.statics).max() < 1e-8 * np.abs(problem.dead).sum()
    assert np.abs(left.motion).max() < 2e-8 * np.abs(solution.d).max()
    assert abs(left.work) < 1e-8 * problem.live_norm
    assert at.energy < 1e-6 * result.load_factor * problem.live_norm


def test_yielding_vanishes_just_where_slacks_are_those_of_the_forces(form, rng):
    at = interior(form, rng)
    true = form.iterate(form.state(at)).z
    exact = replace(at, z=true)
    np.testing.assert_allclose(form.residuals(exact).yielding, 0, atol=ROUNDING)
    off = replace(at, z=true + 0.25)
    np.testing.assert_allclose(form.residuals(off).yielding, 0.25, atol=ROUNDING)


def test_a_state_and_its_iterate_are_each_other_s(form, rng):
    at = form.iterate(form.state(interior(form, rng)))
    assert_same_iterate(form.iterate(form.state(at)), at)
    state = form.state(at)
    again = form.state(form.iterate(state))
    for name in vars(state):
        np.testing.assert_allclose(getattr(again, name), getattr(state, name), atol=ROUNDING, err_msg=name)


def test_steps_of_statics_and_of_kinematics_have_their_own_lengths(form, rng):
    at, by = interior(form, rng), interior(form, rng)
    gone = moved(at, (0.5, 0.25), by)
    assert gone.load_factor == pytest.approx(1.5 * 0.7)
    for name in ("x", "z", "room", "d", "opening", "slip", "crushed"):
        length = 0.5 if name in ("x", "z", "room") else 0.25
        np.testing.assert_allclose(getattr(gone, name), getattr(at, name) + length * getattr(by, name))


# Newton's equations ---------------------------------------------------------------------------------------


def newton_system(form: EdgeForm, at: Iterate, full: bool = False, blend: float = 1.0) -> NewtonSystem:
    problem = form.problem
    friction = blend * problem.friction + (1 - blend) * problem.dilatancy
    return NewtonSystem(Elimination(form), at, friction, 1e-10, 1e-12, full=full)


@pytest.mark.parametrize("blend", [1.0, 0.4])
@pytest.mark.parametrize("full", [False, True])
def test_a_solution_meets_the_equations(form, rng, full, blend):
    system = newton_system(form, interior(form, rng), full, blend)
    right = random_parts(form, rng)
    solution, error = system.solve(right)
    left = flat(right.plus(system.apply(solution), -1.0))
    assert system.full is full  # elimination needed no help
    assert error < SOLVED
    assert np.abs(left).max() < SOLVED * np.abs(flat(right)).max()


def test_elimination_and_full_factors_give_the_same(form, rng):
    """To what the regularisation 1e-10 and the matrix's condition leave."""
    at, right = interior(form, rng), random_parts(form, rng)
    one, other = (flat(newton_system(form, at, full).solve(right)[0]) for full in (False, True))
    np.testing.assert_allclose(one, other, atol=1e-7 * np.abs(other).max())


@pytest.mark.parametrize("gap", [1e-4, 1e-8])
@pytest.mark.parametrize("full", [False, True])
def test_a_solution_meets_the_equations_near_an_answer(form, rng, full, gap):
    """Of each pair one is the gap's root and the other its inverse, as where faces move or stand still."""
    at, root = interior(form, rng), gap**0.5
    moving = rng.random(at.opening.shape) < 0.3
    slides = (rng.random(at.slip.shape[1]) < 0.3) & np.array([[True], [False]])
    at.x[:2] *= np.where(moving, root, 1)
    at = replace(
        at,
        z=at.z * np.where(slides, root, 1),
        opening=at.opening * np.where(moving, 1, root),
        slip=at.slip * np.where(slides, 1, root),
    )
    right = random_parts(form, rng)
    right = right._replace(sliding=right.sliding * gap)
    system = newton_system(form, at, full)
    solution, error = system.solve(right)
    assert error < 1e-8  # where elimination leaves more, full factors follow
    parts, sizes = system.apply(solution), np.abs(flat(right)).max()
    assert np.abs(flat(right.plus(parts, -1.0))).max() < 1e-8 * sizes


def test_equations_are_the_derivatives_of_residuals_and_products(form, rng):
    """Central differences, exact for terms of second order: 1e-5 leaves rounding of some 1e-10. Slacks follow
    the true friction law and strength; openings and rates of crushing keep their products with forces."""
    problem, at, step = form.problem, interior(form, rng), random_parts(form, rng)
    system = newton_system(form, at)

    def value(length: float) -> np.ndarray:
        x = at.x + length * step.joints
        there = Iterate(
            at.load_factor + length * step.load,
            x,
            at.z + length * form.slacks(step.joints, problem.friction),
            at.d + length * step.blocks,
            at.opening * at.x[:2] / x[:2],
            at.slip + length * step.sliding,
            room := at.room + length * (form.G @ step.joints[:2].ravel()),
            at.crushed * at.room / room,
        )
        left = form.residuals(there)
        here = form.residuals(at)
        np.testing.assert_allclose(left.yielding, here.yielding, atol=ROUNDING)
        np.testing.assert_allclose(left.crushing, here.crushing, atol=ROUNDING)
        return flat(Parts(left.statics, there.products.sliding, left.motion, left.work))

    length = 1e-5
    slopes = (value(length) - value(-length)) / (2 * length)
    np.testing.assert_allclose(slopes, flat(system.apply(step)), atol=1e-8)


def test_equations_of_another_friction_are_not_newton_s():
    """The blend changes what slacks follow, and nothing else."""
    form, rng = EdgeForm(PROBLEMS["no cohesion"]), np.random.default_rng(3)
    at, step = interior(form, rng), random_parts(form, rng)
    newton, blended = (newton_system(form, at, blend=blend).apply(step) for blend in (1.0, 0.4))
    np.testing.assert_array_equal(newton.blocks, blended.blocks)
    np.testing.assert_array_equal(newton.joints, blended.joints)
    assert newton.load == blended.load
    assert np.abs(newton.sliding - blended.sliding).max() > 0.1


@pytest.mark.parametrize("method", ON_MATRICES)
@pytest.mark.parametrize(
    "scene", [*KINDS_OF_JOINTS.values(), box_on_floor()], ids=[*KINDS_OF_JOINTS, "a box"]
)
def test_what_methods_on_matrices_end_with_is_a_state_of_the_declared_problem(scene, method):
    """Every equation and pair of the model in Pyomo, where contacts give with their E (q - q₀)."""
    result = solved(scene, method)
    assert (result.model, result.solver) == (MATRICES, "newton")
    problem, found = result.assembly.problem, result.solution.found
    in_space = problem.layout.dimension == 3
    assert (values_of(result, Code.PLATEAU) is not None) == (in_space and method == "compliant")
    if plateau := values_of(result, Code.PLATEAU):
        passes = Passes(problem)
        problem = passes.giving(plateau["give"], passes.settled_forces()).problem
    p = problem.rates(found.d, problem.dilatancy, found.q)
    left = residuals(PyomoMcp(problem), State(result.load_factor, found.q, found.d, p))
    forces, speeds = np.abs(found.q).max(), np.abs(found.d).max()
    np.testing.assert_allclose(left.equilibrium, 0, atol=STATE * forces)
    np.testing.assert_allclose(left.compatibility, 0, atol=STATE * speeds)
    assert left.live_work == pytest.approx(0, abs=STATE * problem.live_norm)
    assert left.z.min() >= -STATE * forces
    assert left.p.min() >= -STATE * speeds
    assert left.z @ left.p <= STATE * result.load_factor * problem.live_norm
