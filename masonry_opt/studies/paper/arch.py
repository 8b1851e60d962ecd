"""Fig. 9 of the paper: the least thickness of a semicircular arch against the friction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from masonry_opt.analysis import solve
from masonry_opt.answer.result import Result
from masonry_opt.scene.arch import Arch, PointLoad
from masonry_opt.scene.blocks import JointDefaults
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.cases import open_arch
from masonry_opt.studies.paper.arch_figures import draw_curve, draw_modes
from masonry_opt.studies.paper.continuous_arch import (
    least_friction_to_hinge,
    least_friction_to_stand,
    least_thickness_ratio,
)
from masonry_opt.studies.paper.example import ProgressLine, PublishedValue, Report, or_nan, published_value
from masonry_opt.studies.paper.least_thickness import (
    LeastThickness,
    friction_to_stand,
    least_thickness,
    opened_scene,
)

CASE = "casapulla_lauro/arch.toml"

#: μ of the curve, beside points close to the transitions.
FRICTIONS = (0.2, 0.25, 0.3, 0.32, 0.33, 0.34, 0.35, 0.36, 0.37, 0.38, 0.39, 0.4, 0.45, 0.5, 0.6, 0.7, 0.8)
_NEAR = 1e-4

#: Numbers of voussoirs of the look at convergence.
COUNTS = (9, 26, 27, 28, 81, 243)
WEIGHTS = ("sector", "straight", "centreline")

#: Where the limits for infinitely many voussoirs were published, and how many are held against them.
LIMITS = "Cocchetti & Rizzi (2020), doi 10.3221/IGF-ESIS.51.26: limit of many voussoirs"
MANY = 501

#: Thicknesses over the least: where exact Coulomb states are looked for, and where the loop is run, whose
#: tolerances need the distance.
_NEXT_TO_IT, _THICKER = (1 + 1e-4, 1 + 2e-4), 1.05

#: Mode III is drawn at this thickness over the least against hinging, and with μ this much above the
#: transition, below which no thickness stands.
_THICK, _ROUGHER = 1.1, 0.005

#: Rates over the largest below which a joint is still.
_STILL = 1e-5


@dataclass(frozen=True)
class Transitions:
    """μ at which the mode of collapse changes: I (hinging) above ``hinging``, III (sliding) below
    ``sliding``, II (mixed) between."""

    hinging: float
    sliding: float


def fig9(cases: Path, progress: ProgressLine = lambda _: None, counts: Sequence[int] = COUNTS) -> Report:
    """Search the least thickness for each friction, the three modes and where they change.

    Parameters
    ----------
    counts: numbers of voussoirs of the look at convergence.

    Raises
    ------
    NoLoadFactorError
        If a linear program of a search fails.
    """
    scene, arch = open_arch(cases, CASE)
    progress("transitions between modes")
    hinged = least_thickness(arch, JointDefaults(friction=math.inf))
    change = Transitions(largest_obliquity(hinged.collapse), least_friction(arch))
    near = [mu + side for mu in (change.hinging, change.sliding) for side in (-_NEAR, _NEAR)]
    found: dict[float, LeastThickness] = {}
    for mu in sorted({*FRICTIONS, *near}):
        progress(f"least thickness at μ = {mu:.4g}")
        found[mu] = least_thickness(arch, JointDefaults(friction=mu))
    progress("Coulomb's flow rule at the least thickness")
    flow = pd.DataFrame([_flow_row(arch, mu, found[mu]) for mu in found if found[mu].thickness])
    progress("convergence with the number of voussoirs")
    convergence = pd.DataFrame([_convergence_row(arch, rule, n) for rule in WEIGHTS for n in counts])
    convergence = pd.concat([convergence, _continuous_rows()], ignore_index=True)
    curve = pd.DataFrame([_curve_row(arch, mu, found[mu]) for mu in found])
    report = Report(
        published_values=_published_values(scene, arch, hinged, change),
        tables={"fig9": curve, "fig9_flow_rule": flow, "fig9_convergence": convergence},
        figures={
            "fig9": draw_curve(arch, curve, change.hinging, change.sliding),
            "fig9_modes": draw_modes(_mode_results(arch, change)),
        },
        captions={
            "fig9": "Fig. 9: least thickness of the semicircular arch against friction. LPs: linear programs "
            "of the search; stands, falls: margins (in voussoir weights) at the ends of the search, within a "
            "millionth of each other. "
            "Below the transition to mode III no thickness stands",
            "fig9_modes": "The three modes, as mechanisms without dilatancy; blue: joints that slide, "
            "orange: hinges. Mode III, next to its transition, is driven by a load "
            "on the crown",
            "fig9_flow_rule": "Flow rules: least thickness with associative flow, and where the margin of "
            "exact Coulomb states vanishes; margins (in voussoir weights) 5 % thicker (none is "
            "found where all is "
            "sliding, which without dilatancy does no work against the pressure that measures the margin)",
            "fig9_convergence": "Least thickness (hinging) and transitions against the number of voussoirs",
        },
    )
    apart = float((flow["Coulomb (m)"] / flow["associative (m)"] - 1).abs().max())
    margins = [flow[f"margin, {name}"] for name in ("loop", "refined")]
    off = [float((margin / flow["margin, associative"] - 1).abs().max()) for margin in margins]
    missing = [
        f"μ = {row['μ']:g}: no margin by the {name}, 5 % thicker than the least"
        for row in flow.to_dict("records")
        for name in ("loop", "refined")
        if math.isnan(row[f"margin, {name}"])
    ]
    lps = curve.loc[curve["thickness (m)"].notna(), "LPs"]
    report.remarks += [
        f"Mode I (hinging) for μ ≥ {change.hinging:.6f}, mode II (mixed) down to {change.sliding:.6f}, mode "
        "III (sliding) below: there a mechanism of sliding alone works at every thickness, so no thickness "
        "stands and the curve ends in a vertical line.",
        f"Each thickness took {lps.min()} to {lps.max()} linear programs of a root search, the proof on "
        "either side included.",
        "Associative against Coulomb: below the least thickness no state of equilibrium exists, whatever the "
        f"flow rule; above it, the least thickness of exact Coulomb states differs by at most {apart:.1e} "
        f"(relative) over {flow['Coulomb (m)'].notna().sum()} frictions, and the margin 5 % thicker by "
        f"{off[0]:.1e} (loop) and {off[1]:.1e} (refined).",
    ]
    report.differences += [*_differences(change), *missing]
    return report


def largest_obliquity(result: Result) -> float:
    """Largest |s| / n of a result's joints: the friction below which its thrust cannot be carried.

    At the least thickness of a hinging arch the thrust is unique, so this is where mode I ends.
    """
    forces = result.joints[["n", "s"]]
    return float((forces["s"].abs() / forces["n"]).max())


def least_friction(arch: Arch) -> float:
    """Friction below which the arch slides at every thickness: where mode III begins.

    Work of a sliding mechanism is proportional to the thickness, so its sign is the same at all; it is the
    one that acts in a thick arch (here as thick as its radius).
    """
    return friction_to_stand(arch.model_copy(update={"thickness": arch.centreline}))


def mode_of(result: Result) -> str:
    """I, II or III by which rates the mechanism has."""
    joints = result.joints
    slip = float(joints["slip"].abs().max())
    turn = float((joints["rotation"].abs() * joints["length"] / 2).max())
    largest = max(slip, turn)
    if slip <= _STILL * largest:
        return "I"
    return "II" if turn > _STILL * largest else "III"


def _curve_row(arch: Arch, mu: float, found: LeastThickness) -> dict[str, object]:
    t = found.thickness
    return {
        "μ": mu,
        "mode": mode_of(found.collapse),
        "thickness (m)": or_nan(t),
        "over radius": or_nan(t) / arch.centreline,
        "LPs": found.threshold.evaluations if found.threshold else 1,
        "stands": f"{found.threshold.holds.number:+.1e}" if found.threshold else "–",
        "falls": f"{found.threshold.fails.number if found.threshold else found.collapse.required():+.1e}",
    }


def _flow_row(arch: Arch, mu: float, found: LeastThickness) -> dict[str, object]:
    joints, least = JointDefaults(friction=mu), or_nan(found.thickness)
    near, further = [least * factor for factor in _NEXT_TO_IT]
    exact = [_exact(opened_scene(arch, t, joints)) for t in (near, further)]
    thicker = opened_scene(arch, least * _THICKER, joints)
    loop = solve(thicker, "nonassociative", always=True)
    return {
        "μ": mu,
        "associative (m)": least,
        # Straight through two thicknesses so near the least that the curvature is nothing.
        "Coulomb (m)": near - exact[0] * (further - near) / (exact[1] - exact[0]),
        "margin, associative": or_nan(solve(thicker, "static").load_factor),
        "margin, loop": or_nan(loop.load_factor),
        "margin, refined": _exact(thicker),
        "loop's end": str(loop.status),
    }


def _convergence_row(arch: Arch, weights: str, voussoirs: int) -> dict[str, object]:
    arch = arch.model_copy(update={"weights": weights, "voussoirs": voussoirs})
    hinged = least_thickness(arch, JointDefaults(friction=math.inf))
    return {
        "weights": weights,
        "voussoirs": str(voussoirs),
        "over radius": or_nan(hinged.thickness) / arch.centreline,
        "I to II (μ)": largest_obliquity(hinged.collapse),
        "II to III (μ)": least_friction(arch),
    }


def _published_values(
    scene: Scene, arch: Arch, hinged: LeastThickness, change: Transitions
) -> list[PublishedValue]:
    straight = least_thickness(
        arch.model_copy(update={"weights": "straight"}), JointDefaults(friction=math.inf)
    )
    many = arch.model_copy(update={"voussoirs": MANY, "weights": "centreline"})
    limit = least_thickness(many, JointDefaults(friction=math.inf))
    return [
        published_value(scene, "least_thickness", hinged.thickness, "least thickness (m), mode I"),
        published_value(
            scene, "least_thickness_sector", hinged.thickness, "least thickness (m), annular sectors"
        ),
        published_value(
            scene, "least_thickness_straight", straight.thickness, "least thickness (m), straight edges"
        ),
        published_value(scene, "mode_I_to_II", change.hinging, "μ from mode I to II"),
        published_value(scene, "mode_II_to_III", change.sliding, "μ from mode II to III"),
        PublishedValue(
            f"least thickness (m), {MANY} voussoirs, weights along the centreline",
            0.107426 * arch.centreline,
            limit.thickness,
            LIMITS,
            1e-4,
        ),
        PublishedValue(
            f"μ from mode I to II, {MANY} voussoirs, weights along the centreline",
            0.395832,
            largest_obliquity(limit.collapse),
            LIMITS,
            1e-4,
        ),
        PublishedValue(
            f"μ from mode II to III, {MANY} voussoirs", 0.309215, least_friction(many), LIMITS, 1e-5
        ),
    ]


def _continuous_rows() -> pd.DataFrame:
    return pd.DataFrame(
        {
            "weights": weights,
            "voussoirs": "∞ (closed form)",
            "over radius": least_thickness_ratio(weights),
            "I to II (μ)": least_friction_to_hinge(weights),
            "II to III (μ)": least_friction_to_stand(),
        }
        for weights in ("sector", "centreline")
    )


def _mode_results(arch: Arch, change: Transitions) -> dict[str, Result]:
    """Mechanisms without dilatancy of arches that hardly stand, by a title."""
    crown = PointLoad(voussoir=(arch.voussoirs + 1) // 2, force=(0.0, -1.0))
    drawn = {
        "I (hinging)": (0.5, _NEXT_TO_IT[1]),
        "II (mixed)": ((change.hinging + change.sliding) / 2, _THICKER),
        "III (sliding)": (change.sliding + _ROUGHER, _THICK),
    }
    results = {}
    for mode, (mu, thicker) in drawn.items():
        joints = JointDefaults(friction=mu)
        thickness = thicker * or_nan(least_thickness(arch, joints).thickness)
        scene = opened_scene(arch, thickness, joints)
        if mode.startswith("III"):
            # Sliding does no work against the pressure: a load on the crown drives it.
            pushed = arch.model_copy(
                update={"thickness": thickness, "live": (0.0, 0.0), "point_loads": [crown]}
            )
            scene = Scene(joints=joints, blocks=pushed.blocks())
        results[f"Mode {mode}\nμ = {mu:.3f}, thickness {thickness:.3f} m"] = solve(
            scene, "nonassociative", always=True
        )
    return results


def _differences(change: Transitions) -> list[str]:
    sector, centreline = (least_friction_to_hinge(weights) for weights in ("sector", "centreline"))
    ratios = [100 * least_thickness_ratio(weights) for weights in ("sector", "centreline")]
    return [
        f"The limits {ratios[1]:.4f} % of the radius and μ = {centreline:.6f} hold for weights spread along "
        "the centreline, as closed form and many voussoirs show alike; with weights at the centroids of "
        f"annular sectors (Milankovitch) they are {ratios[0]:.4f} % and {sector:.6f}. With the paper's 27 "
        f"voussoirs mode I ends at μ = {change.hinging:.6f} (sectors); its figure is 0.396.",
    ]


def _exact(scene: Scene) -> float:
    """Load factor of an exact Coulomb state near the associative one; NaN if the refinement finds none.

    (Where all is sliding there is none: sliding without dilatancy does no work against the pressure.)
    """
    result = solve(scene, "refined", start=solve(scene, "static"))
    return float("nan") if result.stationary is None else or_nan(result.load_factor)
