"""Table 1 of Gilbert, Casapulla & Ahmed (2006): values and tolerances stand in the case files."""

import pytest
from scenes import TABLE_1, solved

import masonry_opt as mo

#: Coulomb states are many; this far above the loop's an exact state may lie.
ABOVE_LOOP = 1e-6


@pytest.mark.parametrize("path", TABLE_1)
def test_loop_after_step_6_and_the_default_between_it_and_the_published_mpec(path):
    """Of the loop λ to 3e-4 relative, on wall 5 to 2e-3: which optimal state a solver returns moves digits.

    Section 5.3 found actual and corrected sliding energy within 0.1 % of the total: ours up to 0.04 % on
    walls 1 to 5, 0.12 % on wall 6, which spends 18.2 % in sliding. Footnote 4: walls 3 and 4 end in rocking
    alone. Step 4's small cohesion (1e-5) is all that is left.

    The MPEC minimises: with its five digits' tolerance it bounds the default from below. The published MCP
    values are of other states; none is exceeded by more than their five digits.
    """
    scene = mo.load(path)
    result = solved(scene, "nonassociative")
    published = scene.reference["nonassociative"]
    assert published.tolerance <= (2e-3 if path.stem == "wall_5" else 3e-4)
    assert result.status is mo.Status.CONVERGED
    assert result.load_factor == pytest.approx(published.value, rel=published.tolerance)
    # Never above the MCP's value, as the paper found, nor the associative one (five digits allow 5e-6).
    for name in ("mcp", "associative"):
        assert result.load_factor <= scene.reference[name].value + 5e-6
    last = result.history.iloc[-1]
    off = abs(last["sliding"] - last["coulomb_sliding"]) / last["load_factor"]
    assert off < (1.5e-3 if path.stem == "wall_6" else 1e-3)
    if path.stem == "wall_6":
        assert last["coulomb_sliding"] / last["load_factor"] == pytest.approx(0.182, abs=2e-3)
    if path.stem in ("wall_3", "wall_4"):
        assert last["coulomb_sliding"] < 1e-4
    default, mpec = solved(scene), scene.reference["mpec"]
    # Wall 6: a lower state was communicated later (0.29264), the lowest that is known to literature.
    assert default.load_factor >= mpec.value * (1 - mpec.tolerance)
    assert default.load_factor <= scene.reference["mcp"].value + 5e-6
    assert default.load_factor <= (1 + ABOVE_LOOP) * result.load_factor
    if path.stem not in ("wall_2", "wall_6"):  # to the five digits that are published
        assert default.load_factor == pytest.approx(mpec.value, abs=5e-6)
