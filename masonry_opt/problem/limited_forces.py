"""Model limited forces: forces of ties, props, earth and freed supports.

A limited force T is a scalar force between two bounds. It has one column in B and two yield conditions,
``T − lowest ≥ 0`` and ``highest − T ≥ 0``. Friction does not apply to it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import inf

import numpy as np
import scipy.sparse as sp

from masonry_opt.brief import brief
from masonry_opt.errors import CaseError, rounded
from masonry_opt.problem.loads import moment_of, moments_in
from masonry_opt.scene.geometry import Extents
from masonry_opt.scene.loads import GROUND, Tie
from masonry_opt.scene.scene import Scene


class Role(StrEnum):
    """Kind of a limited force: the force of a tie, of a prop or of a freed support, or an earth pressure."""

    TIE = "tie"
    PROP = "prop"
    EARTH = "earth"
    SUPPORT = "support"


@dataclass(frozen=True)
class Action:
    """Force and moment on one block per unit of a limited force."""

    block: int  #: index of the block in the scene; −1 if the force acts on the ground
    point: np.ndarray  #: point of action, relative to ``Geometry.origin``, shape (dim,)
    force: np.ndarray  #: force per unit of T, shape (dim,)
    #: Additional moment on the block per unit of T, shape (1,), in space (3,). The value 0 means no moment.
    couple: np.ndarray | float = 0.0

    __repr__ = brief


@dataclass(frozen=True)
class LimitedForce:
    """A force T with a lower and an upper limit, in the scene's unit of force."""

    role: Role  #: kind of force; T is positive for tension in a tie and for compression in a prop
    name: str  #: name of the force in results
    actions: tuple[Action, ...]  #: actions of the force on blocks, per unit of T
    lowest: float = -inf  #: lower limit of T
    highest: float = inf  #: upper limit of T

    __repr__ = brief


def columns(
    limited: Sequence[LimitedForce], centroid: np.ndarray, movable: np.ndarray, length_unit: float
) -> sp.csr_array:
    """Return the columns of the equilibrium matrix B for limited forces, shape (3b, t).

    ``centroid`` has the centroids of all blocks of the scene, ``movable`` the indices of those that can move,
    shape (b,).
    """
    dimension = centroid.shape[1]
    rows = dimension + moments_in(dimension)
    row_of = {int(block): rows * number for number, block in enumerate(movable)}
    matrix = sp.lil_array((rows * len(movable), len(limited)))
    for number, force in enumerate(limited):
        for action in force.actions:
            if action.block in row_of:
                arm = action.point - centroid[action.block]
                moment = moment_of(arm[None], action.force[None])[0] + action.couple
                entries = np.append(action.force, moment / length_unit)
                row = row_of[action.block]
                matrix[row : row + rows, [number]] += entries[:, None]
    return matrix.tocsr()


def struts(scene: Scene, shapes: Extents) -> list[LimitedForce]:
    """Return the limited forces of a scene's ties and props.

    Raises
    ------
    CaseError
        If an end does not lie in its block, or both ends are at one point.
    """
    # A fixed block named "ground" represents the whole ground. An end of a tie or prop on the ground may
    # therefore be outside this block.
    number_of = {
        block.name: number
        for number, block in enumerate(scene.blocks)
        if not block.fixed or block.name != GROUND
    }
    forces = []
    for number, strut in (*enumerate(scene.ties, start=1), *enumerate(scene.props, start=1)):
        role = Role.TIE if isinstance(strut, Tie) else Role.PROP
        ends = [number_of.get(name, -1) for name in strut.between]
        points = [np.array(point) - shapes.origin for point in strut.at]
        for name, block, point, location in zip(strut.between, ends, points, strut.at, strict=True):
            if block >= 0 and shapes.away(block, point) > shapes.tolerance:
                distances = [shapes.away(index, point) for index in range(len(scene.blocks))]
                touching = [
                    f"'{other.name}'"
                    for other, distance in zip(scene.blocks, distances, strict=True)
                    if distance <= shapes.tolerance
                ]
                here = " and ".join(touching)
                raise CaseError(
                    f"{scene.origin}: {role} no. {number} between {list(strut.between)}: the end "
                    f"{list(location)} of 'at' must be in block '{name}', but it is in {here or 'no block'}: "
                    f"choose a point in '{name}' or on its outline, or name this point's block in 'between'"
                )
        along = points[1] - points[0]
        length = np.linalg.norm(along)
        if length <= shapes.tolerance:
            raise CaseError(
                f"{scene.origin}: the {role} between {list(strut.between)} is shorter than the tolerance of "
                f"{rounded(shapes.tolerance)}: choose two distinct points in 'at'"
            )
        towards = (along if role is Role.TIE else -along) / length
        actions = (Action(ends[0], points[0], towards), Action(ends[1], points[1], -towards))
        lowest = strut.prestress if isinstance(strut, Tie) else 0.0
        highest = inf if strut.strength is None else strut.strength
        name = strut.name or f"{strut.between[0]}|{strut.between[1]}"
        forces.append(LimitedForce(role, name, actions, lowest, highest))
    return forces
