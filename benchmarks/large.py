"""Measure time and memory of the phases of an analysis of a large plane wall, or of a large façade of solids.

The first argument is the kind of scene, "wall" or "facade". A wall needs the numbers of blocks in a course
and of courses. A façade needs its length, its depth and the number of courses.
"""

import argparse
import resource
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import masonry_opt as mo
from masonry_opt.scene.scene import Scene


def wall(length: int, courses: int) -> Scene:
    """Return a wall in running bond, whose live load is its weight along x."""
    rows = [[1] * length, [0.5, *[1] * (length - 1), 0.5]]
    bond = mo.Wall(
        block=(0.25, 0.065), courses=rows, repeat=courses // 2, unit_weight=18, live_per_weight=(1, 0)
    )
    return mo.Scene(joints=mo.JointDefaults(friction=0.65), blocks=bond.blocks())


def main() -> None:
    """Solve the scene of the command line, and print seconds and memory as each phase begins."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=("wall", "facade"))
    parser.add_argument("sizes", type=int, nargs="+")
    parser.add_argument("--method", default="static")
    parser.add_argument("--time-limit", type=float)
    asked = parser.parse_args()
    from scenes_in_space import facade

    began = time.perf_counter()

    def report(phase: str) -> None:
        """Print the time since the start, the peak memory so far, and the name of a phase."""
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"{time.perf_counter() - began:8.1f} s {memory:8.0f} MB  {phase}", flush=True)

    scene = wall(*asked.sizes) if asked.kind == "wall" else facade(*asked.sizes)
    result = mo.solve(scene, asked.method, phases=report, time_limit=asked.time_limit)
    report("end")
    print(result.details)


if __name__ == "__main__":
    main()
