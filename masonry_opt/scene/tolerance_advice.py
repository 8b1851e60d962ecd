"""Write the parts of messages that advise values of ``tolerance`` and ``contact_tolerance``."""

import math

from masonry_opt.errors import rounded, rounded_down, rounded_up

#: Amount by which a recommended tolerance exceeds the gap, relative to the gap, to allow for
#: rounding.
_GAP_ROUNDING = 1e-6

#: Largest advised ``tolerance``, relative to the thickness of the thinnest block. Sides shorter than about
#: ten tolerances have no joints. With a larger value, the advised tolerance might remove joints.
ADVISED_SHARE = 0.1


def set_tolerance(tolerance: float) -> str:
    """Return the part of a message that advises setting ``tolerance``.

    The value is rounded up to two digits.
    """
    return f"set 'tolerance' to {rounded_up(tolerance, 2)}"


def too_thin_for(tolerance: float, thickness: float, limit: float = math.inf) -> str:
    """Return the end of a message that the thinnest block is too thin for ``tolerance``, with advice.

    See :func:`lower_tolerance` for the limit.
    """
    advice = lower_tolerance(thickness, limit)
    return f"too thin for 'tolerance' {rounded(tolerance)} (thickness {rounded(thickness)}): {advice}"


def lower_tolerance(thickness: float, limit: float = math.inf, option: str = "tolerance") -> str:
    """Return the part of a message that advises a smaller tolerance.

    The advised tolerances are small compared with the thickness of the thinnest block, and smaller than
    ``limit``. The ``option`` is the name of the tolerance.
    """
    advised = rounded_down(min(limit, ADVISED_SHARE * thickness))
    return f"set '{option}' to less than {advised}, and set 'contact_tolerance' to close gaps between stones"


def set_both(gap: float, tolerance: float) -> str:
    """Return the part of a message that advises setting both ``contact_tolerance`` and ``tolerance``.

    The advice is for surveys in which gaps separate the stones.
    """
    return (
        f"{set_contact_tolerance(gap)}, and 'tolerance' to {rounded_up(tolerance, 2)}, which makes nearly "
        "parallel joints parallel"
    )


def set_contact_tolerance(gap: float) -> str:
    """Return the part of a message that advises setting ``contact_tolerance`` to close a gap."""
    return f"set 'contact_tolerance' to {above_gap(gap)}"


def above_gap(gap: float) -> str:
    """Return a tolerance that closes a gap, as text with three digits.

    It is larger than the gap, because the width of the gap may be rounded.
    """
    return rounded_up(gap * (1 + _GAP_ROUNDING), 3)
