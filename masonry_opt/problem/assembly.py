"""Scene to matrices, without a loop over joints."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from masonry_opt.errors import CaseError
from masonry_opt.problem import points
from masonry_opt.problem.edge_loads import LoadedPiece, edge_forces
from masonry_opt.problem.loads import loads
from masonry_opt.problem.matrices import Matrices
from masonry_opt.problem.problem import Law, Problem
from masonry_opt.scene.contact import Joints, find_joints, with_properties
from masonry_opt.scene.geometry import Geometry, geometry
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.space.contacts import Contacts, find_contacts
from masonry_opt.scene.space.contacts import with_properties as contacts_with_properties
from masonry_opt.scene.space.shapes import Shapes, shapes

#: Fields of a scene that matrices and loads depend on; the others are joint properties and words.
_OF_GEOMETRY = ("gravity", "tolerance", "thickness", "tilt", "blocks", "edge_loads", "loads")


@dataclass(frozen=True)
class Assembly:
    """Problem with the scene it came from, which gives results their names.

    Attributes
    ----------
    problem: the matrices.
    scene: the blocks and their names.
    geometry: polygons and centroids.
    joints: the joints found.
    movable: indices into the scene's blocks of the problem's blocks, shape (b,).
    bare_edge_loads: length of each edge load's line that meets no free edge of a movable block.
    loaded_pieces: pieces of edges on which edge loads act.
    """

    problem: Problem
    scene: Scene
    geometry: Geometry
    joints: Joints
    movable: np.ndarray
    bare_edge_loads: tuple[float, ...] = ()
    loaded_pieces: tuple[LoadedPiece, ...] = ()

    def names(self, blocks: np.ndarray) -> list[str]:
        """Names of blocks by their indices in the scene."""
        return [self.scene.blocks[index].name for index in blocks]

    @property
    def joint(self) -> np.ndarray:
        """Index of the joint that each of the problem's joints is part of, rising."""
        return np.arange(self.problem.joints)

    def joints_of(self, indices: np.ndarray) -> np.ndarray:
        """Indices of the joints that some of the problem's joints are part of, each once, in their order."""
        return indices

    def most_of_joints(self, values: np.ndarray) -> np.ndarray:
        """Of values of the problem's joints the largest within each joint."""
        return values

    def pairs(self, indices: np.ndarray) -> list[list[str]]:
        """Names of the two blocks of each of some of the problem's joints, by their indices."""
        return self.pairs_of(self.joints_of(indices))

    def pairs_of(self, joints: np.ndarray) -> list[list[str]]:
        """Names of the two blocks of each of some joints, by their indices."""
        ends = np.column_stack([self.joints.first, self.joints.second])
        return [self.names(blocks) for blocks in ends[joints]]


@dataclass(frozen=True)
class SpaceAssembly(Assembly):
    """The same in space, where the joints of the problem are contact points.

    Attributes
    ----------
    geometry: solids, their volumes and centroids.
    joints: polygons, edges and points of contact.
    """

    geometry: Shapes  # type: ignore[assignment]
    joints: Contacts  # type: ignore[assignment]

    @property
    def joint(self) -> np.ndarray:
        return self.joints.joint

    def joints_of(self, indices: np.ndarray) -> np.ndarray:
        joints = self.joints.joint[indices]
        return joints[np.sort(np.unique(joints, return_index=True)[1])]

    def most_of_joints(self, values: np.ndarray) -> np.ndarray:
        starts = np.searchsorted(self.joints.joint, np.arange(len(self.joints.first)))
        most: np.ndarray = np.maximum.reduceat(values, starts)
        return most


def assemble(scene: Scene, *, floating: bool = False) -> Assembly:
    """Find the joints of a scene and assemble eqs (1) to (6).

    Parameters
    ----------
    floating: whether blocks may touch nothing, or reach no support: to show them.

    Raises
    ------
    CaseError
        If a block, joint or edge load of the scene is wrong (see ``geometry``, ``find_joints`` and
        ``edge_forces``, in space ``shapes`` and ``find_contacts``), or loads differ by more than double
        precision carries.
    """
    return _in_space(scene, floating) if scene.dimension == 3 else _in_the_plane(scene, floating)


def _in_the_plane(scene: Scene, floating: bool) -> Assembly:
    shapes = geometry(scene)
    joints = find_joints(scene, shapes, floating=floating)
    movable = _movable(scene)
    on_edges, bare, pieces = edge_forces(scene, shapes, joints)
    given, centroid = loads(scene, shapes, movable), shapes.centroid[movable]
    dead = given.dead.about(centroid) + given.weight.about(centroid) + on_edges["dead"][movable].ravel()
    live = given.live.about(centroid) + on_edges["live"][movable].ravel()

    # With this unit rocking reads |m| ≤ n at a usual joint: moments weigh as much as forces in the
    # centre that an interior-point solver finds. It matters: see docs/limits.md. Medians, so
    # that a few odd blocks do not move it.
    in_a_point = joints.length == 0
    lengths = joints.length[~in_a_point]
    length_unit = float(np.median(lengths) if len(lengths) else np.sqrt(np.median(shapes.area[movable]))) / 2
    dead, live, force_unit = _scaled(scene, dead, live, length_unit)
    matrices = Matrices(
        B=_equilibrium(joints, shapes, movable, len(scene.blocks), length_unit),
        half_length=np.where(in_a_point, 1.0, joints.length / 2 / length_unit),
        length_unit=length_unit,
    )
    problem = Problem(matrices, _law(joints, scene.thickness, force_unit), dead, live, force_unit)
    return Assembly(problem, scene, shapes, joints, movable, bare, pieces)


