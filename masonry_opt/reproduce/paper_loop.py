"""The paper's own settings of the loop, whatever the loop's defaults are."""

from __future__ import annotations

from typing import Any

#: Section 5: "unless stated otherwise".
PAPER: dict[str, Any] = {"alpha": 0.3, "alpha_min": 0.001, "beta": 0.6, "tol": 1e-5, "c0": 1e-5}
