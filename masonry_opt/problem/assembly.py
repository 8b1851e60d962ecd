"""Assemble the limit analysis problem of a scene, without a loop over joints."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from masonry_opt.errors import CaseError, rounded
from masonry_opt.problem.displaced import moved
from masonry_opt.problem.fill import FilledPiece, fill_forces, filled_pieces, pressures
from masonry_opt.problem.laws import Law
from masonry_opt.problem.limited_forces import LimitedForce, struts
from masonry_opt.problem.loads import LoadedPiece, Loads, by_component, loaded_pieces, loads, resultants
from masonry_opt.problem.matrices import Matrices, shares
from masonry_opt.problem.names import ProblemNames, labels_of, legal_name
from masonry_opt.problem.problem import Problem
from masonry_opt.problem.settled import SettledState
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.contacts.joints import Joints, find_joints, shapes_of
from masonry_opt.scene.contacts.properties import joint_properties
from masonry_opt.scene.geometry import Extents
from masonry_opt.scene.scene import Scene

#: Attributes of a scene that determine the equilibrium matrices. If an attribute changes, the matrices are
#: assembled again.
_MATRIX_KEYS = ("gravity", "tolerance", "contact_tolerance", "thickness", "blocks", "fills", "ties", "props")
#: Attributes of a scene that determine the loads, but not the matrices. Attributes that are neither in this
#: list nor in ``_MATRIX_KEYS`` are joint properties, or do not affect the problem, such as the title.
_LOAD_KEYS = ("tilt", "edge_loads", "loads", "earthquake", "load_case")

#: Largest permitted limit of the force of a tie, a prop or earth pressure, relative to the unit of force. A
#: larger limit raises an error, because solvers would treat the loads as zero.
_LARGEST_LIMIT = 1e9


@dataclass(frozen=True)
class Assembly:
    """Limit analysis problem of a scene, together with the scene, its joints and the shapes of its blocks."""

    #: Matrices, loads and joint laws. The page "For solver people" of the guide describes its attributes.
    problem: Problem
    scene: Scene  #: the scene, without changes
    geometry: Any  #: shapes of the blocks: ``Geometry`` in the plane, ``Shapes`` in space
    joints: Joints  #: joints of the scene: their two blocks, points and directions
    movable: np.ndarray  #: index of each movable block in the scene's list of blocks, shape (b,)
    #: For each edge load, the length along its line on which the load has no effect, because there is no free
    #: edge of a movable block.
    bare_edge_loads: tuple[float, ...] = ()
    loaded_pieces: tuple[LoadedPiece, ...] = ()  #: pieces of edges on which edge loads act
    filled_pieces: tuple[FilledPiece, ...] = ()  #: pieces of edges that fills touch
    #: Forces with limits, such as the forces of ties, in the order of their columns in B.
    limited: tuple[LimitedForce, ...] = ()
    at_rest: "Assembly | None" = None  #: assembly before the supports settled; None if no support has settled

    def __repr__(self) -> str:
        sizes = repr(self.problem).removeprefix("<Problem of ")
        return f"<Assembly of {self.scene.called!r}:\n {sizes}"

    def names(self, blocks: np.ndarray) -> list[str]:
        """Return the names of blocks.

        Parameters
        ----------
        blocks: Indices of the blocks in the scene's list of blocks, shape (n,).

        Returns
        -------
        list of str
            Name of each block.
        """
        return [self.scene.blocks[index].name for index in blocks]

    def problem_names(self, legal: bool = False) -> ProblemNames:
        """Return names for the rows and columns of the problem's matrices, such as ``n1[A|ground]``.

        Parameters
        ----------
        legal: True for names that are legal in LP files.

        Returns
        -------
        ProblemNames
            Lists ``forces``, ``motions``, ``velocities``, ``balances`` and ``conditions``, in the order of
            the tables of a result.
        """
        blocks = [block.name for block in self.scene.blocks]
        limited = [force.name for force in self.limited]
        if legal:
            blocks, limited = [[legal_name(name) for name in names] for names in (blocks, limited)]
        ends = zip(self.joints.first[self.joint], self.joints.second[self.joint], strict=True)
        joints = [f"{blocks[first]}|{blocks[second]}" for first, second in ends]
        movable = [blocks[index] for index in self.movable]
        return ProblemNames(self.problem, *(labels_of(names, legal) for names in (joints, movable, limited)))

    @property
    def block_loads(self) -> Loads:
        """Return the weights, the further dead forces and the live forces on the movable blocks.

        If supports have settled, the forces act at the displaced points of action.
        """
        if self.at_rest is None:
            return loads(self.scene, self.geometry, self.movable)
        return _moved_loads(self.scene, self.at_rest, self.scene.settled)

    @property
    def joint(self) -> np.ndarray:
        """Return the index of the scene's joint to which each joint of the problem belongs, shape (c,).

        The indices are in ascending order. In space the problem's joints are contact points, and a joint of
        the scene has several contact points.
        """
        return self.joints.parts[0]

    @property
    def pressed(self) -> np.ndarray:
        """Return the indices of the contact points of each joint of the problem, shape (points, c).

        ``points`` is 2 in the plane, where a joint has a contact point at each end. In space it is 1.
        """
        return self.joints.parts[1]

    @property
    def of_point(self) -> np.ndarray:
        """Return the index of the problem's joint to which each contact point belongs."""
        of_point = np.empty(len(self.joints.joint), dtype=int)
        of_point[self.pressed] = np.arange(self.problem.joints)
        return of_point

    def joints_of(self, indices: np.ndarray) -> np.ndarray:
        """Return the indices of the scene's joints that contain given joints of the problem, each index once.

        In space, the problem's joints are contact points.
        """
        joints = self.joint[indices]
        return joints[np.sort(np.unique(joints, return_index=True)[1])]

    def most_of_joints(self, values: np.ndarray) -> np.ndarray:
        """Return, for each joint of the scene, the largest of the values at its contact points.

        ``values`` has one value for each joint of the problem. In space, the problem's joints are contact
        points.
        """
        return self.joints.most(values[self.of_point])

    def pairs(self, indices: np.ndarray) -> list[list[str]]:
        """Return the names of the two blocks at each of the given joints of the problem, without duplicates.

        ``indices`` contains the indices of the joints.
        """
        return self.pairs_of(self.joints_of(indices))

    def pairs_of(self, joints: np.ndarray) -> list[list[str]]:
        """Return the names of the two blocks at each of the given joints of the scene.

        ``joints`` contains the indices of the joints.
        """
        ends = np.column_stack([self.joints.first, self.joints.second])
        return [self.names(blocks) for blocks in ends[joints]]


