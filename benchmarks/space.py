"""Measure the time and the quality of answers for blocks in space.

    python benchmarks/space.py associative         # program with friction cones, up to 5,000 blocks
    python benchmarks/space.py walls --most 100    # incremental and default, corner walls and façades
    python benchmarks/space.py sides               # polygons compared with cones: docs/space_sides.png
    python benchmarks/space.py random --seeds 50   # certified, proven to have no load factor, or open
    python benchmarks/space.py vaults              # from an OBJ file of 199 stones to the HTML page

The script prints tables in Markdown, each row as soon as it is measured. Times are processor times; set
OMP_NUM_THREADS=1.
"""

import argparse
import itertools
import re
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from atlas.random_scenes_in_space import KINDS, random_scene_in_space
from scenes_in_space import corner_wall, facade

import masonry_opt as mo
from masonry_opt.effort import Effort
from masonry_opt.problem import matrices
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import Problem
from masonry_opt.solution.acceptance import LIMITS, Kind
from masonry_opt.solution.reasons import Status
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.registry import find_solver

Size = tuple[int, int, int]
#: File of the chart that ``sides --chart`` draws.
CHART = Path(__file__).parents[1] / "docs" / "space_sides.png"
#: Sizes of scenes by their number of blocks. A corner wall has blocks along x, blocks along y, and courses. A
#: façade has a length, a depth, and courses.
CORNERS: dict[int, Size] = {
    20: (3, 2, 4),
    42: (4, 3, 6),
    100: (6, 4, 10),
    256: (10, 6, 16),
    1000: (24, 16, 25),
}
FACADES: dict[int, Size] = {13: (4, 3, 3), 33: (6, 3, 6), 68: (8, 5, 8), 231: (16, 9, 14)}
#: Sizes of corner walls of 490 and 5,000 blocks.
LARGE: list[Size] = [(21, 14, 14), (60, 40, 50)]
#: First seed of the random scenes. Larger seeds were not used for tuning.
FIRST_SEED = 30_000
#: Load factors of the lowest known exact Coulomb states of corner walls, by number of blocks and friction.
LEAST = {
    (20, 0.6): 0.2449,
    (20, 0.4): 0.2449,
    (42, 0.6): 0.18737,
    (42, 0.4): 0.18025,
    (100, 0.6): 0.11746,
    (100, 0.4): 0.11774,
}


def timed(scene: mo.Scene, method: str, **options: Any) -> tuple[mo.Result, float]:
    began = time.process_time()
    result = mo.solve(scene, method, **options)
    return result, time.process_time() - began


def row(*cells: Any) -> None:
    """Print a row of a table."""
    cells = (
        f"{cell:.5g}" if isinstance(cell, float) else "–" if cell is None else str(cell) for cell in cells
    )
    print(f"| {' | '.join(cells)} |", flush=True)


def head(*cells: str) -> None:
    row(*cells)
    row(*["---"] * len(cells))


def associative(_: argparse.Namespace) -> None:
    """Measure the time of the assembly and the time of the analysis by method ``static`` separately."""
    head(
        "blocks",
        "contact points",
        "joints",
        "assembly, s",
        "by cones, s",
        "iterations",
        "λ",
        "worst residual",
    )
    for size in [CORNERS[100], CORNERS[256], *LARGE]:
        scene = corner_wall(*size)
        began = time.process_time()
        assembly = assemble(scene)
        assembling = time.process_time() - began
        problem = assembly.problem
        result, seconds = timed(scene, "static")
        assert result.certificate is not None
        row(
            problem.blocks,
            problem.joints,
            len(assembly.joints.first),
            round(assembling, 2),
            round(seconds - assembling, 2),
            result.iterations,
            result.load_factor,
            f"{result.certificate.worst:.0e}",
        )


def walls(asked: argparse.Namespace) -> None:
    """Measure method ``incremental`` and the default, with the residual of complementarity of the default."""
    head(
        *("wall", "blocks", "μ", "associative", "incremental", "steps", "s", "default", "steps", "s"),
        *("complementarity", "over the lowest known", "how they ended"),
    )
    scenes = [("corner", corner_wall, n, size) for n, size in CORNERS.items()]
    scenes += [("façade", facade, n, size) for n, size in FACADES.items()]
    for name, make, blocks, size in scenes:
        for friction in (0.6, 0.4) if asked.least <= blocks <= asked.most else ():
            scene = make(*size, friction)
            expected, soft_seconds = timed(scene, "incremental")
            if blocks > asked.most_default:
                row(name, blocks, friction, expected.associative, expected.incremental)
                print(f"    steps {expected.iterations}, {soft_seconds:.1f} s, {codes(expected)}", flush=True)
                continue
            result, seconds = timed(scene, "coulomb")
            known = LEAST.get((blocks, friction)) if make is corner_wall else None
            over = result.load_factor / known if known and result.load_factor else None
            row(
                *(name, blocks, friction, result.associative, expected.incremental, expected.iterations),
                *(round(soft_seconds, 1), result.load_factor, result.iterations, round(seconds, 1)),
                f"{result.certificate.complementarity:.0e}" if result.certificate else None,
                over,
                f"{codes(expected)}; {codes(result)}",
            )


