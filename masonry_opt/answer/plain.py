"""A result as plain numbers, strings, lists and dictionaries, as JSON has them."""

from __future__ import annotations

import math
from dataclasses import asdict
from enum import StrEnum
from typing import Any

import numpy as np

from masonry_opt.answer.result import Result

#: What ``as_dict`` tells, in order; block by block and joint by joint at the end.
_TOLD = (
    *(
        "case",
        "load_case",
        "method",
        "model",
        "solver",
        "status",
        "message",
        "reasons",
        "warnings",
        "kind",
        "crushing",
    ),
    *("friction_law", "load_factor", "tilt_angle", "blocks", "joints", "flow_rule_matters", "iterations"),
    *("lp_solves", "nlp_solves", "stationary", "expected", "expected_reasons", "associative", "exact"),
    *("range", "bound", "seconds", "solvers", "certificate", "infeasibility", "size", "history"),
)


def as_dict(result: Result) -> dict[str, Any]:
    """Everything that a result tells; NaN as None."""
    told = {name: getattr(result, name) for name in _TOLD}
    warnings = zip(result.warnings, result.warning_sentences, strict=True)
    told["warnings"] = [{"sentence": words, **warning.as_dict()} for warning, words in warnings]
    told["blocks"], told["joints"], told["size"] = result.size.blocks, result.size.joints, asdict(result.size)
    told["history"] = result.history.to_dict("records")
    told["block_results"] = result.blocks.to_dict("records")
    told["joint_results"] = result.joints.to_dict("records")
    if len(result.ties):
        told["tie_results"] = result.ties.to_dict("records")
    if result.contacts is not None:
        told["contact_results"] = result.contacts.to_dict("records")
    if result.curve is not None:
        told["curve"] = result.curve.to_dict("records")
    return _plain(told)


def _plain(value: Any) -> Any:
    if isinstance(value, StrEnum):
        return str(value)
    if hasattr(value, "as_dict"):
        value = value.as_dict()
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return value + 0.0 if math.isfinite(value) else None  # no minus before a zero
    return value
