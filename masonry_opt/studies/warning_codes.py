"""Codes of the warnings that studies add to those of their results, and their records."""

from enum import StrEnum
from typing import Any

from masonry_opt.files import plain


class StudyCode(StrEnum):
    """Codes of warnings about studies. The comment on a code lists the values of the warning's record."""

    #: A line of the journal of a study is damaged. The record has the ``path`` of the journal and the number
    #: ``line`` of the damaged line, from 1.
    DAMAGED_JOURNAL = "damaged journal"
    #: The values of some runs make no valid scene. The record has the ``status`` of these runs, their number
    #: ``count``, and the ``message`` of the first run.
    RUNS_LEFT_OUT = "runs left out"
    #: Some runs have no answer. The record has the ``status`` of these runs, their number ``count``, and the
    #: ``message`` of the first run.
    RUNS_UNDECIDED = "runs undecided"
    #: The load factor decreases as a friction, cohesion or strength increases. The record has the name of
    #: this ``parameter``. For a sweep it also has the two ``values`` and ``load_factors`` at the largest
    #: decrease of λ, and the values of the other parameters, ``fixed``. For a sample it also has the
    #: ``rank_correlation``.
    FALLS_WITH_STRENGTH = "falls with strength"
    #: The scene meets the requirement at some values at which it should fail, because they are beyond the
    #: threshold. The record has these ``values``.
    SEVERAL_THRESHOLDS = "several thresholds"
    #: The ``load_factor`` of a crossing is less than its lower ``bound``, which is a contradiction.
    BELOW_BOUND = "below bound"
    #: A crossing has positions without an answer. The record has the number of these positions, ``count``,
    #: and the first of them in the list ``positions``.
    POSITIONS_UNDECIDED = "positions undecided"
    #: The time limit ended a crossing in a sweep, sample or threshold. The record has the time limit in
    #: ``seconds``.
    CROSSING_STOPPED = "crossing stopped"
    #: The loads of axles and the weights seem to be in different units. The record has the ``name`` of the
    #: axles. If the unit of the unit weights is another one, it also has ``unit_weight``, the median unit
    #: weight of the blocks; unless the axles are a common set, also ``load``, the heaviest axle. For a common
    #: set in a scene that is too large for metres, it has ``extent``, the largest dimension of the movable
    #: blocks.
    AXLES_DIFFER = "axles differ"
    #: Some load cases have no axles, so the crossing skipped them. The record has the names of these load
    #: cases, ``cases``.
    CASES_WITHOUT_AXLES = "cases without axles"
    #: The load history ends at a reaction that is closer to the reaction at rest than the reaction of the
    #: answer. The record has the ``end`` ("least" or "greatest"), the ``reaction`` of the answer, and the
    #: reaction at the end of the load history, ``incremental``.
    HISTORY_ENDS_NEARER = "history ends nearer"
    #: An exact state is on the other side of the reaction at rest. The record has the ``end`` ("least" or
    #: "greatest"), the ``reaction`` of the exact state, and the reaction ``at_rest``.
    STATE_ACROSS_REST = "state across rest"


def study_warning(code: StudyCode, sentence: str, **values: Any) -> dict[str, Any]:
    """Return a warning as a record for JSON output."""
    return {"sentence": sentence, "code": str(code), **plain(values)}
