"""The limit analysis problem of a scene: eqs (1) to (6), in dimensionless units."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from operator import attrgetter
from typing import Any, Generic, TypeVar, cast

import numpy as np
import scipy.sparse as sp

from masonry_opt.problem.faces import CHORDS, Faces, Layout, chord_rates
from masonry_opt.problem.laws import Chords, Cone, Forms, Law, Parabola, Sides
from masonry_opt.problem.matrices import Matrices
from masonry_opt.problem.rank import has_independent_columns


@dataclass(frozen=True)
class State:
    """Load factor, forces and motion, in the problem's dimensionless units."""

    load_factor: float  #: λ
    q: np.ndarray  #: joint forces: n₁ of all joints, n₂, s; in space n, s, t; shape (3c,)
    d: np.ndarray  #: block velocities vx, vy, ω in turn, scaled so that f_L·d = Σ|f_L|, shape (3b,)
    p: np.ndarray  #: rates ≥ 0 of the faces, shape (faces,)


#: Arrays that problems of one program have in common.
_GIVEN = ("dead", "live", "settled", "crushing_force", "lowest", "highest")

_T = TypeVar("_T")
_ToArray = Callable[[np.ndarray], np.ndarray]


class Of(property, Generic[_T]):
    """An attribute of a part, such as of a problem's law, by default under the same name."""

    def __init__(self, part: str, name: str = "") -> None:
        super().__init__()
        self._part, self._name = part, name

    def __set_name__(self, _: type, name: str) -> None:
        self._get = attrgetter(f"{self._part}.{self._name or name}")

    def __get__(self, whole: Any, _: type | None = None) -> _T:  # type: ignore[override]
        return cast(_T, self if whole is None else self._get(whole))


