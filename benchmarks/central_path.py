"""How does the load factor change along the path that a pass follows? Draws docs/central_path.png and prints
the folds.

    python benchmarks/central_path.py --stones 60 --seed 101

The path is that of ``masonry_opt/methods/mcp/central_path.py``, which the default follows where no pass leads
to a state.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import NullFormatter

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.large_scenes import large_scene  # noqa: E402

from masonry_opt.drawing.colours import BLACK, BLUE, ORANGE, VERMILION  # noqa: E402
from masonry_opt.methods.mcp.central_path import CentralPath  # noqa: E402
from masonry_opt.methods.mcp.passes import Passes  # noqa: E402
from masonry_opt.methods.mcp.schedule import NewtonStep  # noqa: E402
from masonry_opt.problem.assembly import assemble  # noqa: E402

#: How far beyond the last two folds the picture's second half goes, as a factor on the gap.
NEARBY = 3.0


def draw(points: np.ndarray, steps: list[NewtonStep], file: Path) -> None:
    """λ against the gap: of the path with its folds, and of a pass's steps.

    Parameters
    ----------
    points: energy over the live load's work at λ = 1, and λ, of each centre, shape (centres, 2).
    """
    end = points[-1, 1]
    gap = points[:, 0] / end
    way = np.sign(np.diff(gap))
    folds = 1 + np.flatnonzero(way[1:] != way[:-1])
    figure, panels = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
    for axes in panels:
        axes.plot(gap, points[:, 1], color=BLACK, linewidth=1, label="path of equal products z p")
        axes.plot(gap[folds], points[folds, 1], "o", color=VERMILION, label="fold")
        for word, mark, colour, of in (
            ("a pass, Newton's matrix", "+", BLUE, [step for step in steps if step.blend == 1]),
            ("a pass, a matrix of less friction", "x", ORANGE, [step for step in steps if step.blend < 1]),
        ):
            # A pass measures its gap at the λ of each step.
            measured = [step.gap * max(abs(step.load_factor), 1e-3) / end for step in of]
            axes.plot(measured, [step.load_factor for step in of], mark, color=colour, label=word)
        axes.set(xscale="log", xlabel="energy z·p, over the live load's work at collapse", ylabel="λ")
        axes.invert_xaxis()
    panels[0].legend(fontsize=8)
    if len(folds):
        near = (gap > gap[folds[-2:]].min() / NEARBY) & (gap < gap[folds[-2:]].max() * NEARBY)
        low, high = points[near, 1].min(), points[near, 1].max()
        panels[1].set(xlim=(gap[near].max(), gap[near].min()), title="round the last two folds")
        panels[1].xaxis.set_minor_formatter(NullFormatter())
        panels[1].set_ylim(low - 0.1 * (high - low), high + 0.1 * (high - low))
    figure.savefig(file, dpi=150)
    for at in folds:
        print(f"fold at gap {gap[at]:.3g}, load factor {points[at, 1]:.5f}")


def main() -> None:
    """Draw the path of a rubble wall."""
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--stones", type=int, default=60)
    options.add_argument("--seed", type=int, default=101)
    chosen = options.parse_args()
    problem = assemble(large_scene("rubble", chosen.stones, chosen.seed)).problem
    passes, steps = Passes(problem), list[NewtonStep]()
    passes.run(steps.append)
    points = np.array([(at.energy, at.state.load_factor) for at in CentralPath(problem).centres()])
    draw(points, steps, ROOT / "docs" / "central_path.png")
    print(f"{len(points)} centres to load factor {points[-1, 1]:.6f}")
    print(f"a pass: {passes.outcome} after {len(steps)} steps, load factor {steps[-1].load_factor:.6f}")


if __name__ == "__main__":
    main()
