"""Define the limit analysis problem of a scene: eqs (1) to (6) of the paper, in dimensionless units."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from masonry_opt.brief import brief
from masonry_opt.errors import counted
from masonry_opt.problem.arguments import per_joint, vector
from masonry_opt.problem.faces import CHORDS, chord_rates
from masonry_opt.problem.laws import Chords, Cone, Forms, Law, Parabola, Sides
from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.problem.matrices import Matrices
from masonry_opt.problem.parts import ProblemParts
from masonry_opt.problem.rank import has_independent_columns


@dataclass(frozen=True)
class State:
    """Load factor, joint forces and mechanism, in the problem's dimensionless units."""

    load_factor: float  #: load factor λ
    #: Forces, shape (3c + t,): all n₁, all n₂, all s (in space all n, s and t), then the limited forces.
    q: np.ndarray
    d: np.ndarray  #: velocities vx, vy, ω of each block, shape (3b,), scaled so that f_L·d = Σ|f_L|
    p: np.ndarray  #: rates p ≥ 0 of the yield conditions, shape (faces,)

    __repr__ = brief


#: Attributes of a problem that are constants of its compiled program. Problems in which one of these
#: attributes differs need different programs.
_PROGRAM_CONSTANTS = ("dead", "live", "settled", "crushing_force", "lowest", "highest")


