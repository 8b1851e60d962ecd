"""Decide if a load factor jumps at the threshold of a varied parameter."""

import math
from collections.abc import Iterable

from masonry_opt.solution.thresholds import JUMP
from masonry_opt.studies.many.trial import FALLS, Trial

#: A change of the load factor counts as a jump if it exceeds this multiple of the change that the slopes next
#: to the interval predict. A smaller value would mistake a steep change for a jump.
_JUMP_RATIO = 10.0


def jump_between(
    holds: Trial, fails: Trial, trials: Iterable[Trial], load: float | None
) -> tuple[float, float] | None:
    """Return the load factors at both ends of an interval if λ jumps in the interval; otherwise None.

    Under dead load alone, the margins of stability replace the load factors. The change between both ends is
    a jump if it is much larger than the slopes on both sides of the interval predict. If both slopes are
    unknown, no jump is reported.

    Parameters
    ----------
    holds, fails: The two ends of the interval of the threshold.
    trials: All trials of the search.
    load: Load factor that must be carried; None for the dead load alone. An unstable scene has no load
        factor, and ``load`` replaces it in the comparison. Under dead load alone, no jump can be detected if
        the failing end has no margin.
    """
    known = [trial for trial in trials if math.isfinite(trial.number)]
    width = abs(holds.value - fails.value)
    if not known or (load is None and fails.number == FALLS):
        return None
    before = (load or 0.0) if fails.number == FALLS else fails.number
    change = holds.number - before
    slopes = [*_slope_beyond(holds, fails, known), *_slope_beyond(fails, holds, known)]
    if not slopes and math.isfinite(change):
        return None
    largest = max(abs(trial.number) for trial in known)
    is_jump = change > max(JUMP * largest, _JUMP_RATIO * max(slopes, default=0.0) * width)
    return (fails.number, holds.number) if is_jump else None


def _slope_beyond(end: Trial, other: Trial, known: list[Trial]) -> list[float]:
    """Return a list with the absolute slope of λ just outside the interval, next to ``end``.

    The slope is the change of λ per change of the parameter, between ``end`` and the nearest trial outside
    the interval. The list is empty if the slope is unknown.
    """
    beyond = [trial for trial in known if (trial.value - end.value) * (end.value - other.value) > 0]
    if not beyond or not math.isfinite(end.number):
        return []
    near = min(beyond, key=lambda trial: abs(trial.value - end.value))
    return [abs((near.number - end.number) / (near.value - end.value))]
