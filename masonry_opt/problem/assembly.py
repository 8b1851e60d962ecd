"""Scene to matrices, without a loop over joints."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from masonry_opt.errors import CaseError
from masonry_opt.problem.fill import FilledPiece, fill_forces, filled_pieces, pressures
from masonry_opt.problem.laws import Law
from masonry_opt.problem.limited_forces import LimitedForce, struts
from masonry_opt.problem.loads import LoadedPiece, by_component, loaded_pieces, loads, resultants
from masonry_opt.problem.matrices import Matrices, shares
from masonry_opt.problem.problem import Problem
from masonry_opt.scene.contacts.joints import Joints, find_joints, joint_properties, shapes_of
from masonry_opt.scene.geometry import Extents
from masonry_opt.scene.scene import Scene

#: What of a scene matrices depend on, and what loads do beside it; the rest are joint properties and words.
_OF_GEOMETRY = ("gravity", "tolerance", "contact_tolerance", "thickness", "blocks", "fills", "ties", "props")
_OF_LOADS = ("tilt", "edge_loads", "loads", "earthquake", "load_case")

#: Largest limit of a force, over the unit of force: with more, solvers no longer tell loads from nothing.
_LARGEST = 1e9


@dataclass(frozen=True)
class Assembly:
    """A problem with the scene it came from, the shapes of its blocks and the joints found."""

    problem: Problem
    scene: Scene
    geometry: Any  #: :class:`~masonry_opt.scene.geometry.Geometry`, in space ``Shapes``
    joints: Joints
    movable: np.ndarray  #: indices into the scene's blocks of the problem's blocks, shape (b,)
    #: Length of each edge load's line that meets no free edge of a movable block.
    bare_edge_loads: tuple[float, ...] = ()
    loaded_pieces: tuple[LoadedPiece, ...] = ()  #: pieces of edges on which edge loads act
    filled_pieces: tuple[FilledPiece, ...] = ()  #: pieces of edges that fills touch
    limited: tuple[LimitedForce, ...] = ()  #: the limited forces, in the order of their columns

    def names(self, blocks: np.ndarray) -> list[str]:
        """Names of blocks by their indices in the scene."""
        return [self.scene.blocks[index].name for index in blocks]

    @property
    def joint(self) -> np.ndarray:
        """Index of the joint that each of the problem's joints is part of, rising."""
        return self.joints.parts[0]

    @property
    def pressed(self) -> np.ndarray:
        """Contact points at which each of the problem's joints presses, shape (points, c)."""
        return self.joints.parts[1]

    @property
    def of_point(self) -> np.ndarray:
        """Index of the problem's joint that each contact point is part of, rising."""
        of_point = np.empty(len(self.joints.joint), dtype=int)
        of_point[self.pressed] = np.arange(self.problem.joints)
        return of_point

    def joints_of(self, indices: np.ndarray) -> np.ndarray:
        """Indices of the joints that some of the problem's joints are part of, each once, in their order."""
        joints = self.joint[indices]
        return joints[np.sort(np.unique(joints, return_index=True)[1])]

    def most_of_joints(self, values: np.ndarray) -> np.ndarray:
        """Of values of the problem's joints the largest within each joint."""
        return self.joints.most(values[self.of_point])

    def pairs(self, indices: np.ndarray) -> list[list[str]]:
        """Names of the two blocks of each of some of the problem's joints, by their indices."""
        return self.pairs_of(self.joints_of(indices))

    def pairs_of(self, joints: np.ndarray) -> list[list[str]]:
        """Names of the two blocks of each of some joints, by their indices."""
        ends = np.column_stack([self.joints.first, self.joints.second])
        return [self.names(blocks) for blocks in ends[joints]]


def assemble(scene: Scene, *, floating: bool = False) -> Assembly:
    """Find the joints of a scene and assemble eqs (1) to (6). Raises CaseError if a block, joint, edge load
    or fill is wrong (see ``geometry``, in space ``shapes``, ``find_joints``, also for ``floating``,
    ``loaded_pieces``, ``filled_pieces``), loads differ by more than double precision carries, or the limit of
    a force is more than solvers can set beside the loads."""
    shapes = shapes_of(scene)
    joints = find_joints(scene, shapes, floating=floating)
    return _assembled(scene, shapes, joints, filled_pieces(scene, shapes))


def on_matrices_of(assembly: Assembly, scene: Scene) -> Assembly | None:
    """Assembly of a scene that differs in loads and joint properties alone, with the same matrices; None if
    anything else differs. Raises CaseError as :func:`assemble` does."""
    if any(getattr(scene, name) != getattr(assembly.scene, name) for name in _OF_GEOMETRY):
        return None
    joints, before = assembly.joints, assembly.problem
    ends, gaps = (joints.first, joints.second), (joints.gaps, joints.joining_tolerance)
    joints = replace(joints, **joint_properties(scene, *ends, *gaps))
    if any(getattr(scene, name) != getattr(assembly.scene, name) for name in _OF_LOADS):
        return _assembled(scene, assembly.geometry, joints, assembly.filled_pieces, before.matrices)
    problem = replace(before, law=_law(scene, joints, assembly.limited, before.force_unit))
    return replace(assembly, problem=problem, scene=scene, joints=joints)


