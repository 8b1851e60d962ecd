"""Deadline of an analysis: a time limit that all solvers and all long loops respect.

A deadline applies to all code that runs within :func:`limited`. Solvers pass the remaining seconds on to
their libraries, and loops call :func:`check_time`. At the deadline TimeLimitReached is raised. It is a
KeyboardInterrupt, so that code which keeps a result after Ctrl-C also keeps it at the deadline.
"""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from math import inf

#: A solver that ends without an optimum counts as stopped by the deadline if fewer than this many seconds
#: remain. The margin is needed because solvers use their own clocks. With a larger value, more failed solvers
#: count as stopped.
SAME_TIME = 0.1


class TimeLimitReached(KeyboardInterrupt):
    """Exception that is raised when the time limit of an analysis has passed.

    Attributes
    ----------
    seconds: the time limit, in seconds.
    """

    def __init__(self, seconds: float) -> None:
        super().__init__(f"time limit of {seconds:g} s")
        self.seconds = seconds


#: Deadline as a value of ``time.perf_counter``, and the time limit in seconds from which it was computed.
_deadline: ContextVar[tuple[float, float]] = ContextVar("deadline", default=(inf, inf))


@contextmanager
def limited(seconds: float | None) -> Iterator[None]:
    """Limit the time of the ``with`` block to a number of seconds; None sets no limit.

    If the block is inside another limited block, the earlier deadline applies.
    """
    if seconds is None:
        yield
        return
    own = time.perf_counter() + seconds, seconds
    token = _deadline.set(min(own, _deadline.get()))
    try:
        yield
    finally:
        _deadline.reset(token)


@contextmanager
def unlimited() -> Iterator[None]:
    """Suspend the time limit within a ``with`` block, for code that enforces a time limit itself."""
    token = _deadline.set((inf, inf))
    try:
        yield
    finally:
        _deadline.reset(token)


def seconds_left() -> float:
    """Return the seconds until the deadline; zero after the deadline, infinity without a time limit."""
    return max(_deadline.get()[0] - time.perf_counter(), 0.0)


def check_time(within: float = 0.0) -> None:
    """Raise TimeLimitReached if the deadline has passed, or is less than ``within`` seconds away."""
    deadline, seconds = _deadline.get()
    if time.perf_counter() + within >= deadline:
        raise TimeLimitReached(seconds)
