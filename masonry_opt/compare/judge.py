"""What a run is worth: its question, its error, and whether its certificate lets it count as good."""

from __future__ import annotations

from typing import Any

from masonry_opt.analysis.status import Status
from masonry_opt.compare.accuracy import SMALLEST, Bounds
from masonry_opt.compare.best_known import BestKnown
from masonry_opt.compare.measure import FINISHED

ASSOCIATIVE, COULOMB = "associative", "Coulomb"

#: Verdicts, best first. Only the first is ever drawn as a point of time and error.
GOOD, CERTIFICATE_FAILS, NAMED_STATUS, FAILED = "good", "certificate fails", "named status", "failed"
VERDICTS = (GOOD, CERTIFICATE_FAILS, NAMED_STATUS, FAILED)

#: What a certificate may leave in a good answer, by kind of method.
#: associative: no force out by more than a ten-thousandth (of the weight, of a median block), and λ by no
#:   more than that: the four digits in which published load factors agree. What is beyond is the error axis.
#: loop: it turns shear limits about the last normal forces and so never meets Coulomb's law exactly. A tenth
#:   of a block's weight is what the published parameters leave on the walls of Table 1 (README); more says
#:   that forces, and not only digits, are wrong. Its last step takes what the small cohesion dissipates off
#:   λ and not off the forces: some 1e-4 of equilibrium and of complementarity, by construction.
#: exact: a hundred times what the MPEC's last relaxation leaves; the refinement leaves less than 1e-8.
LIMITS: dict[str, dict[str, float]] = {
    "associative": dict.fromkeys(("equilibrium", "yield", "flow", "complementarity"), 1e-4),
    "loop": {"equilibrium": 1e-3, "yield": 0.1, "flow": 1e-3, "complementarity": 1e-2},
    "exact": dict.fromkeys(("equilibrium", "yield", "flow", "complementarity"), 1e-6),
}

#: Kind of each method that is not exact.
_KINDS = {"static": "associative", "kinematic": "associative", "nonassociative": "loop"}

#: Gaps to the best exact Coulomb state below this are none: the MPEC leaves some 1e-8 of λ.
GAP_FLOOR = 1e-7

#: Violations below this are rounding.
VIOLATION_FLOOR = 1e-10

#: Error at which profiles and scaling count an answer as reached: digits for the linear program, and for
#: Coulomb the one per cent by which the loop is known to end above the lowest state on the walls.
TARGET = {ASSOCIATIVE: 1e-6, COULOMB: 1e-2}


def question(method: str) -> str:
    """Which λ a method asks for."""
    return ASSOCIATIVE if _kind(method) == "associative" else COULOMB


def judge(row: dict[str, Any], bounds: Bounds | None, best: BestKnown | None) -> dict[str, Any]:
    """Verdict, reason and errors of one run.

    Returns
    -------
    ``question``; ``verdict`` (one of VERDICTS) and ``reason`` ("" if good); ``error``: distance of λ from
    the certified one, half the bracket's width at least, or from the best exact Coulomb state, 1e-7 at least,
    both relative; ``below``: whether λ is below that state, which no exact one is known to be;
    ``violation``: largest violation of yield, in median block weights, 1e-10 at least. None
    where there is no such number.
    """
    asks = question(row["method"])
    verdict, reason = _verdict(row)
    error, below = None, False
    load_factor = row["load_factor"]
    if load_factor is not None and asks == ASSOCIATIVE and bounds is not None and bounds.finite:
        distance = abs(load_factor - bounds.middle) / max(abs(bounds.middle), SMALLEST)
        error = max(distance, bounds.width / 2, 1e-16)
    elif load_factor is not None and asks == COULOMB and best is not None:
        gap = (load_factor - best.load_factor) / max(abs(best.load_factor), SMALLEST)
        error, below = max(abs(gap), GAP_FLOOR), gap < -GAP_FLOOR
    return {
        "question": asks,
        "verdict": verdict,
        "reason": reason,
        "error": error,
        "below": below,
        "violation": None if row["yield"] is None else max(row["yield"], VIOLATION_FLOOR),
    }


def _kind(method: str) -> str:
    return _KINDS.get(method, "exact")


def _verdict(row: dict[str, Any]) -> tuple[str, str]:
    if row["ended"] != FINISHED:
        return FAILED, f"{row['ended']}: {row['message']}"
    if row["load_factor"] is None:
        failed = row["status"] == Status.SOLVER_FAILED
        return (FAILED if failed else NAMED_STATUS), f"{row['status']}: {row['message']}"
    limits = LIMITS[_kind(row["method"])]
    # A residual that is missing or no number fails as well.
    missed = [name for name, limit in limits.items() if not (row[name] is not None and row[name] <= limit)]
    if missed:
        words = (f"{name} {row[name]:.1e} > {limits[name]:.0e}" for name in missed if row[name] is not None)
        return CERTIFICATE_FAILS, ", ".join(words) or "no certificate"
    return GOOD, ""
