"""The failure atlas, and maps of how far the loop's parameters may be changed."""

from __future__ import annotations

import textwrap
from pathlib import Path

import pandas as pd

from masonry_opt.studies.atlas.entries import ATLAS
from masonry_opt.studies.atlas.entry import Observation, carry_out, expected_text
from masonry_opt.studies.atlas.heat_maps import heat_maps, scene_sheet
from masonry_opt.studies.atlas.maps import (
    DEMANDED,
    GRIDS,
    MOST_LEFT,
    NEAR,
    describe,
    run_grid,
    safe_region,
    with_remedies,
)
from masonry_opt.studies.paper.example import Basis, ProgressLine, PublishedValue, Report, or_nan

_MESSAGE = 90


def stability(cases: Path, progress: ProgressLine) -> Report:
    """Every run of the failure atlas against its expectation, and the loop over grids of its parameters."""
    report = Report()
    _atlas(report, cases, progress)
    report.remarks.append(
        f"Maps: safe is a λ certified to {100 * MOST_LEFT:g} % (energy and flow rule), at most "
        f"{100 * NEAR:g} % above the paper's, and no more below the lowest exact state known."
    )
    remedied: list[pd.DataFrame] = []
    for stem, grid in GRIDS.items():
        frame = run_grid(grid, cases, progress)
        report.tables[stem] = frame
        report.figures[stem] = heat_maps(grid, frame)
        report.captions[stem] = (
            f"The loop on the six walls over {grid.title}: λ as colour, sub-problems as numbers, failures "
            "as letters"
        )
        report.remarks.append(describe(safe_region(grid, frame), frame))
        again = with_remedies(grid, frame, cases, progress)
        remedied.append(again.assign(grid=grid.title, raw=frame["certified"]))
    _shares(report, pd.concat(remedied))
    return report


def _shares(report: Report, runs: pd.DataFrame) -> None:
    """How many runs of the maps end in a certified answer, without and with remedies."""
    shares = runs.groupby("grid", sort=False)[["raw", "certified"]].agg(["sum", "mean"])
    shares.columns = ["without remedies", "share without", "with remedies", "share with"]
    shares.insert(0, "runs", runs.groupby("grid", sort=False).size())
    report.tables["stability_remedies"] = shares.reset_index()
    report.captions["stability_remedies"] = "Certified answers over the grids, without and with remedies"
    certified, raw = runs["certified"], runs["raw"]
    report.remarks.append(
        f"Remedies: {int(certified.sum())} of the {len(runs)} runs end in a certified answer with them, "
        f"{int(raw.sum())} with the paper's loop and less slope alone."
    )
    report.published_values.append(
        PublishedValue(
            what="certified answers with remedies, share",
            published=(DEMANDED, 1.0),
            computed=float(certified.mean()),
            source="demanded",
            tolerance=0.0,
            basis=Basis.DEMANDED,
        )
    )
    report.differences += [
        f"wall {row['wall']}, {row['grid']}, not certified with remedies: {row['status']}"
        for row in runs[~certified].to_dict("records")
    ]


def _atlas(report: Report, cases: Path, progress: ProgressLine) -> None:
    outcomes: list[Observation] = []
    for entry in ATLAS:
        progress(f"atlas: {entry.name}")
        outcomes += [carry_out(entry, run, cases) for run in entry.runs]
    report.tables["stability_atlas"] = pd.DataFrame([atlas_row(outcome) for outcome in outcomes])
    report.captions["stability_atlas"] = "The failure atlas: what each method and solver answers"
    report.tables["stability_entries"] = pd.DataFrame(
        [{"entry": entry.name, "what fails, and why": entry.fails} for entry in ATLAS]
    )
    report.captions["stability_entries"] = "The failure atlas: what fails in each scene, and why"
    report.figures["stability_scenes"] = scene_sheet(outcomes)
    report.captions["stability_scenes"] = "The scenes of the failure atlas, moved where there is a mechanism"
    met = sum(not outcome.difference for outcome in outcomes)
    report.remarks.append(
        f"Failure atlas: {met} of {len(outcomes)} runs on {len(ATLAS)} scenes are as expected."
    )
    report.differences += [difference_line(outcome) for outcome in outcomes if outcome.difference]


def atlas_row(outcome: Observation) -> dict[str, object]:
    """The row of a run in the table."""
    run, result = outcome.run, outcome.result
    found = result.load_factor if result else None
    return {
        "entry": outcome.entry.name,
        "method": run.method,
        "solver": " ".join(word for word in (run.model, run.solver) if word) or "default",
        "options": ", ".join(f"{name} = {value}" for name, value in run.options.items()),
        "expected": expected_text(run),
        "got": outcome.got,
        "expected λ": _interval(run.load_factor),
        "λ": or_nan(found),
        "as expected": "no" if outcome.difference else "yes",
        "message": textwrap.shorten(outcome.message, _MESSAGE, placeholder=" …"),
    }


def difference_line(outcome: Observation) -> str:
    """What is not as expected."""
    difference = textwrap.shorten(outcome.difference, 3 * _MESSAGE, placeholder=" …")
    return f"{outcome.entry.name}, {outcome.run.name}: {difference}"


def _interval(load_factor: float | tuple[float, float] | None) -> str:
    ends = load_factor if isinstance(load_factor, tuple) else (load_factor,)
    return " to ".join(f"{value:.7g}" for value in ends if value is not None)
