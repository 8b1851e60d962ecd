"""The static and the kinematic program agree, in CVXPY and in Pyomo, and so do duals and unknowns."""

from dataclasses import replace

import pytest
from mappings import mapped
from scenes import ALL_CASES, CASES, CHECKED, KINDS_OF_JOINTS, small_wall, solved

import masonry_opt as mo

FACADE = CASES / "gilbert" / "facade_1x3.toml"

#: Cases on which HiGHS's simplex, Pyomo's default, needs minutes to hours.
TOO_LARGE = {"wall", "facade_2x6", "facade_3x9", "facade_4x12", "facade_6x18", "facade_8x24", "facade_10x30"}
#: Walls of Table 1 that are left out, because the smallest and the largest wall show the same.
LIKE_OTHERS = {f"wall_{number}" for number in range(2, 6)}

LARGE = [path for path in ALL_CASES if path.parent.name == "orduna_lourenco" or "facade" in path.stem]
#: Cases in folders of small cases of every kind.
SMALL = [path for path in ALL_CASES if path.parent.name in CHECKED and path not in LARGE]
SLOW = [path for path in ALL_CASES if path not in SMALL and path.stem not in TOO_LARGE | LIKE_OTHERS]


@pytest.mark.parametrize(
    "path",
    [*SMALL, *(pytest.param(path, marks=pytest.mark.slow) for path in SLOW)],
    ids=lambda path: f"{path.parent.name}/{path.stem}",
)
def test_every_case(path):
    """The four programs of a case agree; small cases also agree with the value of their source."""
    report, reference = mo.check(path), mo.load(path).reference.get("associative")
    assert len(report.table) == 4
    assert report.passed, report.table.to_string()
    if path in SMALL and reference is not None and reference.tolerance is not None:
        near = pytest.approx(reference.value, rel=reference.tolerance)
        assert report.table["load_factor"].to_numpy() == near


@pytest.mark.parametrize("name", KINDS_OF_JOINTS)
def test_terms_that_not_every_scene_has(name):
    report = mo.check(KINDS_OF_JOINTS[name])
    assert report.passed, report.table.to_string()


def test_differences_are_relative_to_load_factors_of_any_size():
    """With a live load multiplied by 10⁶, the same relative error of λ fails the check."""
    scaled = mo.check(mapped(small_wall(), live=1e6))
    assert scaled.passed
    assert scaled.table["load_factor"].to_numpy() * 1e6 == pytest.approx(
        mo.solve(small_wall(), "static").load_factor
    )
    assert scaled.table["difference"].max() < 1e-8
    load_factor = float(scaled.table["load_factor"].median())
    assert replace(scaled, cones=(load_factor, load_factor * (1 + 1e-9))).passed
    assert not replace(scaled, cones=(load_factor, load_factor * (1 + 1e-6))).passed


def test_a_disagreement_does_not_pass():
    table = mo.check(small_wall()).table
    for column in table.columns.drop(["formulation", "model", "load_factor"]):
        wrong = table.copy()
        wrong.loc[2, column] = 2e-6
        assert not mo.DualityReport(wrong).passed
        assert "NOT agree" in str(mo.DualityReport(wrong)).splitlines()[0]


@pytest.mark.parametrize("formulation", ["static", pytest.param("kinematic", marks=pytest.mark.slow)])
def test_the_newer_interior_point_agrees(formulation):
    """HiGHS' interior-point solver HiPO agrees with the default solver on a façade, to 1e-7.

    HiPO gives up on smaller scenes.
    """
    found = mo.solve(FACADE, formulation, solver="highs-hipo")
    assert found.solver == "highs-hipo"
    assert found.load_factor == pytest.approx(solved(FACADE, "static").load_factor, rel=1e-7)
    assert found.certificate.worst < 1e-5


def test_a_check_does_not_depend_on_the_unit_of_the_live_load():
    """A bridge that carries about 80 kN passes the check with a live load of 1 kN and of 0.001 kN.

    With 0.001 kN, λ is some ten thousands.
    """
    scene = mo.load(CASES / "bridges" / "arch_with_fill.toml")
    tiny = [load.model_copy(update={"live": (0.0, -0.001)}) for load in scene.loads]
    whole, parts = mo.check(scene), mo.check(scene.model_copy(update={"loads": tiny}))
    assert whole.passed
    assert parts.passed
    assert parts.table["load_factor"].to_numpy() == pytest.approx(1000 * whole.table["load_factor"], rel=1e-7)
