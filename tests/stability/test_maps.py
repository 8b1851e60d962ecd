"""The grid runner, what it calls safe, and what its sheets show."""

from __future__ import annotations

import pandas as pd
import pytest
from scenes import CASES

import masonry_opt as mo
from masonry_opt.studies.atlas import maps
from masonry_opt.studies.atlas.heat_maps import heat_maps, letter
from masonry_opt.studies.atlas.maps import GRIDS, Grid, Ticks, describe, run_grid, safe_region

SMALL = Grid(
    "limit and blending",
    Ticks("most", {"3": {"max_iterations": 3}, "200": {"max_iterations": 200}}, "200"),
    Ticks.of("beta", "β", (0.4, 0.6)),
)


@pytest.fixture(scope="module")
def frame():
    return run_grid(SMALL, CASES, walls=[1])


def test_one_row_a_run(frame):
    assert len(frame) == 4
    assert list(zip(frame["most"], frame["β"], strict=True)) == [
        ("3", "0.4"),
        ("3", "0.6"),
        ("200", "0.4"),
        ("200", "0.6"),
    ]


def test_cells_are_what_solve_answers(frame):
    """The default cell is Table 1's: 0.63982 in the paper."""
    cell = frame.iloc[3]
    result = mo.solve(CASES / "ferris_tinloi" / "wall_1.toml", "nonassociative", beta=0.6, preset="paper")
    assert cell["load_factor"] == pytest.approx(0.63982, rel=3e-4)
    assert cell["load_factor"] == pytest.approx(result.load_factor, rel=1e-9)
    assert cell["sub_problems"] == len(result.history)
    assert cell["violation"] == pytest.approx(result.certificate.yield_)
    assert cell["off"] == pytest.approx(result.load_factor / 0.63982 - 1)


def test_a_failure_is_a_failure_in_the_frame(frame):
    failed = frame[frame["most"] == "3"]
    assert (failed["status"] == mo.Status.ITERATION_LIMIT).all()
    assert failed["load_factor"].isna().all()
    assert not failed["safe"].any()
    assert (failed["sub_problems"] == 3).all()
    assert frame.loc[frame["most"] == "200", "safe"].all()


def test_a_failure_is_a_letter_and_hatched_in_the_figure(frame):
    figure = heat_maps(SMALL, frame)
    axes = figure.axes[0]
    assert axes.get_title() == "wall 1"
    shown = [text.get_text() for text in axes.texts]
    assert shown[:2] == ["L", "L"]
    assert shown[2:] == [f"{count}" for count in frame["sub_problems"][2:]]
    assert sum(bool(patch.get_hatch()) for patch in axes.patches) == 2
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert f"L: {mo.Status.ITERATION_LIMIT}" in legend


def test_a_traceback_is_shown_not_raised(monkeypatch):
    def broken(*_, **__):
        raise ZeroDivisionError

    monkeypatch.setattr(maps, "solve", broken)
    frame = pd.DataFrame(maps.run_wall(SMALL, CASES, 1, {}))
    assert (frame["status"] == "traceback of ZeroDivisionError").all()
    assert letter(frame["status"][0]) == "T"
    assert not frame["safe"].any()
    assert describe(safe_region(SMALL, frame), frame) == (
        "limit and blending: 0 of 4 pairs are safe on all 1 walls."
    )


def test_uncertified_answers_are_not_safe(frame):
    """A loose tolerance stops wall 2 with energy amiss: within 1 % is not enough."""
    loose = Grid("tol", Ticks.of("c0", "c₀", (3e-6, 1e-5)), Ticks.of("tol", "tol", (1e-5, 1e-3)))
    cells = run_grid(loose, CASES, walls=[2])
    uncertified = cells[~cells["certified"] & cells["load_factor"].notna()]
    assert len(uncertified) > 0
    assert (uncertified["energy"] > 1e-3).all()
    assert not uncertified["safe"].any()
    starred = [text.get_text() for text in heat_maps(loose, cells).axes[0].texts]
    assert sum(text.endswith("*") for text in starred) == len(uncertified)


def made_up(safe: list[list[bool]], default: tuple[str, str]) -> tuple[Grid, pd.DataFrame]:
    rows, columns = len(safe), len(safe[0])
    grid = Grid(
        "made up",
        Ticks("r", {str(row): {} for row in range(rows)}, default[0]),
        Ticks("c", {str(column): {} for column in range(columns)}, default[1]),
    )
    cells = [
        {"wall": wall, "r": str(row), "c": str(column), "safe": safe[row][column] or wall == 2}
        for wall in (1, 2)
        for row in range(rows)
        for column in range(columns)
    ]
    return grid, pd.DataFrame(cells)


def test_safe_region_is_the_largest_rectangle_round_the_default():
    """Safe on every wall counts; the larger rectangle elsewhere does not hold the default."""
    grid, frame = made_up(
        [
            [True, True, True, False, False],
            [True, True, True, False, True],
            [True, True, True, False, True],
        ],
        ("1", "4"),
    )
    region = safe_region(grid, frame)
    assert (region.rows, region.columns) == (["1", "2"], ["4"])
    assert region.holds_default
    sentence = describe(region, frame)
    assert "11 of 15 pairs are safe on all 2 walls" in sentence
    assert "r = 1 to 2 by c = 4" in sentence
    assert (
        "in r 0 grid steps from the lower edge (0 fails) and 1 from the upper (the grid ends there)"
        in sentence
    )


def test_an_unsafe_default_is_said_to_lie_outside():
    grid, frame = made_up([[True, True, False]], ("0", "2"))
    region = safe_region(grid, frame)
    assert region.columns == ["0", "1"]
    assert not region.holds_default
    assert describe(region, frame).endswith("The defaults (r = 0, c = 2) lie outside.")


def test_default_pairs_are_the_loops_own():
    assert (GRIDS["stability_slopes"].rows.default, GRIDS["stability_slopes"].columns.default) == (
        "0.3",
        "0.6",
    )
    for grid in GRIDS.values():
        assert grid.rows.default in grid.rows.values
        assert grid.columns.default in grid.columns.values
