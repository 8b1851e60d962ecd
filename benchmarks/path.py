"""How does the state of a wall change as its contacts stiffen? Draws docs/path.png and prints the folds.

    python benchmarks/path.py --stones 60 --seed 102 --give 0.03

Contacts that give by g have B'd + g E q = D p. With d and p over g as unknowns all is linear in 1/g but
z p = 0: the path is straight from one change of the faces at work to the next. There the partner of what came
to zero grows (Lemke's rule), which orients the path without a determinant; where 1/g then falls, it folds. It
ends where rigid contacts can move: forces and load factor then stay as they are.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.large_scenes import large_scene  # noqa: E402

from masonry_opt.methods.mcp.passes import Passes  # noqa: E402
from masonry_opt.problem.assembly import assemble  # noqa: E402
from masonry_opt.problem.problem import Problem  # noqa: E402
from masonry_opt.problem.state import State  # noqa: E402

#: Force that every limit is loosened by, up to twice as much at random and a tenth at edges, so that no two
#: faces come to zero at once; and what counts as zero: a step's change of q, over q, and its other slopes.
ROOM, STILL, FLAT = 1e-6, 1e-7, 1e-11

#: Pivots at most.
MOST = 1000


def at_work(problem: Problem, state: State, slacks: np.ndarray) -> np.ndarray:
    """Faces at work in a compliant state, shape (faces,); where a joint slides in both senses the faster."""
    p = state.p
    work, slides = p * slacks.mean() > slacks * p.mean(), problem.table.slides
    senses, speed = work[slides].reshape(2, -1), p[slides].reshape(2, -1)
    senses &= (speed == speed.max(axis=0)) | ~senses.all(axis=0)
    work[slides] = senses.ravel()
    return work


def path(problem: Problem, unit: np.ndarray, state: State, give: float) -> list[tuple[float, float]]:
    """1/g and λ at each pivot, from a state of contacts that give by so much until rigid ones can move."""
    b3, faces = problem.dead.size, problem.faces
    B, soft = problem.B.toarray(), 1 / unit
    limits = problem.true_yield.toarray()
    flow = problem.D(problem.dilatancy).toarray()
    sliding = np.arange(faces) < problem.table.slides.stop
    looser = ROOM * np.random.default_rng(0).uniform(1, 2, faces) * np.where(sliding, 1.0, 0.1)
    room = problem.face_cohesion + looser
    # Forces are what the motion leaves: q = (D p - B'd) / E. Unknowns: d, p of all faces, λ, 1/g.
    of_motion = np.hstack([-soft[:, None] * B.T, soft[:, None] * flow])
    statics = np.hstack([B @ of_motion, problem.live[:, None], np.zeros((b3, 1))])
    slack = np.hstack([limits @ of_motion, np.zeros((faces, 2))])
    driven = np.concatenate([problem.live / problem.live_norm, np.zeros(faces + 1), [-1.0]])[None]
    rates, last = np.eye(faces, b3 + faces + 2, b3), np.eye(1, b3 + faces + 2, b3 + faces + 1)
    work, row, value = at_work(problem, state, limits @ state.q + room), last, 1 / give
    points = []
    for _ in range(MOST):
        # Rates of faces at work, whose slacks are zero, d, λ and 1/g; one more row drives the path.
        kept = np.concatenate([np.ones(b3, bool), work, [True, True]])
        matrix = np.vstack([statics, slack[work], driven, row])[:, kept]
        right = np.concatenate([-problem.dead, -room[work], [0.0, value]])
        here, along = np.zeros((2, len(kept)))
        here[kept], along[kept] = np.linalg.solve(matrix, np.column_stack([right, last[0, kept]])).T
        points.append((here[-1], here[-2]))
        values = np.where(work, rates @ here, slack @ here + room)
        slopes = np.where(work, rates @ along, slack @ along)
        noise = FLAT * np.where(work, np.abs(rates @ along).max(), np.abs(slack) @ np.abs(along))
        moved = here[-1] / along[-1] * np.abs(of_motion @ along[:-2]).max()
        shrinks = slopes < -noise
        if 0 < moved < STILL * np.abs(of_motion @ here[:-2]).max() and not (shrinks & work).any():
            return points
        steps = np.where(shrinks, np.maximum(values, 0.0) / np.where(shrinks, -slopes, 1.0), np.inf)
        first = int(steps.argmin())
        if not shrinks.any():
            return points
        row, value = (slack[[first]], -room[first]) if work[first] else (rates[[first]], 0.0)
        work[first] = not work[first]
    return points


def draw(points: list[tuple[float, float]], file: Path) -> None:
    """The load factor against the give, its folds marked."""
    stiffness, load_factor = np.array(points).T
    way = np.sign(np.diff(stiffness))
    folds = 1 + np.flatnonzero(way[1:] != way[:-1])
    figure, axes = plt.subplots(figsize=(6, 3.6), layout="constrained")
    axes.plot(1 / stiffness, load_factor, color="black", linewidth=1)
    axes.plot(1 / stiffness[folds], load_factor[folds], "o", color="tab:red", label="fold")
    axes.plot(1 / stiffness[-1], load_factor[-1], "s", color="tab:blue", label="rigid contacts move")
    axes.set(xscale="log", xlabel="give of contacts", ylabel="load factor")
    axes.invert_xaxis()
    axes.legend()
    figure.savefig(file, dpi=150)
    for at in folds:
        print(f"fold at give {1 / stiffness[at]:.3g}, load factor {load_factor[at]:.5f}")


def main() -> None:
    """Draw the path of a rubble wall."""
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--stones", type=int, default=60)
    options.add_argument("--seed", type=int, default=102)
    options.add_argument("--give", type=float, default=0.03)
    chosen = options.parse_args()
    problem = assemble(large_scene("rubble", chosen.stones, chosen.seed)).problem
    passes = Passes(problem)
    unit = passes.unit_compliance
    state = passes.giving(chosen.give).run()
    if state is None:
        sys.exit("no pass ends with this give")
    points = path(problem, unit, state, chosen.give)
    draw(points, ROOT / "docs" / "path.png")
    print(f"{len(points)} pivots, load factor {state.load_factor:.5f} to {points[-1][1]:.5f}")
    rigid = passes.run()
    print(f"a pass of rigid contacts: {rigid and rigid.load_factor}")


if __name__ == "__main__":
    main()
