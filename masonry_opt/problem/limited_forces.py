"""Limited forces: each a column of B on a line of its own, with two faces, ``T − lowest ≥ 0`` and
``highest − T ≥ 0``, and no friction."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import inf

import numpy as np
import scipy.sparse as sp

from masonry_opt.errors import CaseError
from masonry_opt.problem.loads import moment_of, moments_in
from masonry_opt.scene.geometry import Extents
from masonry_opt.scene.loads import GROUND, Tie
from masonry_opt.scene.scene import Scene


class Role(StrEnum):
    """What exerts a limited force."""

    TIE = "tie"
    PROP = "prop"
    EARTH = "earth"
    SUPPORT = "support"


@dataclass(frozen=True)
class Action:
    """What one unit of a limited force does to a block."""

    block: int  #: index in the scene's blocks; −1 is the ground
    point: np.ndarray  #: where it acts, relative to the origin of the shapes, shape (dim,)
    force: np.ndarray  #: shape (dim,)
    couple: np.ndarray | float = 0.0  #: moment beside that of the force, shape (1,), in space (3,), or none


@dataclass(frozen=True)
class LimitedForce:
    """A force T within limits, in the scene's unit of force."""

    role: Role  #: T > 0 is tension of a tie, compression of a prop
    name: str  #: what results call it
    actions: tuple[Action, ...]  #: on each of its blocks
    lowest: float = -inf  #: limits of T
    highest: float = inf


def columns(
    limited: Sequence[LimitedForce], centroid: np.ndarray, movable: np.ndarray, length_unit: float
) -> sp.csr_array:
    """Columns of B, shape (3b, t), from centroids of all blocks and indices of those that move, (b,)."""
    dimension = centroid.shape[1]
    rows = dimension + moments_in(dimension)
    row_of = {int(block): rows * row for row, block in enumerate(movable)}
    found = sp.lil_array((rows * len(movable), len(limited)))
    for number, force in enumerate(limited):
        for action in force.actions:
            if action.block in row_of:
                arm = action.point - centroid[action.block]
                moment = moment_of(arm[None], action.force[None])[0] + action.couple
                entries, at = np.append(action.force, moment / length_unit), row_of[action.block]
                found[at : at + rows, [number]] += entries[:, None]
    return found.tocsr()


def struts(scene: Scene, shapes: Extents) -> list[LimitedForce]:
    """The ties and props of a scene. Raises CaseError if an end is not in its block, or both in one place."""
    # The ground reaches farther than a fixed block that was drawn for it.
    number_of = {one.name: row for row, one in enumerate(scene.blocks) if not one.fixed or one.name != GROUND}
    found = []
    for number, strut in (*enumerate(scene.ties, start=1), *enumerate(scene.props, start=1)):
        role = Role.TIE if isinstance(strut, Tie) else Role.PROP
        ends = [number_of.get(name, -1) for name in strut.between]
        points = [np.array(point) - shapes.origin for point in strut.at]
        for name, block, point, given in zip(strut.between, ends, points, strut.at, strict=True):
            if block >= 0 and shapes.away(block, point) > shapes.tolerance:
                away = {one.name: shapes.away(row, point) for row, one in enumerate(scene.blocks)}
                here = " and ".join(f"'{one}'" for one, far in away.items() if far <= shapes.tolerance)
                raise CaseError(
                    f"{scene.origin}: {role} no. {number} between {list(strut.between)}: the end "
                    f"{list(given)} of 'at' does not lie in block '{name}' but in {here or 'none'}: give a "
                    f"point inside '{name}' or on its outline, or in 'between' the block that it lies in"
                )
        along = points[1] - points[0]
        length = np.linalg.norm(along)
        if length <= shapes.tolerance:
            raise CaseError(
                f"{scene.origin}: {role} between {list(strut.between)}: its two ends are nearer than the "
                f"tolerance, {shapes.tolerance:.3g}: give two points of its line"
            )
        towards = (along if role is Role.TIE else -along) / length
        actions = tuple(Action(b, p, f) for b, p, f in zip(ends, points, (towards, -towards), strict=True))
        lowest = strut.prestress if isinstance(strut, Tie) else 0.0
        highest = inf if strut.strength is None else strut.strength
        name = strut.name or f"{strut.between[0]}|{strut.between[1]}"
        found.append(LimitedForce(role, name, actions, lowest, highest))
    return found
