"""``sample``: a scene whose numbers are uncertain, solved for values drawn from their distributions."""

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
from masonry_opt.studies.many.run_warnings import is_limit
from masonry_opt.studies.many.runs import (
    INCREMENTAL_COLUMN,
    RunProgress,
    Study,
    StudyOutput,
    charts_if_installed,
    ends,
    run_many,
)
from masonry_opt.studies.runner import REFUSED, UNSOLVED, whole
from masonry_opt.studies.warning_codes import StudyCode, study_warning
from masonry_opt.studies.writing import StudyAnswer, chart_files, csv_text, records
from masonry_opt.words.load_factors import meaning
from masonry_opt.words.sentences import numeral

if TYPE_CHECKING:
    import altair

    from masonry_opt.studies.charts import NamedChart

RUNS = 128  #: Default number of runs: Sobol's points are most even for powers of two.
CONFIDENCE = 0.95  #: Confidence of intervals, unless another is asked for.
KINDS = ("fragility", "sensitivity")  #: Kinds of chart.
_TABLES = ("quantiles.csv", "fragility.csv", "sensitivity.csv")  #: Tables beside that of the runs.
_PRINTED = 5  #: Most rank correlations that are printed.


@dataclass(frozen=True)
class Sample(StudyAnswer):
    """The load factors of a scene whose numbers were drawn, and beside them the incremental load factors.

    A scene that falls by itself counts as collapsed at any load, a scene that is proven to carry any load as
    collapsed at none. Any other run without a load factor is ``undecided``: it did not converge, is unlimited
    without a proof, or its process crashed. Quantiles, probabilities and correlations are those of the
    decided runs. Their limits count the undecided runs both ways: the lower limit of a probability as not
    collapsed, the upper limit as collapsed. A run without an incremental load factor is undecided in the
    numbers of that load factor. These numbers are NaN if no run has one.

    A run is ``refused`` if the numbers drawn make no scene that can be solved. It counts nowhere.

    Intervals are those of independent runs, for any distribution. Up to 10 numbers are drawn by Sobol's
    points, which are closer to the truth than the intervals show.

    Attributes
    ----------
    case: case file or title of the scene.
    table: one row a run: the numbers drawn, then the columns of ``mo.sweep``.
    drawn: names of the columns that were drawn.
    distributions: of each number, in words.
    """

    case: str
    table: pd.DataFrame = field(repr=False)
    drawn: tuple[str, ...] = field(repr=False)
    distributions: Mapping[str, str]

    @property
    def runs(self) -> int:
        """Number of scenes solved."""
        return len(self.table)

    @property
    def load_factors(self) -> np.ndarray:
        """Load factor of each run that was not refused, shape (n,).

        It is -inf if the scene falls by itself, inf if it is proven to carry any load, and NaN if the run is
        undecided.
        """
        return self._of_runs("load_factor")

    @property
    def incremental(self) -> np.ndarray:
        """Incremental load factor of each run, as ``load_factors``; NaN where it is known of none."""
        known = self._counting["incremental"].notna().any()
        return self._of_runs("incremental") if known else np.full(len(self._counting), np.nan)

    @property
    def _counting(self) -> pd.DataFrame:
        """Rows of the runs that were not refused."""
        return self.table[self.table["status"] != REFUSED]

    def _of_runs(self, column: str) -> np.ndarray:
        rows = self._counting
        values = rows[column].to_numpy(dtype=float, copy=True)
        unknown = ~np.isfinite(values)
        values[unknown] = np.nan
        values[unknown & rows["any_load"].fillna(False).to_numpy(dtype=bool)] = math.inf
        values[unknown & (rows["status"] == str(Status.UNSTABLE)).to_numpy()] = -math.inf
        return values

    def _of_both(
        self, key: str, along: Sequence[Any], name: str, of: Callable[[np.ndarray], Sequence[Any]]
    ) -> pd.DataFrame:
        """Return a number of the load factors with its limits, and those of the incremental load factors."""
        columns: dict[str, Any] = {key: along}
        for begin, values in (("", self.load_factors), (INCREMENTAL_COLUMN, self.incremental)):
            told = 3 * (np.nan,) if np.isnan(values).all() else of(values)
            columns |= zip((begin + name, begin + "lower", begin + "upper"), told, strict=True)
        return pd.DataFrame(columns)

    @property
    def falling(self) -> int:
        """Runs whose scene falls by itself."""
        return int((self.table["status"] == str(Status.UNSTABLE)).sum())

    @property
    def unlimited(self) -> int:
        """Runs whose scene is proven to carry any load."""
        return int(np.isposinf(self.load_factors).sum())

    @property
    def undecided(self) -> int:
        """Runs that decide nothing, in the limits counted both as collapsed and as not."""
        return int(np.isnan(self.load_factors).sum())

    @property
    def refused(self) -> int:
        """Runs whose numbers make no scene that can be solved, which count nowhere."""
        return int((self.table["status"] == REFUSED).sum())

    @property
    def failed(self) -> int:
        """Runs whose process crashed, died or reached a limit: they are among the undecided ones."""
        return int(self._counting["status"].isin(UNSOLVED).sum())

    @property
    def counted(self) -> str:
        """Return how many runs there are, and how many of them have no load factor, in words."""
        known = self._counting["incremental"].notna().any()
        unexpected = known & np.isfinite(self.load_factors) & np.isnan(self.incremental)
        without = {
            "fell under dead load alone": self.falling,
            "carried any load": self.unlimited,
            "undecided: limits count them both as collapsed and as not": self.undecided,
            "without an incremental λ: its limits count them both ways": int(unexpected.sum()),
            "refused, left out": self.refused,
        }
        told = [f"{count} ({count / self.runs:.1%}) {what}" for what, count in without.items() if count]
        return "; ".join([counted(self.runs, "run"), *told])

    def quantiles(
        self, probabilities: Sequence[float] = (0.05, 0.5, 0.95), confidence: float = CONFIDENCE
    ) -> pd.DataFrame:
        """Quantiles of the load factor: ``probability``, ``value``, ``lower``, ``upper``; of the
        incremental load factor: ``incremental_value``, ``incremental_lower``, ``incremental_upper``.

        The limits are two of the ordered load factors, whose ranks are quantiles of the binomial distribution
        (n, p): on either side half of what the confidence leaves. A limit is NaN where there are too few runs
        to have one. Undecided runs come first in the order of the lower limit, and last in that of the upper.

        Raises OptionError if a probability is not between 0 and 1.
        """
        _refuse_shares(probabilities=probabilities, confidence=[confidence])

        def of(values: np.ndarray) -> Sequence[Any]:
            decided = values[~np.isnan(values)]
            first, last = (np.where(np.isnan(values), end, values) for end in (-math.inf, math.inf))
            lower, upper = (
                [stats.quantile_test(each, p=p).confidence_interval(confidence) for p in probabilities]
                for each in (first, last)
            )
            middle = np.quantile(decided, probabilities, method="inverted_cdf")
            return middle, [each.low for each in lower], [each.high for each in upper]

        return self._of_both("probability", probabilities, "value", of)

    def fragility(self, loads: Sequence[float] | None = None, confidence: float = CONFIDENCE) -> pd.DataFrame:
        """Probability of collapse at load factors: ``load``, ``probability``, ``lower``, ``upper``;
        by the incremental load factor ``incremental_probability``, ``incremental_lower``, ``incremental_upper``.

        It is the share of the decided runs whose load factor does not exceed them. The limits are Clopper &
        Pearson's, the lower one as if no undecided run had collapsed, the upper one as if all had. By default
        at the lowest and incremental load factors, and 5 % of their range to either side.

        Raises OptionError if the confidence is not between 0 and 1.
        """
        _refuse_shares(confidence=[confidence])
        if loads is None:
            found = np.unique(np.r_[self.load_factors, self.incremental])
            found = found[np.isfinite(found)]
            least, greatest = ends(found)
            aside = 0.05 * (greatest - least) if len(found) else 0.0
            loads = [max(least - aside, 0.0), *found.tolist(), greatest + aside]
        n, aside = len(self._counting), (1 - confidence) / 2

        def of(values: np.ndarray) -> Sequence[Any]:
            decided = np.sort(values[~np.isnan(values)])
            collapsed = np.searchsorted(decided, loads, side="right")
            most = collapsed + n - len(decided)
            with np.errstate(invalid="ignore"):
                lower = np.where(collapsed == 0, 0.0, stats.beta.ppf(aside, collapsed, n - collapsed + 1))
                upper = np.where(most == n, 1.0, stats.beta.ppf(1 - aside, most + 1, n - most))
            return collapsed / len(decided), lower, upper

        return self._of_both("load", loads, "probability", of)

    def sensitivity(self, confidence: float = CONFIDENCE) -> pd.DataFrame:
        """Spearman's rank correlation of the load factor with each number drawn, strongest first:
        ``parameter``, ``rank_correlation``, ``lower``, ``upper``; of the incremental load factor
        ``incremental_rank_correlation``, ``incremental_lower``, ``incremental_upper``. NaN where the load, or the
        number, is the same in all runs. Loads that differ by rounding have one rank; undecided runs
        have none.

        The interval is Fisher's, with Bonett & Wright's (2000) variance (1 + r²/2) / (n − 3). All intervals
        of one of the loads hold at once with the confidence (Bonferroni).

        Raises OptionError if the confidence is not between 0 and 1.
        """
        _refuse_shares(confidence=[confidence])
        drawn = self._counting[list(self.drawn)]
        each = stats.norm.ppf(1 - (1 - confidence) / 2 / max(drawn.shape[1], 1))

        def of(values: np.ndarray) -> Sequence[Any]:
            # Friction may jam in an undecided run: its load factor is neither the least nor the largest.
            told = ~np.isnan(values)
            values, known = values[told], np.abs(values[np.isfinite(values)])
            step = (SAME * float(np.median(known)) if len(known) else 0.0) or 1.0
            ranks = pd.Series(stats.rankdata(np.round(values / step)), drawn.index[told])
            r = drawn[told].rank().corrwith(ranks).to_numpy().clip(-1, 1)
            degrees = len(values) - 3
            half = each * np.sqrt((1 + r**2 / 2) / degrees) if degrees > 0 else np.inf
            # Of a perfect correlation Fisher's transform is infinite.
            middle = np.arctanh(r.clip(-1 + 1e-15, 1 - 1e-15))
            return r, np.tanh(middle - half), np.tanh(middle + half)

        found = self._of_both("parameter", self.drawn, "rank_correlation", of)
        # Rounded, and sorted stably: equal ones stay in the order in which they were named.
        strength = found.filter(like="rank_correlation").abs().max(axis=1).round(12)
        return found.loc[strength.sort_values(ascending=False, kind="stable").index].reset_index(drop=True)

    def tables(self) -> dict[str, pd.DataFrame]:
        """Quantiles, fragility and sensitivity, by these names."""
        return {name: getattr(self, name)() for name in ("quantiles", "fragility", "sensitivity")}

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        records = [*self.table.attrs.get("warning_records", ()), *self._without_answer()]
        return [*records, *self._falls()] if self.table.attrs.get("seeks_lowest", True) else records

    def _without_answer(self) -> Iterator[dict[str, Any]]:
        """Yield how many runs were refused or decide nothing, by status, and why the first one does."""
        refused = self.table[self.table["status"] == REFUSED]
        undecided = self._counting[np.isnan(self.load_factors)]
        for code, rows, what in (
            (StudyCode.RUNS_LEFT_OUT, refused, "left out"),
            (StudyCode.RUNS_UNDECIDED, undecided, "undecided"),
        ):
            for status in rows["status"].unique():
                same = rows[rows["status"] == status]
                why = str(same["message"].iloc[0] or "")
                sentence = f"{counted(len(same), 'run')} {what} ({status}): {why}".removesuffix(": ")
                yield study_warning(code, sentence, status=status, count=len(same), message=why)

    def _falls(self) -> Iterator[dict[str, Any]]:
        """Yield a record for each friction, cohesion or strength with whose growth the load factor falls.

        The whole confidence interval of the rank correlation must be below zero. The load factors must be
        those of a method that seeks the lowest state.
        """
        for row in self.sensitivity().to_dict("records"):
            parameter, correlation = row["parameter"], row["rank_correlation"]
            if row["upper"] < 0 and is_limit(parameter):
                falls = f"the load factor falls as {parameter} grows"
                by = f"rank correlation {numeral(correlation, '+.3f')}"
                reason = "more of it weakens the scene, or lower states were missed where there is less"
                sentence = f"{falls} ({by}): {reason} (option search=10 looks for them)"
                values = {"parameter": parameter, "rank_correlation": correlation}
                yield study_warning(StudyCode.FALLS_WITH_STRENGTH, sentence, **values)

    @property
    def told(self) -> pd.DataFrame:
        return self.quantiles()

    def _source(self) -> str:
        return self.drawing(KINDS[0]).source()

    def plot(self, kind: str = "fragility") -> "altair.TopLevelMixin":
        """Draw the "fragility" curve or the "sensitivity" to what was drawn, as a chart of Altair.

        Raises OptionError if there is no such kind, or Altair, of the extra "studies", is not installed.
        """
        if kind not in KINDS:
            raise OptionError(f"kind '{kind}' is unknown; choose from: {', '.join(KINDS)}")
        return self.drawing(kind).on_paper()

    def drawing(self, kind: str) -> "NamedChart":
        """The chart of a kind. Raises OptionError if Altair is not installed."""
        # Charts are slow to import: only when they are needed.
        from masonry_opt.studies.many import charts

        case = Path(self.case)
        # A scene made in Python has a title instead, which may have dots.
        name = case.stem if case.suffix in (".toml", ".json") else self.case
        title = f"{name}: {self.counted}"
        return getattr(charts, kind)(title, getattr(self, kind)(), f"{CONFIDENCE:.0%} confidence")

    def facts(self) -> dict[str, str]:
        drawn = "; ".join(f"{name} = {text}" for name, text in self.distributions.items())
        told = {"case": self.case, "drawn": drawn, "solved": self.counted}
        told["λ is"] = meaning(name for name in self._counting["which"].dropna() if name)
        lower, upper = self.table["spread_lower"], self.table["spread_upper"]
        if lower.notna().any():
            share = ((upper - lower) / self.table["incremental"]).median()
            within = f"{numeral(lower.min(), '.5f')} to {numeral(upper.max(), '.5f')}"
            by = f"by {share:.1%} (median) with other stiffness of contacts and self-stress"
            told["spread"] = f"the incremental λ of a run {by}, in all {within}"
        return told

    def __str__(self) -> str:
        text = []
        for row in self.quantiles().to_dict("records"):
            told = _told(row, "value", ".5f")
            text.append(f"{row['probability']:<6.0%} of λ below {told}, with {CONFIDENCE:.0%} confidence")
        for row in self.sensitivity().dropna(thresh=4).head(_PRINTED).to_dict("records"):
            text.append(f"rank correlation with {row['parameter']} {_told(row, 'rank_correlation', '+.3f')}")
        return printable("\n".join([super().__str__(), *text]))

    def as_dict(self) -> dict[str, Any]:
        """All but the single runs, as plain numbers, strings, lists and dictionaries (not finite: None)."""
        told: dict[str, Any] = {"case": self.case, "distributions": dict(self.distributions)}
        counts = ("runs", "falling", "unlimited", "undecided", "refused", "failed")
        told |= {name: getattr(self, name) for name in counts}
        told["warnings"] = self.warning_records
        tables = {name: records(frame) for name, frame in self.tables().items()}
        return told | {"confidence": CONFIDENCE} | tables


