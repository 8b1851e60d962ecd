"""Compare the time of the runs of studies with the time of single solves, by method "static".

    python benchmarks/studies.py cases/ferris_tinloi/wall_1.toml cases/ferris_tinloi/wall_5.toml

The studies are a sweep over friction in one worker process, and load cases. The script prints a row for each
study: the time of a single solve over the time of a run of the study, and the largest relative difference of
a load factor. Times are medians by the clock. Those of a sweep do not include the start of its process.
"""

import argparse
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np

import masonry_opt as mo

#: Friction coefficients of the sweep.
FRICTIONS = tuple(np.linspace(0.4, 0.95, 24).tolist())
#: Factors of the weight in the load cases.
WEIGHTS = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4)
#: Number of times that the load cases are solved.
REPEATS = 5

#: Load factors of a study, and the median time of a run in seconds.
Found = tuple[list[float], float]


def singly(scenes: list[mo.Scene]) -> Found:
    """Solve scenes one after the other."""
    load_factors, seconds = [], []
    for scene in scenes:
        began = time.perf_counter()
        load_factors.append(mo.solve(scene, "static").required())
        seconds.append(time.perf_counter() - began)
    return load_factors, float(np.median(seconds))


def of_cases(scene: mo.Scene) -> Found:
    """Solve all load cases of a scene some times."""
    seconds = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        results = mo.solve_cases(scene, "static").results
        seconds.append((time.perf_counter() - began) / len(results))
    return [result.required() for result in results.values()], float(np.median(seconds))


def swept(scene: mo.Scene) -> Found:
    """Sweep over friction."""
    table = mo.sweep(scene, {"joints.friction": FRICTIONS}, method="static", workers=1)
    return [float(value) for value in table["load_factor"]], float(table["seconds"].median())


def studies_of(scene: mo.Scene) -> Iterator[tuple[str, list[mo.Scene], Callable[[], Found]]]:
    """Yield the name of each study of a scene, the scenes of its single solves, and the study."""
    joints = [scene.joints.replace(friction=friction) for friction in FRICTIONS]
    yield "sweep", [scene.replace(joints=each) for each in joints], partial(swept, scene)
    loads = [
        mo.LoadCase(name=f"{factor} of the weight", dead={"weight": factor}, live={"live": 1.0})
        for factor in WEIGHTS
    ]
    cases = scene.replace(load_cases=loads)
    yield "load cases", [cases.in_case(each.name) for each in loads], partial(of_cases, cases)


def main() -> None:
    """Run the studies of the cases of the command line, and print the table."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("cases", nargs="+", type=Path)
    print("| case | study | a run is so many times as fast as a single solve | difference of λ |")
    print("|---" * 4 + "|")
    for case in parser.parse_args().cases:
        scene = mo.load(case)
        mo.solve(scene, "static")  # The first solve imports modules, so it is not measured.
        for name, scenes, study in studies_of(scene):
            found, seconds = study()
            expected, single_seconds = singly(scenes)
            change = max(abs(new / old - 1) for new, old in zip(found, expected, strict=True))
            print(f"| {case.stem} | {name} | {single_seconds / seconds:.1f} | {change:.0e} |", flush=True)


if __name__ == "__main__":
    main()
