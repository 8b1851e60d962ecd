"""Every solver a user can name (adding one is one entry), what it can solve, and how a solve ends."""

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import cache, partial
from typing import Any

from masonry_opt.errors import OptionError

TOLERANCE = 1e-9  #: Feasibility and gap tolerance asked of every solver; looser values cost digits of λ.

#: The modelling languages, the default first; in their place, what is solved where nothing is declared; both.
LANGUAGES = ("cvxpy", "pyomo")
MATRICES = "matrices"
MODELS = (*LANGUAGES, MATRICES)

Options = Callable[[float], dict[str, Any]]


@dataclass(frozen=True)
class SolverEntry:
    """A solver as one modelling language drives it, or one of matrices."""

    name: str
    language: str  #: one of ``MODELS``
    engine: str  #: its name in that language
    options: Options | None  #: its options by tolerance; None if it keeps tolerances of its own
    brought_by: str = ""  #: the module that brings it, if this package does not require it
    interior: bool = False  #: whether it ends inside the set of optimal states, not in a vertex
    stops_early: bool = False  #: whether it saves time at a rough tolerance (HiGHS ends "unknown" at 1e-4)
    decides: bool = True  #: whether its verdicts "infeasible" and "unbounded" can be trusted
    conic: bool = False  #: whether it takes second-order cones
    nonlinear: bool = False  #: whether it solves such programs, and nothing else here

    @property
    def linear(self) -> bool:
        """Whether it solves linear programs."""
        return not self.nonlinear and self.language != MATRICES


@dataclass(frozen=True)
class Solver:
    """A solver, its options, and the feasibility and gap that they ask of it."""

    entry: SolverEntry
    options: dict[str, Any]
    tolerance: float = TOLERANCE

    def __reduce__(self) -> tuple[Any, ...]:
        """Found anew by name in another process: entries have functions."""
        return find_solver, self.key

    @property
    def name(self) -> str:
        """What a user calls it."""
        return self.entry.name

    @property
    def language(self) -> str:
        """The modelling language that drives it, or "matrices"."""
        return self.entry.language

    @property
    def key(self) -> tuple[str, str, float]:
        """Language, name and tolerance."""
        return self.language, self.name, self.tolerance


def _clarabel(tolerance: float) -> dict[str, Any]:
    options: dict[str, Any] = {"tol_gap_abs": tolerance, "tol_gap_rel": tolerance, "tol_feas": tolerance}
    # Its own choice is faer from some hundred thousand joints on, which takes four times as long there.
    options["direct_solve_method"] = "qdldl"
    if tolerance >= 1e-5:
        options["iterative_refinement_enable"] = False  # a third of the time, for digits that are not asked
    return options


def _feasibility(tolerance: float) -> dict[str, Any]:
    names = ("primal_feasibility_tolerance", "dual_feasibility_tolerance")
    return dict.fromkeys(names, max(tolerance, 1e-10))  # HiGHS takes no less


def _highs_simplex(tolerance: float) -> dict[str, Any]:
    return {"solver": "simplex", **_feasibility(tolerance)}


def _highs_interior(tolerance: float, solver: str = "ipx") -> dict[str, Any]:
    # "ipm" would be HiPO where that is installed. Crossover would end in a vertex, and the loop needs the
    # middle of the optimal states.
    interior = {"run_crossover": "off", "ipm_optimality_tolerance": max(tolerance, 1e-12)}
    return {"solver": solver, **_feasibility(tolerance), **interior}


def _first_order(**most: int) -> Options:
    # They take many cheap iterations; OSQP's own limit is a tenth of SCS's.
    return lambda tolerance: {"eps_abs": tolerance, "eps_rel": tolerance, **most}


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
    # This package's own, of the complementarity problem.
    SolverEntry("newton", MATRICES, "newton", None, interior=True),
)

#: By language and name. The first of a language is its default.
SOLVERS: dict[tuple[str, str], SolverEntry] = {(entry.language, entry.name): entry for entry in _ENTRIES}


