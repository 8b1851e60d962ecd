"""Results as text for a terminal."""

from __future__ import annotations

import io
import math

import numpy as np
import pandas as pd
from rich import box
from rich.console import Console
from rich.table import Table

from masonry_opt.answer.result import Result
from masonry_opt.duality import DualityReport
from masonry_opt.errors import printable
from masonry_opt.explain.stressed_joints import stressed_joints

#: Columns shown as small numbers.
_RESIDUALS = (
    "difference",
    "equilibrium",
    "yield",
    "flow",
    "kinematics",
    "virtual_work",
    "complementarity",
)


def result_text(result: Result) -> str:
    """A result in a few lines."""
    certificate = result.certificate.as_dict() if result.certificate else {}
    lines = {
        "case": result.case,
        "method": f"{result.method} ({result.model}, {result.solver})",
        "status": f"{result.status}{': ' + result.message if result.message else ''}",
        "load factor": "none" if result.load_factor is None else f"{result.load_factor:.7f}",
        "blocks × joints": f"{result.size.blocks} × {result.size.joints}",
        "certificate": "   ".join(f"{name} {value:.1e}" for name, value in certificate.items()),
        "dilatancy": _dilatancy(result),
        "programs": _programs(result),
        "seconds": "   ".join(f"{part} {value:.3f}" for part, value in result.seconds.items()),
        "published": _published(result),
        "not modelled": "\n                 ".join(result.size.left_out),
    }
    return printable("\n".join(f"{name:<16} {value}" for name, value in lines.items() if value))


def _programs(result: Result) -> str:
    nonlinear = f" and {result.nlp_solves} nonlinear" if result.nlp_solves else ""
    return f"{result.lp_solves} linear{nonlinear} ({result.iterations} solver iterations)"


def _dilatancy(result: Result) -> str:
    """What an associative answer owes to joints too highly stressed to dilate, by the scene's own law."""
    has_law = np.isfinite(result.assembly.problem.dilatancy_force[:, 1]).any()
    if not has_law or result.load_factor is None or result.method not in ("static", "kinematic"):
        return ""
    stressed = stressed_joints(result)
    if stressed.empty:
        return ""
    worst = max(stressed.to_dict("records"), key=lambda joint: joint["stress"])
    return (
        f"not credible in {len(stressed)} sliding joints, with {stressed['energy'].sum():.3g} of λ: stressed "
        f"above 'dilatancy_stress', most in {worst['first']!r}–{worst['second']!r} ({worst['stress']:.3g})"
    )


def _published(result: Result) -> str:
    """The case file's own reference value for the method, and how far the result is from it."""
    name = "associative" if result.method in ("static", "kinematic") else result.method
    reference = result.assembly.scene.reference.get(name)
    if reference is None:
        return ""
    off = ""
    if result.load_factor is not None and reference.value:
        off = f", here {100 * (result.load_factor / reference.value - 1):+.3f} %"
    return f"{reference.value} ({reference.source}){off}"


def duality_text(report: DualityReport) -> str:
    """The duality table and the verdict."""
    verdict = "static and kinematic, CVXPY and Pyomo agree" if report.passed else "they do NOT agree"
    return f"{frame_text(report.table, 'Duality')}\n{verdict}"


def markdown(frame: pd.DataFrame) -> str:
    """A frame as a Markdown table, its numbers as on the terminal."""
    rows = [
        list(map(str, frame.columns)),
        ["---"] * len(frame.columns),
        *(
            [format_cell(str(column), value) for column, value in record.items()]
            for record in frame.to_dict("records")
        ),
    ]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in rows).replace(" --- ", "---")


def frame_text(frame: pd.DataFrame, title: str) -> str:
    """A frame as a table with a title."""
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for column in frame.columns:
        numeric = pd.api.types.is_numeric_dtype(frame[column])
        table.add_column(str(column), justify="right" if numeric else "left")
    for record in frame.to_dict("records"):
        table.add_row(*(format_cell(str(column), value) for column, value in record.items()))
    # A fixed width, wide enough for every column: what is piped or pasted reads as what is seen.
    console = Console(file=io.StringIO(), width=150)
    console.print(table)
    text = console.file.getvalue()  # type: ignore[attr-defined]
    return "\n".join(line.rstrip() for line in text.splitlines()) + "\n"


def format_cell(column: str, value: object) -> str:
    """A value as tables show it; its column's name says which digits matter."""
    if not isinstance(value, float):
        return str(value)
    if math.isnan(value):
        return "–"
    value += 0.0  # no minus before a zero
    if column in _RESIDUALS:
        return f"{value:.1e}"
    if "%" in column:
        return f"{value:+.3f}"
    if "(s)" in column:
        return f"{value:.2f}"
    return f"{value:.6f}" if column in ("mpec", "refined") else f"{value:.5f}"
