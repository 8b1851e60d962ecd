"""Each solver of the registry: its accuracy on small scenes, statuses, tolerances and errors."""

from types import SimpleNamespace

import clarabel
import cvxpy as cp
import numpy as np
import pytest
import scipy.sparse as sp
from scenes import WALLS, block_on_floor, declared, overhanging, pressed_down, small_wall, two_blocks
from speeds import slow

import masonry_opt as mo
from masonry_opt.effort import Effort
from masonry_opt.methods.exact.refiner import programs
from masonry_opt.models.cvxpy_exact import CvxpyForces
from masonry_opt.models.cvxpy_static import CvxpyStatic
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import ShearLimits
from masonry_opt.solution.answer import certify
from masonry_opt.solution.reasons import Code
from masonry_opt.solvers.cvxpy_engine import CvxpyEngine, has_optimum, solve_balanced
from masonry_opt.solvers.highs import HighsSession
from masonry_opt.solvers.registry import SOLVERS, Verdict, find_solver, in_cvxpy, rougher

#: All solvers of linear programs. The tests run with every extra installed.
LINEAR = [pair for pair, entry in SOLVERS.items() if entry.linear]
#: Interior points of HiGHS, each in two modelling languages.
MORE_OF_HIGHS = [pair for pair in LINEAR if pair[1].startswith("highs-")]

#: Bounds of the certificate's residuals for first-order methods. The bound for all other solvers is a few
#: times their tolerance.
LEFT = {"osqp": 1e-6, "scs": 1e-6}


@pytest.mark.parametrize("formulation", ["static", "kinematic"])
@pytest.mark.parametrize(("language", "solver"), LINEAR)
def test_an_optimum_and_its_duals(language, solver, formulation):
    """The forces and rates of either formulation satisfy all conditions, because primal variables of eq. (9)
    are dual variables of eq. (10). Forces are in median block weights, and velocities are near 1. HiPO ends
    with "unknown" on most scenes this small. Its scene is a block that slides at μ + c L / W, and `duality`
    tests it on a façade."""
    wall, block = small_wall(cohesion=0.05), block_on_floor(4, 2, 0.5).replace(cohesion=0.05)
    problem = assemble(block if solver == "highs-hipo" else wall).problem
    driver = declared(problem, formulation, language, solver)
    answer = driver.solve()
    assert answer.solved.verdict is Verdict.OPTIMAL
    assert answer.solved.status
    assert driver.effort.lp_solves == 1
    assert driver.effort.solvers == {"load factor": [solver]}
    state, most = answer.state, LEFT.get(solver, 1e-8)
    assert certify(problem, state.load_factor, state.q, state.d, problem.friction).worst < most
    assert state.load_factor == pytest.approx(0.7, abs=most)
    z, p = problem.slacks(state.q), state.p
    assert min(z.min(), p.min()) > -1e-6
    np.testing.assert_allclose(problem.B.T @ state.d, problem.D(problem.friction) @ p, atol=1e-6)
    assert problem.live @ state.d == pytest.approx(problem.live_norm, rel=1e-6)
    dissipated = problem.face_cohesion @ p
    assert dissipated > 0.1
    work = state.load_factor * problem.live_norm + problem.dead @ state.d
    assert work == pytest.approx(dissipated, abs=1e-6 * problem.live_norm)
    assert z @ p == pytest.approx(0, abs=1e-6 * problem.live_norm)


@pytest.mark.parametrize("repeats", [True, *slow(False)])
@pytest.mark.parametrize("place", ["right-hand side", "cost", "matrix"])
@pytest.mark.parametrize("wrong", [np.nan, np.inf])
@pytest.mark.parametrize("solver", [name for language, name in LINEAR if language == "cvxpy"])
def test_a_program_with_numbers_that_are_not_finite_fails(solver, wrong, place, repeats):
    """No solver receives NaN or an infinite coefficient. With the number 1 instead, the optimum is 2 or 1."""
    x = cp.Variable(2)
    other = cp.Variable()
    parameter = cp.Parameter(2, value=[1.0, 1.0])
    cost = parameter @ x if place == "cost" else cp.sum(x)
    constraints = {"right-hand side": x >= parameter, "cost": x >= 1, "matrix": parameter @ x >= 1}
    program = cp.Problem(cp.Minimize(cost), [other == 3, x >= 0, x <= 3, constraints[place]])
    engine = CvxpyEngine(program, find_solver("cvxpy", solver), Effort(), "test", repeats)
    if "hipo" not in solver:  # HiPO ends with "unknown" on programs this small
        assert engine.solve().verdict is Verdict.OPTIMAL
        assert program.value == pytest.approx(1 if place == "matrix" else 2, abs=1e-4)
    parameter.save_value(np.array([wrong, 1.0]))  # the setter of ``value`` checks for NaN
    # An infinite right-hand side is permitted; the program is then infeasible.
    if place == "right-hand side" and np.isinf(wrong):
        assert engine.solve().verdict in (Verdict.INFEASIBLE, Verdict.FAILED)
        return
    answer = engine.solve()
    assert answer.verdict is Verdict.FAILED
    assert answer.status == "the program contains coefficients that are NaN or infinite"
    assert engine.effort.lp_solves == (1 if "hipo" in solver else 2)


