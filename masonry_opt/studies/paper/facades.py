"""Figs 14 to 16 of the paper: façades, their mechanisms, and how time grows with the linear program."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from masonry_opt.analysis import solve
from masonry_opt.answer.result import Result
from masonry_opt.studies.cases import open_case
from masonry_opt.studies.palette import COLOURS
from masonry_opt.studies.paper.example import (
    ProgressLine,
    PublishedValue,
    Report,
    against_reference,
    load_factor_text,
    or_nan,
    reference_number,
)
from masonry_opt.studies.paper.sheet import mechanism_sheet

#: Openings across × upwards of Fig. 16.
SIZES = ("1x3", "2x6", "3x9", "4x12")

#: Associative solves of each, the quickest counting: they are short enough for other work to disturb.
_REPEATS = 3

#: Those that the paper's own loop is run on: larger ones take it minutes.
_PAPER_LOOP = ("1x3", "2x6")

#: Section 5.3 relaxes the convergence tolerance for the façades; sub-problems end the loop, nothing else.
_AS_PUBLISHED: dict[str, Any] = {"preset": "paper", "tol": 2e-5}

#: Sub-problems that the paper's problems took: section 5.3.
_SUB_PROBLEMS = (10, 100)

#: Ratios of load factors, which depend little on the pattern: the published two differ by 0.3 %.
_NEARLY = 1e-2

_PATTERN = "the pattern round an opening is ours: the paper's is lost with its figures"
_SOURCE = "section 5.3 and Fig. 16"

_ASSOCIATIVE, _LOOP = "associative", "Coulomb, rough sub-problems"
_PUBLISHED_LOOP = "Coulomb, the paper's own loop"


@dataclass(frozen=True)
class _Run:
    """A façade solved in one way."""

    size: str
    answer: str
    reference: str
    result: Result

    @property
    def seconds(self) -> float:
        """The solver's own: the paper's times are those of the linear programs alone."""
        return _solver_seconds(self.result)


def _solver_seconds(result: Result) -> float:
    return result.seconds["solve"]


def facade_file(size: str) -> str:
    """Case file of a façade, by its openings."""
    return f"gilbert/facade_{size}.toml"


def facades(cases: Path, progress: ProgressLine = lambda _: None) -> Report:
    """Load factors, mechanisms and times of four façades, associative and Coulomb."""
    runs: list[_Run] = []
    for size in SIZES:
        scene = open_case(cases, facade_file(size))
        progress(f"{size}: associative")
        quickest = min((solve(scene, "static") for _ in range(_REPEATS)), key=_solver_seconds)
        runs.append(_Run(size, _ASSOCIATIVE, "associative", quickest))
        progress(f"{size}: loop")
        runs.append(_Run(size, _LOOP, "nonassociative", solve(scene, "nonassociative", sub_problems="rough")))
        if size in _PAPER_LOOP:
            progress(f"{size}: the paper's own loop")
            published = solve(scene, "nonassociative", **_AS_PUBLISHED)
            runs.append(_Run(size, _PUBLISHED_LOOP, "nonassociative", published))
    slopes = {answer: _slope(*_points(runs, answer)) for answer in (_ASSOCIATIVE, _LOOP)}
    published_slopes = {answer: _slope(*_published_points(runs, answer)) for answer in slopes}
    report = Report(
        published_values=_published_values(runs, slopes, published_slopes),
        tables={
            "fig16_runs": pd.DataFrame([_row(run) for run in runs]),
            "fig16_slopes": _slope_table(slopes, published_slopes),
        },
        captions={
            "fig14": "Fig. 14: mechanism of the façade with 2 × 6 openings at the loop's end; blocks: 3 × 1",
            "fig15": "Fig. 15: mechanism of the façade with 4 × 12 openings at the loop's end",
            "fig16": "Fig. 16: time of the linear programs against their size. The paper gives no numbers of "
            "variables in words: its times are drawn at ours for the same openings, to compare slopes",
            "fig16_runs": "Fig. 16: façades as solved; 'time (s)' is the solvers' alone, as published "
            f"(associative: the quickest of {_REPEATS})",
            "fig16_slopes": "Fig. 16: exponent a of time ~ variablesᵃ, fitted to four façades (the paper's "
            "to its two published times, at our numbers of variables)",
        },
    )
    report.figures = {
        "fig14": _mechanism(runs, "2x6"),
        "fig15": _mechanism(runs, "4x12"),
        "fig16": _chart(runs, slopes, published_slopes),
    }
    report.remarks = [
        "The paper's own loop is not run on 3 × 9 and 4 × 12 openings, where it takes minutes: the loop's "
        "default for large scenes solves sub-problems roughly and ends with an exact state.",
        f"Associative time grows with the variables to the power {slopes[_ASSOCIATIVE]:.2f}, the paper's to "
        f"{published_slopes[_ASSOCIATIVE]:.2f}. The loop's to {slopes[_LOOP]:.2f}, the paper's "
        f"to {published_slopes[_LOOP]:.2f}: its exponent hangs on the numbers of sub-problems (ours: "
        f"{_counts(runs)}), and the paper's are not in its text.",
    ]
    report.differences += [
        f"{_name(run)}: {run.result.status} ({run.result.message})."
        for run in runs
        if not run.result.status.usable
    ]
    report.differences.append(
        "Matching: blocks, friction, loads, numbers of openings, the block left away. Not matching: the "
        "pattern round an opening, and so the numbers of blocks and variables, the machine (the paper's: "
        "1.4 GHz, of 2005) and the solver."
    )
    return report


def _published_values(
    runs: list[_Run], slopes: dict[str, float], published_slopes: dict[str, float]
) -> list[PublishedValue]:
    found: list[PublishedValue] = []
    for size in ("2x6", "4x12"):
        associative, loop = (_find(runs, size, answer) for answer in (_ASSOCIATIVE, _LOOP))
        for run in (associative, loop):
            scene = run.result.assembly.scene
            found.append(against_reference(scene, run.reference, run.result, _words(size), _PATTERN))
        low, high = found[-1], found[-2]
        ratio = None
        if low.computed is not None and high.computed is not None:
            ratio = low.computed / high.computed
        published = reference_number(scene, "nonassociative") / reference_number(scene, "associative")
        found.append(
            PublishedValue(
                f"{_words(size)}: Coulomb over associative",
                published,
                ratio,
                "section 5.3",
                tolerance=_NEARLY,
                cause=_PATTERN,
            )
        )
    for run in runs:
        if run.answer != _ASSOCIATIVE:
            as_published = run.answer == _PUBLISHED_LOOP
            found.append(
                PublishedValue(
                    f"{_name(run)}: sub-problems",
                    _SUB_PROBLEMS,
                    len(run.result.history),
                    "section 5.3",
                    tolerance=0.0 if as_published else None,
                    cause="" if as_published else "rough sub-problems are meant to be fewer",
                )
            )
    for answer, slope in slopes.items():
        found.append(
            PublishedValue(
                f"{answer}: exponent of time over variables",
                published_slopes[answer],
                slope,
                _SOURCE,
                cause="two published times, at our numbers of variables, of another solver and machine",
            )
        )
    return found


def _find(runs: list[_Run], size: str, answer: str) -> _Run:
    return next(run for run in runs if (run.size, run.answer) == (size, answer))


def _counts(runs: list[_Run]) -> str:
    chosen = [run for run in runs if run.answer == _LOOP]
    return ", ".join(f"{len(run.result.history)} on {_words(run.size)}" for run in chosen)


def _words(size: str) -> str:
    return size.replace("x", " × ")


def _name(run: _Run) -> str:
    return f"{_words(run.size)}, {run.answer}"


def _row(run: _Run) -> dict[str, object]:
    result, scene = run.result, run.result.assembly.scene
    known = run.answer != _PUBLISHED_LOOP
    return {
        "openings": _words(run.size),
        "answer": run.answer,
        "blocks": result.size.blocks,
        "joints": result.size.joints,
        "LP variables": result.size.columns,
        "published λ": reference_number(scene, run.reference),
        "λ": or_nan(result.load_factor),
        "sub-problems": len(result.history) or 1,
        "time (s)": run.seconds,
        "in all (s)": sum(result.seconds.values()),
        "published (s)": reference_number(scene, f"{run.reference}_seconds") if known else float("nan"),
        "status": str(result.status),
    }


def _points(runs: list[_Run], answer: str) -> tuple[np.ndarray, np.ndarray]:
    """Variables and seconds of the runs of one kind."""
    chosen = [run for run in runs if run.answer == answer]
    return np.array([run.result.size.columns for run in chosen]), np.array([run.seconds for run in chosen])


def _published_points(runs: list[_Run], answer: str) -> tuple[np.ndarray, np.ndarray]:
    """The paper's seconds, at our numbers of variables."""
    points = []
    for run in runs:
        reference = run.result.assembly.scene.reference.get(f"{run.reference}_seconds")
        if run.answer == answer and reference is not None:
            points.append((run.result.size.columns, reference.value))
    variables, seconds = np.array(points).T
    return variables, seconds


