"""Solutions of analyses that the time limit has ended, with or without an answer."""

from dataclasses import replace
from math import isfinite
from typing import Any

from masonry_opt.deadline import TimeLimitReached
from masonry_opt.effort import Effort
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.load_history import LoadStep
from masonry_opt.solution.reasons import Code, Reason, Status, reason
from masonry_opt.solution.solution import Solution


def without_answer(kind: Kind, stop: TimeLimitReached, effort: Effort, last_step: Any = None) -> Solution:
    """Return the solution of an analysis that reached the time limit before it found a collapse state.

    ``last_step`` is the record of the method's last step; None if there was no step. The reason states the
    load factor of this step.
    """
    values: dict[str, Any] = {"carried": None, "last": None}
    load_factor = getattr(last_step, "load_factor", None)
    if load_factor is not None and isfinite(load_factor):
        values["carried" if isinstance(last_step, LoadStep) else "last"] = float(load_factor)
    return Solution(Status.TIME_LIMIT, kind, (_time_limit(stop, effort, **values),))


def with_answer(solution: Solution, stop: TimeLimitReached, effort: Effort) -> Solution:
    """Return an answer that was found before the time limit, marked as interrupted.

    The reason that names the time limit becomes the first reason of the solution.
    """
    why = _time_limit(stop, effort, carried=None, last=None)
    return replace(solution, interrupted=True).telling_first(why)


def _time_limit(stop: TimeLimitReached, effort: Effort, **values: Any) -> Reason:
    """Return the reason why an analysis ended early: the time limit, and the phase that was interrupted."""
    return reason(Code.TIME_LIMIT, seconds=stop.seconds, phase=effort.phase, **values)
