"""Registry of all solvers that a user can select, with their capabilities, options and outcomes."""

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import cache, partial
from typing import Any

from masonry_opt.errors import OptionError
from masonry_opt.scene.mistakes import did_you_mean, instead_of

#: Default feasibility and gap tolerance of every solver. With a larger value, the load factor λ has fewer
#: correct digits; with a smaller value, solvers take more time.
SOLVER_TOLERANCE = 1e-9

#: Modelling languages; the first is the default.
LANGUAGES = ("cvxpy", "pyomo")

#: Value of the option ``model`` for methods that use the matrices directly, without a modelling language.
MATRICES = "matrices"

#: All values of the option ``model``.
MODELS = (*LANGUAGES, MATRICES)

#: Function that converts a tolerance to the options of a solver.
Options = Callable[[float], dict[str, Any]]


@dataclass(frozen=True)
class SolverEntry:
    """Options and capabilities of a solver in one modelling language, or without a language.

    To add a solver, add an entry to ``_ENTRIES``.
    """

    name: str
    language: str  #: modelling language, "cvxpy" or "pyomo"; "matrices" if the solver uses no language
    engine: str  #: name of the solver within the modelling language
    #: Function that converts a tolerance to the options of the solver; None if the solver has fixed
    #: tolerances.
    options: Options | None
    #: Name of an optional module that the solver needs; empty if the solver is always installed.
    brought_by: str = ""
    #: True if the solver returns an interior point of the set of optimal states instead of a vertex.
    interior: bool = False
    #: True if a larger tolerance makes the solver faster. It is False for HiGHS, which ends with the status
    #: "unknown" at a tolerance of 1e-4.
    stops_early: bool = False
    decides: bool = True  #: True if the verdicts "infeasible" and "unbounded" can be trusted
    conic: bool = False  #: True if the solver supports second-order cones
    nonlinear: bool = False  #: True if the solver is used for nonlinear programs only

    @property
    def linear(self) -> bool:
        """Return True if the solver can solve linear programs."""
        return not self.nonlinear and self.language != MATRICES