def _slope(variables: np.ndarray, seconds: np.ndarray) -> float:
    return float(np.polyfit(np.log(variables), np.log(seconds), 1)[0])


def _slope_table(slopes: dict[str, float], published: dict[str, float]) -> pd.DataFrame:
    return pd.DataFrame(
        [
            {"answer": answer, "exponent": slope, "published exponent": published[answer]}
            for answer, slope in slopes.items()
        ]
    )


def _mechanism(runs: list[_Run], size: str) -> Figure:
    run = _find(runs, size, _LOOP)
    result = run.result
    title = f"{_words(size)} openings, {result.size.blocks} blocks: {load_factor_text(result)}"
    return mechanism_sheet([(title, result)], columns=1)


def _chart(runs: list[_Run], slopes: dict[str, float], published_slopes: dict[str, float]) -> Figure:
    figure = Figure(figsize=(7.5, 5.5), layout="constrained")
    axes = figure.subplots()
    for answer, colour in ((_ASSOCIATIVE, COLOURS[0]), (_LOOP, COLOURS[1])):
        variables, seconds = _points(runs, answer)
        axes.plot(
            variables, seconds, "o", color=colour, label=f"{answer}: ours, exponent {slopes[answer]:.2f}"
        )
        _line(axes, variables, seconds, colour, "-")
        variables, seconds = _published_points(runs, answer)
        label = f"{answer}: the paper's, exponent {published_slopes[answer]:.2f}"
        axes.plot(variables, seconds, "^", color=colour, markerfacecolor="white", label=label)
        _line(axes, variables, seconds, colour, "--")
    variables, seconds = _points(runs, _PUBLISHED_LOOP)
    axes.plot(variables, seconds, "X", color=COLOURS[2], label=f"{_PUBLISHED_LOOP}, here")
    variables, seconds = _points(runs, _ASSOCIATIVE)
    for size, x, y in zip(SIZES, variables, seconds, strict=True):
        axes.annotate(
            _words(size), (x, y), xytext=(0, -14), textcoords="offset points", ha="center", fontsize=9
        )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(0.5 * seconds.min(), None)
    axes.set_xlabel("number of LP variables")
    axes.set_ylabel("time of the linear programs (s)")
    axes.grid(color="#EEEEEE", which="both")
    axes.legend(fontsize=8, loc="upper left")
    return figure


def _line(axes: Axes, variables: np.ndarray, seconds: np.ndarray, colour: str, style: str) -> None:
    """The power law fitted to points, over their range."""
    exponent, constant = np.polyfit(np.log(variables), np.log(seconds), 1)
    ends = np.array([variables.min(), variables.max()])
    axes.plot(ends, np.exp(constant) * ends**exponent, style, color=colour, linewidth=1)
