"""The report as one HTML file: tables and interactive charts, no network needed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from masonry_opt.answer.acceptance import LIMITS, OUTSIDE
from masonry_opt.answer.thresholds import APART
from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.comparison import REPEATED_BELOW, Comparison
from masonry_opt.studies.compare.judge import GAP_FLOOR, TARGET, VERDICTS
from masonry_opt.studies.compare.limits import RESIDUALS
from masonry_opt.studies.compare.opening import opening
from masonry_opt.studies.compare.text import number, reason_text
from masonry_opt.studies.drawing import Drawing, script
from masonry_opt.studies.machine import machine, versions
from masonry_opt.studies.page import render

#: Columns of tables: of the frames, and their headings here.
_SUCCESS = {
    "pair": "method · model · solver",
    "tolerance": "tolerance",
    "success": "success",
    **{verdict: verdict for verdict in VERDICTS},
    "on target": "on target",
    "time": "median time (s)",
    "largest error": "largest error",
    "largest violation": "largest violation",
    "peak_memory": "peak (MB)",
}
_RUNS = {
    "scene": "scene",
    "pair": "method · model · solver",
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
    "equilibrium": "equilibrium",
    "yield": "yield",
    "flow": "flow",
    "complementarity": "complementarity",
}
_FORMATS = {
    "tolerance": "{:.0e}",
    "success": "{:.0%}",
    "on target": "{:.0%}",
    "load_factor": "{:.9g}",
    "time": "{:.3g}",
    **dict.fromkeys(("error", "violation", "largest error", "largest violation"), "{:.1e}"),
    **dict.fromkeys(("equilibrium", "yield", "flow", "complementarity"), "{:.0e}"),
    **dict.fromkeys(("iterations", "lp_solves", "peak_memory", "blocks", "joints"), "{:.0f}"),
}

_NUMBERS = {*_FORMATS, *VERDICTS}


def page(comparison: Comparison, charts: Sequence[Drawing]) -> str:
    """The whole file."""
    summary = comparison.summary
    about = machine() | {f"version of {name}": release for name, release in versions().items()}
    left_out = [[i.method, i.model, i.solver, i.reason] for i in comparison.plan.left_out]
    return render(
        "comparison.html",
        title="Comparison of methods and solvers",
        opening=opening(comparison),
        limits=comparison.limits,
        notes=comparison.notes,
        success=_table(frames.success(summary) if len(summary) else summary, _SUCCESS),
        runs=_table(summary.assign(why=[*map(reason_text, summary.to_dict("records"))]), _RUNS),
        charts=charts,
        script=script(),
        references=_references(comparison),
        left_out={"columns": ["method", "model", "solver", "why"], "rows": left_out, "numbers": ()},
        residuals={
            "columns": ["", *RESIDUALS],
            "rows": [
                [kind, *(f"{of.as_dict()[name]:g}" for name in RESIDUALS)] for kind, of in LIMITS.items()
            ],
            "numbers": RESIDUALS,
        },
        outside=f"{OUTSIDE:g}",
        target={question: f"{error:g}" for question, error in TARGET.items()},
        gap_floor=f"{GAP_FLOOR:g}",
        repeated_below=f"{REPEATED_BELOW:g}",
        about={"columns": ["", ""], "rows": [*about.items()], "numbers": ()},
    )


def _table(frame: pd.DataFrame, columns: dict[str, str]) -> dict[str, Any]:
    """Headings and rows of text, of some of a frame's columns."""
    rows = [[_cell(name, row[name]) for name in columns] for row in frame.to_dict("records")]
    numbers = {heading for name, heading in columns.items() if name in _NUMBERS}
    return {"columns": [*columns.values()], "rows": rows, "numbers": numbers}


def _cell(name: str, value: Any) -> str:
    if pd.isna(value):
        return "–"
    return _FORMATS.get(name, "{}").format(value + 0.0 if isinstance(value, float) else value)


def _references(comparison: Comparison) -> dict[str, Any]:
    apart = {str(line["scene"]): line for line in frames.spread(comparison.summary).to_dict("records")}
    rows = []
    for scene in comparison.scenes:
        bounds, best = comparison.bounds.get(scene.name), comparison.best.get(scene.name)
        rows.append(
            [
                scene.name,
                scene.title,
                number(bounds.lower if bounds else None, 12),
                number(bounds.upper if bounds else None, 12),
                _certified_to(bounds),
                number(best.load_factor if best else None, 9),
                best.method if best else "",
                _ends(apart[scene.name]) if scene.name in apart else "",
                "; ".join(f"{question}: {claim}" for question, claim in scene.expected.items()),
            ]
        )
    bounded = ["associative λ, at least", "at most", "certified to"]
    coulomb = ["lowest exact Coulomb λ", "found by", f"runs more than {APART:.0%} apart in Coulomb λ"]
    columns = ["scene", "title", *bounded, *coulomb, "known by hand"]
    return {"columns": columns, "rows": rows, "numbers": {*bounded[:2], coulomb[0]}}


def _ends(apart: Mapping[Any, Any]) -> str:
    """A row of ``frames.spread`` in words."""
    ends = [f"{number(apart[end])} ({apart[f'{end} by']})" for end in ("lowest", "highest")]
    return f"{apart['spread']:.1%}: {' to '.join(ends)}"


def _certified_to(bounds: CertifiedBounds | None) -> str:
    if bounds is None:
        return "no bounds"
    if bounds.finite:
        return f"{bounds.width:.0e}"
    return "unstable" if bounds.unstable else "unlimited" if bounds.unlimited else "unknown"