def assemble(scene: Scene | str | Path, *, floating: bool = False) -> Assembly:
    """Find the joints of a scene, and assemble its limit analysis problem, eqs (1) to (6) of the paper.

    Parameters
    ----------
    scene: A scene, or the path of a case file.
    floating: True to accept movable blocks that touch no other block.

    Returns
    -------
    Assembly
        The scene, its joints, and ``problem``, which has the matrices.

    Raises
    ------
    CaseError
        If a block, joint, edge load or fill is wrong. If loads differ by more than double precision can
        represent. If the limit of a force is too large, relative to the loads, for solvers.
    """
    scene = as_scene(scene)
    shapes = shapes_of(scene)
    joints = find_joints(scene, shapes, floating=floating)
    assembly = _assembled(scene, shapes, joints, filled_pieces(scene, shapes))
    return assembly if scene.settled is None else _settled(assembly, scene.settled)


def on_matrices_of(assembly: Assembly, scene: Scene) -> Assembly | None:
    """Assemble the problem of a changed scene, and reuse the matrices of an earlier assembly.

    The scene may differ from the scene of ``assembly`` only in loads and joint properties. The result is
    None if anything else differs, or if supports of the scene have settled.

    Raises
    ------
    CaseError
        As :func:`assemble` does.
    """
    if scene.settled is not None or assembly.at_rest is not None:
        return None
    if any(getattr(scene, name) != getattr(assembly.scene, name) for name in _MATRIX_KEYS):
        return None
    joints, before = assembly.joints, assembly.problem
    joined, overlaps = (joints.first, joints.second), (joints.overlaps, joints.overlap_ratio)
    properties = joint_properties(scene, joined, overlaps, joints.gaps, joints.closing)
    joints = replace(joints, **properties)
    if any(getattr(scene, name) != getattr(assembly.scene, name) for name in _LOAD_KEYS):
        return _assembled(scene, assembly.geometry, joints, assembly.filled_pieces, before.matrices)
    problem = replace(before, law=_law(scene, joints, assembly.limited, before.force_unit))
    return replace(assembly, problem=problem, scene=scene, joints=joints)


