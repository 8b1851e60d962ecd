"""Function ``certify``: the residuals of a collapse state that a user brings, computed from the matrices."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_opt.errors import OptionError, printable
from masonry_opt.methods.running import NO_WORK
from masonry_opt.problem.arguments import vector
from masonry_opt.problem.assembly import Assembly, assemble
from masonry_opt.problem.names import ProblemNames
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.mistakes import suggests_arguments
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.acceptance import LIMITS, Kind, Limits
from masonry_opt.solution.answer import (
    Answer,
    Certificate,
    certified,
    largest_acting,
    unbalanced_shares,
    violation_shares,
)
from masonry_opt.suitability import refuse_without_live_load

if TYPE_CHECKING:
    import pandas as pd

#: Values of the argument ``friction``. In space, "cone" selects the exact friction cone, and "polygon"
#: selects a polygon with 24 sides inside the cone.
_FRICTION_LAWS = ("cone", "polygon")

#: Values of the argument ``crushing``: joints of limited strength follow the crushing parabola or its chords.
_CRUSHING_LAWS = ("chords", "parabola")

#: Largest residuals with which :func:`certify` accepts a state as exact. The residual ``work`` is the largest
#: relative error of λ that unbalanced forces can cause. With a larger limit of ``work``, states with a less
#: accurate λ are accepted. In exact states of this package, ``work`` is below 1e-9, or at most 3e-7 if the
#: live load acts on very light blocks.
_LIMITS_OF_USERS_STATES: Limits = replace(LIMITS[Kind.EXACT], work=1e-6)


@dataclass(frozen=True, eq=False)
class StateCheck:
    """Residuals of a collapse state with load factor λ, joint forces q and block velocities d.

    All numbers are in the units of the problem that ``mo.assemble`` returns. Names of rows and columns
    consist of a kind and blocks, such as ``n1[A|ground]``.

    Attributes
    ----------
    exact: True if no residual exceeds its limit, which makes the state an exact collapse state.
    load_factor: the load factor λ.
    load_factor_error: largest effect of the unbalanced forces on λ.
    certificate: residuals of the scene as a whole. Its ``complementarity`` is relative to the work of the
        live load at λ = 1.
    table: one row for each residual, with columns ``residual``, ``value``, ``limit``, ``passed``, and
        ``largest_at``, the row, column, yield condition, joint or block that has the largest residual.
        The rows ``complementarity`` and ``work`` are relative to the work of the live load at λ, so
        ``complementarity`` is the value of the certificate divided by |λ|, or by 0.01 if |λ| is smaller. If
        the live load exceeds the dead load, 0.01 is multiplied by the dead load over the live load. The row
        ``work`` is the work of the unbalanced forces. The row ``block`` is the largest unbalanced force on a
        block, relative to the largest force on this block. The row ``joint`` is the largest violation of a
        yield condition, relative to the largest force on the less loaded block of the joint.
    rows: one row for each equation of equilibrium. Columns are ``name``, the terms ``joints`` (B q), ``live``
        (λ f_L) and ``dead`` (f_D), their sum ``unbalanced``, the ``velocity`` d and its name ``of_velocity``.
    columns: one row for each joint force. Columns are ``name``, ``force`` (q), ``of_motion``, ``motion``
        (Bᵀd), ``flow`` (D p) and their difference ``departure``.
    conditions: one row for each yield condition. Columns are ``name``, ``slack`` (z) and ``rate`` (p).
    """

    assembly: Assembly
    q: np.ndarray  #: joint forces, as passed
    #: Collapse state and its residuals, computed with the matrices of ``problem``.
    answer: Answer
    #: Problem with which the residuals are computed. If only the dead load does positive work in the
    #: mechanism, the dead load and the live load are exchanged. The exchange does not change the total load
    #: at the load factor λ of the state.
    problem: Problem

    @property
    def exact(self) -> bool:
        """True if no residual exceeds its limit."""
        return not _LIMITS_OF_USERS_STATES.failing(self.answer.residuals)

    @property
    def load_factor(self) -> float:
        """Load factor λ of the state."""
        return self.answer.load_factor

    @property
    def load_factor_error(self) -> float:
        """Largest error of λ that the unbalanced forces can cause.

        The error follows from the virtual work of the unbalanced forces in the mechanism. The error is the
        residual ``work`` times |λ|, or times 0.01 if |λ| is smaller. If the live load exceeds the dead load,
        0.01 is multiplied by the dead load over the live load. The error is infinite if the loads do no
        positive work in the mechanism.
        """
        return self.answer.residuals["work"] * self.problem.load_factor_scale.divisor(self.load_factor)

    @property
    def certificate(self) -> Certificate:
        """Residuals of equilibrium, yield conditions, flow rule and complementarity, for the whole scene."""
        return self.answer.certificate

    @cached_property
    def table(self) -> "pd.DataFrame":
        """Table with one row for each residual: its value, its limit, and the place where it is largest."""
        import pandas as pd

        limits, largest_at = _LIMITS_OF_USERS_STATES.as_dict(), self._largest_at()
        failing = _LIMITS_OF_USERS_STATES.failing(self.answer.residuals)
        return pd.DataFrame(
            {
                "residual": name,
                "value": value + 0.0,  # turns −0.0 into 0.0
                "limit": limits[name],
                "passed": name not in failing,
                "largest_at": largest_at[name] if value else "",
            }
            for name, value in self.answer.residuals.items()
        )

    @cached_property
    def rows(self) -> "pd.DataFrame":
        """Table with one row for each equation of equilibrium: its terms and its residual.

        Equilibrium is eq. (1) of the paper.
        """
        import pandas as pd

        problem, q = self._scene_problem, self.q
        terms = {
            "joints": problem.B @ q,
            "live": self.load_factor * problem.live,
            "dead": problem.dead,
            "unbalanced": problem.unbalanced(self.load_factor, q),
        }
        velocities = {"of_velocity": self._names.velocities, "velocity": self.answer.d}
        return pd.DataFrame({"name": self._names.balances, **terms, **velocities})

    @cached_property
    def columns(self) -> "pd.DataFrame":
        """Table with one row for each joint force: its value, and the motion of the joint.

        The table compares the motion Bᵀd with the motion D p of the flow rule, eqs (2) and (5) of the paper.
        """
        import pandas as pd

        motion, departure = self.problem.motion(self.answer.d), self._departure
        motions = {"of_motion": self._names.motions, "motion": motion, "flow": motion - departure}
        return pd.DataFrame({"name": self._names.forces, "force": self.q, **motions, "departure": departure})

    @cached_property
    def conditions(self) -> "pd.DataFrame":
        """Table with one row for each yield condition: its slack and its rate.

        The yield conditions are eq. (4) of the paper.
        """
        import pandas as pd

        slacks = self._scene_problem.slacks(self.q)
        return pd.DataFrame({"name": self._names.conditions, "slack": slacks, "rate": self._rates})

    def __str__(self) -> str:
        from masonry_opt.reporting.sentences import numeral
        from masonry_opt.reporting.terminal import frame_text

        failing = self.table[~self.table["passed"]]
        verdict = "this is an exact collapse state, because no residual exceeds its limit"
        if len(failing):
            faults = ", ".join(f"{row.residual} {row.value:.1e}" for row in failing.itertuples())
            verdict = f"this is NOT an exact collapse state, because residuals are too large: {faults}"
            verdict += self._advice_on_chords()
        shown = self.table.assign(value=[numeral(value, ".1e") for value in self.table["value"]])
        shown = shown.assign(limit=shown["limit"].map("{:.0e}".format))
        table = frame_text(shown, "residuals (0 is exact)")
        return printable(f"λ = {self.load_factor:.6g}: {verdict}\n\n{table}").rstrip("\n")

    def __repr__(self) -> str:
        worst = max(self.answer.residuals.values())
        scene = self.assembly.scene.called
        return (
            f"<StateCheck of {scene!r}: λ = {self.load_factor:.6g}, exact: {self.exact}, worst {worst:.1e}>"
        )

    def _advice_on_chords(self) -> str:
        """Return advice on the argument ``crushing`` if the chords explain the failed check, or "".

        Chords replace the crushing parabola. They explain the failure if the forces are outside the chords,
        and admissible by the parabola.
        """
        problem = self._scene_problem
        outside = problem.slacks(self.q)[problem.bent].min(initial=0.0)
        least_by_parabola = problem.by_parabola.slacks(self.q).min(initial=0.0)
        if outside >= -_LIMITS_OF_USERS_STATES.yield_ or least_by_parabola < -_LIMITS_OF_USERS_STATES.yield_:
            return ""
        return (
            "; the yield conditions are chords inside the crushing parabola: if your program uses the "
            "parabola, pass crushing='parabola'"
        )

    @property
    def _scene_problem(self) -> Problem:
        """Problem of the scene with the friction law and the crushing law that the check uses."""
        return self.assembly.problem.by(self.answer.forms)

    @cached_property
    def _names(self) -> ProblemNames:
        return self.assembly.problem_names()

    @cached_property
    def _rates(self) -> np.ndarray:
        return self.problem.rates(self.answer.d, self.answer.slope)

    @cached_property
    def _departure(self) -> np.ndarray:
        return self.problem.departure(self.answer.d, self._rates, self.answer.slope)

    def _largest_at(self) -> dict[str, str]:
        """For each residual, return the name of the row, joint or block at which the residual is largest."""
        problem, answer, names = self.problem, self.answer, self._names
        unbalanced = problem.unbalanced(answer.load_factor, answer.q)
        acting = largest_acting(problem, answer.load_factor, answer.q)
        slacks = problem.slacks(answer.q)
        energies = problem.energies(answer.q, self._rates / problem.steep)
        work = np.abs(unbalanced * answer.d)
        does_work = np.isfinite(answer.residuals["work"])
        at_work = names.balances[int(work.argmax())]
        return {
            "equilibrium": names.balances[int(np.abs(unbalanced).argmax())],
            "yield": names.conditions[int(slacks.argmin())],
            "flow": names.motions[int(np.abs(self._departure).argmax())],
            "complementarity": (names.joints + names.limited)[int(energies.argmax())][1:-1],
            "work": at_work if does_work else "d: the loads do no positive work",
            "block": names.blocks[int(unbalanced_shares(problem, unbalanced, acting).argmax())][1:-1],
            "joint": names.conditions[int(violation_shares(problem, slacks, acting).argmax())],
        }


@suggests_arguments
def certify(  # noqa: PLR0913 - each option of the public API is an argument
    scene: Scene | Assembly | str | Path,
    load_factor: float,
    q: Any,
    d: Any,
    *,
    associative: bool = False,
    friction: str = "cone",
    crushing: str = "chords",
    load_case: str | None = None,
) -> StateCheck:
    """Compute the residuals of a collapse state that other software has found.

    A state is an exact collapse state if equilibrium, yield conditions, flow rule and complementarity hold,
    each within the limit of exact answers of this package. In addition, unbalanced forces may change λ by at
    most 1e-6 of its value, or by 1e-8 if |λ| is less than 0.01. If the live load exceeds the dead
    load, 0.01 and 1e-8 are multiplied by the dead load over the live load. ``result.load_factor``,
    ``result.q`` and ``result.d`` of a result can be certified too. This package accepts its own exact states
    with a larger effect of unbalanced forces, up to 1e-3 of λ, so ``certify`` may reject such a state.

    Parameters
    ----------
    scene: A scene, the path of a case file, or the assembly of a scene (``mo.assemble``).
    load_factor: The load factor λ.
    q: Joint forces, one for each column of ``mo.assemble(scene).problem.B``, in its unit of force
        ``force_unit``. In the plane these are n₁ of all joints, then n₂, then s, then forces of ties, props
        and earth. The columns are named by ``mo.assemble(scene).problem_names().forces``.
    d: Block velocities, one for each row of B: vx, vy, ω of each movable block, with ω times the unit of
        length, ``length_unit``. Only their ratios matter.
    associative: True for associative flow; by default each joint has its own dilatancy.
    friction: Law of friction in space: "cone", or the "polygon" inside the cone.
    crushing: Law of joints of limited strength: "chords" inside the parabola, or the "parabola".
    load_case: Name of a load case of the scene; needed if the scene has load cases.

    Returns
    -------
    StateCheck
        The residuals of the state and their limits. Its property ``exact`` is True if no residual exceeds its
        limit.

    Raises
    ------
    CaseError
        If the scene is wrong, or no block carries a live load.
    OptionError
        If the load factor is not a finite number, or if forces or velocities have another number of entries
        or an entry that is not finite. If a law or the load case is unknown.
    """
    assembly = scene if isinstance(scene, Assembly) else assemble(as_scene(scene, load_case))
    assembly.scene.refuse_without_case()
    refuse_without_live_load(assembly)
    load_factor = _finite_number(load_factor)
    problem = _with_laws(assembly.problem, friction, crushing)
    names = assembly.problem_names()
    height, width = problem.B.shape
    q = _finite("q", vector("q", q, width, "joint forces, one for each column of problem.B"), names.forces)
    d = _finite("d", vector("d", d, height, "velocities, one for each row of problem.B"), names.velocities)
    driven, forces = _driven(problem, load_factor, q, d)
    slope = problem.friction if associative else problem.dilatancy_at(problem.normal_forces(q))
    answer = certified(driven, load_factor, forces, d, slope)
    return StateCheck(assembly, q, answer, driven)


def _finite_number(load_factor: Any) -> float:
    """Return a load factor as a float. Raises OptionError if the load factor is not a finite number."""
    is_number = isinstance(load_factor, int | float | np.number) and not isinstance(load_factor, bool)
    if not (is_number and np.isfinite(load_factor)):
        raise OptionError(f"load_factor must be a finite number (found {load_factor!r})")
    return float(load_factor)


def _finite(argument: str, values: np.ndarray, names: list[str]) -> np.ndarray:
    """Check that all entries of an array are finite numbers, and return the array.

    Raises OptionError, which names the first entry that is not finite.
    """
    wrong = np.flatnonzero(~np.isfinite(values))
    if len(wrong):
        row = int(wrong[0])
        raise OptionError(
            f"{argument} must contain only finite numbers, but entry no. {row} ({names[row]}) is "
            f"{values[row]}"
        )
    return values


def _with_laws(problem: Problem, friction: str, crushing: str) -> Problem:
    """Return a problem with the laws that the options ``friction`` and ``crushing`` select.

    Raises OptionError if a name is not the name of a law.
    """
    for argument, name, known in (
        ("friction", friction, _FRICTION_LAWS),
        ("crushing", crushing, _CRUSHING_LAWS),
    ):
        if name not in known:
            raise OptionError(f"{argument} must be {' or '.join(map(repr, known))} (found {name!r})")
    by_law = problem.by_cone if friction == "cone" else problem
    return by_law.by_parabola if crushing == "parabola" else by_law


def _driven(problem: Problem, load_factor: float, q: np.ndarray, d: np.ndarray) -> tuple[Problem, np.ndarray]:
    """Exchange dead and live load if only the dead load does positive work; return problem and joint forces.

    The problem and the joint forces are unchanged if the live load does positive work in the mechanism d, if
    the dead load does no positive work, or if λ is not positive. An exchange of the loads does not change the
    total load at λ, but energies are then divided by the work of the dead load. In an exchange, the lowest
    forces of ties, props and earth count as dead load.
    """
    sizes = np.linalg.norm(problem.live) * np.linalg.norm(d)
    if problem.live @ d > NO_WORK * sizes or load_factor <= problem.load_factor_scale.zero:
        return problem, q
    constant = problem.with_lowest_forces_as_load
    exchanged = replace(constant, live=constant.dead / load_factor, dead=load_factor * constant.live)
    if exchanged.live @ d <= 0:
        return problem, q
    return exchanged, q - problem.lowest_forces
