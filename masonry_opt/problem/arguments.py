"""Convert arguments of functions to arrays of numbers, and refuse other arguments by their name."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from masonry_opt.errors import OptionError


def per_joint(name: str, value: Any, joints: int) -> np.ndarray:
    """Check an argument, and return one number for each joint that can slide, shape (k,).

    A single number applies to all joints.

    Raises OptionError, which names the argument, if the value is neither a number nor an array of this shape,
    or if a number is not finite.
    """
    needed = f"a number, or one number for each of the {joints} joints that can slide, shape ({joints},)"
    array = numbers(name, value, needed)
    is_wrong = ~np.isfinite(array)
    if is_wrong.any():
        raise OptionError(f"{name} must contain only finite numbers (found {array[is_wrong].flat[0]})")
    if array.ndim == 0:
        return np.full(joints, float(array))
    if array.shape != (joints,):
        raise OptionError(f"{name} must be {needed} (found an array of shape {array.shape})")
    return array


def vector(name: str, value: Any, entries: int, meaning: str) -> np.ndarray:
    """Check an array argument, and return it as a vector with the given number of entries.

    ``meaning`` describes the entries in error messages.

    Raises OptionError, which names the argument, if the value is not an array of this shape.
    """
    needed = f"an array of {meaning}, shape ({entries},)"
    array = numbers(name, value, needed)
    if array.shape != (entries,):
        raise OptionError(f"{name} must be {needed} (found {_described(array)})")
    return array


def numbers(name: str, value: Any, needed: str) -> np.ndarray:
    """Convert a value to an array of floats.

    Raises OptionError if the value is neither a number nor an array of numbers.
    """
    try:
        array = np.asarray(value)
    except ValueError:  # NumPy raises ValueError for nested lists of unequal lengths
        raise OptionError(f"{name} must be {needed} (found lists of unequal lengths)") from None
    if array.dtype.kind not in "iuf":
        raise OptionError(f"{name} must be {needed} (found {_described(array, value)})")
    return array.astype(float, copy=False)


def list_of_numbers(name: str, values: Any) -> list[float]:
    """Return a number or a list of numbers as a list. Raises OptionError for any other value."""
    needed = "a number or a list of numbers"
    array = np.atleast_1d(numbers(name, values, needed))
    if array.ndim != 1 or not np.isfinite(array).all():
        raise OptionError(f"{name} must be {needed} (found {values!r})")
    return [float(number) for number in array]


def refuse_shares(**shares: Sequence[float]) -> None:
    """Raise OptionError if a number is not between 0 and 1."""
    for name, values in shares.items():
        wrong = [value for value in values if not 0 < value < 1]
        if wrong:
            raise OptionError(f"{name} must be between 0 and 1 (found {wrong[0]})")


def _described(array: np.ndarray, value: Any = None) -> str:
    """Describe an argument for an error message, such as ``an array of shape (2,)``."""
    if array.ndim:
        kind = "" if array.dtype.kind in "iuf" else f" of {array.dtype.name}"
        return f"an array{kind} of shape {array.shape}"
    return f"the number {array}" if array.dtype.kind in "iuf" else repr(value)[:60]
