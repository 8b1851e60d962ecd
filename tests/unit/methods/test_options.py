"""An option that a method does not have raises an error, which names the option and the possible ones."""

import pytest
from scenes import two_blocks
from scenes_in_space import box_on_floor

import masonry_opt as mo

#: Method, option and a value out of its range.
OUT_OF_RANGE = [
    *(("nonassociative", name, value) for name, value in (
        ("preset", "fast"), ("sub_problems", "fast"), ("beta", 0), ("beta", 1.5), ("beta", 7), ("tol", 0),
        ("alpha", -1), ("alpha", 2), ("alpha_min", 2), ("c0", -1e-5), ("max_iterations", 0),
        ("start", "warm"), ("trial_cohesion", 0), ("always", 1), ("remedies", "some"), ("revise", 0.1),
    )),
    *(("coulomb", "descent", value) for value in ("no", 1)),
    ("incremental", "curve", 1),
    *(("coulomb", "search", value) for value in (0, -1.0, "10", float("inf"))),
    ("mpec", "epsilon", 1e-10),
]  # fmt: skip

#: Start of the words that advise an object of the settings of the incremental analysis.
SETTINGS = "settings=mo.IncrementalSettings("

LOOP = {"method": "nonassociative"}
STATIC = {"method": "static"}
INCREMENTAL = {"method": "incremental"}
NEWTON = {"model": "pyomo", "solver": "newton"}

#: Arguments of `solve`, and the names that the error message must contain in this order.
NOT_TAKEN = [
    ({"bta": 0.5}, ["'bta'", "'beta'", "nonassociative"]),
    (LOOP | {"bta": 0.5}, ["'bta'", "'beta'"]),
    ({"metod": "static"}, ["'metod'", "'method'"]),
    ({"fallback": False}, ["coulomb", "'fallback'", "descent"]),
    ({"descnt": True}, ["'descnt'", "'descent'"]),
    ({"zzz": 1}, ["coulomb", "'zzz'", "descent"]),
    (LOOP | {"zzz": 1}, ["'zzz'", "preset", "sub_problems", "alpha"]),
    ({"method": "statik"}, ["'statik'", "static"]),
    ({"beta": 0.5}, ["coulomb", "'beta'", "nonassociative"]),
    (STATIC | {"beta": 0.5}, ["'beta'", "nonassociative"]),
    ({"solver": "highs"}, ["newton", "static", "nonassociative"]),
    ({"solver": "clarabel", "tolerance": 1e-6}, ["newton", "static", "nonassociative"]),
    ({"solver": "casadi"}, ["newton", "'pyomo'", "mpec"]),
    (STATIC | {"solver": "casadi"}, ["mpec"]),
    ({"solver": "nope"}, ["newton", "'nope'", "static", "kinematic"]),
    *(({"model": model}, ["matrices", model, "static", "kinematic"]) for model in ("cvxpy", "pyomo")),
    ({"method": "incremental", "model": "pyomo"}, ["matrices", "pyomo", "static"]),
    *(({"method": method, "model": "cvxpy"}, ["pyomo"]) for method in ("mpec", "global")),
    (STATIC | {"model": "matrices"}, ["cvxpy, pyomo", "matrices", "coulomb", "incremental"]),
    ({"tolerance": 1e-6}, ["'tolerance'", "static", "kinematic", "nonassociative"]),
    ({"until": 0.21}, ["'search'"]),
    ({"method": "incremental", "give": 0.1}, ["'give'", "curve, spread, settings"]),
    ({"curve": True}, ["coulomb", "'curve'", "incremental"]),
    (STATIC | NEWTON, ["coulomb"]),
    *(({"method": name} | NEWTON, []) for name in ("kinematic", "mpec", "global")),
    (LOOP | NEWTON, []),
    ({"method": ["static"]}, ["'static'", "unknown"]),
    ({"method": "mcp"}, ["'mcp'", "'coulomb'"]),
    ({"method": "compliant"}, ["'compliant'", "'incremental'"]),
    ({"method": "refined"}, ["'refined'", "search=SECONDS", "'coulomb'"]),
    ({"expected": False}, ["'expected'", "'incremental'"]),
    (INCREMENTAL | {"increment": 0.1}, ["'increment'", SETTINGS + "increment="]),
    ({"increment": 0.1}, ["'coulomb'", "'incremental'", SETTINGS + "increment="]),
    ({"programs": 9}, ["'programs'", "budget=mo.ProofBudget(programs="]),
    ({"most_joints": 9}, ["'most_joints'", "budget=mo.ProofBudget(most_joints="]),
    (INCREMENTAL | {"settings": {"increment": 0.1}}, ["'settings'", "mo.IncrementalSettings", "Python"]),
    ({"settings": "x"}, ["'settings'", "mo.SearchSettings", "Python"]),
    ({"start": 3}, ["'start': must be a result", "Python"]),
]  # fmt: skip


@pytest.mark.parametrize(("method", "option", "value"), OUT_OF_RANGE)
def test_a_value_out_of_range_is_refused_by_the_option_s_name(method, option, value):
    with pytest.raises(mo.OptionError, match=f"'{option}'"):
        mo.solve(two_blocks(), method, **{option: value})


def test_global_search_is_of_the_plane():
    with pytest.raises(mo.OptionError, match="'global'"):
        mo.solve(box_on_floor(), "global")


@pytest.mark.parametrize(("asked", "names"), NOT_TAKEN)
def test_what_a_method_does_not_take_is_refused_with_what_there_is(asked, names):
    with pytest.raises(mo.OptionError) as refused:
        mo.solve(two_blocks(), **asked)
    message = str(refused.value)
    at = 0
    for name in names:
        at = message.find(name, at)
        assert at >= 0, (name, message)
