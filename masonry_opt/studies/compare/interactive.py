"""The charts as plotly figures, from the frames; their labels are escaped, as plotly reads them as markup."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.judge import CERTIFIED
from masonry_opt.studies.compare.known_answers import ASSOCIATIVE, COULOMB
from masonry_opt.studies.compare.style import VERDICT_COLOURS, letter, looks


def interactive_charts(summary: pd.DataFrame) -> list[tuple[str, go.Figure]]:
    """Every chart with its title."""
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
    certified = asked[(asked["verdict"] == CERTIFIED) & (asked[error] > 0)]
    band = 10 * float(certified[error].max()) if len(certified) else 1.0
    least = float(certified[error].min()) if len(certified) else 1e-16
    figure = go.Figure()
    traces_of: list[str] = []  # the scene of each trace
    for scene, frame in asked.groupby("scene", sort=False):
        for pair, group in frame.groupby("pair", sort=False):
            look = shown[str(pair)]
            fine = (group["verdict"] == CERTIFIED) & group[error].notna()
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
        text=["above: not certified", ""],
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
    for verdict, colour in VERDICT_COLOURS.items():
        figure.add_bar(
            y=labels, x=table[verdict].tolist(), name=verdict, orientation="h", marker={"color": colour}
        )
    times = ["" if pd.isna(time) else f"{time:.2g} s" for time in table["time"]]
    figure.add_scatter(
        x=table["scenes"].tolist(),
        y=labels,
        mode="text",
        text=times,
        textposition="middle right",
        cliponaxis=False,
        showlegend=False,
        hoverinfo="skip",
    )
    figure.update_layout(
        barmode="stack",
        template="simple_white",
        height=140 + 22 * len(table),
        xaxis_title="scenes; at the right the median time of the certified answers",
        margin={"r": 90},
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
        f"error {number(line['error'])}, violation {number(line['violation'])}",
        f"{line['time']:.3g} s, {line['peak_memory']:.0f} MB, {number(line['iterations'])} iterations",
    ]
    return "<br>".join(escape(word) for word in words)


def number(value: float) -> str:
    """Five digits; a dash for what is not known."""
    return "–" if value is None or np.isnan(value) else f"{value:.5g}"
