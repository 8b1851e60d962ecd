"""Beer & Johnston, sample problem 8.4: a block raised and lowered by a wedge of 8°, friction 0.35.

The block's weight W, the reaction R of the wedge at an angle a to the vertical, and the push N of the guide
with its friction balance: R sin a = N, and R cos a = W + μ N where the block rises, W - μ N where it sinks.
The wedge takes the force R sin a + μ R cos a, as the floor rubs too.
"""

import math

import pytest
from scenes import CASES, solved

from masonry_opt.answer.acceptance import CLOSED

RAISES = CASES / "beer_johnston" / "wedge_raises.toml"
LOWERS = CASES / "beer_johnston" / "wedge_lowers.toml"

WEIGHT, FRICTION, WEDGE = 400.0, 0.35, math.radians(8)
ANGLE = math.atan(FRICTION)


def force(reaction: float, guide: float) -> float:
    """On the wedge, for a reaction at that angle and a guide whose friction on the block, over its push, is
    ``guide`` upwards."""
    upright = WEIGHT / (1 + guide * math.tan(reaction))
    return upright * (math.tan(reaction) + FRICTION)


def raising() -> float:
    """The wedge's friction adds to its slope."""
    return force(ANGLE + WEDGE, -FRICTION)


def lowering() -> float:
    """Pulled out, the wedge drags the block along, less its slope."""
    return force(ANGLE - WEDGE, FRICTION)


def dilating() -> float:
    """Dilatancy of μ outweighs the slope of tan 8°: the block rises although the wedge is pulled out, and the
    guide holds it down."""
    return force(ANGLE - WEDGE, -FRICTION)


def test_closed_forms_are_the_published_forces():
    assert raising() == pytest.approx(423, abs=0.5)
    assert lowering() == pytest.approx(206, abs=0.55)  # by way of forces rounded to three digits
    assert raising() == pytest.approx(WEIGHT * math.tan(WEDGE + 2 * ANGLE), rel=1e-12)
    assert dilating() == pytest.approx(WEIGHT * math.tan(2 * ANGLE - WEDGE), rel=1e-12)


@pytest.mark.parametrize(
    ("path", "method", "expected"),
    [
        (RAISES, "static", raising()),
        (RAISES, "mcp", raising()),
        (RAISES, "nonassociative", raising()),
        (LOWERS, "static", dilating()),
        (LOWERS, "mcp", lowering()),
        (LOWERS, "nonassociative", lowering()),
    ],
)
def test_load_factors(path, method, expected):
    """The case files have twelve digits of tan 8°."""
    assert solved(path, method).load_factor == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize(("path", "expected"), [(RAISES, raising()), (LOWERS, lowering())])
def test_no_coulomb_state_is_lower(path, expected):
    result = solved(path, "global")
    assert result.bound == pytest.approx(expected, rel=CLOSED)


def test_dilatancy_lifts_the_block_that_is_lowered():
    """It sinks by the slope of the wedge that is pulled out; with dilatancy it rises."""
    true, dilatant = (solved(LOWERS, method).blocks.set_index("block") for method in ("mcp", "static"))
    assert true["vy"]["B"] == pytest.approx(math.tan(WEDGE) * true["vx"]["A"], rel=1e-8)
    assert true["vx"]["A"] < 0
    assert dilatant["vy"]["B"] > 0
