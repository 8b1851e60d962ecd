"""Answer of ``least`` and ``most``: the interval that contains the threshold, and all trials."""

import math
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from masonry_opt.brief import brief
from masonry_opt.files import plain
from masonry_opt.reporting.load_factors import meaning
from masonry_opt.reporting.sentences import numeral
from masonry_opt.reporting.summary import crushing
from masonry_opt.result import distinct_warnings
from masonry_opt.studies.many.threshold_text import distinguishing_digits, rounded_outwards
from masonry_opt.studies.many.trial import FALLS, UNLIMITED, Trial
from masonry_opt.studies.run_columns import ANSWER_COLUMNS, CROSSING_COLUMNS, framed
from masonry_opt.studies.warning_codes import StudyCode, study_warning
from masonry_opt.studies.writing import StudyAnswer

#: Printed texts for load factors that are infinite.
_INFINITE_FACTOR_TEXTS = {FALLS: "none (unstable under dead load)", UNLIMITED: "any"}
#: First columns of a table of trials, with their types. The columns are attributes of a trial.
_TRIAL_COLUMNS = {"value": "float64", "holds": "bool", "number": "float64"}
_VALUE_DIGITS = 9  #: Least number of significant digits with which the ends of an interval are printed.
_NUMBER_DIGITS = 6  #: Least number of significant digits with which load factors are printed.


