"""Every model is declared for joints of every kind, in the problem's order, and complementarity problems are
solved."""

import cvxpy as cp
import numpy as np
import pyomo.environ as pyo
import pytest
from scenes import CASES, KINDS_OF_JOINTS, declared

import masonry_opt as mo
from masonry_opt.methods.bounds.conflicts import driven_motion
from masonry_opt.methods.exact.refiner import programs
from masonry_opt.methods.mpec import CasadiIpopt
from masonry_opt.models.cvxpy_exact import CvxpyAtYield, CvxpyDrivenMotion, CvxpyForces, CvxpyMotion
from masonry_opt.models.cvxpy_kinematic import CvxpyKinematic
from masonry_opt.models.cvxpy_standing import CvxpyDriven, CvxpyFalling, CvxpyStanding
from masonry_opt.models.cvxpy_static import CvxpyStatic
from masonry_opt.models.pyomo_kinematic import PyomoKinematic
from masonry_opt.models.pyomo_mcp import PyomoMcp, with_slack_variables
from masonry_opt.models.pyomo_mpec import PyomoGlobal, PyomoMpec, PyomoRelaxed
from masonry_opt.models.pyomo_static import PyomoStatic
from masonry_opt.models.pyomo_terms import put
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import Problem, ShearLimits, State
from masonry_opt.solution.answer import certify
from masonry_opt.solvers.highs import LinearProgram


@pytest.fixture(scope="module", params=KINDS_OF_JOINTS)
def problem(request) -> Problem:
    return assemble(KINDS_OF_JOINTS[request.param]).problem


@pytest.fixture
def numbers(problem) -> State:
    rng = np.random.default_rng(4)
    shapes = (3 * problem.joints, 3 * problem.blocks)
    return State(0.7, *(rng.normal(size=size) for size in shapes), rng.uniform(size=problem.faces))


#: Models with statics, by name. Each is made from a problem and its true shear limits.
STATIC = {
    "eq. (9)": CvxpyStatic,
    "standing": CvxpyStanding,
    "exact, forces": lambda problem, _: CvxpyForces(problem),
    "at yield": lambda problem, _: CvxpyAtYield(problem, np.arange(problem.faces) % 2 == 0, 0.5),
    "eq. (9) in Pyomo": PyomoStatic,
    "MPEC": lambda problem, _: PyomoMpec(problem),
    "global": lambda problem, _: PyomoGlobal(problem, *np.ones((2, problem.faces)), 1.0),
}
#: Models with mechanisms, by name.
KINEMATIC = {
    "eq. (10)": CvxpyKinematic,
    "falling": lambda problem, limits: CvxpyFalling(problem, limits, np.ones(problem.blocks), 1.0),
    "driven": lambda problem, limits: CvxpyDriven(problem, limits),
    "exact, motion": lambda problem, limits: CvxpyMotion(problem, slope=limits.slope),
    "eq. (10) in Pyomo": PyomoKinematic,
    "MPEC": STATIC["MPEC"],
    "global": STATIC["global"],
}


def of_pyomo(model):
    return isinstance(model.program, pyo.ConcreteModel)


@pytest.mark.parametrize("name", STATIC)
def test_slacks_and_equilibrium_are_the_problem_s(name, problem, numbers):
    """At arbitrary forces, the slack of each face, in order, and the imbalance are those of the problem."""
    model = STATIC[name](problem, ShearLimits.true(problem))
    statics, load_factor = model.statics, numbers.load_factor
    if of_pyomo(model):
        put(statics.q, numbers.q)
        statics.load_factor.set_value(load_factor)
        slacks = np.array([pyo.value(slack) for slack in statics.slacks])
        balance = [pyo.value(row.body) - pyo.value(row.upper) for row in statics.equilibrium.values()]
    else:
        statics.q.value = numbers.q
        if isinstance(statics.load_factor, cp.Variable):
            statics.load_factor.value = load_factor
        else:
            load_factor = statics.load_factor.value
        slacks, balance = statics.slacks.value, statics.equilibrium.args[0].value
    np.testing.assert_allclose(slacks, problem.slacks(numbers.q), atol=1e-12)
    expected = problem.B @ numbers.q + load_factor * problem.live + problem.dead
    np.testing.assert_allclose(balance, expected, atol=1e-12)


@pytest.mark.parametrize("name", KINEMATIC)
def test_flow_is_the_problem_s(name, problem, numbers):
    """At arbitrary velocities and rates, Bᵀd − D p of each joint is that of the problem, under the friction
    of eq. (10) or the joints' own flow rule."""
    limits = ShearLimits.true(problem)
    model = KINEMATIC[name](problem, limits)
    of_own_flow = name in ("MPEC", "global")
    slope = problem.dilatancy if of_own_flow else problem.friction
    mechanism = model.mechanism
    if of_pyomo(model):
        put(mechanism.d, numbers.d)
        put(mechanism.p, numbers.p)
        rows = mechanism.compatibility.values()
        departure = np.array([pyo.value(row.body) - pyo.value(row.upper) for row in rows])
        slip = [pyo.value(slip) for slip in mechanism.slip]
    else:
        mechanism.d.value, mechanism.p.value = numbers.d, numbers.p
        departure, slip = mechanism.compatibility.args[0].value, mechanism.slip.value
    expected = problem.B.T @ numbers.d - problem.D(slope) @ numbers.p
    np.testing.assert_allclose(departure, expected, atol=1e-12)
    np.testing.assert_allclose(slip, problem.slip(numbers.p), atol=1e-12)