@pytest.mark.parametrize("falls", [True, False], ids=["falls", "pressed down"])
@pytest.mark.parametrize(
    ("language", "solver", "formulation"),
    [
        *((*pair, "static") for pair in LINEAR),
        ("cvxpy", "clarabel", "kinematic"),
        *slow(*((*pair, "kinematic") for pair in LINEAR if pair != ("cvxpy", "clarabel"))),
    ],
)
def test_programs_without_an_optimum(language, solver, falls, formulation):
    """The solver itself reports that the program is infeasible or unbounded."""
    problem = assemble(overhanging() if falls else pressed_down()).problem
    answer = declared(problem, formulation, language, solver).solve()
    assert answer.state is None
    infeasible = falls == (formulation == "static")
    assert answer.solved.verdict is (Verdict.INFEASIBLE if infeasible else Verdict.UNBOUNDED)
    assert not answer.solved.failed
    assert answer.solved.status


@pytest.mark.parametrize(
    ("language", "solver"),
    [*(pair for pair in LINEAR if pair not in MORE_OF_HIGHS), *slow(*MORE_OF_HIGHS)],
)
def test_scenes_without_a_load_factor(language, solver):
    """The statuses do not depend on the solver. If a solver's own status is unreliable, Clarabel decides."""
    falls = mo.solve(overhanging(), "static", model=language, solver=solver)
    assert (falls.status, falls.reasons[0].code) == (mo.Status.UNSTABLE, Code.FALLS)
    assert falls.reasons[0].values["blocks"] == ["A"]
    unlimited = mo.solve(pressed_down(), "static", model=language, solver=solver)
    assert unlimited.status is mo.Status.UNLIMITED
    assert [reason.code for reason in unlimited.reasons] == [Code.NO_MECHANISM, Code.JOINTS]
    deciding = solver if SOLVERS[language, solver].decides else "clarabel"
    assert falls.solvers == {"dead load": [deciding]}
    assert unlimited.solvers["load factor"] == [solver]
    assert unlimited.solvers["diagnosis"] == [deciding]


@pytest.mark.parametrize("formulation", ["static", "kinematic"])
@pytest.mark.parametrize("language", ["cvxpy", "pyomo"])
def test_changed_shear_limits_are_those_of_a_newly_declared_model(language, formulation):
    problem = assemble(small_wall(cohesion=0.05)).problem
    k = len(problem.sliding)
    limits = ShearLimits(np.linspace(0.1, 0.4, k), np.linspace(0.2, 0.1, k))
    changed = declared(problem, formulation, language)
    changed.solve()
    changed.set_shear_limits(limits)
    new = declared(problem, formulation, language, limits=limits)
    assert changed.solve().state.load_factor == pytest.approx(new.solve().state.load_factor, rel=1e-8)


# Which solver did what ---------------------------------------------------------------------------------


def test_the_solver_asked_for_does_everything_that_it_can():
    result = mo.solve(WALLS[0], "nonassociative", solver="highs", incremental=False)
    assert result.solver == "highs"
    assert result.solvers == {"dead load": ["highs"], "sub-problems": ["highs"], "exact end": ["highs"]}
    of_pyomo = mo.solve(two_blocks(), "nonassociative", model="pyomo", incremental=False)
    assert of_pyomo.solver == "highs-ipm"
    assert of_pyomo.solvers == {purpose: ["highs-ipm"] for purpose in result.solvers}


#: The model of each method, and its solvers by purpose. The MPEC begins with the loop, which is declared in
#: CVXPY.
DECLARED = {"mpec": "pyomo", "coulomb": "matrices", "global": "pyomo"}
DOES = {
    "mpec": dict.fromkeys(("sub-problems", "exact end"), "clarabel")
    | {"relaxation": "casadi", "associative": "highs"},
    "coulomb": {"associative": "highs", "refinement": "highs"},
    "global": {"load factor": "clarabel", "refinement": "highs"},
}
#: Purposes of solvers of a proof that no state is lower.
PROOF = {"conflicts": "highs", "clauses": "cadical"}
for _method in ("coulomb", "global"):
    DOES[_method] |= {"random forces": "highs"} | PROOF


