"""Live loads along the weight of blocks, which at λ = -1 weigh nothing: any mechanism of theirs is exact."""

import pytest

import masonry_opt as mo


def arch(*, wall: float | None = None) -> mo.Scene:
    """An arch with its weight as live load, on fixed abutments or on walls so thick and 3 high."""
    stone = {"unit_weight": 20}
    built = {
        "span": 3,
        "rise": 1,
        "thickness": 0.3,
        "voussoirs": 7,
        "skewbacks": 0.3,
        "abutments": wall is None,
    }
    blocks = mo.Arch(at=(0, 3), live_per_weight=(0, -1), **built, **stone).blocks()
    for name, left in (("left", -1.5 - wall), ("right", 1.5)) if wall else ():
        blocks += mo.Column(name=name, at=(left, 0), width=wall, height=3, drums=6, **stone).blocks()
    return mo.Scene(joints=mo.JointDefaults(friction=0.7), blocks=blocks)


@pytest.mark.parametrize("wall", [0.6, 1.2])
@pytest.mark.parametrize("method", ["mcp", "refined", "compliant"])
def test_walls_overturn_under_the_thrust(wall, method):
    """No joint slides: all three load factors are that of an associative program."""
    bound = mo.solve(arch(wall=wall), "static").load_factor
    result = mo.solve(arch(wall=wall), method)
    assert result.load_factor == pytest.approx(bound, rel=1e-6)
    assert result.certificate.worst < 1e-6


@pytest.mark.parametrize("method", ["mcp", "compliant"])
def test_what_stands_and_jams_is_not_called_unstable(method):
    result = mo.solve(arch(), method)
    assert (result.status, result.load_factor) == (mo.Status.JAMMED, None)
    assert result.solution.proven_none
