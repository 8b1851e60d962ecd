"""Measure the answers and the time of the default method on scenes that were not used for tuning.

    python benchmarks/goals.py --stones 60 200 600 --seeds 20 --lines build/goals.csv
    python benchmarks/goals.py --stones --small 125
    python benchmarks/goals.py --draw build/goals.csv

The scenes are rubble walls with the given numbers of stones, and small random scenes of the four kinds of
tests/atlas. The script prints a line for each set of scenes:

- how many scenes have a certified state, how exact the state is, and how the others end
- how many scenes have an incremental load factor, with an exact state or as a range
- the processor time divided by that of the associative program, scene by scene in one run

With --lines each scene adds a line to a file. --draw makes build/sizes.png of the rubble walls in such files.
"""

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.large_scenes import rubble  # noqa: E402
from atlas.random_scenes import KINDS, random_scene  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.drawing.colours import BLACK, BLUE, ORANGE, SKY_BLUE  # noqa: E402
from masonry_opt.solution.reasons import Code  # noqa: E402

#: First seed of the scenes. Larger seeds were not used for tuning.
FIRST_SEED = 30_000

#: Seed of a small random scene without a load factor, which is solved before the measurement.
JAMMED = 100

#: Kinds of states, and the largest residual of complementarity of each kind, divided by λ.
EXACT = {"exact to 1e-08 λ": 1e-8, "to 1e-06": 1e-6, "to 1e-05": 1e-5}

#: Colours of outcomes, from the best on. The rest of a bar has no colour.
ENDS = {"exact state": BLUE, "range": SKY_BLUE}
STATES = dict(zip(EXACT, (BLUE, SKY_BLUE, ORANGE), strict=True))


def timed(scene: mo.Scene, **options: Any) -> tuple[mo.Result, float]:
    began = time.process_time()
    result = mo.solve(scene, **options)
    return result, time.process_time() - began


def how_exact(result: mo.Result) -> str:
    """Return the kind of the state (a key of ``EXACT``, or "rough"), or the status if there is no state."""
    if result.load_factor is None or result.certificate is None:
        return f"none: {result.status}" + ("" if result.solution.proven_none else ", not proven")
    left = result.certificate.complementarity / max(abs(result.load_factor), 1e-2)
    return next((name for name, most in EXACT.items() if left <= most), "rough")


def line(name: str, stones: int, seed: int, scene: mo.Scene) -> dict[str, Any]:
    """Return the answer and the time of the default for a scene; ``stones`` is 0 for a small random scene."""
    _, static = timed(scene, method="static")
    result, seconds = timed(scene)
    codes = [said.code for said in result.incremental_reasons]
    sure, off = ENDS
    if result.incremental is not None:
        ended = sure if Code.COLLAPSE in codes else off
    else:
        ended = f"none: {', '.join(codes) or result.status}"
    return {
        "scenes": name,
        "stones": stones,
        "seed": seed,
        "joints": result.size.joints,
        "state": how_exact(result),
        "ended": ended,
        "load_factor": result.load_factor,
        "incremental": result.incremental,
        "associative": result.associative,
        "steps": result.iterations,
        "seconds": seconds,
        "static_seconds": static,
        "message": result.message,
    }


def scenes(asked: argparse.Namespace) -> Iterator[tuple[str, int, int, mo.Scene]]:
    for stones in asked.stones:
        for seed in range(asked.first, asked.first + asked.seeds):
            yield f"rubble of {stones}", stones, seed, rubble(stones, seed)
    for kind in KINDS if asked.small else ():
        for seed in range(asked.first, asked.first + asked.small):
            yield kind, 0, seed, random_scene(kind, seed)


def tell(lines: pd.DataFrame) -> None:
    """Print a line for each set of scenes."""
    for name, of in lines.groupby("scenes", sort=False):
        states, expected = (of[column].value_counts().to_dict() for column in ("state", "ended"))
        ratio = of["seconds"] / of["static_seconds"]
        print(f"{name} ({len(of)}): {states}; incremental: {expected};", end=" ")
        print(f"time × {ratio.median():.1f}, half {ratio.quantile(0.25):.1f} to", end=" ")
        print(f"{ratio.quantile(0.75):.1f}, at most {ratio.max():.0f}")


