"""What reports say of a run in words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from masonry_opt.answer.acceptance import LIMITS, Kind
from masonry_opt.studies.compare.judge import VerdictReason
from masonry_opt.studies.compare.limits import residuals_over_limit
from masonry_opt.studies.compare.measure import FINISHED
from masonry_opt.words.sentences import numeral


def reason_text(row: Mapping[Any, Any], brief: bool = False) -> str:
    """Why a row of the summary (see :func:`~.frames.summary`) has its verdict; "" if it is certified.

    ``brief``: of an analysis that ended by itself the status alone, without the message that explains it.
    """
    finished = row["ended"] == FINISHED
    said = str(row["status"] if finished else row["ended"])
    said += f": {row['message']}" if row["message"] and not (brief and finished) else ""
    match row["reason"]:
        case VerdictReason.NONE:
            return ""
        case VerdictReason.RESIDUAL:
            limits = LIMITS[Kind(row["kind"])].as_dict()
            over = residuals_over_limit(row).items()
            return ", ".join(f"{name} {residual:.1e} > {limits[name]:.0e}" for name, residual in over)
        case VerdictReason.NO_CERTIFICATE:
            return "no certificate"
        case VerdictReason.ABOVE_BOUND:
            return "λ above its certified bound"
        case VerdictReason.BELOW_BOUND:
            return "λ below its certified bound"
        case VerdictReason.FALSE_CLAIM:
            return f"{said} (right: {row['right'] or 'not this'})"
    return said


def number(value: float | None, digits: int = 5) -> str:
    """A number in so many digits; a dash for what is not known."""
    return "–" if value is None or math.isnan(value) else numeral(value, f".{digits}g")
