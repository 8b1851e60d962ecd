"""What a plan holds, and that what it leaves out is said with its reason."""

import dataclasses

import pytest
from scenes import two_blocks

import masonry_opt as mo
from masonry_opt.solvers.registry import SOLVERS
from masonry_opt.studies.compare.runs import Pair, plan


def test_everything_admissible_is_planned_at_every_tolerance():
    found = plan(["static", "kinematic"], ["cvxpy", "pyomo"], ["clarabel", "highs"], [1e-4, 1e-8])
    combinations = {(pair.method, pair.model, pair.solver) for pair in found.pairs}
    assert combinations == {
        (method, model, solver)
        for method in ("static", "kinematic")
        for model, solver in (("cvxpy", "clarabel"), ("cvxpy", "highs"), ("pyomo", "highs"))
    }
    assert {pair.tolerance for pair in found.pairs} == {1e-4, 1e-8}
    assert len(found.pairs) == 12
    assert {item[1:3] for item in found.left_out} == {("pyomo", "clarabel")}
    assert all("solver 'clarabel' is unknown for model 'pyomo'" in reason for *_, reason in found.left_out)


@pytest.mark.parametrize(
    ("method", "models", "pair"),
    [
        ("refined", ["pyomo"], Pair("refined", "cvxpy", "highs", None)),
        ("mcp", ["cvxpy", "pyomo"], Pair("mcp", "matrices", "newton", None)),
    ],
)
def test_a_method_with_tolerances_of_its_own_runs_once_with_its_own_solver(method, models, pair):
    assert plan([method], models, ["clarabel"], [1e-4, 1e-8]).pairs == (pair,)


def test_a_solver_the_method_does_not_take_is_left_out_with_a_reason():
    found = plan(["static", "nonassociative"], ["cvxpy", "pyomo"], ["scipy"], [1e-6])
    assert ("nonassociative", "pyomo", "scipy") in {item[:3] for item in found.left_out}
    assert all(reason for *_, reason in found.left_out)


def test_a_solver_that_is_not_installed_is_left_out_with_what_to_install(monkeypatch):
    absent = dataclasses.replace(SOLVERS["cvxpy", "highs-hipo"], missing=lambda: "pip install it")
    monkeypatch.setitem(SOLVERS, ("cvxpy", "highs-hipo"), absent)
    found = plan(["static"], ["cvxpy"], ["highs", "highs-hipo"], [1e-6])
    assert {pair.solver for pair in found.pairs} == {"highs"}
    ((*_, solver, reason),) = found.left_out
    assert (solver, reason.endswith("pip install it")) == ("highs-hipo", True)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((["magic"], ["cvxpy"], ["clarabel"], [1e-6]), "method 'magic' is unknown"),
        ((["static"], ["ampl"], ["clarabel"], [1e-6]), "model 'ampl' is unknown"),
        ((["static"], ["cvxpy"], ["nix"], [1e-6]), "solver 'nix' is unknown"),
        ((["static"], ["cvxpy"], ["clarabel"], [0.0]), "tolerance must be"),
        ((["static"], ["pyomo"], ["clarabel"], [1e-6]), "nothing to compare: static, pyomo, clarabel"),
    ],
)
def test_wrong_names_are_refused(arguments, message):
    with pytest.raises(mo.OptionError, match=message):
        plan(*arguments)


def test_a_scene_made_in_python_is_to_be_saved_first():
    with pytest.raises(mo.OptionError, match=r"mo\.save"):
        mo.compare([two_blocks()])
