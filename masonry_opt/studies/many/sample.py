"""``sample``: a scene whose numbers are uncertain, solved for values drawn from their distributions."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from masonry_opt.errors import OptionError
from masonry_opt.methods.how_to_solve import HowToSolve
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.many.draws import Draws
from masonry_opt.studies.many.runs import Study
from masonry_opt.studies.many.sample_answer import KINDS, Sample
from masonry_opt.studies.many.table import ManyRuns, RunProgress, RunsFolder
from masonry_opt.studies.writing import csv_text, write_files

#: Default number of runs: Sobol's points are most even for powers of two.
RUNS = 128


def sample(
    scene: Scene | str | Path,
    distributions: Mapping[str, Any],
    *,
    n: int = RUNS,
    seed: int = 0,
    by: str = "scene",
    correlation: float | None = None,
    sequence: str | None = None,
    method: str = DEFAULT,
    model: str | None = None,
    solver: str | None = None,
    tolerance: float | None = None,
    expected: bool = True,
    out: str | Path | None = None,
    parquet: bool = False,
    force: bool = False,
    workers: int | None = None,
    dask: str | None = None,
    progress: RunProgress = lambda done, of: None,
    **options: Any,
) -> Sample:
    """Find the load factors of a scene whose numbers are uncertain.

    >>> import masonry_opt as mo
    >>> found = mo.sample("wall.toml", {"joints.friction": ("lognormal", 0.65, "15%")}, n=256)
    >>> print(found)

    Numbers are independent of each other; those of joints may be correlated (``by``, ``correlation``).

    Parameters
    ----------
    scene:
        A scene, or the path of a case file.
    distributions:
        By names of numbers (as in ``mo.sweep``): ``("lognormal", mean, deviation)`` and ``("normal", mean,
        deviation)``, with mean and standard deviation of the number itself, the latter also as a share of
        the mean, ``"15%"``; ``("uniform", least, greatest)``; or a frozen distribution of ``scipy.stats``.
        If the scene refuses a value drawn, such as a friction below zero, nothing is run.
    n:
        Runs. With Sobol's sequence a power of two is best. A larger number adds to the runs of a smaller one.
    seed:
        The same seed gives the same table, with any number of workers.
    by:
        "scene": one value for all joints. "joint": properties of joints (``joints.friction``, ...) are drawn
        for each joint; "course": for each course (the joints at one height).
    correlation:
        Of the normal scores behind the values: between the joints of a course (``by="course"``; default 1,
        one value a course; courses are independent), or between all joints (``by="joint"``; default 0).
    sequence:
        "sobol", scrambled (the default up to 10 numbers), or "random", independent points (the default
        above: of many numbers Sobol's points correlate some unless there are thousands of runs).
    method, model, solver, tolerance, expected, **options:
        Of :func:`~masonry_opt.analysis.solve`.
    out:
        Folder for ``runs.csv``, ``quantiles.csv``, ``fragility.csv``, ``sensitivity.csv`` and a chart of
        each. Runs that it holds already are not made again.
    parquet, force, workers, dask, progress:
        As of ``mo.sweep``.

    Returns
    -------
    Sample
        All runs, quantiles of the load factor, probabilities of collapse and sensitivities.

    Raises
    ------
    OptionError
        If a name, distribution or argument is wrong, the scene refuses a value drawn, or ``out`` holds runs
        of something else, or a table with other runs.
    CaseError
        If the scene is wrong.
    OutputError
        If ``out`` cannot be written; runs already made are kept.
    """
    scene = as_scene(scene)
    for name, value, least in (("n", n, 1), ("seed", seed, 0)):
        if not isinstance(value, int) or isinstance(value, bool) or value < least:
            raise OptionError(f"{name} must be a whole number, {least} or more (found {value!r})")
    draws = Draws(scene, distributions, by, correlation)
    values = draws.table(n, seed, sequence)
    folder = None if out is None else Path(out)
    how = HowToSolve(method, model, solver, tolerance, expected, options)
    study, make = (Study(None, how), draws.scene) if draws.varied else (Study(scene, how), None)
    runs = ManyRuns(study, values.to_dict("records"), make)  # type: ignore[arg-type]  # columns have names
    table = runs.table(RunsFolder(folder, parquet, force), workers, dask, progress)
    found = Sample(scene.called, table, tuple(column.name for column in draws.columns), draws.texts)
    if folder is not None:
        write_files(folder, {f"{name}.csv": csv_text(frame) for name, frame in found.tables().items()})
        with contextlib.suppress(OptionError):  # the tables need no extra
            from masonry_opt.studies.charts import write_charts

            write_charts("Sample", [found.drawing(kind) for kind in KINDS], folder)
    return found
