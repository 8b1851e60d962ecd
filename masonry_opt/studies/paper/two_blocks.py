"""Fig. 6 of the paper: two blocks, and how the load factor depends on the angle of dilatancy φ₀.

Closed form. The face between A and B rises by ψ in the direction in which A is pushed. B, of weight 1,
rests on a rough support in the line of that face, its weight in the middle of its span (0 ≤ x ≤ 3). As A
moves by (1, tan φ₀), B rotates about one end of its support and touches A at one end of the face: about
x = 0 and at x = 2 if it rises, about x = 1 and at x = 3 if it sinks. The shear force of the face passes
through the hinge, so that moments about the hinge give the normal force

    n = κ cos ψ,    κ = 1.5 / 2 if B rises, 0.5 / 2 if it sinks.

A drags B along; the face presses on A by n (cos ψ + μ sin ψ) downwards and n (μ cos ψ - sin ψ) backwards:

    λ = μ (1 + n (cos ψ + μ sin ψ)) + n (μ cos ψ - sin ψ) = μ + κ cos² ψ (2 μ - (1 - μ²) tan ψ).

With ψ = 0: 2.5 μ and 1.5 μ. With t = tan φ₀, B's end of the face moves along the normal of the face by

    t (cos ψ + t sin ψ) + t cos ψ - sin ψ = 2 t cos ψ - (1 - t²) sin ψ :

first what the face opens by as it slips, then what A rises by. This changes its sign where
tan 2φ₀ = tan ψ: the load factor jumps at φ₀ = ψ / 2.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from masonry_opt.analysis import solve
from masonry_opt.answer.status import Status
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.cases import open_case, with_joints
from masonry_opt.studies.palette import COLOURS
from masonry_opt.studies.paper.example import (
    Basis,
    ProgressLine,
    PublishedValue,
    Report,
    against_reference,
    or_nan,
)
from masonry_opt.studies.paper.sheet import draw_panel

TWO_BLOCKS = "gilbert/two_blocks.toml"

#: Angles of dilatancy, in degrees, at which λ is computed; friction is φ = 5.7°.
_ANGLES = (-5.0, -4.0, -3.0, -2.5, -1.5, -1.0, -0.5, 0.5, 1.0, 1.5, 2.5, 3.0, 4.0, 5.0)

#: Halvings of the ten degrees between the outermost angles: to 0.0006°.
_HALVINGS = 14

#: An exact state against a closed form whose case file has twelve digits.
_EXACT = 1e-8

_SOURCE = "section 4.1 and footnote 2"


@dataclass(frozen=True)
class Variant:
    """A form of the two blocks.

    Attributes
    ----------
    file: its case file.
    name: what it is.
    face: ψ, by which the face between A and B rises in the direction of A's motion, in degrees.
    """

    file: str
    name: str
    face: float


FLAT = Variant(TWO_BLOCKS, "flat", 0.0)
CONTRACTS = Variant("gilbert/wedge_blocks.toml", "contracting wedge", 4.0)
EXPANDS = Variant("gilbert/wedge_blocks_expanding.toml", "expanding wedge", -4.0)


def closed_form(friction: float, face: float, rises: bool) -> float:
    """Load factor by hand (see above): friction μ, inclination of the face in degrees, and B's sense."""
    psi, share = math.radians(face), 0.75 if rises else 0.25
    return friction + share * math.cos(psi) ** 2 * (2 * friction - (1 - friction**2) * math.tan(psi))


def with_dilatancy(scene: Scene, angle: float) -> Scene:
    """The scene with the same angle of dilatancy, in degrees, in every joint."""
    return with_joints(scene, dilatancy=math.tan(math.radians(angle)))


def jump_angle(scene: Scene, between: float) -> float:
    """Angle of dilatancy, in degrees, at which the least load factor crosses a value, by bisection.

    NaN if there is no load factor on the way.
    """
    low, high = _ANGLES[0], _ANGLES[-1]
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        least = solve(with_dilatancy(scene, middle), "global").load_factor
        if least is None:
            return math.nan
        if least > between:
            high = middle
        else:
            low = middle
    return (low + high) / 2


