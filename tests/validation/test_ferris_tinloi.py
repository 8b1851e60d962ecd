"""Table 1 of Gilbert, Casapulla & Ahmed (2006): values and tolerances stand in the case files.

The examples "table1", "fig10" and "fig12" hold the loop to what is published, and its energy.
"""

import pytest
from scenes import TABLE_1, solved

import masonry_opt as mo

#: Coulomb states are many; this far above the loop's an exact state may lie.
ABOVE_LOOP = 1e-6


@pytest.mark.parametrize("path", TABLE_1)
def test_the_default_lies_between_the_published_mpec_and_the_loop(path):
    """The MPEC minimises: with its five digits' tolerance it bounds the default from below. Neither the
    default nor the loop exceeds the published MCP, as the paper found, nor the loop the associative value, by
    more than five digits allow, 5e-6."""
    scene = mo.load(path)
    default, loop = solved(scene), solved(scene, "nonassociative")
    known = {name: reference.value for name, reference in scene.reference.items()}
    assert loop.load_factor <= min(known["mcp"], known["associative"]) + 5e-6
    assert default.load_factor <= known["mcp"] + 5e-6
    assert default.load_factor <= (1 + ABOVE_LOOP) * loop.load_factor
    # Wall 6: a lower state was communicated later (0.29264), the lowest that is known to literature.
    assert default.load_factor >= known["mpec"] * (1 - scene.reference["mpec"].tolerance)
    if path.stem not in ("wall_2", "wall_6"):  # to the five digits that are published
        assert default.load_factor == pytest.approx(known["mpec"], abs=5e-6)
