"""Runs that many entries of the atlas share: the same answer of every method, or of every solver."""

from __future__ import annotations

from typing import Any

from masonry_opt.answer.status import Status
from masonry_opt.errors import CaseError
from masonry_opt.studies.atlas.entry import Run

#: The loop stops at a relative change of λ of 1e-5 and leaves the small cohesion's trace.
LOOP = 2e-5

#: HiGHS and Clarabel solve to 1e-9; friction in the hundred thousands costs digits.
COARSE = 1e-5

#: IPOPT's last relaxation, ε = 3e-9.
MPEC = 1e-7

#: Enough for scenes this small, where the first state is the lowest but for a few.
FEW_KICKS = 10

WITHOUT_HALVING = {"alpha": 0.0, "alpha_min": 0.0}
#: The paper's loop and nothing else: no exact state at its end, no further runs.
RAW: dict[str, Any] = {"finish": False, "remedies": "none"}
AGAIN = "began again with alpha"
LOCKS = "'unlimited: dilatancy locks the blocks', so the loop began again from a cohesive start"
REMEDIED = "so the loop began again"
NO_INFLUENCE = "the flow rule has no influence"

TWO_FORMULATIONS = "MPEC and refinement, which agree"
OTHERS = "static and kinematic, three solvers, which agree"

SOLVERS = ("clarabel", "highs", "highs-ipm")


def associative(
    expected: Status | type[CaseError],
    load_factor: float | tuple[float, float] | None = None,
    source: str = "",
    **keys: Any,
) -> tuple[Run, ...]:
    """The static program in three solvers, and the kinematic one in Pyomo."""
    return (
        *(
            Run(expected, "static", solver=name, load_factor=load_factor, source=source, **keys)
            for name in SOLVERS
        ),
        Run(expected, "kinematic", "pyomo", load_factor=load_factor, source=source, **keys),
    )


def loops(
    expected: Status | type[CaseError],
    load_factor: float | tuple[float, float] | None = None,
    source: str = "",
    solvers: tuple[str, ...] = SOLVERS,
    tolerance: float = LOOP,
    **keys: Any,
) -> tuple[Run, ...]:
    """The loop in CVXPY, in some solvers."""
    return tuple(
        Run(expected, solver=name, load_factor=load_factor, source=source, tolerance=tolerance, **keys)
        for name in solvers
    )


def references(
    load_factor: float | tuple[float, float],
    source: str,
    proven: bool | None = None,
    cold: Status = Status.CONVERGED,
) -> tuple[Run, ...]:
    """The refinement, the MPEC warm and cold, and the bracket (``proven`` or not; None: not asked)."""
    found: dict[str, Any] = {"load_factor": load_factor, "source": source}
    cold_found = found if cold.usable else {}
    runs = [
        Run(Status.CONVERGED, "refined", options={"kicks": FEW_KICKS}, **found),
        Run(Status.CONVERGED, "mpec", tolerance=MPEC, **found),
        Run(cold, "mpec", options={"start": "cold"}, tolerance=MPEC, **cold_found),
    ]
    if proven is not None:
        runs.append(Run(Status.OPTIMAL if proven else Status.CONVERGED, "global", **found))
    return tuple(runs)


def every_method(expected: Status, says: str = "", cold: Status | None = None) -> tuple[Run, ...]:
    """A status that every method must give."""
    return (
        *associative(expected, says=says),
        *loops(expected, says=says),
        Run(expected, options={"start": "cohesive"}, says=says),
        Run(expected, "refined", says=says),
        Run(expected, "global", says=says),
        Run(expected, "mpec", says=says),
        Run(cold or expected, "mpec", options={"start": "cold"}, says="" if cold else says),
    )
