"""Functions for processes that must be stopped."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import NoReturn

from masonry_opt.errors import CaseError


def sleep(seconds: float) -> str:
    """Take time."""
    time.sleep(seconds)
    return "slept"


def hoard(megabytes: int) -> int:
    """Take memory, ten MB at a time, each touched."""
    kept = [b"x" * 10_000_000 for _ in range(megabytes // 10) if not time.sleep(0.005)]
    time.sleep(2)
    return len(kept)


def die() -> NoReturn:
    """End as a solver that crashes does."""
    os._exit(7)


def fail() -> NoReturn:
    """Raise what nobody expects."""
    raise ZeroDivisionError("by zero")


def refuse(where: str) -> NoReturn:
    """Raise what a user can put right."""
    raise CaseError(where)


def start_and_sleep(case: Path, *_: object) -> None:
    """A run that says when it starts, and takes a minute."""
    case.with_suffix(".started").touch()
    time.sleep(60)
