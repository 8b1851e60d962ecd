"""How does the load factor change along the path that a pass follows? Draws docs/central_path.png and prints
the folds.

    python benchmarks/central_path.py --stones 60 --seed 101

Rigid contacts, and all products z p the same, τ, which falls to 0. With w = log p and z = τ / p all
conditions are smooth and no sign is left to keep: Newton steps along the path's tangent and square to it
(Keller's pseudo-arclength, 1977; lengths by log p and log τ alone) go round folds, where τ rises again.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import scipy.sparse as sp
from matplotlib.ticker import NullFormatter
from scipy.sparse.linalg import splu

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.large_scenes import large_scene  # noqa: E402

from masonry_opt.drawing.colours import BLACK, BLUE, ORANGE, VERMILION  # noqa: E402
from masonry_opt.methods.mcp.passes import Passes  # noqa: E402
from masonry_opt.methods.mcp.schedule import NewtonStep  # noqa: E402
from masonry_opt.problem.assembly import assemble  # noqa: E402
from masonry_opt.problem.problem import Problem  # noqa: E402

#: Energy Σ z p over the live load's work Σ|f_L|, at λ = 1: where the path is begun, and where it ends.
FIRST, LAST = 10.0, 1e-10

#: What the equations may leave; steps along the path at first and at most; Newton steps of a correction at
#: most, and by how much each may change a logarithm.
LEFT, STEP, LONGEST, CORRECTIONS, FARTHEST = 1e-9, 0.1, 0.2, 8, 2.0

#: How far beyond the last two folds the picture's second half goes, as a factor on the gap.
NEARBY = 3.0

#: Steps of a path at most, halvings included.
MOST = 10_000


class Centre:
    """The conditions of a centre, of the unknowns x = (q, d, λ, w = log p, log τ)."""

    def __init__(self, problem: Problem) -> None:
        arms = sp.diags_array(1 / problem.face_arm)
        self.limits = (arms @ problem.true_yield).tocsr()
        self.flow = (problem.D(problem.dilatancy) @ arms).tocsr()
        self.problem, self.room = problem, problem.face_cohesion / problem.face_arm
        self.ends = np.cumsum([problem.B.shape[1], problem.dead.size, 1, problem.faces])
        self.size = int(self.ends[-1])
        self.weights = np.concatenate(
            [np.zeros(self.ends[2]), np.full(problem.faces, 1 / problem.faces), [1]]
        )

    def at(self, x: np.ndarray, row: np.ndarray) -> tuple[np.ndarray, sp.csc_array]:
        """What is left of the conditions, shape (size,), and their derivative with one more row below."""
        problem, live = self.problem, self.problem.live
        q, d, load_factor, w, tau = np.split(x, self.ends)
        p, z = np.exp(w), np.exp(tau - w)
        left = [
            problem.B @ q + load_factor * live + problem.dead,
            self.limits @ q + self.room - z,
            problem.B.T @ d - self.flow @ p,
            [live @ d / problem.live_norm - 1],
        ]
        blocks = [
            [problem.B, None, live[:, None], None, None],
            [self.limits, None, None, sp.diags_array(z), -z[:, None]],
            [None, problem.B.T, None, -self.flow @ sp.diags_array(p), None],
            [None, live[None] / problem.live_norm, None, None, None],
            [part[None] for part in np.split(row, self.ends)],
        ]
        return np.concatenate(left), sp.block_array(blocks, format="csc")

    def corrected(self, x: np.ndarray, row: np.ndarray, most: int) -> tuple[np.ndarray, int] | None:
        """The centre near x, square to the row, and after how many Newton steps; None if too many."""
        with np.errstate(all="ignore"):
            for count in range(most):
                left, matrix = self.at(x, row)
                if not np.isfinite(left).all():
                    return None
                if np.abs(left).max() < LEFT:
                    return x, count
                step = splu(matrix).solve(np.append(left, 0.0))
                x = x - step * min(1.0, FARTHEST / np.abs(step[self.ends[2] :]).max())
        return None

    def path(self) -> np.ndarray:
        """log τ and λ from centre to centre, shape (centres, 2)."""
        first, last = np.log(np.array([FIRST, LAST]) * self.problem.live_norm / self.problem.faces)
        along = np.eye(1, self.size + 1, self.size)[0]
        begun = self.corrected(first * along, along, MOST)
        assert begun is not None, "no centre to begin with"
        (x, _), along, step, points = begun, -along, STEP, list[tuple[float, float]]()
        for _ in range(MOST):
            points.append((x[-1], x[self.ends[1]]))
            if x[-1] < last or step < LEFT:
                break
            _, matrix = self.at(x, self.weights * along)
            along = splu(matrix).solve(np.eye(1, self.size + 1, self.size)[0])
            along /= np.sqrt(self.weights @ along**2)
            while (ended := self.corrected(x + step * along, self.weights * along, CORRECTIONS)) is None:
                step /= 2
            step = min(1.5 * step, LONGEST) if ended[1] <= CORRECTIONS // 3 else step
            x = ended[0]
        return np.array(points)


def draw(centre: Centre, points: np.ndarray, steps: list[NewtonStep], file: Path) -> None:
    """λ against the gap: of the path with its folds, and of a pass's steps."""
    end = points[-1, 1]
    gap = np.exp(points[:, 0]) * centre.problem.faces / centre.problem.live_norm / end
    way = np.sign(np.diff(points[:, 0]))
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
    centre = Centre(problem)
    points = centre.path()
    draw(centre, points, steps, ROOT / "docs" / "central_path.png")
    print(f"{len(points)} centres to load factor {points[-1, 1]:.6f}")
    print(f"a pass: {passes.outcome} after {len(steps)} steps, load factor {steps[-1].load_factor:.6f}")


if __name__ == "__main__":
    main()