def _assembled(
    scene: Scene, shapes: Any, joints: Joints, filled: tuple[FilledPiece, ...], given: Matrices | None = None
) -> Assembly:
    movable = np.flatnonzero(~scene.fixed)
    pieces, bare = loaded_pieces(scene, shapes, joints)
    limited = (*struts(scene, shapes), *pressures(scene, filled))
    matrices = given or Matrices.of(joints, shapes, movable, _length_unit(joints, shapes, movable), limited)
    beside = resultants(shapes, pieces), fill_forces(scene, shapes, filled)
    dead, live, force_unit = _loaded(scene, shapes, movable, matrices, *beside)
    law = _law(scene, joints, limited, force_unit)
    problem = Problem(matrices, law, dead, live, force_unit)
    return Assembly(problem, scene, shapes, joints, movable, bare, pieces, filled, limited)


def _length_unit(joints: Joints, shapes: Extents, movable: np.ndarray) -> float:
    # With this unit rocking reads |m| ≤ n at a usual joint: moments weigh as much as forces in the centre
    # that an interior-point solver finds (see docs/limits.md). A few odd blocks do not move a median.
    extents, across = joints.extent[joints.extent > 0], len(shapes.origin) - 1
    usual = np.median(extents) ** (1 / across) if len(extents) else np.median(shapes.width[movable])
    return float(usual) / 2


def _loaded(
    scene: Scene, shapes: Extents, movable: np.ndarray, matrices: Matrices, *beside: Mapping[str, np.ndarray]
) -> tuple[np.ndarray, np.ndarray, float]:
    """Dead and live loads in units of force and length, with those on all blocks beside, by kind; and the
    unit of force: the median dead load of a block, or live load where there is none."""
    given, centroid = loads(scene, shapes, movable), shapes.centroid[movable]
    dead, live = given.dead.about(centroid) + given.weight.about(centroid), given.live.about(centroid)
    dead = dead + sum(of["dead"][movable].ravel() for of in beside)
    live = live + sum(of["live"][movable].ravel() for of in beside)
    forces = (matrices.by_block(load)[:, : scene.dimension] for load in (dead, live))
    sizes = (np.hypot.reduce(force, axis=1) for force in forces)
    force_unit = next((float(np.median(size[size > 0])) for size in sizes if size.any()), 1.0)
    # Moments are forces times lengths.
    of_block = by_component(scene.dimension, force_unit, force_unit * matrices.length_unit)
    scale = np.tile(of_block, matrices.blocks)
    with np.errstate(over="ignore", invalid="ignore"):
        dead, live = dead / scale, live / scale
    if not (np.isfinite(dead).all() and np.isfinite(live).all()):
        raise CaseError(
            f"{scene.origin}: loads differ by more than double precision carries: the median block's is "
            f"{force_unit:.3g}; give weights and loads in one unit"
        )
    return dead, live, force_unit


def with_supports_freed(
    assembly: Assembly, scene: Scene, push: np.ndarray, restraints: Sequence[LimitedForce]
) -> Assembly:
    """Assembly of a scene in which some fixed blocks can move, with the same joints (none between these and
    other fixed blocks), dead loads (none on these) and limited forces, beside which restraints act. A push at
    the centroid of each of these, shape (2,) or (3,), is the only live load."""
    before, movable, joints = assembly.problem, np.flatnonzero(~scene.fixed), assembly.joints
    shapes = assembly.geometry
    limited = (*assembly.limited, *restraints)
    matrices = Matrices.of(joints, shapes, movable, before.length_unit, limited)
    dead, live = (np.zeros((len(movable), matrices.layout.rows)) for _ in range(2))
    others = np.isin(movable, assembly.movable)
    dead[others] = before.by_block(before.dead)
    live[~others, : len(push)] = push / before.force_unit
    law = _law(scene, joints, limited, before.force_unit)
    problem = Problem(matrices, law, dead.ravel(), live.ravel(), before.force_unit)
    pieces = tuple(one for one in assembly.loaded_pieces if one.kind == "dead")
    changed = replace(assembly, problem=problem, scene=scene, movable=movable)
    return replace(changed, loaded_pieces=pieces, limited=limited)


def _law(scene: Scene, joints: Joints, limited: Sequence[LimitedForce], force_unit: float) -> Law:
    for force in limited:
        most = force.lowest if np.isinf(force.highest) else force.highest
        if most > _LARGEST * force_unit:
            raise CaseError(
                f"{scene.origin}: {force.role} '{force.name}': its limit, {most:.3g}, is more than "
                f"{_LARGEST:.0e} times the median block's load, {force_unit:.3g}: check its unit; a "
                "tie or prop that never yields needs no 'strength'"
            )
    lowest, highest = np.array([(force.lowest, force.highest) for force in limited]).reshape(-1, 2).T
    joint, _ = joints.parts
    # The area that stresses act on. A corner has none: its dilatancy does not depend on stress.
    section = shares(joints, joint) * scene.thickness
    in_a_point = section == 0
    sliding = np.flatnonzero(np.isfinite(joints.friction[joint]))
    crushing = np.flatnonzero(np.isfinite(joints.strength[joint]) & ~in_a_point)
    acts_on = np.where(in_a_point, 1.0, section)
    stress = np.where(in_a_point[:, None], np.inf, joints.dilatancy_stress[joint])
    return Law(
        sliding=sliding,
        friction=joints.friction[joint][sliding],
        cohesion=(joints.cohesion[joint] * section / force_unit)[sliding],
        dilatancy=joints.dilatancy[joint][sliding],
        dilatancy_force=(stress * acts_on[:, None] / force_unit)[sliding],
        crushing=crushing,
        crushing_force=joints.strength[joint][crushing] * section[crushing] / force_unit,
        lowest=lowest / force_unit,
        highest=highest / force_unit,
    )
