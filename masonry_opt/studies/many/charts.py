"""Charts of sweeps and samples.

- A sweep has charts of λ against its parameters. Each kind of mechanism has its own mark, and dashed lines
  show the incremental load factor. A ring marks the least λ. Load factors far above all others are written
  as numbers above the axis.
- A sweep of two parameters also has a heat map.
- A sample has the fragility curve, and a chart of rank correlations.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from masonry_opt.drawing.colours import (
    CRUSHING_COLOUR,
    HINGING_COLOUR,
    LIVE,
    MARKED,
    SEPARATING_COLOUR,
    SERIES,
    SLIDING_COLOUR,
)
from masonry_opt.problem.load_factor_scale import EQUALITY_TOLERANCE, ZERO
from masonry_opt.studies.charts import NamedChart, alt, axis, legend
from masonry_opt.studies.many.runs import HEAT_MAP, INCREMENTAL_COLUMN, at_least, chart_names, ends
from masonry_opt.studies.run_columns import CROSSED_RUNS, is_crossed

#: Colour and mark of each kind of mechanism. Pictures of results use these colours for joints.
_LOOKS = {
    "sliding": (SLIDING_COLOUR, "square"),
    "hinging": (HINGING_COLOUR, "circle"),
    "crushing": (CRUSHING_COLOUR, "cross"),
    "mixed": (MARKED, "triangle-up"),
    "separating": (SEPARATING_COLOUR, "diamond"),
    "none": (LIVE, "triangle-down"),
}
_DARK = "#333333"  #: Colour of lines, and of marks of runs without a mechanism.
_CROSS = "M-.8-.8L.8.8M.8-.8L-.8.8"  #: Mark of a run without a load factor, as an SVG path.
_SHAPE_ABOVE_AXIS = "triangle-up"  #: Mark of a load factor above the end of the axis.
#: A chart of a sweep has a line of λ for each value of the second parameter, up to this number of values.
#: With more values, the chart has points.
_MOST_DRAWN_LINES = 7
#: Largest number of load factors above the end of the axis that a chart writes as numbers. If there are more,
#: the chart writes only the greatest of them.
_MOST_WRITTEN_VALUES = 6
#: Axis titles that contain a symbol, by the name of the parameter on the axis.
_SYMBOLS = {
    "joints.friction": "friction μ = tan φ",
    "joints.friction_angle": "friction angle φ [°]",
    "joints.dilatancy": "dilatancy tan φ₀",
    "joints.dilatancy_angle": "dilatancy angle φ₀ [°]",
    "joints.cohesion": "cohesion c",
}
#: Outliers are drawn in a strip at the top of the chart, so that the axis shows the differences between all
#: other load factors. The smallest outlier is at least this multiple of the next smaller load factor.
_FAR_RATIO = 10.0
#: Largest fraction of the load factors that may be outliers. If there are at least three load factors, the
#: largest may be an outlier even if this fraction does not allow it.
_FAR_SHARE = 0.25
_LABEL = "load factor λ"  #: Title of the axis of load factors.
#: Height in pixels of the two strips of a chart. The top strip is for load factors above the end of the axis,
#: and the bottom strip for runs without a load factor.
_STRIP_HEIGHT = 24
_MOST_CORRELATIONS = 15  #: Largest number of correlations in the chart; weaker ones are not drawn.
#: Colours of the load factors of a sample: the load factor of the method, and the incremental load factor.
_COLOURS = alt.Scale(range=[*SERIES[:2]])
#: Legend entry for load factors above the end of the axis, whose values are written as numbers.
_OFF_AXIS_LABEL = "above the axis: the number is λ"
_RING = "ring: smallest λ"  #: Note on the ring around the smallest load factor.
_WHITE = "white dot: smallest λ"  #: Note on the white dot of the smallest load factor in a heat map.
_DASHED = "dashes: incremental λ"  #: Note on dashed lines or dashes, which show the incremental load factor.


def drawings(frame: pd.DataFrame, names: Sequence[str]) -> list[NamedChart]:
    """Return the charts of λ against the parameters of a sweep.

    For one or two parameters there is a chart of λ against the first parameter, and for two parameters also a
    heat map. For more parameters there is a chart of λ against each parameter.
    """
    named_charts = [against(frame, names, name) for name in (names if len(names) > 2 else names[:1])]
    # A heat map cannot show infinite values of a parameter, such as unlimited friction. If there are such
    # values, no heat map is drawn.
    finite = np.isfinite(frame[list(names)].to_numpy(float)).all()
    if len(names) == 2 and finite and frame["load_factor"].notna().any():
        named_charts.append(heat_map(frame, names[0], names[1]))
    return named_charts


def against(frame: pd.DataFrame, names: Sequence[str], name: str) -> NamedChart:
    """Return the chart of λ against the values of one parameter of a sweep.

    A sweep of one parameter is drawn as a line. A sweep of two parameters has a line for each value of the
    second parameter, unless there are too many values. All other sweeps are drawn as points.
    """
    far = off_axis(np.r_[frame["load_factor"], frame["incremental"]])
    off, failed = far[: len(frame)], frame["load_factor"].isna()
    on_axis = ~failed & ~off
    incremental = frame["incremental"].mask(far[len(frame) :])
    # If both load factors are equal in all runs, only one is drawn: one line would cover the other.
    same = np.allclose(frame["incremental"], frame["load_factor"], rtol=EQUALITY_TOLERANCE, equal_nan=True)
    series = mechanism = frame["mechanism"].fillna("none")
    looks = {kind: look for kind, look in _LOOKS.items() if kind in {*mechanism[on_axis]}}
    lines = _has_lines(frame, names)
    if lines:
        series = names[1] + " = " + frame[names[1]].map("{:g}".format)
        looks = {line: (colour, "circle") for line, colour in zip(series.unique(), SERIES, strict=False)}
    status = "no load factor: " + frame["status"].astype(str)
    looks |= dict.fromkeys(status[failed].unique(), (_DARK, _CROSS))
    looks |= {_OFF_AXIS_LABEL: (_DARK, _SHAPE_ABOVE_AXIS)} if off.any() else {}

    least_ones = at_least(frame)
    marks = frame[["status"]].assign(
        mechanism=mechanism,
        at=frame[name].astype(float),
        line=series,
        series=series.mask(failed, status).mask(off, _OFF_AXIS_LABEL),
        λ=frame["load_factor"],
        incremental=incremental,
        least=least_ones & (least_ones.sum() < frame["load_factor"].count()),
    )
    known, incremental_marks = marks[on_axis], marks[incremental.notna() & (not same)]
    x = alt.X("at:Q", scale=alt.Scale(zero=False, nice=False, padding=12), axis=alt.Axis(title=_label(name)))
    scale = alt.Scale(
        domain=ends(np.r_[known["λ"], incremental]), nice=False, zero=False, padding=_STRIP_HEIGHT
    )
    # A format is set because Vega's default would round labels too much: 0.32 and 0.28 would both be written
    # as 0.3.
    upwards = {"scale": scale, "axis": alt.Axis(title=_LABEL, format=".6~g", labels=len(known) > 0)}
    y = alt.Y("λ:Q", **upwards)
    colours = alt.Scale(domain=[*looks], range=[colour for colour, _ in looks.values()])
    shapes = alt.Scale(domain=[*looks], range=[shape for _, shape in looks.values()])
    solid = alt.Chart(known).encode(x=x, y=y)
    dashed = alt.Chart(incremental_marks).encode(x=x, y=alt.Y("incremental:Q", **upwards))
    stroke: Any = alt.Stroke("line:N", scale=colours) if lines else alt.value(_DARK)
    if lines or len(names) == 1:
        layers = [solid.mark_line(strokeWidth=1.2).encode(stroke=stroke)]
        layers.append(dashed.mark_line(strokeWidth=1.2, strokeDash=[6, 3]).encode(stroke=stroke))
    else:
        layers = [dashed.mark_point(color=_DARK, shape="stroke")]
    # Runs without a load factor are drawn in the bottom strip, and load factors above the end of the axis in
    # the top strip.
    at_bottom, at_top = alt.value(alt.expr(f"height - {_STRIP_HEIGHT / 2}")), alt.value(_STRIP_HEIGHT / 2)
    tooltip = [alt.Tooltip("at:Q", title=name), "λ:N", "mechanism:N", "status:N"]
    if is_crossed(frame):
        marks = marks.assign(**frame[["axles", "direction", "position"]])
        known = marks[on_axis]
        tooltip += ["axles:N", "direction:N", alt.Tooltip("position:Q", format=".6~g")]
    look = {"fill": alt.Fill("series:N", scale=colours), "stroke": alt.Stroke("series:N", scale=colours)}
    look |= {"shape": alt.Shape("series:N", scale=shapes), "tooltip": tooltip}
    for rows, height in ((known, y), (marks[failed], at_bottom), (marks[off], at_top)):
        layers.append(alt.Chart(rows).mark_point(size=45, opacity=1).encode(x=x, y=height, **look))
    layers.append(alt.Chart(marks[marks["least"]]).mark_point(size=220, color=_DARK).encode(x=x, y=y))
    # If many load factors are above the end of the axis, their numbers would overlap. Only the greatest of
    # these load factors is then written.
    written = marks[off] if off.sum() <= _MOST_WRITTEN_VALUES else marks[off].nlargest(1, "λ")
    text = alt.Chart(written).mark_text(color=_DARK, dy=-_STRIP_HEIGHT)
    layers.append(text.encode(x=x, y=at_top, text=alt.Text("λ:Q", format=".4~g")))
    file = chart_names(names)[[*names].index(name)]
    notes = [_RING] if marks["least"].any() else []
    notes += [_DASHED] if len(incremental_marks) else []
    notes += _note_on_equal_lines(frame, names) + _names_of_load_factors(frame) + _note_on_axles(frame)
    # Vega warns of layers without rows. The first layer is kept, because it has the axis of λ.
    layers[1:] = [layer for layer in layers[1:] if len(layer.data)]
    return NamedChart(file, f"{_LABEL} against {_label(name)}", alt.layer(*layers), "; ".join(notes))


def _has_lines(frame: pd.DataFrame, names: Sequence[str]) -> bool:
    """Return True if a sweep of two parameters is drawn with a line for each value of the second one."""
    return len(names) == 2 and frame[names[1]].nunique() <= _MOST_DRAWN_LINES


def _note_on_equal_lines(frame: pd.DataFrame, names: Sequence[str]) -> list[str]:
    """Return a list with a note on the lines of a chart that coincide; empty if no lines coincide.

    The note names the lines by their parameter values. It is needed because the last line that is drawn hides
    the other lines.
    """
    if not _has_lines(frame, names):
        return []
    across, line = names
    table = frame.pivot_table("load_factor", across, line, dropna=False).dropna(axis=1, how="all")
    load_factors = table.to_numpy(float)
    groups: list[list[float]] = []
    drawn: list[np.ndarray] = []
    for value, of_value in zip(table.columns.to_numpy(float), load_factors.T, strict=True):
        is_equal = [np.allclose(of_value, other, rtol=EQUALITY_TOLERANCE, equal_nan=True) for other in drawn]
        if any(is_equal):
            groups[is_equal.index(True)].append(value)
        else:
            drawn.append(of_value)
            groups.append([value])
    equal = [", ".join(f"{value:g}" for value in group) for group in groups if len(group) > 1]
    return [f"equal lines: {line} = {'; '.join(equal)}"] if equal else []


def heat_map(frame: pd.DataFrame, across: str, up: str) -> NamedChart:
    """Return the heat map of λ over two parameters; runs without a load factor are grey."""
    off, missing = off_axis(frame["load_factor"]), frame["load_factor"].isna().any()
    least = at_least(frame) & (frame["load_factor"].nunique() > 1)
    cells = frame[[across, up, "load_factor", "status"]].set_axis(["x", "y", "λ", "status"], axis=1)
    number = alt.Axis(format=".4~g", formatType="number", labelAngle=0)
    x = alt.X("x:O", title=_label(across), axis=number)
    y = alt.Y("y:O", title=_label(up), axis=number, sort="descending")
    of_colours = alt.Legend(title=_LABEL, orient="bottom", direction="horizontal", gradientLength=200)
    scale = alt.Scale(scheme="viridis", domain=ends(frame["load_factor"][~off]), clamp=True)
    tooltip = [alt.Tooltip("x:O", title=across), alt.Tooltip("y:O", title=up), "λ:N", "status:N"]
    grey = alt.Chart(cells).mark_rect(color="#CCCCCC").encode(x, y, tooltip=tooltip)
    known = alt.Chart(cells.dropna(subset=["λ"])).mark_rect(color="#CCCCCC").encode(x, y, tooltip=tooltip)
    ring = alt.Chart(cells[least]).mark_point(size=90, filled=True, fill="white", stroke=_DARK, opacity=1)
    notes = [_WHITE] if least.any() else []
    notes += ["load factors far above all others have the last colour of the scale"] if off.any() else []
    notes += ["grey: no load factor"] if missing else []
    coloured = known.encode(fill=alt.Fill("λ:Q", scale=scale, legend=of_colours))
    chart = (grey + coloured + ring.encode(x, y)).properties(height=300)
    notes += _names_of_load_factors(frame)
    notes += _note_on_axles(frame)
    return NamedChart(HEAT_MAP, f"{_LABEL} over two parameters", chart, "; ".join(notes))


def _names_of_load_factors(frame: pd.DataFrame) -> list[str]:
    """Return a note that names the load factors in the chart, as a list; empty without load factors."""
    names = frame.loc[frame["load_factor"].notna(), "which"].unique()
    return [f"λ: {', '.join(names)}"] if len(names) else []


def _note_on_axles(frame: pd.DataFrame) -> list[str]:
    """Return a note that axles cross the scene, as a list; empty if no axles cross the scene."""
    return [CROSSED_RUNS] if is_crossed(frame) else []


def off_axis(load_factors: ArrayLike) -> np.ndarray:
    """Return a mask, shape (n,), of the load factors that are too large for the axis of a chart."""
    values = np.asarray(load_factors, dtype=float)
    ascending = np.sort(values[np.isfinite(values)])
    greatest = np.maximum.accumulate(np.abs(ascending))
    most_far = max(int(_FAR_SHARE * len(ascending)), len(ascending) >= 3)
    far = (greatest[:-1] > ZERO) & (ascending[1:] >= _FAR_RATIO * greatest[:-1])
    far[: max(0, len(far) - most_far)] = False
    return values >= ascending[1:][far].min() if far.any() else np.zeros(len(values), dtype=bool)


def _label(name: str) -> str:
    """Return the axis title for a parameter of the scene."""
    return _SYMBOLS.get(name, name)


def _by_load(frame: pd.DataFrame, own: str) -> pd.DataFrame:
    """Return a table with separate rows for the method's own load factor and the incremental load factor.

    The column ``of`` is the name of the load factor. ``own`` is the name of the method's own load factor,
    such as "lowest found". The rows of the incremental load factor are omitted if it is unknown, or if it
    equals the own load factor in all rows.
    """
    key, *names = (name for name in map(str, frame) if not name.startswith(INCREMENTAL_COLUMN))
    lowest, incremental = (
        frame[[key, *(prefix + name for name in names)]] for prefix in ("", INCREMENTAL_COLUMN)
    )
    parts = [lowest.assign(of=own)]
    incremental = incremental.set_axis([key, *names], axis=1)
    if not lowest.equals(incremental):
        parts.append(incremental.assign(of="incremental"))
    return pd.concat(parts, ignore_index=True).dropna(subset=names[:1])


def fragility(title: str, curve: pd.DataFrame, sure: str, own: str) -> NamedChart:
    """Return the chart of the probability of collapse against the load, with its confidence band.

    Parameters
    ----------
    title: End of the chart's title.
    curve: Table of :meth:`~.sample.Sample.fragility`.
    sure: Confidence of the band, as text.
    own: Name of the method's own load factor, such as "lowest found".
    """
    share, curve = axis("probability of collapse", 0, 1.02), _by_load(curve, own)
    along = alt.Chart(curve).encode(
        x=alt.X("load:Q", **axis(_LABEL, *curve["load"].agg(["min", "max"]))),
        color=alt.Color("of:N", scale=_COLOURS),
        tooltip=["of:N", *(alt.Tooltip(f"{name}:Q", format=".4f") for name in curve if name != "of")],
    )
    band = along.mark_area(opacity=0.25, interpolate="step-after")
    line = along.mark_line(strokeWidth=2, interpolate="step-after")
    chart = band.encode(y=alt.Y("lower:Q", **share), y2="upper:Q")
    chart += line.encode(strokeDash=alt.StrokeDash("of:N", legend=None), y=alt.Y("probability:Q", **share))
    return NamedChart("fragility", f"Fragility, {title}", chart, f"line: share of runs; band: {sure}")


def sensitivity(title: str, correlations: pd.DataFrame, sure: str, own: str) -> NamedChart:
    """Return the chart of rank correlations between λ and the random parameters, strongest on top.

    Parameters
    ----------
    title: End of the chart's title.
    correlations: Table of :meth:`~.sample.Sample.sensitivity`.
    sure: Confidence of the intervals, as text.
    own: Name of the method's own load factor, such as "lowest found".
    """
    known = correlations.dropna(thresh=4)
    shown = _by_load(known.head(_MOST_CORRELATIONS), own)
    # Correlations whose confidence interval contains zero have hollow marks.
    shown = shown.assign(certain=(shown["lower"] > 0) | (shown["upper"] < 0))
    x, colours = axis("rank correlation with λ", -1.05, 1.05), {"scale": _COLOURS} | legend(len(shown))
    rows = alt.Chart(shown).encode(
        y=alt.Y("parameter:N", sort=None, title=None, axis=alt.Axis(labelLimit=190)),
        yOffset=alt.YOffset("of:N", sort=[own, "incremental"]),
        stroke=alt.Stroke("of:N", **colours),
        tooltip=["parameter:N", "of:N", *(f"{name}:Q" for name in ("rank_correlation", "lower", "upper"))],
    )
    marks = rows.mark_point(size=60, opacity=1).encode(
        x=alt.X("rank_correlation:Q", **x),
        shape=alt.Shape("of:N", legend=None),
        fill=alt.when("datum.certain").then(alt.Fill("of:N", **colours)).otherwise(alt.value("white")),
    )
    limits = rows.mark_rule(strokeWidth=1.5).encode(x=alt.X("lower:Q", **x), x2="upper:Q")
    left_out = f", the first {_MOST_CORRELATIONS} of {len(known)}" if len(known) > _MOST_CORRELATIONS else ""
    if known.empty:
        left_out = ": no parameter has an influence"
    chart = (limits + marks).properties(height=28 * max(len(known.head(_MOST_CORRELATIONS)), 2))
    notes = (
        f"the horizontal lines are confidence intervals; with at least {sure}, all intervals of a load "
        "factor contain the true correlations; a hollow mark means that the correlation may be zero"
    )
    return NamedChart("sensitivity", f"Sensitivity, {title}{left_out}", chart, notes)
