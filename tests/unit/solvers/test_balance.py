"""Programs with entries of 10⁶, solved by Clarabel: their own primal and dual, whatever is scaled."""

from __future__ import annotations

from types import SimpleNamespace

import clarabel
import numpy as np
import pytest
import scipy.sparse as sp

from masonry_opt.solvers.cvxpy_engine import solve_balanced

FRICTION = 1e6


def solved(data):
    dims = data["dims"]
    cones = [
        clarabel.ZeroConeT(dims.zero),
        clarabel.NonnegativeConeT(dims.nonneg),
        *(clarabel.SecondOrderConeT(size) for size in dims.soc),
    ]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-10
    size = len(data["c"])
    P = data.get("P", sp.csc_array((size, size)))
    P = sp.triu(P).tocsc()
    return clarabel.DefaultSolver(P, data["c"], data["A"], data["b"], cones, settings).solve()


def pushed_block(cone: bool) -> dict:
    """max λ of a block of weight 1 under λ sideways, half as wide as high: |s| ≤ μ n, λ ≤ n / 2.

    x = (n, s, λ); rows: n = 1, s = λ, rocking, friction.
    """
    A = [[1, 0, 0], [0, 1, -1], [-0.5, 0, 1], [-FRICTION, 0, 0], [0, -1, 0]]
    if not cone:
        A[3:] = [[-FRICTION, 1, 0], [-FRICTION, -1, 0]]
    b = np.zeros(len(A))
    b[0] = 1.0
    dims = SimpleNamespace(zero=2, nonneg=1 if cone else 3, soc=[2] if cone else [])
    return {"A": sp.csc_array(np.array(A, dtype=float)), "b": b, "c": np.array([0.0, 0, -1]), "dims": dims}


@pytest.mark.parametrize("cone", [False, True], ids=["sides", "cone"])
def test_large_friction_leaves_no_condition_open(cone):
    """By hand: λ = 1/2, from the row of rocking alone, whose multiplier is 1; Aᵀz = −c."""
    data = pushed_block(cone)
    found = solve_balanced(solved, data)
    assert found.x == pytest.approx([1.0, 0.5, 0.5], abs=1e-7)
    assert found.z[2] == pytest.approx(1.0, abs=1e-7)
    assert data["A"].T @ found.z == pytest.approx(-data["c"], abs=1e-7)


def test_rows_of_one_cone_share_a_factor_and_equations_have_none():
    """Else a point of one cone would be taken for one of another."""
    seen, given = [], pushed_block(cone=True)
    solve_balanced(lambda data: seen.append(data) or solved(data), given)
    A, scaled = given["A"].toarray(), seen[0]["A"].toarray()
    columns = np.array([scaled[0, 0], *scaled[1, 1:] / A[1, 1:]])
    of_cone = scaled[3, 0] / (A[3, 0] * columns[0]), scaled[4, 1] / (A[4, 1] * columns[1])
    assert of_cone[0] == pytest.approx(of_cone[1], rel=1e-12)
    assert np.abs(scaled).max() <= 1e3 < np.abs(A).max()
    assert seen[0]["c"] == pytest.approx(columns * given["c"])
    assert seen[0]["b"][:2] == pytest.approx(given["b"][:2])