def _in_space(scene: Scene, floating: bool) -> Assembly:
    solids = shapes(scene)
    contacts = find_contacts(scene, solids, floating=floating)
    movable = _movable(scene)
    given, centroid = loads(scene, solids, movable), solids.centroid[movable]
    areas = contacts.area[contacts.area > 0]
    usual = np.sqrt(np.median(areas)) if len(areas) else np.cbrt(np.median(solids.volume[movable]))
    length_unit = float(usual) / 2
    dead = given.dead.about(centroid) + given.weight.about(centroid)
    dead, live, force_unit = _scaled(scene, dead, given.live.about(centroid), length_unit)
    matrices = points.matrices(contacts, solids, movable, length_unit)
    problem = Problem(matrices, points.law(contacts, force_unit), dead, live, force_unit)
    return SpaceAssembly(problem, scene, solids, contacts, movable)


def _movable(scene: Scene) -> np.ndarray:
    return np.flatnonzero([not block.fixed for block in scene.blocks])


def _scaled(
    scene: Scene, dead: np.ndarray, live: np.ndarray, length_unit: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """Dead and live loads in units of force and length, and the unit of force: the median dead load of a
    block, or live load where there is none."""
    rows, dimension = (6, 3) if scene.dimension == 3 else (3, 2)
    sizes = (np.hypot.reduce(load.reshape(-1, rows)[:, :dimension], axis=1) for load in (dead, live))
    force_unit = next(filter(None, map(_median_of_positive, sizes)), 1.0)
    # Moments are forces times lengths.
    of_block = np.repeat([force_unit, force_unit * length_unit], [dimension, rows - dimension])
    scale = np.tile(of_block, len(dead) // rows)
    with np.errstate(over="ignore", invalid="ignore"):
        dead, live = dead / scale, live / scale
    if not (np.isfinite(dead).all() and np.isfinite(live).all()):
        raise CaseError(
            f"{scene.origin}: loads differ by more than double precision carries: the median block's is "
            f"{force_unit:.3g}; give weights and loads in one unit"
        )
    return dead, live, force_unit


def with_joints_of(assembly: Assembly, scene: Scene) -> Assembly | None:
    """Assembly of a scene that differs in joint properties alone, with the same matrices; None if anything
    else differs.

    Raises CaseError if an exception names two blocks that do not touch.
    """
    if any(getattr(scene, name) != getattr(assembly.scene, name) for name in _OF_GEOMETRY):
        return None
    force_unit = assembly.problem.force_unit
    if isinstance(assembly, SpaceAssembly):
        contacts = contacts_with_properties(assembly.joints, scene)
        problem = replace(assembly.problem, law=points.law(contacts, force_unit))
        return replace(assembly, problem=problem, scene=scene, joints=contacts)
    joints = with_properties(assembly.joints, scene)
    law = _law(joints, scene.thickness, force_unit)
    return replace(assembly, problem=replace(assembly.problem, law=law), scene=scene, joints=joints)


def _law(joints: Joints, thickness: float, force_unit: float) -> Law:
    in_a_point = joints.length == 0
    sliding = np.flatnonzero(np.isfinite(joints.friction))
    crushing = np.flatnonzero(np.isfinite(joints.strength) & ~in_a_point)
    # The area that stresses act on. A corner has none: its dilatancy does not depend on stress.
    section = joints.length * thickness
    acts_on = np.where(in_a_point, 1.0, section)
    stress = np.where(in_a_point[:, None], np.inf, joints.dilatancy_stress)
    return Law(
        sliding=sliding,
        friction=joints.friction[sliding],
        cohesion=(joints.cohesion * section / force_unit)[sliding],
        dilatancy=joints.dilatancy[sliding],
        dilatancy_force=(stress * acts_on[:, None] / force_unit)[sliding],
        crushing=crushing,
        crushing_force=joints.strength[crushing] * section[crushing] / force_unit,
    )


def _median_of_positive(values: np.ndarray) -> float:
    return float(np.median(values[values > 0])) if (values > 0).any() else 0.0


def _equilibrium(
    joints: Joints, shapes: Geometry, movable: np.ndarray, blocks: int, length_unit: float
) -> sp.csr_array:
    """B with lengths in ``length_unit``: joint forces act on the first block as they are, on the
    second reversed. Joints without length carry no moment."""
    count = len(joints.first)
    # Normal into the first block; tangent a quarter turn clockwise of it.
    normal = joints.normal
    tangent = np.column_stack([normal[:, 1], -normal[:, 0]])
    row_of = np.full(blocks, -1)
    row_of[movable] = np.arange(len(movable))
    rows, columns, values = [], [], []
    for block, sign in ((joints.first, 1.0), (joints.second, -1.0)):
        arm = (joints.middle - shapes.centroid[block]) / length_unit
        for column, force in enumerate((normal, tangent)):
            moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
            for component, value in enumerate((force[:, 0], force[:, 1], moment)):
                rows.append(3 * row_of[block] + component)
                columns.append(column * count + np.arange(count))
                values.append(sign * value)
        turns = np.flatnonzero(joints.length > 0)
        rows.append(3 * row_of[block[turns]] + 2)
        columns.append(2 * count + turns)
        values.append(np.full(len(turns), sign))
    row, col, entry = map(np.concatenate, (rows, columns, values))
    # Fixed blocks have no rows; exact zeros (axis-aligned joints) stay out of the pattern.
    kept = (row >= 0) & (entry != 0)
    shape = (3 * len(movable), 3 * count)
    return sp.csr_array((entry[kept], (row[kept], col[kept])), shape=shape)
