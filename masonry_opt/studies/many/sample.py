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
from masonry_opt.answer.reasons import Status
from masonry_opt.answer.thresholds import SAME
from masonry_opt.errors import OptionError, counted, printable
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.many.draws import Draws
from masonry_opt.studies.many.run_warnings import FALLS_WITH_STRENGTH, is_limit
from masonry_opt.studies.many.runs import (
    EXPECTED,
    RunProgress,
    Study,
    StudyOutput,
    charts_if_installed,
    ends,
    run_many,
)
from masonry_opt.studies.runner import REFUSED, UNSOLVED, whole
from masonry_opt.studies.writing import StudyAnswer, chart_files, csv_text, records
from masonry_opt.words.load_factors import meaning
from masonry_opt.words.sentences import numeral

if TYPE_CHECKING:
    import altair

    from masonry_opt.studies.charts import NamedChart

RUNS = 128  #: Default number of runs, a power of two: Sobol points are most uniform for powers of two.
CONFIDENCE = 0.95  #: Default confidence of intervals.
KINDS = ("fragility", "sensitivity")  #: Kinds of chart.
_TABLES = ("quantiles.csv", "fragility.csv", "sensitivity.csv")  #: Files of tables, in addition to the runs.
_PRINTED_CORRELATIONS = 5  #: Largest number of rank correlations that are printed.
#: Largest size of a correlation before Fisher's transform, which is infinite for a correlation of 1.
_LARGEST_CORRELATION = 1 - 1e-15


