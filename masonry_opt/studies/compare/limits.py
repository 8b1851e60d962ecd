"""A run's residuals against the package's table of acceptance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from masonry_opt.answer.acceptance import LIMITS, Kind, over_load_factor

#: What the table limits of a certificate.
RESIDUALS = ("equilibrium", "yield", "flow", "complementarity")


def residuals_over_limit(row: Mapping[Any, Any], kind: Kind | None = None) -> dict[str, float | None]:
    """The residuals of a row with a load factor that are over the limits of its kind of answer, or of
    another kind; one that is missing or no number is as well."""
    left = {name: row[name] for name in RESIDUALS}
    if (energy := left["complementarity"]) is not None:
        left["complementarity"] = over_load_factor(energy, row["load_factor"])
    return LIMITS[kind or Kind(row["kind"])].failing(left)
