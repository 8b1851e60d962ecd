"""Limited forces as joints, which the passes know: one algebra of joints serves both."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from masonry_opt.problem.faces import KINDS
from masonry_opt.problem.laws import Law
from masonry_opt.problem.matrices import Matrices
from masonry_opt.problem.problem import Problem
from masonry_opt.problem.state import State

#: Largest size of a force without limits, over all loads: where it acts, no state has it.
_FAR = 10.0


@dataclass(frozen=True)
class JointsAlone:
    """A problem whose limited forces are joints in a point: what T is above its lowest, or below its highest
    value, is a normal force n ≥ 0; a force without limits is the shear of a joint that holds anything.

    These joints have cohesion and no friction, and no column of B but the force's own: what else they carry
    is zero in the centre of the interior. A force whose limits are one is a dead load.

    Attributes
    ----------
    given: the problem.
    problem: the same without limited forces; the given one where it has none.
    most: largest normal force of each of its joints, infinite for those of the given problem, shape (c,).
    """

    given: Problem
    problem: Problem
    most: np.ndarray

    @classmethod
    def of(cls, given: Problem) -> JointsAlone:
        """The problem with joints in place of its limited forces."""
        if not given.matrices.limited:
            return cls(given, given, np.full(given.joints, np.inf))
        matrices, varied = given.matrices, _varied(given)
        free, base, sign = _free(given), _base(given), _sign(given)
        columns, none = matrices.of_limited.tocsc(), sp.csc_array((given.dead.size, len(varied)))
        normal = columns @ sp.diags_array(np.where(free, 0.0, sign))
        shear = columns @ sp.diags_array(free.astype(float))
        own = matrices.of_joints.tocsc()
        kinds = [own[:, kind] for kind in np.arange(own.shape[1]).reshape(KINDS, -1)]
        points = matrices.layout.points
        added = [*points * [normal[:, varied]], shear[:, varied], none][:KINDS]
        B = sp.hstack([part for pair in zip(kinds, added, strict=True) for part in pair], format="csr")
        B.eliminate_zeros()
        extent = np.append(matrices.extent, np.ones(len(varied)))
        together = Matrices(B, extent, matrices.length_unit, matrices.layout)
        dead = given.dead + matrices.of_limited @ base
        most = np.append(
            np.full(given.joints, np.inf), np.where(free, 1.0, given.highest - given.lowest)[varied]
        )
        problem = replace(given, matrices=together, law=_law(given, given.law), dead=dead)
        return cls(given, problem, most)

    def law(self, law: Law) -> Law:
        """A law of the given problem, as one of its joints alone."""
        return _law(self.given, law) if self.given.matrices.limited else law

    def forces(self, q: np.ndarray) -> np.ndarray:
        """Forces of the given problem, shape (3c + t,), of those of joints alone."""
        given = self.given
        if not given.matrices.limited:
            return q
        kinds, varied, free = self.problem.by_kind(q), _varied(given), _free(given)
        points = given.layout.points
        normal, shear = kinds[:points, given.joints :].sum(axis=0), kinds[points, given.joints :]
        T = _base(given)
        T[varied] += np.where(free[varied], shear, _sign(given)[varied] * normal)
        return np.append(kinds[:, : given.joints].ravel(), T)

    def joint_forces(self, q: np.ndarray) -> np.ndarray:
        """The other way round."""
        given = self.given
        if not given.matrices.limited:
            return q
        varied, free = _varied(given), _free(given)
        T = given.of_forces(q)[varied]
        above = _sign(given)[varied] * (T - _base(given)[varied])
        kinds, points = np.zeros((KINDS, len(varied))), given.layout.points
        kinds[:points] = np.where(free[varied], 0.5, above) / points
        kinds[points] = np.where(free[varied], T, 0.0)
        return np.concatenate([given.by_kind(q), kinds], axis=1).ravel()

    def compliance(self, of_joints: np.ndarray) -> np.ndarray:
        """Compliance of joints and forces of the given problem, shape (3c + t,), of that of joints alone; of
        forces that do not vary it means nothing."""
        given = self.given
        if not given.matrices.limited:
            return of_joints
        kinds, varied, points = self.problem.by_kind(of_joints), _varied(given), given.layout.points
        normal, shear = kinds[0, given.joints :] / points, kinds[points, given.joints :]
        forces = np.full(given.matrices.limited, normal.mean() if len(normal) else 0.0)
        forces[varied] = np.where(_free(given)[varied], shear, normal)
        return np.append(kinds[:, : given.joints].ravel(), forces)

    def held(self, of_joints: np.ndarray) -> np.ndarray:
        """Compliance of joints alone, shape (3c,), none of it where a force without limits holds a support:
        that is the ground."""
        varied, kinds = _varied(self.given), self.problem.by_kind(of_joints.copy())
        kinds[:, self.given.joints :][:, _free(self.given)[varied]] = 0.0
        return kinds.ravel()

    def state(self, state: State, gives: Problem) -> State:
        """A state of the given problem, of one of joints alone; what contacts give is that of ``gives``."""
        given, table = self.given, self.problem.table
        if not given.matrices.limited:
            return state
        q, p = self.forces(state.q), state.p
        slides = p[table.slides].reshape(-1, len(self.problem.sliding))[:, : len(given.sliding)]
        rocks = p[table.rocks].reshape(-1, self.problem.joints)[:, : given.joints]
        moved = given.of_forces(gives.motion(state.d, q))
        limits = np.append(moved[given.table.below], -moved[given.table.above])
        rates = [slides.ravel(), rocks.ravel(), p[table.chords], np.maximum(limits, 0.0)]
        return replace(state, q=q, p=np.concatenate(rates))


def _free(problem: Problem) -> np.ndarray:
    return np.isinf(problem.lowest) & np.isinf(problem.highest)


def _varied(problem: Problem) -> np.ndarray:
    return np.flatnonzero(problem.highest > problem.lowest)


def _sign(problem: Problem) -> np.ndarray:
    return np.where(np.isfinite(problem.lowest), 1.0, -1.0)


def _base(problem: Problem) -> np.ndarray:
    """The limit that each force is counted from, 0 of those without, shape (t,)."""
    lowest, highest = problem.lowest, problem.highest
    return np.where(np.isfinite(lowest), lowest, np.where(np.isfinite(highest), highest, 0.0))


def _law(given: Problem, law: Law) -> Law:
    varied, loads = _varied(given), given.force_sizes(given.dead).sum() + given.force_sizes(given.live).sum()
    one, nothing = np.ones(len(varied)), np.zeros(len(varied))
    return replace(
        law,
        sliding=np.append(law.sliding, given.joints + np.arange(len(varied))),
        friction=np.append(law.friction, nothing),
        cohesion=np.append(law.cohesion, np.where(_free(given)[varied], _FAR * loads, one)),
        dilatancy=np.append(law.dilatancy, nothing),
        dilatancy_force=np.concatenate([law.dilatancy_force, np.full((len(varied), 2), np.inf)]),
        lowest=np.zeros(0),
        highest=np.zeros(0),
    )
