"""The report as one HTML file that needs no network: load factors by scene and method, charts, tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from masonry_opt.answer.acceptance import LIMITS, OUTSIDE
from masonry_opt.drawing.elements import scene_elements
from masonry_opt.drawing.page import MOST_BLOCKS
from masonry_opt.drawing.svg import Canvas, blocks_svg
from masonry_opt.errors import CaseError
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.case_file import load
from masonry_opt.studies.charts import NamedChart, script
from masonry_opt.studies.compare import frames, judge
from masonry_opt.studies.compare.frames import REPEATED_BELOW, Comparison
from masonry_opt.studies.compare.runs import RESIDUALS
from masonry_opt.studies.journal import machine, versions
from masonry_opt.studies.runner import FINISHED
from masonry_opt.studies.writing import frame_table, render, table
from masonry_opt.words.sentences import numeral

#: Columns of the table of runs, and headings that are not their names.
_RUNS = ["scene", "pair", "load_factor", "tolerance", "verdict", "error", "violation", "time", "reason"]
_RUNS += ["iterations", "lp_solves", "peak_memory", "blocks", "joints", *RESIDUALS]
_HEADINGS = {"pair": "method · model · solver", "load_factor": "λ", "time": "time (s)", "reason": "why"}
_HEADINGS |= {"lp_solves": "LPs"}

#: Text in place of a load factor, and its look, by verdict.
_NO_VALUE = {
    judge.NAMED: ("no load factor", "named"),
    judge.FAILED: ("failed", "failed"),
    judge.WRONG: ("wrong", "wrong"),
}


class TableCell(NamedTuple):
    """A value, notes below it, and its look: "" (a load factor), "plain", "named", "failed" or "wrong"."""

    value: str
    notes: tuple[str, ...] = ()
    look: str = ""


class SceneRow(NamedTuple):
    """A scene: its picture ("" where there is none), and a cell a column."""

    scene: str
    title: str
    picture: str
    cells: tuple[TableCell, ...]


_UNKNOWN = TableCell("–", look="plain")


def page(comparison: Comparison, charts: Sequence[NamedChart]) -> str:
    """The report of a comparison, its charts inside."""
    summary = comparison.summary
    about = machine() | {f"version of {name}": release for name, release in versions().items()}
    tables: dict[str, Any] = dict.fromkeys(("success", "runs"))
    if len(summary):
        headings, columns = _HEADINGS | frames.HEADINGS, ("pair", *frames.SUCCESS)
        tables["success"] = frame_table(frames.success(summary), frames.FORMATS, columns, **headings)
        headings = frames.HEADINGS | _HEADINGS
        tables["runs"] = frame_table(summary, frames.FORMATS, _RUNS, **headings)
    residuals = [
        (kind, *(f"{limit.as_dict()[name]:g}" for name in RESIDUALS)) for kind, limit in LIMITS.items()
    ]
    return render(
        "comparison.html",
        title="Comparison of methods and solvers",
        opening=opening(comparison),
        comparison=comparison,
        **tables,
        charts=charts,
        script=script(),
        left_out=table(("method", "model", "solver", "why"), comparison.plan.left_out),
        residuals=table(("", *RESIDUALS), residuals, RESIDUALS),
        outside=f"{OUTSIDE:g}",
        target={question: f"{error:g}" for question, error in judge.TARGET.items()},
        gap_floor=f"{judge.GAP_FLOOR:g}",
        repeated_below=f"{REPEATED_BELOW:g}",
        about=table(("", ""), [*about.items()]),
    )


def opening(comparison: Comparison) -> tuple[list[str], list[SceneRow]]:
    """Headings and rows of the load factors: scenes in their order, methods in the plan's."""
    summary = comparison.summary
    answers = frames.answers(summary).to_dict("records") if len(summary) else []
    found = {(row["scene"], row["method"]): row for row in answers}
    methods = dict.fromkeys(pair.method for pair in comparison.plan.pairs)
    coulomb = any(judge.question_of(method) == judge.COULOMB for method in methods)
    rows, cells = [], {}
    for scene in comparison.scenes:
        name = scene.name
        bounds, best = comparison.bounds.get(name), comparison.best.get(name)
        sizes = [row for (of, _), row in found.items() if of == name and pd.notna(row["joints"])]
        size = f"{sizes[0]['blocks']:.0f} × {sizes[0]['joints']:.0f}" if sizes else "–"
        of = {
            question: {
                f"{question} λ, {method}": _answer(found.get((name, method)))
                for method in methods
                if judge.question_of(method) == question
            }
            for question in (judge.ASSOCIATIVE, judge.COULOMB)
        }
        certified = _cell(bounds.middle if bounds and bounds.finite else None)
        cells = {"b × c": TableCell(size, look="plain")}
        cells |= of[judge.ASSOCIATIVE] or {"associative λ, certified": certified}
        if coulomb:
            cells["lowest Coulomb λ known"] = _cell(best.load_factor, best.method) if best else _UNKNOWN
            cells["λ to expect"] = _cell(comparison.to_expect.get(name))
            cells |= of[judge.COULOMB]
        rows.append(SceneRow(name, scene.title, _picture(scene.path), tuple(cells.values())))
    return [*cells], rows


def _cell(load_factor: float | None, *notes: str) -> TableCell:
    return _UNKNOWN if load_factor is None else TableCell(_lambda(load_factor), notes)


def _answer(row: Mapping[Any, Any] | None) -> TableCell:
    if row is None:
        return TableCell("not run", look="plain")
    notes = [f"{judge.number(row['time'], 2)} s"]
    if row["alike"] < row["runs"]:
        notes.append(f"{row['alike']} of {row['runs']} runs {row['verdict']}")
    if row["verdict"] == judge.CERTIFIED:
        return _cell(row["load_factor"], *_gap(row), *notes)
    said, look = _NO_VALUE[row["verdict"]]
    given = "" if pd.isna(row["load_factor"]) else f"λ {_lambda(row['load_factor'])}: "
    # An analysis that ended by itself said its status, and explained it in a message.
    why = row["reason"].replace(f": {row['message']}", "") if row["ended"] == FINISHED else row["reason"]
    return TableCell(said, (given + why, *notes), look)


def _gap(row: Mapping[Any, Any]) -> list[str]:
    """How far a load factor is from what is known."""
    if pd.isna(row["gap"]):
        return []
    if row["question"] == judge.ASSOCIATIVE:
        return [f"error {row['error']:.0e}"]
    return [f"gap {100 * row['gap']:+.2g} %" if row["gap"] else "gap 0 %"]


def _lambda(value: float) -> str:
    """A load factor in five digits, zeros too: those of a row are read against each other."""
    return numeral(value, "#.5g").removesuffix(".")


def _picture(case: Path) -> str:
    """A small picture of a scene in the plane, as SVG; "" of one that is large, gone or wrong."""
    try:
        scene = load(case)
        if scene.dimension == 3 or len(scene.blocks) > MOST_BLOCKS:
            return ""
        elements = scene_elements(assemble(scene, floating=True))
    except CaseError:
        return ""
    canvas = Canvas(elements, (), 0.0)
    return canvas.svg(elements.title, [blocks_svg(elements, canvas)], "")
