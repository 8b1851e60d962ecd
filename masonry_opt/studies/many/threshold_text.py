"""Write the values and load factors of a threshold with enough digits, rounded away from the threshold."""

from collections.abc import Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal

from masonry_opt.reporting.sentences import numeral

#: Values are first rounded to this number of significant digits, to remove errors of binary numbers.
#: Otherwise 0.3, which is slightly smaller in binary, would be rounded down to 0.299999999.
_EXACT_DIGITS = 15


def distinguishing_digits(number: float, others: Sequence[float], least: int) -> int:
    """Return the least number of significant digits that distinguishes a number from other numbers.

    The result is at least ``least``, and at most 17.
    """
    for digits in range(least, 17):
        if all(f"{number:.{digits}g}" != f"{other:.{digits}g}" for other in others):
            return digits
    return 17


def rounded_outwards(value: float, digits: int, upwards: bool) -> str:
    """Return a value as text, rounded to ``digits`` significant digits: up if ``upwards``, else down."""
    if digits >= _EXACT_DIGITS:
        return numeral(value, f".{digits}g")
    exact = Context(prec=_EXACT_DIGITS).create_decimal(Decimal(value))
    context = Context(prec=digits, rounding=ROUND_CEILING if upwards else ROUND_FLOOR)
    return numeral(float(context.create_decimal(exact)), f".{digits}g")
