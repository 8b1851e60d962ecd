"""The study of both ends of the six walls, of the two blocks in their place."""

from __future__ import annotations

import pytest
from scenes import CASES

from masonry_opt.studies import parts
from masonry_opt.studies.paper import bracket


def test_ends_close_in_and_never_cross(monkeypatch):
    monkeypatch.setattr(bracket, "wall_file", lambda _: "gilbert/two_blocks.toml")
    monkeypatch.setattr(bracket, "_SEARCH", {"search": 0.2})
    monkeypatch.setattr(parts, "cores", lambda: 1)  # another process would know nothing of these
    report = bracket.bracket(CASES)
    walls, steps = report.tables["bracket_walls"], report.tables["bracket_steps"]
    assert list(walls["wall"]) == [1, 2, 3, 4, 5, 6]
    assert walls["lowest λ found"].to_list() == pytest.approx([0.15] * 6, rel=1e-9)  # by hand
    assert walls["bound"].to_list() == pytest.approx([0.15] * 6, rel=1e-5)
    assert (walls["bound"] <= walls["lowest λ found"]).all()
    for _, of_wall in steps.groupby("wall"):
        assert of_wall[of_wall["end"] == "λ"]["value"].is_monotonic_decreasing
        assert of_wall[of_wall["end"] == "bound"]["value"].is_monotonic_increasing
    assert len(report.figures["bracket"].axes) == 6
