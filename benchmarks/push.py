"""How does a push go from event to event? Draws docs/push.png and prints where both walls end.

    python benchmarks/push.py --stones 60 --seed 341002

λ over the displacement of the live load, each event a point: wall 6 of Ferris & Tin-Loi, and a rubble wall
(tests/atlas/large_scenes.py).
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
from masonry_opt.drawing.colours import BLACK, BLUE, BLUISH_GREEN, ORANGE, VERMILION  # noqa: E402
from masonry_opt.methods.push.push import push  # noqa: E402
from masonry_opt.problem.assembly import assemble  # noqa: E402

#: What joints do at events, with their colours.
COLOURS = {"slides": BLUE, "sticks": ORANGE, "opens": VERMILION, "closes": BLUISH_GREEN}


def draw(axes: Axes, scene: mo.Scene, title: str) -> None:
    """The path of a scene, and its ray as a level."""
    problem = assemble(scene).problem
    found = push(problem)
    assert found.load_factor is not None
    at = [0.0, *(event.at for event in found.events)]
    load_factors = [0.0, *(event.load_factor for event in found.events)]
    far = 3 * max(at)
    axes.plot([*at, far], [*load_factors, load_factors[-1]], color=BLACK, linewidth=0.6)
    does = [event.what for event in found.events]
    axes.scatter(at[1:], load_factors[1:], s=7, c=[COLOURS[what] for what in does], zorder=3)
    for what, colour in COLOURS.items():
        axes.scatter([], [], s=25, color=colour, label=f"{what} ({does.count(what)})")
    axes.axhline(found.load_factor, color=BLACK, dashes=(6, 2), linewidth=0.8)
    axes.set(xscale="symlog", title=f"{title}: ray at λ = {found.load_factor:.4f}")
    axes.set(xlim=(0, far), ylim=(0, None), ylabel="load factor λ")
    axes.set_xlabel("displacement u of the live load,\nin what a mean contact gives under the dead load")
    axes.legend(loc="lower right", fontsize=9)
    print(f"{title}: {len(found.events)} events, {found.folds} folds, at most {found.peak}", end=" ")
    print(f"on the way to {found.load_factor}")


def main() -> None:
    """Draw both walls."""
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--stones", type=int, default=60)
    options.add_argument("--seed", type=int, default=341002)
    chosen = options.parse_args()
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4.2), layout="constrained")
    draw(left, mo.load(ROOT / "cases" / "ferris_tinloi" / "wall_6.toml"), "wall 6")
    draw(right, rubble(chosen.stones, chosen.seed), f"a rubble wall of {chosen.stones} stones")
    figure.savefig(ROOT / "docs" / "push.png", dpi=150)


if __name__ == "__main__":
    main()
