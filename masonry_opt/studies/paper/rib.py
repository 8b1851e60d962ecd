"""Arch rib of Pippard & Ashby (section 5.2): the friction above which both flow rules give one λ."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure
from scipy.optimize import bisect

from masonry_opt.analysis import solve
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.cases import open_arch, with_joints
from masonry_opt.studies.palette import COLOURS
from masonry_opt.studies.paper.example import ProgressLine, Report, or_nan, published_value
from masonry_opt.studies.paper.least_thickness import friction_to_stand

CASE = "pippard_ashby/rib.toml"

FRICTIONS = (
    *(0.05, 0.06, 0.065, 0.07, 0.08, 0.09, 0.1, 0.105, 0.11, 0.115, 0.12, 0.13, 0.14, 0.16, 0.18, 0.2),
    *(0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.6, 0.7, 0.8),
)

#: Frictions at which a global search looks for a lower Coulomb load factor, and its limit of time (s).
PROVEN = (0.07, 0.08, 0.1, 0.12)
_TIME = 5.0

#: Seconds of search for lower states of so small a scene.
_SEARCH = 0.5

#: Load factors nearer than this, relative, coincide.
COINCIDE = 1e-4


def rib(cases: Path, progress: ProgressLine = lambda _: None) -> Report:
    """Load factor of the rib against friction, associative and Coulomb."""
    scene, arch = open_arch(cases, CASE)
    rows = []
    for mu in FRICTIONS:
        progress(f"μ = {mu:g}")
        rows.append(_row(scene, mu))
    table = pd.DataFrame(rows)
    progress("where associative and Coulomb part")
    stands = friction_to_stand(arch)
    parting = _parting(scene, table, stands)
    claimed = scene.reference["coincide_above"]
    coincide_from = stands if parting is None else parting
    report = Report(
        tables={"rib": table},
        figures={"rib": _figure(table, stands, claimed.value)},
        captions={
            "rib": "Load factor (in voussoir weights) of the arch rib against friction; loop with "
            "always=True; global: least Coulomb load factor that a global search found, where it was run",
        },
    )
    report.published_values.append(
        published_value(
            scene,
            "coincide_above",
            coincide_from,
            "μ from which associative and Coulomb coincide",
            cause="" if abs(coincide_from - claimed.value) < 0.005 else _cause(parting),
        )
    )
    holds = coincide_from <= claimed.value
    report.remarks += [
        f"The claim that associative and Coulomb load factors coincide for μ above about {claimed.value:g} "
        f"{'holds' if holds else 'does not hold'} with the geometry assumed in the case file.",
        f"The rib stands under its own weight for μ ≥ {stands:.5f}.",
    ]
    if parting is None:
        report.remarks.append(
            f"They coincide (within {COINCIDE:g}) below {claimed.value:g} too, wherever the rib stands: "
            f"largest difference of the loop {_largest(table, 'loop'):.1e}, of the exact refinement "
            f"{_largest(table, 'refined'):.1e}."
        )
    searched = _largest(table, "global")
    found = (
        "found no lower Coulomb load factor" if searched < COINCIDE else "found another Coulomb load factor"
    )
    report.remarks.append(
        f"Global searches at μ = {', '.join(f'{m:g}' for m in PROVEN)} {found} (difference {searched:.1e})."
    )
    if parting is not None:
        report.remarks.append(f"They part below μ = {parting:.4f}.")
    report.differences += [
        f"μ = {row['μ']:g}: the {name} ended '{row[name + ' ended']}'"
        for row in table.to_dict("records")
        for name in ("loop", "refined")
        if float(row["μ"]) > stands and row[name + " ended"] != "converged"
    ]
    return report


def with_friction(scene: Scene, friction: float) -> Scene:
    """The scene with another friction in all its joints."""
    return with_joints(scene, friction=friction)


def _row(scene: Scene, mu: float) -> dict[str, object]:
    at = with_friction(scene, mu)
    associative, loop = solve(at, "static"), solve(at, "nonassociative", always=True)
    refined = solve(at, "refined", search=_SEARCH)
    least = solve(at, "global", time_limit=_TIME).load_factor if mu in PROVEN else None
    return {
        "μ": mu,
        "associative": or_nan(associative.load_factor),
        "loop": or_nan(loop.load_factor),
        "refined": or_nan(refined.load_factor),
        "global": or_nan(least),
        "associative ended": str(associative.status),
        "loop ended": str(loop.status),
        "refined ended": str(refined.status),
    }


def _parting(scene: Scene, table: pd.DataFrame, stands: float) -> float | None:
    """μ below which the two load factors differ, by bisection; None if they never do."""
    apart = (table["refined"] / table["associative"] - 1).abs() > COINCIDE
    if not apart.any():
        return None
    low = float(table.loc[apart, "μ"].max())
    above = table.loc[(table["μ"] > low) & table["refined"].notna(), "μ"]
    if above.empty:
        return low

    def differs(mu: float) -> float:
        at = with_friction(scene, mu)
        associative, refined = solve(at, "static"), solve(at, "refined", search=_SEARCH)
        return abs(or_nan(refined.load_factor) / or_nan(associative.load_factor) - 1) - COINCIDE

    return float(bisect(differs, max(low, stands), float(above.min()), xtol=1e-4))


def _largest(table: pd.DataFrame, method: str) -> float:
    """Largest relative difference of a method from the associative load factor."""
    return float((table[method] / table["associative"] - 1).abs().max())


def _cause(parting: float | None) -> str:
    if parting is None:
        return (
            "nothing parts them with the geometry assumed, down to the friction at which the rib no longer "
            "stands; the paper's geometry and dead loads are not known to us"
        )
    return "the paper's geometry and dead loads are not known to us"


def _figure(table: pd.DataFrame, stands: float, claimed: float) -> Figure:
    figure = Figure(figsize=(7.0, 4.2))
    axes = figure.add_subplot()
    axes.plot(table["μ"], table["associative"], color=COLOURS[0], linewidth=1.8, label="associative")
    axes.plot(table["μ"], table["loop"], "o", color=COLOURS[1], markersize=6, fillstyle="none", label="loop")
    axes.plot(table["μ"], table["refined"], "x", color="black", markersize=5, label="exact Coulomb (refined)")
    axes.axvline(claimed, color="#777777", linestyle="--", linewidth=1)
    top = float(table["associative"].max())
    axes.annotate(f" μ = {claimed:g}: published,\n coincide above", (claimed, 0.8 * top), fontsize=9)
    axes.axvspan(0, stands, color="#DDDDDD", zorder=0)
    axes.annotate(
        "falls\nby itself", (stands / 2, 0.5 * top), ha="center", rotation=90, va="center", fontsize=9
    )
    axes.set_xlim(0, float(table["μ"].max()) + 0.02)
    axes.set_ylim(0, 1.1 * top)
    axes.set_xlabel("friction μ = tan φ")
    axes.set_ylabel("load factor λ (voussoir weights)")
    axes.legend(loc="lower right")
    return figure
