"""The static and the kinematic program agree in space, by polygons in CVXPY and Pyomo, and by cones.

The load factor by cones lies between those by polygons inside and outside the cones.
"""

from dataclasses import replace

import pytest
from scenes import declared
from scenes_in_space import corner_wall, facade, pushed_box

import masonry_opt as mo
from masonry_opt.problem import faces, matrices
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import Problem

SCENES = {
    "box": pushed_box((1.0, 2.0, 3.0), 0.3, 20.0),
    "corner": corner_wall(2, 2, 3),
    "corner with cohesion": corner_wall(2, 2, 3).replace(joints={"friction": 0.5, "cohesion": 0.02}),
    "nothing slides": corner_wall(2, 2, 2, float("inf")),
    "corner of 20": corner_wall(3, 2, 4),
    "façade": facade(4, 3, 3),
}
FAST = ("box", "nothing slides")
EVERY = [pytest.param(name, marks=() if name in FAST else pytest.mark.slow) for name in SCENES]


@pytest.mark.parametrize("name", EVERY)
def test_four_ways_by_polygons(name):
    report = mo.check(SCENES[name])
    assert len(report.table) == 4
    assert report.passed, report.table.to_string()
    assert bool(report.friction) == (name != "nothing slides")
    assert report.cones == pytest.approx(2 * (mo.solve(SCENES[name], "static").load_factor,), rel=1e-7)


def test_load_factors_by_cones_that_disagree_do_not_pass():
    report = mo.check(SCENES["box"])
    static, kinematic = report.cones
    for cones in ((static, kinematic * (1 + 1e-6)), (0.98 * static, 0.98 * kinematic)):
        assert not replace(report, cones=cones).passed


def with_polygons(problem: Problem, sides: int, *, outside: bool) -> Problem:
    """Return the problem with polygons inside or outside the cones.

    The sides of outside polygons are at c + μ n, those of inside polygons at cos(π/P) times this value.
    """
    layout = faces.space(sides)
    layout = replace(layout, factor=1.0) if outside else layout
    return replace(problem, matrices=replace(problem.matrices, layout=layout))


@pytest.mark.parametrize("sides", [8, matrices.SIDES])
@pytest.mark.parametrize("name", EVERY)
def test_cones_lie_between_polygons(name, sides):
    """The load factor by cones lies between those by polygons of P sides inside and outside, to 1e-7."""
    problem = assemble(SCENES[name]).problem
    cones = mo.solve(SCENES[name], "static").load_factor
    inside, outside = (
        declared(with_polygons(problem, sides, outside=outside), of_load=True).solve().state.load_factor
        for outside in (False, True)
    )
    assert inside <= cones * (1 + 1e-7)
    assert cones <= outside * (1 + 1e-7)
    if name == "box":
        # The box does not slide along a side, so that the polygons change its load factor.
        assert inside < 0.999 * cones
        assert cones < 0.9999 * outside