@pytest.mark.parametrize("method", DOES)
def test_methods_say_which_solver_did_what(method):
    result = mo.solve(two_blocks(), method)
    expected = {"dead load": "newton", "incremental analysis": "newton"} | DOES[method]
    assert result.solvers == {purpose: [solver] for purpose, solver in expected.items()}
    assert result.as_dict()["solvers"] == result.solvers
    assert result.as_dict()["model"] == result.model == DECLARED[method]
    assert result.at_incremental.model == "matrices"


def test_without_a_proof_programs_of_products_bound_the_load_factor(no_proof):
    result = mo.solve(two_blocks(), "global")
    assert result.solvers["bounds"] == ["highs"]
    assert result.solvers["products"] == ["highs-ipm"]
    assert not PROOF.keys() & result.solvers.keys()


def test_a_program_that_is_out_of_time_is_not_begun_again(watched):
    forces = CvxpyForces(assemble(mo.load(WALLS[5])).problem)
    session = HighsSession(forces.program, Effort(), "once")
    runs = watched(HighsSession, "run")
    session.set_costs(forces.statics.load_factor, np.array([1.0]))
    assert session.solve(1e-6) is Verdict.FAILED
    assert len(runs) == 1
    assert session.solve() is Verdict.OPTIMAL


@pytest.mark.slow
def test_a_limit_is_of_one_run_whatever_those_before_took():
    """HiGHS counts the time of all runs. Without a correction, a search would end when its runs had taken
    half of its time limit."""
    forces, effort = CvxpyForces(assemble(mo.load(WALLS[5])).problem), Effort()
    session, rng = HighsSession(forces.program, effort, "often"), np.random.default_rng(0)
    session.set_costs(forces.statics.load_factor, np.array([-1.0]))
    while effort.seconds["solve"] <= 1.2:
        session.set_costs(forces.statics.q, 1e-3 * rng.standard_normal(forces.statics.q.size))
        assert session.solve(0.9) is Verdict.OPTIMAL


def test_a_start_from_another_basis_does_not_change_the_optimum():
    """On wall 5, the simplex method maximises λ from the basis of the least λ. It reaches the λ of a cold
    start in far fewer iterations. The kinematic program, which Clarabel solves, has the same λ."""
    problem = assemble(mo.load(WALLS[5])).problem
    program = programs(problem)[0]

    def session(sense: float) -> HighsSession:
        made = HighsSession(program, Effort(), "load factor")
        made.set_costs("load_factor", np.array([sense]))
        return made

    least, cold, warm = session(1.0), session(-1.0), session(-1.0)
    warm.start_from(least)  # without a basis, the next start is cold
    assert cold.solve() is warm.solve() is least.solve() is Verdict.OPTIMAL
    assert warm.effort.iterations == cold.effort.iterations
    warm = session(-1.0)
    warm.start_from(least)
    assert warm.solve() is Verdict.OPTIMAL
    assert warm.effort.iterations < cold.effort.iterations / 2
    largest = float(warm.values("load_factor")[0])
    assert largest == pytest.approx(float(cold.values("load_factor")[0]), rel=1e-12)
    assert largest == pytest.approx(mo.solve(WALLS[5], "kinematic").load_factor, rel=1e-8)


@pytest.mark.parametrize("solver", ["clarabel", "highs"])
def test_a_solved_program_does_not_hold_its_solver(solver):
    """The factors of a solver need more memory than the program, so CVXPY must not keep them."""
    problem = assemble(small_wall()).problem
    model = CvxpyStatic(problem, ShearLimits.true(problem))
    assert has_optimum(model.program, find_solver("cvxpy", solver), Effort(), "load factor")
    assert not model.program._solver_cache


# The registry ------------------------------------------------------------------------------------------


def test_defaults_are_the_first_of_each_language():
    assert find_solver("cvxpy", None).name == "clarabel"
    assert find_solver("pyomo", None).name == "highs"
    assert find_solver("cvxpy", "HIGHS").entry is SOLVERS["cvxpy", "highs"]


