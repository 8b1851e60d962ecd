"""Section 6.5 of the paper: dilatancy that falls with normal stress, and a check of associative answers.

Two blocks by hand. Let dilatancy be whole up to the stress full and vanish from the stress none on, in the
face between A and B (length 1, normal force n) and under A (length 3, normal force 1 + n), so that
λ = μ (n + 1 + n). B rises, n = 0.75, while either dilates; it sinks, n = 0.25, only if both contract;
it rests, with any n in between, where neither does: where n and (1 + n) / 3 are at least none. The least is

    λ = μ (1 + 2 n),    n = max(none, 3 none - 1), but at least 0.25 and at most 0.75:

what was a jump at φ₀ = 0 is a rise from none = 0.25 to none = 1.75 / 3.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from masonry_opt.analysis import solve
from masonry_opt.answer.result import Result
from masonry_opt.explain.stressed_joints import stressed_joints
from masonry_opt.report.pictures.mechanism import draw_mechanism, legend_handles
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.cases import open_case, with_joints
from masonry_opt.studies.palette import COLOURS
from masonry_opt.studies.paper.example import (
    Basis,
    ProgressLine,
    PublishedValue,
    Report,
    load_factor_text,
    or_nan,
)
from masonry_opt.studies.paper.table1 import wall_file
from masonry_opt.studies.paper.two_blocks import TWO_BLOCKS

#: Stresses at which dilatancy vanishes; it is whole up to half of each. Block weights per unit of length.
_LEVELS = (1e-4, 0.03, 0.1, 0.2, 0.3, 0.4, 0.5, 0.55, 0.7, 1.0, 2.0, 3.0, 10.0, 100.0)

#: Dilatancy of wall 1 at low stress, beside one equal to friction, 0.65: real joints dilate little.
_REAL = 0.05

#: The wall whose associative answer is checked, and the stress above which joints are taken not to dilate.
_CHECKED, _TOO_HIGH = 6, 1.0

#: Stresses above which the check counts the sliding joints.
_ABOVE = (0.0, 0.25, 0.5, 1.0, 2.0, 4.0)

#: Relative error of the loop, which ends where λ stands still.
_LOOP = 1e-3

#: Departure from the flow rule, over the largest velocity, above which an answer does not obey the law.
_MOST_OFF_FLOW = 1e-2

_SOURCE = "computed here, of joints without the law"

#: Why the least level need not give Coulomb's answer.
_UNLOADED = "a joint without any force dilates all the same, however low the stress at which it ceases to"


def with_law(scene: Scene, dilatancy: float, none: float) -> Scene:
    """The scene with dilatancy in every joint: whole up to half the stress ``none``, gone from there on."""
    return with_joints(scene, dilatancy=dilatancy, dilatancy_stress=(none / 2, none))


def by_hand(friction: float, none: float) -> float:
    """Least load factor of the two blocks (see above)."""
    normal = min(max(none, 3 * none - 1, 0.25), 0.75)
    return friction * (1 + 2 * normal)


def dilatancy(cases: Path, progress: ProgressLine = lambda _: None) -> Report:
    """Load factor against the stress at which dilatancy vanishes; joints too stressed to dilate."""
    blocks, wall = open_case(cases, TWO_BLOCKS), open_case(cases, wall_file(1))
    checked = open_case(cases, wall_file(_CHECKED))
    report = Report(
        captions={
            "dilatancy": "Load factor against the stress at which dilatancy vanishes (it is whole up to "
            "half of it). Hollow: an answer whose certificate shows a departure from the flow rule of more "
            f"than {_MOST_OFF_FLOW:g}; a cross: the loop found no answer",
            "dilatancy_law": "The loop with dilatancy that falls with stress. 'off the law': of sliding "
            "joints, the largest difference between the dilatancy of the answer and the law's for its stress",
            "dilatancy_joints": f"Wall {_CHECKED}, associative: sliding joints stressed above so much; the "
            "energy that goes into their dilation, in units of λ",
            "dilatancy_check": f"Wall {_CHECKED}, associative: sliding joints whose mean normal stress "
            f"exceeds {_TOO_HIGH:g} block weight per unit of length",
        }
    )
    friction = blocks.joints.friction
    named = {
        "two blocks": (blocks, friction),
        f"wall 1, dilatancy {_REAL:g}": (wall, _REAL),
        "wall 1, dilatancy μ": (wall, wall.joints.friction),
    }
    rows: list[dict[str, object]] = []
    limits: dict[str, tuple[float | None, float | None]] = {}
    for name, (scene, most) in named.items():
        progress(f"{name}: Coulomb, and the same dilatancy at any stress")
        limits[name] = _limits(scene, most)
        sweep = []
        for none in _LEVELS:
            progress(f"{name}: none from stress {none:g} on")
            sweep.append(_row(name, none, solve(with_law(scene, most, none), "nonassociative")))
        report.published_values += _ends(name, limits[name], sweep)
        report.remarks.append(_order(name, sweep))
        rows += sweep
    table = pd.DataFrame(rows)
    hand = [by_hand(friction, none) for none in table["none from"]]
    table.insert(2, "by hand", np.where(table["scene"] == "two blocks", hand, np.nan))
    report.differences = _differences(table)
    progress(f"wall {_CHECKED}: associative")
    associative = solve(checked, "static")
    report.tables = {"dilatancy_law": table, "dilatancy_joints": _joint_table(associative)}
    coulomb = solve(checked, "nonassociative")
    report.remarks.append(_verdict(associative, coulomb))
    report.figures = {
        "dilatancy": _draw(table, limits, friction),
        "dilatancy_check": _draw_check(associative),
    }
    return report


def _limits(scene: Scene, most: float) -> tuple[float | None, float | None]:
    """Load factors without dilatancy, and with the same at any stress."""
    associative = most == scene.joints.friction
    at_any = scene if associative else with_joints(scene, dilatancy=most)
    return solve(scene, "nonassociative").load_factor, solve(
        at_any, "static" if associative else "nonassociative"
    ).load_factor


def _row(name: str, none: float, result: Result) -> dict[str, object]:
    return {
        "scene": name,
        "none from": none,
        "λ": or_nan(result.load_factor),
        "sub-problems": len(result.history),
        "off the law": off_the_law(result),
        "flow": float("nan") if result.certificate is None else result.certificate.flow,
        "status": str(result.status),
        "time (s)": sum(result.seconds.values()),
    }


def off_the_law(result: Result) -> float:
    """Largest difference, among sliding joints, of the dilatancy an answer claims and the law's for its
    normal forces; NaN without an answer."""
    solution, problem = result.solution, result.assembly.problem
    if result.load_factor is None or solution.q is None or solution.slope is None:
        return float("nan")
    slides = result.joints["slip"].abs() > 1e-4 * result.blocks[["vx", "vy"]].abs().to_numpy().max()
    off = np.abs(problem.dilatancy_at(problem.normal_forces(solution.q)) - solution.slope)
    return float(off[slides.to_numpy()[problem.sliding]].max(initial=0.0))


def _ends(
    name: str, limits: tuple[float | None, float | None], sweep: list[dict[str, object]]
) -> list[PublishedValue]:
    """The law's two limits, against answers for joints without the law."""
    found = []
    ends = (("lowest level: Coulomb", 0), ("highest level: the same dilatancy at any stress", -1))
    for limit, (words, index) in zip(limits, ends, strict=True):
        computed = sweep[index]["λ"]
        assert isinstance(computed, float)
        if limit is None:
            continue
        # Every joint of the two blocks is loaded.
        exempt = index == 0 and name != "two blocks"
        found.append(
            PublishedValue(
                f"{name}, {words}",
                limit,
                None if np.isnan(computed) else computed,
                _SOURCE,
                tolerance=None if exempt else _LOOP,
                cause=_UNLOADED if exempt else "",
                basis=Basis.COMPUTED,
            )
        )
    return found


