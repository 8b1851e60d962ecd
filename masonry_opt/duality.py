"""Cross-check of the associative problem: static and kinematic formulation, in CVXPY and in Pyomo.

The dual variables of each model must be the unknowns of the other formulation. For a stable scene without
live load, the margin of stability is computed in place of a load factor.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from masonry_opt.analysis import solve
from masonry_opt.brief import brief
from masonry_opt.effort import Effort
from masonry_opt.errors import NoLoadFactorError, printable
from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.problem.problem import Problem, State
from masonry_opt.reporting.linear_laws import BY_CHORDS, by_sides
from masonry_opt.reporting.sentences import numeral
from masonry_opt.reporting.stability import STABLE
from masonry_opt.reporting.summary import of_fills
from masonry_opt.reporting.terminal import frame_text
from masonry_opt.result import Result
from masonry_opt.scene.mistakes import suggests_arguments
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.acceptance import AGREEMENT, DUALITY
from masonry_opt.solution.answer import Existence
from masonry_opt.solution.reasons import Reason
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.registry import LANGUAGES, find_solver
from masonry_opt.stability.dead_load import with_pressure_removed

if TYPE_CHECKING:
    import pandas as pd

#: Tolerance of the solvers in the cross-check of statics and kinematics. With Clarabel's default tolerance,
#: duality gaps reach 7e-7 in scenes with fill. If a solver does not reach the tolerance but reports a nearly
#: optimal point, the values of this point are compared.
_SOLVER_TOLERANCE = 1e-11


@dataclass(frozen=True)
class DualityReport:
    """Comparison of four solutions of the associative problem: static and kinematic, in CVXPY and Pyomo.

    Attributes
    ----------
    table: one row for each formulation and language. Columns are ``formulation``, ``model``, ``load_factor``,
        its relative ``difference`` from the median of all four, and residuals. The residuals are
        ``equilibrium``, ``yield``, ``kinematics``, ``virtual_work`` and ``complementarity``. ``kinematics``
        is the residual of Bᵀd = D p with p ≥ 0, divided by the largest velocity. ``virtual_work`` and
        ``complementarity`` are relative to λ Σ|f_L|.
    crushing: True if the strength of a joint is limited; all four solutions limit the strength by chords.
    friction: description of the polygons that limit friction in space; "" in the plane, and if friction is
        unlimited.
    cones: load factors of the static and the kinematic program in space, with the cones in which the polygons
        are inscribed; None in the plane.
    warnings: probable mistakes in the scene, as codes with values.
    warning_sentences: probable mistakes in the scene, as sentences.
    fills: the effect of each fill, as sentences.
    of_stability: True if no live load acts. The load factors in ``table`` and ``cones`` are then margins of
        stability: the normal force, in median block weights, that every joint can lose.
    load_factor_scale: Scale on which the load factors are compared.
    """

    table: "pd.DataFrame"
    crushing: bool = False
    friction: str = ""
    cones: tuple[float, float] | None = None
    warnings: tuple[Reason, ...] = ()
    warning_sentences: tuple[str, ...] = ()
    fills: tuple[str, ...] = ()
    of_stability: bool = False
    load_factor_scale: LoadFactorScale = field(default_factory=LoadFactorScale)

    __repr__ = brief

    @property
    def passed(self) -> bool:
        """True if all load factors agree to 1e-7, and all residuals are at most 1e-6.

        In space the cones of friction must also have no lower load factor than the polygons inside them.
        """
        residuals = self.table.drop(columns=["formulation", "model", "load_factor", "difference"])
        agree = bool((self.table["difference"] <= AGREEMENT).all() and (residuals <= DUALITY).all(axis=None))
        gap, missed = self._cone_differences
        return agree and gap <= AGREEMENT and missed >= -AGREEMENT

    @property
    def _cone_differences(self) -> tuple[float, float]:
        """Relative differences between static and kinematic λ, and between λ of friction cones and polygons.

        Both differences are zero in the plane. In space, the first is the absolute difference between the
        static and the kinematic λ, both with friction cones. The second is positive if λ is lower with
        friction polygons than with friction cones.
        """
        static, kinematic = self.cones or (0.0, 0.0)
        missed = static - float(self.table["load_factor"].median()) if self.cones else 0.0
        divisor = self.load_factor_scale.divisor(static)
        return abs(static - kinematic) / divisor, missed / divisor

    def __str__(self) -> str:
        verdict = "the static and kinematic formulations in CVXPY and Pyomo agree"
        if not self.passed:
            verdict = (
                "the static and kinematic formulations in CVXPY and Pyomo do NOT agree: see the differences "
                "and residuals below"
            )
        median = numeral(float(self.table["load_factor"].median()), ".7f")
        difference = self.table["difference"].max()
        relative = f"largest relative difference {difference:.1e}"
        answer = [f"associative load factor {median} ({relative})"]
        if self.of_stability:
            margin = (
                f"margin of stability: every joint can lose a normal force of {median} times the median "
                f"block weight ({relative})"
            )
            answer = [STABLE, margin]
        lines = [
            verdict,
            *answer,
            *([f"joints crush by {BY_CHORDS}"] if self.crushing else []),
            *([f"friction {self.friction}"] if self.friction else []),
            *(f"fill {sentence}" for sentence in self.fills),
        ]
        if self.cones and self.friction:
            gap, missed = self._cone_differences
            by_cone = numeral(self.cones[0], ".7f")
            lines.append(
                f"λ is {by_cone} with friction cones (static and kinematic λ differ by {gap:.1e}), and "
                f"{missed:.2%} lower with friction polygons"
            )
        lines += ["", frame_text(self.table, "residuals of each solution (0 is exact)")]
        lines += [f"warning: {sentence}" for sentence in self.warning_sentences]
        return printable("\n".join(lines)).rstrip("\n")


@suggests_arguments
def check(scene: Scene | str | Path) -> DualityReport:
    """Compare the static and the kinematic solution of the associative problem, each in CVXPY and Pyomo.

    For a stable scene without live load, the four programs compute its margin of stability.

    Parameters
    ----------
    scene: A scene, or the path of a case file.

    Returns
    -------
    DualityReport
        The four load factors, their differences and residuals.

    Raises
    ------
    CaseError
        If the scene is wrong.
    NoLoadFactorError
        If the scene has no associative load factor to compare; without live load, if it is unstable, or if
        its margin of stability is unlimited.
    """
    # pandas is imported only for this check, because its import would delay the command ``solve`` by a
    # quarter of a second.
    import pandas as pd

    result = solve(scene, "static")
    problem = result.assembly.problem
    if result.stability:
        problem = _of_margin(result)
    else:
        result.required()

    def solve_with(problem: Problem, formulation: str, language: str) -> State:
        """Solve one formulation in one modelling language, and return the optimal state.

        Raises NoLoadFactorError if the solver finds no state.
        """
        solver = find_solver(language, None, _SOLVER_TOLERANCE)
        driver = Driver(problem, formulation, solver, Effort(), of_load=True)
        answer = driver.solve(nearly=True)
        if answer.state is None:
            raise NoLoadFactorError(
                f"{result.case}: no solution of the {formulation} formulation was found in {language}: the "
                f"solver stopped with '{answer.solved.status}'",
                result.warning_sentences,
            )
        return answer.state

    rows = [
        {"formulation": formulation, "model": language}
        | _row(problem, solve_with(problem, formulation, language))
        for language in LANGUAGES
        for formulation in ("static", "kinematic")
    ]
    table = pd.DataFrame(rows)
    median, scale = float(table["load_factor"].median()), problem.load_factor_scale
    table.insert(3, "difference", (table["load_factor"] - median).abs() / scale.divisor(median))
    friction = by_sides(problem.layout) if problem.by_friction.word and len(problem.sliding) else ""
    cones = None
    by_cone = problem.by_cone
    if by_cone.by_friction.conic:
        static, kinematic = (
            solve_with(by_cone, formulation, "cvxpy") for formulation in ("static", "kinematic")
        )
        cones = static.load_factor, kinematic.load_factor
    return DualityReport(
        table,
        bool(result.crushing),
        friction,
        cones,
        result.warnings,
        result.warning_sentences,
        tuple(of_fills(result.assembly)),
        result.stability is not None,
        scale,
    )


def _of_margin(result: Result) -> Problem:
    """Return a problem whose associative load factor equals the margin of stability of a stable scene.

    Raises NoLoadFactorError if the scene has no joints, or if self-stress can press all joints without limit.
    """
    from masonry_opt.stability.existence import existence

    if not result.size.joints:
        raise NoLoadFactorError(
            f"{result.case}: {STABLE}; no blocks touch, so there is no margin of stability to compare",
            result.warning_sentences,
        )
    problem = with_pressure_removed(result.assembly.problem)
    certificate = existence(problem, Effort(), of_mechanism=False) if problem.live_norm else None
    if not problem.live_norm or (certificate and certificate.existence is Existence.UNBOUNDED):
        margin = "self-stress can press all joints without limit, so there is no margin to compare"
        raise NoLoadFactorError(f"{result.case}: {STABLE}; {margin}", result.warning_sentences)
    return problem


def _row(problem: Problem, state: State) -> dict[str, float]:
    """Return the load factor of a state, and its residuals in both formulations.

    The keys are the names of columns of ``DualityReport.table``.
    """
    balance = problem.unbalanced(state.load_factor, state.q)
    z = problem.slacks(state.q)
    departure = problem.departure(state.d, state.p, problem.friction)
    velocity = np.abs(state.d).max()
    external = state.load_factor * problem.live @ state.d + problem.dead @ state.d
    work = abs(external - problem.face_cohesion @ state.p)
    energy = np.abs(z * state.p).sum()
    divisor = problem.live_norm * problem.load_factor_scale.divisor(state.load_factor)
    return {
        "load_factor": state.load_factor,
        "equilibrium": float(np.abs(balance).max() / problem.blocks),
        "yield": float(max(-z.min(), 0.0)),
        "kinematics": float(max(np.abs(departure).max(), -state.p.min(), 0.0) / velocity),
        "virtual_work": float(work / divisor),
        "complementarity": float(energy / divisor),
    }
