"""Short names of a problem's matrices, joint law and yield conditions.

Formulas read ``problem.B`` and ``problem.friction`` in place of ``problem.matrices.B`` and
``problem.law.friction``.
"""

from functools import cached_property

import numpy as np
import scipy.sparse as sp

from masonry_opt.problem.arguments import per_joint
from masonry_opt.problem.faces import Faces, Layout
from masonry_opt.problem.laws import Forms, Law
from masonry_opt.problem.matrices import Matrices


class ProblemParts:
    """Read-only short names for the contents of a problem's matrices, joint law and yield conditions.

    :class:`~.problem.Problem` adds the loads.
    """

    matrices: Matrices
    law: Law

    @cached_property
    def table(self) -> Faces:
        """Return the ``Faces`` of this problem: its yield conditions, their order and their matrices.

        Problems in which the same joints and forces are limited share this object.
        """
        bounded = np.isfinite(self.lowest), np.isfinite(self.highest)
        return self.matrices.faces(self.sliding, self.crushing, bounded)

    @property
    def B(self) -> sp.csr_array:
        """Return the equilibrium matrix, shape (3b, 3c + t)."""
        return self.matrices.B

    @property
    def length_unit(self) -> float:
        """Return the length by which all lengths are divided, in the scene's unit of length."""
        return self.matrices.length_unit

    @property
    def layout(self) -> Layout:
        """Return the layout of the arrays: their sizes and the order of their entries."""
        return self.matrices.layout

    @property
    def blocks(self) -> int:
        """Return the number of movable blocks, b."""
        return self.matrices.blocks

    @property
    def joints(self) -> int:
        """Return the number of joints, c; in space the number of contact points."""
        return self.matrices.joints

    @property
    def part(self) -> np.ndarray:
        """Return, for each joint, the index of its part (connected component) of the scene, shape (c,)."""
        return self.matrices.part

    def of_forces(self, of_columns: np.ndarray) -> np.ndarray:
        """Select the values of the limited forces, shape (t,), from values for all columns of B."""
        return self.matrices.of_forces(of_columns)

    def by_block(self, of_rows: np.ndarray) -> np.ndarray:
        """Reshape loads or velocities, shape (3b,), to one row for each block, shape (b, 3)."""
        return self.matrices.by_block(of_rows)

    def by_kind(self, of_columns: np.ndarray) -> np.ndarray:
        """Reshape joint forces or joint motions to one row for each force component, shape (3, c)."""
        return self.matrices.by_kind(of_columns)

    @property
    def sliding(self) -> np.ndarray:
        """Return the indices of the joints that can slide, shape (k,)."""
        return self.law.sliding

    @property
    def friction(self) -> np.ndarray:
        """Return the friction coefficient μ of each joint that can slide, shape (k,)."""
        return self.law.friction

    @property
    def cohesion(self) -> np.ndarray:
        """Return the cohesion of each joint that can slide, as a force, shape (k,)."""
        return self.law.cohesion

    @property
    def dilatancy(self) -> np.ndarray:
        """Return the dilatancy tan φ₀ of each joint that can slide, shape (k,)."""
        return self.law.dilatancy

    @property
    def crushing(self) -> np.ndarray:
        """Return the indices of the joints of limited strength, shape (l,)."""
        return self.law.crushing

    @property
    def crushing_force(self) -> np.ndarray:
        """Return the normal force f_c L at which a joint of limited strength crushes entirely, shape (l,)."""
        return self.law.crushing_force

    @property
    def lowest(self) -> np.ndarray:
        """Return the lower limit of each limited force, shape (t,); −inf for a force without lower limit."""
        return self.law.lowest

    @property
    def highest(self) -> np.ndarray:
        """Return the upper limit of each limited force, shape (t,); inf for a force without upper limit."""
        return self.law.highest

    @property
    def forms(self) -> Forms:
        """Return the classes that evaluate the friction law and the strength law."""
        return self.law.forms

    @property
    def dilatancy_depends_on_stress(self) -> bool:
        """Return True if the dilatancy of at least one joint falls with its normal force."""
        return self.law.dilatancy_depends_on_stress

    def dilatancy_at(self, n: np.ndarray) -> np.ndarray:
        """Return the dilatancy tan φ₀ of each joint that can slide, under given normal forces, shape (k,).

        ``n`` are the normal forces of all joints, shape (c,).
        """
        return self.law.dilatancy_at(n)

    @property
    def N(self) -> sp.csr_array:
        """Return the matrix that sums the normal forces of each joint that can slide, shape (k, 3c + t)."""
        return self.table.N

    @property
    def limit_factors(self) -> sp.csr_array:
        """Return the coefficient of each shear limit in each yield condition, shape (faces, k)."""
        return self.table.limit_factors

    @property
    def bent(self) -> np.ndarray:
        """Return the indices of the crushing conditions by point, joint and chord, shape (2, l, chords).

        The axes are the two contact points, the l joints with limited strength, and the chords.
        """
        return self.table.bent

    @property
    def face_joint(self) -> np.ndarray:
        """Return the index of the joint to which each yield condition belongs, shape (faces − limits,).

        The last conditions, which limit forces such as those of ties, belong to no joint and are left out.
        """
        return self.table.face_joint

    @property
    def faces(self) -> int:
        """Return the number of yield conditions."""
        return self.table.count

    def C(self, slope: np.ndarray | float) -> sp.csr_array:
        """Return the yield matrix C for a given slope of the shear limits, shape (faces, 3c + t).

        The slope is a number for all joints that can slide, or an array of shape (k,). Raises OptionError if
        it is neither.
        """
        return self.table.C(per_joint("slope", slope, len(self.sliding)))
