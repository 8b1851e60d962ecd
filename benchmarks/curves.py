"""Where do the three load factors lie beside λ over displacement? Draws docs/curves.png and prints them.

    python benchmarks/curves.py --stones 100 --seed 26 --search 60

Wall 6 of Ferris & Tin-Loi and a rubble wall: the load to expect is the plateau of method "compliant", the
least known the lowest state of method "refined" with a search of so many seconds.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.large_scenes import rubble  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.drawing.colours import BLACK, BLUE, BLUISH_GREEN, VERMILION  # noqa: E402


def draw(axes: Axes, scene: mo.Scene, title: str, search: float) -> None:
    """λ over displacement, and the three load factors as levels."""
    given = mo.solve(scene, "compliant", curve=True)
    lowest = mo.solve(scene, "refined", search=search)
    curve = given.curve
    assert curve is not None
    axes.plot(curve["displacement"], curve["load_factor"], ".-", color=BLACK, label="λ over displacement")
    for word, value, colour, dashes in (
        ("associative", given.associative, VERMILION, (1, 1)),
        ("to expect", given.expected, BLUE, (6, 2)),
        ("least known", lowest.load_factor, BLUISH_GREEN, (4, 2, 1, 2)),
    ):
        assert value is not None
        axes.axhline(value, color=colour, dashes=dashes, label=f"{word}: {value:.4f}")
        print(f"{title}, {word}: {value:.6f}")
    print(f"{title}, highest of {len(curve)} states: {curve['load_factor'].max():.6f}")
    axes.set(xscale="log", title=title, ylabel="load factor λ")
    axes.set_ylim(bottom=0)
    axes.set_xlabel("displacement of the live load,\nin what a mean contact gives under the dead load")
    axes.legend(loc="lower right", fontsize=9)


def main() -> None:
    """Draw both walls."""
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--stones", type=int, default=100)
    options.add_argument("--seed", type=int, default=26)
    options.add_argument("--search", type=float, default=60.0, help="seconds that the least is searched for")
    chosen = options.parse_args()
    wall = mo.load(ROOT / "cases" / "ferris_tinloi" / "wall_6.toml")
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
    draw(left, wall, "wall 6", chosen.search)
    scene = rubble(chosen.stones, chosen.seed)
    draw(right, scene, f"a rubble wall of {chosen.stones} stones", chosen.search)
    figure.savefig(ROOT / "docs" / "curves.png", dpi=150)


if __name__ == "__main__":
    main()
