"""The report as one HTML file that needs no network: load factors by scene and method, charts, tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import shapely

from masonry_opt.answer.acceptance import LIMITS, OUTSIDE
from masonry_opt.answer.thresholds import APART
from masonry_opt.drawing.elements import outlines
from masonry_opt.errors import CaseError
from masonry_opt.scene.case_file import load
from masonry_opt.scene.geometry import geometry
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.charts import NamedChart, script
from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.comparison import REPEATED_BELOW, Comparison
from masonry_opt.studies.compare.judge import (
    ASSOCIATIVE,
    CERTIFIED,
    COULOMB,
    FAILED,
    GAP_FLOOR,
    NAMED,
    TARGET,
    WRONG,
    number,
    question_of,
    reason_text,
)
from masonry_opt.studies.compare.runs import RESIDUALS
from masonry_opt.studies.machine import machine, versions
from masonry_opt.studies.writing import render
from masonry_opt.words.sentences import numeral

_PAIR = {"pair": "method · model · solver"}

#: Columns of the table of runs, and their headings.
_RUNS = {
    "scene": "scene",
    **_PAIR,
    "load_factor": "λ",
    "tolerance": "tolerance",
    "verdict": "verdict",
    "error": "error",
    "violation": "violation",
    "time": "time (s)",
    "why": "why",
    "iterations": "iterations",
    "lp_solves": "LPs",
    "peak_memory": "peak (MB)",
    "blocks": "blocks",
    "joints": "joints",
    **{name: name for name in RESIDUALS},
}

#: Pixels within which a picture fits, and units of its paths in a pixel.
_WIDTH, _HEIGHT, _UNITS = 110, 72, 10

#: Margin around the movable blocks within which supports are drawn, as a share of the larger side.
_MARGIN = 0.06

#: Of more blocks only the outline is drawn: they are smaller than the lines between them.
_MOST = 800

#: Text in place of a load factor, and its look, by verdict.
_NO_VALUE = {NAMED: ("no load factor", "named"), FAILED: ("failed", "failed"), WRONG: ("wrong", "wrong")}


class Thumbnail(NamedTuple):
    """SVG paths of the supports and of the movable blocks, in tenths of a pixel, y downwards."""

    width: int
    height: int
    fixed: str
    movable: str


class TableCell(NamedTuple):
    """A value, notes below it, and its look: "" (a load factor), "plain", "named", "failed" or "wrong"."""

    value: str
    notes: tuple[str, ...] = ()
    look: str = ""


class SceneRow(NamedTuple):
    """A scene: its picture (None if its file is gone or has no shapes in the plane), and a cell a column."""

    scene: str
    title: str
    picture: Thumbnail | None
    cells: tuple[TableCell, ...]


_UNKNOWN = TableCell("–", look="plain")


def page(comparison: Comparison, charts: Sequence[NamedChart]) -> str:
    """The report of a comparison, its charts inside."""
    summary = comparison.summary
    about = machine() | {f"version of {name}": release for name, release in versions().items()}
    tables = {"success": None, "apart": None, "runs": None}
    if len(summary):
        why = [*map(reason_text, summary.to_dict("records"))]
        tables["success"] = _shown(frames.success(summary), _PAIR | frames.SUCCESS)
        tables["runs"] = _shown(summary.assign(why=why), _RUNS)
    if len(apart := frames.spread(summary)):
        tables["apart"] = _shown(apart, {name: name for name in apart})
    residuals = [
        (kind, *(f"{limit.as_dict()[name]:g}" for name in RESIDUALS)) for kind, limit in LIMITS.items()
    ]
    return render(
        "comparison.html",
        title="Comparison of methods and solvers",
        opening=opening(comparison),
        limits=comparison.limits,
        notes=comparison.notes,
        **tables,
        charts=charts,
        script=script(),
        references=_references(comparison),
        left_out=_table(("method", "model", "solver", "why"), comparison.plan.left_out),
        residuals=_table(("", *RESIDUALS), residuals, RESIDUALS),
        outside=f"{OUTSIDE:g}",
        target={question: f"{error:g}" for question, error in TARGET.items()},
        gap_floor=f"{GAP_FLOOR:g}",
        most_apart=f"{100 * APART:g} %",
        repeated_below=f"{REPEATED_BELOW:g}",
        about=_table(("", ""), [*about.items()]),
    )


def _table(
    columns: Sequence[str], rows: Sequence[Sequence[str]], numbers: Sequence[str] = ()
) -> dict[str, Any]:
    """A table of the template; ``numbers``: columns that are aligned to the right."""
    return {"columns": columns, "rows": rows, "numbers": numbers}


def _shown(frame: pd.DataFrame, columns: Mapping[str, str]) -> dict[str, Any]:
    """Some of a frame's columns as a table."""
    words = frames.in_words(frame, columns)
    numbers = [heading for name, heading in columns.items() if name in frames.FORMATS]
    return _table([*words], words.to_numpy().tolist(), numbers)