def codes(result: mo.Result) -> str:
    return f"{result.status}: {', '.join(reason.code for reason in result.reasons)}"


def sides(asked: argparse.Namespace) -> None:
    """Compare associative load factors of friction polygons with those of cones, all solved by Clarabel.

    Times do not include the assembly. Each row also contains the incremental load factor.
    """
    head("blocks", "μ", "sides", "associative", "below cones, %", "s", "incremental", "steps", "s")
    drawn: dict[tuple[int, float], dict[int, tuple[float, float]]] = {}
    own = matrices.SIDES
    for blocks, friction in itertools.product((20, 42, 100), (0.6, 0.4)):
        scene = corner_wall(*CORNERS[blocks], friction)
        cones, seconds = associative_of(assemble(scene).problem.by_cone)
        row(blocks, friction, "cones", cones, 0.0, round(seconds, 2))
        found = drawn[blocks, friction] = {0: (0.0, seconds)}
        for count in (8, 16, own, 32):
            matrices.SIDES = count
            polygons, seconds = associative_of(assemble(scene).problem)
            soft, soft_seconds = timed(scene, "incremental")
            found[count] = 100 * (1 - polygons / cones), seconds
            soft_cells = soft.incremental, soft.iterations, round(soft_seconds, 2)
            row(blocks, friction, count, polygons, round(found[count][0], 3), round(seconds, 2), *soft_cells)
        matrices.SIDES = own
    if asked.chart:
        chart(drawn)


def associative_of(problem: Problem) -> tuple[float, float]:
    """Return the associative load factor with the problem's friction limits, and the time of its program.

    The time includes declaring, compiling and solving the program.
    """
    clarabel = find_solver("cvxpy", None)
    began = time.process_time()
    driver = Driver(problem, "static", clarabel, Effort(), of_load=True)
    state = driver.solve().state
    assert state is not None
    return state.load_factor, time.process_time() - began


def chart(drawn: dict[tuple[int, float], dict[int, tuple[float, float]]]) -> None:
    """Draw the error of polygons over their time relative to cones, with a line for each wall."""
    figure, axes = plt.subplots(figsize=(7.5, 4.2), layout="constrained")
    # The colours of Okabe & Ito are distinct for colour-blind readers. Dashed lines have the lower friction,
    # and markers show the number of sides.
    colours = {20: "#0072B2", 42: "#D55E00", 100: "#009E73"}
    marks = {8: "o", 16: "s", matrices.SIDES: "^", 32: "D"}
    for (blocks, friction), found in drawn.items():
        longer = [found[count][1] / found[0][1] for count in marks]
        below = [found[count][0] for count in marks]
        colour, style = colours[blocks], "-" if friction == 0.6 else "--"
        axes.plot(longer, below, style, color=colour, label=f"{blocks} blocks, μ = {friction}")
        for mark, at, error in zip(marks.values(), longer, below, strict=True):
            axes.plot(at, error, mark, color=colour, mfc=colour if friction == 0.6 else "white")
    for count, mark in marks.items():
        axes.plot([], [], mark, color="black", label=f"{count} sides")
    axes.set_yscale("log")
    axes.set_yticks([0.1, 0.2, 0.5, 1, 2], ["0.1", "0.2", "0.5", "1", "2"])
    axes.set_xlabel("time of the program by polygons, over that by cones")
    axes.set_ylabel("associative λ below that by cones, %")
    axes.grid(linewidth=0.3)
    axes.legend(frameon=False, fontsize=9, ncols=2)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    figure.savefig(CHART, dpi=160)


