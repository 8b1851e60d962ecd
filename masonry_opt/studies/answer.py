"""What answers of studies have in common: they are printed as facts, and written as JSON."""

from __future__ import annotations

import json
import math
from abc import ABC, abstractmethod
from typing import Any

import pandas as pd

from masonry_opt.errors import printable


class StudyAnswer(ABC):
    """The answer of a study."""

    def facts(self) -> dict[str, str]:
        """What it found, in words by name."""
        return {}

    @abstractmethod
    def as_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, strings, lists and dictionaries (not finite: None)."""

    def __str__(self) -> str:
        return printable("\n".join(f"{name:<16} {value}" for name, value in self.facts().items()))

    def to_json(self) -> str:
        """``as_dict`` as one JSON object."""
        return json.dumps(self.as_dict(), allow_nan=False, ensure_ascii=False)


def finite(number: float) -> float | None:
    """A number as JSON has it: None unless it is finite."""
    return number + 0.0 if math.isfinite(number) else None


def records(frame: pd.DataFrame) -> list[dict[Any, Any]]:
    """Rows of a frame as JSON has them: None for what is missing or not finite."""
    known = frame.replace([math.inf, -math.inf], math.nan).astype(object)
    return known.where(known.notna(), None).to_dict("records")