def _order(name: str, sweep: list[dict[str, object]]) -> str:
    values = pd.Series([row["λ"] for row in sweep], dtype=float).dropna()
    rises = bool((values.diff().dropna() >= -_LOOP * values.abs().max()).all())
    return (
        f"{name}: λ {'rises' if rises else 'does not rise steadily'} with the stress at which dilatancy "
        f"vanishes, from {values.iloc[0]:.5f} to {values.iloc[-1]:.5f}."
    )


def _differences(table: pd.DataFrame) -> list[str]:
    found = []
    for name, rows in table.groupby("scene", sort=False):
        ended = rows["λ"].notna()
        if not ended.all():
            levels = ", ".join(f"{none:g}" for none in rows["none from"][~ended])
            found.append(
                f"{name}: the loop finds no answer where dilatancy vanishes from a stress of {levels} on. A "
                "joint that dilates takes up force and so stops dilating, then loses it again: linear "
                "programs answer with the one or the other, and no blend of their forces settles between."
            )
        off = rows[rows["off the law"] > _LOOP]
        if len(off):
            found.append(
                f"{name}: {len(off)} of {int(ended.sum())} answers hold a sliding joint whose dilatancy is "
                f"not the law's for its final stress, by up to {off['off the law'].max():.2g}: the loop "
                "takes the law at its last sub-problem's forces, and the exact state at its end has others."
            )
        rough = rows[rows["flow"] > _MOST_OFF_FLOW]
        if len(rough):
            found.append(
                f"{name}: {len(rough)} of {int(ended.sum())} answers depart from the flow rule by up to "
                f"{rough['flow'].max():.2g} of the largest velocity (the certificate says so), where the "
                "loop stopped for λ alone standing still."
            )
    hand = table.dropna(subset=["by hand", "λ"])
    above = hand[(hand["λ"] / hand["by hand"] - 1).abs() > _LOOP]
    found += [
        f"two blocks, none from {row['none from']:g} on: the loop ends at {row['λ']:.5f}, by hand "
        f"{row['by hand']:.5f}; departure from the flow rule {row['flow']:.1e}."
        for row in above.to_dict("records")
    ]
    return found


