"""Misspelt methods, models, solvers and options: the error suggests the name that was meant."""

import pytest
from scenes import block_on_floor

import masonry_opt as mo

CASED = block_on_floor().replace(load_cases=[mo.LoadCase(name="storm", live={"live": 1.0})])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"method": "coulom"}, "method 'coulom' is unknown; did you mean 'coulomb'?"),
        ({"method": "Static"}, "method 'Static' is unknown; did you mean 'static'?"),
        ({"method": "KINEMATIC"}, "method 'KINEMATIC' is unknown; did you mean 'kinematic'?"),
        ({"method": "magic"}, "method 'magic' is unknown; choose from: static, kinematic"),
        ({"method": "static", "model": "cvxpi"}, "model 'cvxpi' is unknown; did you mean 'cvxpy'?"),
        ({"method": "static", "solver": "clarabell"}, "did you mean 'clarabel'?"),
        ({"method": "static", "solver": "none"}, "choose from: "),
        ({"serch": 10}, "no option 'serch'; did you mean 'search'?"),
        ({"method": "incremental", "curv": True}, "no option 'curv'; did you mean 'curve'?"),
    ],
)
def test_an_unknown_name_of_solve(options, message):
    with pytest.raises(mo.OptionError) as error:
        mo.solve(block_on_floor(), **options)
    assert message in str(error.value)


def test_unknown_names_of_records():
    with pytest.raises(mo.OptionError, match="no load case 'strom'; did you mean 'storm'"):
        mo.solve(CASED, load_case="strom")
    with pytest.raises(mo.CaseError, match="'set' \"lm71\" is unknown; did you mean 'LM71'"):
        mo.Axles(name="a", set="lm71")
    with pytest.raises(mo.CaseError, match="'axels', but no load has this group; did you mean 'axles'"):
        CASED.replace(load_cases=[mo.LoadCase(name="a", live={"axels": 1.0})])
    scene = block_on_floor().replace(axles=[mo.Axles(name="bogie", loads=[1], road=[(0, 2), (1, 2)])])
    with pytest.raises(mo.OptionError, match="no axles 'bogy'; did you mean 'bogie'"):
        mo.crossing(scene, "bogy")
    with pytest.raises(mo.OptionError, match="kind of picture 'thrsut' is unknown; did you mean 'thrust'"):
        mo.solve(block_on_floor(), "static").plot("thrsut")


STUDIES = {
    "sweep": lambda **more: mo.sweep(block_on_floor(), {"joints.friction": [0.3]}, **more),
    "sample": lambda **more: mo.sample(block_on_floor(), {"joints.friction": ("uniform", 0.3, 0.4)}, **more),
    "least": lambda **more: mo.least(lambda friction: block_on_floor(friction=friction), 0.1, 1.0, **more),
    "most": lambda **more: mo.most(lambda width: block_on_floor(width=width), 0.1, 1.0, **more),
    "settle": lambda **more: mo.settle(block_on_floor(), "floor", (0, -1), **more),
    "crossing": lambda **more: mo.crossing(block_on_floor(), **more),
    "directions": lambda **more: mo.directions(block_on_floor(), **more),
    "solve_cases": lambda **more: mo.solve_cases(CASED, **more),
}


@pytest.mark.parametrize(
    ("study", "typed", "meant"),
    [
        ("sweep", "worker", "workers"),
        ("sweep", "ot", "out"),
        ("sample", "sed", "seed"),
        ("sample", "dsk", "dask"),
        ("least", "sample", "samples"),
        ("most", "laod", "load"),
        ("settle", "movment", "movement"),
        ("crossing", "required_facter", "required_factor"),
        ("crossing", "serch", "search"),
        ("directions", "evry", "every"),
        ("solve_cases", "setled", "settled"),
        ("solve_cases", "time_limits", "time_limit"),
    ],
)
def test_a_misspelt_argument_of_a_study(study, typed, meant):
    with pytest.raises(mo.OptionError) as error:
        STUDIES[study](**{typed: 2})
    assert f"no option '{typed}'; did you mean '{meant}'?" in str(error.value)


def test_an_argument_of_another_study_is_not_suggested():
    with pytest.raises(mo.OptionError) as error:
        mo.solve(block_on_floor(), worker=2)
    assert "workers" not in str(error.value)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: mo.compare([], method="static"),
            "'compare' has no argument 'method'; did you mean 'methods'",
        ),
        (lambda: mo.report([], "page.html", unit="m, kN"), "'report' has no argument 'unit'; did you mean"),
        (lambda: mo.capacity(None, blok="A"), "'capacity' has no argument 'blok'; did you mean 'block'?"),
        (
            lambda: mo.certify(None, 1, 0, 0, crush="chords"),
            "no argument 'crush'; did you mean 'crushing'?",
        ),
        (lambda: mo.check(None, load_case="a"), "'check' has no argument 'load_case'; it has: scene"),
        (lambda: mo.draw(None, name=True), "'draw' has no argument 'name'; did you mean 'names'?"),
        (lambda: mo.export(None, "x.lp", methode="a"), "no argument 'methode'; did you mean 'method'?"),
        (lambda: mo.prove_least(None, second=1.0), "no argument 'second'; did you mean 'seconds'?"),
    ],
)
def test_unknown_arguments_of_functions_without_options(call, message):
    with pytest.raises(mo.OptionError) as error:
        call()
    assert message in str(error.value)


def test_an_unknown_argument_of_a_kinematic_check():
    curve = mo.capacity(mo.solve(block_on_floor(0.6, 3, friction=0.9), "static"), steps=2)
    with pytest.raises(mo.OptionError, match="'check' has no argument 'behavior_factor'; did you mean"):
        curve.check([(0, 0.2), (9, 0.03)], behavior_factor=2.0)
