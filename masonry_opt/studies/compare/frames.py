"""The tables behind charts and reports: medians, Pareto fronts, success."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.answer.acceptance import SMALLEST
from masonry_opt.answer.thresholds import APART, SAME
from masonry_opt.studies.compare.accuracy import CertifiedBounds
from masonry_opt.studies.compare.best_known import BestKnown
from masonry_opt.studies.compare.judge import CERTIFIED, COULOMB, GAP_FLOOR, NAMED, TARGET, VERDICTS, judge
from masonry_opt.studies.compare.runs import RESIDUALS, pair_of

_PAIR = ["method", "model", "solver", "tolerance"]

#: Numbers of a summary that are medians of the repeats.
_MEDIANS = ["time", "build_seconds", "compile_seconds", "solve_seconds", "read_seconds", "peak_memory"]
_COUNTS = ["lp_solves", "nlp_solves", "iterations"]

#: Columns of the success table, and headings that are not their names.
SUCCESS = ["tolerance", "success", *VERDICTS, "on target", "time", "largest error", "largest violation"]
SUCCESS += ["peak_memory"]
HEADINGS = {"time": "median time (s)", "peak_memory": "peak (MB)"}

#: How numbers are written, by column.
FORMATS = {
    **dict.fromkeys(("success", "on target"), "{:.0%}"),
    "spread": "{:.1%}",
    "load_factor": "{:.9g}",
    "time": "{:.3g}",
    **dict.fromkeys(("lowest", "highest"), "{:.5g}"),
    **dict.fromkeys(("error", "violation", "largest error", "largest violation"), "{:.1e}"),
    **dict.fromkeys(("tolerance", *RESIDUALS), "{:.0e}"),
    **dict.fromkeys(("iterations", "lp_solves", "peak_memory", "blocks", "joints"), "{:.0f}"),
    **dict.fromkeys(("scenes", *VERDICTS), "{}"),
}


def summary(
    rows: Iterable[dict[str, Any]],
    bounds: Mapping[str, CertifiedBounds],
    best: Mapping[str, BestKnown],
    expected: Mapping[str, Mapping[str, str]],
) -> pd.DataFrame:
    """One row a scene and pair: medians of the repeats' times, and the worst verdict of the repeats.

    ``bounds``, ``best`` and ``expected`` are by scene name (see :func:`~.judge.judge`). ``time``: seconds of
    the solve without the parts that all pairs share: reading the scene, checking its dead load.
    """
    judged = []
    for row in rows:
        shared = (row["scene_seconds"] or 0.0) + (row["dead_load_seconds"] or 0.0)
        scene = row["scene"]
        verdict = judge(row, bounds.get(scene), best.get(scene), expected.get(scene, {}))
        judged.append(row | {"pair": pair_of(row).label, "time": row["wall"] - shared} | verdict)
    frame = pd.DataFrame(judged)
    if frame.empty:
        return frame
    numbers = [*_MEDIANS, *_COUNTS, *RESIDUALS, "tolerance", "error", "violation", "load_factor", "bound"]
    numbers += ["joints", "blocks"]
    frame[numbers] = frame[numbers].astype(float)
    repeats = frame.groupby(["scene", *_PAIR], dropna=False, sort=False)
    frame["of"], frame["badness"] = repeats.ngroup(), frame["verdict"].map(VERDICTS.index)
    frame["repeats"] = repeats["scene"].transform("size")
    frame[_MEDIANS] = repeats[_MEDIANS].transform("median")
    worst = frame.sort_values(["of", "badness"], kind="stable").drop_duplicates("of", keep="last")
    columns = ["scene", "pair", *_PAIR, "question", "verdict", "reason", "right", "load_factor", "error"]
    columns += ["below", "violation", *_MEDIANS, *_COUNTS, "repeats", "joints", "blocks", *RESIDUALS]
    return worst[[*columns, "bound", "ended", "status", "kind", "message"]].reset_index(drop=True)


def answers(frame: pd.DataFrame) -> pd.DataFrame:
    """The answer of each method to each scene: one row of the summary for a scene and method.

    Among the runs of a method, the one with the best verdict; among certified ones the one nearest to the
    certified bounds (associative λ) or with the lowest λ (Coulomb), within SAME; among these the quickest.
    Further columns: ``runs`` of the method on the scene; ``alike``: runs with the same verdict; ``gap``: the
    error, negative where λ is below the best exact state known, 0 up to GAP_FLOOR.
    """
    runs = frame.groupby(["scene", "method"], sort=False)
    frame = frame.assign(of=runs.ngroup(), runs=runs["scene"].transform("size"))
    frame["alike"] = frame.groupby(["of", "verdict"])["scene"].transform("size")
    near = frame["error"] <= GAP_FLOOR
    frame["gap"] = frame["error"].mask(near, 0.0).mask(frame["below"] & ~near, -frame["error"])
    certified = frame["verdict"] == CERTIFIED
    lowest = frame["load_factor"].where(certified).groupby(frame["of"]).transform("min")
    above = (frame["load_factor"] - lowest) / lowest.abs().clip(lower=SMALLEST)
    distance = frame["error"].where(frame["question"] != COULOMB, above).fillna(np.inf).clip(lower=SAME)
    frame["rank"], frame["distance"] = frame["verdict"].map(VERDICTS.index), distance.where(certified, 0.0)
    order = ["of", "rank", "distance", "time"]
    return frame.sort_values(order, kind="stable").drop_duplicates("of").drop(columns=order[:3])


def pareto(frame: pd.DataFrame, cost: str = "time", error: str = "error") -> pd.DataFrame:
    """The certified rows that no other such row beats in both columns, cheapest first."""
    known = frame[(frame["verdict"] == CERTIFIED) & frame[error].notna()].sort_values([cost, error])
    before = known[error].cummin().shift(fill_value=np.inf)
    return known[known[error] < before]


def success(frame: pd.DataFrame) -> pd.DataFrame:
    """How the scenes ended, one row a pair and tolerance.

    ``success``: share that is certified or named correctly. ``on target``: share that is certified with an
    error within TARGET. Median and quartiles of the time, largest error and violation are those of the
    certified answers; peak_memory (MB) is that of all.
    """
    if frame.empty:
        return frame
    certified = frame["verdict"] == CERTIFIED
    marked = frame.assign(
        **{verdict: (frame["verdict"] == verdict).astype(int) for verdict in VERDICTS},
        success=frame["verdict"].isin((CERTIFIED, NAMED)),
        target=certified & (frame["error"] <= frame["question"].map(TARGET)),
        **{name: frame[name].where(certified) for name in ("time", "error", "violation")},
    )
    columns: dict[str, Any] = {
        "scenes": ("scene", "size"),
        **{verdict: (verdict, "sum") for verdict in VERDICTS},
        "success": ("success", "mean"),
        "on target": ("target", "mean"),
        "time": ("time", "median"),
        "time 25 %": ("time", lambda times: times.quantile(0.25)),
        "time 75 %": ("time", lambda times: times.quantile(0.75)),
        "largest error": ("error", "max"),
        "largest violation": ("violation", "max"),
        "peak_memory": ("peak_memory", "max"),
    }
    return marked.groupby(["pair", *_PAIR], dropna=False, sort=False).agg(**columns).reset_index()


def spread(frame: pd.DataFrame) -> pd.DataFrame:
    """Scenes whose certified Coulomb load factors differ by more than APART, the widest spread first.

    Columns: scene; ``lowest`` and ``highest`` λ of the certified Coulomb runs; ``spread``, their distance
    over the lowest; ``lowest by`` and ``highest by``: the pairs that ended there, within GAP_FLOOR.
    """
    columns = ["scene", "lowest", "highest", "spread", "lowest by", "highest by"]
    if frame.empty:
        return pd.DataFrame(columns=columns)
    lines = []
    certified = frame[(frame["verdict"] == CERTIFIED) & (frame["question"] == COULOMB)]
    for scene, group in certified.groupby("scene", sort=False):
        lowest, highest = group["load_factor"].min(), group["load_factor"].max()
        share = (highest - lowest) / max(abs(lowest), SMALLEST)
        if share > APART:
            ends = [_who_ended(group, load_factor) for load_factor in (lowest, highest)]
            lines.append(dict(zip(columns, [scene, lowest, highest, share, *ends], strict=True)))
    return pd.DataFrame(lines, columns=columns).sort_values("spread", ascending=False, kind="stable")


def _who_ended(group: pd.DataFrame, load_factor: float) -> str:
    """The pairs that ended at a load factor: the first, and how many others."""
    near = (group["load_factor"] - load_factor).abs() <= GAP_FLOOR * max(abs(load_factor), SMALLEST)
    first, *others = group.loc[near, "pair"].unique()
    return f"{first} and {len(others)} more" if others else str(first)