@dataclass(frozen=True)
class Threshold(StudyAnswer):
    """Least or greatest value of a parameter at which a scene is stable, or carries a required load.

    Attributes
    ----------
    least: True if the scene holds (is stable or carries ``load``) from ``value`` upwards; False if downwards.
    load: Load factor to be carried; None if the scene is to be stable under its dead load alone.
    value: The threshold, interpolated between the two ends; at a jump the end at which the scene holds.
    holds, fails: The two ends of the interval that contains the threshold. Both are solved.
    jump: Load factors (without ``load``: margins) at the failing and the holding end if they differ much more
        than the slopes next to the interval predict: the mechanism changes, joints lock, or the scene itself
        changes. Otherwise, or if both slopes are unknown, None.
    contradictions: Values that were tried on the failing side of the threshold, and at which the scene holds.
    trials: All trials, in the order in which they were solved.
    """

    least: bool
    load: float | None
    value: float
    holds: Trial
    fails: Trial
    jump: tuple[float, float] | None
    contradictions: tuple[float, ...]
    trials: tuple[Trial, ...] = field(repr=False)

    __repr__ = brief

    @property
    def interval(self) -> tuple[float, float]:
        """Lower and upper end of the interval that contains the threshold."""
        return min(self.holds.value, self.fails.value), max(self.holds.value, self.fails.value)

    @property
    def evaluations(self) -> int:
        """Number of scenes that were solved."""
        return len(self.trials)

    @property
    def history(self) -> pd.DataFrame:
        """Table of all trials: columns ``value``, ``holds`` and ``number``, and the columns of ``mo.sweep``.

        If axles move over the scene, the table has the columns of their worst position too.
        """
        rows = [
            {name: getattr(trial, name) for name in _TRIAL_COLUMNS}
            | trial.answer.columns()
            | {"seconds": sum(trial.result.seconds.values())}
            for trial in self.trials
        ]
        crossed = any(trial.answer.crossing for trial in self.trials)
        return framed(rows, _TRIAL_COLUMNS, ANSWER_COLUMNS | (CROSSING_COLUMNS if crossed else {}))

    @property
    def notebook_table(self) -> pd.DataFrame:
        """Table that a notebook displays: the columns ``value``, ``holds`` and ``number`` of all trials."""
        return self.history[[*_TRIAL_COLUMNS]]

    @property
    def _kind(self) -> str:
        """Printed kind of the threshold, "least" or "greatest"."""
        return "least" if self.least else "greatest"

    @property
    def _measure(self) -> str:
        """Printed name of ``Trial.number``: "margin" under the dead load alone, otherwise "load factor"."""
        return "margin" if self.load is None else "load factor"

    def facts(self) -> dict[str, str]:
        """Return the printed lines of the answer, as a dict from the label of each line to its text."""
        meets = (
            "the scene is stable under its dead load"
            if self.load is None
            else f"λ is at least {numeral(self.load, 'g')}"
        )
        value = f"{self._rounded(self.holds)}, at which {meets}"
        if self.value != self.holds.value:
            value += (
                " (threshold, interpolated between the holding and the failing value: "
                f"{numeral(self.value, '.9g')})"
            )
        facts = {
            f"{self._kind} value": value,
            "holds": self._end(self.holds),
            "fails": self._end(self.fails),
            "scenes solved": str(self.evaluations),
        }
        if self._names:
            facts["λ is"] = meaning(self._names)
        law = crushing(self.holds.result)
        if law:
            facts["crushing"] = law
        if self.jump:
            before, after = (
                _INFINITE_FACTOR_TEXTS.get(number) or numeral(number, ".6g") for number in self.jump
            )
            facts["jump"] = f"the {self._measure} jumps from {before} to {after}"
        return facts

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        """Warnings of the results at both ends of the interval, and a warning about further thresholds."""
        records = distinct_warnings([self.holds.answer, self.fails.answer])
        if not self.contradictions:
            return records
        values = ", ".join(f"{value:.6g}" for value in self.contradictions)
        side = "below" if self.least else "above"
        sentence = (
            f"the scene also meets the requirement at {values}, {side} the threshold: search around these "
            "values too"
        )
        contradictions = list(self.contradictions)
        return [study_warning(StudyCode.SEVERAL_THRESHOLDS, sentence, values=contradictions), *records]

    @property
    def _names(self) -> list[str]:
        """Names of the load factors at both ends of the interval; empty if only the dead load acts."""
        if self.load is None:
            return []
        return [end.name for end in (self.holds, self.fails) if math.isfinite(end.number)]

    def _rounded(self, end: Trial) -> str:
        """Return an end of the interval as text, rounded so that the printed interval contains the exact one.

        If there is one threshold in the range, the scene thus also holds at the printed holding end, and
        fails at the printed failing end.
        """
        digits = distinguishing_digits(self.fails.value, [self.holds.value], _VALUE_DIGITS)
        return rounded_outwards(end.value, digits, upwards=end.holds == self.least)

    def _end(self, end: Trial) -> str:
        """Return a text that describes one end of the interval that contains the threshold.

        It states the value, the load factor (under dead load alone: the margin), and the largest residual.
        The numbers have enough digits to distinguish both ends, and the failing end from the load.
        """
        value = self._rounded(end)
        if not math.isfinite(end.number):
            return f"at {value}: {end.result.status}"
        worst = end.certificate.worst if end.certificate else None
        residual = "" if worst is None else f" (largest residual {worst:.0e})"
        near = [number for number in (self.holds.number, self.load) if number is not None]
        digits = distinguishing_digits(self.fails.number, near, _NUMBER_DIGITS)
        number = numeral(end.number, f".{digits}g")
        place = f", with {end.answer.place}" if end.answer.place else ""
        return f"at {value}: {self._measure} {number}{residual}{place}"

    def as_dict(self) -> dict[str, Any]:
        """Return the answer as a dictionary of plain values. Infinite numbers and NaN become None.

        The dictionary has the value and the load factor (or margin) of each trial, but not its result.
        """
        names = ("load", "value", "interval", "jump", "contradictions", "evaluations")
        result = {"kind": self._kind} | {name: getattr(self, name) for name in names}
        result["warnings"] = self.warning_records
        for name, end in {"holds": self.holds, "fails": self.fails}.items():
            result[name] = {"value": end.value, "number": end.number, "status": end.result.status}
            result[name]["certificate"] = end.certificate
            if end.answer.crossing is not None:
                result[name] |= end.answer.crossing.place
        trials = [{name: getattr(trial, name) for name in _TRIAL_COLUMNS} for trial in self.trials]
        return plain(result | {"trials": trials})
