"""The report as one HTML file that needs no network: load factors by scene and method, charts, tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import shapely

from masonry_opt.answer.acceptance import LIMITS, OUTSIDE
from masonry_opt.answer.thresholds import APART
from masonry_opt.errors import CaseError
from masonry_opt.scene.case_file import load
from masonry_opt.scene.geometry import geometry
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.charts import NamedChart, script
from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.answer import REPEATED_BELOW, Comparison
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


@dataclass(frozen=True)
class Thumbnail:
    """SVG paths of the supports and of the movable blocks, in tenths of a pixel, y downwards."""

    width: int
    height: int
    fixed: str
    movable: str


@dataclass(frozen=True)
class TableCell:
    """A value, notes below it, and its look: "" (a load factor), "plain", "named", "failed" or "wrong"."""

    value: str
    notes: tuple[str, ...] = ()
    look: str = ""


@dataclass(frozen=True)
class SceneRow:
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
    success = runs = None
    if len(summary):
        success = _shown(frames.success(summary), _PAIR | frames.SUCCESS)
        why = [*map(reason_text, summary.to_dict("records"))]
        runs = _shown(summary.assign(why=why), _RUNS)
    residuals = [
        (kind, *(f"{limit.as_dict()[name]:g}" for name in RESIDUALS)) for kind, limit in LIMITS.items()
    ]
    return render(
        "comparison.html",
        title="Comparison of methods and solvers",
        opening=opening(comparison),
        limits=comparison.limits,
        notes=comparison.notes,
        success=success,
        runs=runs,
        charts=charts,
        script=script(),
        references=_references(comparison),
        left_out=_table(("method", "model", "solver", "why"), comparison.plan.left_out),
        residuals=_table(("", *RESIDUALS), residuals, RESIDUALS),
        outside=f"{OUTSIDE:g}",
        target={question: f"{error:g}" for question, error in TARGET.items()},
        gap_floor=f"{GAP_FLOOR:g}",
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
    found = {(str(row["scene"]), str(row["method"])): row for row in answers}
    apart = _apart(summary)

    def size(scene: str) -> TableCell:
        for (name, _), row in found.items():
            if name == scene and not (pd.isna(row["blocks"]) or pd.isna(row["joints"])):
                return TableCell(f"{row['blocks']:.0f} × {row['joints']:.0f}", look="plain")
        return _UNKNOWN

    def answer(method: str, scene: str) -> TableCell:
        return _answer(found.get((scene, method)))

    def certified(scene: str) -> TableCell:
        bounds = comparison.bounds.get(scene)
        return TableCell(_lambda(bounds.middle)) if bounds and bounds.finite else _UNKNOWN

    def best(scene: str) -> TableCell:
        known = comparison.best.get(scene)
        return TableCell(_lambda(known.load_factor), (known.method,)) if known else _UNKNOWN

    def to_expect(scene: str) -> TableCell:
        load_factor = comparison.to_expect.get(scene)
        return _UNKNOWN if load_factor is None else TableCell(_lambda(load_factor))

    def spread(scene: str) -> TableCell:
        if (row := apart.get(scene)) is None:
            return _UNKNOWN
        ends = f"{_lambda(row['lowest'])} to {_lambda(row['highest'])}"
        return TableCell(f"{100 * row['spread']:.1f} %", (ends,))

    def of_methods(question: str) -> dict[str, Callable[[str], TableCell]]:
        methods = dict.fromkeys(pair.method for pair in comparison.plan.pairs)
        return {
            f"{question} λ, {method}": partial(answer, method)
            for method in methods
            if question_of(method) == question
        }

    columns = {"b × c": size} | (of_methods(ASSOCIATIVE) or {"associative λ, certified": certified})
    if coulomb := of_methods(COULOMB):
        columns |= {"lowest Coulomb λ known": best, "λ to expect": to_expect} | coulomb
        columns |= {f"spread of Coulomb λ, if over {100 * APART:g} %": spread}
    rows = [
        SceneRow(
            scene.name,
            scene.title,
            _picture(scene.path),
            tuple(cell(scene.name) for cell in columns.values()),
        )
        for scene in comparison.scenes
    ]
    return [*columns], rows


def _answer(row: Mapping[Any, Any] | None) -> TableCell:
    if row is None:
        return TableCell("not run", look="plain")
    notes = [f"{number(row['time'], 2)} s"]
    if row["alike"] < row["runs"]:
        notes.append(f"{row['alike']} of {row['runs']} runs {row['verdict']}")
    if row["verdict"] == CERTIFIED:
        return TableCell(_lambda(row["load_factor"]), (*_gap(row), *notes))
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
    apart = _apart(comparison.summary)

    def end(row: Mapping[Any, Any], which: str) -> str:
        return f"{number(row[which])} ({row[f'{which} by']})"

    rows = []
    for scene in comparison.scenes:
        bounds, best = comparison.bounds.get(scene.name), comparison.best.get(scene.name)
        ends = apart.get(scene.name)
        rows.append(
            [
                scene.name,
                scene.title,
                number(bounds.lower if bounds else None, 12),
                number(bounds.upper if bounds else None, 12),
                _certified_to(bounds),
                number(best.load_factor if best else None, 9),
                best.method if best else "",
                f"{ends['spread']:.1%}: {end(ends, 'lowest')} to {end(ends, 'highest')}" if ends else "",
                "; ".join(f"{question}: {claim}" for question, claim in scene.expected.items()),
            ]
        )
    bounded = ["associative λ, at least", "at most", "certified to"]
    coulomb = ["lowest exact Coulomb λ", "found by", f"runs more than {APART:.0%} apart in Coulomb λ"]
    columns = ["scene", "title", *bounded, *coulomb, "known by hand"]
    return _table(columns, rows, [*bounded[:2], coulomb[0]])


def _apart(summary: pd.DataFrame) -> dict[str, dict[Any, Any]]:
    """The rows of ``frames.spread`` by scene."""
    return {str(row["scene"]): row for row in frames.spread(summary).to_dict("records")}


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
    frame = (left - margin, bottom - margin, right + margin, top + margin)
    wide, tall = frame[2] - frame[0], frame[3] - frame[1]
    scale = _UNITS * min(_WIDTH / wide, _HEIGHT / tall)
    if len(movable) > _MOST:
        movable = np.array([shapely.union_all(movable)])

    def path(drawn: np.ndarray) -> str:
        """Outlines and holes, in whole units."""
        rings = shapely.get_rings(shapely.get_parts(drawn))
        corners = (
            np.rint((shapely.get_coordinates(ring)[:-1] - (frame[0], frame[3])) * (scale, -scale))
            for ring in rings
        )
        return "".join("M" + " ".join(f"{x:.0f} {y:.0f}" for x, y in ring + 0.0) + "Z" for ring in corners)

    supports = shapely.clip_by_rect(shapes[fixed], *frame)
    return Thumbnail(round(wide * scale), round(tall * scale), path(supports), path(movable))