def _assembled(
    scene: Scene,
    shapes: Any,
    joints: Joints,
    filled: tuple[FilledPiece, ...],
    matrices: Matrices | None = None,
) -> Assembly:
    """Assemble the problem of a scene whose joints are known.

    If ``matrices`` is passed, these equilibrium matrices are reused.
    """
    movable = np.flatnonzero(~scene.fixed)
    pieces, bare = loaded_pieces(scene, shapes, joints)
    limited = (*struts(scene, shapes), *pressures(scene, filled))
    if matrices is None:
        length_unit = _length_unit(joints, shapes, movable)
        matrices = Matrices.of(joints, shapes, movable, length_unit, limited)
    further_loads = resultants(shapes, pieces), fill_forces(scene, shapes, filled)
    block_loads = loads(scene, shapes, movable)
    dead, live, force_unit = _scaled_loads(scene, block_loads, shapes, movable, matrices, *further_loads)
    law = _law(scene, joints, limited, force_unit)
    problem = Problem(matrices, law, dead, live, force_unit)
    return Assembly(problem, scene, shapes, joints, movable, bare, pieces, filled, limited)


def _settled(at_rest: Assembly, state: SettledState) -> Assembly:
    """Return the assembly of a scene whose supports have settled.

    ``at_rest`` is the assembly before the settlement.
    """
    scene, movable, before = at_rest.scene, at_rest.movable, at_rest.problem
    joints = state.joints_of(scene, at_rest.joints)
    shapes = state.geometry(at_rest.geometry)
    pieces, filled = state.pieces(at_rest.loaded_pieces), state.pieces(at_rest.filled_pieces)
    limited = (*state.struts(at_rest.limited), *pressures(scene, filled))
    matrices = Matrices.of(joints, shapes, movable, before.length_unit, limited)
    block_loads = _moved_loads(scene, at_rest, state)
    further_loads = resultants(shapes, pieces), fill_forces(scene, shapes, filled)
    dead, live, force_unit = _scaled_loads(scene, block_loads, shapes, movable, matrices, *further_loads)
    law = _law(scene, joints, limited, force_unit)
    problem = Problem(matrices, law, dead, live, force_unit)
    if np.array_equal(before.dead, state.dead) and not problem.statics_fix_forces:
        of_limited = state.limited
        # Fill exerts no earth pressure on a level edge. If the settlement inclines the edge, there is a new
        # earth pressure, which ``state.limited`` does not contain. Load histories then start with all limited
        # forces at their lower limits.
        if len(of_limited) != len(limited):
            of_limited = problem.lowest_forces[len(state.forces) :]
        problem = replace(problem, settled=np.concatenate([state.forces, of_limited]))
    return Assembly(
        problem, scene, shapes, joints, movable, at_rest.bare_edge_loads, pieces, filled, limited, at_rest
    )


def _moved_loads(scene: Scene, at_rest: Assembly, state: SettledState) -> Loads:
    """Return the loads on the movable blocks, with points of action that have moved with the blocks.

    The scene may have other loads than the scene of the assembly ``at_rest``.
    """
    parts = loads(scene, at_rest.geometry, at_rest.movable)
    poses = state.poses[at_rest.movable]
    return Loads(*(moved(forces, poses) for forces in (parts.weight, parts.dead, parts.live)))


def _length_unit(joints: Joints, shapes: Extents, movable: np.ndarray) -> float:
    """Return the length, in the scene's unit, by which all lengths of the problem are divided."""
    # The unit of length is half the median joint length, or in space half the square root of the median joint
    # area. In the plane, a joint of median length then rocks at |m| = n, so moments and forces have equal
    # weight in an interior-point solver. A few very large or small blocks hardly change a median.
    extents = joints.extent[joints.extent > 0]
    joint_dimension = len(shapes.origin) - 1
    if len(extents) == 0:
        return float(np.median(shapes.width[movable])) / 2
    return float(np.median(extents) ** (1 / joint_dimension)) / 2


