"""Functions that format parts of messages."""

import pytest

from masonry_opt.errors import listed, remainder, shortened


@pytest.mark.parametrize(
    ("count", "noun", "expected"),
    [
        (2, "", ""),
        (3, "", ""),
        (4, "", "and 1 more"),
        (5, "", "and 2 more"),
        (4, "row", "and 1 more row"),
        (13, "row", "and 10 more rows"),
    ],
)
def test_items_beyond_the_first_three_are_counted(count, noun, expected):
    items = [f"item {number}" for number in range(count)]
    assert remainder(count, 3, noun) == expected
    assert shortened(items, 3, noun) == items[:3] + ([expected] if expected else [])
    assert listed(items, 3, noun) == (", ".join(items[:3]) + f" {expected}").strip()
