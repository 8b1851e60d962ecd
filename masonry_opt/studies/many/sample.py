"""Function ``sample``: load factors of a scene whose numbers are random, by Monte Carlo simulation."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from scipy import stats

from masonry_opt.analysis import prepare
from masonry_opt.effort import ignore_progress
from masonry_opt.errors import OptionError, counted, printable
from masonry_opt.methods.registry import DEFAULT, METHODS
from masonry_opt.problem.arguments import list_of_numbers, refuse_shares
from masonry_opt.problem.load_factor_scale import EQUALITY_TOLERANCE
from masonry_opt.reporting.load_factors import meaning
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.mistakes import instead_of
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.reasons import Status
from masonry_opt.studies.many.draws import Draws
from masonry_opt.studies.many.run_warnings import warnings_by_status, warnings_of_correlations
from masonry_opt.studies.many.runs import (
    INCREMENTAL_COLUMN,
    RunProgress,
    Study,
    StudyOutput,
    charts_if_installed,
    ends,
    run_many,
)
from masonry_opt.studies.many.sample_text import correlation_text, quantile_text, spread_text
from masonry_opt.studies.run_columns import CROSSED_RUNS, is_crossed
from masonry_opt.studies.runner import REFUSED, UNSOLVED, whole
from masonry_opt.studies.warning_codes import StudyCode
from masonry_opt.studies.writing import StudyAnswer, chart_files, csv_text, records

if TYPE_CHECKING:
    import altair

    from masonry_opt.studies.charts import NamedChart

RUNS = 128  #: Default number of runs: a power of two, for which Sobol points are most uniform.
CONFIDENCE = 0.95  #: Default confidence of intervals of quantiles, probabilities and correlations.
CHART_KINDS = ("fragility", "sensitivity")  #: Kinds of chart.
_TABLES = ("quantiles.csv", "fragility.csv", "sensitivity.csv")  #: Names of the files of statistics.
_PRINTED_CORRELATIONS = 5  #: Largest number of rank correlations that are printed; weaker ones are omitted.
#: Bound on the absolute correlations whose Fisher transform is computed. Larger correlations are replaced by
#: this value, because the transform of 1 is infinite.
_LARGEST_CORRELATION = 1 - 1e-15


@dataclass(frozen=True)
class Sample(StudyAnswer):
    """Load factors and incremental load factors of a scene for random values of its parameters.

    Runs without a load factor count as follows:

    - A scene that is unstable under its dead load counts as collapsed at any load.
    - A scene that is proven to carry any load collapses at no load.
    - Any other run is ``undecided``: it did not converge, was stopped by the time limit, is unlimited without
      a proof, or its process crashed. Quantiles, probabilities and correlations are those of the decided
      runs. Their limits allow for both cases: the lower limit of a probability counts undecided runs as not
      collapsed, the upper limit as collapsed.
    - A run without an incremental load factor is undecided in the statistics of the incremental load factor.
      These statistics are NaN if no run has an incremental load factor.
    - A run is ``refused`` if its values make no scene that can be solved. Statistics ignore these runs.

    Confidence intervals assume independent runs, and are valid for any distribution. Up to 10 numbers are
    drawn by Sobol points, whose statistics are more accurate than the intervals show.

    Attributes
    ----------
    case: Case file or title of the scene.
    table: Table with one row per run: the random values, then the columns of ``mo.sweep``.
    drawn: Names of the columns with random values.
    distributions: Distribution of each number, as text.
    """

    case: str
    table: pd.DataFrame = field(repr=False)
    drawn: tuple[str, ...] = field(repr=False)
    distributions: Mapping[str, str]

    @property
    def runs(self) -> int:
        """Number of runs."""
        return len(self.table)

    @property
    def load_factors(self) -> np.ndarray:
        """Load factor of each run with a valid scene, shape (n,).

        The value is -inf if the scene is unstable under its dead load, inf if the scene is proven to carry
        any load, and NaN if the run is undecided.
        """
        return self._of_runs("load_factor")

    @property
    def incremental(self) -> np.ndarray:
        """Incremental load factor of each run with a valid scene, shape (n,).

        All values are NaN if no run has an incremental load factor.
        """
        known = self._counting["incremental"].notna().any()
        return self._of_runs("incremental") if known else np.full(len(self._counting), np.nan)

    @property
    def _method(self) -> str:
        """Name of the method of all runs."""
        return str(self.table.attrs.get("method", DEFAULT))

    @property
    def _counting(self) -> pd.DataFrame:
        """Rows of the runs with a valid scene. Statistics are computed from these rows only."""
        return self.table[self.table["status"] != REFUSED]

    def _of_runs(self, column: str) -> np.ndarray:
        """Return a column of load factors; see ``load_factors`` for the values −inf, inf and NaN."""
        rows = self._counting
        values = rows[column].to_numpy(dtype=float, copy=True)
        # If the time limit ended a crossing, λ is only an upper bound, so the run is undecided.
        stopped = (rows["status"] == str(Status.TIME_LIMIT)).to_numpy()
        unknown = ~np.isfinite(values) | stopped
        values[unknown] = np.nan
        values[unknown & rows["any_load"].fillna(False).to_numpy(dtype=bool)] = math.inf
        values[unknown & (rows["status"] == str(Status.UNSTABLE)).to_numpy()] = -math.inf
        return values

    def _of_both(
        self, key: str, along: Sequence[Any], name: str, statistic: Callable[[np.ndarray], Sequence[Any]]
    ) -> pd.DataFrame:
        """Return a table with one statistic, for the load factors and for the incremental load factors.

        Parameters
        ----------
        key, along: Name and values of the first column.
        name: Name of the statistic's column.
        statistic: Returns the statistic of load factors, its lower and its upper limit, each along the rows.
        """
        columns: dict[str, Any] = {key: along}
        for prefix, load_factors in (("", self.load_factors), (INCREMENTAL_COLUMN, self.incremental)):
            decided = not np.isnan(load_factors).all()
            value, lower, upper = statistic(load_factors) if decided else (np.nan, np.nan, np.nan)
            columns |= {prefix + name: value, prefix + "lower": lower, prefix + "upper": upper}
        return pd.DataFrame(columns)

    @property
    def falling(self) -> int:
        """Number of runs whose scene is unstable under its dead load."""
        return int((self.table["status"] == str(Status.UNSTABLE)).sum())

    @property
    def unlimited(self) -> int:
        """Number of runs whose scene is proven to carry any load."""
        return int(np.isposinf(self.load_factors).sum())

    @property
    def undecided(self) -> int:
        """Number of undecided runs. Confidence limits cover both collapse and no collapse."""
        return int(np.isnan(self.load_factors).sum())

    @property
    def refused(self) -> int:
        """Number of runs whose values do not make a valid scene; statistics ignore these runs."""
        return int((self.table["status"] == REFUSED).sum())

    @property
    def failed(self) -> int:
        """Number of runs that crashed, or whose process died or exceeded a limit of time or memory.

        Failed runs also count as undecided.
        """
        return int(self._counting["status"].isin(UNSOLVED).sum())

    @property
    def counted(self) -> str:
        """Text with the number of all runs and, for each reason, the number of runs without a load factor."""
        has_incremental = self._counting["incremental"].notna().any()
        missing = has_incremental & np.isfinite(self.load_factors) & np.isnan(self.incremental)
        without = {
            "fell under dead load alone": self.falling,
            "carried any load": self.unlimited,
            "undecided (confidence limits cover both collapse and no collapse)": self.undecided,
            "without an incremental λ (confidence limits cover both collapse and no collapse)": missing.sum(),
            "refused, left out": self.refused,
        }
        shares = [f"{count} ({count / self.runs:.1%}) {kind}" for kind, count in without.items() if count]
        return "; ".join([counted(self.runs, "run"), *shares])

    def quantiles(
        self, probabilities: float | Sequence[float] = (0.05, 0.5, 0.95), confidence: float = CONFIDENCE
    ) -> pd.DataFrame:
        """Return quantiles of the load factor and of the incremental load factor, with confidence limits.

        The limits are two of the sorted load factors. Their ranks are quantiles of the binomial distribution
        (n, p), with equal probabilities on both sides. Undecided runs are sorted first for the lower limit,
        and last for the upper limit. A limit is NaN if there are too few runs to compute it.

        Parameters
        ----------
        probabilities: Probabilities of the quantiles, between 0 and 1.
        confidence: Confidence of the limits.

        Returns
        -------
        DataFrame
            Table with one row for each probability. The columns are ``probability``, ``value``, ``lower`` and
            ``upper``; those of the incremental load factor begin with ``incremental_``.

        Raises
        ------
        OptionError
            If a probability or the confidence is not between 0 and 1.
        """
        probabilities = list_of_numbers("probabilities", probabilities)
        refuse_shares(probabilities=probabilities, confidence=[confidence])

        def interval(values: np.ndarray, probability: float) -> Any:
            return stats.quantile_test(values, p=probability).confidence_interval(confidence)

        def statistic(values: np.ndarray) -> Sequence[Any]:
            undecided = np.isnan(values)
            value = np.quantile(values[~undecided], probabilities, method="inverted_cdf")
            first, last = np.where(undecided, -math.inf, values), np.where(undecided, math.inf, values)
            lower = [interval(first, p).low for p in probabilities]
            upper = [interval(last, p).high for p in probabilities]
            return value, lower, upper

        return self._of_both("probability", probabilities, "value", statistic)

    def fragility(
        self, loads: float | Sequence[float] | None = None, confidence: float = CONFIDENCE
    ) -> pd.DataFrame:
        """Return the probability of collapse at given load factors (the fragility curve).

        The probability is the fraction of decided runs whose load factor
        does not exceed the load, up to rounding. The limits are those of Clopper and Pearson (1934): the
        lower limit assumes that no undecided run has collapsed, the upper limit that all undecided runs have.

        Parameters
        ----------
        loads: Load factors. Default: those of all runs, where load factors that differ by rounding errors
            count as one, and two values that extend their range by 5 % at each end.
        confidence: Confidence of the limits.

        Returns
        -------
        DataFrame
            Table with one row for each load. The columns are ``load``, ``probability``, ``lower`` and
            ``upper``; those of the incremental load factor begin with ``incremental_``.

        Raises
        ------
        OptionError
            If a load is not a number, or if the confidence is not between 0 and 1.
        """
        refuse_shares(confidence=[confidence])
        loads = self._loads_of_runs() if loads is None else list_of_numbers("loads", loads)
        n, tail = len(self._counting), (1 - confidence) / 2
        upper_ends = np.asarray(loads, dtype=float)
        upper_ends = upper_ends + EQUALITY_TOLERANCE * np.abs(upper_ends)

        def statistic(values: np.ndarray) -> Sequence[Any]:
            decided = np.sort(values[~np.isnan(values)])
            collapsed = np.searchsorted(decided, upper_ends, side="right")
            most = collapsed + n - len(decided)
            with np.errstate(invalid="ignore"):
                lower = np.where(collapsed == 0, 0.0, stats.beta.ppf(tail, collapsed, n - collapsed + 1))
                upper = np.where(most == n, 1.0, stats.beta.ppf(1 - tail, most + 1, n - most))
            return collapsed / len(decided), lower, upper

        return self._of_both("load", loads, "probability", statistic)

    def _loads_of_runs(self) -> list[float]:
        """Return the load factors, in ascending order, at which the fragility curve is computed by default.

        These are all finite load factors and incremental load factors of the runs. One value below the least
        and one value above the greatest load factor are added, at a distance of 5 % of the range. The first
        value is not below zero. Of load factors that differ by rounding errors, only the largest is returned.
        """
        loads = np.unique(np.r_[self.load_factors, self.incremental])
        loads = loads[np.isfinite(loads)]
        is_largest = np.ones(len(loads), dtype=bool)
        is_largest[:-1] = np.diff(loads) > EQUALITY_TOLERANCE * np.abs(loads[1:])
        loads = loads[is_largest]
        least, greatest = ends(loads)
        margin = 0.05 * (greatest - least) if len(loads) else 0.0
        return [max(least - margin, 0.0), *loads.tolist(), greatest + margin]

    def sensitivity(self, confidence: float = CONFIDENCE) -> pd.DataFrame:
        """Return Spearman's rank correlations of λ with the random parameters, strongest first.

        A correlation is NaN if the load factor or the
        number is constant. Load factors that differ by rounding errors have equal ranks. Undecided runs are
        omitted.

        The interval uses Fisher's transform, with the variance (1 + r²/2) / (n − 3) of Bonett and Wright
        (2000). All intervals of a load factor contain the true correlations with a probability of at least
        ``confidence`` (Bonferroni correction).

        Parameters
        ----------
        confidence: Confidence of the intervals.

        Returns
        -------
        DataFrame
            Table with one row for each parameter. The columns are ``parameter``, ``rank_correlation``,
            ``lower`` and ``upper``; those of the incremental load factor begin with ``incremental_``.

        Raises
        ------
        OptionError
            If the confidence is not between 0 and 1.
        """
        refuse_shares(confidence=[confidence])
        drawn = self._counting[list(self.drawn)]
        deviations = stats.norm.ppf(1 - (1 - confidence) / 2 / max(drawn.shape[1], 1))

        def statistic(values: np.ndarray) -> Sequence[Any]:
            # Undecided runs (NaN) have no rank and are omitted.
            ranked = ~np.isnan(values)
            values, sizes = values[ranked], np.abs(values[np.isfinite(values)])
            step = (EQUALITY_TOLERANCE * float(np.median(sizes)) if len(sizes) else 0.0) or 1.0
            ranks = pd.Series(stats.rankdata(np.round(values / step)), drawn.index[ranked])
            r = drawn[ranked].rank().corrwith(ranks).to_numpy().clip(-1, 1)
            degrees = len(values) - 3
            half_width = deviations * np.sqrt((1 + r**2 / 2) / degrees) if degrees > 0 else np.inf
            middle = np.arctanh(r.clip(-_LARGEST_CORRELATION, _LARGEST_CORRELATION))
            return r, np.tanh(middle - half_width), np.tanh(middle + half_width)

        table = self._of_both("parameter", self.drawn, "rank_correlation", statistic)
        # Rounding and a stable sort keep equal correlations in the order of the distributions.
        strength = table.filter(like="rank_correlation").abs().max(axis=1).round(12)
        return table.loc[strength.sort_values(ascending=False, kind="stable").index].reset_index(drop=True)

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return the tables "quantiles", "fragility" and "sensitivity" by name."""
        return {name: getattr(self, name)() for name in ("quantiles", "fragility", "sensitivity")}

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        """Warnings of the single runs, and warnings about all runs together.

        The latter warn of runs without an answer, and of strengths whose increase lowers λ.
        """
        records = [*self.table.attrs.get("warning_records", ()), *self._without_answer()]
        if METHODS[self._method].seeks_lowest:
            records += warnings_of_correlations(self.sensitivity(), self._method)
        return records

    def _without_answer(self) -> Iterator[dict[str, Any]]:
        """Generate a warning for each status of invalid or undecided runs, with the number of these runs."""
        refused = self.table[self.table["status"] == REFUSED]
        undecided = self._counting[np.isnan(self.load_factors)]
        yield from warnings_by_status(StudyCode.RUNS_LEFT_OUT, refused, "left out")
        yield from warnings_by_status(StudyCode.RUNS_UNDECIDED, undecided, "undecided")

    @property
    def notebook_table(self) -> pd.DataFrame:
        """Table that a notebook displays: the quantiles of the load factor."""
        return self.quantiles()

    def _source(self) -> str:
        """Return the picture of the fragility curve as a data URL."""
        return self.drawing(CHART_KINDS[0]).source()

    def plot(self, kind: str = "fragility") -> "altair.TopLevelMixin":
        """Return the Altair chart of a statistic.

        Parameters
        ----------
        kind: "fragility" (probability of collapse) or "sensitivity" (rank correlations).

        Raises
        ------
        OptionError
            If the kind is unknown, or if the extra "studies" (Altair) is not installed.
        """
        if kind not in CHART_KINDS:
            raise OptionError(f"kind '{kind}' is unknown{instead_of(kind, CHART_KINDS)}")
        return self.drawing(kind).on_paper()

    def drawing(self, kind: str) -> "NamedChart":
        """Return the chart of the given kind, with its name, title and notes.

        Raises OptionError if Altair is not installed.
        """
        # The module of charts is slow to import, so it is imported only here.
        from masonry_opt.studies.many import charts

        case = Path(self.case)
        # The name of a case file is printed without its extension. The title of a scene made in Python is
        # printed in full, because a dot in a title does not begin an extension.
        title = f"{case.stem if case.suffix in ('.toml', '.json') else self.case}: {self.counted}"
        own = " or ".join(sorted(filter(None, self._counting["which"].dropna().unique()))) or "load factor"
        return getattr(charts, kind)(title, getattr(self, kind)(), f"{CONFIDENCE:.0%} confidence", own)

    def facts(self) -> dict[str, str]:
        """Return the printed lines of the answer, as a dict from the label of each line to its text."""
        drawn = "; ".join(f"{name} = {text}" for name, text in self.distributions.items())
        facts = {"case": self.case, "drawn": drawn, "solved": self.counted}
        facts["λ is"] = meaning(name for name in self._counting["which"].dropna() if name)
        if is_crossed(self.table):
            facts["axles"] = CROSSED_RUNS
        if self.table["spread_lower"].notna().any():
            facts["spread"] = spread_text(self.table)
        return facts

    def __str__(self) -> str:
        lines = [quantile_text(row, CONFIDENCE) for row in self.quantiles().to_dict("records")]
        printed = self.sensitivity().dropna(thresh=4).head(_PRINTED_CORRELATIONS)
        lines += map(correlation_text, printed.to_dict("records"))
        return printable("\n".join([super().__str__(), *lines]))

    def as_dict(self) -> dict[str, Any]:
        """Return the statistics as plain values, with None for numbers that are not finite."""
        result: dict[str, Any] = {"case": self.case, "distributions": dict(self.distributions)}
        counts = ("runs", "falling", "unlimited", "undecided", "refused", "failed")
        result |= {name: getattr(self, name) for name in counts}
        result["warnings"] = self.warning_records
        tables = {name: records(frame) for name, frame in self.tables().items()}
        return result | {"confidence": CONFIDENCE} | tables


