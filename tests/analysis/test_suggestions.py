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
    with pytest.raises(mo.CaseError, match="names group 'axels', which no load has; did you mean 'axles'"):
        CASED.replace(load_cases=[mo.LoadCase(name="a", live={"axels": 1.0})])
    scene = block_on_floor().replace(axles=[mo.Axles(name="bogie", loads=[1], road=[(0, 2), (1, 2)])])
    with pytest.raises(mo.OptionError, match="no axles 'bogy'; did you mean 'bogie'"):
        mo.crossing(scene, "bogy")
    with pytest.raises(mo.OptionError, match="kind of picture 'thrsut' is unknown; did you mean 'thrust'"):
        mo.solve(block_on_floor(), "static").plot("thrsut")
