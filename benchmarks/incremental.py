"""Compute incremental load factors of random scenes or cases, or vary the settings of the analysis.

    python benchmarks/incremental.py table plane --first 1400000 --count 23
    python benchmarks/incremental.py table rubble:60 --first 1400000 --count 10
    python benchmarks/incremental.py table cases/gilbert/facade_1x3.toml
    python benchmarks/incremental.py ablation plane --first 1410000 --count 5

``table`` prints a row for each scene: joints, end, load factor, the highest load carried and the lowest load
not carried, load increments, jumps, linear solves and processor time.

``ablation`` multiplies each setting by three and by a third. It prints the largest relative change of a load
factor, the number of scenes that end in another way, and the number of linear solves.
"""

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import fields, replace
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.large_scenes import large_scene  # noqa: E402
from atlas.random_scenes import KINDS, random_scene  # noqa: E402
from atlas.random_scenes_in_space import KINDS as KINDS_IN_SPACE  # noqa: E402
from atlas.random_scenes_in_space import random_scene_in_space  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.methods.incremental.analysis import End, IncrementalAnalysis, IncrementalResult  # noqa: E402
from masonry_opt.methods.incremental.collapse_state import find_collapse_state  # noqa: E402
from masonry_opt.methods.incremental.settings import IncrementalSettings  # noqa: E402
from masonry_opt.problem.assembly import assemble  # noqa: E402
from masonry_opt.problem.problem import Problem  # noqa: E402


def scenes(family: str, first: int, count: int) -> Iterator[tuple[str, mo.Scene]]:
    """Yield names and scenes of a family: plane, space, a large family as "rubble:60", or a case file."""
    seeds = range(first, first + count)
    if family == "plane":
        yield from ((f"{kind} {seed}", random_scene(kind, seed)) for kind in KINDS for seed in seeds)
    elif family == "space":
        for kind in KINDS_IN_SPACE:
            yield from ((f"{kind} {seed}", random_scene_in_space(kind, seed)) for seed in seeds)
    elif family.endswith(".toml"):
        yield family, mo.load(ROOT / family)
    else:
        name, _, stones = family.partition(":")
        yield from ((f"{family} {seed}", large_scene(name, int(stones), seed)) for seed in seeds)


def analysed(
    problem: Problem, settings: IncrementalSettings, programs: bool = True
) -> tuple[IncrementalResult, int]:
    """Return the result of a problem, and its number of linear solves.

    If ``programs`` is true, two linear programs look for an exact collapse state in the plane if the analysis
    has none.
    """
    analysis = IncrementalAnalysis(problem, settings)
    result = analysis.run()
    if programs and result.end is End.COLLAPSE and result.state is None and not problem.layout.round:
        result = result.with_state(find_collapse_state(analysis.solver, result.collapse))
    return result, analysis.solver.iterations


def table(family: str, first: int, count: int) -> None:
    """Print a row for each scene, and the sum of the times."""
    total = 0.0
    for name, scene in scenes(family, first, count):
        problem = assemble(scene).problem
        began = time.process_time()
        result, solves = analysed(problem, IncrementalSettings())
        seconds = time.process_time() - began
        total += seconds
        exact = "exact" if result.state else "range"
        row = [
            name,
            problem.joints,
            result.end.name.lower(),
            result.load_factor and f"{result.load_factor:.9f}",
            f"{result.carried:.6g}–{result.not_carried:.6g} {exact}",
            f"{len(result.history.steps)} increments, {result.history.jumps} jumps, {solves} solves",
            f"{seconds:.3f} s",
        ]
        print("| " + " | ".join(map(str, row)) + " |", flush=True)
    print(f"seconds: {total:.2f}")


def ablation(family: str, first: int, count: int) -> None:
    """Print a row for each setting, multiplied by three and by a third."""
    problems = [assemble(scene).problem for _, scene in scenes(family, first, count)]
    usual = IncrementalSettings()
    before = [analysed(problem, usual, programs=False) for problem in problems]
    print(f"| usual | | | {sum(solves for _, solves in before)} |")
    for field in fields(usual):
        for factor in (3.0, 1 / 3):
            value = getattr(usual, field.name)
            changed = value * factor if isinstance(value, float) else max(1, round(value * factor))
            after = [
                analysed(problem, replace(usual, **{field.name: changed}), programs=False)
                for problem in problems
            ]
            pairs = [(old, new) for (old, _), (new, _) in zip(before, after, strict=True)]
            ends = sum(old.end is not new.end for old, new in pairs)
            changes = [
                abs(new.load_factor / old.load_factor - 1)
                for old, new in pairs
                if old.load_factor and new.load_factor is not None
            ]
            solves = sum(number for _, number in after)
            row = [f"{field.name} = {changed:.4g}", f"{max(changes):.2e}", ends, solves]
            print("| " + " | ".join(map(str, row)) + " |", flush=True)


def main() -> None:
    """Run the command that the arguments name."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("command", choices=["table", "ablation"])
    parser.add_argument("family", nargs="?", default="plane")
    parser.add_argument("--first", type=int, default=1_400_000)
    parser.add_argument("--count", type=int, default=10)
    of = parser.parse_args()
    if of.command == "table":
        table(of.family, of.first, of.count)
    else:
        ablation(of.family, of.first, of.count)


if __name__ == "__main__":
    main()