@dataclass(frozen=True)
class Problem(ProblemParts):
    """Matrices, joint law and loads of a scene, which are the input of every method.

    - Statics, eq. (1): ``B q + λ live + dead = 0``. The paper has the opposite sign of B: B q − λ f_L = f_D.
    - Yield, eq. (4): ``z = C(slope) q + face_cohesion ≥ 0``. Each row is a yield condition, called a *face*.
    - Kinematics, eqs (2), (5), (6): ``Bᵀ d = D(slope) p``, the motion of each joint's first block relative to
      its second.

    For another joint law or other loads on the same matrices, use ``dataclasses.replace(problem, law=…)``.
    The copy shares the computed matrices and faces.

    Numbers are dimensionless, so that solvers see values near one. Forces are divided by ``force_unit``, the
    median dead load of a block. Lengths are divided by ``length_unit``: half the median joint length in the
    plane, half the square root of the median joint area in space.

    Shapes (3b,) and (3c,) are those of the plane, where b blocks have three velocities and c joints three
    forces. In space the joints are contact points, and the shapes are (6b,) and (3c,); see
    :class:`~.faces.Layout`. Limited forces append t entries to (3c,). Attributes of the parts have short
    names here; see :class:`~.parts.ProblemParts`.
    """

    matrices: Matrices
    law: Law
    dead: np.ndarray  #: dead load f_D, shape (3b,)
    live: np.ndarray  #: live load f_L, shape (3b,)
    force_unit: float  #: unit of force of the problem, in the scene's unit; all forces are divided by it
    #: Joint forces under the dead load, shape (3c + t,), at which load histories start. None if the forces
    #: are not known.
    settled: np.ndarray | None = None

    def __repr__(self) -> str:
        height, width = self.B.shape
        sizes = f"{counted(self.blocks, 'movable block')}, {self.joints} {self.layout.called}"
        matrices = f"B {height} × {width}, C {self.faces} × {width}"
        return f"<Problem of {sizes}, {counted(self.matrices.limited, 'limited force')}: {matrices}>"

    def same_program(self, other: "Problem") -> bool:
        """Return True if this problem and another problem can be solved with the same compiled program.

        The problems may then differ only in friction, cohesion and dilatancy, which are parameters of
        programs.
        """
        equal_constants = all(
            np.array_equal(getattr(self, name), getattr(other, name)) for name in _PROGRAM_CONSTANTS
        )
        return equal_constants and self.table is other.table and self.forms == other.forms

    @property
    def recession_cone(self) -> "Problem":
        """Return a copy of the problem in which each finite cohesion, strength and force limit is zero.

        Infinite strengths and limits remain infinite. The copy is the recession cone of the problem: its
        admissible forces can be scaled up without bound.
        """
        limits = {name: getattr(self, name) for name in ("cohesion", "crushing_force", "lowest", "highest")}
        without_constants: dict[str, Any] = {
            name: np.where(np.isfinite(limit), 0.0, limit) for name, limit in limits.items()
        }
        return replace(self, law=replace(self.law, **without_constants))

    @property
    def lowest_forces(self) -> np.ndarray:
        """Return forces q with each limited force at its lower limit, and zero joint forces.

        The shape is (3c + t,). A limited force without a finite lower limit is zero too.
        """
        forces = np.zeros(self.B.shape[1])
        forces[self.B.shape[1] - len(self.lowest) :] = np.where(np.isfinite(self.lowest), self.lowest, 0.0)
        return forces

    @property
    def with_lowest_forces_as_load(self) -> "Problem":
        """Return an equivalent problem in which every finite lower limit of a force is zero.

        The former lower limits are part of the dead load.
        """
        constant = self.lowest_forces
        if not constant.any():
            return self
        lowest = constant[self.B.shape[1] - len(self.lowest) :]
        law = replace(self.law, lowest=self.lowest - lowest, highest=self.highest - lowest)
        settled = None if self.settled is None else self.settled - constant
        return replace(self, law=law, dead=self.dead + self.B @ constant, settled=settled)

    @cached_property
    def statics_fix_forces(self) -> bool:
        """Return True if the equilibrium equations provably determine all joint forces.

        An example is a stack of blocks in the plane.
        """
        return has_independent_columns(self.B)

    @property
    def flow_is_associative(self) -> bool:
        """Return True if the dilatancy equals the friction at all joints.

        All collapse states then have the same load factor.
        """
        return not self.dilatancy_depends_on_stress and np.array_equal(self.dilatancy, self.friction)

    @property
    def live_norm(self) -> float:
        """Return Σ|f_L|, the sum of the magnitudes of all live load components.

        The layout defines the sum, see :meth:`~.faces.Layout.norm`. The objective and the velocities are
        scaled by this number, which brings velocities near 1.
        """
        return self.layout.norm(self.by_block(self.live))

    @cached_property
    def load_factor_scale(self) -> LoadFactorScale:
        """Return the scale for comparing load factors of this problem with each other and with zero."""
        return LoadFactorScale.of_loads(float(self.force_sizes(self.dead).sum()), self.live_norm)

    @property
    def live_displacement(self) -> float:
        """Return the displacement of the live load in a mechanism that is scaled to f_L·d = Σ|f_L|.

        The displacement is the work Σ|f_L| divided by the sum of the magnitudes of the live forces. These
        magnitudes do not depend on the axes.
        """
        return self.live_norm / (self.force_sizes(self.live).sum() or self.live_norm)

    def forces(self, load: np.ndarray) -> np.ndarray:
        """Return the force on each block, shape (b, 2), from a load of shape (3b,).

        For velocities, the result is the translations.

        In space the shape is (b, 3) for (6b,).
        """
        return self.by_block(load)[:, : self.layout.dimension]

    def force_sizes(self, load: np.ndarray) -> np.ndarray:
        """Return the magnitude of the force on each block, shape (b,), from a load of shape (3b,)."""
        return np.hypot.reduce(self.forces(load), axis=1)

    def moments(self, load: np.ndarray) -> np.ndarray:
        """Return the moment on each block, shape (b, 1), from a load of shape (3b,).

        For velocities, the result is the rotations.

        In space the shape is (b, 3). Moments are about centroids, in force times length unit. Rotations are
        multiplied by the length unit.
        """
        return self.by_block(load)[:, self.layout.dimension :]

    @cached_property
    def by_friction(self) -> Sides:
        """Return the friction law of this problem, an instance of ``Sides`` or ``Cone``."""
        return self.forms.friction(self.layout, self.law)

    @cached_property
    def by_strength(self) -> Chords:
        """Return the strength law of this problem, an instance of ``Chords`` or ``Parabola``."""
        return self.forms.strength(self.layout, self.law)

    def by(self, forms: Forms) -> "Problem":
        """Return a copy of the problem whose friction and strength laws are evaluated by the given classes.

        If the problem already uses these classes, the problem itself is returned.
        """
        return self if forms == self.forms else replace(self, law=replace(self.law, forms=forms))

    @cached_property
    def by_cone(self) -> "Problem":
        """Return the problem with the exact friction cone; in the plane, the problem itself."""
        return self.by(self.forms._replace(friction=Cone)) if self.layout.round else self

    @cached_property
    def by_parabola(self) -> "Problem":
        """Return the problem with the exact strength parabola.

        If no joint has a limited strength, the problem itself is returned.
        """
        return self.by(self.forms._replace(strength=Parabola)) if len(self.crushing) else self

    def _by_sense(self, values: np.ndarray) -> np.ndarray:
        """Select the entries of the sliding conditions, shape (senses, k), from an array over all conditions.

        The result is a view of the array ``values``, shape (faces,).
        """
        return values[self.table.slides].reshape(len(self.layout.senses), -1)

    def _of_sliders(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the normal forces, shape (k,), and the shears of the joints that can slide.

        The shears have shape (dimension − 1, k).
        """
        return self.at_points(q)[:, self.sliding].sum(axis=0), self.shears(q)[:, self.sliding]

    def slip_speed(self, d: np.ndarray) -> np.ndarray:
        """Return the slip speed of each joint, shape (c,), under block velocities d, shape (3b,)."""
        return np.hypot.reduce(np.abs(self.shears(self.motion(d))), axis=0)

    def motion(self, d: np.ndarray) -> np.ndarray:
        """Return the relative motions Bᵀd of blocks at joints and at limited forces, shape (3c + t,)."""
        moved: np.ndarray = self.B.T @ d
        return moved

    @property
    def columns_of_sliding(self) -> np.ndarray:
        """Return the indices in q of the force components of the joints that can slide, shape (3, k)."""
        return np.asarray(self.by_kind(np.arange(self.B.shape[1]))[:, self.sliding])

    @cached_property
    def true_yield(self) -> sp.csr_array:
        """Return the yield matrix C(μ) for the joints' own friction coefficients, shape (faces, 3c + t)."""
        return self.C(self.friction)

    def D(self, slope: np.ndarray | float) -> sp.csr_array:
        """Return the flow matrix D, shape (3c + t, faces), for a given ratio of opening to slip.

        The slope is a number for all joints that can slide, or an array of shape (k,). Raises OptionError if
        it is neither.

        If the slope equals the friction, the flow is normal to the yield surface (C = Dᵀ). The sign is that
        of C, because the resultant forces do the work −c·p on the joint velocities with the sign of B used
        here.
        """
        return self.C(slope).T.tocsr()

    @cached_property
    def face_constant(self) -> np.ndarray:
        """Return the constant term of each yield condition without the part from cohesion, shape (faces,).

        The constant is nonzero only for chords of crushing and for forces with limits.
        """
        constant = np.zeros(self.faces)
        constant[self.table.bent] = np.outer(self.crushing_force, CHORDS.constant)
        limits = -self.lowest[self.table.below], self.highest[self.table.above]
        constant[self.table.limits] = np.concatenate(limits)
        return constant

    @cached_property
    def face_cohesion(self) -> np.ndarray:
        """Return the constant term c of each yield condition z = C(μ) q + c, shape (faces,)."""
        return self.limit_factors @ self.cohesion + self.face_constant

    @cached_property
    def steep(self) -> np.ndarray:
        """Return the scale of each slack: max(1, μ) for sliding, 1 for other conditions, shape (faces,).

        Slacks are divided by this scale, because with a large friction coefficient the slack of sliding is
        about μ times the normal force.
        """
        return np.maximum(self.limit_factors @ self.friction, 1.0)

    def slacks(self, q: np.ndarray) -> np.ndarray:
        """Return the slack z = C(μ) q + c of each yield condition under the forces q, shape (faces,).

        A negative slack is a violation. If the law is a friction cone or a strength parabola, the slacks are
        computed from the curve instead of the polygon's sides or the chords. Raises OptionError if ``q`` is
        not an array of one force for each column of B.
        """
        q = vector("q", q, self.B.shape[1], "joint forces")
        z: np.ndarray = self.true_yield @ q + self.face_cohesion
        if isinstance(self.by_friction, Cone):
            self._by_sense(z)[:] = self.by_friction.slacks(*self._of_sliders(q))
        if isinstance(self.by_strength, Parabola):
            z[self.bent] = self.by_strength.slacks(self.at_points(q)[:, self.crushing])[..., None]
        return z

    def energy(self, q: np.ndarray, p: np.ndarray) -> float:
        """Return Σ|z p|, the complementarity error of forces q and rates p.

        Here z are the slacks of the yield conditions under the forces q. The rates p have shape (faces,). The
        error is the energy of conditions that have a nonzero rate although they are not at yield. It is zero
        if complementarity, eq. (8), is satisfied.
        """
        sliding, crushing, others = self._energies(q, p)
        return float(sliding.sum()) + float(crushing.sum()) + float(others.sum())

    def energies(self, q: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Return the complementarity error of each joint, then of each limited force, shape (c + t,).

        The sum of all entries is :meth:`energy`.
        """
        sliding, crushing, others = self._energies(q, p)
        totals = np.zeros(self.joints + self.matrices.limited)
        totals[self.sliding] += np.atleast_2d(sliding).sum(axis=0)
        totals[self.crushing] += crushing if crushing.ndim == 1 else crushing.sum(axis=(0, 2))
        limits = self.joints + np.append(self.table.below, self.table.above)
        np.add.at(totals, np.append(self.face_joint, limits).astype(int), others)
        return totals

    def _energies(self, q: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the complementarity errors of sliding, of crushing and of all other conditions."""
        table = self.table
        z = self.true_yield @ q + self.face_cohesion
        others = np.abs(z * p)
        others[table.slides] = 0.0
        others[table.chords] = 0.0
        sliding = self.by_friction.energies(self._by_sense(z), self._by_sense(p), *self._of_sliders(q))
        at_points = self.at_points(q)[:, self.crushing]
        crushing = np.zeros(0)
        if at_points.size:
            crushing = self.by_strength.energies(z[self.bent], p[self.bent], at_points)
        return sliding, crushing, others

    def energy_costs(self, p: np.ndarray, weight: float) -> tuple[float, np.ndarray]:
        """Return the cost coefficients of λ and of q in the objective λ Σ|f_L| + w Σ z p / steep.

        Here w is ``weight``, z are the slacks C(μ) q + c, and ``steep`` scales the slacks. The rates p have
        shape (faces,), the coefficients of q have shape (3c + t,). The constant part of the objective, which
        contains c, is left out. The objective is bounded below if the live load drives the mechanism and the
        weight is above one.
        """
        return self.live_norm, weight * (self.true_yield.T @ (p / self.steep))

    def rates(self, d: np.ndarray, slope: np.ndarray | float) -> np.ndarray:
        """Return the rates p ≥ 0 (plastic multipliers, shape (faces,)) of all yield conditions in a motion d.

        The flow rule determines the rates. The slip determines the sliding rates of one sense in the plane,
        and of the two senses next to its direction in space. The opening of each contact, minus the opening
        due to sliding, determines the rocking rates. If this difference is negative, ``Bᵀd − D p`` is the
        violation of the flow rule.

        Parameters
        ----------
        d : ndarray, shape (3b,)
            Block velocities.
        slope : float, or ndarray of shape (k,)
            Opening per unit slip, for all joints that can slide or for each of them.

        Raises
        ------
        OptionError
            If the velocities or the slope are not numbers, or have another shape.
        """
        slope = per_joint("slope", slope, len(self.sliding))
        motion = self.motion(vector("d", d, self.B.shape[0], "velocities of all movable blocks"))
        opening = self.at_points(motion)
        slides = self.layout.rates(self.shears(motion)[:, self.sliding])
        opening[:, self.sliding] -= slope * self.by_friction.speed(slides)
        crush = np.zeros(0)
        joints = self.crushing
        if len(joints):
            # In a joint that can crush, crushing rates alone can produce any motion, so its rocking rates are
            # zero.
            first, second = opening[:, joints]
            crush = chord_rates((first + second) / 2, (second - first) / 2).ravel()
            opening[:, joints] = 0.0
        rock = opening / self.layout.points
        extension = self.of_forces(motion)
        limits = np.append(extension[self.table.below], -extension[self.table.above])
        return np.maximum(np.concatenate([slides.ravel(), rock.ravel(), crush, limits]), 0.0)

    def unbalanced(self, load_factor: float, q: np.ndarray) -> np.ndarray:
        """Return the unbalanced forces on the blocks: the residual B q + λ f_L + f_D, shape (3b,)."""
        return self.B @ q + load_factor * self.live + self.dead

    def departure(self, d: np.ndarray, p: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Return the residual Bᵀd − D(slope) p of the flow rule in a motion d, shape (3c + t,)."""
        flow = self.true_yield if slope is self.friction else self.C(slope)
        residual = self.motion(d) - flow.T @ p
        if self.by_friction.conic:
            # For a cone, the joint opens by ``slope`` times its slip rate. In ``flow``, the joint opens by
            # ``slope`` times ``slip_of_sides``. Correct the residual of the opening by the difference.
            slip_of_sides = self.limit_factors.T @ p
            residual[self.sliding] += slope * (slip_of_sides - self.slip(p))
        return residual

    def slip(self, p: np.ndarray) -> np.ndarray:
        """Return the slip rate of each joint that can slide, shape (k,), from rates p of shape (faces,).

        The slip rate times the shear limit is the dissipated power.
        """
        return self.by_friction.speed(self._by_sense(p))

    def normal_forces(self, q: np.ndarray) -> np.ndarray:
        """Return the normal force of each joint, shape (c,), from forces q of shape (3c + t,)."""
        return np.asarray(self.at_points(q).sum(axis=0))

    def at_points(self, q: np.ndarray) -> np.ndarray:
        """Return the normal forces at the contact points of joints, shape (2, c), from the forces q.

        In space each joint is one contact point, and the shape is (1, c).
        """
        return self.by_kind(q)[: self.layout.points]

    def shears(self, q: np.ndarray) -> np.ndarray:
        """Return the shears of all joints, shape (1, c), in space (2, c), from the forces q."""
        return self.by_kind(q)[self.layout.points :]


@dataclass(frozen=True)
class ShearLimits:
    """Shear limits |s| ≤ cohesion + slope · n of the joints that can slide (eq. (4), Fig. 4 of the paper)."""

    slope: np.ndarray  #: shape (k,)
    cohesion: np.ndarray  #: as a force, shape (k,)

    __repr__ = brief

    @classmethod
    def true(cls, problem: Problem) -> "ShearLimits":
        """Return the true shear limits, which follow from the joints' own friction and cohesion.

        A flow normal to these limits is associative (C = D).
        """
        return cls(problem.friction, problem.cohesion)

    def at(self, n: np.ndarray) -> np.ndarray:
        """Return the shear limit of each joint that can slide, under the normal forces n, shape (k,)."""
        return self.cohesion + self.slope * n


@dataclass(frozen=True)
class Scaled:
    """Problem in scaled units, with factors that convert its forces and λ to the original units.

    Velocities are equal in both units.
    """

    problem: Problem  #: the problem in the scaled units
    force: float  #: factor that converts forces of the scaled problem to units of the original problem
    load_factor: float  #: factor that converts λ of the scaled problem to λ of the original problem

    __repr__ = brief

    def limits(self, limits: ShearLimits) -> ShearLimits:
        """Convert shear limits of the original problem to the units of the scaled problem."""
        return ShearLimits(limits.slope, limits.cohesion / self.force)

    def state(self, state: State) -> State:
        """Convert a state of the scaled problem to the units of the original problem."""
        return replace(state, load_factor=self.load_factor * state.load_factor, q=self.force * state.q)


def in_units_of_live_load(problem: Problem) -> Scaled:
    """Return the problem with its live load scaled to about the magnitude of the dead load.

    The factor is the power of two that brings the largest entries of both loads nearest to each other. Powers
    of two change no digit of any number.
    """
    live, dead = (float(np.abs(load).max()) or 1.0 for load in (problem.live, problem.dead))
    unit = 2.0 ** np.round(np.log2(live / dead))
    return Scaled(replace(problem, live=problem.live / unit), 1.0, 1.0 / float(unit))


def in_units_of_load(problem: Problem) -> Scaled:
    """Return the problem with its live load divided by Σ|f_L|, and all other forces by a typical dead load.

    The typical dead load is Σ|f_D| over the blocks on which the live load acts. If these blocks have no dead
    load, the sum is over all blocks. Without any dead load, forces are divided by Σ|f_L|.

    Tolerances of solvers are relative to the largest forces, which are many block weights in large scenes. In
    the scaled units, solvers reach smaller errors, and at rough tolerances the error does not grow with the
    size of the scene.
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
