"""The outcome of an analysis: a solution with the names and units of its scene, as numbers and codes."""

import math
from dataclasses import astuple, dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from masonry_opt.answer import frames
from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.answer import Certificate, InfeasibilityCertificate
from masonry_opt.answer.reasons import Reason, Status, size_of
from masonry_opt.answer.sense import warnings_of
from masonry_opt.answer.solution import Solution
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.problem.problem import Of, Problem
from masonry_opt.solvers.registry import MATRICES

if TYPE_CHECKING:
    import pandas as pd


#: Present names of attributes of a result, by the names that they had in former versions.
_FORMER_NAMES = {
    "expected": "incremental",
    "at_expected": "at_incremental",
    "expected_reasons": "incremental_reasons",
}


@dataclass(frozen=True)
class Size:
    """Sizes of the scene and of the linear program."""

    blocks: int  #: movable ones, b
    joints: int  #: in the plane c
    rows: int | None  #: of the linear program as the solver received it; None if none was built
    columns: int | None
    nonzeros: int | None
    left_out: tuple[str, ...] = ()  #: what was not modelled, each with its reason, where that is told
    contacts: int | None = None  #: contact points of a scene in space, c; None in the plane


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Outcome:
    """The answer to "at what load does this masonry collapse?", with its residuals; tables are made when they
    are asked for. :class:`~masonry_opt.Result` puts it into words, pictures and files.

    Attributes
    ----------
    case: case file or title of the scene.
    load_case: name of the load case that it is of; None of a scene without.
    method: the one asked for.
    model: the language that declared what was solved; "matrices" where none did, as of a push.
    solver: the one asked for, or the method's own; of another language where that declared what was solved.
    status, reasons: how it ended, and why, in codes with their values.
    usable: whether there is a load factor.
    kind: of answer, which decides what its certificate must show.
    load_factor: λ; None unless ``status.usable``.
    certificate: residuals of λ, forces and mechanism, from the matrices alone; None without λ.
    infeasibility: without λ what is proven of its existence, with residuals from the matrices alone; None
        with λ, of scenes that fall, and above 2000 joints (in space points).
    flow_rule_matters: False if the loop's associative start already obeys the joints' own flow rule.
    iterations: of the solver, summed.
    lp_solves, nlp_solves: linear or cone programs solved, and nonlinear ones (without the dead load's check).
    stationary: after a search (option ``search``): True if no mechanism that was tried at yield lowers λ,
        False if the solver could not tell for some; None without a search.
    lowest: load factor of the exact Coulomb collapse state, the lowest that the method found; None if its
        state is not exact.
    incremental: incremental load factor, by method "incremental": the largest load factor of the load
        history in which the live load is raised from rest, with elastic contacts. None if there is none, if
        it was not asked for, and for methods with associative flow.
    end: load factor at the end of the load history: the load that the scene carries once it moves on; None if
        the history was not followed to its end.
    incremental_reasons: codes that tell how the load history ended, or why there is no incremental load
        factor.
    at_incremental: the result of the incremental collapse; seconds and solvers are of the whole analysis.
        None if it was not asked for.
    associative: load factor with associative flow, which no Coulomb answer exceeds; None where unlimited.
    exact: whether all residuals under the joints' own flow rule, in space by the cone, are within the limits
        of exact answers.
    bound: of method "global", a lower bound of λ below the rates and forces that ``reasons`` say it assumes;
        None for other methods.
    seconds: by part (see :class:`~masonry_opt.effort.Effort`).
    solvers: names of the solvers by what they did: "dead load", "load factor", "sub-problems", ...
    largest_turn, largest_shift: the largest angle (radians) by which a joint was turned, and the largest
        distance by which a contact point was moved, to align contacts within the accuracy of the drawing; 0
        where all are as drawn.
    size: of scene and linear program.
    assembly, solution: the matrices, and forces and velocities in their units.
    warnings: what looks unintended in the scene, in codes with their values. They change nothing else.
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

    status = Of[Status]("solution")
    reasons = Of[tuple[Reason, ...]]("solution")
    usable = Of[bool]("solution.status")
    kind = Of[Kind]("solution")
    load_factor = Of[float | None]("solution")
    flow_rule_matters = Of[bool]("solution")
    stationary = Of[bool | None]("solution")
    bound = Of[float | None]("solution")
    end = Of[float | None]("solution")
    incremental = Of[float | None]("solution", "incremental_value")
    associative = Of[float | None]("solution", "associative_value")
    case = Of[str]("assembly.scene", "called")

    def __repr__(self) -> str:
        told = f"{self.case!r}, {self.method!r}, {str(self.status)!r}, load_factor={self.load_factor}"
        return f"{type(self).__name__}({told})"

    def __getattr__(self, name: str) -> Any:
        """Raise AttributeError. The error names the present name of an attribute that had a former one."""
        if name in _FORMER_NAMES:
            raise AttributeError(f"'{name}' is now called '{_FORMER_NAMES[name]}'")
        raise AttributeError(f"'{type(self).__name__}' object has no attribute '{name}'")

    @cached_property
    def joints(self) -> "pd.DataFrame":
        """A row a joint: ``first``, ``second``, ``x``, ``y`` (middle), ``length``, forces on the first block
        ``n`` (compression > 0), ``s``, ``m``, rates of the first block against the second ``slip``,
        ``opening``, ``rotation``, ``utilisation`` (force over limit, NaN where idle).
        Forces and lengths in the case's units.

        In space, where vectors have three columns in the scene's coordinates: ``first``, ``second``, ``x``
        (centroid), ``area`` (0 of an edge or a point), ``nx`` (unit normal into the first block), resultant
        on the first block as ``n`` (along the normal, compression > 0), ``s`` (size of the shear) and ``fx``,
        ``px`` (where n acts, NaN where the joint is not pressed), ``torsion`` (moment about the normal there,
        else at the centroid), rates of the first block against the second at the centroid ``slip`` (size),
        ``opening`` and ``vx`` (both), ``rotation`` (size) and ``wx`` (about its direction, right-handed),
        ``ax`` (point of that axis nearest to the centroid, NaN where the joint does not turn), and
        ``utilisation``, the largest of its ``contacts``."""
        return frames.joint_frame(self.assembly, self.solution)

    @cached_property
    def contacts(self) -> "pd.DataFrame | None":
        """A row a contact point of a scene in space, by joint; None in the plane.

        ``joint`` (number of its row in ``joints``), ``first``, ``second``, ``x``, ``y``, ``z``, force on the
        first block as ``n`` (compression > 0), ``s`` (size of the shear) and ``fx``, ``fy``, ``fz``, rates of
        the first block against the second ``slip`` (size), ``opening`` and ``vx``, ``vy``, ``vz`` (both), and
        ``utilisation`` (|shear| over c + μ n, 0 where friction is unlimited, NaN where the point is idle).
        Within a joint of more than three points forces are one of many ways to share its resultant."""
        return frames.contact_frame(self.assembly, self.solution)

    @cached_property
    def blocks(self) -> "pd.DataFrame":
        """Return a row for each movable block: ``block``, ``x``, ``y`` (centroid), ``vx``, ``vy``, ``omega``.

        Velocities are scaled so that the live load does the work Σ|f_L|. With the code "no work" the dead
        load does it, together with the lowest forces of ties, props and earth. In the plane Σ|f_L| sums
        components, in space the sizes of forces and of moments about centroids (forces times half the root
        of the median joint's area). In space the columns are ``block``, ``x``, ``y``, ``z``, ``vx``, ``vy``,
        ``vz``, and the rotation about the axes, right-handed, ``wx``, ``wy``, ``wz``.
        """
        return frames.block_frame(self.assembly, self.solution)

    @cached_property
    def ties(self) -> "pd.DataFrame":
        """A row a tie or prop: ``name``, ``kind``, blocks ``first`` and ``second`` ("ground" does not move),
        ``force`` (tension, of a prop compression, in the case's unit) from ``lowest`` to ``highest``, rate at
        which it ``lengthens``, and whether it ``yields``: at its highest force, further in the mechanism."""
        return frames.tie_frame(self.assembly, self.solution, Role.TIE, Role.PROP)

    @cached_property
    def pressures(self) -> "pd.DataFrame":
        """A row a face that a fill presses on, as in ``ties``: ``first`` is its block; ``force``, horizontal
        and into the face, lies between ``lowest``, the active pressure, and ``highest``, the mobilised share
        of the passive one, which is reached where it ``yields``."""
        return frames.tie_frame(self.assembly, self.solution, Role.EARTH)

    @cached_property
    def history(self) -> "pd.DataFrame":
        """Return a row for each step of the method; empty for a single linear program.

        A step is a sub-problem of the loop (:class:`~.loop.run.Iteration`), a load step
        (:class:`~.load_history.LoadStep`), a relaxation of the MPEC (:class:`~.mpec.RelaxationStep`), or a
        lower state of the search (:class:`~.coulomb.search.LowerState`).
        """
        return frames.history_frame(self.assembly, self.solution)

    @cached_property
    def curve(self) -> "pd.DataFrame | None":
        """Load–displacement curve of the load history, if method "incremental" was asked for it; else None.

        The load is raised from rest, so that the curve has jumps and no falling branches. A row is an
        equilibrium: ``load_factor``, ``displacement`` of the live load since the dead load (its work over its
        forces, in the closing of a joint of mean length under the mean contact force of the dead load),
        whether a ``jump`` led there, numbers of joints that are ``sliding`` under pressure or ``opening``
        (about an edge, or wholly), and the names of the two blocks of each joint that ``starts_sliding`` or
        ``starts_opening``: in none of the rows before. In the first row these joints slide or are open under
        the dead load alone.
        """
        history = self.solution.load_history
        if not self.solution.tells_curve or history is None:
            return None
        return frames.curve_frame(self.assembly, history)

    @property
    def largest_turn(self) -> float:
        return float(self.assembly.joints.turn.max(initial=0.0))

    @property
    def largest_shift(self) -> float:
        return float(self.assembly.joints.shift.max(initial=0.0))

    @property
    def load_case(self) -> str | None:
        case = self.assembly.scene.load_case
        return None if case is None else case.name

    @property
    def certificate(self) -> Certificate | None:
        return self.solution.answer.certificate if self.solution.answer else None

    @property
    def infeasibility(self) -> InfeasibilityCertificate | None:
        if self.load_factor is not None or (found := self.solution.infeasibility) is None:
            return None
        clamped = self.assembly.joints_of(np.array(found.clamped, dtype=int))
        return replace(found, clamped=tuple(clamped.tolist()))

    @property
    def incremental_reasons(self) -> tuple[Reason, ...]:
        return self.at_incremental.reasons if self.at_incremental else ()

    @cached_property
    def at_incremental(self) -> Self | None:
        if self.kind is Kind.INCREMENTAL:
            return self
        if (found := self.solution.incremental) is None:
            return None
        of = replace(self, method="incremental", model=MATRICES, solver="newton", solution=found)
        return replace(of, iterations=len(found.history), lp_solves=0, nlp_solves=0)

    @property
    def lowest(self) -> float | None:
        return self.load_factor if self.exact else None

    @cached_property
    def exact(self) -> bool:
        return self.solution.is_exact(self.assembly.problem)

    @property
    def size(self) -> Size:
        problem, lp = self.assembly.problem, self.solution.size
        rows, columns, nonzeros = (None, None, None) if lp is None else astuple(lp)
        points, joints = size_of(problem).get("contacts"), len(self.assembly.joints.first)
        return Size(problem.blocks, joints, rows, columns, nonzeros, contacts=points)

    @cached_property
    def warnings(self) -> tuple[Reason, ...]:
        return warnings_of(self.assembly, self.solution)

    @property
    def range(self) -> tuple[float | None, float | None]:
        """Least and greatest that the least load factor under the joints' own flow rule can be, if there is
        one: what is proven without assumption, and λ itself if it is exact, else the associative one."""
        proven = self.bound if self.solution.bound_derived else None
        return proven, self.load_factor if self.exact else self.associative

    @property
    def crushing(self) -> str:
        """How joints of limited strength crush: by the "parabola", or "chords" inside it (moments up to
        0.65 % less); "" if none is."""
        return self._law.by_strength.word if len(self.assembly.problem.crushing) else ""

    @property
    def friction_law(self) -> str:
        """How friction is limited in space: by the "cone", or by a "polygon of P sides" inside it, which have
        cos(π/P) of its friction at least; "" in the plane, where friction is unlimited, and of no state."""
        found = self.solution.found
        nothing = found.q is None and found.d is None
        return "" if nothing or not len(self._law.sliding) else self._law.by_friction.word

    @property
    def _law(self) -> Problem:
        """The problem by the laws of what was found."""
        return self.assembly.problem.by(self.solution.found.forms)

    @property
    def tilt_angle(self) -> float | None:
        """Tilt of the ground at which the scene falls, atan λ in degrees; None of other scenes."""
        if self.assembly.scene.tilt is None or self.load_factor is None:
            return None
        return math.degrees(math.atan(self.load_factor))
