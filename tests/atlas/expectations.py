"""Runs that many entries of the atlas share: the same answer of every method, or of every solver."""

from typing import Any

from atlas.entry import Expectation

from masonry_opt.errors import CaseError
from masonry_opt.solution.reasons import Code, Reason, Status, reason
from masonry_opt.solution.thresholds import ZERO

#: The loop stops at a relative change of λ of 1e-5 and leaves the small cohesion's trace.
LOOP = 2e-5

#: HiGHS and Clarabel solve to 1e-9; friction in the hundred thousands costs digits.
COARSE = 1e-5

#: IPOPT's last relaxation, ε = 3e-9.
MPEC = 1e-7

#: The default ends in an exact state, near the least of them: so far above at most.
PASS = 1e-2

#: Digits to which least load factors are given here.
LEAST = 1e-6

#: Seconds of a search that ends earlier, at the least load factor.
SEARCH = 20.0

WITHOUT_HALVING = {"alpha": 0.0, "alpha_min": 0.0}
#: The paper's loop without so much as less slope where it fails.
RAW: dict[str, Any] = {"preset": "paper", "remedies": "none"}
AGAIN = reason(Code.BEGAN_AGAIN, remedies="alpha=")
LOCKS = reason(Code.BEGAN_AGAIN, first=Status.LOCKED, remedies="start=cohesive")
REMEDIED = reason(Code.BEGAN_AGAIN)
NO_INFLUENCE = reason(Code.FLOW_RULE_IDLE)

TWO_FORMULATIONS = "MPEC and refinement, which agree"
OTHERS = "static and kinematic, three solvers, which agree"

SOLVERS = ("clarabel", "highs", "highs-ipm")


def associative(
    load_factor: float | tuple[float, float] | None = None,
    source: str = "",
    solvers: tuple[str, ...] = SOLVERS,
    expected: Status | type[CaseError] = Status.OPTIMAL,
    **keys: Any,
) -> tuple[Expectation, ...]:
    """The static program in some solvers, and the kinematic one in Pyomo."""
    static = [Expectation("static", load_factor, source, expected, solver=name, **keys) for name in solvers]
    return *static, Expectation("kinematic", load_factor, source, expected, "pyomo", **keys)


def loops(
    load_factor: float | tuple[float, float] | None = None,
    source: str = "",
    solvers: tuple[str | None, ...] = SOLVERS,
    expected: Status | type[CaseError] = Status.CONVERGED,
    tolerance: float = LOOP,
    **keys: Any,
) -> tuple[Expectation, ...]:
    """The loop in CVXPY, in some solvers."""
    given = {"load_factor": load_factor, "source": source, "expected": expected, "tolerance": tolerance}
    return tuple(Expectation(solver=name, **given, **keys) for name in solvers)


def refused(names: str) -> list[Expectation]:
    return [Expectation(method, expected=CaseError, names=names) for method in ("static", "nonassociative")]


def by_solver(name: str) -> Reason:
    return reason(Code.BEGAN_AGAIN, remedies=f"solver={name}")


def no_state(*solvers: str | None, **options: Any) -> tuple[Expectation, ...]:
    """Loops of which a sub-problem has no state."""
    why = reason(Code.SUB_PROBLEM_EMPTY)
    return loops(solvers=solvers, expected=Status.NO_STATE, why=why, options=options)


def default(load_factor: float | tuple[float, float], source: str, only: bool = False) -> Expectation:
    """The default.

    Parameters
    ----------
    load_factor: the least of any Coulomb state; or an interval.
    only: whether there is no other.
    """
    if not (only or isinstance(load_factor, tuple)):
        load_factor = load_factor * (1 - LEAST), load_factor * (1 + PASS)
        source = f"{source}, to {100 * PASS:g} % above"
    return Expectation("coulomb", load_factor, source, exact=True)


def searching(load_factor: float, source: str) -> Expectation:
    """Return the run of the default with a search, which must find the least load factor."""
    until = round(load_factor * (1 + LEAST) + ZERO, 9)
    return Expectation("coulomb", load_factor, source, options={"search": SEARCH, "until": until})


def references(load_factor: float, source: str, proven: bool | None = None) -> tuple[Expectation, ...]:
    """Return a search, the MPEC warm and cold, and the bracket (``proven`` or not; None: not asked)."""
    runs = [
        searching(load_factor, source),
        Expectation("mpec", load_factor, source, tolerance=MPEC),
        Expectation("mpec", load_factor, source, tolerance=MPEC, options={"start": "cold"}),
    ]
    if proven is not None:
        status = Status.OPTIMAL if proven else Status.CONVERGED
        runs.append(Expectation("global", load_factor, source, status))
    return tuple(runs)


def one_answer(
    load_factor: float, source: str, proven: bool | None = None, **of_loop: Any
) -> tuple[Expectation, ...]:
    """The only load factor, with any flow rule: of every method (``proven`` as ``references`` takes it)."""
    return (
        *associative(load_factor, source),
        *loops(load_factor, source, **of_loop),
        *(() if proven is None else references(load_factor, source, proven)),
        default(load_factor, source, only=True),
    )


def every_method(expected: Status, why: Reason | None = None) -> tuple[Expectation, ...]:
    """A status that every method must give."""
    told: dict[str, Any] = {"expected": expected, "why": why}
    cohesive, cold = {"start": "cohesive"}, {"start": "cold"}
    return (
        *associative(**told),
        *loops(**told),
        Expectation(options=cohesive, **told),
        *(Expectation(method, **told) for method in ("coulomb", "global", "mpec")),
        Expectation("mpec", options=cold, **told),
    )