def names() -> list[str]:
    """Every solver by name, in any language, installed or not, and what CVXPY finds beside them."""
    known = [name for _, name in SOLVERS]
    return list(dict.fromkeys([*known, *sorted(engine.lower() for engine in _installed_for_cvxpy())]))


def capable(language: str, of: Callable[[SolverEntry], bool]) -> tuple[str, ...]:
    """Names of the solvers in that language that can do something, installed or not; its default first."""
    return tuple(entry.name for entry in _ENTRIES if entry.language == language and of(entry))


def find_solver(language: str, name: str | None, tolerance: float = TOLERANCE) -> Solver:
    """The solver of that name in that language, or its default, with a tolerance; in CVXPY also any other
    that is installed, with tolerances of its own. Raises OptionError if the language is unknown, the solver
    unknown there or not installed, or the tolerance no number between 0 and 0.1."""
    if language not in MODELS:
        raise OptionError(f"model '{language}' is unknown; choose from: {', '.join(MODELS)}")
    known = capable(language, lambda entry: not entry.nonlinear)
    name = (name or known[0]).lower()
    entry = SOLVERS.get((language, name))
    if entry is None and language == "cvxpy" and name.upper() in _installed_for_cvxpy():
        entry = SolverEntry(name, language, name.upper(), None, decides=False)
    if entry is None:
        others = "; or any other that CVXPY finds installed" if language == "cvxpy" else ""
        raise OptionError(
            f"solver '{name}' is unknown for model '{language}'; choose from: {', '.join(known)}{others}"
        )
    if entry.brought_by and not importlib.util.find_spec(entry.brought_by):
        raise OptionError(f"solver '{name}' is not installed: CasADi brings IPOPT: pip install '.[mpec]'")
    if not (isinstance(tolerance, float) and 0 < tolerance <= 0.1):
        raise OptionError(f"tolerance must be a number above 0, at most 0.1 (found {tolerance!r})")
    return Solver(entry, entry.options(tolerance) if entry.options else {}, tolerance)


def rougher(solver: Solver, tolerance: float) -> Solver:
    """The same solver, its tolerance this at least."""
    return find_solver(solver.language, solver.name, max(tolerance, solver.tolerance))


def in_cvxpy(solver: Solver, cones: bool = False) -> Solver:
    """The same solver at its default tolerance, for programs that are declared in CVXPY alone; CVXPY's
    default where CVXPY does not drive it, its verdicts cannot be trusted, or there are cones, which it does
    not take."""
    entry = SOLVERS.get(("cvxpy", solver.name))
    fit = entry is not None and entry.decides and (entry.conic or not cones)
    return find_solver("cvxpy", solver.name if fit else None)


class Verdict(Enum):
    """Outcome of a solve."""

    OPTIMAL = "optimal"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    INFEASIBLE_OR_UNBOUNDED = "infeasible or unbounded"  #: what presolve may stop at
    FAILED = "solver failed"
    NEARLY = "nearly optimal"  #: a point short of the solver's tolerance, which a certificate must judge


@dataclass(frozen=True)
class Solved:
    """One solve: its outcome, the same in the solver's own words, and the solver's own time (s)."""

    verdict: Verdict
    status: str
    seconds: float

    def readable(self, nearly: bool) -> bool:
        """Whether there is an optimum to read; or, where what is ``nearly`` one will do, such a point."""
        return self.verdict is Verdict.OPTIMAL or (nearly and self.verdict is Verdict.NEARLY)

    @property
    def failed(self) -> bool:
        """Whether the solver decided nothing."""
        return self.verdict in (Verdict.FAILED, Verdict.NEARLY)


def iterations_of(info: Any) -> int:
    """Iterations of a run of HiGHS; counts of what did not run are negative."""
    return max(info.simplex_iteration_count, 0) + max(info.ipm_iteration_count, 0)


@dataclass(frozen=True)
class LpSize:
    """Size of a linear program as the solver received it."""

    rows: int
    columns: int
    nonzeros: int