@dataclass(frozen=True)
class Problem:
    """Matrices, the law of the joints, and loads: what every method works on.

    Statics, eq. (1): ``B q + λ live + dead = 0`` (the paper turns the sign of B: B q − λ f_L = f_D).
    Yield, eq. (4): ``C(slope) q + face_cohesion ≥ 0``. Kinematics, eqs (2), (5), (6): ``Bᵀ d = D(slope) p``,
    the motion of each joint's first block against its second. Another law, or other loads, on the same
    matrices are ``dataclasses.replace(problem, law=…)``; what matrices and faces have computed is shared.

    Forces are in units of ``force_unit`` (the median dead load of a block), lengths in units of
    ``length_unit`` (half the median joint length, in space half the root of the median area): solvers see
    numbers near one. Shapes (3b,) and (3c,) are those of the plane; in space, where the c joints are contact
    points, (6b,) and (3c,) (see :class:`~.faces.Layout`). What is read often has the same name here.
    """

    matrices: Matrices
    law: Law
    dead: np.ndarray  #: load f_D, shape (3b,)
    live: np.ndarray  #: load f_L, shape (3b,)
    force_unit: float  #: what a dimensionless force is multiplied by
    #: Joint forces (3c + t,) under the dead load, from which load histories start; None where not known.
    settled: np.ndarray | None = None

    B = Of[sp.csr_array]("matrices")
    length_unit = Of[float]("matrices")
    layout = Of[Layout]("matrices")
    blocks = Of[int]("matrices")
    joints = Of[int]("matrices")
    part = Of[np.ndarray]("matrices")
    of_forces = Of[_ToArray]("matrices")
    by_block = Of[_ToArray]("matrices")
    by_kind = Of[_ToArray]("matrices")

    sliding = Of[np.ndarray]("law")
    friction = Of[np.ndarray]("law")
    cohesion = Of[np.ndarray]("law")
    dilatancy = Of[np.ndarray]("law")
    crushing = Of[np.ndarray]("law")
    crushing_force = Of[np.ndarray]("law")
    lowest = Of[np.ndarray]("law")
    highest = Of[np.ndarray]("law")
    forms = Of[Forms]("law")
    dilatancy_depends_on_stress = Of[bool]("law")
    dilatancy_at = Of[_ToArray]("law")

    C = Of[Callable[[np.ndarray], sp.csr_array]]("table")
    N = Of[sp.csr_array]("table")
    limit_factors = Of[sp.csr_array]("table")
    bent = Of[np.ndarray]("table")
    face_joint = Of[np.ndarray]("table")
    faces = Of[int]("table", "count")

    @cached_property
    def table(self) -> Faces:
        """The table of faces, one for all problems of the matrices that limit the same joints and forces."""
        bounded = np.isfinite(self.lowest), np.isfinite(self.highest)
        return self.matrices.faces(self.sliding, self.crushing, bounded)

    def same_program(self, other: "Problem") -> bool:
        """Whether another problem differs in friction, cohesion and dilatancy alone: programs' parameters."""
        given = all(np.array_equal(getattr(self, name), getattr(other, name)) for name in _GIVEN)
        return given and self.table is other.table and self.forms == other.forms

    @property
    def recession_cone(self) -> "Problem":
        """The problem of forces that can be added without end: no cohesion or strength, limits of zero."""
        finite = {name: getattr(self, name) for name in ("cohesion", "crushing_force", "lowest", "highest")}
        none: dict[str, Any] = {name: np.where(np.isfinite(of), 0.0, of) for name, of in finite.items()}
        return replace(self, law=replace(self.law, **none))

    @property
    def lowest_forces(self) -> np.ndarray:
        """Forces (3c + t,) of which limited forces have their lowest value, and all others are zero."""
        forces = np.zeros(self.B.shape[1])
        forces[self.B.shape[1] - len(self.lowest) :] = np.where(np.isfinite(self.lowest), self.lowest, 0.0)
        return forces

    @property
    def with_lowest_forces_as_load(self) -> "Problem":
        """Return a problem whose limited forces count from their lowest values, which join the dead load."""
        constant = self.lowest_forces
        if not constant.any():
            return self
        lowest = constant[self.B.shape[1] - len(self.lowest) :]
        law = replace(self.law, lowest=self.lowest - lowest, highest=self.highest - lowest)
        settled = None if self.settled is None else self.settled - constant
        return replace(self, law=law, dead=self.dead + self.B @ constant, settled=settled)

    @cached_property
    def statics_fix_forces(self) -> bool:
        """True if equilibrium alone is shown to fix all joint forces, as in a stack in the plane."""
        return has_independent_columns(self.B)

    @property
    def live_norm(self) -> float:
        """Σ|f_L|, as the layout sums it, by which objective and velocities (so near 1) are scaled."""
        return self.layout.norm(self.by_block(self.live))

    @property
    def live_displacement(self) -> float:
        """Displacement of the live load, over forces whose sizes no axes change, per work of Σ|f_L|."""
        return self.live_norm / (self.force_sizes(self.live).sum() or self.live_norm)

    def forces(self, load: np.ndarray) -> np.ndarray:
        """Forces, or velocities, of blocks, (b, 2), in a load or motion, (3b,); in space (b, 3) of (6b,)."""
        return self.by_block(load)[:, : self.layout.dimension]

    def force_sizes(self, load: np.ndarray) -> np.ndarray:
        """Size of the force on each block, shape (b,), in a load, shape (3b,)."""
        return np.hypot.reduce(self.forces(load), axis=1)

    def moments(self, load: np.ndarray) -> np.ndarray:
        """Moments about centroids (force × length unit) or rotations (by length unit), (b, 1) or (b, 3)."""
        return self.by_block(load)[:, self.layout.dimension :]

    @cached_property
    def by_friction(self) -> Sides:
        """The law of friction."""
        return self.forms.friction(self.layout, self.law)

    @cached_property
    def by_strength(self) -> Chords:
        """The law of strength."""
        return self.forms.strength(self.layout, self.law)

    def by(self, forms: Forms) -> "Problem":
        """The same problem by these laws; itself if they are its own."""
        return self if forms == self.forms else replace(self, law=replace(self.law, forms=forms))

    @cached_property
    def by_cone(self) -> "Problem":
        """The same with friction by the cone; itself in the plane."""
        return self.by(self.forms._replace(friction=Cone)) if self.layout.round else self

    @cached_property
    def by_parabola(self) -> "Problem":
        """The same with strength by the parabola; itself where none is limited."""
        return self.by(self.forms._replace(strength=Parabola)) if len(self.crushing) else self

    def _by_sense(self, of_faces: np.ndarray) -> np.ndarray:
        """Slacks or rates of sliding, shape (senses, k), in those of all faces, shape (faces,)."""
        return of_faces[self.table.slides].reshape(len(self.layout.senses), -1)

    def _of_sliders(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Normal forces, shape (k,), and shears, shape (shears, k), of the joints that can slide."""
        return self.at_points(q)[:, self.sliding].sum(axis=0), self.shears(q)[:, self.sliding]

    def slip_speed(self, d: np.ndarray) -> np.ndarray:
        """Speed of slip in each joint, shape (c,), under block velocities, shape (3b,)."""
        return np.hypot.reduce(np.abs(self.shears(self.motion(d))), axis=0)

    def motion(self, d: np.ndarray) -> np.ndarray:
        """Return the motion that the flow rule must explain, Bᵀd, shape (3c,)."""
        moved: np.ndarray = self.B.T @ d
        return moved

    @property
    def columns_of_sliding(self) -> np.ndarray:
        """Indices in q of n, s and t of the contact points that can slide, shape (3, k)."""
        return np.asarray(self.by_kind(np.arange(self.B.shape[1]))[:, self.sliding])

    @cached_property
    def true_yield(self) -> sp.csr_array:
        """C(μ), of the true friction law, shape (faces, 3c)."""
        return self.C(self.friction)

    def D(self, slope: np.ndarray) -> sp.csr_array:
        """Flow rule that opens joints by that slope, shape (k,), per unit slip: shape (3c, faces). C = D is
        normality: with the friction as slope the flow is normal to the yield surface. (Dᵀ is C and not −C:
        with the sign of B used here the resultant forces do the work −c·p on the joint velocities.)"""
        return self.C(slope).T.tocsr()

    @cached_property
    def face_constant(self) -> np.ndarray:
        """Constant part of chords of crushing and limits of forces, zero on other faces, shape (faces,)."""
        constant = np.zeros(self.faces)
        constant[self.table.bent] = np.outer(self.crushing_force, CHORDS.constant)
        limits = -self.lowest[self.table.below], self.highest[self.table.above]
        constant[self.table.limits] = np.concatenate(limits)
        return constant

    @cached_property
    def face_cohesion(self) -> np.ndarray:
        """Constant part of each yield condition, shape (faces,)."""
        return self.limit_factors @ self.cohesion + self.face_constant

    @cached_property
    def steep(self) -> np.ndarray:
        """max(1, μ) of faces of sliding, 1 of all others, shape (faces,): what slacks are divided by where
        they are compared. Under large friction those of sliding are so many times any force."""
        return np.maximum(self.limit_factors @ self.friction, 1.0)

    def slacks(self, q: np.ndarray) -> np.ndarray:
        """Slack z of each face under forces q, eq. (4), shape (faces,): negative is a violation. Of cone and
        parabola theirs, in place of those of sides and chords."""
        z: np.ndarray = self.true_yield @ q + self.face_cohesion
        if isinstance(self.by_friction, Cone):
            self._by_sense(z)[:] = self.by_friction.slacks(*self._of_sliders(q))
        if isinstance(self.by_strength, Parabola):
            z[self.bent] = self.by_strength.slacks(self.at_points(q)[:, self.crushing])[..., None]
        return z

    def energy(self, q: np.ndarray, p: np.ndarray) -> float:
        """Σ |z p|: energy of faces that move without being at yield, in rates p, shape (faces,)."""
        z, table = self.true_yield @ q + self.face_cohesion, self.table
        others = np.abs(z * p)
        others[table.slides] = others[table.chords] = 0.0
        sliding = self.by_friction.energy(self._by_sense(z), self._by_sense(p), *self._of_sliders(q))
        at_points = self.at_points(q)[:, self.crushing]
        crushing = self.by_strength.energy(z[self.bent], p[self.bent], at_points) if at_points.size else 0.0
        return sliding + crushing + float(others.sum())

    def rates(self, d: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Return rates p ≥ 0 with which the joints could follow Bᵀd under a flow rule, shape (faces,).

        Arguments are velocities d (3b,) and openings per unit slip (k,).

        Slip gives the sliding rates, of one sense only, in space of the two next to its direction; what
        points open beyond what sliding explains gives the rocking rates, in the plane half of it. Where that
        is negative, ``Bᵀd − D p`` is the violation of the flow rule.
        """
        motion = self.motion(d)
        opening, slides = self.at_points(motion), self.layout.rates(self.shears(motion)[:, self.sliding])
        opening[:, self.sliding] -= slope * self.by_friction.speed(slides)
        crush = np.zeros(0)
        if len(joints := self.crushing):
            # A joint that can crush follows every motion.
            first, second = opening[:, joints]
            crush = chord_rates((first + second) / 2, (second - first) / 2).ravel()
            opening[:, joints] = 0.0
        rock = opening / self.layout.points
        gives = self.of_forces(motion)
        limits = np.append(gives[self.table.below], -gives[self.table.above])
        return np.maximum(np.concatenate([slides.ravel(), rock.ravel(), crush, limits]), 0.0)

    def unbalanced(self, load_factor: float, q: np.ndarray) -> np.ndarray:
        """What joint forces and loads leave of equilibrium, eq. (1), shape (3b,)."""
        return self.B @ q + load_factor * self.live + self.dead

    def departure(self, d: np.ndarray, p: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Return what is left of the flow rule of a slope, Bᵀd − D p, shape (3c,)."""
        flow = self.true_yield if slope is self.friction else self.C(slope)
        left = self.motion(d) - flow.T @ p
        if self.by_friction.conic:
            of_sides = self.limit_factors.T @ p
            left[self.sliding] += slope * (of_sides - self.slip(p))
        return left

    def slip(self, p: np.ndarray) -> np.ndarray:
        """Sliding in all senses, shape (k,), in rates p, shape (faces,): what the shear limit dissipates."""
        return self.by_friction.speed(self._by_sense(p))

    def normal_forces(self, q: np.ndarray) -> np.ndarray:
        """Normal forces of all joints, shape (c,), in forces q, shape (3c,)."""
        return np.asarray(self.at_points(q).sum(axis=0))

    def at_points(self, q: np.ndarray) -> np.ndarray:
        """Normal forces at the points of joints, shape (2, c), in space (1, c), in forces q, shape (3c,)."""
        return self.by_kind(q)[: self.layout.points]

    def shears(self, q: np.ndarray) -> np.ndarray:
        """Shears of all joints, shape (1, c), in space (2, c), in forces q, shape (3c,)."""
        return self.by_kind(q)[self.layout.points :]


@dataclass(frozen=True)
class ShearLimits:
    """|s| ≤ cohesion + slope · n at each joint that can slide (eq. (4), Fig. 4)."""

    slope: np.ndarray  #: shape (k,)
    cohesion: np.ndarray  #: as a force, shape (k,)

    @classmethod
    def true(cls, problem: Problem) -> "ShearLimits":
        """The joints' own friction and cohesion; flow normal to them is associative (C = D)."""
        return cls(problem.friction, problem.cohesion)

    def at(self, n: np.ndarray) -> np.ndarray:
        """The largest |s| under normal forces n of the joints that can slide, shape (k,) each."""
        return self.cohesion + self.slope * n


@dataclass(frozen=True)
class Scaled:
    """A problem in other units of force and of λ; velocities are the same in both."""

    problem: Problem  #: in those units
    force: float  #: what its forces are multiplied by
    load_factor: float  #: what its λ is multiplied by

    def limits(self, limits: ShearLimits) -> ShearLimits:
        """Shear limits of the problem as it was, in these units."""
        return ShearLimits(limits.slope, limits.cohesion / self.force)

    def state(self, state: State) -> State:
        """A state in these units, as one of the problem as it was."""
        return replace(state, load_factor=self.load_factor * state.load_factor, q=self.force * state.q)


def in_units_of_live_load(problem: Problem) -> Scaled:
    """The problem with a live load whose largest entry is near that of the dead load, smaller by a power of
    two: no digit of any number changes, and solvers see λ as of a live load about as large as the weights."""
    live, dead = (float(np.abs(load).max()) or 1.0 for load in (problem.live, problem.dead))
    unit = 2.0 ** np.round(np.log2(live / dead))
    return Scaled(replace(problem, live=problem.live / unit), 1.0, 1.0 / float(unit))


def in_units_of_load(problem: Problem) -> Scaled:
    """The problem with a live load whose entries sum to one, forces in units of the dead load of what carries
    it.

    The largest forces of a large scene are a thousand block weights, from which solvers take tolerances: in
    these units they end a hundred times nearer the optimum (façades of 6000 blocks: 4e-8 instead of 4e-6), in
    a third more iterations, and rough solutions are as rough at every size (else 4 to 17 % off on façades).
    """
    dead = np.abs(problem.by_block(problem.dead)).sum(axis=1)
    loaded = problem.by_block(problem.live).any(axis=1)
    weights = (float(dead[loaded].sum()), float(dead.sum()), problem.live_norm)
    force = next(weight for weight in weights if weight)
    forces = ("cohesion", "dilatancy_force", "crushing_force", "lowest", "highest")
    law = replace(problem.law, **{name: getattr(problem.law, name) / force for name in forces})
    dead, live = problem.dead / force, problem.live / problem.live_norm
    scaled = replace(problem, law=law, dead=dead, live=live, force_unit=problem.force_unit * force)
    return Scaled(scaled, force, force / problem.live_norm)
