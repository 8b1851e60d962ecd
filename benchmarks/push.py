"""How does a push go from rest to its ray? Draws docs/push.png and prints where both walls end; or prints
rows of the table in benchmarks/README.md, of walls 1 to 6, then of rubble walls of so many stones and seeds.

    python benchmarks/push.py --stones 60 --seed 341000
    python benchmarks/push.py --table 60:341000-341007 100:26 200:0 200:180001
    python benchmarks/push.py --table 60:733000-733019
    python benchmarks/push.py --sizes 20 40 80 160 320 640 --seed 752000

λ over the displacement of the live load, each step a point: wall 6 of Ferris & Tin-Loi, and a rubble wall
(tests/atlas/large_scenes.py). With --sizes docs/push_sizes.png: time of path, of a load that grows and of the
associative program, of three rubble walls of each number of stones.
"""

import argparse
import sys
import time
from itertools import product
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.large_scenes import rubble  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.answer.thresholds import PLATEAU  # noqa: E402
from masonry_opt.drawing.colours import BLACK, BLUE, ORANGE  # noqa: E402
from masonry_opt.methods.push.growth import grown  # noqa: E402
from masonry_opt.methods.push.push import Elastic  # noqa: E402
from masonry_opt.problem.assembly import assemble  # noqa: E402


def draw(axes: Axes, scene: mo.Scene, title: str) -> None:
    """The path of a scene, and its ray as a level."""
    found = Elastic(assemble(scene).problem).pushed()
    at = [step.displacement for step in found.steps]
    load_factors = [step.load_factor for step in found.steps]
    axes.plot(at, load_factors, ".-", color=BLUE, markeredgecolor=BLACK, markersize=4, linewidth=0.6)
    end = str(found.ended)
    if found.answer:
        end = f"ray at λ = {found.answer.load_factor:.4f}"
        axes.axhline(found.answer.load_factor, color=BLACK, dashes=(6, 2), linewidth=0.8)
    axes.set(xscale="symlog", title=f"{title}: {end}")
    axes.set(xlim=(0, 1e4), ylim=(0, None), ylabel="load factor λ")
    axes.set_xlabel("displacement u of the live load,\nin what a mean contact gives under the dead load")
    print(f"{title}: {len(found.steps)} steps, {found.folds} folds, at most {found.peak}: {end}")


def row(scene: mo.Scene, title: str) -> None:
    """Print where a push ends, and what it took; the load that it passes on the way if that is higher."""
    problem, began = assemble(scene).problem, time.process_time()
    found = Elastic(problem).pushed()
    seconds = time.process_time() - began
    end = found.answer and found.answer.load_factor
    passed = f"{found.peak:.5f}" if end and found.peak > end * (1 + PLATEAU) else "–"
    told = [title, problem.joints, f"{end:.5f}" if end else found.ended, len(found.steps)]
    told += [sum(step.corrections for step in found.steps), found.folds, passed, f"{seconds:.1f}"]
    print("| " + " | ".join(map(str, told)) + " |", flush=True)


def table(rubble_walls: list[str]) -> None:
    """Rows of walls 1 to 6, then of rubble walls, "stones:seed" or "stones:first-last"."""
    print("| scene | joints | λ at the ray | steps | corrections | folds | on the way up to | s |")
    for number in range(1, 7):
        row(mo.load(ROOT / "cases" / "ferris_tinloi" / f"wall_{number}.toml"), f"wall {number}")
    for walls in rubble_walls:
        stones, _, seeds = walls.partition(":")
        first, _, last = seeds.partition("-")
        for seed in range(int(first), int(last or first) + 1):
            row(rubble(int(stones), seed), f"{stones} stones, {seed}")


def sizes(stones: list[int], first: int) -> None:
    """Draw times over joints of three rubble walls each, and print them."""
    ways = {"path": (BLUE, "o"), "a load that grows": (ORANGE, "s"), "associative program": (BLACK, "x")}
    figure, axes = plt.subplots(figsize=(6.5, 4.2), layout="constrained")
    print("| stones, seed | joints | path, s | ends | grows, s | λ carried, and not | associative, s |")
    mo.solve(rubble(20, first), "static")  # what is imported first takes no time of others
    for number, seed in product(stones, range(first, first + 3)):
        scene, times = rubble(number, seed), []
        elastic = Elastic(assemble(scene).problem)
        if elastic.settled is None:
            continue
        began = time.process_time()
        found = elastic.pushed(until=1e12)
        times.append(time.process_time() - began)
        growth = grown(elastic.curve.rounded_by(0.03), lambda u, load: None)
        times.append(time.process_time() - began - times[0])
        began = time.process_time()
        mo.solve(scene, "static")
        times.append(time.process_time() - began)
        joints, unit = elastic.problem.joints, elastic.problem.live_norm
        for (colour, mark), seconds, filled in zip(
            ways.values(), times, (found.answer, True, True), strict=True
        ):
            axes.plot(joints, seconds, mark, color=colour, mfc=colour if filled else "white", markersize=5)
        loads = (growth.carried, growth.beyond) if growth else (None, None)
        told = [f"{number}, {seed}", joints, f"{times[0]:.2f}", found.ended, f"{times[1]:.2f}"]
        told += [" ".join("–" if of is None else f"{of / unit:.5f}" for of in loads), f"{times[2]:.2f}"]
        print("| " + " | ".join(map(str, told)) + " |", flush=True)
    for name, (colour, mark) in ways.items():
        axes.plot([], [], mark, color=colour, label="path to a ray" if mark == "o" else name)
        if mark == "o":
            axes.plot([], [], "o", color=BLUE, mfc="white", label="path that came to none")
    axes.set(xscale="log", yscale="log", xlabel="joints", ylabel="processor time, s")
    axes.legend()
    figure.savefig(ROOT / "docs" / "push_sizes.png", dpi=150)


def main() -> None:
    """Draw both walls, or print the table."""
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--stones", type=int, default=60)
    options.add_argument("--seed", type=int, default=341000)
    options.add_argument("--table", nargs="+", metavar="STONES:SEEDS")
    options.add_argument("--sizes", nargs="+", type=int, metavar="STONES")
    chosen = options.parse_args()
    if chosen.sizes:
        sizes(chosen.sizes, chosen.seed)
        return
    if chosen.table:
        table(chosen.table)
        return
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4.2), layout="constrained")
    draw(left, mo.load(ROOT / "cases" / "ferris_tinloi" / "wall_6.toml"), "wall 6")
    draw(right, rubble(chosen.stones, chosen.seed), f"a rubble wall of {chosen.stones} stones")
    figure.savefig(ROOT / "docs" / "push.png", dpi=150)


if __name__ == "__main__":
    main()
