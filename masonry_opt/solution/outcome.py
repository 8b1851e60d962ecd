"""The outcome of an analysis: a solution with the names and units of its scene, as numbers and codes."""

import math
from dataclasses import astuple, dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from masonry_opt.brief import brief
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.problem.problem import Problem
from masonry_opt.solution import frames
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import Certificate, InfeasibilityCertificate
from masonry_opt.solution.proof import Proof
from masonry_opt.solution.reasons import Code, Reason, Status, size_of
from masonry_opt.solution.sense import warnings_of
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.stability import Stability
from masonry_opt.solvers.registry import MATRICES

if TYPE_CHECKING:
    import pandas as pd


#: Present name of each former attribute of a result.
FORMER_NAMES = {
    "expected": "incremental",
    "at_expected": "at_incremental",
    "expected_reasons": "incremental_reasons",
}


@dataclass(frozen=True)
class Size:
    """Numbers of blocks and joints of a scene, and of rows and columns of its linear program."""

    blocks: int  #: number b of movable blocks
    joints: int  #: number of joints (c in the plane)
    #: Number of rows of the linear program, as passed to the solver; None if there is no linear program.
    rows: int | None
    #: Number of columns of the linear program; None if there is no linear program.
    columns: int | None
    #: Number of nonzero coefficients of the linear program; None if there is no linear program.
    nonzeros: int | None
    left_out: tuple[str, ...] = ()  #: parts of the scene that the model leaves out, each with the reason
    contacts: int | None = None  #: number c of contact points of a scene in space; None in the plane

    __repr__ = brief


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Outcome:
    """Result of an analysis: load factor, joint forces, mechanism and residuals.

    Tables are computed when they are first read. :class:`~masonry_opt.Result` adds messages, plots and files.

    Attributes
    ----------
    case: case file or title of the scene.
    load_case: name of the load case; None if the scene has no load cases.
    method: name of the requested method.
    model: modelling language of the program, such as "cvxpy"; "matrices" if none was used, as in an
        incremental analysis.
    solver: name of the requested solver, or of the method's own solver. If another language declared the
        program, its solver is named.
    status: status in which the analysis ended.
    reasons: reasons for the status, as codes with their values.
    usable: True if there is a load factor, or if a scene without live load is stable.
    time_limit_reached: True if the time limit ended the analysis. The attribute ``load_factor`` is then the
        lowest load factor found within the time limit, or None.
    stability: safety margins of a stable scene without live load, see
        :class:`~.solution.stability.Stability`. None in all other cases (a live load acts, the scene is
        unstable, or its stability is undecided).
    kind: kind of the answer, such as "associative" or "exact", which determines the limits of its residuals.
    load_factor: load factor λ; None unless ``status.usable``.
    certificate: residuals of equilibrium, yield, flow and complementarity, computed from the matrices alone;
        None if there is no load factor.
    infeasibility: statement about the existence of a load factor, with residuals computed from the matrices
        alone. None if there is a load factor, if the scene is unstable under dead load, and for more than
        2000 joints (in space, contact points).
    flow_rule_matters: False if the associative answer, with which the loop starts, already satisfies the
        joints' own flow rule.
    iterations: sum of the iterations of the solvers.
    lp_solves: number of linear or cone programs solved, without those for the dead load alone.
    nlp_solves: number of nonlinear programs solved.
    stationary: True if the search (option ``search``) found no mechanism that lowers λ, False if the solver
        could not decide for some mechanisms; None if the method did not search.
    lowest: lowest load factor of the exact Coulomb collapse states that the method and the incremental
        analysis found; None if they found no exact state.
    incremental: incremental load factor, by method "incremental": the largest load factor of the load
        history in which the live load is increased from zero, with elastic contacts. None if the history
        has no collapse, if it is switched off, and for methods with associative flow.
    end: load factor at the end of the load history, when the blocks move without end; None if the history was
        not followed to its end.
    incremental_reasons: reasons why the load history ended, or why there is no incremental load factor.
    at_incremental: result of the incremental analysis, with the times and solvers of the whole analysis. None
        if the incremental load factor is switched off, for methods with associative flow, and if the scene is
        unstable under its dead load.
    associative: load factor with associative flow, an upper bound on all Coulomb load factors; None if
        unlimited.
    q, d: joint forces and block velocities as arrays, in the units of the problem's matrices
        (``assembly.problem``); see :func:`~masonry_opt.certify`. None if they are not known.
    exact: True if all residuals are within the limits of exact answers. The flow rule is the joints' own, and
        friction in space is the cone.
    bound: lower bound on λ: no exact Coulomb state has a load factor from 0 to this bound. ``proof`` or
        method "global" proves the bound. A bound from method "global" may assume limits on rates and forces,
        which ``reasons`` state. None if no bound is known.
    proof: proof that no state has a lower load factor, see :func:`~masonry_opt.check_proof`. It covers forces
        up to a million times the loads, and motions up to a million times the mean velocity of the live load.
        None if there is no proof.
    seconds: seconds by part of the analysis, such as "dead load".
    solvers: names of the solvers by purpose: "dead load", "load factor", "sub-problems", ...
    largest_turn: largest angle (radians) by which a joint was turned to align contacts within the accuracy of
        the drawing; 0 if all joints are as drawn.
    largest_shift: largest distance by which a contact point was moved to align contacts; 0 if none was moved.
    size: sizes of the scene and the linear program.
    assembly: the matrices of the scene.
    solution: forces and velocities in the units of the matrices.
    warnings: properties of the scene that look unintended, as codes with values. They do not affect the
        analysis.
    """

    method: str
    model: str
    solver: str
    iterations: int
    lp_solves: int
    nlp_solves: int
    seconds: dict[str, float]
    solvers: dict[str, list[str]]
    assembly: Assembly
    solution: Solution

    @property
    def status(self) -> Status:
        """Status in which the analysis ended."""
        return self.solution.status

    @property
    def reasons(self) -> tuple[Reason, ...]:
        """Reasons for the status, as codes with their values."""
        return self.solution.reasons

    @property
    def usable(self) -> bool:
        """True if there is a load factor, or if a scene without live load is stable."""
        return self.status.usable or self.stability is not None

    @property
    def stability(self) -> Stability | None:
        """Safety margins of a scene that has no live load and is stable; None for all other scenes."""
        return self.solution.stability

    @property
    def time_limit_reached(self) -> bool:
        """True if the time limit ended the analysis.

        The attribute ``load_factor`` is then the lowest load factor found within the time limit, or None.
        """
        return self.solution.has(Code.TIME_LIMIT)

    @property
    def kind(self) -> Kind:
        """Kind of the answer, such as "exact", which determines the limits of its residuals."""
        return self.solution.kind

    @property
    def load_factor(self) -> float | None:
        """Load factor λ; None unless the status is "optimal" or "converged"."""
        return self.solution.load_factor

    @property
    def q(self) -> np.ndarray | None:
        """Joint forces in the problem's units, one for each column of the matrix B; None if unknown.

        :func:`~masonry_opt.certify` explains their order.
        """
        return self.solution.q

    @property
    def d(self) -> np.ndarray | None:
        """Block velocities in the problem's units, one for each row of the matrix B; None if unknown."""
        return self.solution.d

    @property
    def flow_rule_matters(self) -> bool:
        """False if the associative answer already satisfies the joints' own flow rule."""
        return self.solution.flow_rule_matters

    @property
    def stationary(self) -> bool | None:
        """True if the search (option ``search``) tried other mechanisms, and none of them lowers λ.

        False if the solver could not decide for some mechanisms; None if the method did not search.
        """
        return self.solution.stationary

    @property
    def bound(self) -> float | None:
        """Lower bound on λ: no exact Coulomb state has a load factor from 0 to this bound.

        None if no bound is known.
        """
        return self.solution.bound

    @property
    def proof(self) -> Proof | None:
        """Proof that no collapse state has a lower load factor; None if there is no proof."""
        return self.solution.proof

    @property
    def end(self) -> float | None:
        """Load factor at the end of the load history; None if the history was not followed to its end."""
        return self.solution.end

    @property
    def incremental(self) -> float | None:
        """Incremental load factor: the largest load factor of the load history; None if unknown."""
        return self.solution.incremental_value

    @property
    def associative(self) -> float | None:
        """Load factor with associative flow; None if it is unlimited or unknown."""
        return self.solution.associative_value

    @property
    def case(self) -> str:
        """Name of the scene in tables and messages."""
        return self.assembly.scene.called

    def __repr__(self) -> str:
        attributes = f"{self.case!r}, {self.method!r}, {str(self.status)!r}, load_factor={self.load_factor}"
        return f"{type(self).__name__}({attributes})"

    def __getattr__(self, name: str) -> Any:
        """Raise AttributeError. The message for a former name states the present name."""
        if name in FORMER_NAMES:
            raise AttributeError(f"'{name}' is now called '{FORMER_NAMES[name]}'")
        raise AttributeError(f"'{type(self).__name__}' object has no attribute '{name}'")

    @cached_property
    def joints(self) -> "pd.DataFrame":
        """Table with one row for each joint; forces and lengths are in the case's units.

        Columns in the plane:

        - ``first``, ``second``: names of the two blocks.
        - ``x``, ``y``: middle of the joint; ``length``: its length.
        - ``n`` (compression > 0), ``s``, ``m``: normal force, shear and moment on the first block.
        - ``slip``, ``opening``, ``rotation``: rates of the first block relative to the second.
        - ``utilisation``: force over limit; NaN if the joint carries no force.

        Columns in space, where a vector has three columns, such as ``x``, ``y``, ``z``, in the scene's
        coordinates:

        - ``first``, ``second``: names of the two blocks.
        - ``x``: centroid of the joint; ``area``: its area, 0 for an edge or a point.
        - ``nx``: unit normal, which points into the first block.
        - ``n`` (along the normal, compression > 0), ``s`` (size of the shear), ``fx``: resultant on the first
          block.
        - ``px``: point of action of n; NaN if the joint is not pressed.
        - ``torsion``: moment about the normal at this point; at the centroid if the joint is not pressed.
        - ``slip`` (size), ``opening``, ``vx`` (both): rates of the first block relative to the second, at the
          centroid.
        - ``rotation`` (size), ``wx``: relative rotation about its direction, right-handed.
        - ``ax``: point of the rotation axis nearest to the centroid; NaN if the joint does not turn.
        - ``utilisation``: the largest utilisation of its ``contacts``.
        """
        return frames.joint_frame(self.assembly, self.solution)

    @cached_property
    def contacts(self) -> "pd.DataFrame | None":
        """Table with one row for each contact point in space, ordered by joint; None in the plane.

        - ``joint``: number of the joint's row in ``joints``; ``first``, ``second``: names of its blocks.
        - ``x``, ``y``, ``z``: the point.
        - ``n`` (compression > 0), ``s`` (size of the shear), ``fx``, ``fy``, ``fz``: force on the first
          block.
        - ``slip`` (size), ``opening``, ``vx``, ``vy``, ``vz`` (both): rates of the first block relative to
          the second.
        - ``utilisation``: |shear| over c + μ n; 0 if friction is unlimited, NaN if the point carries no
          force.

        If a joint has more than three points, its resultant does not determine their forces uniquely.
        """
        return frames.contact_frame(self.assembly, self.solution)

    @cached_property
    def blocks(self) -> "pd.DataFrame":
        """Table with one row for each movable block, its centroid and its velocities.

        Columns in the plane are ``block``, ``x``, ``y``, ``vx``, ``vy``, ``omega``. Columns in space are
        ``block``, ``x``, ``y``, ``z``, ``vx``, ``vy``, ``vz``, and the right-handed rotation about the axes,
        ``wx``, ``wy``, ``wz``.

        Velocities are scaled so that the live load does the work Σ|f_L|. If the reasons contain the code "no
        work", the dead load does this work, together with the lowest forces of ties, props and earth. In the
        plane Σ|f_L| is a sum of components. In space it is a sum of the magnitudes of forces and moments
        about centroids. The unit of length of the moments is half the square root of the median joint area.
        """
        return frames.block_frame(self.assembly, self.solution)

    @cached_property
    def ties(self) -> "pd.DataFrame":
        """Table with one row for each tie or prop.

        - ``name``, ``kind``: name, and "tie" or "prop".
        - ``first``, ``second``: names of the connected blocks; "ground" does not move.
        - ``force``: tension, for a prop compression, in the case's unit, from ``lowest`` to ``highest``.
        - ``lengthens``: rate of lengthening.
        - ``yields``: True if the force is at its upper limit and the tie or prop yields in the mechanism.
        """
        return frames.tie_frame(self.assembly, self.solution, Role.TIE, Role.PROP)

    @cached_property
    def pressures(self) -> "pd.DataFrame":
        """Table with one row for each block face under pressure of a fill; columns are as in ``ties``.

        ``first`` is the block of the face. ``force`` is horizontal and directed into the face. It is at least
        ``lowest``, the active pressure, and at most ``highest``, the mobilised share of the passive pressure.
        The pressure ``yields`` if it reaches ``highest``.
        """
        return frames.tie_frame(self.assembly, self.solution, Role.EARTH)

    @cached_property
    def history(self) -> "pd.DataFrame":
        """Table with one row for each step of the method; empty for a single linear program.

        Depending on the method, a step is one of the following:

        - a sub-problem of the loop (:class:`~.loop.run.Iteration`);
        - a load step (:class:`~.load_history.LoadStep`);
        - a relaxation of the MPEC (:class:`~.mpec.RelaxationStep`);
        - a lower state of the search (:class:`~.coulomb.search.LowerState`).
        """
        return frames.history_frame(self.assembly, self.solution)

    @cached_property
    def curve(self) -> "pd.DataFrame | None":
        """Load–displacement curve of the load history; None if the option ``curve`` was not set.

        The load never decreases, so the curve has jumps instead of falling branches. Each row is an
        equilibrium:

        - ``load_factor``: load factor λ.
        - ``displacement``: displacement of the live load (its work divided by its forces) from equilibrium
          under the dead load. The unit is the closing of a joint of mean length under the mean contact force
          of the dead load.
        - ``jump``: True if the blocks came to rest after a damped motion.
        - ``sliding``, ``opening``: number of joints that slide under pressure, and number of joints that are
          open, at one edge at least.
        - ``starts_sliding``, ``starts_opening``: names of the two blocks of each joint that slides, or opens,
          for the first time. The first row is the state under the dead load alone.
        """
        history = self.solution.load_history
        if not self.solution.tells_curve or history is None:
            return None
        return frames.curve_frame(self.assembly, history)

    @property
    def largest_turn(self) -> float:
        """Largest angle, in radians, by which a joint was turned to align contacts."""
        return float(self.assembly.joints.turn.max(initial=0.0))

    @property
    def largest_shift(self) -> float:
        """Largest distance by which a contact point was moved to align contacts."""
        return float(self.assembly.joints.shift.max(initial=0.0))

    @property
    def load_case(self) -> str | None:
        """Name of the load case; None if the scene has no load cases."""
        case = self.assembly.scene.load_case
        return None if case is None else case.name

    @property
    def certificate(self) -> Certificate | None:
        """Residuals of equilibrium, yield, flow and complementarity; None if there is no load factor."""
        return self.solution.answer.certificate if self.solution.answer else None

    @property
    def infeasibility(self) -> InfeasibilityCertificate | None:
        """Result of the attempt to prove that no load factor exists, with its residuals.

        None if a load factor is known, or if no proof was attempted.

        The indices ``clamped`` refer to rows of ``joints``.
        """
        certificate = self.solution.infeasibility
        if self.load_factor is not None or certificate is None:
            return None
        clamped = self.assembly.joints_of(np.array(certificate.clamped, dtype=int))
        return replace(certificate, clamped=tuple(clamped.tolist()))

    @property
    def incremental_reasons(self) -> tuple[Reason, ...]:
        """Reasons why the load history ended, or why the incremental load factor does not exist."""
        return self.at_incremental.reasons if self.at_incremental else ()

    @cached_property
    def at_incremental(self) -> Self | None:
        """Result of the incremental analysis; None if no incremental load factor was requested.

        It is also None if the scene is unstable under its dead load.
        """
        if self.kind is Kind.INCREMENTAL:
            return self
        solution = self.solution.incremental
        if solution is None:
            return None
        return replace(
            self,
            method="incremental",
            model=MATRICES,
            solver="newton",
            solution=solution,
            iterations=len(solution.history),
            lp_solves=0,
            nlp_solves=0,
        )

    @property
    def lowest(self) -> float | None:
        """Lowest load factor of all exact Coulomb collapse states found; None if no exact state was found.

        The states are the answer and the state at the end of the load history. The latter counts only if its
        load factor is positive, and lower than that of the answer by more than rounding errors.
        """
        own = self.load_factor if self.exact else None
        history = self.at_incremental
        at_end = None if history is None or not history.exact else history.load_factor
        scale = self.assembly.problem.load_factor_scale
        if at_end is None or at_end <= scale.zero:
            return own
        return at_end if own is None or scale.is_lower(at_end, own) else own

    @cached_property
    def exact(self) -> bool:
        """True if the answer is an exact Coulomb state for the joints' own dilatancy."""
        return self.solution.is_exact(self.assembly.problem)

    @property
    def size(self) -> Size:
        """Numbers of blocks and joints of the scene, and of rows and columns of its linear program."""
        problem, lp = self.assembly.problem, self.solution.size
        rows, columns, nonzeros = (None, None, None) if lp is None else astuple(lp)
        points, joints = size_of(problem).get("contacts"), len(self.assembly.joints.first)
        return Size(problem.blocks, joints, rows, columns, nonzeros, contacts=points)

    @cached_property
    def warnings(self) -> tuple[Reason, ...]:
        """Warnings about the scene, as codes with values."""
        return warnings_of(self.assembly, self.solution)

    @property
    def range(self) -> tuple[float | None, float | None]:
        """Lower and upper bound on the least λ with the joints' own flow rule.

        The lower bound is proven by ``proof``, or by method "global" without assumed limits on rates and
        forces. It is None if there is no such bound. The upper bound is ``lowest``. If no exact state was
        found, the upper bound is the associative load factor, or None if that load factor is unknown.
        """
        proven = self.bound if self.solution.bound_derived else None
        return proven, self.associative if self.lowest is None else self.lowest

    @property
    def crushing(self) -> str:
        """Strength law of the answer: "parabola" or its approximation "chords"; "" if strength is unlimited.

        The chords are inside the parabola, and permit moments that are up to 0.65 % smaller.
        """
        return self._law.by_strength.word if len(self.assembly.problem.crushing) else ""

    @property
    def friction_law(self) -> str:
        """Friction law with which a scene in space was solved: "cone" or "polygon of P sides".

        The polygon is inside the cone. The friction of the polygon is at least cos(π/P) times that of the
        cone. The value is "" in the plane, if friction is unlimited, and if there are neither forces nor
        velocities.
        """
        state = self.solution.state
        is_empty = state.q is None and state.d is None
        return "" if is_empty or not len(self._law.sliding) else self._law.by_friction.word

    @property
    def _law(self) -> Problem:
        """Matrices of the scene, with the friction and strength laws with which the scene was solved."""
        return self.assembly.problem.by(self.solution.state.forms)

    @property
    def tilt_angle(self) -> float | None:
        """Tilt of the ground at collapse, atan λ in degrees; None if the scene is not tilted."""
        if self.assembly.scene.tilt is None or self.load_factor is None:
            return None
        return math.degrees(math.atan(self.load_factor))