def _joint_table(associative: Result) -> pd.DataFrame:
    rows: list[dict[str, object]] = []
    for above in _ABOVE:
        joints = stressed_joints(associative, above).sort_values("stress")
        energy = float(joints["energy"].sum())
        highest = joints.to_dict("records")[-1:]
        rows.append(
            {
                "stress above": above,
                "sliding joints": len(joints),
                "energy": energy,
                "of λ (%)": f"{100 * energy / associative.load_factor:.1f}"
                if associative.load_factor
                else "–",
                "highest stress": float(joints["stress"].max()),
                "the highest": " – ".join(f"{joint['first']} – {joint['second']}" for joint in highest),
            }
        )
    return pd.DataFrame(rows)


def _verdict(associative: Result, coulomb: Result) -> str:
    joints = stressed_joints(associative, _TOO_HIGH)
    if associative.load_factor is None or coulomb.load_factor is None:
        return f"Wall {_CHECKED}: no load factor to check."
    return (
        f"Wall {_CHECKED}: {len(joints)} sliding joints of the associative answer are stressed above "
        f"{_TOO_HIGH:g}; {joints['energy'].sum():.3f} of λ = {associative.load_factor:.3f} goes into their "
        "dilation. "
        f"The loop, without dilatancy, ends {associative.load_factor - coulomb.load_factor:.3f} lower."
    )


def _draw(
    table: pd.DataFrame, limits: dict[str, tuple[float | None, float | None]], friction: float
) -> Figure:
    figure = Figure(figsize=(8.0, 9.0), layout="constrained")
    panels = figure.subplots(len(limits), 1, sharex=True)
    for axes, (name, (lower, upper)) in zip(panels, limits.items(), strict=True):
        rows = table[table["scene"] == name]
        if name == "two blocks":
            stress = np.geomspace(_LEVELS[0], _LEVELS[-1], 2000)
            hand = [by_hand(friction, none) for none in stress]
            axes.plot(stress, hand, color="#777777", linewidth=1, label="by hand: the least")
        rough = rows["flow"] > _MOST_OFF_FLOW
        axes.plot(rows["none from"][~rough], rows["λ"][~rough], "o", color=COLOURS[0], label="loop")
        if rough.any():
            axes.plot(
                rows["none from"][rough],
                rows["λ"][rough],
                "o",
                color=COLOURS[0],
                markerfacecolor="white",
                label="loop, off the flow rule",
            )
        for level, style, label in ((lower, "--", "Coulomb"), (upper, ":", "one dilatancy at any stress")):
            if level is not None:
                axes.axhline(level, color="black", linewidth=1, linestyle=style, label=label, zorder=0)
        missing = rows["none from"][rows["λ"].isna()]
        if len(missing):
            foot = [axes.get_ylim()[0]] * len(missing)
            axes.plot(missing, foot, "x", color=COLOURS[1], clip_on=False, label="no answer")
        axes.set_title(name, loc="left", fontsize=10)
        axes.set_ylabel("load factor λ")
        axes.grid(color="#EEEEEE")
        axes.legend(fontsize=8, loc="center right")
    panels[-1].set_xscale("log")
    panels[-1].set_xlabel("stress at which dilatancy vanishes (block weights per unit of length)")
    return figure


def _draw_check(associative: Result) -> Figure:
    figure = Figure(figsize=(6.5, 7.0), layout="constrained")
    axes = figure.subplots()
    draw_mechanism(associative, axes, marked=set(stressed_joints(associative, _TOO_HIGH).index))
    axes.set_title(f"Wall {_CHECKED}, associative: {load_factor_text(associative)}")
    axes.set_axis_off()
    handles = legend_handles(associative, f"sliding, stressed above {_TOO_HIGH:g}")
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
    return figure