def _told(row: Mapping[Any, Any], name: str, spec: str) -> str:
    """Return a statistic of the load factor with its confidence limits, and of the incremental one."""

    def said(value: float) -> str:
        if math.isfinite(value):
            return numeral(value, spec)
        return "unknown" if math.isnan(value) else "none" if value < 0 else "any load"

    told = (
        map(said, (row[of + column] for column in (name, "lower", "upper")))
        for of in ("", INCREMENTAL_COLUMN)
    )
    found, beside = (f"{value} ({lower} to {upper})" for value, lower, upper in told)
    if math.isnan(row[INCREMENTAL_COLUMN + name]):
        return found
    return f"{found}; incremental {'the same' if beside == found else beside}"


def _refuse_shares(**shares: Sequence[float]) -> None:
    for name, values in shares.items():
        if wrong := [value for value in values if not 0 < value < 1]:
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
    """Find the load factors of a scene whose numbers are uncertain.

    >>> import masonry_opt as mo
    >>> found = mo.sample("wall.toml", {"joints.friction": ("lognormal", 0.65, "15%")}, n=256)
    >>> print(found)

    Numbers are independent of each other.

    Raises OptionError if a name, distribution or argument is wrong, the scene refuses a value drawn, or
    ``out`` holds runs of something else, a table with other runs, or files of these names that were not
    written here; CaseError if the scene is wrong; OutputError if ``out`` cannot be written (runs already made
    are kept); NoRunSolvedError if every run was refused or crashed.

    Parameters
    ----------
    scene: A scene, or the path of a case file.
    distributions: By names of numbers (as in ``mo.sweep``): ``("lognormal", mean, deviation)`` and
        ``("normal", mean, deviation)``, with mean and standard deviation of the number itself, the latter
        also as a share of the mean, ``"15%"``; ``("uniform", least, greatest)``; or a frozen distribution of
        ``scipy.stats``. If the scene refuses a value drawn, such as a friction below zero, nothing is run.
    n: Runs. A power of two is best. A larger number adds to the runs of a smaller one.
    seed: The same seed gives the same table, with any number of workers.
    by: "scene": one value for all joints. "course": properties of joints (``joints.friction``, ...) are drawn
        for each course (the joints at one height), independent of the others. "joint": for each joint.
    method, options: As of :func:`~masonry_opt.analysis.solve`, its model, solver, ... too.
    out: Folder for ``runs.csv``, ``quantiles.csv``, ``fragility.csv``, ``sensitivity.csv`` and charts of the
        last two. Runs that it holds already are not made again.
    force, workers, dask, progress: As of ``mo.sweep``.
    """
    scene = as_scene(scene)
    n, seed = whole("n", n, 1), whole("seed", seed, 0)
    draws = Draws(scene, distributions, by)
    values = draws.table(n, seed)
    study = Study(prepare(method, **options).how, draws.scene, scene)
    points: list[Any] = values.to_dict("records")
    output = None if out is None else StudyOutput(Path(out), [*_TABLES, *chart_files(KINDS)], force)
    table = run_many(study, points, output=output, by=(workers, dask), progress=progress)
    found = Sample(scene.called, table, tuple(column.name for column in draws.columns), draws.texts)
    if output is not None:
        tables = {f"{name}.csv": csv_text(frame) for name, frame in found.tables().items()}
        charts = charts_if_installed("Sample", lambda: [found.drawing(kind) for kind in KINDS])
        output.write(table, tables | charts)
    return found
