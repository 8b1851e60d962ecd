"""What tests of many scenes share."""

from __future__ import annotations

import sys

import pytest


@pytest.fixture
def without_charts(monkeypatch):
    """As where the extra "studies" is not installed: tables alone are written, which takes less time."""
    for module in ("charts", "many.charts"):
        monkeypatch.delitem(sys.modules, f"masonry_opt.studies.{module}", raising=False)
    monkeypatch.setitem(sys.modules, "altair", None)
