"""What is done inside a run's own process: one solve, or the certified bounds of one scene."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path
from typing import Any

from masonry_opt.analysis import solve
from masonry_opt.errors import MasonryError
from masonry_opt.methods.registry import METHODS
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.blocks import Block, JointDefaults
from masonry_opt.scene.case_file import load
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.compare.accuracy import certified_bounds
from masonry_opt.studies.compare.plan import Pair

#: Share of a run's time limit that a method with a time limit of its own is given.
_OWN_LIMIT = 0.8

#: One block on a floor.
_WARM_UP = Scene(
    joints=JointDefaults(friction=0.6),
    blocks=[
        Block(name="A", vertices=[(0, 0), (1, 0), (1, 2), (0, 2)], weight=1, live=(1, 0)),
        Block(name="floor", vertices=[(-5, -1), (6, -1), (6, 0), (-5, 0)], fixed=True),
    ],
)


def run_pair(path: Path, pair: Pair, time_limit: float) -> dict[str, Any]:
    """Solve a case file; what :func:`~.store.row` keeps of the result, and ``wall``: seconds of the
    solve by the clock on the wall.

    A first solve of one block, not timed, loads what libraries load late.
    """
    chosen: dict[str, Any] = {"model": pair.model, "solver": pair.solver, "tolerance": pair.tolerance}
    method = METHODS[pair.method]
    options: dict[str, Any] = {}
    if method.options and "time_limit" in method.options.model_fields:
        options["time_limit"] = _OWN_LIMIT * time_limit
    with contextlib.suppress(MasonryError, ArithmeticError, ValueError, AttributeError):
        # A solver that fails here fails again below, where it counts.
        if method.own_tolerances:
            for model in ("cvxpy", "pyomo"):
                solve(_WARM_UP, "static", model=model)
        else:
            solve(_WARM_UP, pair.method, **chosen)
    start = time.perf_counter()
    result = solve(path, pair.method, **chosen, **options)
    wall = time.perf_counter() - start
    kept = result.as_dict()
    for frame in ("history", "block_results", "joint_results"):
        del kept[frame]
    return kept | {"wall": wall}


def bound_scene(path: Path) -> dict[str, float]:
    """Certified bounds of a case file's associative load factor (see ``certified_bounds``)."""
    bounds = certified_bounds(assemble(load(path)).problem)
    return {"lower": bounds.lower, "upper": bounds.upper}