@pytest.mark.parametrize("language", ["cvxpy", "pyomo"])
def test_size_of_eq_9_and_eq_10(language, problem):
    b, c, faces = problem.blocks, problem.joints, problem.faces
    drivers = [declared(problem, name, language) for name in ("static", "kinematic")]
    for driver in drivers:
        driver.solve()
    static, kinematic = (driver.size() for driver in drivers)
    assert (static.rows, static.columns) == (3 * b + faces, 3 * c + 1)
    # CVXPY writes p ≥ 0 as rows.
    signs = faces if language == "cvxpy" else 0
    assert (kinematic.rows, kinematic.columns) == (3 * c + 1 + signs, 3 * b + faces)


def test_what_exact_states_are_refined_by_is_what_cvxpy_compiles_of_the_models(problem):
    """Each row and column agrees to the last digit, so that the simplex method ends in the same one of many
    optima."""
    forces, motion = CvxpyForces(problem), CvxpyMotion(problem)
    statics, mechanism = forces.statics, motion.mechanism
    names = [
        {"q": statics.q, "load_factor": statics.load_factor, "yield": forces.within_yield},
        {"p": mechanism.p, "d": mechanism.d},
    ]
    for model, made, of in zip((forces, motion), programs(problem), names, strict=True):
        compiled = LinearProgram.of(model.program)
        assert (compiled.matrix != made.matrix).nnz == 0
        for array in ("cost", "low", "high", "row_lower", "row_upper"):
            np.testing.assert_array_equal(getattr(made, array), getattr(compiled, array))
        for name, place in (made.columns | made.rows).items():
            np.testing.assert_array_equal(place, (compiled.columns | compiled.rows)[id(of[name])])


def test_the_kinematics_of_proofs_are_compiled_as_cvxpy_compiles_the_model(problem):
    """Rows have the same order. The columns of each variable are compared by name."""
    energy, highest = np.random.default_rng(0).uniform(size=problem.faces), 0.7
    model, made = CvxpyDrivenMotion(problem, energy, highest), driven_motion(problem, energy)
    compiled = LinearProgram.of(model.program)
    made.row_upper[made.rows["energy"]] = highest * problem.live_norm
    for name, variable in (("p", model.mechanism.p), ("d", model.mechanism.d)):
        own, other = made.columns[name], compiled.columns[id(variable)]
        assert abs(compiled.matrix[:, other] - made.matrix[:, own]).max() == 0
        for array in ("cost", "low", "high"):
            np.testing.assert_array_equal(getattr(made, array)[own], getattr(compiled, array)[other])
    for array in ("row_lower", "row_upper"):
        np.testing.assert_array_equal(getattr(made, array), getattr(compiled, array))
    np.testing.assert_array_equal(made.rows["energy"], compiled.rows[id(model.balance)])


SMALL = [CASES / "gilbert" / "two_blocks.toml", CASES / "livesley" / "wedges.toml"]


def test_the_complementary_pairs_are_slacks_and_rates(problem, numbers):
    """Both sides of each pair are evaluated by Pyomo from the declaration: v = z, and p as a row."""
    mcp = PyomoMcp(problem)
    mcp.start_from(numbers)
    put(with_slack_variables(mcp, "mpec.standard_form"), np.zeros(problem.faces))
    pairs = list(mcp.program.complementarity.values())
    z = [pyo.value(pair.ve.upper) - pyo.value(pair.ve.body) for pair in pairs]
    np.testing.assert_allclose(z, problem.slacks(numbers.q), atol=1e-12)
    np.testing.assert_array_equal([pyo.value(pair.c.body) for pair in pairs], numbers.p)


def test_a_relaxation_holds_a_state_and_tells_what_it_leaves(problem, numbers):
    model = PyomoRelaxed(PyomoMpec(problem))
    model.start_from(numbers)
    read = model.read()
    assert read.load_factor == numbers.load_factor
    for ours, theirs in ((read.q, numbers.q), (read.d, numbers.d), (read.p, numbers.p)):
        np.testing.assert_array_equal(ours, theirs)
    expected = np.maximum(problem.slacks(numbers.q), 0.0) * numbers.p
    np.testing.assert_allclose(model.products(), expected, atol=1e-12)
    assert len(model.complementarity_rows) == problem.faces
    model.epsilon.set_value(0.25)
    rows = zip(model.complementarity_rows, expected, strict=True)
    assert all(pyo.value(row.body) - pyo.value(row.upper) == pytest.approx(z_p - 0.25) for row, z_p in rows)


@pytest.mark.parametrize("path", SMALL, ids=lambda path: path.stem)
def test_ipopt_finds_a_certified_state_of_what_is_declared(path):
    """IPOPT starts at rest without an objective, and ends in any of the states."""
    problem = assemble(mo.load(path)).problem
    model = PyomoRelaxed(PyomoMcp(problem))
    at_rest = (np.zeros(size) for size in (3 * problem.joints, 3 * problem.blocks, problem.faces))
    model.start_from(State(0.0, *at_rest))
    ipopt = CasadiIpopt(model)
    assert all(ipopt.solve(epsilon)[0] for epsilon in 10.0 ** -np.arange(10))
    found = model.read()
    left = certify(problem, found.load_factor, found.q, found.d, problem.dilatancy)
    assert max(left.equilibrium, left.yield_, left.flow) <= 1e-6
    assert left.complementarity / found.load_factor <= 1e-4
