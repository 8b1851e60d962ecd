"""What tests of many scenes share."""

import sys

import pytest
from scenes import block_on_floor

import masonry_opt as mo


@pytest.fixture
def case(tmp_path):
    """A case file of a block that rocks or slides at λ = 1/2."""
    mo.save(block_on_floor(1.0, 2.0), tmp_path / "block.toml")
    return tmp_path / "block.toml"


@pytest.fixture
def without_charts(monkeypatch):
    """As where the extra "studies" is not installed: tables alone are written, which takes less time."""
    for module in ("charts", "many.charts"):
        monkeypatch.delitem(sys.modules, f"masonry_opt.studies.{module}", raising=False)
    monkeypatch.setitem(sys.modules, "altair", None)
