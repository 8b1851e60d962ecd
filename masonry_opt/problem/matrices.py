"""Build the equilibrium matrix of a scene, and index its rows and columns."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from masonry_opt.brief import brief
from masonry_opt.problem.faces import FORCE_COMPONENTS, PLANE, Bounded, Faces, Layout, space
from masonry_opt.problem.limited_forces import LimitedForce, columns
from masonry_opt.problem.loads import moment_of
from masonry_opt.scene.contacts.joints import Joints
from masonry_opt.scene.geometry import Extents

#: Number of sides of the friction polygon inside the cone. More sides enlarge the programs. Load factors of
#: corner walls are lower than with the cone: by 0.1 to 0.3 % with 24 sides, by 0.2 to 0.5 % with 16 (see
#: "Polygons and cones" in ``benchmarks/README.md``).
SIDES = 24


def shares(joints: Joints, joint: np.ndarray) -> np.ndarray:
    """Return the length of each joint, shape (c,); in space, the area that belongs to each contact point.

    In space the area of a joint is divided equally among its contact points.
    """
    return np.asarray((joints.extent / np.bincount(joint, minlength=len(joints.extent)))[joint])


@dataclass(frozen=True)
class Matrices:
    """Equilibrium matrix of a problem, and the meaning of its rows and columns.

    The problem has b movable blocks, c joints and t limited forces, such as the forces of ties.
    """

    #: Equilibrium matrix, shape (3b, 3c + t). The rows of a block are fx, fy and the moment about its
    #: centroid. The columns are the normal forces n₁ at the starts of all joints (compression > 0), all n₂ at
    #: the ends, all shears s, then the limited forces. In space, the columns are all n, all shears s, all
    #: shears t, then the limited forces. The paper's normal force is n₁ + n₂; its moment is L/2 (n₂ − n₁).
    B: sp.csr_array
    #: Size of each contact divided by the median size, shape (c,). The size is the length of a joint, or in
    #: space the area that belongs to a contact point. Elastic stiffness is proportional to this ratio. A
    #: contact at a corner has the ratio 1.
    extent: np.ndarray
    length_unit: float  #: length by which all lengths are divided, in the scene's unit of length
    layout: Layout = PLANE  #: sizes of arrays and order of their entries, in the plane or in space
    limited: int = 0  #: number of limited forces, t
    _tables: dict[tuple[bytes, ...], Faces] = field(default_factory=dict, init=False, repr=False)

    __repr__ = brief

    @classmethod
    def of(
        cls,
        joints: Joints,
        shapes: Extents,
        movable: np.ndarray,
        length_unit: float,
        limited: Sequence[LimitedForce] = (),
    ) -> "Matrices":
        """Assemble the equilibrium matrix of the blocks with the indices ``movable``.

        A column of B contains the forces and moments of one unit of a joint force on the joint's first block,
        and the opposite forces and moments on its second block. The shear s acts along the joint's tangent;
        in space t acts along normal × tangent. Lengths are divided by ``length_unit``.
        """
        layout = PLANE if joints.point.shape[1] == 2 else space(SIDES)
        joint, pressed = joints.parts
        points = joints.point[pressed]
        count = len(joint)
        normal, *tangents = joints.axes[:, joint]
        # Normal forces act at the contact points.
        normal_forces = [(point, normal) for point in points]
        # Shears act at the mean of the contact points.
        shears = [(points.mean(axis=0), tangent) for tangent in tangents]
        row_of = np.full(len(shapes.size), -1)
        row_of[movable] = np.arange(len(movable))
        rows, numbers, values = [], [], []
        for block_of_joint, sign in ((joints.first, 1.0), (joints.second, -1.0)):
            block = block_of_joint[joint]
            for kind, (point, direction) in enumerate([*normal_forces, *shears]):
                arm = (point - shapes.centroid[block]) / length_unit
                entries = sign * np.column_stack([direction, moment_of(arm, direction)])
                rows.append(layout.rows * row_of[block][:, None] + np.arange(layout.rows))
                numbers.append(np.broadcast_to((kind * count + np.arange(count))[:, None], entries.shape))
                values.append(entries)
        row, column, value = (np.concatenate(parts).ravel() for parts in (rows, numbers, values))
        # Remove the entries of fixed blocks, and exact zeros, which occur at axis-aligned joints.
        stored = (row >= 0) & (value != 0)
        shape = layout.rows * len(movable), FORCE_COMPONENTS * count
        B = sp.csr_array((value[stored], (row[stored], column[stored])), shape=shape)
        if limited:
            B = sp.hstack([B, columns(limited, shapes.centroid, movable, length_unit)], format="csr")
        share = shares(joints, joint)
        median = float(np.median(share[share > 0])) if share.any() else 1.0
        return cls(B, np.where(share > 0, share / median, 1.0), length_unit, layout, len(limited))

    @property
    def blocks(self) -> int:
        """Return the number of movable blocks, b."""
        return self.B.shape[0] // self.layout.rows

    @property
    def joints(self) -> int:
        """Return the number of joints, c; in space the number of contact points."""
        return (self.B.shape[1] - self.limited) // FORCE_COMPONENTS

    @cached_property
    def of_joints(self) -> sp.csr_array:
        """Return the columns of B for the joint forces, shape (3b, 3c)."""
        return self.B[:, : FORCE_COMPONENTS * self.joints] if self.limited else self.B

    @cached_property
    def of_limited(self) -> sp.csr_array:
        """Return the columns of B for the limited forces, shape (3b, t)."""
        return self.B[:, FORCE_COMPONENTS * self.joints :]

    def faces(self, sliding: np.ndarray, crushing: np.ndarray, bounded: Bounded) -> Faces:
        """Return the table of yield conditions (called faces) of all joints and limited forces.

        ``sliding`` and ``crushing`` are the indices of the joints that can slide and of those that can crush.
        Limited forces are forces with a lower or an upper limit, such as the force in a tie. The two masks of
        ``bounded`` mark the forces with a lower limit and the forces with an upper limit.
        Equal arguments return one shared object, so all joint laws share its computed arrays.
        """
        key = tuple(array.tobytes() for array in (sliding, crushing, *bounded))
        if key not in self._tables:
            self._tables[key] = Faces(self.layout, self.joints, sliding, crushing, bounded)
        return self._tables[key]

    def by_block(self, of_rows: np.ndarray) -> np.ndarray:
        """Reshape loads or velocities, shape (3b,), to one row for each block, shape (b, 3)."""
        return of_rows.reshape(-1, self.layout.rows)

    def by_kind(self, of_columns: np.ndarray) -> np.ndarray:
        """Reshape joint forces or joint motions to one row for each force component, shape (3, c).

        The argument has values of all columns of B, shape (3c + t,).
        """
        return of_columns[: len(of_columns) - self.limited].reshape(FORCE_COMPONENTS, -1)

    def of_forces(self, of_columns: np.ndarray) -> np.ndarray:
        """Select the values of the limited forces, shape (t,), from values for all columns of B.

        The argument has shape (3c + t,). Its values are forces or motions.
        """
        return of_columns[len(of_columns) - self.limited :]

    @cached_property
    def ends(self) -> sp.csr_array:
        """Return the incidence matrix of blocks and joints, shape (b, c).

        An entry is 1 if the joint touches the block.
        """
        entries = self.of_joints.tocoo()
        at = entries.row // self.layout.rows, entries.col % self.joints
        touched = sp.csr_array((np.ones(entries.nnz), at), shape=(self.blocks, self.joints))
        touched.data[:] = 1.0
        return touched

    @cached_property
    def longest_arm(self) -> np.ndarray:
        """Return the longest lever arm of the joint forces on each block, shape (b,), in the length unit."""
        if not self.joints:
            return np.ones(self.blocks)
        largest = self.by_block(abs(self.of_joints).max(axis=1).toarray())
        arms = largest[:, self.layout.dimension :].max(axis=1)
        # Blocks without joints, which only limited forces such as ties support, get the unit of length as
        # their longest arm.
        return np.where(arms > 0, arms, 1.0)

    @cached_property
    def part(self) -> np.ndarray:
        """Return, for each joint, the index of its part (connected component) of the scene, shape (c,).

        Joints are connected by movable blocks. Supports do not connect them.
        """
        _, part = connected_components(self.ends.T @ self.ends, directed=False)
        return part