def sample(  # noqa: PLR0913 - options of the public API are keywords
    scene: Scene | str | Path,
    distributions: Mapping[str, Any],
    *,
    n: int = RUNS,
    seed: int = 0,
    by: str = "scene",
    method: str = DEFAULT,
    out: str | Path | None = None,
    force: bool = False,
    workers: int | None = None,
    dask: str | None = None,
    progress: RunProgress = ignore_progress,
    **options: Any,
) -> Sample:
    """Solve a scene for random, independent values of its uncertain parameters.

    Axles cross the scene in each run if the scene has axles, as in ``mo.sweep``.

    >>> import masonry_opt as mo
    >>> wall = mo.sample("wall.toml", {"joints.friction": ("lognormal", 0.65, "15%")}, n=256)
    >>> print(wall)

    Parameters
    ----------
    scene: A scene, or the path of a case file.
    distributions: By names of numbers (as in ``mo.sweep``): ``("lognormal", mean, deviation)`` and
        ``("normal", mean, deviation)``, with mean and standard deviation of the number itself; the deviation
        may be a fraction of the mean, ``"15%"``. Others are ``("uniform", least, greatest)`` and frozen
        distributions of ``scipy.stats``. If a value is impossible, such as a friction below 0, nothing is
        run.
    n: Number of runs, best a power of two. The runs of a smaller number are the first of a larger number.
    seed: Seed of the random numbers. Equal seeds give equal tables, with any number of workers.
    by: "scene": one value for all joints. "course": properties of joints (``joints.friction``, ...) are drawn
        for each course (the joints at one height), independent of the others. "joint": for each joint.
    method, options: As for :func:`~masonry_opt.solve`, including ``model``, ``solver``, ...
    out: Folder for ``runs.csv``, ``quantiles.csv``, ``fragility.csv``, ``sensitivity.csv`` and charts of the
        last two. Runs that the folder already contains are not made again.
    force, workers, dask, progress: As for ``mo.sweep``.

    Returns
    -------
    Sample
        The runs, with quantiles, fragility curve and rank correlations.

    Raises
    ------
    OptionError
        If a name, a distribution or an argument is wrong, if the scene refuses a random value, or if ``out``
        has runs of another study, a table with other runs, or files with the same names from other programs.
    CaseError
        If the scene is wrong.
    OutputError
        If ``out`` cannot be written. Finished runs are kept.
    NoRunSolvedError
        If every run was refused or crashed.
    """
    scene = as_scene(scene)
    n, seed = whole("n", n, 1), whole("seed", seed, 0)
    draws = Draws(scene, distributions, by)
    values = draws.table(n, seed)
    study = Study(prepare(method, function=sample, **options).how, draws.scene, scene)
    points: list[Any] = values.to_dict("records")
    output = None if out is None else StudyOutput(Path(out), [*_TABLES, *chart_files(CHART_KINDS)], force)
    table = run_many(study, points, output=output, by=(workers, dask), progress=progress)
    drawn = Sample(scene.called, table, tuple(column.name for column in draws.columns), draws.texts)
    if output is not None:
        tables = {f"{name}.csv": csv_text(frame) for name, frame in drawn.tables().items()}
        title = f"Sample of {scene.called}"
        output.write(table, tables | charts_if_installed(title, lambda: [*map(drawn.drawing, CHART_KINDS)]))
    return drawn
