"""The geometry of a scene as matrices."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from masonry_opt.problem.faces import KINDS, PLANE, Bounded, Faces, Layout, space
from masonry_opt.problem.limited_forces import LimitedForce, columns
from masonry_opt.problem.loads import moment_of
from masonry_opt.scene.contacts.joints import Joints
from masonry_opt.scene.geometry import Extents

#: Sides of the polygon inside the cone of friction. Associative and incremental load factors of corner walls
#: are some 0.2 % lower than by cones; with 12 sides 1 %, with 16 sides 0.5 %. Steps are as many.
SIDES = 24


def shares(joints: Joints, joint: np.ndarray) -> np.ndarray:
    """Length or area that each of the problem's joints stands for, an equal share of its joint's."""
    return np.asarray((joints.extent / np.bincount(joint, minlength=len(joints.extent)))[joint])


@dataclass(frozen=True)
class Matrices:
    """Equilibrium of b movable blocks under the forces of c joints and t limited forces."""

    #: Equilibrium matrix, shape (3b, 3c + t); rows fx, fy, moment about the centroid of each block, columns
    #: n₁ (compression > 0) at the start of all joints, then n₂ at their end, then s, then the limited forces,
    #: each on a line of its own: of ties, props, earth. The paper's n is n₁ + n₂, its m, about the joint's
    #: middle, L/2 (n₂ − n₁). In space n of all contact points, then s, then t.
    B: sp.csr_array
    #: Length of each joint, in space area that a contact point stands for, over the median, which its
    #: stiffness grows with, shape (c,); 1 where there is none, as of a corner on an edge.
    extent: np.ndarray
    length_unit: float  #: what a dimensionless length is multiplied by
    layout: Layout = PLANE  #: rows of a block and points of a joint, and what goes with them
    limited: int = 0  #: number of limited forces, t
    _tables: dict[tuple[bytes, ...], Faces] = field(default_factory=dict, init=False, repr=False)

    @classmethod
    def of(
        cls,
        joints: Joints,
        shapes: Extents,
        movable: np.ndarray,
        length_unit: float,
        limited: Sequence[LimitedForce] = (),
    ) -> "Matrices":
        """B with lengths in ``length_unit``, of the blocks with these indices. Columns are wrenches of unit
        forces, s along a joint's tangent, in space t along normal × tangent, reversed on the second block."""
        layout = PLANE if joints.point.shape[1] == 2 else space(SIDES)
        joint, pressed = joints.parts
        at, count, (normal, *tangents) = joints.point[pressed], len(joint), joints.axes[:, joint]
        forces = [*((place, normal) for place in at), *((at.mean(axis=0), along) for along in tangents)]
        row_of = np.full(len(shapes.size), -1)
        row_of[movable] = np.arange(len(movable))
        rows, numbers, values = [], [], []
        for of_joint, sign in ((joints.first, 1.0), (joints.second, -1.0)):
            block = of_joint[joint]
            for kind, (place, force) in enumerate(forces):
                arm = (place - shapes.centroid[block]) / length_unit
                entries = sign * np.column_stack([force, moment_of(arm, force)])
                rows.append(layout.rows * row_of[block][:, None] + np.arange(layout.rows))
                numbers.append(np.broadcast_to((kind * count + np.arange(count))[:, None], entries.shape))
                values.append(entries)
        row, column, value = (np.concatenate(parts).ravel() for parts in (rows, numbers, values))
        # Fixed blocks have no rows; exact zeros (axis-aligned joints) stay out of the pattern.
        stays = (row >= 0) & (value != 0)
        shape = layout.rows * len(movable), KINDS * count
        B = sp.csr_array((value[stays], (row[stays], column[stays])), shape=shape)
        if limited:
            B = sp.hstack([B, columns(limited, shapes.centroid, movable, length_unit)], format="csr")
        share = shares(joints, joint)
        usual = float(np.median(share[share > 0])) if share.any() else 1.0
        return cls(B, np.where(share > 0, share / usual, 1.0), length_unit, layout, len(limited))

    @property
    def blocks(self) -> int:
        """Number of movable blocks, b."""
        return self.B.shape[0] // self.layout.rows

    @property
    def joints(self) -> int:
        """Number of joints, c."""
        return (self.B.shape[1] - self.limited) // KINDS

    @cached_property
    def of_joints(self) -> sp.csr_array:
        """Columns of B that are of joints, shape (3b, 3c)."""
        return self.B[:, : KINDS * self.joints] if self.limited else self.B

    @cached_property
    def of_limited(self) -> sp.csr_array:
        """Columns of B that are of limited forces, shape (3b, t)."""
        return self.B[:, KINDS * self.joints :]

    def faces(self, sliding: np.ndarray, crushing: np.ndarray, bounded: Bounded) -> Faces:
        """Faces where these joints slide, these crush and these forces are bounded: one for all laws."""
        key = tuple(of.tobytes() for of in (sliding, crushing, *bounded))
        if key not in self._tables:
            self._tables[key] = Faces(self.layout, self.joints, sliding, crushing, bounded)
        return self._tables[key]

    def by_block(self, of_rows: np.ndarray) -> np.ndarray:
        """Loads or velocities, shape (3b,), by block, shape (b, 3)."""
        return of_rows.reshape(-1, self.layout.rows)

    def by_kind(self, of_columns: np.ndarray) -> np.ndarray:
        """Forces or motions of joints, in those of all columns, shape (3c + t,), by kind, shape (3, c)."""
        return of_columns[: len(of_columns) - self.limited].reshape(KINDS, -1)

    def of_forces(self, of_columns: np.ndarray) -> np.ndarray:
        """Limited forces or their motions, shape (t,), in those of all columns, shape (3c + t,)."""
        return of_columns[len(of_columns) - self.limited :]

    @cached_property
    def ends(self) -> sp.csr_array:
        """1 where a joint (column) is one of a block's (row), shape (b, c)."""
        entries = self.of_joints.tocoo()
        at = entries.row // self.layout.rows, entries.col % self.joints
        touched = sp.csr_array((np.ones(entries.nnz), at), shape=(self.blocks, self.joints))
        touched.data[:] = 1.0
        return touched

    @cached_property
    def longest_arm(self) -> np.ndarray:
        """Longest arm of a joint's force on each block, shape (b,)."""
        largest = self.by_block(abs(self.of_joints).max(axis=1).toarray())
        arms = largest[:, self.layout.dimension :].max(axis=1)
        # Where there is none, as of a block that ties alone hold, the unit of length.
        return np.where(arms > 0, arms, 1.0)

    @cached_property
    def part(self) -> np.ndarray:
        """Number of the part of the scene, connected without supports, that each joint is in, shape (c,)."""
        _, part = connected_components(self.ends.T @ self.ends, directed=False)
        return part
