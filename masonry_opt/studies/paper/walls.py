"""Figs 10 and 13 of the paper: mechanisms of the walls of Ferris & Tin-Loi and of Orduña & Lourenço."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from masonry_opt.analysis import solve
from masonry_opt.answer.result import Result
from masonry_opt.studies.cases import open_case
from masonry_opt.studies.paper.example import (
    ProgressLine,
    PublishedValue,
    Report,
    against_reference,
    load_factor_text,
    reference_number,
)
from masonry_opt.studies.paper.sheet import mechanism_sheet
from masonry_opt.studies.paper.table1 import WALLS, counts, wall_file

LARGE_WALL = "orduna_lourenco/wall.toml"

#: Walls that footnote 4 of the paper says fail in rocking alone.
_ROCKING = (3, 4)

#: Share of energy that the loop's small cohesion (1e-5 of the largest normal force) may dissipate.
_NO_SLIDING = 1e-3


def sliding_share(result: Result) -> float:
    """Share of the energy that Coulomb friction dissipates at the loop's last sub-problem."""
    last = result.history.iloc[-1]
    return float(last["coulomb_sliding"] / last["load_factor"])


def fig10(cases: Path, progress: ProgressLine = lambda _: None) -> Report:
    """The six mechanisms that the loop ends with, in one sheet."""
    report = Report(
        captions={
            "fig10": "Fig. 10: mechanisms of the six walls of Ferris & Tin-Loi at the loop's last "
            "sub-problem; full blocks are 4 × 1.75, displacements are magnified",
            "fig10_walls": "Fig. 10: the loop's answers",
        }
    )
    panels, rows = [], []
    for number in WALLS:
        progress(f"wall {number}")
        scene = open_case(cases, wall_file(number))
        result = solve(scene, "nonassociative")
        share = sliding_share(result)
        comparison = against_reference(scene, "nonassociative", result, f"wall {number}")
        report.published_values.append(comparison)
        if number in _ROCKING:
            # Of the whole: nothing relative can be said of a published zero.
            report.published_values.append(
                PublishedValue(
                    f"wall {number}: share of energy in sliding",
                    0.0,
                    share,
                    "footnote 4",
                    tolerance=_NO_SLIDING,
                )
            )
        letter = "abcdef"[number - 1]
        panels.append((f"({letter}) wall {number}: {load_factor_text(result)}", result))
        rows.append(
            {
                "wall": number,
                "λ paper": comparison.published,
                "λ": result.load_factor,
                "diff %": 100 * comparison.relative_difference,
                "in sliding (%)": f"{100 * share:.1f}",
                "status": str(result.status),
                "LPs": result.lp_solves,
                "time (s)": sum(result.seconds.values()),
                "published (s)": scene.reference["nonassociative_seconds"].value,
            }
        )
    report.tables["fig10_walls"] = pd.DataFrame(rows)
    report.figures["fig10"] = mechanism_sheet(panels, columns=3)
    return report


def fig13(cases: Path, progress: ProgressLine = lambda _: None) -> Report:
    """The wall of 792 blocks: associative and Coulomb load factor, and its mechanism."""
    scene = open_case(cases, LARGE_WALL)
    progress("associative")
    associative = solve(scene, "static")
    progress("loop")
    loop = solve(scene, "nonassociative", sub_problems="accurate")
    report = Report(
        published_values=[
            *counts(scene, loop, "wall"),
            against_reference(scene, "associative", associative, "static"),
            against_reference(
                scene,
                "nonassociative",
                loop,
                "loop",
                "which optimal state a solver returns decides where the loop ends; ours ends with exact "
                f"forces on its mechanism, and its last sub-problem at "
                f"{loop.history['load_factor'].iloc[-1]:.5f}",
            ),
            against_reference(
                scene,
                "mpec",
                loop,
                "loop, against the MPEC of Orduña & Lourenço",
                "the Coulomb problem has many solutions, and another method ends in another",
            ),
        ],
        captions={
            "fig13": "Fig. 13: mechanism of Orduña & Lourenço's wall at the loop's last sub-problem; blocks "
            "are 3 × 1, displacements are magnified",
            "fig13_wall": "Fig. 13: load factors and times. Published times are of machines of 2005: 1.4 GHz "
            "(the paper's loop), 551 MHz (the MPEC: 15 h 46 min)",
        },
    )
    rows: list[dict[str, object]] = []
    for answer, result, reference in (
        ("associative", associative, "associative"),
        ("Coulomb, loop", loop, "nonassociative"),
        ("Coulomb, MPEC of Orduña & Lourenço", None, "mpec"),
    ):
        rows.append(
            {
                "answer": answer,
                "published": scene.reference[reference].value,
                "computed": None if result is None else result.load_factor,
                "LPs": "–" if result is None else str(result.lp_solves),
                "time (s)": float("nan") if result is None else sum(result.seconds.values()),
                "published (s)": reference_number(scene, f"{reference}_seconds"),
                "status": "–" if result is None else str(result.status),
            }
        )
    report.tables["fig13_wall"] = pd.DataFrame(rows)
    if loop.certificate is not None:
        report.remarks.append(
            f"At the loop's end no joint violates Coulomb's law by more than {loop.certificate.yield_:.2g} "
            f"median block weights; {100 * sliding_share(loop):.1f} % of the "
            "energy goes into sliding."
        )
    report.figures["fig13"] = mechanism_sheet(
        [(f"{loop.size.blocks} blocks, {loop.size.joints} joints: {load_factor_text(loop)}", loop)], columns=1
    )
    return report
