"""Function ``sweep``: the load factor of a scene over a grid of values of its numbers."""

import inspect
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from numbers import Integral
from pathlib import Path
from typing import Any

import pandas as pd

from masonry_opt.analysis import prepare
from masonry_opt.drawing.elements import title_of
from masonry_opt.effort import ignore_progress
from masonry_opt.errors import OptionError, counted, printable
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.reporting.load_factors import meaning
from masonry_opt.reporting.names import warning_lines
from masonry_opt.reporting.sentences import numeral
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.many.parameters import Parameters
from masonry_opt.studies.many.runs import (
    RunProgress,
    Study,
    StudyOutput,
    at_least,
    chart_names,
    charts_if_installed,
    run_many,
)
from masonry_opt.studies.many.scene_answer import place_text
from masonry_opt.studies.run_columns import CROSSED_RUNS, PLACE, RUN_COLUMNS, is_crossed
from masonry_opt.studies.runner import UNSOLVED
from masonry_opt.studies.writing import chart_files


def sweep(  # noqa: PLR0913 - options of the public API are keywords
    scene: Scene | str | Path | Callable[..., Scene],
    vary: Mapping[str, Sequence[float]],
    *,
    method: str = DEFAULT,
    out: str | Path | None = None,
    force: bool = False,
    workers: int | None = None,
    dask: str | None = None,
    progress: RunProgress = ignore_progress,
    **options: Any,
) -> pd.DataFrame:
    """Solve a scene for every combination of values of its parameters.

    If the scene has axles, they cross the scene in each run. λ is then the least of all positions and of all
    load cases with axles, as :func:`~masonry_opt.crossing` finds it.

    Runs that differ only in limits on forces, such as the strength of a tie, share exact states. A lower
    state of another run replaces the answer of a run if the run's own matrices certify the state as exact.
    Only methods that look for the lowest state share states: "coulomb", "mpec" and "global".

    Parameters
    ----------
    scene: A scene, the path of a case file, or a function of the numbers that returns a scene.
    vary: Values by name. The parameters of a scene have names such as ``joints.friction``, ``block.A.weight``
        and ``arch.thickness``. For a function, the names are the names of its arguments.
    method, options: As for :func:`~masonry_opt.solve`, including ``model``, ``solver``, ...
    out: Folder for ``runs.csv`` and charts (with the extra ``studies``). Runs that the folder contains are
        not made again: an interrupted sweep continues where it stopped. A table is not replaced if the new
        table lacks some of its runs.
    force: True to replace files of other programs, and a table even if the new table lacks some of its runs.
        The runs remain in ``journal.jsonl``.
    workers: Number of processes; by default one per core.
    dask: Address of a Dask scheduler, whose workers make the runs instead (needs the extra ``dask``).
    progress: Function called with the number of finished runs and the number of all runs.

    Returns
    -------
    pandas.DataFrame
        Table with one row per run; the values of the last name in ``vary`` change fastest. The first columns
        are the values. Further columns are

        - ``load_factor`` (NaN without a load factor), and ``which``, the name of this load factor, such as
          "lowest found" or "associative";
        - ``status``, ``reason`` (a code) and ``message``;
        - ``any_load`` (True if a Coulomb method has proven that the scene carries any load), ``exact``, and
          ``states`` (number of different exact states found);
        - ``incremental`` (incremental load factor; NaN if it is switched off), ``spread_lower`` and
          ``spread_upper`` (its range with the option ``spread``), and ``associative``;
        - the residuals of the certificate: ``equilibrium``, ``yield``, ``flow`` and ``complementarity``;
        - ``mechanism`` ("sliding", "hinging", "crushing", "mixed", "separating" or "none"), and the numbers
          of joints in each motion: ``slides``, ``hinges``, ``separates`` and ``crushes``;
        - ``blocks``, ``joints`` and ``seconds``;
        - ``state_from`` (the other run in which the state was found, else "") and ``warnings`` (about the
          scene of the run).

        If axles cross the scene, the columns ``load_case``, ``axles``, ``direction`` and ``position`` (of the
        first axle) name the worst position. Further columns are ``bound`` (as in ``mo.crossing``),
        ``positions`` (number of solved positions) and ``undecided_positions``. Such runs share no states.

        A failed run is a row too, with status "refused" if its values make no scene. Any other error of a
        scene function ends the sweep; with ``out`` the finished runs are kept. ``attrs["warnings"]`` lists
        the warnings of all runs, each once.

    Raises
    ------
    OptionError
        If a name, a value, a method or an option is wrong, or if ``out`` has runs of another study, a
        table with other runs, or files with the same names from other programs.
    CaseError
        If the case file or the scene is wrong.
    OutputError
        If ``out`` cannot be written. Finished runs are kept.
    NoRunSolvedError
        If every run was refused or crashed.
    """
    points = grid(vary)
    varied_scene: Scene | None = None
    if callable(scene) and not isinstance(scene, Scene):
        make = _maker(scene, list(vary))
    else:
        varied_scene = as_scene(scene)
        parameters = Parameters(varied_scene)
        parameters.check_names(vary)
        make = parameters.at
    study = Study(prepare(method, function=sweep, **options).how, make, varied_scene)
    output = None if out is None else StudyOutput(Path(out), chart_files(chart_names(list(vary))), force)
    frame = run_many(study, points, output=output, by=(workers, dask), progress=progress)
    if output is not None:
        title = f"Sweep of {title_of(varied_scene)}" if varied_scene else "Sweep"
        output.write(frame, charts_if_installed(title, lambda: _drawings(frame, list(vary))))
    return frame


