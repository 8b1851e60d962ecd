"""Dilatancy that falls with the mean normal stress of a joint (section 6.5 of the paper)."""

import numpy as np
import pytest
from scenes import block_on_floor, solved, two_blocks
from speeds import slow

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble


def with_law(scene, full, none, dilatancy=None):
    """Return the scene with a dilatancy law in every joint, whose dilatancy at low stress is the friction."""
    most = scene.joints.friction if dilatancy is None else dilatancy
    return scene.replace(joints={"dilatancy": most, "dilatancy_stress": (full, none)})


def test_dilatancy_falls_linearly_between_its_stresses():
    """Dilatancy falls linearly between stresses 1 and 3, which are normal forces 2 and 6 on a length of 2."""
    problem = assemble(with_law(block_on_floor(width=2.0), 1.0, 3.0, dilatancy=0.4)).problem
    weight = problem.force_unit
    for force, dilatancy in ((0, 0.4), (2, 0.4), (3, 0.3), (5, 0.1), (6, 0.0), (9, 0.0)):
        assert problem.dilatancy_at(np.array([force / weight])) == pytest.approx([dilatancy])


@pytest.mark.parametrize("none", [1e-3, 0.24, 0.45, 0.6, 10.0, *slow(0.1, 0.3, 0.55, 0.7, 1.0)])
def test_two_blocks_by_hand(none):
    """The loop's load factor is the least one by hand, λ = μ (1 + 2 n), to 1e-6.

    - B sinks with n = 0.25 if the stresses on A and under A, (1 + n) / 3, leave no dilatancy.
    - B rises with n = 0.75 as long as A still dilates.
    - Between these cases n = max(none, 3 none - 1), and the loop may find no answer or a higher one.
    """
    result = solved(with_law(two_blocks(), none / 2, none), "nonassociative")
    least = 0.1 * (1 + 2 * min(max(none, 3 * none - 1, 0.25), 0.75))
    if not 0.25 < none < 1.75 / 3:
        assert result.load_factor == pytest.approx(least, rel=1e-6)
        assert result.joints["n"].min() >= 0.25 - 1e-6
    elif result.load_factor is None:
        assert result.status is mo.Status.CYCLING
    else:
        assert least * (1 - 1e-3) <= result.load_factor <= 0.25 * (1 + 1e-6)


@pytest.mark.parametrize("method", ["mpec", "global"])
def test_methods_with_fixed_dilatancy_refuse_it(method):
    with pytest.raises(mo.OptionError, match=f"'{method}'.*'nonassociative'"):
        solved(with_law(two_blocks(), 0.1, 0.2), method)


def test_a_search_refuses_it():
    """A search refuses dilatancy that depends on stress; without a search, the default is the loop."""
    scene = with_law(two_blocks(), 0.1, 0.2)
    with pytest.raises(mo.OptionError, match=r"'search'.*'dilatancy_stress'"):
        solved(scene, "coulomb", search=1.0)
    assert solved(scene, "coulomb").load_factor == solved(scene, "nonassociative").load_factor


@pytest.mark.parametrize("stresses", [(2.0, 1.0), (1.0, 1.0)])
def test_stresses_must_rise(stresses):
    with pytest.raises(ValueError, match="dilatancy_stress"):
        mo.JointDefaults(friction=0.5, dilatancy=0.1, dilatancy_stress=stresses)