def opening(comparison: Comparison) -> tuple[list[str], list[SceneRow]]:
    """Headings and rows of the load factors: scenes in their order, methods in the plan's."""
    summary = comparison.summary
    answers = frames.answers(summary).to_dict("records") if len(summary) else []
    found = {(row["scene"], row["method"]): row for row in answers}
    apart = {row["scene"]: row for row in frames.spread(summary).to_dict("records")}
    methods = dict.fromkeys(pair.method for pair in comparison.plan.pairs)
    coulomb = any(question_of(method) == COULOMB for method in methods)
    rows, cells = [], {}
    for scene in comparison.scenes:
        name = scene.name
        bounds, best, ends = comparison.bounds.get(name), comparison.best.get(name), apart.get(name)
        sizes = [row for (of, _), row in found.items() if of == name and pd.notna(row["joints"])]
        size = f"{sizes[0]['blocks']:.0f} × {sizes[0]['joints']:.0f}" if sizes else "–"
        of = {
            question: {
                f"{question} λ, {method}": _answer(found.get((name, method)))
                for method in methods
                if question_of(method) == question
            }
            for question in (ASSOCIATIVE, COULOMB)
        }
        certified = _cell(bounds.middle if bounds and bounds.finite else None)
        cells = {"b × c": TableCell(size, look="plain")}
        cells |= of[ASSOCIATIVE] or {"associative λ, certified": certified}
        if coulomb:
            spread = f"{_lambda(ends['lowest'])} to {_lambda(ends['highest'])}" if ends else ""
            cells["lowest Coulomb λ known"] = _cell(best.load_factor, best.method) if best else _UNKNOWN
            cells["λ to expect"] = _cell(comparison.to_expect.get(name))
            cells |= of[COULOMB]
            cells[f"spread of Coulomb λ, if over {100 * APART:g} %"] = (
                TableCell(f"{100 * ends['spread']:.1f} %", (spread,)) if ends else _UNKNOWN
            )
        rows.append(SceneRow(name, scene.title, _picture(scene.path), tuple(cells.values())))
    return [*cells], rows


def _cell(load_factor: float | None, *notes: str) -> TableCell:
    return _UNKNOWN if load_factor is None else TableCell(_lambda(load_factor), notes)


def _answer(row: Mapping[Any, Any] | None) -> TableCell:
    if row is None:
        return TableCell("not run", look="plain")
    notes = [f"{number(row['time'], 2)} s"]
    if row["alike"] < row["runs"]:
        notes.append(f"{row['alike']} of {row['runs']} runs {row['verdict']}")
    if row["verdict"] == CERTIFIED:
        return _cell(row["load_factor"], *_gap(row), *notes)
    said, look = _NO_VALUE[row["verdict"]]
    given = "" if pd.isna(row["load_factor"]) else f"λ {_lambda(row['load_factor'])}: "
    return TableCell(said, (given + reason_text(row, brief=True), *notes), look)


def _gap(row: Mapping[Any, Any]) -> list[str]:
    """How far a load factor is from what is known."""
    if pd.isna(row["gap"]):
        return []
    if row["question"] == ASSOCIATIVE:
        return [f"error {row['error']:.0e}"]
    return [f"gap {100 * row['gap']:+.2g} %" if row["gap"] else "gap 0 %"]


def _lambda(value: float) -> str:
    """A load factor in five digits, zeros too: those of a row are read against each other."""
    return numeral(value, "#.5g").removesuffix(".")


def _references(comparison: Comparison) -> dict[str, Any]:
    """What runs are held against."""
    rows = []
    for scene in comparison.scenes:
        bounds, best = comparison.bounds.get(scene.name), comparison.best.get(scene.name)
        ends = [number(end, 12) for end in (bounds.lower, bounds.upper)] if bounds else ["–", "–"]
        lowest = [number(best.load_factor, 9), best.method] if best else ["–", ""]
        by_hand = "; ".join(f"{question}: {claim}" for question, claim in scene.expected.items())
        rows.append([scene.name, *ends, _certified_to(bounds), *lowest, by_hand])
    numbers = ["associative λ, at least", "at most", "lowest exact Coulomb λ"]
    columns = ["scene", *numbers[:2], "certified to", numbers[2], "found by", "known by hand"]
    return _table(columns, rows, numbers)


def _certified_to(bounds: CertifiedBounds | None) -> str:
    if bounds is None:
        return "no bounds"
    if bounds.finite:
        return f"{bounds.width:.0e}"
    return "unstable" if bounds.unstable else "unlimited" if bounds.unlimited else "unknown"


def _picture(case: Path) -> Thumbnail | None:
    try:
        scene = load(case)
        return thumbnail(scene) if scene.dimension == 2 else None
    except CaseError:  # its file is gone, or a block has no shape
        return None


def thumbnail(scene: Scene) -> Thumbnail:
    """The picture of a scene. Raises CaseError if a block has no polygon."""
    shapes = geometry(scene).polygons
    fixed = np.array([block.fixed for block in scene.blocks])
    movable = shapes[~fixed]
    left, bottom, right, top = shapely.total_bounds(movable)
    margin = _MARGIN * max(right - left, top - bottom)
    left, bottom, right, top = left - margin, bottom - margin, right + margin, top + margin
    wide, tall = right - left, top - bottom
    scale = _UNITS * min(_WIDTH / wide, _HEIGHT / tall)
    if len(movable) > _MOST:
        movable = np.array([shapely.union_all(movable)])

    def path(drawn: np.ndarray) -> str:
        """Outlines and holes, in whole units."""
        rings = [
            np.rint((ring[:-1] - (left, top)) * (scale, -scale)) for of in outlines(drawn) for ring in of
        ]
        return "".join("M" + " ".join(f"{x:.0f} {y:.0f}" for x, y in ring + 0.0) + "Z" for ring in rings)

    supports = shapely.clip_by_rect(shapes[fixed], left, bottom, right, top)
    return Thumbnail(round(wide * scale), round(tall * scale), path(supports), path(movable))