def _drawings(frame: pd.DataFrame, names: Sequence[str]) -> list[Any]:
    """Return the charts of a sweep. Raises OptionError if the extra "studies" is not installed."""
    from masonry_opt.studies.many.charts import drawings

    return drawings(frame, names)


def grid(vary: Mapping[str, Sequence[float]]) -> list[dict[str, float]]:
    """Return all combinations of values; the values of the last name change fastest.

    Raises OptionError if there are no values, if a value is not a number, or if a value occurs twice.
    """
    if not isinstance(vary, Mapping) or not vary:
        raise OptionError("vary must be a dictionary, such as {'joints.friction': [0.3, 0.4]}")
    axes: list[list[float]] = []
    for name, values in vary.items():
        if name in RUN_COLUMNS:
            raise OptionError(f"'{name}' in 'vary' is a column of the result table: use another name")
        try:
            # Integers are not converted to floats, because some parameters of a scene are counts.
            axis = [int(value) if isinstance(value, Integral) else float(value) for value in values]
        except (TypeError, ValueError):
            raise OptionError(f"'{name}' in 'vary' needs a list of numbers (found {values!r})") from None
        if not axis or any(map(math.isnan, axis)):
            raise OptionError(f"'{name}' in 'vary' needs a list of at least one number; NaN is not allowed")
        if len(set(axis)) < len(axis):
            raise OptionError(f"'{name}' in 'vary' has a value twice: remove the repeated value")
        axes.append(axis)
    return [dict(zip(vary, values, strict=True)) for values in itertools.product(*axes)]


def _maker(function: Callable[..., Scene], names: Sequence[str]) -> Callable[[Mapping[str, float]], Scene]:
    """Return a function that calls the user's function with a dictionary of values.

    Raises OptionError if the user's function has other parameters. The returned function raises OptionError
    if the user's function returns no scene.
    """
    try:
        inspect.signature(function).bind(**dict.fromkeys(names))
    except TypeError as error:
        raise OptionError(
            f"the function that makes the scene must accept the varied parameters as arguments: {error}"
        ) from None

    def make(values: Mapping[str, float]) -> Scene:
        """Return the scene for a dictionary of values."""
        scene = function(**values)
        if not isinstance(scene, Scene):
            raise OptionError(f"the function must return a Scene (found {type(scene).__name__})")
        return scene

    return make


def _where(rows: pd.DataFrame, names: Sequence[str]) -> str:
    """Return a text with the values of the first run in a table, and the number of the other runs.

    If axles cross the scene of the run, the text also has their worst position.
    """
    row = rows.iloc[0]
    first = ", ".join(f"{name} = {row[name]:g}" for name in names)
    if is_crossed(rows) and pd.notna(row["position"]):
        first += f", with {place_text(*(row[name] for name in PLACE))}"
    return f"{first}, and in {counted(len(rows) - 1, 'more run')}" if len(rows) > 1 else first


def summary_text(frame: pd.DataFrame, names: Sequence[str]) -> str:
    """Return the summary of a sweep as text of a few lines."""
    load_factors = frame["load_factor"].dropna()
    lines = [f"{counted(len(frame), 'run')}, {len(load_factors)} with a load factor"]
    if len(load_factors):
        lines.append(f"λ from {numeral(load_factors.min(), '.6f')} to {numeral(load_factors.max(), '.6f')}")
        lines.append(f"λ is {meaning(frame.loc[load_factors.index, 'which'])}")
        if is_crossed(frame):
            lines.append(CROSSED_RUNS)
        lines.append(f"smallest at {_where(frame[at_least(frame)], names)}")
    shared = int((frame["state_from"] != "").sum())
    if shared:
        lines.append(
            f"runs that take their collapse state from another run: {shared} (see column state_from)"
        )
    failed = frame[frame["load_factor"].isna()]
    for status, count in failed["status"].value_counts().items():
        rows = failed[failed["status"] == status]
        why = f": {rows['message'].iloc[0]}" if status in UNSOLVED else ""
        lines.append(f"{count} {status}, at {_where(rows, names)}{why}")
    return printable("\n".join([*lines, *warning_lines(frame.attrs.get("warnings", ()))]))
