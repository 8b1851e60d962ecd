"""The report as one HTML file: interactive charts and tables, no network needed.

Whatever comes from a case file or a solver is escaped: in tables by pandas, in charts here (plotly reads
labels as markup).
"""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

import numpy as np
import pandas as pd
import plotly.graph_objects as go
import plotly.io

from masonry_opt.compare import frames
from masonry_opt.compare.comparison import REPEATED_BELOW, Comparison
from masonry_opt.compare.judge import ASSOCIATIVE, COULOMB, GAP_FLOOR, GOOD, LIMITS, TARGET, VERDICTS
from masonry_opt.compare.machine import machine, versions
from masonry_opt.compare.style import letter, looks

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 1200px; padding: 0 1em }
table { border-collapse: collapse; font-size: 13px; font-variant-numeric: tabular-nums }
th, td { padding: 3px 8px; border-bottom: 1px solid #ddd; text-align: left; white-space: nowrap }
th { position: sticky; top: 0; background: #f4f4f4; cursor: pointer }
.table { overflow: auto; max-height: 600px; margin: 1em 0 }
.words td { white-space: normal } input { padding: 4px; width: 20em }
"""

#: Sorts a table at a click on its head, and hides rows that do not hold what is typed.
_SCRIPT = """
for (const head of document.querySelectorAll('th')) head.onclick = () => {
  const body = head.closest('table').tBodies[0], at = head.cellIndex, up = head.dataset.up !== '1';
  head.dataset.up = up ? '1' : '0';
  const key = row => { const text = row.cells[at].textContent, number = parseFloat(text);
                       return isNaN(number) ? text : number };
  const rows = [...body.rows].sort((a, b) => { const x = key(a), y = key(b);
    return typeof x === typeof y ? (x < y ? -1 : x > y ? 1 : 0) : typeof x === 'number' ? -1 : 1 });
  if (!up) rows.reverse();
  body.append(...rows);
};
for (const box of document.querySelectorAll('input')) box.oninput = () => {
  for (const row of document.querySelectorAll('#' + box.dataset.table + ' tbody tr'))
    row.hidden = !box.value.toLowerCase().split(' ').every(w => row.textContent.toLowerCase().includes(w));
};
"""


def page(comparison: Comparison) -> str:
    """The whole file."""
    summary = comparison.summary
    parts = ["<h1>Comparison of methods and solvers</h1>", _meaning(comparison)]
    if not summary.empty:
        figures = _figures(summary)
        for number, (title, figure) in enumerate(figures):
            parts.append(f"<h2>{escape(title)}</h2>")
            parts.append(
                plotly.io.to_html(
                    figure, full_html=False, include_plotlyjs=number == 0, config={"displaylogo": False}
                )
            )
        parts += [
            "<h2>Success and time</h2>",
            _table(frames.success(summary).drop(columns="pair"), "success"),
        ]
        parts += [
            "<h2>All runs (medians of repeats)</h2>",
            '<input data-table="runs" placeholder="filter: wall_6 clarabel good">',
            _table(summary.drop(columns="pair"), "runs"),
        ]
    parts += ["<h2>What answers are measured by</h2>", _table(_references(comparison), "references")]
    if comparison.plan.left_out:
        left_out = pd.DataFrame([vars(item) for item in comparison.plan.left_out])
        parts += ["<h2>Not applicable</h2>", _table(left_out, "left_out")]
    about = machine() | {f"version of {name}": number for name, number in versions().items()}
    parts += [
        "<h2>Machine, versions, command</h2>",
        _table(pd.DataFrame(about.items(), columns=["", " "]), "about"),
    ]
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>Comparison</title>'
        f"<style>{_STYLE}</style></head><body>{''.join(parts)}<script>{_SCRIPT}</script></body></html>\n"
    )


def _meaning(comparison: Comparison) -> str:
    """What a reader must know before the charts."""
    limits = comparison.limits
    good = "; ".join(
        f"{kind}: " + ", ".join(f"{name} ≤ {value:g}" for name, value in of.items())
        for kind, of in LIMITS.items()
    )
    lines = [
        f"{len(comparison.scenes)} scenes. Each run in its own process, on one core, within "
        f"{limits.time:g} s and {limits.memory:g} MB; times are medians of {limits.repeats} runs (of one "
        f"where a run takes over {REPEATED_BELOW:g} s), without reading the scene and the check of its "
        "dead load, which all share.",
        f"Good: there is a load factor and its certificate leaves at most ({good}). All else is counted and "
        "marked, never drawn as a point of time and error.",
        "Error of the associative λ: relative distance from the middle of certified bounds. Error of "
        f"Coulomb's λ: relative gap to the best exact state known, {GAP_FLOOR:g} at least; beside it the "
        "largest violation of yield in median block weights. An answer below the best exact state is not "
        "exact. One above it may still be a state of Coulomb friction: there are many, and the least is the "
        "safe one.",
        "Profiles and growth: least time, at any tolerance, to a good answer with an error of at most "
        f"{TARGET[ASSOCIATIVE]:g} (associative) or {TARGET[COULOMB]:g} (Coulomb). Open marks and broken "
        "lines: Pyomo.",
        *comparison.notes,
    ]
    return "".join(f"<p>{escape(line)}</p>" for line in lines)


def _figures(summary: pd.DataFrame) -> list[tuple[str, go.Figure]]:
    figures = [("Success rate, method × solver", _success(summary))]
    for asks in (ASSOCIATIVE, COULOMB):
        if not (summary["question"] == asks).any():
            continue
        name = "Associative λ" if asks == ASSOCIATIVE else "Coulomb λ"
        word = "error" if asks == ASSOCIATIVE else "gap to the best exact state"
        figures.append((f"{name}: time against {word}", _time_error(summary, asks, "error", word)))
        if asks == COULOMB:
            what = "largest violation of yield (median block weights)"
            figures.append((f"{name}: time against violation", _time_error(summary, asks, "violation", what)))
        figures.append((f"{name}: performance profile", _profile(summary, asks)))
        figures.append((f"{name}: time against size", _size(summary, asks)))
    return figures


def _time_error(summary: pd.DataFrame, asks: str, error: str, word: str) -> go.Figure:
    asked, shown = summary[summary["question"] == asks], looks(summary)
    good = asked[(asked["verdict"] == GOOD) & (asked[error] > 0)]
    band = 10 * float(good[error].max()) if len(good) else 1.0
    least = float(good[error].min()) if len(good) else 1e-16
    figure = go.Figure()
    traces_of: list[str] = []  # the scene of each trace
    for scene, frame in asked.groupby("scene", sort=False):
        for pair, group in frame.groupby("pair", sort=False):
            look = shown[str(pair)]
            fine = (group["verdict"] == GOOD) & group[error].notna()
            # An exact zero has no place on a logarithmic axis: it stands on the least error shown.
            height = group[error].clip(lower=least).where(fine, band)
            figure.add_scatter(
                x=group["time"].tolist(),
                y=height.tolist(),
                mode="markers+text",
                name=escape(str(pair)),
                text=[
                    "" if ok else letter(line)
                    for ok, line in zip(fine, group.to_dict("records"), strict=True)
                ],
                textposition="top center",
                hovertext=[_hover(line) for line in group.to_dict("records")],
                hoverinfo="text",
                marker={
                    "color": look.colour,
                    "size": 10,
                    "symbol": [look.symbol if ok else "x-thin-open" for ok in fine],
                },
                visible=not traces_of or traces_of[0] == scene,
            )
            traces_of.append(str(scene))
        front = frames.pareto(frame, error=error)
        figure.add_scatter(
            x=front["time"].tolist(),
            y=front[error].clip(lower=least).tolist(),
            mode="lines",
            line={"color": "grey", "shape": "hv", "width": 1},
            name="Pareto front",
            visible=not traces_of or traces_of[0] == scene,
        )
        traces_of.append(str(scene))
    scenes = dict.fromkeys(traces_of)
    buttons = [
        {
            "label": escape(of),
            "method": "update",
            "args": [{"visible": [*(t == of for t in traces_of), True]}],
        }
        for of in scenes
    ]
    figure.add_scatter(
        x=[float(asked["time"].min()), float(asked["time"].max())],
        y=[band / 3] * 2,
        mode="lines+text",
        text=["above: no good answer", ""],
        textposition="top right",
        line={"color": "grey", "dash": "dot"},
        showlegend=False,
        hoverinfo="skip",
    )
    _axes(figure, "time (s)", word)
    figure.update_layout(updatemenus=[{"buttons": buttons, "x": 0, "xanchor": "left", "y": 1.12}])
    return figure


def _profile(summary: pd.DataFrame, asks: str) -> go.Figure:
    figure, shown = go.Figure(), looks(summary)
    curves = frames.profiles(frames.reached(summary, asks))
    last = 2.0 * float(curves["ratio"].max() if len(curves) else 1.0)
    for pair, curve in curves.groupby("pair", sort=False):
        look = shown[str(pair)]
        figure.add_scatter(
            x=[*curve["ratio"], last],
            y=[*curve["share"], curve["share"].iloc[-1]],
            mode="lines+markers",
            line={"color": look.colour, "shape": "hv", "dash": look.dash},
            marker={"symbol": look.symbol},
            name=escape(str(pair)),
        )
    _axes(figure, "time over the fastest pair's", "share of scenes reached within it", y_type="linear")
    return figure


def _size(summary: pd.DataFrame, asks: str) -> go.Figure:
    figure, shown = go.Figure(), looks(summary)
    times = frames.reached(summary, asks)
    fits = frames.growth(times).set_index("pair")
    for pair, group in times[np.isfinite(times["time"])].groupby("pair", sort=False):
        look, fit = shown[str(pair)], fits.loc[str(pair)]
        known = not np.isnan(fit["exponent"])
        label = escape(str(pair)) + (f" ∝ c^{fit['exponent']:.2f}" if known else "")
        figure.add_scatter(
            x=group["joints"].tolist(),
            y=group["time"].tolist(),
            mode="markers",
            marker={"color": look.colour, "symbol": look.symbol, "size": 9},
            name=label,
            legendgroup=label,
            hovertext=[escape(scene) for scene in group["scene"]],
        )
        if known:
            fitted = group["joints"][group["joints"] >= frames.FITTED_FROM]
            x = np.array([fitted.min(), fitted.max()])
            figure.add_scatter(
                x=x.tolist(),
                y=(fit["factor"] * x ** fit["exponent"]).tolist(),
                mode="lines",
                line={"color": look.colour, "dash": look.dash, "width": 1},
                legendgroup=label,
                showlegend=False,
                hoverinfo="skip",
            )
    _axes(figure, "joints c", "time (s)")
    return figure


def _success(summary: pd.DataFrame) -> go.Figure:
    table = frames.success(summary)
    labels = [
        escape(line["pair"]) + ("" if pd.isna(line["tolerance"]) else f" · {line['tolerance']:.0e}")
        for line in table.to_dict("records")
    ]
    figure = go.Figure()
    for verdict, colour in zip(VERDICTS, ("#009E73", "#E69F00", "#999999", "#D55E00"), strict=True):
        figure.add_bar(
            y=labels, x=table[verdict].tolist(), name=verdict, orientation="h", marker={"color": colour}
        )
    figure.update_layout(
        barmode="stack",
        template="simple_white",
        height=140 + 22 * len(table),
        xaxis_title="scenes",
        yaxis={"autorange": "reversed", "automargin": True},
    )
    return figure


def _axes(figure: go.Figure, x: str, y: str, y_type: str = "log") -> None:
    figure.update_layout(template="simple_white", height=560, xaxis_title=x, yaxis_title=y)
    figure.update_xaxes(type="log", showgrid=True)
    figure.update_yaxes(type=y_type, showgrid=True, exponentformat="power")


def _hover(line: Mapping[Any, Any]) -> str:
    """What a mark says when pointed at."""
    tolerance = "" if pd.isna(line["tolerance"]) else f", tolerance {line['tolerance']:.0e}"
    words = [
        f"{line['scene']}: {line['pair']}{tolerance}",
        f"{line['verdict']} {line['reason']}",
        f"λ {line['load_factor']:.9g}",
        f"error {_number(line['error'])}, violation {_number(line['violation'])}",
        f"{line['time']:.3g} s, {line['peak_memory']:.0f} MB, {_number(line['iterations'])} iterations",
    ]
    return "<br>".join(escape(word) for word in words)


def _references(comparison: Comparison) -> pd.DataFrame:
    lines = []
    for scene in comparison.scenes:
        bounds, best = comparison.bounds.get(scene.name), comparison.best.get(scene.name)
        lines.append(
            {
                "scene": scene.name,
                "title": scene.title,
                "λ associative, at least": f"{bounds.lower:.12g}" if bounds else "",
                "at most": f"{bounds.upper:.12g}" if bounds else "",
                "certified to": f"{bounds.width:.0e}" if bounds else "no bounds",
                "best exact Coulomb λ": f"{best.load_factor:.9g}" if best else "none known",
                "found by": best.method if best else "",
            }
        )
    return pd.DataFrame(lines)


def _table(frame: pd.DataFrame, name: str) -> str:
    html = frame.to_html(
        index=False, border=0, table_id=name, na_rep="", float_format=_number, escape=True, justify="left"
    )
    return f'<div class="table">{html}</div>'


def _number(value: float) -> str:
    return "–" if value is None or np.isnan(value) else f"{value:.5g}"
