"""Dilatancy that falls with mean normal stress (section 6.5), and the check of associative answers."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import CASES, block_on_floor, solved, two_blocks

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble

WALL_4 = CASES / "ferris_tinloi" / "wall_4.toml"


def with_law(scene, full, none, dilatancy=None):
    """The scene with a law in every joint; dilatancy at low stress is friction unless given."""
    most = scene.joints.friction if dilatancy is None else dilatancy
    law = {"dilatancy": most, "dilatancy_stress": (full, none)}
    return scene.model_copy(update={"joints": scene.joints.model_copy(update=law)})


def test_dilatancy_falls_linearly_between_its_stresses():
    """Block of weight 1 on a joint of length 2: stresses 1 and 3 are normal forces 2 and 6."""
    problem = assemble(with_law(block_on_floor(width=2.0), 1.0, 3.0, dilatancy=0.4)).problem
    weight = problem.force_unit
    for force, dilatancy in ((0, 0.4), (2, 0.4), (3, 0.3), (5, 0.1), (6, 0.0), (9, 0.0)):
        assert problem.dilatancy_at(np.array([force / weight])) == pytest.approx([dilatancy])


def test_units_do_not_matter():
    """The same wall in other units of force and length, and the law's stresses with them."""
    scene = two_blocks()
    force, length = 1e4, 1e3
    blocks = [
        block.model_copy(
            update={
                "vertices": [(length * x, length * y) for x, y in block.vertices],
                "weight": None if block.weight is None else force * block.weight,
                "live": (force * block.live[0], force * block.live[1]),
            }
        )
        for block in scene.blocks
    ]
    large = scene.model_copy(update={"blocks": blocks})
    for none in (0.2, 0.8):
        ours = solved(with_law(scene, none / 2, none), "nonassociative")
        theirs = solved(with_law(large, none / 2 * force / length, none * force / length), "nonassociative")
        assert theirs.load_factor == pytest.approx(ours.load_factor, rel=1e-6)


@pytest.mark.parametrize("none", [1e-3, 0.1, 0.24])
def test_two_blocks_above_the_law_are_coulombs(none):
    """B sinks, λ = 1.5 μ, while the stress of the face, 0.25, and under A, 1.25 / 3, leave no dilatancy."""
    result = solved(with_law(two_blocks(), none / 2, none), "nonassociative")
    assert result.load_factor == pytest.approx(0.15, rel=1e-6)
    assert result.joints["n"].min() >= 0.25 - 1e-6


@pytest.mark.parametrize("none", [0.6, 0.7, 1.0, 10.0])
def test_two_blocks_below_the_law_are_associative(none):
    """B rises, λ = 2.5 μ, as long as A still dilates on the floor under its greatest stress, 1.75 / 3."""
    result = solved(with_law(two_blocks(), none / 2, none), "nonassociative")
    assert result.load_factor == pytest.approx(0.25, rel=1e-6)


@pytest.mark.parametrize("none", [0.3, 0.45, 0.55])
def test_two_blocks_between_are_never_given_a_wrong_answer(none):
    """The least λ = μ (1 + 2 n), n = max(none, 3 none - 1): B rests. The loop may find no answer there;
    if it gives one, it is between that and the associative one."""
    result = solved(with_law(two_blocks(), none / 2, none), "nonassociative")
    least = 0.1 * (1 + 2 * max(none, 3 * none - 1))
    if result.load_factor is None:
        assert not result.status.usable
        assert result.status is mo.Status.CYCLING
    else:
        assert least * (1 - 1e-3) <= result.load_factor <= 0.25 * (1 + 1e-6)


def test_a_law_that_no_stress_reaches_changes_nothing():
    scene = mo.load(WALL_4)
    associative = solved(scene, "static").load_factor
    assert solved(with_law(scene, 1e6, 2e6), "nonassociative").load_factor == pytest.approx(
        associative, rel=1e-6
    )
    constant = scene.joints.model_copy(update={"dilatancy": 0.2})
    same = solved(scene.model_copy(update={"joints": constant}), "nonassociative")
    assert solved(with_law(scene, 1e6, 2e6, 0.2), "nonassociative").load_factor == pytest.approx(
        same.load_factor, rel=1e-9
    )


def test_a_law_without_dilatancy_changes_nothing():
    scene = mo.load(WALL_4)
    law = with_law(scene, 0.5, 1.0, dilatancy=0.0)
    assert solved(law, "nonassociative").load_factor == pytest.approx(
        solved(scene, "nonassociative").load_factor, rel=1e-9
    )
    assert solved(law, "refined").load_factor is not None


@pytest.mark.parametrize("method", ["static", "kinematic"])
def test_associative_methods_do_not_heed_it(method):
    scene = two_blocks()
    assert solved(with_law(scene, 0.1, 0.2), method).load_factor == pytest.approx(0.25, rel=1e-6)


@pytest.mark.parametrize("method", ["mpec", "refined", "global"])
def test_methods_with_fixed_dilatancy_refuse_it(method):
    with pytest.raises(mo.OptionError, match=f"'{method}'.*'nonassociative'"):
        solved(with_law(two_blocks(), 0.1, 0.2), method)


@pytest.mark.parametrize("stresses", [(2.0, 1.0), (1.0, 1.0)])
def test_stresses_must_rise(stresses, tmp_path):
    with pytest.raises(ValueError, match="dilatancy_stress"):
        mo.JointDefaults(friction=0.5, dilatancy=0.1, dilatancy_stress=stresses)
    path = tmp_path / "case.toml"
    mo.save(two_blocks(), path)
    text = path.read_text().replace(
        "[joints]\n", f"[joints]\ndilatancy = 0.1\ndilatancy_stress = {list(stresses)}\n"
    )
    path.write_text(text)
    with pytest.raises(mo.CaseError, match="dilatancy_stress") as error:
        mo.load(path)
    assert str(path) in str(error.value)


@pytest.mark.parametrize("ending", [".toml", ".json"])
def test_it_survives_being_written(tmp_path, ending):
    scene = with_law(two_blocks(), 0.5, 2.0)
    own = mo.Joint(between=("A", "floor"), dilatancy=0.05, dilatancy_stress=(0.25, 0.75))
    scene = scene.model_copy(update={"exceptions": [*scene.exceptions, own]})
    path = tmp_path / f"case{ending}"
    mo.save(scene, path)
    assert mo.load(path) == scene
    assert mo.load(path).joints.dilatancy_stress == (0.5, 2.0)
