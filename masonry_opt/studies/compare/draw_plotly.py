"""A chart as a plotly figure, for the page; what it says is escaped, as plotly reads it as markup."""

from __future__ import annotations

import math
from html import escape
from typing import Any

import plotly.graph_objects as go
from plotly.subplots import make_subplots

from masonry_opt.studies.compare.charts import Axis, Bars, Chart, Series

#: Heights in pixels: of a chart, and of a bar's row.
_HEIGHT, _ROW = 440, 34


def draw(chart: Chart | Bars) -> go.Figure:
    """The figure of a chart; of several panels one is shown, to be chosen from a list."""
    figure = _bars(chart) if isinstance(chart, Bars) else _panels(chart)
    # Its legend stands below it in the page.
    figure.update_layout(
        template="simple_white", showlegend=False, margin={"l": 10, "r": 10, "t": 40, "b": 10}
    )
    figure.update_xaxes(automargin=True, showgrid=True)
    figure.update_yaxes(automargin=True)
    return figure


def _panels(chart: Chart) -> go.Figure:
    figure = go.Figure()
    panel_of: list[str] = []  # the panel of each trace
    for title, panel in chart.panels.items():
        for series in panel:
            figure.add_trace(_trace(series).update(visible=not panel_of or title == panel_of[0]))
            panel_of.append(title)
    if chart.band is not None:
        band = {"fillcolor": "#EDEDED", "opacity": 1, "line_width": 0, "layer": "below"}
        figure.add_hrect(chart.band, chart.y.limits[1], **band)
        figure.add_annotation(
            text="not certified", x=0, xref="paper", y=1, yref="paper", showarrow=False, yanchor="top"
        )
    if len(chart.panels) > 1:
        shown = {title: [of == title for of in panel_of] for title in chart.panels}
        buttons = [
            {"label": escape(title), "method": "restyle", "args": [{"visible": visible}]}
            for title, visible in shown.items()
        ]
        place = {"x": 0, "xanchor": "left", "y": 1.02, "yanchor": "bottom"}
        figure.update_layout(updatemenus=[{"buttons": buttons, **place}])
    figure.update_layout(height=_HEIGHT, xaxis=_axis(chart.x), yaxis=_axis(chart.y))
    return figure


def _trace(series: Series) -> go.Scatter:
    modes = {"lines": series.line, "markers": series.marker, "text": series.letters}
    hover = [escape(text).replace("\n", "<br>") for text in series.hover]
    return go.Scatter(
        x=[*series.x],
        y=[*series.y],
        name=escape(series.name),
        mode="+".join(mode for mode, used in modes.items() if used),
        text=[*series.letters],
        textfont={"color": series.colour, "size": 14},
        hovertext=hover,
        hoverinfo="text" if hover else "skip",
        marker={
            "color": series.colour,
            "symbol": (series.marker or "circle") + ("" if series.filled else "-open"),
            "size": 10,
            "maxdisplayed": 5 if series.line == "steps" else 0,
        },
        line={
            "color": series.colour,
            "dash": "solid" if series.filled else "dash",
            "shape": "hv" if series.line == "steps" else "linear",
            "width": 1.5 if series.line == "steps" else 1,
        },
    )


def _axis(axis: Axis) -> dict[str, Any]:
    return {
        "title": escape(axis.label),
        "type": "log" if axis.log else "linear",
        "range": [math.log10(end) for end in axis.limits] if axis.log else axis.limits,
        "tickvals": [*axis.ticks],
        "ticktext": [*axis.ticks.values()],
        "tickangle": 0,
        "showgrid": True,
    }


def _bars(chart: Bars) -> go.Figure:
    figure = make_subplots(1, 2, shared_yaxes=True, horizontal_spacing=0.06)
    # In two lines, to leave room beside them on a narrow screen.
    labels = [escape(label).replace(" · ", "<br>", 1) for label in chart.labels]
    for name, colour, counts in chart.parts:
        text = [str(count or "") for count in counts]
        bars = go.Bar(x=counts, y=labels, name=escape(name), orientation="h", marker_color=colour)
        figure.add_trace(bars.update(text=text, textangle=0, insidetextanchor="middle"), 1, 1)
    low, median, high = ([*column] for column in zip(*chart.times, strict=True))
    figure.add_scatter(
        x=median,
        y=labels,
        mode="markers",
        marker_color="black",
        error_x={
            "array": [end - middle for end, middle in zip(high, median, strict=True)],
            "arrayminus": [middle - start for start, middle in zip(low, median, strict=True)],
        },
        row=1,
        col=2,
    )
    figure.update_layout(
        barmode="stack",
        barnorm="percent",
        height=100 + _ROW * len(labels),
        xaxis={"title": "scenes", "tickvals": [0, 50], "ticktext": ["0", "50 %"]},
        xaxis2=_axis(chart.time),
        yaxis={"autorange": "reversed"},
    )
    return figure
