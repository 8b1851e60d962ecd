"""The loop's answers over grids of its parameters, and the region in which they can be relied on."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.analysis import solve
from masonry_opt.answer.result import Result
from masonry_opt.methods.loop.options import PAPER
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.cases import open_case
from masonry_opt.studies.parts import in_processes

WALLS = (1, 2, 3, 4, 5, 6)

#: A safe λ is at most this share above the paper's, or below the lowest exact state known.
NEAR = 0.01

#: What an answer of the maps leaves of complementarity (energy, in units of λ) and of the flow rule at most:
#: "always < 0.1 %" in the paper, section 5.3.
MOST_LEFT = 1e-3

#: Status of a run that raised what no user should see.
TRACEBACK = "traceback"

#: The share of runs that must end in a certified answer where remedies are allowed.
DEMANDED = 0.99

#: What the parameters do by themselves.
PRESET = {"preset": "paper"}


@dataclass(frozen=True)
class Ticks:
    """One parameter of a grid.

    Attributes
    ----------
    name: heading of its column.
    values: what ``solve`` is given, by the text shown.
    default: text of the default value.
    """

    name: str
    values: dict[str, dict[str, Any]]
    default: str

    @classmethod
    def of(cls, option: str, name: str, numbers: Sequence[float]) -> Ticks:
        """Numbers of one option of the loop, its default among them."""
        return cls(
            name,
            {f"{number:g}": {option: float(number)} for number in numbers},
            f"{PAPER[option]:g}",
        )


@dataclass(frozen=True)
class Grid:
    """Two parameters; the loop is run on every wall for every pair.

    Attributes
    ----------
    title: what is varied.
    rows, columns: the parameters; the columns change fastest.
    ordered: whether neighbours are near each other, so that a region has an inside and an edge.
    """

    title: str
    rows: Ticks
    columns: Ticks
    ordered: bool = True


GRIDS: dict[str, Grid] = {
    "stability_slopes": Grid(
        "first slope α₀ and blending β",
        Ticks.of("alpha", "α₀", (0.05, 0.1, 0.3, 0.6, 0.9)),
        Ticks.of("beta", "β", (0.2, 0.4, 0.6, 0.8, 1.0)),
    ),
    "stability_cohesion": Grid(
        "small cohesion c₀ and tolerance",
        Ticks.of("c0", "c₀", (0.0, 1e-7, 1e-6, 3e-6, 1e-5, 3e-5, 1e-4)),
        Ticks.of("tol", "tol", (1e-6, 1e-5, 1e-4, 1e-3)),
    ),
    "stability_starts": Grid(
        "start and solver",
        Ticks(
            "start",
            {
                "associative": {},
                **{
                    f"cohesive {cohesion:g}": {"start": "cohesive", "trial_cohesion": float(cohesion)}
                    for cohesion in (0.1, 1, 10)
                },
            },
            "associative",
        ),
        Ticks(
            "solver",
            {
                "clarabel": {"solver": "clarabel"},
                "highs-ipm": {"solver": "highs-ipm"},
                "highs": {"solver": "highs"},
                "pyomo highs-ipm": {"model": "pyomo", "solver": "highs-ipm"},
            },
            "clarabel",
        ),
        ordered=False,
    ),
}


def run_grid(
    grid: Grid,
    cases: Path,
    progress: Callable[[str], None] = lambda _: None,
    walls: Sequence[int] = WALLS,
    options: Mapping[str, Any] = PRESET,
) -> pd.DataFrame:
    """Run the loop on some walls for every pair of a grid.

    Parameters
    ----------
    cases: folder of the case files.
    progress: called with a line before each wall.
    options: of the loop, in every run; by default the paper's loop alone, which begins again with less
        slope and no more.

    Returns
    -------
    Frame, one row a run: ``wall``, the two parameters (as text, by their names), ``status``,
    ``load_factor``, ``off`` (over the paper's λ, minus 1), ``sub_problems`` (of the last attempt),
    ``lp_solves`` (of all), ``violation`` (of the true Coulomb law, in median block weights), ``energy``
    (complementarity, in units of λ), ``certified`` and ``safe``.

    Raises
    ------
    CaseError
        If a case file is missing or wrong.
    """
    # Each wall in a process of its own, the largest first: the maps are the dearest of what is reproduced.
    largest_first = sorted(walls, reverse=True)
    found = {}
    for part, rows in in_processes(run_wall, [(grid, cases, wall, dict(options)) for wall in largest_first]):
        progress(f"{grid.title}: wall {largest_first[part]}")
        found[largest_first[part]] = rows
    return pd.DataFrame([row for wall in walls for row in found[wall]])


def run_wall(grid: Grid, cases: Path, wall: int, options: Mapping[str, Any]) -> list[dict[str, object]]:
    """The rows of one wall in the frame of :func:`run_grid`."""
    scene = open_case(cases, f"ferris_tinloi/wall_{wall}.toml")
    rows: list[dict[str, object]] = []
    for row, row_keys in grid.rows.values.items():
        for column, column_keys in grid.columns.values.items():
            cell = {"wall": wall, grid.rows.name: row, grid.columns.name: column}
            try:
                result = solve(scene, "nonassociative", **options, **row_keys, **column_keys)
            except Exception as error:  # a map shows where even this happens
                rows.append(cell | _no_answer(f"{TRACEBACK} of {type(error).__name__}"))
            else:
                rows.append(cell | _measures(scene, result))
    return rows


def _no_answer(status: str) -> dict[str, object]:
    nothing = dict.fromkeys(("load_factor", "off", "violation", "energy"), float("nan"))
    counts = {"sub_problems": 0, "lp_solves": 0}
    return {"status": status, **nothing, **counts, "certified": False, "safe": False}


def _measures(scene: Scene, result: Result) -> dict[str, object]:
    nan = float("nan")
    published, lowest = (scene.reference[name].value for name in ("nonassociative", "refined"))
    found, certificate = result.load_factor, result.certificate
    certified = certificate is not None and max(certificate.complementarity, certificate.flow) <= MOST_LEFT
    return {
        "status": str(result.status),
        "load_factor": nan if found is None else found,
        "off": nan if found is None else found / published - 1,
        "sub_problems": len(result.history),
        "lp_solves": result.lp_solves,
        "violation": certificate.yield_ if certificate else nan,
        "energy": certificate.complementarity if certificate else nan,
        "certified": certified,
        "safe": certified and found is not None and (1 - NEAR) * lowest <= found <= (1 + NEAR) * published,
    }


def with_remedies(
    grid: Grid, frame: pd.DataFrame, cases: Path, progress: Callable[[str], None]
) -> pd.DataFrame:
    """The grid's runs again as a user gets them: with an exact end and every remedy, shape as ``frame``."""
    walls = list(dict.fromkeys(frame["wall"]))
    return run_grid(grid, cases, lambda line: progress(f"{line}, with remedies"), walls, {})


@dataclass(frozen=True)
class Region:
    """The largest rectangle of pairs that are safe on every wall.

    Attributes
    ----------
    safe: of each pair (row, column), whether it is safe on every wall.
    rows, columns: texts of the rectangle's values; empty if there is none.
    """

    grid: Grid
    safe: pd.DataFrame
    rows: list[str]
    columns: list[str]

    @property
    def holds_default(self) -> bool:
        """Whether the default pair lies inside."""
        return self.grid.rows.default in self.rows and self.grid.columns.default in self.columns


def safe_region(grid: Grid, frame: pd.DataFrame) -> Region:
    """The largest rectangle of safe pairs, of those with the default pair if that is safe."""
    rows, columns = list(grid.rows.values), list(grid.columns.values)
    safe = frame.pivot_table(
        index=grid.rows.name, columns=grid.columns.name, values="safe", aggfunc="all", sort=False
    ).loc[rows, columns]
    default = (rows.index(grid.rows.default), columns.index(grid.columns.default))
    with_default = bool(safe.iloc[default])
    best: tuple[int, slice, slice] = (0, slice(0), slice(0))
    for top in range(len(rows)):
        for bottom in range(top + 1, len(rows) + 1):
            for left in range(len(columns)):
                for right in range(left + 1, len(columns) + 1):
                    has_default = top <= default[0] < bottom and left <= default[1] < right
                    area = (bottom - top) * (right - left)
                    if area <= best[0] or (with_default and not has_default):
                        continue
                    if safe.iloc[top:bottom, left:right].to_numpy().all():
                        best = (area, slice(top, bottom), slice(left, right))
    return Region(grid, safe, rows[best[1]], columns[best[2]])


def describe(region: Region, frame: pd.DataFrame) -> str:
    """What region is safe and where the defaults lie in it, in a sentence or two."""
    grid, safe = region.grid, region.safe
    walls = frame["wall"].nunique()
    count = f"{int(safe.to_numpy().sum())} of {safe.size} pairs are safe on all {walls} walls"
    if not region.rows:
        return f"{grid.title}: {count}."
    if not grid.ordered:
        per_column = [
            f"{column}: {int(frame.loc[frame[grid.columns.name] == column, 'safe'].sum())}"
            for column in grid.columns.values
        ]
        each = walls * len(grid.rows.values)
        starts = [row for row in grid.rows.values if safe.loc[row, grid.columns.default]]
        return (
            f"{grid.title}: {count}; of {each} runs by solver, safe are: {', '.join(per_column)}. With "
            f"{grid.columns.default} every wall is safe from: {', '.join(starts) or 'no start'}."
        )
    sentence = (
        f"{grid.title}: {count}; the largest rectangle of them is {_span(region.rows, grid.rows)} by "
        f"{_span(region.columns, grid.columns)}, its middle {_middle(region.rows, grid.rows)}, "
        f"{_middle(region.columns, grid.columns)}"
    )
    defaults = f"{grid.rows.name} = {grid.rows.default}, {grid.columns.name} = {grid.columns.default}"
    if not region.holds_default:
        return f"{sentence}. The defaults ({defaults}) lie outside."
    return (
        f"{sentence}. The defaults ({defaults}) lie inside, {_distance(region.rows, grid.rows)} and "
        f"{_distance(region.columns, grid.columns)}."
    )


def _span(values: list[str], axis: Ticks) -> str:
    return f"{axis.name} = {values[0]}" + (f" to {values[-1]}" if len(values) > 1 else "")


def _middle(values: list[str], axis: Ticks) -> str:
    low, high = values[(len(values) - 1) // 2], values[len(values) // 2]
    return f"{axis.name} = {low}" + (f" to {high}" if high != low else "")


def _distance(values: list[str], axis: Ticks) -> str:
    """How many grid values lie between the default and either edge, and what lies beyond."""
    everything, at = list(axis.values), values.index(axis.default)
    first, last = everything.index(values[0]), everything.index(values[-1])
    below = f"{everything[first - 1]} fails" if first else "the grid ends there"
    above = f"{everything[last + 1]} fails" if last + 1 < len(everything) else "the grid ends there"
    return (
        f"in {axis.name} {at} grid {_steps(at)} from the lower edge ({below}) and "
        f"{len(values) - 1 - at} from the upper ({above})"
    )


def _steps(number: int) -> str:
    return "step" if number == 1 else "steps"
