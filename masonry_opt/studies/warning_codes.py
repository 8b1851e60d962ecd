"""Codes of the warnings that studies add to those of their results, and their records."""

from enum import StrEnum
from typing import Any

from masonry_opt.files import plain


class StudyCode(StrEnum):
    """Code of a warning about a study; the comment of each lists the values of its record."""

    DAMAGED_JOURNAL = "damaged journal"  # path, line: number of the line, from 1
    RUNS_LEFT_OUT = "runs left out"  # status, count, message: why the first of these runs has no answer
    RUNS_UNDECIDED = "runs undecided"  # status, count, message: why the first of these runs has no answer
    # parameter; of a sweep also values and load_factors: two each, at the largest fall, and fixed: the other
    # numbers there; of a sample also rank_correlation.
    FALLS_WITH_STRENGTH = "falls with strength"
    SEVERAL_THRESHOLDS = "several thresholds"  # values: at which the scene holds beyond the threshold
    BELOW_BOUND = "below bound"  # load_factor, bound: of a crossing, which contradict each other
    # end: "least" or "greatest"; reaction: of the answer; incremental: reaction at which the history ends
    HISTORY_ENDS_NEARER = "history ends nearer"
    STATE_ACROSS_REST = "state across rest"  # end, reaction: of that state; at_rest: reaction at rest


def study_warning(code: StudyCode, sentence: str, **values: Any) -> dict[str, Any]:
    """Return the record of a warning, as JSON output has it."""
    return {"sentence": sentence, "code": str(code), **plain(values)}
