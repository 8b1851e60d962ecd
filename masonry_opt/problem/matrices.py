"""The geometry of a scene as matrices."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from masonry_opt.problem.faces import PLANE, Faces, Layout, selection

#: Tables of faces that matrices remember: of the laws that the programs in use are declared under.
_REMEMBERED = 4


@dataclass(frozen=True)
class Matrices:
    """Equilibrium of b movable blocks under the forces of c joints and t limited forces.

    Attributes
    ----------
    B: equilibrium matrix, shape (3b, 3c + t); rows fx, fy, moment about the centroid of each block,
        columns n (compression > 0) of all joints, then s, then m (about the joint's middle), then the
        limited forces, each on a line of its own: of ties, props, earth.
    half_length: L / 2 of each joint, shape (c,); 1 where a corner stands on an edge, whose column m of B is
        empty: there the two rocking faces say n ≥ 0, and m says nothing.
    length_unit: what a dimensionless length is multiplied by.
    layout: the numbers 3 and 3 above, and what goes with them.
    areas: area that each contact point in space stands for, shape (c,); None in the plane.
    limited: number of limited forces, t.
    """

    B: sp.csr_array
    half_length: np.ndarray
    length_unit: float
    layout: Layout = PLANE
    areas: np.ndarray | None = None
    limited: int = 0
    _tables: dict[tuple[bytes, ...], Faces] = field(default_factory=dict, init=False, repr=False)

    @property
    def blocks(self) -> int:
        """Number of movable blocks, b."""
        return self.B.shape[0] // self.layout.rows

    @property
    def joints(self) -> int:
        """Number of joints, c."""
        return (self.B.shape[1] - self.limited) // self.layout.kinds

    @cached_property
    def of_joints(self) -> sp.csr_array:
        """Columns of B that are of joints, shape (3b, 3c)."""
        return self.B[:, : self.layout.kinds * self.joints] if self.limited else self.B

    @cached_property
    def of_limited(self) -> sp.csr_array:
        """Columns of B that are of limited forces, shape (3b, t)."""
        return self.B[:, self.layout.kinds * self.joints :]

    @property
    def extent(self) -> np.ndarray:
        """What the stiffness of joints grows with, shape (c,): their length, or area."""
        return self.half_length if self.areas is None else self.areas

    def faces(
        self, sliding: np.ndarray, crushing: np.ndarray, bounded: tuple[np.ndarray, np.ndarray]
    ) -> Faces:
        """Table of the faces of joints of which these slide and these crush, and of limited forces of which
        these are bounded below and these above, shape (t,) each; one for all laws that agree."""
        key = tuple(of.tobytes() for of in (sliding, crushing, *bounded))
        if key not in self._tables:
            for oldest in list(self._tables)[: 1 - _REMEMBERED]:
                del self._tables[oldest]
            self._tables[key] = Faces(self.layout, self.half_length, sliding, crushing, bounded)
        return self._tables[key]

    def by_block(self, of_rows: np.ndarray) -> np.ndarray:
        """Loads or velocities, shape (3b,), by block, shape (b, 3)."""
        return of_rows.reshape(-1, self.layout.rows)

    def by_kind(self, of_columns: np.ndarray) -> np.ndarray:
        """Forces or motions of joints, in those of all columns, shape (3c + t,), by kind, shape (3, c)."""
        return of_columns[: len(of_columns) - self.limited].reshape(self.layout.kinds, -1)

    def of_forces(self, of_columns: np.ndarray) -> np.ndarray:
        """Limited forces or their motions, shape (t,), in those of all columns, shape (3c + t,)."""
        return of_columns[len(of_columns) - self.limited :]

    @cached_property
    def ends(self) -> sp.csr_array:
        """1 where a joint (column) is one of a block's (row), shape (b, c)."""
        rows, columns = (np.arange(size) for size in self.of_joints.shape)
        of_joints = abs(self.of_joints) @ selection(columns % self.joints, self.joints)
        touched = (selection(rows // self.layout.rows, self.blocks).T @ of_joints).tocsr()
        touched.data[:] = 1.0
        return touched

    @cached_property
    def touching(self) -> tuple[np.ndarray, np.ndarray]:
        """Block and joint of every end of a joint on a movable block."""
        entries = self.ends.tocoo()
        return entries.row, entries.col

    @cached_property
    def longest_arm(self) -> np.ndarray:
        """Longest arm of a force on each block, half a joint's length at least, shape (b,)."""
        moments = self.by_block(np.arange(self.B.shape[0]))[:, self.layout.dimension :]
        of_forces = abs(self.B[moments.ravel(), : self.layout.dimension * self.joints])
        arms = of_forces.max(axis=1).toarray().reshape(moments.shape).max(axis=1)
        block, joint = self.touching
        np.maximum.at(arms, block, self.half_length[joint])
        # Where there is none, as of a block that ties alone hold, the unit of length.
        return np.where(arms > 0, arms, 1.0)

    @cached_property
    def in_a_point(self) -> np.ndarray:
        """Whether each joint carries no moment, as a corner on an edge, shape (c,)."""
        moments = self.of_joints[:, self.layout.dimension * self.joints :].tocsc()
        return ~np.diff(moments.indptr).reshape(-1, self.joints).any(axis=0)

    @cached_property
    def part(self) -> np.ndarray:
        """Number of the connected part of the scene that each joint belongs to, shape (c,). Parts
        that share supports alone do not act on each other."""
        _, part = connected_components(self.ends.T @ self.ends, directed=False)
        return part