def draw(lines: pd.DataFrame, file: Path) -> None:
    """Draw the shares of answers and the time over the size of rubble walls, and save the picture."""
    rubbles = lines[lines["stones"] > 0].assign(ratio=lines["seconds"] / lines["static_seconds"])
    by_size = rubbles.groupby("stones")
    names = [f"{size:,}\n({len(of)})" for size, of in by_size]
    figure, (expected, states, times) = plt.subplots(1, 3, figsize=(10, 4.4), layout="constrained")
    for axes, column, colours in ((expected, "ended", ENDS), (states, "state", STATES)):
        shares = 100 * by_size[column].value_counts(normalize=True).unstack(fill_value=0.0)
        _stack(axes, names, shares.reindex(columns=list(colours), fill_value=0.0), colours)
    expected.set_title("an incremental load factor")
    states.set_title("a certified state")
    for place, (_, of) in enumerate(by_size):
        low, median, high = of["ratio"].quantile([0.25, 0.5, 0.75])
        times.plot([place] * len(of), of["ratio"], "_", color=SKY_BLUE, zorder=1)
        times.plot([place] * 2, [low, high], color=BLUE, linewidth=5, solid_capstyle="butt", zorder=2)
        times.plot(place, median, "o", color="white", markeredgecolor=BLACK, zorder=3)
        times.annotate(f"{median:.0f}", (place, median), (9, -4), textcoords="offset points")
    times.set(yscale="log", title="time", ylabel="processor time over the associative")
    times.set_xticks(range(len(names)), names)
    times.set_yticks(ticks := [5, 10, 20, 50, 100, 200], [f"× {tick}" for tick in ticks])
    times.minorticks_off()
    times.margins(x=0.15)
    times.legend(
        handles=[*times.lines[:2], times.lines[2]],
        labels=["a wall", "middle half", "median"],
        loc="upper center",
        bbox_to_anchor=(0.5, -0.13),
        frameon=False,
    )
    figure.supxlabel("stones of a rubble wall (and how many walls)", fontsize=10)
    figure.savefig(file, dpi=150)


def _stack(axes: Axes, names: list[str], shares: pd.DataFrame, colours: dict[str, str]) -> None:
    """Draw stacked bars with the share of each outcome in per cent."""
    top = shares.cumsum(axis=1)
    for name, colour in colours.items():
        axes.bar(names, shares[name], bottom=top[name] - shares[name], color=colour, width=0.7, label=name)
    axes.set(ylim=(0, 100), ylabel="share of walls (%)")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), frameon=False)


def main(asked: argparse.Namespace) -> None:
    if asked.draw:
        lines = pd.concat(map(pd.read_csv, asked.draw))
        draw(lines, ROOT / "build" / "sizes.png")
        tell(lines)
        return
    # The first solve imports modules, such as Pyomo for a proof that no state exists. It is not measured.
    line("", 0, 0, random_scene("tessellation", JAMMED))
    found = []
    for given in scenes(asked):
        found.append(line(*given))
        if asked.lines:
            begun = asked.lines.exists()
            pd.DataFrame(found[-1:]).to_csv(asked.lines, mode="a", header=not begun, index=False)
    tell(pd.DataFrame(found))


if __name__ == "__main__":
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("--stones", type=int, nargs="*", default=[60, 200], help="sizes of rubble walls")
    parser.add_argument("--seeds", type=int, default=20, help="walls of each size")
    parser.add_argument("--small", type=int, default=0, help="small random scenes of each kind")
    parser.add_argument("--first", type=int, default=FIRST_SEED, help="the first seed")
    parser.add_argument("--lines", type=Path, metavar="FILE", help="CSV to which each scene adds a line")
    parser.add_argument("--draw", type=Path, nargs="+", metavar="FILE", help="draw such lines, solve nothing")
    main(parser.parse_args())
