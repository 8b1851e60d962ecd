"""Fig. 11 of the paper: how starting conditions, α and β change the loop's way on wall 6."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from masonry_opt.analysis import solve
from masonry_opt.answer.result import Result
from masonry_opt.answer.status import Status
from masonry_opt.studies.cases import open_case
from masonry_opt.studies.palette import COLOURS
from masonry_opt.studies.paper.example import ProgressLine, PublishedValue, Report
from masonry_opt.studies.paper.table1 import wall_file

#: Section 5.3 calls every answer "equal or very close" to 0.29649: within one in a thousand.
_VERY_CLOSE = 1e-3

#: Sub-problems that β = 0.2 took the paper.
_PUBLISHED_SLOW = 85

_SOURCE = "section 5.3 and Fig. 11"

_STYLES = ("-", "--", "-.", "-", "--")

#: Sub-problems that the panels show; all but the slowest run end before.
_SHOWN = 40


@dataclass(frozen=True)
class Variation:
    """One way of running the loop.

    Attributes
    ----------
    panel: of the figure.
    label: what differs from the paper's settings.
    options: the options that do.
    tolerance: within which the answer must be the published one; None if nothing is demanded.
    cause: why it may differ.
    """

    panel: str
    label: str
    options: dict[str, Any] = field(default_factory=dict)
    tolerance: float | None = _VERY_CLOSE
    cause: str = ""


def _cohesive(trial: float) -> Variation:
    options = {"start": "cohesive", "trial_cohesion": trial}
    return Variation("start", f"cohesive, trial cohesion {trial:g}", options)


def _alpha(alpha: float) -> Variation:
    return Variation("alpha", f"α = {alpha:g}", {"alpha": alpha})


PANELS = {
    "start": "(a) starting conditions (trial cohesion in block weights)",
    "alpha": "(b) α, slope of the contracting shear limit over μ",
    "beta": "(c) β, weight of the newest normal forces",
}

#: The run that takes many sub-problems, and the one that does not converge.
SLOW = Variation("beta", "β = 0.2", {"beta": 0.2})
CYCLES = Variation("beta", "β = 1", {"beta": 1.0}, tolerance=None)

VARIATIONS = (
    Variation("start", "associative"),
    _cohesive(0.5),
    _cohesive(1.0),
    _cohesive(5.0),
    Variation(
        "alpha",
        "α = 0 throughout",
        {"alpha": 0.0, "alpha_min": 0.0},
        tolerance=None,
        cause="without contraction nothing draws the normal forces to their least",
    ),
    _alpha(0.0),
    _alpha(0.1),
    _alpha(0.3),
    _alpha(0.6),
    SLOW,
    Variation("beta", "β = 0.4", {"beta": 0.4}),
    Variation("beta", "β = 0.6"),
    Variation("beta", "β = 0.8", {"beta": 0.8}),
    CYCLES,
)


def fig11(cases: Path, progress: ProgressLine = lambda _: None) -> Report:
    """Load factor against sub-problems for several starts, α and β, wall 6."""
    scene = open_case(cases, wall_file(6))
    published = scene.reference["nonassociative"].value
    report = Report(
        captions={
            "fig11": "Fig. 11: load factor of each sub-problem of the loop, wall 6; dotted: published, "
            "0.29649; a dot where a run converged, a cross where it did not. α = 0 throughout: α_min = 0 too",
            "fig11_outcomes": "Fig. 11: how each run ended (the paper: converged for all but β = 1)",
            "fig11_iterations": "Fig. 11: load factor of each sub-problem",
        }
    )
    runs: list[tuple[Variation, Result]] = []
    rows = []
    for variation in VARIATIONS:
        progress(variation.label)
        start = time.perf_counter()
        result = solve(scene, "nonassociative", preset="paper", **variation.options)
        seconds = time.perf_counter() - start
        runs.append((variation, result))
        answer = PublishedValue(
            variation.label, published, result.load_factor, _SOURCE, variation.tolerance, variation.cause
        )
        if variation is not CYCLES:
            report.published_values.append(answer)
        rows.append(
            {
                "panel": PANELS[variation.panel][:3],
                "run": variation.label,
                "status": str(result.status),
                "λ": result.load_factor,
                "diff %": 100 * answer.relative_difference,
                "sub-problems": len(last_run(result)),
                "LPs": result.lp_solves,
                "time (s)": seconds,
                "how it ended": result.message,
            }
        )
        if variation is SLOW:
            report.published_values.append(
                PublishedValue(
                    f"{variation.label}: sub-problems",
                    _PUBLISHED_SLOW,
                    len(last_run(result)),
                    "section 5.3",
                    cause="the last digits of λ swing for long, and which state a solver returns decides "
                    "when two of them agree",
                )
            )
        if variation is CYCLES:
            cycling = result.status is Status.CYCLING
            sentence = f"{variation.label}: {result.status} ({result.message})"
            (report.remarks if cycling else report.differences).append(f"{sentence}; the paper: cycling.")
    if began_again := [run.label for run, result in runs if len(last_run(result)) < len(result.history)]:
        report.differences.append(
            f"{'; '.join(began_again)}: a sub-problem had no state of equilibrium, and the loop began again "
            "with a smaller α. The paper tells of none. A contracting shear limit also caps the normal "
            "force, and how low depends on the state that the solver returned before."
        )
    report.tables = {
        "fig11_outcomes": pd.DataFrame(rows),
        "fig11_iterations": pd.concat(
            [
                last_run(result)[["iteration", "load_factor", "alpha"]].assign(run=variation.label)
                for variation, result in runs
            ]
        ),
    }
    report.figures["fig11"] = _draw(runs, published)
    return report


def _draw(runs: list[tuple[Variation, Result]], published: float) -> Figure:
    figure = Figure(figsize=(8.0, 10.5), layout="constrained")
    *panels, ends = figure.subplots(len(PANELS) + 1, 1)
    for axes, (panel, title) in zip(panels, PANELS.items(), strict=True):
        shown = [(variation, result) for variation, result in runs if variation.panel == panel]
        for (variation, result), colour, style in zip(shown, COLOURS, _STYLES, strict=False):
            _draw_run(axes, variation, result, colour, style)
        axes.set_title(title, loc="left", fontsize=10)
        axes.set_xlim(0, _SHOWN)
        # A trial cohesion can be so small that the first load factor is near zero.
        axes.set_ylim(0.0 if panel == "start" else 0.2, 0.43)
        axes.legend(fontsize=8, ncols=2, loc="lower right")
    for variation, result in runs:
        if variation is SLOW or variation is CYCLES:
            _draw_run(ends, variation, result, COLOURS[0 if variation is SLOW else 1], "-")
    ends.set_title("(d) the same, β = 0.2 and β = 1, λ magnified", loc="left", fontsize=10)
    ends.set_ylim(0.286, 0.312)
    ends.set_xlim(0, None)
    ends.legend(fontsize=8, loc="upper right")
    for axes in (*panels, ends):
        axes.axhline(published, color="black", linewidth=1, linestyle=":", zorder=0)
        axes.set_ylabel("load factor λ")
        axes.grid(color="#EEEEEE")
    ends.set_xlabel("sub-problem")
    return figure


def _draw_run(axes: Axes, variation: Variation, result: Result, colour: str, style: str) -> None:
    history = last_run(result)
    k, load_factor = history["iteration"], history["load_factor"]
    outcome = f"{len(k)} sub-problems" if result.status.usable else str(result.status)
    label = f"{variation.label}: {outcome}"
    axes.plot(k, load_factor, style, color=colour, linewidth=1.4, label=label)
    end = "o" if result.status.usable else "X"
    axes.plot(k.iloc[-1], load_factor.iloc[-1], end, color=colour, markersize=7, markeredgecolor="white")


def last_run(result: Result) -> pd.DataFrame:
    """The history of a loop's last run: what came before it failed and was begun again."""
    history = result.history
    return history[history["attempt"] == history["attempt"].max()]