@dataclass(frozen=True)
class Sample(StudyAnswer):
    """Load factors, and incremental load factors, of a scene for random values of its numbers.

    Runs without a load factor count as follows, so that no probability of collapse is too low:

    - A scene that is proven to carry any load collapses at no load.
    - Any other run counts as collapsed at any load: the scene is unstable under its dead load, or the run is
      ``undecided`` (not converged, unlimited without a proof, ...).
    - A run without an incremental load factor counts as collapsed at any load in the statistics of the
      incremental load factor. These statistics are NaN if no run has an incremental load factor.
    - A run is ``refused`` if its values make no scene that can be solved, and ``failed`` if its process
      crashed or died. Quantiles, probabilities and correlations leave both out.

    Confidence intervals assume independent runs, and hold for any distribution. Up to 10 numbers are drawn
    by Sobol points, whose statistics are more accurate than the intervals show.

    Attributes
    ----------
    case: Case file or title of the scene.
    table: One row a run: the random values, then the columns of ``mo.sweep``.
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
        """Load factor of each run that was solved, shape (n,).

        The load factor is -inf if the run counts as collapsed at any load, and inf if it collapses at none.
        """
        return self._of_runs("load_factor")

    @property
    def expected(self) -> np.ndarray:
        """Incremental load factor of each run that was solved, shape (n,), counted as ``load_factors``.

        All values are NaN if no run has an incremental load factor.
        """
        known = self._counting["expected"].notna().any()
        return self._of_runs("expected") if known else np.full(len(self._counting), np.nan)

    @property
    def _counting(self) -> pd.DataFrame:
        """Rows of the runs that were solved."""
        return self.table[~self.table["status"].isin(UNSOLVED)]

    def _of_runs(self, column: str) -> np.ndarray:
        """Return a column of load factors, with ±inf for the runs without one; see ``load_factors``."""
        values = self._counting[column].to_numpy(dtype=float)
        any_load = self._counting["any_load"].fillna(False).to_numpy(dtype=bool)
        without_value = np.where(any_load, math.inf, -math.inf)
        return np.where(np.isfinite(values), values, without_value)

    def _of_both(
        self, key: str, along: Sequence[Any], name: str, statistic: Callable[[np.ndarray], Sequence[Any]]
    ) -> pd.DataFrame:
        """Return a statistic of the load factors and of the incremental load factors as a table.

        Parameters
        ----------
        key, along: Name and values of the first column.
        name: Name of the statistic's column.
        statistic: Returns the statistic of load factors, its lower and its upper limit, each along the rows.
        """
        columns: dict[str, Any] = {key: along}
        for prefix, load_factors in (("", self.load_factors), (EXPECTED, self.expected)):
            known = not np.isnan(load_factors).any()
            value, lower, upper = statistic(load_factors) if known else (np.nan, np.nan, np.nan)
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
        """Number of other runs without a load factor, which count as collapsed at any load."""
        return int(np.isneginf(self.load_factors).sum()) - self.falling

    @property
    def refused(self) -> int:
        """Number of runs whose values make no scene that can be solved; no statistic counts them."""
        return int((self.table["status"] == REFUSED).sum())

    @property
    def failed(self) -> int:
        """Number of runs whose process crashed or died; no statistic counts them."""
        return self.runs - len(self._counting) - self.refused

    @property
    def counted(self) -> str:
        """Number of runs, and numbers of runs without a load factor, as text."""
        unexpected = np.isfinite(self.load_factors) & np.isneginf(self.expected)
        without = {
            "fell under dead load alone": self.falling,
            "carried any load": self.unlimited,
            "undecided, counted as fallen": self.undecided,
            "without an incremental λ, counted as fallen there": unexpected.sum(),
            "refused, left out": self.refused,
            "crashed or died, left out": self.failed,
        }
        shares = [f"{count} ({count / self.runs:.1%}) {kind}" for kind, count in without.items() if count]
        return "; ".join([counted(self.runs, "run"), *shares])

    def quantiles(
        self, probabilities: Sequence[float] = (0.05, 0.5, 0.95), confidence: float = CONFIDENCE
    ) -> pd.DataFrame:
        """Return quantiles of the load factor and of the incremental load factor, with confidence limits.

        The columns are ``probability``, ``value``, ``lower`` and ``upper``; those of the incremental load
        factor begin with ``expected_``. The limits are two of the sorted load factors. Their ranks are
        quantiles of the binomial distribution (n, p), with equal probabilities on both sides. A limit is NaN
        if there are too few runs for it.

        Raises OptionError if a probability is not between 0 and 1.
        """
        _refuse_shares(probabilities=probabilities, confidence=[confidence])

        def statistic(values: np.ndarray) -> Sequence[Any]:
            limits = [stats.quantile_test(values, p=p).confidence_interval(confidence) for p in probabilities]
            return np.quantile(values, probabilities, method="inverted_cdf"), *zip(*limits, strict=True)

        return self._of_both("probability", probabilities, "value", statistic)

    def fragility(self, loads: Sequence[float] | None = None, confidence: float = CONFIDENCE) -> pd.DataFrame:
        """Return the probability of collapse at given load factors (the fragility curve).

        The columns are ``load``, ``probability``, ``lower`` and ``upper``; those by the incremental load
        factor begin with ``expected_``. The probability is the share of runs whose load factor does not
        exceed the load. The limits are those of Clopper and Pearson (1934).

        Raises OptionError if the confidence is not between 0 and 1.

        Parameters
        ----------
        loads: Load factors. Default: those of all runs, and 5 % of their range beyond both ends.
        confidence: Confidence of the limits.
        """
        _refuse_shares(confidence=[confidence])
        if loads is None:
            loads = self._loads_of_runs()
        n, tail = len(self._counting), (1 - confidence) / 2

        def statistic(values: np.ndarray) -> Sequence[Any]:
            collapsed = np.searchsorted(np.sort(values), loads, side="right")
            with np.errstate(invalid="ignore"):
                lower = np.where(collapsed == 0, 0.0, stats.beta.ppf(tail, collapsed, n - collapsed + 1))
                upper = np.where(collapsed == n, 1.0, stats.beta.ppf(1 - tail, collapsed + 1, n - collapsed))
            return collapsed / n, lower, upper

        return self._of_both("load", loads, "probability", statistic)

    def _loads_of_runs(self) -> list[float]:
        """Return all finite load factors of the runs, and 5 % of their range beyond both ends."""
        loads = np.unique(np.r_[self.load_factors, self.expected])
        loads = loads[np.isfinite(loads)]
        least, greatest = ends(loads)
        margin = 0.05 * (greatest - least) if len(loads) else 0.0
        return [max(least - margin, 0.0), *loads.tolist(), greatest + margin]

    def sensitivity(self, confidence: float = CONFIDENCE) -> pd.DataFrame:
        """Return Spearman's rank correlation of the load factor with each random number, strongest first.

        The columns are ``parameter``, ``rank_correlation``, ``lower`` and ``upper``; those of the
        incremental load factor begin with ``expected_``. A correlation is NaN if the load factor or the
        number is constant. Load factors that differ by rounding errors have equal ranks. Runs with a load
        factor but without an incremental load factor are left out of the incremental correlation.

        The interval uses Fisher's transform, with the variance (1 + r²/2) / (n − 3) of Bonett and Wright
        (2000). The intervals of all numbers hold together with the given confidence (Bonferroni).

        Raises OptionError if the confidence is not between 0 and 1.
        """
        _refuse_shares(confidence=[confidence])
        drawn = self._counting[list(self.drawn)]
        deviations = stats.norm.ppf(1 - (1 - confidence) / 2 / max(drawn.shape[1], 1))

        def statistic(values: np.ndarray) -> Sequence[Any]:
            # A run may lack an incremental load factor because friction locks: its rank is unknown.
            ranked = ~(np.isneginf(values) & np.isfinite(self.load_factors))
            values, sizes = values[ranked], np.abs(values[np.isfinite(values)])
            step = (SAME * float(np.median(sizes)) if len(sizes) else 0.0) or 1.0
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
        """Warnings of the runs, on runs left out, and on load factors that fall as a strength grows."""
        records = [*self.table.attrs.get("warning_records", ()), *self._left_out()]
        if self.table.attrs.get("seeks_lowest", True):
            records += [{"sentence": sentence, "code": FALLS_WITH_STRENGTH} for sentence in self._falls()]
        return records

    def _left_out(self) -> Iterator[dict[str, Any]]:
        """Yield a warning for each kind of run that was left out: their number, and the first reason."""
        for status in UNSOLVED:
            rows = self.table[self.table["status"] == status]
            if len(rows):
                why = f"{counted(len(rows), 'run')} {status}, and left out: {rows['message'].iloc[0]}"
                yield {"sentence": why, "code": f"runs {status}"}

    def _falls(self) -> Iterator[str]:
        """Yield a sentence for each friction, cohesion or strength with whose growth the load factor falls.

        The whole confidence interval of the rank correlation must be below zero. The load factors must be
        those of a method that seeks the lowest state.
        """
        for row in self.sensitivity().to_dict("records"):
            if row["upper"] < 0 and is_limit(row["parameter"]):
                falls = f"the load factor falls as {row['parameter']} grows"
                by = f"rank correlation {numeral(row['rank_correlation'], '+.3f')}"
                reason = "more of it weakens the scene, or lower states were missed where there is less"
                yield f"{falls} ({by}): {reason} (method 'refined' with search=10 looks for them)"

    @property
    def told(self) -> pd.DataFrame:
        """Table that a notebook shows: the quantiles."""
        return self.quantiles()

    def _source(self) -> str:
        """Return the fragility curve as the address of an image."""
        return self.drawing(KINDS[0]).source()

    def plot(self, kind: str = "fragility") -> "altair.TopLevelMixin":
        """Return the "fragility" curve, or the "sensitivity" to each random number, as an Altair chart.

        Raises OptionError if the kind is unknown, or if the extra "studies" (Altair) is not installed.
        """
        if kind not in KINDS:
            raise OptionError(f"kind '{kind}' is unknown; choose from: {', '.join(KINDS)}")
        return self.drawing(kind).on_paper()

    def drawing(self, kind: str) -> "NamedChart":
        """Return the chart of a kind, with its name, title and notes.

        Raises OptionError if Altair is not installed.
        """
        # The module of charts is slow to import, so it is imported only here.
        from masonry_opt.studies.many import charts

        case = Path(self.case)
        # A scene made in Python has a title in place of a path; the title may contain dots.
        name = case.stem if case.suffix in (".toml", ".json") else self.case
        title = f"{name}: {self.counted}"
        return getattr(charts, kind)(title, getattr(self, kind)(), f"{CONFIDENCE:.0%} confidence")

    def facts(self) -> dict[str, str]:
        """Return the findings by label, as printed."""
        drawn = "; ".join(f"{name} = {text}" for name, text in self.distributions.items())
        facts = {"case": self.case, "drawn": drawn, "solved": self.counted}
        facts["λ is"] = meaning(name for name in self._counting["which"].dropna() if name)
        lower, upper = self.table["spread_lower"], self.table["spread_upper"]
        if lower.notna().any():
            share = ((upper - lower) / self.table["expected"]).median()
            within = f"{numeral(lower.min(), '.5f')} to {numeral(upper.max(), '.5f')}"
            by = f"by {share:.1%} (median) with other stiffness of contacts and self-stress"
            facts["spread"] = f"the incremental λ of a run {by}, in all {within}"
        return facts

    def __str__(self) -> str:
        lines = []
        for row in self.quantiles().to_dict("records"):
            value = _statistic_text(row, "value", ".5f")
            lines.append(f"{row['probability']:<6.0%} of λ below {value}, with {CONFIDENCE:.0%} confidence")
        for row in self.sensitivity().dropna(thresh=4).head(_PRINTED_CORRELATIONS).to_dict("records"):
            correlation = _statistic_text(row, "rank_correlation", "+.3f")
            lines.append(f"rank correlation with {row['parameter']} {correlation}")
        return printable("\n".join([super().__str__(), *lines]))

    def as_dict(self) -> dict[str, Any]:
        """Return everything but the single runs as plain values; numbers that are not finite are None."""
        result: dict[str, Any] = {"case": self.case, "distributions": dict(self.distributions)}
        counts = ("runs", "falling", "unlimited", "undecided", "refused", "failed")
        result |= {name: getattr(self, name) for name in counts}
        result["warnings"] = self.warning_records
        tables = {name: records(frame) for name, frame in self.tables().items()}
        return result | {"confidence": CONFIDENCE} | tables


def _statistic_text(row: Mapping[Any, Any], name: str, spec: str) -> str:
    """Return a statistic with its limits as text, of the load factor and of the incremental load factor.

    Parameters
    ----------
    row: Row of a table of ``Sample``.
    name: Name of the statistic's column.
    spec: Format of numbers.
    """

    def with_limits(prefix: str) -> str:
        value, lower, upper = (_value_text(row[prefix + end], spec) for end in (name, "lower", "upper"))
        return f"{value} ({lower} to {upper})"

    statistic = with_limits("")
    if math.isnan(row[EXPECTED + name]):
        return statistic
    incremental = with_limits(EXPECTED)
    return f"{statistic}; incremental {'the same' if incremental == statistic else incremental}"


def _value_text(value: float, spec: str) -> str:
    """Return a load factor, or a statistic of load factors, as text; words if it is not finite."""
    if math.isfinite(value):
        return numeral(value, spec)
    if math.isnan(value):
        return "unknown"
    return "none" if value < 0 else "any load"


def _refuse_shares(**shares: Sequence[float]) -> None:
    """Raise OptionError for the first number that is not between 0 and 1, with its name."""
    for name, values in shares.items():
        wrong = [value for value in values if not 0 < value < 1]
        if wrong:
            raise OptionError(f"{name} must lie between 0 and 1 (found {wrong[0]})")


def sample(
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
    progress: RunProgress = lambda done, of: None,
    **options: Any,
) -> Sample:
    """Solve a scene for random values of its uncertain numbers, which are independent of each other.

    >>> import masonry_opt as mo
    >>> wall = mo.sample("wall.toml", {"joints.friction": ("lognormal", 0.65, "15%")}, n=256)
    >>> print(wall)

    Parameters
    ----------
    scene: A scene, or the path of a case file.
    distributions: By names of numbers (as in ``mo.sweep``): ``("lognormal", mean, deviation)`` and
        ``("normal", mean, deviation)``, with mean and standard deviation of the number itself, the latter
        also as a share of the mean, ``"15%"``; ``("uniform", least, greatest)``; or a frozen distribution of
        ``scipy.stats``. If the scene refuses a value drawn, such as a friction below zero, nothing is run.
    n: Number of runs, best a power of two. The runs of a smaller number are the first of a larger number.
    seed: Seed of the random numbers. Equal seeds give equal tables, with any number of workers.
    by: "scene": one value for all joints. "course": properties of joints (``joints.friction``, ...) are drawn
        for each course (the joints at one height), independent of the others. "joint": for each joint.
    method, options: As of :func:`~masonry_opt.analysis.solve`, its model, solver, ... too.
    out: Folder for ``runs.csv``, ``quantiles.csv``, ``fragility.csv``, ``sensitivity.csv`` and charts of the
        last two. Runs that it holds already are not made again.
    force, workers, dask, progress: As of ``mo.sweep``.

    Returns
    -------
    Sample
        The runs, with quantiles, fragility curve and rank correlations.

    Raises
    ------
    OptionError
        If a name, a distribution or an argument is wrong, if the scene refuses a random value, or if ``out``
        holds runs of another study, a table with other runs, or files with the same names from other
        programs.
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
    study = Study(prepare(method, **options).how, draws.scene, scene)
    points: list[Any] = values.to_dict("records")
    output = None if out is None else StudyOutput(Path(out), [*_TABLES, *chart_files(KINDS)], force)
    table = run_many(study, points, output=output, by=(workers, dask), progress=progress)
    drawn = Sample(scene.called, table, tuple(column.name for column in draws.columns), draws.texts)
    if output is not None:
        tables = {f"{name}.csv": csv_text(frame) for name, frame in drawn.tables().items()}
        charts = charts_if_installed("Sample", lambda: [drawn.drawing(kind) for kind in KINDS])
        output.write(table, tables | charts)
    return drawn
