"""Fig. 7 of the paper: how the loop moves between two blocks, with and without contraction."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from masonry_opt.analysis.finding import Iteration
from masonry_opt.analysis.result import Result
from masonry_opt.analysis.solve import solve
from masonry_opt.reproduce.example import Comparison, Progress, Report, open_case
from masonry_opt.reproduce.paper_loop import PAPER
from masonry_opt.reproduce.sheet import COLOURS
from masonry_opt.reproduce.two_blocks import TWO_BLOCKS
from masonry_opt.scene.scene import Scene

#: Fig. 4 (a): limits without contraction.
FLAT_LIMITS = PAPER | {"alpha": 0.0, "alpha_min": 0.0}

#: Language, solver, and what it is.
SOLVERS = (
    ("cvxpy", "clarabel", "interior point"),
    ("cvxpy", "highs-ipm", "interior point"),
    ("pyomo", "highs-ipm", "interior point"),
    ("cvxpy", "highs", "simplex"),
    ("pyomo", "highs", "simplex"),
)

#: MOSEK's λ / μ with α = 0 (section 4.1).
_MOSEK = 1.9535

#: The limits' small cohesion (1e-5 of the largest normal force) is all that may pass the interval's ends.
_NEARLY = 1e-4


@dataclass(frozen=True)
class Step:
    """The joint between A and B in a sub-problem, in the case's units.

    Attributes
    ----------
    load_factor: λ of the sub-problem, uncorrected.
    n, s: normal and shear force.
    slope, cohesion: its shear limit |s| ≤ cohesion + slope · n.
    """

    load_factor: float
    n: float
    s: float
    slope: float
    cohesion: float


def follow(scene: Scene, **options: Any) -> tuple[Result, list[Step]]:
    """Run the loop and keep what happens in the joint between A and B."""
    steps: list[Iteration] = []
    result = solve(scene, "nonassociative", progress=steps.append, **options)
    problem = result.assembly.problem
    pairs = [*zip(result.joints["first"], result.joints["second"], strict=True)]
    joint = next(number for number, pair in enumerate(pairs) if set(pair) == {"A", "B"})
    limited = int(np.flatnonzero(problem.sliding == joint)[0])
    path = []
    for step in steps:
        assert step.state is not None  # the loop shows every state it reports
        assert step.limits is not None
        cohesion = 0.0 if step.limits.cohesion is None else float(step.limits.cohesion[limited])
        path.append(
            Step(
                load_factor=step.load_factor,
                n=float(step.state.q[3 * joint]) * problem.force_unit,
                s=abs(float(step.state.q[3 * joint + 1])) * problem.force_unit,
                slope=float(step.limits.slope[limited]),
                cohesion=cohesion * problem.force_unit,
            )
        )
    return result, path


def fig7(cases: Path, progress: Progress = lambda _: None) -> Report:
    """Forces between the two blocks at every iteration, and where the loop ends without contraction.

    Parameters
    ----------
    cases: folder of the case files.
    progress: called with a line before each solve.

    Raises
    ------
    CaseError
        If a case file is missing or wrong.
    """
    scene = open_case(cases, TWO_BLOCKS)
    mu = scene.joints.friction
    report = Report(
        captions={
            "fig7": "Fig. 7: forces (dots) and shear limits (lines) between the two blocks at each iteration "
            "of the loop; the first limit is Coulomb's: (a) limits without contraction, α = 0; (b) α = 0.3 "
            "at first. (c) Where the loop ends with α = 0, by solver",
            "fig7_solvers": "Fig. 7: load factors over μ that the loop ends with, by solver",
            "fig7_steps": "Fig. 7: the joint between A and B, by iteration (Clarabel)",
        },
    )
    rows, ends = [], []
    for language, solver, kind in SOLVERS:
        progress(f"{language}, {solver}")
        start = time.perf_counter()
        flat, default = (
            solve(scene, model=language, solver=solver, **options) for options in (FLAT_LIMITS, PAPER)
        )
        seconds = time.perf_counter() - start
        value = _over(flat, mu)
        ends.append((f"{solver} ({language})", value))
        rows.append(
            {
                "model": language,
                "solver": solver,
                "kind": kind,
                "λ/μ, α = 0": value,
                "sub-problems, α = 0": len(flat.history),
                "λ/μ, α = 0.3": _over(default, mu),
                "sub-problems, α = 0.3": len(default.history),
                "time (s)": seconds,
            }
        )
        what = f"({language}, {solver}, {kind})"
        report.comparisons += [
            Comparison(f"α = 0: λ/μ {what}", (1.5, 2.5), value, "section 4.1", tolerance=_NEARLY),
            Comparison(f"α = 0.3: λ/μ {what}", 1.5, _over(default, mu), "Fig. 7 (b)", tolerance=1e-3),
        ]
    report.comparisons.append(
        Comparison(
            "α = 0: λ/μ (cvxpy, clarabel) against MOSEK's",
            _MOSEK,
            ends[0][1],
            "section 4.1, MOSEK 2.5",
            cause="every value from 1.5 to 2.5 is a solution, and which one a solver picks is its own",
        )
    )
    paths = {"α = 0": follow(scene, **FLAT_LIMITS)[1], "α = 0.3": follow(scene, **PAPER)[1]}
    report.tables = {
        "fig7_solvers": pd.DataFrame(rows),
        "fig7_steps": pd.DataFrame(
            {
                "panel": panel,
                "iteration": number,
                "λ/μ": step.load_factor / mu,
                "n": step.n,
                "s": step.s,
                "slope of the limit over μ": step.slope / mu,
                "cohesion of the limit": step.cohesion,
            }
            for panel, path in paths.items()
            for number, step in enumerate(path, start=1)
        ),
    }
    spread = [value for _, value in ends]
    report.remarks.append(
        f"Without contraction the loop ends anywhere between 1.5 μ and 2.5 μ: here from {min(spread):.4g} μ "
        f"to {max(spread):.4g} μ, by solver (the paper: {_MOSEK} μ, with MOSEK)."
    )
    report.figures["fig7"] = _draw(paths, ends, mu)
    return report


def _over(result: Result, mu: float) -> float:
    return math.nan if result.load_factor is None else result.load_factor / mu


def _draw(paths: dict[str, list[Step]], ends: list[tuple[str, float]], mu: float) -> Figure:
    figure = Figure(figsize=(8.0, 7.2), layout="constrained")
    axes = figure.subplot_mosaic([["a", "b"], ["c", "c"]], height_ratios=[1.7, 1])
    for key, (name, path) in zip("ab", paths.items(), strict=True):
        _draw_path(axes[key], path, mu)
        axes[key].set_title(f"({key}) {name}")
    _draw_ends(axes["c"], ends)
    return figure


def _draw_path(axes: Axes, path: list[Step], mu: float) -> None:
    n = np.array([0.0, 1.1])
    colours = mpl.colormaps["viridis"](np.linspace(0, 0.92, len(path)))
    for number, (step, colour) in enumerate(zip(path, colours, strict=True), start=1):
        axes.plot(n, step.cohesion + step.slope * n, color=colour, linewidth=1.3)
        axes.plot(
            step.n,
            step.s,
            "o",
            color=colour,
            markersize=8,
            markeredgecolor="white",
            zorder=3,
            label=f"{number}: λ = {step.load_factor / mu:.4f} μ",
        )
    for point, numbers in _distinct(path).items():
        axes.annotate(numbers, point, xytext=(-6, 5), textcoords="offset points", ha="right", zorder=4)
    axes.set_xlim(0, 1.1)
    axes.set_ylim(0, 0.16)
    axes.set_xlabel("normal force n (block weights)")
    axes.set_ylabel("shear force |s| (block weights)")
    axes.legend(fontsize=8, loc="upper left", ncols=2, title="iteration", frameon=False)


def _distinct(path: list[Step]) -> dict[tuple[float, float], str]:
    """Where points are told apart, the iterations there, such as "4-6"."""
    groups: list[tuple[Step, list[int]]] = []
    for number, step in enumerate(path, start=1):
        for there, numbers in groups:
            if abs(step.n - there.n) < 0.01 and abs(step.s - there.s) < 0.002:
                numbers.append(number)
                break
        else:
            groups.append((step, [number]))
    return {(there.n, there.s): _span(numbers) for there, numbers in groups}


def _span(numbers: list[int]) -> str:
    if len(numbers) > 2 and numbers[-1] - numbers[0] == len(numbers) - 1:
        return f"{numbers[0]}–{numbers[-1]}"
    return ", ".join(map(str, numbers))


def _draw_ends(axes: Axes, ends: list[tuple[str, float]]) -> None:
    axes.axvspan(1.5, 2.5, color="#EEEEEE", label="admissible: 1.5 μ to 2.5 μ")
    axes.axvline(_MOSEK, color=COLOURS[1], linestyle="--", label=f"published, MOSEK: {_MOSEK} μ")
    for row, (_, value) in enumerate(ends):
        axes.plot(value, row, "o", color=COLOURS[0], markersize=8)
        before = value < _MOSEK
        axes.annotate(
            f"{value:.4f} μ",
            (value, row),
            xytext=(-9 if before else 9, 0),
            textcoords="offset points",
            va="center",
            ha="right" if before else "left",
        )
    axes.set_yticks(range(len(ends)), [name for name, _ in ends])
    axes.set_ylim(len(ends) - 0.5, -0.5)
    axes.set_xlim(1.4, 3.0)
    axes.set_xlabel("load factor λ / μ where the loop ends with α = 0")
    axes.set_title("(c) α = 0, by solver")
    axes.legend(fontsize=8, loc="upper right")
