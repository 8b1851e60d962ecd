"""Fixtures that tests of many scenes share."""

import pytest
from scenes import block_on_floor

import masonry_opt as mo


@pytest.fixture
def case(tmp_path):
    """Return the path of a case file of a block of 1 × 2, which overturns at λ = 1/2."""
    mo.save(block_on_floor(1.0, 2.0), tmp_path / "block.toml")
    return tmp_path / "block.toml"


@pytest.fixture
def without_charts(without):
    """Write tables without charts, which takes less time."""
    without("altair", "studies.charts", "studies.many.charts")
