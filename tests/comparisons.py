"""A made-up comparison of solvers on two case files, with every way in which a run can end."""

from typing import Any

import pandas as pd
from atlas.made_scenes import judged_by_hand
from lines import line
from scenes import CASES

from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.judge import BestKnown, Comparison, summary
from masonry_opt.studies.compare.runs import COMPARISON_COLUMNS, RunLimits, find_scenes, plan

NAMES = BLOCKS, WALL = "gilbert/two_blocks", "ferris_tinloi/wall_1"

#: For each scene and method: λ, seconds, and the entries that differ from a good line (:mod:`lines`).
_ENDS: dict[tuple[str, str], tuple[float | None, float, dict[str, Any]]] = {
    (BLOCKS, "static"): (0.25, 1.5, {}),
    (BLOCKS, "nonassociative"): (0.153, 2.5, {}),
    (BLOCKS, "coulomb"): (0.15, 0.5, {}),
    (BLOCKS, "mpec"): (0.15, 4.5, {"flow": 0.3}),
    (WALL, "static"): (0.64286, 1.5, {}),
    (WALL, "nonassociative"): (None, 60.0, {"ended": "time limit", "message": "over 60 s"}),
    (WALL, "coulomb"): (None, 3.5, {"status": "unstable under dead load", "message": "It falls. " * 30}),
    (WALL, "mpec"): (0.63898, 5.5, {}),
}


def made_up() -> Comparison:
    """Return a comparison of two scenes and four methods.

    HiGHS takes twice as long as Clarabel. With HiGHS the loop ends at a load factor that is 2 % higher.
    """
    planned = plan(["static", "nonassociative", "coulomb", "mpec"], ["cvxpy"], ["clarabel", "highs"], [1e-9])
    rows = []
    for scene in NAMES:
        for pair in planned.pairs:
            load_factor, seconds, known = _ENDS[scene, pair.method]
            worse = pair.method == "nonassociative" and pair.solver == "highs"
            run = {
                "method": pair.method,
                "model": pair.model,
                "solver": pair.solver,
                "tolerance": pair.tolerance,
                "load_factor": load_factor and load_factor * (1.02 if worse else 1.0),
                "wall": seconds * (2 if pair.solver == "highs" else 1),
            }
            rows.append(line(scene=scene, **(run | known)))
    bounds = {BLOCKS: CertifiedBounds(0.25, 0.25), WALL: CertifiedBounds(0.64286, 0.64286)}
    best = {BLOCKS: BestKnown(0.15, "by hand"), WALL: BestKnown(0.63898, "mpec")}
    judged = judged_by_hand(summary(rows, bounds, best), {WALL: {"Coulomb": "unstable under dead load"}})
    scenes = find_scenes([CASES / f"{name}.toml" for name in NAMES])
    results = pd.DataFrame(rows, columns=COMPARISON_COLUMNS)
    return Comparison(scenes, planned, RunLimits(60, 4000, 1), bounds, best, results, judged)
