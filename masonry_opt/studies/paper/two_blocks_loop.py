"""Fig. 7 of the paper: how the loop moves between two blocks, with and without contraction."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from masonry_opt.analysis import solve
from masonry_opt.answer.result import Result
from masonry_opt.answer.solution import Solution
from masonry_opt.methods.loop.history import Iteration
from masonry_opt.methods.loop.method import nonassociative
from masonry_opt.methods.loop.options import LoopOptions
from masonry_opt.methods.task import Task
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.scene import Scene
from masonry_opt.solvers.registry import find_solver
from masonry_opt.studies.cases import open_case
from masonry_opt.studies.palette import COLOURS
from masonry_opt.studies.paper.example import ProgressLine, PublishedValue, Report, or_nan
from masonry_opt.studies.paper.two_blocks import TWO_BLOCKS

#: Fig. 4 (a): limits without contraction.
FLAT_LIMITS: dict[str, Any] = {"preset": "paper", "alpha": 0.0, "alpha_min": 0.0}


@dataclass(frozen=True)
class SolverChoice:
    """A solver, its modelling language, and whether it may presolve.

    Attributes
    ----------
    language, name: of the solver.
    kind: what it is.
    presolve: whether HiGHS may reduce the problem first, which leaves little of so small a one.
    """

    language: str
    name: str
    kind: str
    presolve: bool = True

    @property
    def label(self) -> str:
        """In words."""
        return f"{self.name} ({self.language}{'' if self.presolve else ', no presolve'})"


SOLVERS = (
    SolverChoice("cvxpy", "clarabel", "interior point"),
    SolverChoice("cvxpy", "highs-ipm", "interior point", presolve=False),
    SolverChoice("cvxpy", "highs-ipm", "interior point"),
    SolverChoice("pyomo", "highs-ipm", "interior point"),
    SolverChoice("cvxpy", "highs", "simplex", presolve=False),
    SolverChoice("cvxpy", "highs", "simplex"),
    SolverChoice("pyomo", "highs", "simplex"),
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


def end_of_loop(scene: Scene, choice: SolverChoice, **options: Any) -> Solution:
    """Where the loop ends with a solver."""
    solver = find_solver(choice.language, choice.name)
    if not choice.presolve:
        solver = replace(solver, options=solver.options | {"presolve": "off"})
    return nonassociative(Task(assemble(scene).problem, solver, LoopOptions(**options)))


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
        assert step.solved is not None  # the loop shows every sub-problem that it reports
        assert step.solved.state is not None
        n, s, _ = step.solved.state.q.reshape(3, -1)
        limits = step.solved.limits
        path.append(
            Step(
                load_factor=step.load_factor,
                n=float(n[joint]) * problem.force_unit,
                s=abs(float(s[joint])) * problem.force_unit,
                slope=float(limits.slope[limited]),
                cohesion=float(limits.cohesion[limited]) * problem.force_unit,
            )
        )
    return result, path


def fig7(cases: Path, progress: ProgressLine = lambda _: None) -> Report:
    """Forces between the two blocks at every iteration, and where the loop ends without contraction."""
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
    for choice in SOLVERS:
        progress(choice.label)
        start = time.perf_counter()
        flat = end_of_loop(scene, choice, **FLAT_LIMITS)
        default = end_of_loop(scene, choice, preset="paper")
        seconds = time.perf_counter() - start
        value, contracting = (or_nan(end.load_factor) / mu for end in (flat, default))
        ends.append((choice.label, value))
        rows.append(
            {
                "solver": choice.label,
                "kind": choice.kind,
                "λ/μ, α = 0": value,
                "sub-problems, α = 0": len(flat.history),
                "λ/μ, α = 0.3": contracting,
                "sub-problems, α = 0.3": len(default.history),
                "time (s)": seconds,
            }
        )
        report.published_values += [
            PublishedValue(
                f"α = 0: λ/μ, {choice.label}", (1.5, 2.5), value, "section 4.1", tolerance=_NEARLY
            ),
            PublishedValue(f"α = 0.3: λ/μ, {choice.label}", 1.5, contracting, "Fig. 7 (b)", tolerance=1e-3),
        ]
    report.published_values.append(
        PublishedValue(
            "α = 0: λ/μ, clarabel against MOSEK",
            _MOSEK,
            ends[0][1],
            "section 4.1, MOSEK 2.5",
            cause="every value from 1.5 to 2.5 is a solution, and which one a solver picks is its own",
        )
    )
    paths = {"α = 0": follow(scene, **FLAT_LIMITS)[1], "α = 0.3": follow(scene, preset="paper")[1]}
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


def _draw(paths: dict[str, list[Step]], ends: list[tuple[str, float]], mu: float) -> Figure:
    figure = Figure(figsize=(8.0, 7.2), layout="constrained")
    grid = figure.add_gridspec(2, 1, height_ratios=[1.5, 1])
    above, below = figure.add_subfigure(grid[0]), figure.add_subfigure(grid[1])
    for axes, letter, (name, path) in zip(above.subplots(1, 2), "ab", paths.items(), strict=True):
        _draw_path(axes, path, mu)
        axes.set_title(f"({letter}) {name}")
    _draw_ends(below.subplots(), ends)
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
