"""``sample``: a scene whose numbers are uncertain, solved for values drawn from their distributions."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from masonry_opt.analysis import refuse_options
from masonry_opt.errors import CaseError, OptionError
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.many.distributions import Distribution, distribution
from masonry_opt.studies.many.draws import SEQUENCES, scores
from masonry_opt.studies.many.parameters import Parameters, is_of_joints
from masonry_opt.studies.many.runs import Study
from masonry_opt.studies.many.sample_answer import Sample
from masonry_opt.studies.many.spread import BY, Spread, with_values
from masonry_opt.studies.many.table import Progress, refuse_parquet, table

#: Runs, unless another number is asked for: a power of two, of which Sobol's points are spread most evenly.
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
    out: str | Path | None = None,
    parquet: bool = False,
    force: bool = False,
    workers: int | None = None,
    dask: str | None = None,
    progress: Progress = lambda done, of: None,
    **options: Any,
) -> Sample:
    """Find the load factors of a scene whose numbers are uncertain.

    >>> import masonry_opt as mo
    >>> found = mo.sample("wall.toml", {"joints.friction": ("lognormal", 0.65, "15%")}, n=256)
    >>> print(found)

    Numbers are independent of each other, but for those of joints in the way that ``by`` says.

    Parameters
    ----------
    scene:
        A scene, or the path of a case file.
    distributions:
        By names of numbers (as in ``mo.sweep``): ``("lognormal", mean, deviation)`` and ``("normal", mean,
        deviation)``, with mean and standard deviation of the number itself, the latter also as a share of
        the mean, ``"15%"``; ``("uniform", least, greatest)``; or a frozen distribution of ``scipy.stats``.
        Nothing is cut off: where values are drawn that the scene does not take, such as a friction below
        zero, nothing is run, and the error says how likely they are.
    n:
        Runs. With Sobol's sequence a power of two is best. A larger number adds to the runs of a smaller one.
    seed:
        Of the draws: the same seed gives the same table, whatever the number of workers.
    by:
        "scene": one value for all joints. "joint": properties of joints (``joints.friction``, ...) are drawn
        for each joint; "course": for each course, which are the joints at one height.
    correlation:
        Between the joints of a course (``by="course"``; 1 unless given: one value a course; courses are
        independent), or between all joints (``by="joint"``; 0 unless given). Of the normal scores from which
        values are made, so exactly that of normal distributions.
    sequence:
        "sobol", scrambled (the default up to 10 numbers), or "random" (the default above): independent
        points. Of many numbers Sobol's points move some as one, unless there are thousands of runs.
    method, model, solver, tolerance, **options:
        Of :func:`~masonry_opt.analysis.solve`.
    out:
        Folder for ``runs.csv``, ``quantiles.csv``, ``fragility.csv``, ``sensitivity.csv`` and a chart of
        each. Runs that it holds already are not made again.
    parquet, force, workers, dask, progress:
        As of ``mo.sweep``.

    Returns
    -------
    Sample
        The table of all runs, with quantiles of the load factor, probabilities of collapse and what matters.

    Raises
    ------
    OptionError
        If a name, distribution or argument is wrong, values are drawn that the scene does not take, or
        ``out`` holds runs of something else, or a table with other runs.
    CaseError
        If the scene is wrong.
    OutputError
        If ``out`` cannot be written; runs already made are kept.
    """
    scene = as_scene(scene)
    for name, value in (("n", n), ("seed", seed)):
        if not isinstance(value, int) or isinstance(value, bool) or value < (name == "n"):
            raise OptionError(f"{name} must be a whole number, {int(name == 'n')} or more (found {value!r})")
    refuse_options(method, model, solver, tolerance, options)
    if parquet:
        refuse_parquet()
    draws = Draws(scene, distributions, by, correlation)
    values = draws.table(n, seed, sequence)
    draws.refuse_impossible(values)
    study = Study(None if draws.spreads else scene, method, model, solver, tolerance, options)
    folder = None if out is None else Path(out)
    runs = table(
        study,
        [{str(name): value for name, value in row.items()} for row in values.to_dict("records")],
        make=draws.scene if draws.spreads else None,
        folder=folder,
        force=force,
        workers=workers,
        dask=dask,
        progress=progress,
    )
    found = Sample(
        case=scene.called,
        table=runs,
        drawn=tuple(map(str, values)),
        distributions={name: draws.told(name) for name in draws.distributions},
    )
    if folder is not None:
        # Charts are slow to import: only when they are needed.
        from masonry_opt.studies.many.folder import write_sample

        write_sample(found, folder, parquet)
    return found


class Draws:
    """What is drawn for a scene, and the scenes that it makes.

    Attributes
    ----------
    distributions: by name.
    spreads: properties that differ from joint to joint, by name; none if all are drawn once for all.
    """

    def __init__(
        self, scene: Scene, distributions: Mapping[str, Any], by: str, correlation: float | None
    ) -> None:
        if not isinstance(distributions, Mapping) or not distributions:
            raise OptionError(
                "name what is uncertain, with its distribution: {'joints.friction': ('lognormal', 0.6, 0.1)}"
            )
        if by not in BY:
            raise OptionError(f"by='{by}' is unknown; choose from: {', '.join(BY)}")
        if by == "scene" and correlation is not None:
            raise OptionError("correlation: goes with by='joint' or by='course'")
        self._correlation = float(by == "course") if correlation is None else correlation
        if not 0 <= self._correlation <= 1:
            raise OptionError(f"correlation must be between 0 and 1 (found {correlation!r})")
        self._parameters = Parameters(scene)
        self._parameters.check_names(distributions)
        self._by = by
        self.distributions: dict[str, Distribution] = {
            name: distribution(name, given) for name, given in distributions.items()
        }
        self.spreads = {
            name: Spread(scene, name, by, self._correlation)
            for name in self.distributions
            if by != "scene" and is_of_joints(name)
        }
        if by != "scene" and not self.spreads:
            raise OptionError(f"by='{by}': no property of joints is uncertain, such as 'joints.friction'")

    def told(self, name: str) -> str:
        """A number's distribution in words."""
        text = self.distributions[name].text
        if name not in self.spreads:
            return text
        return f"{text} by {self._by}, correlation {self._correlation:g}"

    def table(self, count: int, seed: int, sequence: str | None) -> pd.DataFrame:
        """The values of each run, one column a number."""
        if sequence is not None and sequence not in SEQUENCES:
            raise OptionError(f"sequence '{sequence}' is unknown; choose from: {', '.join(SEQUENCES)}")
        names: list[str] = []
        of: list[Distribution] = []
        groups: list[list[int]] = []
        for name, law in self.distributions.items():
            spread = self.spreads.get(name)
            units = [unit.name for unit in spread.units] if spread else [name]
            groups += [[len(names) + k for k in group] for group in (spread.groups if spread else [[0]])]
            names += units
            of += [law] * len(units)
        drawn = stats.norm.cdf(scores(count, groups, self._correlation, sequence, seed))
        values = {
            name: law.quantile(drawn[:, k]) for k, (name, law) in enumerate(zip(names, of, strict=True))
        }
        return pd.DataFrame(values)

    def refuse_impossible(self, table: pd.DataFrame) -> None:
        """Raise OptionError if the least or greatest value of a number makes no scene."""
        for name, law in self.distributions.items():
            spread = self.spreads.get(name)
            drawn = table[[unit.name for unit in spread.units] if spread else [name]].to_numpy()
            if not np.isfinite(drawn).all():
                raise OptionError(f"'{name}': {law.text} gives values that are no number")
            for value in (float(drawn.min()), float(drawn.max())):
                try:
                    self._parameters.at({name: value})
                except CaseError as error:
                    likely = law.below(0.0) if value < 0 else None
                    how = "" if likely is None else f" (values below 0: {likely:.2g} of all)"
                    raise OptionError(
                        f"'{name}': {law.text} gives {value:g}{how}, which the scene does not take: {error}; "
                        "take a distribution without such values, such as a lognormal, or one cut off, such "
                        "as scipy.stats.truncnorm"
                    ) from None

    def scene(self, values: Mapping[str, float]) -> Scene:
        """The scene of a run.

        Raises CaseError if its values make none.
        """
        once = {name: values[name] for name in self.distributions if name not in self.spreads}
        return with_values(self._parameters.at(once), list(self.spreads.values()), values)
