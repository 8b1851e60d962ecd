"""Parameters of slow tests, which only CI runs."""

from collections.abc import Iterable

import pytest


def slow(*values: object) -> list[object]:
    """Return values as parameters of slow tests. A tuple contains one value for each argument of the test."""
    return [
        pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=pytest.mark.slow)
        for value in values
    ]


def slow_after(count: int, values: Iterable[object]) -> list[object]:
    """Return values as parameters of tests, of which all after the first ``count`` are slow.

    The slow tests repeat the claim of the fast ones.
    """
    listed = list(values)
    return [*listed[:count], *slow(*listed[count:])]
