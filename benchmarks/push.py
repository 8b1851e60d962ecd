"""How does a push go from rest to its ray? Draws docs/push.png and prints where both walls end.

    python benchmarks/push.py --stones 60 --seed 341000

λ over the displacement of the live load, each step a point: wall 6 of Ferris & Tin-Loi, and a rubble wall
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
from masonry_opt.drawing.colours import BLACK, BLUE  # noqa: E402
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


def main() -> None:
    """Draw both walls."""
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--stones", type=int, default=60)
    options.add_argument("--seed", type=int, default=341000)
    chosen = options.parse_args()
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4.2), layout="constrained")
    draw(left, mo.load(ROOT / "cases" / "ferris_tinloi" / "wall_6.toml"), "wall 6")
    draw(right, rubble(chosen.stones, chosen.seed), f"a rubble wall of {chosen.stones} stones")
    figure.savefig(ROOT / "docs" / "push.png", dpi=150)


if __name__ == "__main__":
    main()