def fig6(cases: Path, progress: ProgressLine = lambda _: None) -> Report:
    """Load factor of two blocks and of their wedge variants against the angle of dilatancy."""
    report = Report(
        captions={
            "fig6": "Fig. 6: two blocks, of which the lower, A, is pushed to the right: (b) it expands as it "
            "slides and B rises; (c) it contracts and B sinks. Sliding joints blue, hinges orange. (d) "
            "Load factor against the angle of dilatancy; (e), (f) the same where the face between the blocks "
            "rises by ψ",
            "fig6_dilatancy": "Fig. 6: load factor at every angle of dilatancy",
            "fig6_jump": "Fig. 6: where the load factor jumps",
        },
        remarks=[
            "The load factor is a step: what counts is whether B rises or sinks. At the jump itself every "
            "value between is admissible; Fig. 7 shows where the loop ends if it does not contract.",
            "The jump lies at half the angle of the face, as footnote 2 of the paper says: above zero if the "
            "motion of A makes room under B (the wedge contracts), below zero if it lifts B (it expands).",
        ],
    )
    points, jumps = [], []
    scenes = {variant: open_case(cases, variant.file) for variant in (FLAT, CONTRACTS, EXPANDS)}
    for variant, scene in scenes.items():
        progress(f"{variant.name}: at φ₀ = φ and φ₀ = 0")
        for reference, method in (
            ("associative", "static"),
            ("coulomb", "global"),
            ("nonassociative", "nonassociative"),
        ):
            options: dict[str, Any] = {"preset": "paper"} if method == "nonassociative" else {}
            result = solve(scene, method, **options)
            report.published_values.append(
                against_reference(scene, reference, result, f"{variant.name} ({method})")
            )
        points += _sweep(variant, scene, progress)
        progress(f"{variant.name}: where the load factor jumps")
        start = time.perf_counter()
        low, high = _levels(variant, scene)
        found = jump_angle(scene, (low + high) / 2)
        jumps.append(
            {
                "variant": variant.name,
                "face ψ (°)": variant.face,
                "published jump (°)": variant.face / 2,
                "computed jump (°)": found,
                "λ below": low,
                "λ above": high,
                "time (s)": time.perf_counter() - start,
            }
        )
        report.published_values.append(
            PublishedValue(
                f"{variant.name}: φ₀ of the jump (°)", variant.face / 2, found, _SOURCE, tolerance=1e-3
            )
        )
    table = pd.DataFrame(points)
    opens = table["φ₀ (°)"] >= 0
    report.remarks.append(
        f"The least load factor is proven at {table.loc[opens, 'proven'].sum()} of {opens.sum()} angles "
        f"φ₀ ≥ 0 and at {table.loc[~opens, 'proven'].sum()} of {(~opens).sum()} below, where joints contract "
        "and no bounds of the rates can be derived."
    )
    for (name, below), rows in table.groupby(["variant", "B sinks"], sort=False):
        worst = int((rows["least λ"] - rows["by hand"]).abs().fillna(math.inf).argmax())
        report.published_values.append(
            PublishedValue(
                f"{name}: least λ while B {'sinks' if below else 'rises'} (worst of {len(rows)} angles)",
                float(rows["by hand"].iloc[worst]),
                float(rows["least λ"].iloc[worst]),
                "closed form",
                tolerance=_EXACT,
                basis=Basis.BY_HAND,
            )
        )
    report.tables = {
        "fig6_jump": pd.DataFrame(jumps),
        "fig6_dilatancy": table.drop(columns="B sinks"),
    }
    report.figures["fig6"] = _draw(scenes, table)
    return report


