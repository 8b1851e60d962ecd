"""Fig. 8 of the paper: Livesley's wedges, with and without dilatancy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.analysis import solve
from masonry_opt.studies.cases import open_case
from masonry_opt.studies.paper.example import (
    ProgressLine,
    PublishedValue,
    Report,
    against_reference,
    load_factor_text,
)
from masonry_opt.studies.paper.sheet import mechanism_sheet

WEDGES = "livesley/wedges.toml"

#: What is solved: method, options, the reference of the case file it is held against, and the value in
#: Fig. 8 with half a unit of its last digit.
_RUNS: dict[str, tuple[str, dict[str, Any], str, tuple[float, float]]] = {
    "associative, CVXPY": ("static", {}, "associative", (1.8, 0.05)),
    "associative, Pyomo": ("static", {"model": "pyomo"}, "associative", (1.8, 0.05)),
    "loop": ("nonassociative", {"preset": "paper"}, "nonassociative", (1.28, 0.005)),
    "refined": ("refined", {}, "coulomb", (1.28, 0.005)),
    "least, proven": ("global", {}, "coulomb", (1.28, 0.005)),
}


def fig8(cases: Path, progress: ProgressLine = lambda _: None) -> Report:
    """Uplift of one of two wedges: associative and Coulomb, both mechanisms."""
    scene = open_case(cases, WEDGES)
    report = Report(
        captions={
            "fig8": "Fig. 8: Livesley's wedges, uplift at the left one: (a) associative, the unloaded wedge "
            "rises with it; (b) Coulomb, it sinks. Each wedge is 1 high and weighs 1",
            "fig8_wedges": "Fig. 8: load factors λ, the uplift over the weight of a wedge",
        }
    )
    rows, results = [], {}
    for name, (method, options, reference, (drawn, half_unit)) in _RUNS.items():
        progress(name)
        result = results[name] = solve(scene, method, **options)
        report.published_values += [
            against_reference(scene, reference, result, name),
            PublishedValue(f"{name}: in the figure", drawn, result.load_factor, "Fig. 8", half_unit / drawn),
        ]
        closed = scene.reference["associative" if method == "static" else "coulomb"].value
        rows.append(
            {
                "answer": name,
                "Fig. 8": drawn,
                "closed form": closed,
                "λ": result.load_factor,
                "diff %": 100 * PublishedValue(name, closed, result.load_factor, "").relative_difference,
                "status": str(result.status),
                "LPs": result.lp_solves,
                "time (s)": sum(result.seconds.values()),
            }
        )
    report.tables["fig8_wedges"] = pd.DataFrame(rows)
    report.remarks.append(
        f"Of the Coulomb load factor: {results['least, proven'].message}. The loop's answer may lie a "
        "trace below it: its state is Coulomb's to within its own tolerance only."
    )
    associative, coulomb = results["associative, CVXPY"], results["least, proven"]
    report.figures["fig8"] = mechanism_sheet(
        [
            (f"(a) associative: {load_factor_text(associative)}", associative),
            (f"(b) Coulomb: {load_factor_text(coulomb)}", coulomb),
        ],
        columns=2,
    )
    return report
