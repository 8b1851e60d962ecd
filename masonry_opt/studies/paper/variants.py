"""Section 6.4 of the paper: move limits on normal forces, and turning only the limits of joints at yield."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from masonry_opt.analysis import solve
from masonry_opt.answer.result import Result
from masonry_opt.methods.loop.steps import Revise, Turn
from masonry_opt.problem.problem import ShearLimits
from masonry_opt.studies.cases import open_case
from masonry_opt.studies.palette import COLOURS
from masonry_opt.studies.paper.example import ProgressLine, Report, against_reference, or_nan
from masonry_opt.studies.paper.facades import facade_file
from masonry_opt.studies.paper.table1 import WALLS, wall_file

#: Relative rise of λ that counts as higher: larger than the loop's tolerance at its end.
_HIGHER = 1e-3


#: Share of its limit from which on a joint counts as about to slide.
_ABOUT_TO_SLIDE = 1 - 1e-3


class MoveLimit:
    """Bounds the change of the normal forces about which the shear limits turn.

    Parameters
    ----------
    share: largest change, as a share of the force and the mean one.
    """

    def __init__(self, share: float) -> None:
        self.share = share
        self._about: np.ndarray | None = None

    def __call__(self, turn: Turn) -> ShearLimits:
        """The next shear limits; the series of forces begins anew with every run of the loop."""
        about, before = turn.about, self._about
        if before is not None and turn.last.number > 1:
            most = self.share * (np.abs(before) + np.abs(before).mean())
            about = np.clip(about, before - most, before + most)
        self._about = about
        return replace(turn, about=about).limits()


def only_at_yield(turn: Turn) -> ShearLimits:
    """The next shear limits, those of joints that neither slide nor are about to left as they were."""
    state, before, problem = turn.last.state, turn.last.limits, turn.problem
    assert state is not None  # the sub-problem was solved
    following = turn.limits()
    n, s, _ = state.q.reshape(3, -1)[:, problem.sliding]
    keeps = np.abs(s) < _ABOUT_TO_SLIDE * before.at(n)
    return ShearLimits(
        np.where(keeps, before.slope, following.slope), np.where(keeps, before.cohesion, following.cohesion)
    )


@dataclass(frozen=True)
class Variation:
    """A modification of the loop: another way to turn the shear limits."""

    label: str
    revise: Revise


BASE = Variation("as published", Turn.limits)

VARIATIONS = (
    Variation("move limit 0.1", MoveLimit(0.1)),
    Variation("move limit 0.3", MoveLimit(0.3)),
    Variation("move limit 1", MoveLimit(1.0)),
    Variation("only at yield", only_at_yield),
)


def variants(cases: Path, progress: ProgressLine = lambda _: None) -> Report:
    """The six walls and the smallest façade with and without what section 6.4 tried."""
    files = {f"wall {number}": wall_file(number) for number in WALLS}
    files["façade 1 × 3"] = facade_file("1x3")
    report = Report(
        captions={
            "variants": "Section 6.4: sub-problems and load factor of each variant, beside the loop as "
            "published. A cross: no load factor",
            "variants_runs": "Section 6.4: the runs. A move limit bounds the change of the normal forces "
            "about which the shear limits turn, as a share of the force and the mean one",
            "variants_summary": "Section 6.4: what each variant changed, over all scenes",
        }
    )
    rows = []
    for name, file in files.items():
        scene = open_case(cases, file)
        progress(f"{name}: {BASE.label}")
        base = solve(scene, "nonassociative", preset="paper")
        if "nonassociative" in scene.reference:
            report.published_values.append(against_reference(scene, "nonassociative", base, name))
        rows.append(_row(name, BASE, base, base))
        for variation in VARIATIONS:
            progress(f"{name}: {variation.label}")
            result = solve(scene, "nonassociative", preset="paper", revise=variation.revise)
            rows.append(_row(name, variation, result, base))
    table = pd.DataFrame(rows)
    summary = pd.DataFrame([_summary(variation, table) for variation in VARIATIONS])
    report.tables = {"variants_runs": table, "variants_summary": summary}
    report.remarks = [
        _limits_verdict(summary[summary["variant"].str.startswith("move limit")]),
        _yield_verdict(summary[summary["variant"] == "only at yield"].iloc[0]),
    ]
    report.figures["variants"] = _draw(table, list(files))
    return report


def _row(name: str, variation: Variation, result: Result, base: Result) -> dict[str, object]:
    return {
        "scene": name,
        "variant": variation.label,
        "λ": or_nan(result.load_factor),
        "against published loop (%)": 100 * (or_nan(result.load_factor) / or_nan(base.load_factor) - 1),
        "sub-problems": len(result.history),
        "runs of the loop": int(result.history["attempt"].max()),
        "status": str(result.status),
        "time (s)": sum(result.seconds.values()),
    }


def _summary(variation: Variation, table: pd.DataFrame) -> dict[str, object]:
    mine = table[table["variant"] == variation.label].set_index("scene")
    base = table[table["variant"] == BASE.label].set_index("scene")
    rise = mine["against published loop (%)"]
    fewer = mine["sub-problems"] < base["sub-problems"]
    higher = rise[rise > 100 * _HIGHER]
    return {
        "variant": variation.label,
        "sub-problems": int(mine["sub-problems"].sum()),
        "as published": int(base["sub-problems"].sum()),
        "fewer on": f"{int(fewer.sum())} of {len(mine)}",
        "λ higher on": ", ".join(higher.index) or "none",
        "highest rise (%)": float(max(rise.max(), 0.0)),
        "without λ": ", ".join(mine.index[mine["λ"].isna()]) or "none",
    }


def _limits_verdict(summary: pd.DataFrame) -> str:
    """What the paper found of move limits, beside ours."""
    records = summary.to_dict("records")
    gain = any(row["sub-problems"] < row["as published"] for row in records)
    counts = ", ".join(f"{row['sub-problems']} ({row['variant']})" for row in records)
    worse = [row for row in records if row["λ higher on"] != "none" or row["without λ"] != "none"]
    risks = "; ".join(
        f"{row['variant']}: λ higher on {row['λ higher on']}, by up to {row['highest rise (%)']:.2g} %, "
        f"without λ: {row['without λ']}"
        for row in worse
    )
    return (
        f"Move limits, 'the required computational effort was not reduced': "
        f"{'refuted' if gain else 'confirmed'} ({records[0]['as published']} sub-problems as published; "
        f"{counts}). 'The risk of converging to an artificially high load factor appeared to be increased': "
        f"{f'confirmed ({risks})' if worse else f'not confirmed (none rose by {100 * _HIGHER:g} % or more)'}."
    )


def _yield_verdict(row: pd.Series) -> str:
    """What the paper found of turning only the limits of joints at yield, beside ours."""
    change = row["sub-problems"] / row["as published"] - 1
    little = abs(change) < 0.2 and row["λ higher on"] == "none" and row["without λ"] == "none"
    return (
        "Only joints at yield, 'very little difference to the convergence characteristics': "
        f"{'confirmed' if little else 'refuted'} ({row['sub-problems']} sub-problems against "
        f"{row['as published']}; λ higher on: {row['λ higher on']}; without λ: {row['without λ']})."
    )


def _draw(table: pd.DataFrame, scenes: list[str]) -> Figure:
    figure = Figure(figsize=(8.0, 7.0), layout="constrained")
    count, rise = figure.subplots(2, 1, sharex=True)
    labels = [BASE.label, *(variation.label for variation in VARIATIONS)]
    width = 0.8 / len(labels)
    for number, (label, colour) in enumerate(zip(labels, (COLOURS[6], *COLOURS), strict=False)):
        runs = table[table["variant"] == label].set_index("scene").loc[scenes]
        at = [place + (number - (len(labels) - 1) / 2) * width for place in range(len(scenes))]
        count.bar(at, runs["sub-problems"], width=0.9 * width, color=colour, label=label)
        if label != BASE.label:
            rise.plot(at, runs["against published loop (%)"], "o", color=colour, markersize=6)
        failed = [x for x, load_factor in zip(at, runs["λ"], strict=True) if load_factor != load_factor]
        rise.plot(failed, [0.0] * len(failed), "X", color=colour, markersize=10)
    count.set_ylabel("sub-problems")
    count.legend(fontsize=8, ncols=3)
    rise.axhline(0.0, color="black", linewidth=1, zorder=0)
    rise.set_ylabel("λ against the loop as published (%)")
    rise.set_xticks(range(len(scenes)), scenes)
    for axes in (count, rise):
        axes.grid(color="#EEEEEE", axis="y")
        axes.set_axisbelow(True)
    return figure