def _levels(variant: Variant, scene: Scene) -> tuple[float, float]:
    friction = scene.joints.friction
    return closed_form(friction, variant.face, False), closed_form(friction, variant.face, True)


def _sweep(variant: Variant, scene: Scene, progress: ProgressLine) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    levels = _levels(variant, scene)
    for angle in _ANGLES:
        progress(f"{variant.name}: φ₀ = {angle:g}°")
        dilatant = with_dilatancy(scene, angle)
        start = time.perf_counter()
        loop = solve(dilatant, "nonassociative", preset="paper")
        least = solve(dilatant, "global")
        rises = angle > variant.face / 2
        rows.append(
            {
                "variant": variant.name,
                "φ₀ (°)": angle,
                "B sinks": not rises,
                "by hand": levels[rises],
                "least λ": or_nan(least.load_factor),
                "proven": least.status is Status.OPTIMAL,
                "loop": or_nan(loop.load_factor),
                "least λ, diff %": 100 * (or_nan(least.load_factor) / levels[rises] - 1),
                "loop, diff %": 100 * (or_nan(loop.load_factor) / levels[rises] - 1),
                "time (s)": time.perf_counter() - start,
            }
        )
    return rows


def _draw(scenes: dict[Variant, Scene], table: pd.DataFrame) -> Figure:
    figure = Figure(figsize=(8.0, 5.6), layout="constrained")
    grid = figure.add_gridspec(2, 1, height_ratios=[1, 2])
    above, below = figure.add_subfigure(grid[0]), figure.add_subfigure(grid[1])
    mechanisms = {
        "(b) φ₀ = φ: expands": solve(scenes[FLAT], "static"),
        "(c) φ₀ = -5°: contracts": solve(with_dilatancy(scenes[FLAT], -5.0), "global"),
        "ψ = 4°, φ₀ = 0: contracts": solve(scenes[CONTRACTS], "global"),
    }
    for axes, (title, result) in zip(above.subplots(1, 3), mechanisms.items(), strict=True):
        draw_panel(
            result, axes, f"{title}\nλ = {or_nan(result.load_factor) / scenes[FLAT].joints.friction:.4g} μ"
        )
        for x, y, name in result.blocks[["x", "y", "block"]].itertuples(index=False):
            axes.annotate(name, (x, y), ha="center", va="center")
    charts = below.subplots(1, 3, sharey=True)
    for axes, letter, (variant, scene) in zip(charts, "def", scenes.items(), strict=True):
        _draw_step(axes, variant, scene, table[table["variant"] == variant.name])
        axes.set_title(f"({letter}) {variant.name}, ψ = {variant.face:g}°", fontsize=10)
    charts[0].set_ylabel("load factor λ / μ")
    below.legend(*charts[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    return figure


def _draw_step(axes: Axes, variant: Variant, scene: Scene, points: pd.DataFrame) -> None:
    mu, jump = scene.joints.friction, variant.face / 2
    low, high = (level / mu for level in _levels(variant, scene))
    limit = math.degrees(math.atan(mu))
    axes.plot([-limit, jump, jump, limit], [low, low, high, high], color="#777777", label="by hand")
    angles = points["φ₀ (°)"]
    axes.plot(angles, points["least λ"] / mu, "o", color=COLOURS[0], markersize=6, label="least λ")
    axes.plot(angles, points["loop"] / mu, ".", color=COLOURS[4], markersize=5, label="loop")
    axes.axvline(jump, color=COLOURS[1], linewidth=1, linestyle="--", zorder=0, label="φ₀ = ψ / 2")
    for level, where, side in ((low, -limit, "left"), (high, limit, "right")):
        axes.annotate(f"{level:.4g} μ", (where, level), xytext=(0, 7), textcoords="offset points", ha=side)
    axes.set_xlabel("dilatancy φ₀ (°)")
    axes.set_ylim(1.0, 3.3)
    axes.set_xticks([-4, -2, 0, 2, 4])
    axes.grid(color="#EEEEEE")
