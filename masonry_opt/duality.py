"""Duality: static against kinematic, CVXPY against Pyomo, and each model's duals as kinematics."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from masonry_opt.analysis import solve
from masonry_opt.answer.acceptance import AGREEMENT, DUALITY, SMALLEST, over_load_factor
from masonry_opt.answer.reasons import Reason
from masonry_opt.effort import Effort
from masonry_opt.errors import NoLoadFactorError, printable
from masonry_opt.problem.problem import Problem, State
from masonry_opt.scene.scene import Scene
from masonry_opt.solvers.driver import Driver
from masonry_opt.solvers.registry import LANGUAGES, find_solver
from masonry_opt.words.sentences import BY_CHORDS, by_sides, numeral
from masonry_opt.words.summary import of_fills
from masonry_opt.words.terminal import frame_text

if TYPE_CHECKING:
    import pandas as pd

#: Asked of solvers here: at the default tolerance Clarabel leaves gaps to 7e-7 under fill. Its last point
#: counts even where it stops short of this: residuals judge it.
_SOLVER_TOLERANCE = 1e-11


@dataclass(frozen=True)
class DualityReport:
    """Four answers to the associative problem, with their residuals.

    Attributes
    ----------
    table: one row a formulation and language: ``load_factor``, ``difference`` (relative, from the
        median of all), and the residuals ``equilibrium``, ``yield``, ``kinematics`` (Bᵀd = D p with
        p ≥ 0, over the largest velocity), ``virtual_work`` and ``complementarity`` (both over λ Σ|f_L|).
    crushing: whether any joint's strength is limited; by chords in all four.
    friction: by which polygons it is limited in space, in all four; "" in the plane, and unlimited.
    cones: load factors in space by the cones that these lie in, of statics and kinematics; None in the plane.
    warnings, warning_sentences: what looks unintended in the scene, as in a result.
    fills: what each fill does, in words.
    """

    table: "pd.DataFrame"
    crushing: bool = False
    friction: str = ""
    cones: tuple[float, float] | None = None
    warnings: tuple[Reason, ...] = ()
    warning_sentences: tuple[str, ...] = ()
    fills: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Load factors agree to 1e-7 relative, every residual is below 1e-6; by cones λ is no less."""
        residuals = self.table.drop(columns=["formulation", "model", "load_factor", "difference"])
        agree = bool((self.table["difference"] <= AGREEMENT).all() and (residuals <= DUALITY).all(axis=None))
        gap, missed = self._beside_cones
        return agree and gap <= AGREEMENT and missed >= -AGREEMENT

    @property
    def _beside_cones(self) -> tuple[float, float]:
        """Difference of statics and kinematics by cones, and by how much λ is lower by polygons, relative."""
        static, kinematic = self.cones or (0.0, 0.0)
        missed = static - float(self.table["load_factor"].median()) if self.cones else 0.0
        return abs(static - kinematic) / max(abs(static), SMALLEST), missed / max(abs(static), SMALLEST)

    def __str__(self) -> str:
        agree = "agree" if self.passed else "do NOT agree: see differences and residuals below"
        middle = numeral(float(self.table["load_factor"].median()), ".7f")
        apart = self.table["difference"].max()
        lines = [
            "static and kinematic, CVXPY and Pyomo " + agree,
            f"associative load factor {middle} (largest relative difference {apart:.1e})",
            *([f"joints crush by {BY_CHORDS}"] if self.crushing else []),
            *([f"friction {self.friction}"] if self.friction else []),
            *(f"fill {said}" for said in self.fills),
        ]
        if self.cones and self.friction:
            (gap, missed), by_cone = self._beside_cones, numeral(self.cones[0], ".7f")
            with_cone = f"with the cone λ = {by_cone} (static and kinematic differ by {gap:.1e})"
            lines.append(f"{with_cone}; the polygon gives {missed:.2%} less")
        lines += ["", frame_text(self.table, "residuals of each solution (0 is exact)")]
        lines += [f"warning: {sentence}" for sentence in self.warning_sentences]
        return printable("\n".join(lines)).rstrip("\n")


def check(scene: Scene | str | Path) -> DualityReport:
    """Solve the associative problem in four ways and compare the answers.

    Parameters
    ----------
    scene: a scene, or the path of a case file.

    Raises
    ------
    CaseError
        If the scene is wrong.
    NoLoadFactorError
        If the scene has no associative load factor to compare.
    """
    # Importing pandas takes a quarter of a second, and the command solve imports this module.
    import pandas as pd

    result = solve(scene, "static")
    result.required()
    problem = result.assembly.problem

    def solved(problem: Problem, formulation: str, language: str) -> State:
        solver = find_solver(language, None, _SOLVER_TOLERANCE)
        driver = Driver(problem, formulation, solver, Effort(), of_load=True)
        answer = driver.solve(nearly=True)
        if answer.state is None:
            raise NoLoadFactorError(
                f"{result.case}: {formulation}, {language}: the solver stopped with '{answer.solved.status}'"
            )
        return answer.state

    rows = [
        {"formulation": formulation, "model": language}
        | _row(problem, solved(problem, formulation, language))
        for language in LANGUAGES
        for formulation in ("static", "kinematic")
    ]
    table = pd.DataFrame(rows)
    middle = float(table["load_factor"].median())
    table.insert(3, "difference", (table["load_factor"] - middle).abs() / max(abs(middle), SMALLEST))
    friction = by_sides(problem.layout) if problem.by_friction.word and len(problem.sliding) else ""
    cones = None
    if (by_cone := problem.by_cone).by_friction.conic:
        static, kinematic = (solved(by_cone, each, "cvxpy") for each in ("static", "kinematic"))
        cones = static.load_factor, kinematic.load_factor
    warnings, fills = (result.warnings, result.warning_sentences), tuple(of_fills(result.assembly))
    return DualityReport(table, bool(result.crushing), friction, cones, *warnings, fills)


def _row(problem: Problem, state: State) -> dict[str, float]:
    balance = problem.unbalanced(state.load_factor, state.q)
    z = problem.slacks(state.q)
    departure = problem.departure(state.d, state.p, problem.friction)
    velocity = np.abs(state.d).max()
    external = state.load_factor * problem.live @ state.d + problem.dead @ state.d
    work, energy = abs(external - problem.face_cohesion @ state.p), np.abs(z * state.p).sum()
    return {
        "load_factor": state.load_factor,
        "equilibrium": float(np.abs(balance).max() / problem.blocks),
        "yield": float(max(-z.min(), 0.0)),
        "kinematics": float(max(np.abs(departure).max(), -state.p.min(), 0.0) / velocity),
        "virtual_work": over_load_factor(float(work / problem.live_norm), state.load_factor),
        "complementarity": over_load_factor(float(energy / problem.live_norm), state.load_factor),
    }
