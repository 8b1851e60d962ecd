"""Codes of the warnings that studies add to those of their results, and their records."""

from enum import StrEnum
from typing import Any

from masonry_opt.files import plain


class StudyCode(StrEnum):
    """Codes of warnings about studies. The comment above a code lists the fields of its record."""

    #: A line of the journal of a study is damaged. The record has the ``path`` of the journal and the number
    #: ``line`` of the damaged line, counted from 1.
    DAMAGED_JOURNAL = "damaged journal"
    #: Runs were left out, because their values make the scene invalid. The record has their ``status``, their
    #: number ``count``, and the ``message`` of the first run.
    RUNS_LEFT_OUT = "runs left out"
    #: Some runs have no answer. The record has the ``status`` of these runs, their number ``count``, and the
    #: ``message`` of the first run.
    RUNS_UNDECIDED = "runs undecided"
    #: The load factor decreases as a ``parameter`` (a friction, cohesion or strength) increases. For a sweep,
    #: the record has the ``values`` and ``load_factors`` at the largest decrease, and the ``fixed`` values of
    #: the other parameters. For a sample, the record has the ``rank_correlation``.
    FALLS_WITH_STRENGTH = "falls with strength"
    #: The scene fails directly beyond the threshold, but meets the requirement again at some parameter values
    #: farther away. The record lists these ``values``.
    SEVERAL_THRESHOLDS = "several thresholds"
    #: The ``load_factor`` of a crossing is less than its lower ``bound``, which is a contradiction.
    BELOW_BOUND = "below bound"
    #: A crossing has positions without an answer. The record has the number ``count`` of these positions, and
    #: the list ``positions`` of the first few.
    POSITIONS_UNDECIDED = "positions undecided"
    #: The time limit ended a crossing in a sweep, sample or threshold. The record has the time limit in
    #: ``seconds``.
    CROSSING_STOPPED = "crossing stopped"
    #: The axle loads and the scene seem to be in different units. The record has the ``name`` of the axles,
    #: and the values that do not fit together:
    #:
    #: - for axles with loads of their own, the largest axle load (``load``) and the median unit weight of the
    #:   blocks (``unit_weight``);
    #: - for a predefined set of axles, which is in kN and m, either ``unit_weight``, or the largest dimension
    #:   of the movable blocks (``extent``), if it is implausibly large for a length in metres.
    AXLES_DIFFER = "axles differ"
    #: Some load cases have no axles, so the crossing skipped them. The record has ``cases``, the names of
    #: these load cases.
    CASES_WITHOUT_AXLES = "cases without axles"
    #: The load history ends at a reaction between the reaction of the answer and the reaction at rest. The
    #: record has the ``end`` ("least" or "greatest"), the ``reaction`` of the answer, and ``incremental``,
    #: the reaction at the end of the load history.
    HISTORY_ENDS_NEARER = "history ends nearer"
    #: The search for the least reaction of a support found an exact state with a reaction above the reaction
    #: at rest, or the search for the greatest reaction found a state with a reaction below the reaction at
    #: rest. The record has the ``end`` ("least" or "greatest"), the ``reaction`` of the state, and the
    #: reaction ``at_rest``.
    STATE_ACROSS_REST = "state across rest"


def study_warning(code: StudyCode, sentence: str, **values: Any) -> dict[str, Any]:
    """Return a warning as a record for JSON output."""
    return {"sentence": sentence, "code": str(code), **plain(values)}
