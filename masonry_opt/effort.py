"""Where the time goes: seconds by part, added up over an analysis."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

#: The parts, in the order in which they happen.
PARTS = ("scene", "dead_load", "build", "compile", "solve", "read")


class Stopwatch:
    """Seconds by part.

    ``scene`` is reading, joints and matrices; ``dead_load`` the check that the scene stands;
    ``build`` declares the model; ``compile`` turns it to solver data, updates included; ``solve`` is
    the solver's own time; ``read`` turns its answer to arrays.
    """

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(PARTS, 0.0)

    @contextmanager
    def measure(self, part: str) -> Iterator[None]:
        """Add the time spent inside to a part."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.add(part, time.perf_counter() - start)

    def add(self, part: str, seconds: float) -> None:
        """Add seconds to a part."""
        self.seconds[part] += seconds