@pytest.mark.parametrize(
    ("language", "name", "words"),
    [("ampl", None, "'ampl'.*: cvxpy, pyomo"), ("cvxpy", "mosek", "'mosek'.*: clarabel, highs"),
     ("pyomo", "clarabel", "'clarabel'.*: highs, highs-ipm"), ("pyomo", "ipopt", "ipopt")],
)  # fmt: skip
def test_what_is_not_there_is_refused_with_what_is(language, name, words, monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(mo.OptionError, match=words):
        find_solver(language, name)


@pytest.mark.parametrize("tolerance", [0.0, -1.0, 1.0, 0.11, "1e-9", float("nan")])
def test_tolerance_must_be_one(tolerance):
    with pytest.raises(mo.OptionError, match="tolerance"):
        find_solver("cvxpy", None, tolerance)


@pytest.mark.parametrize("pair", LINEAR)
def test_tolerances_reach_the_solver(pair):
    """The options of each solver contain the tolerance, under any name."""
    options = str(find_solver(*pair, 3.25e-6).options)
    assert "3.25e-06" in options


@pytest.mark.parametrize("name", ["clarabel", "highs", "highs-ipm"])
def test_rougher_is_the_same_solver_asked_for_less(name):
    solver = find_solver("cvxpy", name)
    rough = rougher(solver, 1e-4)
    assert (rough.name, rough.tolerance) == (name, 1e-4)
    changed = {key: value for key, value in rough.options.items() if solver.options.get(key) != value}
    assert {value for value in changed.values() if value is not False} == {1e-4}
    # The tolerance is never smaller than the one requested first.
    assert rougher(rough, 1e-9) == rough


@pytest.mark.parametrize(("language", "name"), SOLVERS)
def test_programs_of_cvxpy_alone_are_solved_by_whom_can_be_trusted(language, name):
    entry = SOLVERS[language, name]
    of_cvxpy = in_cvxpy(find_solver(language, name, 1e-4))
    known = SOLVERS.get(("cvxpy", name))
    expected = name if known and known.decides else "clarabel"
    assert (of_cvxpy.language, of_cvxpy.name) == ("cvxpy", expected)
    assert of_cvxpy.entry.decides
    assert of_cvxpy.tolerance == 1e-9
    assert entry.decides or expected == "clarabel"


FRICTION = 1e6


def solved(data):
    dims = data["dims"]
    cones = [clarabel.ZeroConeT(dims.zero), clarabel.NonnegativeConeT(dims.nonneg)]
    cones += [clarabel.SecondOrderConeT(size) for size in dims.soc]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-10
    size = len(data["c"])
    P = sp.triu(data.get("P", sp.csc_array((size, size)))).tocsc()
    return clarabel.DefaultSolver(P, data["c"], data["A"], data["b"], cones, settings).solve()


def pushed_block(cone: bool) -> dict:
    """Return the program of the largest λ for a block of weight 1 that is pushed sideways by λ and half as
    wide as high.

    The conditions are |s| ≤ μ n and λ ≤ n / 2. The variables are x = (n, s, λ), and the rows are n = 1, s =
    λ, rocking and friction.
    """
    A = [[1, 0, 0], [0, 1, -1], [-0.5, 0, 1], [-FRICTION, 0, 0], [0, -1, 0]]
    if not cone:
        A[3:] = [[-FRICTION, 1, 0], [-FRICTION, -1, 0]]
    b = np.zeros(len(A))
    b[0] = 1.0
    dims = SimpleNamespace(zero=2, nonneg=1 if cone else 3, soc=[2] if cone else [])
    return {"A": sp.csc_array(np.array(A, dtype=float)), "b": b, "c": np.array([0.0, 0, -1]), "dims": dims}


@pytest.mark.parametrize("cone", [False, True], ids=["sides", "cone"])
def test_large_friction_leaves_no_condition_open(cone):
    """By hand, λ = 1/2 follows from the row of rocking alone, whose multiplier is 1. Then Aᵀz = −c."""
    data = pushed_block(cone)
    found = solve_balanced(solved, data)
    assert found.x == pytest.approx([1.0, 0.5, 0.5], abs=1e-7)
    assert found.z[2] == pytest.approx(1.0, abs=1e-7)
    assert data["A"].T @ found.z == pytest.approx(-data["c"], abs=1e-7)


def test_rows_of_one_cone_share_a_factor_and_equations_have_none():
    """With different factors, a point of the scaled cone would not correspond to a point of the original
    cone."""
    seen, given = [], pushed_block(cone=True)
    solve_balanced(lambda data: seen.append(data) or solved(data), given)
    A, scaled = given["A"].toarray(), seen[0]["A"].toarray()
    columns = np.array([scaled[0, 0], *scaled[1, 1:] / A[1, 1:]])
    of_cone = scaled[3, 0] / (A[3, 0] * columns[0]), scaled[4, 1] / (A[4, 1] * columns[1])
    assert of_cone[0] == pytest.approx(of_cone[1], rel=1e-12)
    assert np.abs(scaled).max() <= 1e3 < np.abs(A).max()
    assert seen[0]["c"] == pytest.approx(columns * given["c"])
    assert seen[0]["b"][:2] == pytest.approx(given["b"][:2])
