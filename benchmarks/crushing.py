"""Measure what a compressive strength adds to the associative program, for two solvers.

    python benchmarks/crushing.py cases/ferris_tinloi/wall_1.toml cases/gilbert/facade_1x3.toml

Clarabel solves programs with the moment parabola, HiGHS programs with chords inside the parabola. Strengths
are multiples of the mean stress below the scene: its weight over the length of all joints with supports. The
script prints a row for each strength and solver: the rows of the program, the processor time over that
without strength, and the load factor.
"""

import argparse
import time
from math import inf
from pathlib import Path

import masonry_opt as mo
from masonry_opt.problem.loads import weights

#: Strengths relative to the mean stress below the scene. The last entry means unlimited strength.
STRENGTHS = (10.0, 30.0, inf)
REPEATS = 3


def mean_stress(scene: mo.Scene) -> float:
    """Return the weight of a scene over the length of all its joints with supports."""
    assembly = mo.assemble(scene)
    fixed = [block.fixed for block in scene.blocks]
    joints = assembly.joints
    below = [fixed[one] or fixed[other] for one, other in zip(joints.first, joints.second, strict=True)]
    weight = weights(scene, assembly.geometry, assembly.movable).sum()
    return float(weight / joints.extent[below].sum())


def solved(scene: mo.Scene, solver: str) -> tuple[mo.Result, float]:
    """Return the result of method "static", and the shortest processor time of some repeats."""
    seconds = inf
    for _ in range(REPEATS):
        began = time.process_time()
        result = mo.solve(scene, "static", solver=solver)
        seconds = min(seconds, time.process_time() - began)
    return result, seconds


def main() -> None:
    """Solve the cases of the command line with each strength, and print the table."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("cases", nargs="+", type=Path)
    print("| case | strength | solver | law | rows | time over unlimited | λ |")
    print("|---" * 7 + "|")
    for case in parser.parse_args().cases:
        scene = mo.load(case)
        stress = mean_stress(scene)
        for solver in ("clarabel", "highs"):
            rows = []
            for multiple in STRENGTHS:
                strength = None if multiple == inf else multiple * stress
                joints = scene.joints.replace(strength=strength)
                rows.append((multiple, *solved(scene.replace(joints=joints), solver)))
            unlimited = rows[-1][-1]
            for multiple, result, seconds in rows:
                cells = [case.stem, f"{multiple:g}", solver, result.crushing or "–", str(result.size.rows)]
                cells += [f"{seconds / unlimited:.1f}", f"{result.required():.6f}"]
                print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
