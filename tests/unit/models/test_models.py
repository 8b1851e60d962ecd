"""Every model declares itself on joints of every kind, and has the order of faces that the problem has."""

import cvxpy as cp
import numpy as np
import pyomo.environ as pyo
import pytest
from scenes import declared

from masonry_opt.methods.exact.refiner import programs
from masonry_opt.models.cvxpy_exact import CvxpyAtYield, CvxpyForces, CvxpyMotion
from masonry_opt.models.cvxpy_kinematic import CvxpyKinematic
from masonry_opt.models.cvxpy_standing import CvxpyDriven, CvxpyFalling, CvxpyStanding
from masonry_opt.models.cvxpy_static import CvxpyStatic
from masonry_opt.models.pyomo_kinematic import PyomoKinematic
from masonry_opt.models.pyomo_mpec import PyomoGlobal, PyomoMpec
from masonry_opt.models.pyomo_static import PyomoStatic
from masonry_opt.models.pyomo_terms import put
from masonry_opt.problem.problem import ShearLimits
from masonry_opt.solvers.highs import LinearProgram

#: Models that have statics, by name, each of a problem and its true shear limits.
STATIC = {
    "eq. (9)": CvxpyStatic,
    "standing": CvxpyStanding,
    "exact, forces": lambda problem, _: CvxpyForces(problem),
    "at yield": lambda problem, _: CvxpyAtYield(problem, np.arange(problem.faces) % 2 == 0, 0.5),
    "eq. (9) in Pyomo": PyomoStatic,
    "MPEC": lambda problem, _: PyomoMpec(problem),
    "global": lambda problem, _: PyomoGlobal(problem, *np.ones((2, problem.faces)), 1.0),
}
#: Models that have mechanisms.
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
    """At any forces whatever: the slack of each face, in order, and what is out of balance."""
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
    """At any velocities and rates whatever: Bᵀd − D p of each joint, under the friction of eq. (10), or the
    joints' own flow rule."""
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
    static, kinematic = (declared(problem, name, language).size() for name in ("static", "kinematic"))
    assert (static.rows, static.columns) == (3 * b + faces, 3 * c + 1)
    # CVXPY writes p ≥ 0 as rows.
    signs = faces if language == "cvxpy" else 0
    assert (kinematic.rows, kinematic.columns) == (3 * c + 1 + signs, 3 * b + faces)


def test_what_exact_states_are_refined_by_is_what_cvxpy_compiles_of_the_models(problem):
    """Column by column and row by row, to the last digit: simplex then ends in the same of many optima."""
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
