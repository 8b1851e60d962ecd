"""Tests of Table 1 of Gilbert, Casapulla & Ahmed (2006), whose values and tolerances are in the case files.

The examples "table1", "fig10" and "fig12" compare the loop and its energy with the published values.
"""

import pytest
from scenes import TABLE_1, solved

import masonry_opt as mo

#: Relative amount by which an exact state may lie above the loop's state: there are many Coulomb states.
ABOVE_LOOP = 1e-6


@pytest.mark.parametrize("path", TABLE_1)
def test_the_default_lies_between_the_published_mpec_and_the_loop(path):
    """The default's λ lies between the published MPEC value and the loop's λ.

    The MPEC minimises λ, so that it bounds the default from below, to its five digits. As the paper found,
    neither the default nor the loop exceeds the published MCP, and the loop does not exceed the associative
    value. Five digits allow a difference of 5e-6.
    """
    scene = mo.load(path)
    default, loop = solved(scene), solved(scene, "nonassociative")
    known = {name: reference.value for name, reference in scene.reference.items()}
    assert loop.load_factor <= min(known["mcp"], known["associative"]) + 5e-6
    assert default.load_factor <= known["mcp"] + 5e-6
    assert default.load_factor <= (1 + ABOVE_LOOP) * loop.load_factor
    # For wall 6 a lower state was communicated later (0.29264), the lowest that is known in the literature.
    assert default.load_factor >= known["mpec"] * (1 - scene.reference["mpec"].tolerance)
    if path.stem not in ("wall_2", "wall_6"):  # Five digits are published.
        assert default.load_factor == pytest.approx(known["mpec"], abs=5e-6)