def _scaled_loads(
    scene: Scene,
    block_loads: Loads,
    shapes: Extents,
    movable: np.ndarray,
    matrices: Matrices,
    *further: Mapping[str, np.ndarray],
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the dimensionless dead load and live load, shape (3b,) each, and the unit of force.

    The unit of force is the median dead load of a block, or the median live load if there is no dead load.
    ``further`` are loads on all of the scene's blocks, by kind.
    """
    centroid = shapes.centroid[movable]
    dead = block_loads.dead.about(centroid) + block_loads.weight.about(centroid)
    live = block_loads.live.about(centroid)
    dead = dead + sum(load["dead"][movable].ravel() for load in further)
    live = live + sum(load["live"][movable].ravel() for load in further)
    force_unit = _force_unit(scene, matrices, dead, live)
    # Moments are measured in the unit of force times the unit of length.
    units_of_block = by_component(scene.dimension, force_unit, force_unit * matrices.length_unit)
    scale = np.tile(units_of_block, matrices.blocks)
    with np.errstate(over="ignore", invalid="ignore"):
        dead, live = dead / scale, live / scale
    if not (np.isfinite(dead).all() and np.isfinite(live).all()):
        raise CaseError(
            f"{scene.origin}: some loads, divided by the median block load of {rounded(force_unit)}, are too "
            "large for double precision: give weights and loads in the same unit"
        )
    return dead, live, force_unit


def _force_unit(scene: Scene, matrices: Matrices, *loads: np.ndarray) -> float:
    """Return the unit of force: the median force on a loaded block.

    The forces are those of the first nonzero load in ``loads``. The unit is 1 if all loads are zero.
    """
    for load in loads:
        sizes = np.hypot.reduce(matrices.by_block(load)[:, : scene.dimension], axis=1)
        if sizes.any():
            return float(np.median(sizes[sizes > 0]))
    return 1.0


def with_supports_freed(
    assembly: Assembly, scene: Scene, push: np.ndarray, restraints: Sequence[LimitedForce]
) -> Assembly:
    """Return the assembly of a scene in which some blocks that were fixed can move.

    Joints, dead loads and limited forces are those of the assembly. There are no joints between the freed
    blocks and other fixed blocks, and no dead loads on the freed blocks.

    Parameters
    ----------
    assembly : Assembly
        Assembly of the scene with all supports fixed.
    scene : Scene
        The scene with the freed blocks.
    push : ndarray, shape (2,) or (3,)
        Force at the centroid of each freed block. It is the only live load.
    restraints : sequence of LimitedForce
        Further limited forces.
    """
    before = assembly.problem
    joints = assembly.joints
    shapes = assembly.geometry
    movable = np.flatnonzero(~scene.fixed)
    limited = (*assembly.limited, *restraints)
    matrices = Matrices.of(joints, shapes, movable, before.length_unit, limited)
    dead, live = (np.zeros((len(movable), matrices.layout.rows)) for _ in range(2))
    was_movable = np.isin(movable, assembly.movable)
    dead[was_movable] = before.by_block(before.dead)
    live[~was_movable, : len(push)] = push / before.force_unit
    law = _law(scene, joints, limited, before.force_unit)
    problem = Problem(matrices, law, dead.ravel(), live.ravel(), before.force_unit)
    pieces = tuple(piece for piece in assembly.loaded_pieces if piece.kind == "dead")
    changed = replace(assembly, problem=problem, scene=scene, movable=movable)
    return replace(changed, loaded_pieces=pieces, limited=limited)


def _law(scene: Scene, joints: Joints, limited: Sequence[LimitedForce], force_unit: float) -> Law:
    """Return the joint law of a scene in dimensionless units.

    Raises CaseError if the limit of a force is too large, relative to the loads.
    """
    for force in limited:
        limit = force.lowest if np.isinf(force.highest) else force.highest
        if limit > _LARGEST_LIMIT * force_unit:
            raise CaseError(
                f"{scene.origin}: {force.role} '{force.name}' has the limit {rounded(limit)}, which is more "
                f"than {_LARGEST_LIMIT:.0e} times the median block load of {rounded(force_unit)}: check the "
                "unit of the limit, or omit 'strength' for a tie or prop that never yields"
            )
    lowest, highest = np.array([(force.lowest, force.highest) for force in limited]).reshape(-1, 2).T
    joint, _ = joints.parts
    # Compute the area on which the stresses of each contact act. A contact at a corner has no area, so its
    # dilatancy cannot depend on stress.
    section = shares(joints, joint) * scene.thickness
    is_corner = section == 0
    sliding = np.flatnonzero(np.isfinite(joints.friction[joint]))
    crushing = np.flatnonzero(np.isfinite(joints.strength[joint]) & ~is_corner)
    stressed_area = np.where(is_corner, 1.0, section)
    stress = np.where(is_corner[:, None], np.inf, joints.dilatancy_stress[joint])
    return Law(
        sliding=sliding,
        friction=joints.friction[joint][sliding],
        cohesion=(joints.cohesion[joint] * section / force_unit)[sliding],
        dilatancy=joints.dilatancy[joint][sliding],
        dilatancy_force=(stress * stressed_area[:, None] / force_unit)[sliding],
        crushing=crushing,
        crushing_force=joints.strength[joint][crushing] * section[crushing] / force_unit,
        lowest=lowest / force_unit,
        highest=highest / force_unit,
    )
