"""Codes of the warnings that studies add to those of their results, and their records."""

from enum import StrEnum
from typing import Any

from masonry_opt.files import plain


class StudyCode(StrEnum):
    """Code of a warning about a study; the comment of each lists the values of its record."""

    #: ``path``; ``line``: number of the damaged line, from 1.
    DAMAGED_JOURNAL = "damaged journal"
    #: ``status``; ``count`` of runs; ``message``: reason why the first of these runs has no answer.
    RUNS_LEFT_OUT = "runs left out"
    #: ``status``; ``count`` of runs; ``message``: reason why the first of these runs has no answer.
    RUNS_UNDECIDED = "runs undecided"
    #: ``parameter``. Of a sweep also two ``values`` and two ``load_factors``, those at the largest fall, and
    #: ``fixed``, the other numbers at the fall. Of a sample also ``rank_correlation``.
    FALLS_WITH_STRENGTH = "falls with strength"
    #: ``values``: those at which the scene holds beyond the threshold.
    SEVERAL_THRESHOLDS = "several thresholds"
    #: ``load_factor`` and ``bound`` of a crossing, which contradict each other.
    BELOW_BOUND = "below bound"
    #: ``end``: "least" or "greatest"; ``reaction`` of the answer; ``incremental``: reaction at the end of the
    #: load history.
    HISTORY_ENDS_NEARER = "history ends nearer"
    #: ``end``: "least" or "greatest"; ``reaction`` of the exact state; ``at_rest``: reaction at rest.
    STATE_ACROSS_REST = "state across rest"


def study_warning(code: StudyCode, sentence: str, **values: Any) -> dict[str, Any]:
    """Return the record of a warning in the form of JSON output."""
    return {"sentence": sentence, "code": str(code), **plain(values)}
