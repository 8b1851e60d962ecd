"""Expectations that many entries of the atlas share, such as one answer for every method or solver."""

from typing import Any

from atlas.entry import Expectation

from masonry_opt.errors import CaseError
from masonry_opt.problem.load_factor_scale import ZERO
from masonry_opt.solution.reasons import Code, Reason, Status, reason

#: Relative tolerance of the loop, which stops at a change of λ of 1e-5 and depends on the small cohesion.
LOOP = 2e-5

#: Relative tolerance with a friction of 1e5, which costs digits. HiGHS and Clarabel solve to 1e-9.
COARSE = 1e-5

#: Relative tolerance of the MPEC, whose last relaxation in IPOPT is ε = 3e-9.
MPEC = 1e-7

#: Largest relative excess of the default's exact state over the least load factor.
PASS = 1e-2

#: Relative accuracy with which the least load factors are stated here.
LEAST = 1e-6

#: Time limit of a search in seconds; a search ends earlier at the least load factor.
SEARCH = 20.0

WITHOUT_HALVING = {"alpha": 0.0, "alpha_min": 0.0}
#: Options of the paper's loop without any remedy, not even a smaller slope, if it fails.
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
    """Return expectations of the static program with each solver, and of the kinematic program in Pyomo."""
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
    """Return expectations of the loop in CVXPY with each solver."""
    given = {"load_factor": load_factor, "source": source, "expected": expected, "tolerance": tolerance}
    return tuple(Expectation(solver=name, **given, **keys) for name in solvers)


def refused(names: str) -> list[Expectation]:
    return [Expectation(method, expected=CaseError, names=names) for method in ("static", "nonassociative")]


def by_solver(name: str) -> Reason:
    return reason(Code.BEGAN_AGAIN, remedies=f"solver={name}")


def no_state(*solvers: str | None, **options: Any) -> tuple[Expectation, ...]:
    """Return expectations of loops that end because a sub-problem has no state."""
    why = reason(Code.SUB_PROBLEM_EMPTY)
    return loops(solvers=solvers, expected=Status.NO_STATE, why=why, options=options)


def default(load_factor: float | tuple[float, float], source: str, only: bool = False) -> Expectation:
    """Return the expectation of the default method.

    Parameters
    ----------
    load_factor: the least load factor of all Coulomb states, or an interval.
    only: True if all Coulomb states have this load factor.
    """
    if not (only or isinstance(load_factor, tuple)):
        load_factor = load_factor * (1 - LEAST), load_factor * (1 + PASS)
        source = f"{source}, to {100 * PASS:g} % above"
    return Expectation("coulomb", load_factor, source, exact=True)


def searching(load_factor: float, source: str) -> Expectation:
    """Return the expectation of the default with a search, which must find the least load factor."""
    until = round(load_factor * (1 + LEAST) + ZERO, 9)
    return Expectation("coulomb", load_factor, source, options={"search": SEARCH, "until": until})


def references(load_factor: float, source: str, proven: bool | None = None) -> tuple[Expectation, ...]:
    """Return expectations of a search, of the MPEC with a warm and a cold start, and of method "global".

    Method "global" must prove its load factor if ``proven`` is True. If ``proven`` is None, it does not run.
    """
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
    """Return expectations of every method on a scene with a single load factor under any flow rule.

    The argument ``proven`` is that of ``references``.
    """
    return (
        *associative(load_factor, source),
        *loops(load_factor, source, **of_loop),
        *(() if proven is None else references(load_factor, source, proven)),
        default(load_factor, source, only=True),
    )


def every_method(expected: Status, why: Reason | None = None) -> tuple[Expectation, ...]:
    """Return the expectations that every method ends with the given status."""
    keys: dict[str, Any] = {"expected": expected, "why": why}
    cohesive, cold = {"start": "cohesive"}, {"start": "cold"}
    return (
        *associative(**keys),
        *loops(**keys),
        Expectation(options=cohesive, **keys),
        *(Expectation(method, **keys) for method in ("coulomb", "global", "mpec")),
        Expectation("mpec", options=cold, **keys),
    )
