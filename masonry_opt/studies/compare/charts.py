"""The charts of a comparison, described once: what is drawn, whatever draws it. From the frames alone."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.errors import counted
from masonry_opt.methods.registry import METHODS
from masonry_opt.studies.compare import frames
from masonry_opt.studies.compare.judge import (
    CERTIFIED,
    FAILED,
    GAP_FLOOR,
    NAMED,
    TARGET,
    VIOLATION_FLOOR,
    WRONG,
    VerdictReason,
)
from masonry_opt.studies.compare.known_answers import ASSOCIATIVE, COULOMB
from masonry_opt.studies.compare.text import number, reason_text
from masonry_opt.studies.palette import COLOURS

GREY = "#777777"

#: Letters in a line of what a mark says.
_HOVER = 44

#: Shapes of marks, by plotly's names, of methods in the order of the registry; the last is no method's.
MARKERS = ("circle", "square", "triangle-up", "diamond", "star", "cross", "hexagon", "triangle-down")

#: Letters of runs that are not certified, and what they stand for.
_LETTERS = {
    "T": "time limit",
    "M": "memory limit",
    "W": "wrong",
    "N": "no load factor, and the right reason why",
    "F": "failed but said so",
}

#: Of a question and its error: what is no smaller in a chart, and why.
_FLOORS = {
    (COULOMB, "error"): (GAP_FLOOR, f"gaps below {GAP_FLOOR:g} are none, drawn there"),
    (COULOMB, "violation"): (
        VIOLATION_FLOOR,
        f"violations below {VIOLATION_FLOOR:g} are rounding, drawn there",
    ),
}

_VERDICT_COLOURS = {CERTIFIED: COLOURS[2], NAMED: COLOURS[5], FAILED: "#BBBBBB", WRONG: COLOURS[1]}

#: Steps between the ticks of a logarithmic axis, and of a short one, for which a telephone has room.
_STEPS, _FEW = 7, 2

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Axis:
    """An axis: its ends, and the text of each tick."""

    label: str
    limits: tuple[float, float]
    ticks: Mapping[float, str]
    log: bool = True


@dataclass(frozen=True)
class Series:
    """Points of one look: marks, a line through them ("straight" or "steps"), or a letter each.

    The legend has one entry for each name. ``filled``: full marks and whole lines, else open and broken.
    ``hover``: what each point says when pointed at.
    """

    name: str
    x: Iterable[float]
    y: Iterable[float]
    colour: str
    marker: str = ""
    filled: bool = True
    line: str = ""
    letters: Iterable[str] = ()
    hover: Iterable[str] = ()


@dataclass(frozen=True)
class Chart:
    """Panels, by title, that share their axes; from ``band`` upwards stands what is not certified.

    name: of its files.
    """

    name: str
    title: str
    x: Axis
    y: Axis
    panels: Mapping[str, list[Series]]
    band: float | None = None
    notes: str = ""


@dataclass(frozen=True)
class Bars:
    """How scenes ended: a stacked bar a row, beside it a median time and its middle half (seconds).

    parts: name, colour, and the count of each row. times: 25 %, median and 75 % of each row; NaN if unknown.
    """

    name: str
    title: str
    labels: list[str]
    parts: list[tuple[str, str, list[int]]]
    times: list[tuple[float, float, float]]
    time: Axis
    notes: str


def charts(summary: pd.DataFrame) -> list[Chart | Bars]:
    """Every chart of a summary (see :func:`~.frames.summary`); none of an empty one."""
    if summary.empty:
        return []
    drawn: list[Chart | Bars] = [_success(summary)]
    for question in (ASSOCIATIVE, COULOMB):
        if not (summary["question"] == question).any():
            continue
        drawn.append(_time_error(summary, question, "error"))
        if question == COULOMB:
            drawn.append(_time_error(summary, question, "violation"))
        drawn += [_profile(summary, question), _size(summary, question)]
    return drawn


def _time_error(summary: pd.DataFrame, question: str, error: str) -> Chart:
    """Time against error, a panel a scene; what is not certified stands in a band at the top."""
    rows, looks = summary[summary["question"] == question], _looks(summary)
    certified = rows["verdict"] == CERTIFIED
    low, high = _decades(rows[certified][error])
    band = high * 10**0.3
    top = band * (band / low) ** 0.22
    # An exact zero has no place on a logarithmic axis: it stands on the least error shown. Letters at near
    # times are kept apart by three heights in turn.
    turn = (rows[~certified].groupby("scene").cumcount() % 3).reindex(rows.index)
    in_band = band * (top / band) ** (0.15 + 0.25 * turn)
    rows = rows.assign(height=rows[error].clip(low).where(certified, in_band))
    panels = {}
    for scene, frame in rows.groupby("scene", sort=False):
        series = []
        for pair, group in frame.groupby("pair", sort=False):
            series += _pair_series(str(pair), looks[str(pair)], group)
        front = frames.pareto(frame, error=error)
        below = frame[(frame["verdict"] == CERTIFIED) & frame["below"] & (error == "error")]
        series.append(Series("Pareto front", front["time"], front["height"], GREY, line="steps"))
        if len(below):
            name = "below the best exact state (|gap|)"
            series.append(Series(name, below["time"], below["height"] * 0.6, GREY, MARKERS[-1]))
        panels[str(scene)] = series
    letters = dict.fromkeys(_letter(row) for row in rows[~certified].to_dict("records"))
    notes = [f"{letter}: {_LETTERS[letter]}" for letter in letters]
    what, label = _error_words(question, error)
    ticks, floor = _powers(low, high), _FLOORS.get((question, error))
    if floor and math.isclose(low, floor[0]):
        ticks[low] = f"≤ {ticks[low]}"
        notes.append(floor[1])
    return Chart(
        f"time_{error}_{question.lower()}",
        f"{question.capitalize()} λ: time against {what}",
        _log_axis("time (s)", rows["time"]),
        Axis(label, (low / 3, top), ticks),
        panels,
        band,
        "; ".join(notes),
    )


def _pair_series(pair: str, look: dict[str, Any], rows: pd.DataFrame) -> list[Series]:
    """Certified answers of one pair on one scene, joined by tolerance, and the letters of the others."""
    known, others = rows[rows["verdict"] == CERTIFIED], rows[rows["verdict"] != CERTIFIED]
    known = known[known["height"].notna()].sort_values("tolerance")
    marks = Series(pair, known["time"], known["height"], **look, line="straight", hover=_hover(known))
    letters = [_letter(row) for row in others.to_dict("records")]
    place = others["time"], others["height"], look["colour"]
    return [marks, Series(pair, *place, letters=letters, hover=_hover(others))] if letters else [marks]


def _profile(summary: pd.DataFrame, question: str) -> Chart:
    """Performance profiles over the scenes."""
    times, looks = frames.reached(summary, question), _looks(summary)
    curves = frames.profiles(times)
    last = 2.0 * float(curves["ratio"].max() if len(curves) else 1.0)
    series = []
    for pair, curve in curves.groupby("pair", sort=False):
        x, y = [*curve["ratio"], last], [*curve["share"], curve["share"].iloc[-1]]
        series.append(Series(str(pair), x, y, **looks[str(pair)], line="steps"))
    doublings = math.ceil(math.log2(last))
    ticks = {2.0**power: f"{2**power}" for power in range(0, doublings + 1, math.ceil(doublings / 7))}
    percents = {share / 100: f"{share} %" for share in range(0, 101, 20)}
    title = f"performance profile: to {TARGET[question]:g}, {counted(times['scene'].nunique(), 'scene')}"
    return Chart(
        f"profile_{question.lower()}",
        f"{question.capitalize()} λ, {title}",
        Axis("time over the fastest pair's", (1.0, last), ticks),
        Axis("scenes reached within it", (-0.02, 1.04), percents, log=False),
        {"": series},
    )


def _size(summary: pd.DataFrame, question: str) -> Chart:
    """Time against the number of joints, with fitted exponents."""
    times, looks = frames.reached(summary, question), _looks(summary)
    fits = frames.growth(times).set_index("pair")
    solved = times[np.isfinite(times["time"])]
    series = []
    for pair, group in solved.groupby("pair", sort=False):
        look, fit = looks[str(pair)], fits.loc[str(pair)]
        known = bool(np.isfinite(fit["exponent"]))
        name = f"{pair} ∝ c^{fit['exponent']:.2f}" if known else str(pair)
        series.append(Series(name, group["joints"], group["time"], **look, hover=group["scene"]))
        if known:
            fitted = group["joints"][group["joints"] >= frames.FITTED_FROM]
            x = np.array([fitted.min(), fitted.max()])
            y = fit["factor"] * x ** fit["exponent"]
            series.append(Series(name, x, y, look["colour"], filled=look["filled"], line="straight"))
    return Chart(
        f"size_{question.lower()}",
        f"{question.capitalize()} λ: time to reach {TARGET[question]:g}, against size",
        _log_axis("joints c", solved["joints"]),
        _log_axis("time (s)", solved["time"]),
        {"": series},
    )


def _success(summary: pd.DataFrame) -> Bars:
    """How the scenes ended, a bar a pair and tolerance; beside it the time of its certified answers."""
    table = frames.success(summary)
    least, most = int(table["scenes"].min()), int(table["scenes"].max())
    # An interruption leaves some out.
    scenes = counted(most, "scene") if least == most else f"{least} to {most} scenes"
    times = table[["time 25 %", "time", "time 75 %"]]
    rungs = zip(table["pair"], table["tolerance"], strict=True)
    return Bars(
        "success",
        "How the scenes ended",
        [f"{pair}{'' if pd.isna(tolerance) else f' · {tolerance:.0e}'}" for pair, tolerance in rungs],
        [(name, colour, [*table[name]]) for name, colour in _VERDICT_COLOURS.items()],
        [*times.itertuples(index=False, name=None)],
        _log_axis("time (s)", pd.Series(times.to_numpy().ravel()), _FEW),
        f"{scenes}, counts in the bars. Time: median of the certified answers, and their middle half",
    )


def _looks(summary: pd.DataFrame) -> dict[str, dict[str, Any]]:
    """By pair: the colour of its solver, the marker of its method, filled for CVXPY."""
    solvers, methods = list(dict.fromkeys(summary["solver"])), list(METHODS)
    return {
        row["pair"]: {
            "colour": COLOURS[solvers.index(row["solver"]) % len(COLOURS)],
            "marker": MARKERS[methods.index(row["method"]) % len(MARKERS)],
            "filled": row["model"] == "cvxpy",
        }
        for row in summary.drop_duplicates("pair").to_dict("records")
    }


def _letter(row: Mapping[Any, Any]) -> str:
    """The letter of a row that is not certified."""
    if row["verdict"] != FAILED:
        return "W" if row["verdict"] == WRONG else "N"
    return {VerdictReason.TIME_LIMIT: "T", VerdictReason.MEMORY_LIMIT: "M"}.get(row["reason"], "F")


def _hover(rows: pd.DataFrame) -> list[str]:
    """What the marks of rows say when pointed at, in lines."""
    return ["\n".join(_said(row)) for row in rows.to_dict("records")]


def _said(row: Mapping[Any, Any]) -> Iterator[str]:
    yield row["scene"]
    yield f"{row['pair']}, tolerance {number(row['tolerance'])}"
    yield textwrap.fill(f"{row['verdict']} {reason_text(row)}", _HOVER)
    yield f"λ {number(row['load_factor'], 9)}"
    yield f"error {number(row['error'])}, violation {number(row['violation'])}"
    yield f"{number(row['time'], 3)} s, {row['peak_memory']:.0f} MB, iterations: {number(row['iterations'])}"


def _error_words(question: str, error: str) -> tuple[str, str]:
    """What an error is called in a title, and at its axis."""
    if error == "violation":
        return "violation of yield", "largest violation of yield (median block weights)"
    if question == COULOMB:
        return "gap to the best exact state", "relative gap to the best exact state known"
    return "error", "relative error of λ (against certified bounds)"


def _decades(values: pd.Series) -> tuple[float, float]:
    """Whole decades, one at least, that hold the positive ones among the values."""
    known = values[values > 0]
    if known.empty:
        return 1e-9, 1.0
    low, high = math.floor(math.log10(known.min())), math.ceil(math.log10(known.max()) + 1e-9)
    return 10.0**low, 10.0 ** max(high, low + 1)


def _log_axis(label: str, values: pd.Series, steps: int = _STEPS) -> Axis:
    low, high = _decades(values)
    return Axis(label, (low / 1.25, high * 1.25), _powers(low, high, steps))


def _powers(low: float, high: float, steps: int = _STEPS) -> dict[float, str]:
    """Ticks at powers of ten, so many steps at most."""
    first, last = round(math.log10(low)), round(math.log10(high))
    powers = range(first, last + 1, math.ceil((last - first) / steps))
    return {10.0**power: f"10{str(power).translate(_SUPERSCRIPTS)}" for power in powers}
