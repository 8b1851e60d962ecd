"""Compute incremental load factors of random scenes or cases, or vary the settings of the analysis.

    python benchmarks/incremental.py table plane --first 1400000 --count 23
    python benchmarks/incremental.py table rubble:60 --first 1400000 --count 10
    python benchmarks/incremental.py table cases/gilbert/facade_1x3.toml
    python benchmarks/incremental.py ablation plane --first 1410000 --count 5
    python benchmarks/incremental.py ablation corner:4x3x6 --settings far motion_solves

A family is "plane", "space", a kind of large scene with its number of stones, a corner wall with its blocks
along x, its blocks along y and its courses, or a case file.

``table`` prints a row for each scene: joints, end, load factor, the highest load carried and the lowest load
not carried, load increments, jumps, linear solves and processor time.

``ablation`` multiplies each setting, or only the named ones, by three and by a third. It prints:

- the largest relative change of a load factor, and the number of load factors that change by more than 1e-3
- the number of exact states that the load history loses and gains
- the number of scenes that end in another way
- the number of linear solves, relative to the number with the default settings
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
from scenes_in_space import corner_wall  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.methods.incremental.analysis import End, IncrementalAnalysis, IncrementalResult  # noqa: E402
from masonry_opt.methods.incremental.collapse_state import find_collapse_state  # noqa: E402
from masonry_opt.methods.incremental.settings import IncrementalSettings  # noqa: E402
from masonry_opt.problem.assembly import assemble  # noqa: E402
from masonry_opt.problem.problem import Problem  # noqa: E402

#: A load factor counts as changed if its relative change exceeds this value.
CHANGED = 1e-3


def scenes(family: str, first: int, count: int) -> Iterator[tuple[str, mo.Scene]]:
    """Yield names and scenes of a family, as the first lines of this file explain."""
    seeds = range(first, first + count)
    if family == "plane":
        yield from ((f"{kind} {seed}", random_scene(kind, seed)) for kind in KINDS for seed in seeds)
    elif family == "space":
        for kind in KINDS_IN_SPACE:
            yield from ((f"{kind} {seed}", random_scene_in_space(kind, seed)) for seed in seeds)
    elif family.endswith(".toml"):
        yield family, mo.load(ROOT / family)
    elif family.startswith("corner:"):
        yield family, corner_wall(*map(int, family.partition(":")[2].split("x")))
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


def ablation(family: str, first: int, count: int, names: list[str]) -> None:
    """Print a row for each named setting, or for all settings, multiplied by three and by a third."""
    problems = [assemble(scene).problem for _, scene in scenes(family, first, count)]
    usual = IncrementalSettings()
    before = [analysed(problem, usual, programs=False) for problem in problems]
    print(f"{len(problems)} scenes, {sum(solves for _, solves in before)} solves")
    print("| setting | largest change | changed | exact states | other ends | solves × |")
    print("|---" * 6 + "|")
    for name in names or [field.name for field in fields(usual)]:
        for factor in (3.0, 1 / 3):
            value = getattr(usual, name)
            changed = value * factor if isinstance(value, float) else max(1, round(value * factor))
            settings = replace(usual, **{name: changed})
            after = [analysed(problem, settings, programs=False) for problem in problems]
            print("| " + " | ".join([f"{name} = {changed:.4g}", *compared(before, after)]) + " |", flush=True)


def compared(
    before: list[tuple[IncrementalResult, int]], after: list[tuple[IncrementalResult, int]]
) -> list[str]:
    """Return the cells of a row of ``ablation``: changes, exact states, ends and solves."""
    pairs = [(old, new) for (old, _), (new, _) in zip(before, after, strict=True)]
    changes = [
        abs(new.load_factor / old.load_factor - 1)
        for old, new in pairs
        if old.load_factor and new.load_factor is not None
    ]
    exact = [(old.state is not None, new.state is not None) for old, new in pairs]
    lost, gained = exact.count((True, False)), exact.count((False, True))
    ends = sum(old.end is not new.end for old, new in pairs)
    ratio = sum(solves for _, solves in after) / sum(solves for _, solves in before)
    large = sum(change > CHANGED for change in changes)
    return [f"{max(changes, default=0.0):.1e}", f"{large}", f"-{lost} +{gained}", f"{ends}", f"{ratio:.2f}"]


def main() -> None:
    """Run the command that the arguments name."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("command", choices=["table", "ablation"])
    parser.add_argument("family", nargs="?", default="plane")
    parser.add_argument("--first", type=int, default=1_400_000)
    parser.add_argument("--count", type=int, default=10)
    names = [field.name for field in fields(IncrementalSettings)]
    parser.add_argument("--settings", nargs="*", default=[], choices=names, metavar="NAME")
    of = parser.parse_args()
    if of.command == "table":
        table(of.family, of.first, of.count)
    else:
        ablation(of.family, of.first, of.count, of.settings)


if __name__ == "__main__":
    main()
