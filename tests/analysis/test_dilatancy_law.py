"""Dilatancy that falls with mean normal stress (section 6.5), and the check of associative answers."""

import numpy as np
import pytest
from scenes import block_on_floor, solved, two_blocks

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble


def with_law(scene, full, none, dilatancy=None):
    """The scene with a law in every joint; dilatancy at low stress is friction unless given."""
    most = scene.joints.friction if dilatancy is None else dilatancy
    return scene.replace(joints={"dilatancy": most, "dilatancy_stress": (full, none)})


def test_dilatancy_falls_linearly_between_its_stresses():
    """Block of weight 1 on a joint of length 2: stresses 1 and 3 are normal forces 2 and 6."""
    problem = assemble(with_law(block_on_floor(width=2.0), 1.0, 3.0, dilatancy=0.4)).problem
    weight = problem.force_unit
    for force, dilatancy in ((0, 0.4), (2, 0.4), (3, 0.3), (5, 0.1), (6, 0.0), (9, 0.0)):
        assert problem.dilatancy_at(np.array([force / weight])) == pytest.approx([dilatancy])


@pytest.mark.parametrize("none", [1e-3, 0.1, 0.24, 0.3, 0.45, 0.55, 0.6, 0.7, 1.0, 10.0])
def test_two_blocks_by_hand(none):
    """The least λ = μ (1 + 2 n): B sinks, n = 0.25, while the stress of the face and under A, (1 + n) / 3,
    leave no dilatancy, and rises, n = 0.75, as long as A still dilates. Between it rests at
    n = max(none, 3 none - 1): there the loop may find no answer, or one above that."""
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
    """The loop solves such a scene; a search has fixed dilatancy."""
    scene = with_law(two_blocks(), 0.1, 0.2)
    with pytest.raises(mo.OptionError, match=r"'search'.*'dilatancy_stress'"):
        solved(scene, "coulomb", search=1.0)
    assert solved(scene, "coulomb").load_factor == solved(scene, "nonassociative").load_factor


@pytest.mark.parametrize("stresses", [(2.0, 1.0), (1.0, 1.0)])
def test_stresses_must_rise(stresses):
    with pytest.raises(ValueError, match="dilatancy_stress"):
        mo.JointDefaults(friction=0.5, dilatancy=0.1, dilatancy_stress=stresses)
