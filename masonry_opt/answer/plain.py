"""Plain numbers, strings, lists and dictionaries, as JSON has them."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Any

import numpy as np


def plain(value: Any) -> Any:
    """The same as JSON has it; NaN as None."""
    if isinstance(value, StrEnum):
        return str(value)
    if hasattr(value, "as_dict"):
        value = value.as_dict()
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return value + 0.0 if math.isfinite(value) else None  # no minus before a zero
    return value