def random(asked: argparse.Namespace) -> None:
    """Count how random scenes end with the default, and how many answers are wrong."""
    ends: dict[str, Counter[str]] = {kind: Counter() for kind in asked.kinds}
    seconds: dict[str, list[float]] = {kind: [] for kind in asked.kinds}
    for kind, seed in itertools.product(ends, range(FIRST_SEED, FIRST_SEED + asked.seeds)):
        scene = random_scene_in_space(kind, seed)
        try:
            static = mo.solve(scene, "static")
            result, took = timed(scene, "coulomb")
        except Exception as error:
            ends[kind]["wrong: raises"] += 1
            print(f"    {kind} {seed}: {type(error).__name__}: {str(error)[:300]}", flush=True)
            continue
        end = verdict(static, result)
        ends[kind][end] += 1
        seconds[kind].append(took)
        if asked.verbose or not end.startswith(("certified", "proven")):
            numbers = f"{static.load_factor} {result.incremental} {result.load_factor} {took:.1f} s"
            size = result.assembly.problem.blocks
            print(
                f"    {kind} {seed}: {end}; {size} blocks; {numbers}; {codes(static)}; {codes(result)}",
                flush=True,
            )
    head(
        "kind",
        *(names := sorted({end for of_kind in ends.values() for end in of_kind})),
        "median s",
        "most s",
    )
    for kind, counts in ends.items():
        spent = seconds[kind] or [0.0]
        row(kind, *(counts[name] for name in names), float(np.median(spent)), max(spent))


def verdict(static: mo.Result, result: mo.Result) -> str:
    """Return the verdict on an answer: certified, proven to have no load factor, open, or wrong.

    A Coulomb state is wrong if its load factor is above the associative one, or if the static program finds
    the scene unstable. The status "unstable" is wrong if the static program has a load factor.
    """
    falls = [each.status is Status.UNSTABLE for each in (static, result)]
    if result.certificate is None:
        if falls[1] and static.load_factor is not None:
            return "wrong: falls"
        return "proven none" if falls[1] or result.solution.proven_none else f"open: {result.status}"
    assert result.load_factor is not None
    if falls[0] or (static.load_factor and result.load_factor > static.load_factor * (1 + 1e-6) + 1e-6):
        return "wrong: above associative"
    exact = result.certificate.worst < LIMITS[Kind.EXACT].complementarity
    return "certified, exact" if exact else "certified, rougher"


def vaults(_: argparse.Namespace) -> None:
    """Measure the time from an OBJ file to the HTML page for barrel vaults of 199 stones.

    Coordinates of the file have three decimals. The vaults are pushed along, across or diagonally.
    """
    head("thickness", "μ", "pushed", "read, s", "solve, s", "page, s", "λ", "incremental", "associative")
    for thickness, friction, live in (
        (0.35, 0.4, (1.0, 0.0, 0.0)),
        (0.35, 0.4, (0.7, 0.7, 0.0)),
        (0.6, 0.4, (0.0, 1.0, 0.0)),
        (0.6, 0.4, (0.7, 0.7, 0.0)),
        (0.45, 0.35, (0.5, 0.87, 0.0)),
    ):
        vault = mo.Barrel(
            span=4, rise=1.5, thickness=thickness, voussoirs=21, length=4.5, stone=0.5, unit_weight=20
        )
        drawn = mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=vault.blocks())
        with TemporaryDirectory() as folder:
            mesh = Path(folder, "vault.obj")
            mo.export(drawn, mesh)
            text = re.sub(r"-?\d+\.\d+", lambda number: f"{float(number[0]):.3f}", mesh.read_text())
            mesh.write_text(text)
            began = time.process_time()
            scene = mo.read_mesh(mesh, unit_weight=20, live=live, friction=friction)
            reading = time.process_time() - began
            result, seconds = timed(scene, "coulomb")
            began = time.process_time()
            result.save(Path(folder, "vault.html"))
            drawing = time.process_time() - began
        load_factors = result.load_factor, result.incremental, result.associative
        row(
            thickness,
            friction,
            live,
            *(round(part, 1) for part in (reading, seconds, drawing)),
            *load_factors,
        )


PARTS: dict[str, Callable[[argparse.Namespace], None]] = {
    part.__name__: part for part in (associative, walls, sides, random, vaults)
}

if __name__ == "__main__":
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("--least", type=int, default=0, help="fewest blocks of a wall")
    parser.add_argument("--most", type=int, default=256, help="most blocks of a wall")
    parser.add_argument("--most-default", type=int, default=256, help="most blocks for the default method")
    parser.add_argument("--seeds", type=int, default=50, help="random scenes of each kind")
    parser.add_argument("--kinds", nargs="*", choices=KINDS, default=list(KINDS), help="of random scenes")
    parser.add_argument("--chart", action="store_true", help="write docs/space_sides.png")
    parser.add_argument("--verbose", "-v", action="store_true", help="a line a random scene")
    asked = parser.parse_args()
    # The first solve imports modules, so it is not measured.
    mo.solve(corner_wall(1, 1, 1))
    PARTS[asked.part](asked)
