"""Warnings of a study of many runs; each sentence is issued only once.

Warnings name inputs that look unintended, and load factors that decrease as a strength or friction increases.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.errors import counted, listed, remainder
from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.reporting.load_factors import search_advice
from masonry_opt.reporting.sentences import numeral
from masonry_opt.solution.reasons import Status
from masonry_opt.studies.warning_codes import StudyCode, study_warning

#: Last parts of the names of parameters that limit forces, such as ``joints.friction``. A larger limit
#: permits all forces that a smaller limit permits.
_LIMITS = ("friction", "friction_angle", "cohesion", "strength")
_MOST_LISTED_VALUES = 3  #: Largest number of values that a warning lists; further values are only counted.

Row = Mapping[str, Any]  #: Row of a run by column name, including the columns of :func:`recorded_warnings`.
Point = Mapping[str, float]  #: Values of a run by name.


def recorded_warnings(records: Sequence[Row]) -> dict[str, Any]:
    """Return the warnings of a run as two table columns: sentences and records.

    The column ``warnings`` is a text. The column ``warned`` has the records of the warnings, which
    :func:`warnings_of_rows` reads.
    """
    return {"warnings": "; ".join(record["sentence"] for record in records), "warned": list(records)}


def warnings_of_rows(rows: Sequence[Row], points: Sequence[Point]) -> Iterator[dict[str, Any]]:
    """Generate the warnings of many runs. Each warning code is reported only for one run.

    For each warning code, the warnings of the first run with the code are generated. The entry ``runs`` of
    each record is the number of runs with the code. If some runs lack the warning, or if their sentences
    differ, the sentence ends with the values of the first run and the number of the other runs.
    """
    runs_by_code: dict[str, list[int]] = {}
    sentences_by_code: dict[str, set[str]] = {}
    for index, row in enumerate(rows):
        for record in row.get("warned") or ():
            sentences_by_code.setdefault(record["code"], set()).add(record["sentence"])
            runs = runs_by_code.setdefault(record["code"], [])
            if index not in runs[-1:]:
                runs.append(index)
    for code, runs in runs_by_code.items():
        first_records = [record for record in rows[runs[0]]["warned"] if record["code"] == code]
        where = ""
        if len(runs) < len(rows) or len(sentences_by_code[code]) > len(first_records):
            named = " ".join(filter(None, (_named(points[runs[0]]), remainder(len(runs), 1, "run"))))
            where = f" (at {named})"
        for record in first_records:
            yield record | {"sentence": record["sentence"] + where, "runs": len(runs)}


def warnings_of_falls(frame: pd.DataFrame, names: Sequence[str], method: str) -> Iterator[dict[str, Any]]:
    """Generate a warning for each friction, cohesion or strength whose increase decreases the lowest λ found.

    Two runs are compared if they differ by one step of this parameter, and all other varied parameters are
    equal. The warning states the largest decrease. Its advice depends on the method of the runs.
    """
    for name in filter(is_limit, names):
        others = [other for other in names if other != name]
        record = _largest_fall(frame, name, others, method)
        if record:
            yield record


def warnings_of_correlations(sensitivity: pd.DataFrame, method: str) -> Iterator[dict[str, Any]]:
    """Generate a warning for each friction, cohesion or strength whose increase lowers the load factor.

    ``sensitivity`` is the table of rank correlations. The whole confidence interval of the correlation must
    be below zero. The method must seek the lowest state.
    """
    for row in sensitivity.to_dict("records"):
        parameter, correlation = row["parameter"], row["rank_correlation"]
        if row["upper"] < 0 and is_limit(parameter):
            sentence = (
                f"the load factor falls as {parameter} grows (rank correlation "
                f"{numeral(correlation, '+.3f')}): either larger values weaken the scene, or "
                f"the method did not find the lowest load factors at smaller values"
                f"{search_advice(method, 'them')}"
            )
            values = {"parameter": parameter, "rank_correlation": correlation}
            yield study_warning(StudyCode.FALLS_WITH_STRENGTH, sentence, **values)


def warnings_by_status(code: StudyCode, rows: pd.DataFrame, kind: str) -> Iterator[dict[str, Any]]:
    """Generate a warning for each status: the number of runs with this status, and their first message."""
    for status in rows["status"].unique():
        of_status = rows[rows["status"] == status]
        why = str(of_status["message"].iloc[0] or "")
        sentence = f"{counted(len(of_status), 'run')} {kind} ({status}): {why}".removesuffix(": ")
        yield study_warning(code, sentence, status=status, count=len(of_status), message=why)


def is_limit(name: str) -> bool:
    """Return True if a parameter is a friction, cohesion or strength of joints, ties or props."""
    return name.split(".")[-1] in _LIMITS and not name.startswith("fill.")


def differing_values(run: Point, other: Point) -> str:
    """Return a text with those values of ``other`` that differ from ``run``, such as "tie.strength = 40"."""
    return _named({name: value for name, value in other.items() if run[name] != value})


def _largest_fall(
    frame: pd.DataFrame, name: str, others: Sequence[str], method: str
) -> dict[str, Any] | None:
    """Return a warning about the largest decrease of λ with an increase of a parameter.

    The result is None if λ never decreases.
    """
    # If the time limit ended a crossing, λ may be too large, so the run of this crossing is ignored.
    known = frame[frame["status"] != str(Status.TIME_LIMIT)].dropna(subset="load_factor")
    known = known.sort_values([*others, name], kind="stable")
    before, after = known.shift(), known
    falls = (before["load_factor"] - after["load_factor"]).where(after[name] > before[name])
    for other in others:
        falls = falls.where(after[other] == before[other])
    if not falls.notna().any():
        return None
    largest = int(np.nanargmax(falls.to_numpy()))
    first, second = before.iloc[largest], after.iloc[largest]
    higher, lower = first["load_factor"], second["load_factor"]
    if not LoadFactorScale().is_distinctly_lower(lower, higher):
        return None
    fixed = {other: float(first[other]) for other in others}
    where = f"{name} = {numeral(first[name], 'g')}"
    values = [numeral(row["load_factor"], ".6f") for row in (first, second)]
    where_fixed = f" ({_named(fixed)})" if fixed else ""
    sentence = (
        f"the lowest load factor found falls from {values[0]} at {where} to {values[1]} at "
        f"{numeral(second[name], 'g')}{where_fixed}: either the scene is weaker at the larger value, or a "
        f"lower λ was missed at the smaller value{search_advice(method, 'it')}"
    )
    return study_warning(
        StudyCode.FALLS_WITH_STRENGTH,
        sentence,
        parameter=name,
        values=[float(first[name]), float(second[name])],
        load_factors=[float(first["load_factor"]), float(second["load_factor"])],
        fixed=fixed,
    )


def _named(point: Point) -> str:
    """Return a text with the first parameter values of a run, and the number of its other values."""
    values = [f"{name} = {numeral(value, 'g')}" for name, value in point.items()]
    return listed(values, _MOST_LISTED_VALUES, "value")
