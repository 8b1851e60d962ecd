"""What the report opens with: the load factors, a row a scene and a column a method."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from masonry_opt.answer.thresholds import APART
from masonry_opt.errors import CaseError
from masonry_opt.scene.case_file import load
from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.case_scenes import CaseScene
from masonry_opt.studies.compare.comparison import Comparison
from masonry_opt.studies.compare.judge import CERTIFIED, FAILED, NAMED, WRONG, question_of
from masonry_opt.studies.compare.known_answers import ASSOCIATIVE, COULOMB
from masonry_opt.studies.compare.text import number, reason_text
from masonry_opt.studies.compare.thumbnail import Thumbnail, thumbnail
from masonry_opt.words.sentences import numeral

#: What stands in place of a load factor, and its look, by verdict.
_NO_VALUE = {NAMED: ("no load factor", "named"), FAILED: ("failed", "failed"), WRONG: ("wrong", "wrong")}


@dataclass(frozen=True)
class Cell:
    """A value, what is written small below it, and how it is to look: "" (a load factor), "plain", "named",
    "failed" or "wrong"."""

    value: str
    notes: tuple[str, ...] = ()
    look: str = ""


@dataclass(frozen=True)
class Row:
    """A scene: its picture (None if its case file is gone or has no shapes), and a cell a column."""

    scene: str
    title: str
    picture: Thumbnail | None
    cells: tuple[Cell, ...]


@dataclass(frozen=True)
class Opening:
    """The table: headings of the cells, and the rows."""

    columns: tuple[str, ...]
    rows: tuple[Row, ...]


def opening(comparison: Comparison) -> Opening:
    """The load factors of a comparison, its scenes in their order, its methods in the plan's."""
    methods = [*dict.fromkeys(pair.method for pair in comparison.plan.pairs)]
    associative = [method for method in methods if question_of(method) == ASSOCIATIVE]
    coulomb = [method for method in methods if question_of(method) == COULOMB]
    columns = ["b × c", *(f"associative λ, {method}" for method in associative or ["certified"])]
    if coulomb:
        columns += ["lowest Coulomb λ known", *(f"Coulomb λ, {method}" for method in coulomb)]
        columns.append(f"spread of Coulomb λ, if over {100 * APART:g} %")
    summary = comparison.summary
    answers = frames.answers(summary).to_dict("records") if len(summary) else []
    apart = {str(row["scene"]): row for row in frames.spread(summary).to_dict("records")}
    found = {(str(row["scene"]), str(row["method"])): row for row in answers}
    rows = []
    for scene in comparison.scenes:
        cells = [_size([row for (name, _), row in found.items() if name == scene.name])]
        cells += [_answer(found.get((scene.name, method))) for method in associative]
        if not associative:
            cells.append(_certified(comparison, scene))
        if coulomb:
            cells.append(_best(comparison, scene))
            cells += [_answer(found.get((scene.name, method))) for method in coulomb]
            cells.append(_spread(apart.get(scene.name)))
        rows.append(Row(scene.name, scene.title, _picture(scene), tuple(cells)))
    return Opening(tuple(columns), tuple(rows))


def _picture(scene: CaseScene) -> Thumbnail | None:
    try:
        return thumbnail(load(scene.path))
    except CaseError:
        return None


def _size(rows: list[dict[Any, Any]]) -> Cell:
    """Blocks and joints, as any run found them."""
    for row in rows:
        if not (pd.isna(row["blocks"]) or pd.isna(row["joints"])):
            return Cell(f"{row['blocks']:.0f} × {row['joints']:.0f}", look="plain")
    return Cell("–", look="plain")


def _answer(row: Mapping[Any, Any] | None) -> Cell:
    if row is None:
        return Cell("not run", look="plain")
    notes = [f"{number(row['time'], 2)} s"]
    if row["alike"] < row["runs"]:
        notes.append(f"{row['alike']} of {row['runs']} runs {row['verdict']}")
    if row["verdict"] == CERTIFIED:
        return Cell(_lambda(row["load_factor"]), (*_gap(row), *notes))
    said, look = _NO_VALUE[row["verdict"]]
    given = "" if pd.isna(row["load_factor"]) else f"λ {_lambda(row['load_factor'])}: "
    return Cell(said, (given + reason_text(row, brief=True), *notes), look)


def _gap(row: Mapping[Any, Any]) -> list[str]:
    """How far a load factor is from what is known."""
    if pd.isna(row["gap"]):
        return []
    if row["question"] == ASSOCIATIVE:
        return [f"error {row['error']:.0e}"]
    return [f"gap {100 * row['gap']:+.2g} %" if row["gap"] else "gap 0 %"]


def _best(comparison: Comparison, scene: CaseScene) -> Cell:
    best = comparison.best.get(scene.name)
    return Cell(_lambda(best.load_factor), (best.method,)) if best else Cell("–", look="plain")


def _certified(comparison: Comparison, scene: CaseScene) -> Cell:
    """The associative λ that the bounds enclose, where no method looked for it."""
    bounds = comparison.bounds.get(scene.name)
    known = bounds is not None and bounds.finite
    return Cell(_lambda(bounds.middle)) if bounds and known else Cell("–", look="plain")


def _spread(row: Mapping[Any, Any] | None) -> Cell:
    if row is None:
        return Cell("–", look="plain")
    ends = f"{_lambda(row['lowest'])} to {_lambda(row['highest'])}"
    return Cell(f"{100 * row['spread']:.1f} %", (ends,))


def _lambda(value: float) -> str:
    """A load factor in five digits, zeros too: those of a row are read against each other."""
    return numeral(value, "#.5g").removesuffix(".")
