"""Count wrong and missing answers of methods and solvers on difficult scenes and on random scenes.

    python benchmarks/verdicts.py --random 40 --time-limit 10
    python benchmarks/verdicts.py --no-atlas --stones 60,200 --seeds 2 \\
        --methods nonassociative,coulomb --solvers clarabel

The script compares like `masonry-opt compare`: on the failure atlas (tests/atlas), whose correct answers are
known, and on random scenes. An interrupted run continues. The file tests/atlas/best_known.toml contains the
lowest known exact states. The exit code is 1 if a verdict is wrong.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.made_scenes import judged_by_hand, write_atlas, write_large, write_random  # noqa: E402

from masonry_opt.studies.compare.comparison import run_plan, write_report  # noqa: E402
from masonry_opt.studies.compare.judge import Comparison, best_known  # noqa: E402
from masonry_opt.studies.compare.runs import RunLimits, find_scenes, plan  # noqa: E402


def verdicts(asked: argparse.Namespace) -> Comparison:
    """Compare on the selected scenes, and write tables, charts and report of the comparison."""
    made = asked.out / "scenes"
    expected = write_atlas(made, ROOT / "cases") if asked.atlas else {}
    large = write_large(made, [int(count) for count in asked.stones.split(",") if count], asked.seeds)
    scenes = find_scenes([*expected, *write_random(made, asked.random), *large])
    planned = plan(asked.methods.split(","), ["cvxpy"], asked.solvers.split(","), [1e-9])
    limits, known = RunLimits(asked.time_limit, 4000.0, 1), best_known(scenes, ROOT / "tests" / "atlas")
    comparison = run_plan(scenes, planned, limits, asked.out, asked.progress, known)
    by_hand = {scene.name: expected.get(scene.path, {}) for scene in scenes}
    comparison = replace(comparison, summary=judged_by_hand(comparison.summary, by_hand))
    write_report(comparison, asked.out)
    return comparison


def arguments(given: list[str] | None = None) -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--atlas", action=argparse.BooleanOptionalAction, default=True)
    parser.add_argument("--random", type=int, default=0, help="so many small random scenes, by seed")
    parser.add_argument("--stones", default="", help="large random scenes of so many stones: 60,200")
    parser.add_argument("--seeds", type=int, default=1, help="how many of each")
    parser.add_argument("--methods", default="static,nonassociative,coulomb")
    parser.add_argument("--solvers", default="clarabel,highs")
    parser.add_argument("--time-limit", type=float, default=60.0, help="seconds a run")
    parser.add_argument("--out", type=Path, default=Path("results/verdicts"))
    return parser.parse_args(given, argparse.Namespace(progress=print))


if __name__ == "__main__":
    comparison = verdicts(arguments())
    print(comparison)
    sys.exit(int((comparison.summary["verdict"] == "wrong").any()))