@dataclass(frozen=True)
class Solver:
    """Solver with its options and its tolerance, which applies to feasibility and to the duality gap."""

    entry: SolverEntry
    options: dict[str, Any]
    tolerance: float = SOLVER_TOLERANCE

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle only the key of the solver, because its entry contains functions that cannot be pickled."""
        return find_solver, self.key

    @property
    def name(self) -> str:
        """Return the name by which a user selects the solver."""
        return self.entry.name

    @property
    def language(self) -> str:
        """Return the modelling language from which the solver is called; "matrices" if there is none."""
        return self.entry.language

    @property
    def key(self) -> tuple[str, str, float]:
        """Return the modelling language, name and tolerance, which together identify the solver."""
        return self.language, self.name, self.tolerance


def _clarabel(tolerance: float) -> dict[str, Any]:
    options: dict[str, Any] = {"tol_gap_abs": tolerance, "tol_gap_rel": tolerance, "tol_feas": tolerance}
    # Select the linear solver qdldl. For more than about 100,000 joints, Clarabel would choose faer, which
    # takes four times as long.
    options["direct_solve_method"] = "qdldl"
    if tolerance >= 1e-5:
        # Iterative refinement takes a third of the time. At a tolerance of 1e-5 or more, its additional
        # digits are not needed.
        options["iterative_refinement_enable"] = False
    return options


def _feasibility(tolerance: float) -> dict[str, Any]:
    names = ("primal_feasibility_tolerance", "dual_feasibility_tolerance")
    return dict.fromkeys(names, max(tolerance, 1e-10))  # 1e-10 is the smallest value that HiGHS accepts


def _highs_simplex(tolerance: float) -> dict[str, Any]:
    return {"solver": "simplex", **_feasibility(tolerance)}


def _highs_interior(tolerance: float, solver: str = "ipx") -> dict[str, Any]:
    # Crossover is switched off, because it ends in a vertex, at which some joints have no normal force. The
    # loop of linear programs needs an optimal state in which these joints are pressed.
    interior = {"run_crossover": "off", "ipm_optimality_tolerance": max(tolerance, 1e-12)}
    # The older interior-point method is named "ipx". With "ipm", HiGHS would use the newer HiPO if installed.
    return {"solver": solver, **_feasibility(tolerance), **interior}


def _first_order(**iteration_limit: int) -> Options:
    # First-order solvers need many cheap iterations, so the iteration limit is higher than the default limit
    # of OSQP.
    return lambda tolerance: {"eps_abs": tolerance, "eps_rel": tolerance, **iteration_limit}


_highs_hipo = partial(_highs_interior, solver="hipo")


@cache
def _installed_for_cvxpy() -> frozenset[str]:
    import cvxpy as cp

    return frozenset(cp.installed_solvers())


_ENTRIES = (
    SolverEntry("clarabel", "cvxpy", "CLARABEL", _clarabel, interior=True, stops_early=True, conic=True),
    SolverEntry("highs", "cvxpy", "HIGHS", _highs_simplex),
    SolverEntry("highs-ipm", "cvxpy", "HIGHS", _highs_interior, interior=True),
    SolverEntry("highs-hipo", "cvxpy", "HIGHS", _highs_hipo, interior=True),
    SolverEntry("osqp", "cvxpy", "OSQP", _first_order(max_iter=100_000), decides=False),
    SolverEntry("scs", "cvxpy", "SCS", _first_order(max_iters=100_000), decides=False, conic=True),
    SolverEntry("scipy", "cvxpy", "SCIPY", lambda tolerance: {"scipy_options": _feasibility(tolerance)}),
    SolverEntry("highs", "pyomo", "highs", _highs_simplex),
    SolverEntry("highs-ipm", "pyomo", "highs", _highs_interior, interior=True),
    SolverEntry("highs-hipo", "pyomo", "highs", _highs_hipo, interior=True),
    SolverEntry("casadi", "pyomo", "ipopt", None, "casadi", interior=True, nonlinear=True),
    # Newton's method of this package
    SolverEntry("newton", MATRICES, "newton", None, interior=True),
)

#: Solvers by language and name. The first entry of a language is its default solver.
SOLVERS: dict[tuple[str, str], SolverEntry] = {(entry.language, entry.name): entry for entry in _ENTRIES}


def names() -> list[str]:
    """Return the names of all registered solvers, and of further solvers that are installed for CVXPY."""
    known = [name for _, name in SOLVERS]
    return list(dict.fromkeys([*known, *sorted(engine.lower() for engine in _installed_for_cvxpy())]))


def capable(language: str, has: Callable[[SolverEntry], bool]) -> tuple[str, ...]:
    """Return the names of a modelling language's solvers that have a capability, the default solver first.

    ``has`` is a function that returns True for the entry of a solver with the capability. Solvers that are
    not installed are included.
    """
    return tuple(entry.name for entry in _ENTRIES if entry.language == language and has(entry))


def find_solver(language: str, name: str | None, tolerance: float = SOLVER_TOLERANCE) -> Solver:
    """Return the solver of a given name in a modelling language; without a name, the default solver.

    For CVXPY, other installed solvers are accepted too, with their own default tolerances.

    Raises
    ------
    OptionError
        If the language is unknown, if the solver is unknown in this language or not installed, or if the
        tolerance is not a number above 0 and at most 0.1.
    """
    if language not in MODELS:
        raise OptionError(f"model '{language}' is unknown{instead_of(language, MODELS)}")
    known = capable(language, lambda entry: not entry.nonlinear)
    name = (name or known[0]).lower()
    entry = SOLVERS.get((language, name))
    if entry is None and language == "cvxpy" and name.upper() in _installed_for_cvxpy():
        entry = SolverEntry(name, language, name.upper(), None, decides=False)
    if entry is None:
        addition = ", or any solver installed for CVXPY" if language == "cvxpy" else ""
        near = did_you_mean(name, known) or f"; choose from: {', '.join(known)}{addition}"
        raise OptionError(f"solver '{name}' is unknown for model '{language}'{near}")
    if entry.brought_by and not importlib.util.find_spec(entry.brought_by):
        raise OptionError(
            f"solver '{name}' needs CasADi, which contains IPOPT: install it with pip install '.[mpec]'"
        )
    if not (isinstance(tolerance, float) and 0 < tolerance <= 0.1):
        raise OptionError(f"tolerance must be a number above 0 and at most 0.1 (found {tolerance!r})")
    return Solver(entry, entry.options(tolerance) if entry.options else {}, tolerance)


def rougher(solver: Solver, tolerance: float) -> Solver:
    """Return the solver with the larger of two tolerances: its own tolerance and a given tolerance."""
    return find_solver(solver.language, solver.name, max(tolerance, solver.tolerance))


def in_cvxpy(solver: Solver, cones: bool = False) -> Solver:
    """Return the solver of the same name in CVXPY, or CVXPY's default solver if this solver is unsuitable.

    The result is used for programs that are declared only in CVXPY. Its tolerance is the default tolerance.

    A solver is unsuitable in three cases:

    - it is not registered for CVXPY;
    - its verdicts "infeasible" and "unbounded" cannot be trusted;
    - the program has cones (``cones`` is True), and the solver does not support them.
    """
    entry = SOLVERS.get(("cvxpy", solver.name))
    is_suitable = entry is not None and entry.decides and (entry.conic or not cones)
    return find_solver("cvxpy", solver.name if is_suitable else None)


class Verdict(Enum):
    """Outcome of a solve."""

    OPTIMAL = "optimal"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    #: The presolve found that no optimum exists, but did not decide if the program is infeasible or
    #: unbounded.
    INFEASIBLE_OR_UNBOUNDED = "infeasible or unbounded"
    FAILED = "solver failed"
    #: The solution of the solver is less accurate than the tolerance. The certificate of the answer decides
    #: if the solution is accepted.
    NEARLY = "nearly optimal"


@dataclass(frozen=True)
class Solved:
    """Outcome of one solve: verdict, status text of the solver, and time in seconds."""

    verdict: Verdict
    status: str
    seconds: float

    def readable(self, nearly: bool) -> bool:
        """Return True if the solver found a solution whose values can be read.

        If ``nearly`` is True, a nearly optimal point counts as a solution.
        """
        return self.verdict is Verdict.OPTIMAL or (nearly and self.verdict is Verdict.NEARLY)

    @property
    def failed(self) -> bool:
        """Return True if the solver found neither an optimum nor a proof that no optimum exists."""
        return self.verdict in (Verdict.FAILED, Verdict.NEARLY)


def iterations_of(info: Any) -> int:
    """Return the number of iterations of a HiGHS run.

    HiGHS reports −1 for an algorithm that did not run.
    """
    return max(info.simplex_iteration_count, 0) + max(info.ipm_iteration_count, 0)


@dataclass(frozen=True)
class LpSize:
    """Numbers of rows, columns and nonzeros of a linear program in the form that the solver receives."""

    rows: int
    columns: int
    nonzeros: int
