"""Codes of the warnings that studies add to those of their results, and their records."""

from enum import StrEnum
from typing import Any

from masonry_opt.files import plain


class StudyCode(StrEnum):
    """Codes of warnings about studies. The comment on a code lists the values of the warning's record."""

    #: Values: ``path`` of the journal; ``line``, the number of the damaged line, from 1.
    DAMAGED_JOURNAL = "damaged journal"
    #: Values: ``status`` of the runs; ``count``, the number of runs; ``message``, the reason of the first
    #: run.
    RUNS_LEFT_OUT = "runs left out"
    #: Values: ``status`` of the runs; ``count``, the number of runs; ``message``, the reason of the first
    #: run.
    RUNS_UNDECIDED = "runs undecided"
    #: Values: ``parameter``, the name of the varied input, such as the friction. For a sweep also the two
    #: ``values`` and ``load_factors`` at the largest decrease of λ, and ``fixed``, the values of the other
    #: numbers. For a sample also ``rank_correlation``.
    FALLS_WITH_STRENGTH = "falls with strength"
    #: Value: ``values``, numbers beyond the threshold at which the scene is also stable or carries the load.
    SEVERAL_THRESHOLDS = "several thresholds"
    #: Values: ``load_factor`` of a crossing, and ``bound``, its larger lower bound, which is a contradiction.
    BELOW_BOUND = "below bound"
    #: Values: ``count``, the number of undecided positions of a crossing; ``positions``, with the first of
    #: them.
    POSITIONS_UNDECIDED = "positions undecided"
    #: Values: ``name`` of the axles; ``unit_weight``, the median of the blocks, if the axles are a common
    #: set; otherwise ``load`` of all axles and ``weight``, the sum of all dead loads.
    AXLES_DIFFER = "axles differ"
    #: Value: ``cases``, the names of the load cases without axles.
    CASES_WITHOUT_AXLES = "cases without axles"
    #: Values: ``end``, "least" or "greatest"; ``reaction`` of the answer; ``incremental``, the reaction at
    #: the end of the load history.
    HISTORY_ENDS_NEARER = "history ends nearer"
    #: Values: ``end``, "least" or "greatest"; ``reaction`` of the exact state; ``at_rest``, the reaction at
    #: rest.
    STATE_ACROSS_REST = "state across rest"


def study_warning(code: StudyCode, sentence: str, **values: Any) -> dict[str, Any]:
    """Return the record of a warning in the form of JSON output."""
    return {"sentence": sentence, "code": str(code), **plain(values)}
