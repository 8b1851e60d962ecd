"""Fig. 12 of the paper: where the energy of the live load goes at each iteration, wall 6."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from masonry_opt.analysis import solve
from masonry_opt.studies.cases import open_case
from masonry_opt.studies.palette import COLOURS
from masonry_opt.studies.paper.example import ProgressLine, PublishedValue, Report, against_reference
from masonry_opt.studies.paper.table1 import wall_file

_SOURCE = "section 5.3"

#: Share of sliding at the end, in per cent; over its last eight iterations ours swings by as much.
_PUBLISHED, _NEARLY = 18.2, 0.01

#: Per cent of the total energy by which actual and corrected sliding energy differ at most.
_ALWAYS_BELOW = 0.1


def fig12(cases: Path, progress: ProgressLine = lambda _: None) -> Report:
    """Shares of sliding friction and of raised weight at each iteration of wall 6."""
    scene = open_case(cases, wall_file(6))
    progress("wall 6: loop")
    result = solve(scene, "nonassociative", preset="paper")
    table = energies(result.history)
    last = table.iloc[-1]
    actual, corrected = 100 * last["share of sliding"], 100 * last["share, corrected"]
    # What step 6 takes off λ is friction in neither law.
    small = 0.0 if result.load_factor is None else 100 * (1 - result.load_factor / last["λ"])
    report = Report(
        published_values=[against_reference(scene, "nonassociative", result, "wall 6")],
        tables={"fig12": table},
        captions={
            "fig12": "Fig. 12: energy at each iteration of the loop, wall 6. Below, the share of sliding: as "
            "the sub-problem has it, and corrected to Coulomb's law for the same slips and normal forces",
        },
    )
    for kind, value in (("actual", actual), ("corrected", corrected)):
        what = f"energy in sliding at the end, {kind} (%)"
        report.published_values.append(PublishedValue(what, _PUBLISHED, value, _SOURCE, tolerance=_NEARLY))
    off = abs(actual - corrected)
    cause = f"{small:.3f} % is the small cohesion, which step 6 takes off λ" if off > _ALWAYS_BELOW else ""
    check = "actual against corrected energy of sliding (% of the total)"
    report.published_values += [
        PublishedValue(
            check,
            (0.0, _ALWAYS_BELOW),
            off,
            f"{_SOURCE}: always < 0.1 %",
            cause=cause,
        ),
        PublishedValue(
            f"{check}, without the small cohesion of step 6",
            (0.0, _ALWAYS_BELOW),
            abs(actual - small - corrected),
            f"{_SOURCE}: always < 0.1 %",
            tolerance=0.0,
        ),
    ]
    report.figures["fig12"] = _draw(table)
    return report


def energies(history: pd.DataFrame) -> pd.DataFrame:
    """The parts of the energy at each iteration, in units of λ and as shares.

    Actual sliding energy: slips against the sub-problem's own shear limits; corrected: against Coulomb's.
    """
    total = history["load_factor"]
    return pd.DataFrame(
        {
            "iteration": history["iteration"],
            "λ": total,
            "raised weight": history["raising"],
            "sliding": history["sliding"],
            "corrected": history["coulomb_sliding"],
            "share of sliding": history["sliding"] / total,
            "share, corrected": history["coulomb_sliding"] / total,
            "time (s)": history["seconds"],
        }
    )


def _draw(table: pd.DataFrame) -> Figure:
    figure = Figure(figsize=(7.5, 6.5), layout="constrained")
    total, share = figure.subplots(2, 1, sharex=True, height_ratios=[1.5, 1])
    k = table["iteration"]
    total.bar(k, table["raised weight"], color=COLOURS[5], label="increase in potential energy")
    total.bar(
        k,
        table["sliding"],
        bottom=table["raised weight"],
        color=COLOURS[1],
        hatch="//",
        edgecolor="white",
        label="sliding friction",
    )
    total.set_ylabel("total energy (load factor λ)")
    total.set_ylim(0, 0.5)
    total.legend(loc="upper right", frameon=False, ncols=2)
    share.plot(
        k,
        100 * table["share of sliding"],
        "o-",
        color=COLOURS[1],
        label="actual: the sub-problem's own shear limit",
    )
    share.plot(
        k, 100 * table["share, corrected"], "x--", color=COLOURS[6], label="corrected: Coulomb's shear limit"
    )
    share.axhline(_PUBLISHED, color="#777777", linewidth=1, linestyle=":")
    share.annotate(
        f"published: {_PUBLISHED} % at the end",
        (k.iloc[-1], _PUBLISHED),
        xytext=(0, 6),
        textcoords="offset points",
        ha="right",
    )
    share.set_ylabel("energy in sliding (%)")
    share.set_xlabel("iteration")
    share.set_xticks(k)
    share.legend(fontsize=8)
    return figure
