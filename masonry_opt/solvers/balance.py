"""Programs with very large entries, scaled for a conic solver: friction of 1e6 in a row is 1e6 beside 1."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import scipy.sparse as sp

#: Larger entries than this: their inequalities, then variables, are scaled to it. An entry of 1e6 then stands
#: as far above one as the 1 beside it below: with either at one, digits of the other are lost.
_LARGE = 1e3


def solve_balanced(solve: Callable[[dict[str, Any]], Any], data: dict[str, Any]) -> Any:
    """What a solver ends with, in the program's own units.

    Parameters
    ----------
    solve: of min c·x + ½ x·P x with b − A x in cones.
    data: c, A, b and perhaps P, and the cones' dimensions, as CVXPY has them for Clarabel.
    """
    A, dims = data["A"], data["dims"]
    if not A.nnz or abs(A).max() <= _LARGE:
        return solve(data)
    sizes = [1] * (dims.zero + dims.nonneg) + dims.soc
    each = np.repeat(np.arange(len(sizes)), sizes)
    rows = _by_cones(1 / np.maximum(1.0, _largest(A) / _LARGE), each, dims.zero)
    balanced = sp.diags_array(rows) @ A
    before, columns = _largest(balanced), 1 / np.maximum(1.0, _largest(balanced.T) / _LARGE)
    scale = sp.diags_array(columns)
    # Inequalities keep their size where variables are scaled, as p ≥ 0.
    rows *= _by_cones(before / _largest(balanced @ scale), each, dims.zero)
    A = sp.diags_array(rows) @ A
    scaled = data | {"A": (A @ scale).tocsc(), "b": rows * data["b"], "c": columns * data["c"]}
    if "P" in data:
        scaled["P"] = (scale @ data["P"] @ scale).tocsc()
    raw = solve(scaled)
    x, z = columns * np.asarray(raw.x), rows * np.asarray(raw.z)
    told = {name: getattr(raw, name) for name in ("status", "solve_time", "iterations", "obj_val")}
    return SimpleNamespace(x=x, z=z, **told)


def _largest(A: Any) -> np.ndarray:
    """Largest entry of each row."""
    largest: np.ndarray = abs(A).max(axis=1).toarray().ravel()
    return largest


def _by_cones(factors: np.ndarray, each: np.ndarray, zero: int) -> np.ndarray:
    """Factors that may be put to rows: one for all of a cone, the least; none to equations."""
    of_cones = np.full(each[-1] + 1, np.inf)
    np.minimum.at(of_cones, each, factors)
    of_cones[:zero] = 1.0
    return of_cones[each]
