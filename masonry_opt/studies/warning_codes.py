"""Codes of the warnings that studies add to those of their results, and their records."""

from enum import StrEnum
from typing import Any

from masonry_opt.files import plain


class StudyCode(StrEnum):
    """Codes of warnings about studies. The comment above a code lists the fields of its record."""

    #: A line of the journal of a study is damaged. The record has the ``path`` of the journal and the number
    #: ``line`` of the damaged line, counted from 1.
    DAMAGED_JOURNAL = "damaged journal"
    #: With the values of some runs, the scene is not valid. The record has the ``status`` of these runs,
    #: their number ``count``, and the ``message`` of the first run.
    RUNS_LEFT_OUT = "runs left out"
    #: Some runs have no answer. The record has the ``status`` of these runs, their number ``count``, and the
    #: ``message`` of the first run.
    RUNS_UNDECIDED = "runs undecided"
    #: The load factor decreases as a friction, cohesion or strength increases. The record has the name of
    #: this ``parameter``. For a sweep it also has ``values`` and ``load_factors``, the two parameter values
    #: and the two load factors at the largest decrease of λ. The values of the other parameters are
    #: ``fixed``. For a sample the record also has the ``rank_correlation`` of the parameter and λ.
    FALLS_WITH_STRENGTH = "falls with strength"
    #: The scene meets the requirement at some parameter values beyond the threshold, although it should fail
    #: there. The record has the list ``values`` of these parameter values.
    SEVERAL_THRESHOLDS = "several thresholds"
    #: The ``load_factor`` of a crossing is less than its lower ``bound``, which is a contradiction.
    BELOW_BOUND = "below bound"
    #: A crossing has positions without an answer. The record has the number ``count`` of these positions, and
    #: the list ``positions`` of the first few.
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
    #: Some load cases have no axles, so the crossing skipped them. The record has the names ``cases`` of
    #: these load cases.
    CASES_WITHOUT_AXLES = "cases without axles"
    #: The load history ends at a reaction between the reaction at rest and the reaction of the answer. The
    #: record has the ``end`` ("least" or "greatest"), the ``reaction`` of the answer, and the reaction at the
    #: end of the load history, ``incremental``.
    HISTORY_ENDS_NEARER = "history ends nearer"
    #: An exact state has a reaction above the reaction at rest (for the least reaction) or below it (for the
    #: greatest reaction). The record has the ``end`` ("least" or "greatest"), the ``reaction`` of the exact
    #: state, and the reaction ``at_rest``.
    STATE_ACROSS_REST = "state across rest"


def study_warning(code: StudyCode, sentence: str, **values: Any) -> dict[str, Any]:
    """Return a warning as a record for JSON output."""
    return {"sentence": sentence, "code": str(code), **plain(values)}
