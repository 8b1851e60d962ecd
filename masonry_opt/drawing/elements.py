"""Elements of scenes and results: computed once, then drawn by pictures and pages alike."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely

from masonry_opt.drawing import forces
from masonry_opt.drawing.colours import (
    CRUSHING_COLOUR,
    GAP,
    HINGING_COLOUR,
    JOINT,
    MARKED,
    SEPARATING_COLOUR,
    SLIDING_COLOUR,
)
from masonry_opt.drawing.marks import Marks, joint_marks, moved, shrink_of, size_of
from masonry_opt.errors import counted, printable
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.reporting.sentences import numeral
from masonry_opt.reporting.stability import answer_line
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.motion import fastest, joint_motion
from masonry_opt.solution.outcome import Outcome
from masonry_opt.solution.reasons import Status

#: Kinds of pictures of a result. Each kind is named after the quantity that is drawn on the joints.
PICTURE_KINDS = ("mechanism", "thrust", "utilisation")

#: Largest displacement in the "full motion" of a drawn mechanism, relative to the scene's size. With a larger
#: value, mechanisms are magnified more.
FULL_MOTION = 0.1
#: Fraction of the full motion (see ``FULL_MOTION``) that pictures show. An HTML page shows this fraction when
#: it is opened.
SHOWN_MOTION_SHARE = 0.6
_MARGIN_AT_REST = 0.07  #: Free space around the movable blocks at rest, relative to the scene's size.
_PADDING = 0.02  #: Free space around moved blocks and marks, relative to the scene's size.
_TEXT = 0.15  #: Width of the text next to a scale bar, relative to the scene's size.


@dataclass(frozen=True)
class Elements:
    """Elements of a drawing of a scene or result: blocks, their motion, loads and marks on joints.

    Coordinates are in the case's unit of length, relative to the geometry's origin.
    """

    assembly: Assembly  #: assembly of the scene, with the shapes of the blocks
    heading: str  #: line below the scene's title
    movement: str  #: description of the motion for captions; "" if no block moves
    #: Full motion of each block of the scene (see ``FULL_MOTION``): displacement of the block's point at the
    #: origin, and rotation. The shape is (blocks, 3), in space (blocks, 6).
    motion: np.ndarray
    loads: list[Marks]  #: marks of loads and fill
    #: Marks on joints, by layer. An unsolved scene has the layer "scene". A result has one layer for each
    #: kind in ``PICTURE_KINDS`` for which it has data.
    layers: dict[str, list[Marks]]

    @property
    def title(self) -> str:
        """Return the title of the drawing."""
        return title_of(self.assembly.scene)

    @property
    def outline_width(self) -> float:
        """Return the width of the blocks' outlines in points, which is smaller if there are many blocks."""
        return float(np.clip(15 / np.sqrt(len(self.assembly.movable) or 1), 0.1, 0.8))

    @property
    def supports(self) -> np.ndarray:
        """Return the indices of the supports: fixed blocks, and blocks with prescribed settlements."""
        reactions = [force for force in self.assembly.limited if force.role is Role.SUPPORT]
        settling = np.array([action.block for force in reactions for action in force.actions], dtype=int)
        return np.union1d(np.flatnonzero(self.assembly.scene.fixed), settling)

    @property
    def all_marks(self) -> list[Marks]:
        """Return the marks of all layers and of the loads."""
        return [mark_group for marks in (*self.layers.values(), self.loads) for mark_group in marks]

    def shown(self, kind: str) -> list[Marks]:
        """Return the marks that a kind of picture shows.

        Pictures of a scene or a mechanism also show the loads.
        """
        return [*self.layers.get(kind, ()), *(self.loads if kind in ("scene", "mechanism") else ())]

    def box(self, marks: Iterable[Marks], share: float) -> np.ndarray:
        """Return the box of the drawn area: its lower left and upper right corners, shape (2, 2).

        The area contains movable blocks and marks, both at rest and after the fraction ``share`` of the full
        motion.
        """
        movable, size = self.assembly.movable, size_of(self.assembly)
        shapes = self.assembly.geometry.polygons[movable]
        corners, block = shapely.get_coordinates(shapes, return_index=True)
        points = [moved(corners, share * self.motion[movable][block])]
        for mark_group in marks:
            points += [mark_group.moved(part).reshape(-1, 2) for part in (0.0, share)]
            if mark_group.text:
                points.append(mark_group.points[:, -1] + [_TEXT * size, _PADDING * size])
        reach, pad = np.concatenate(points), _PADDING * size
        low = np.minimum(corners.min(axis=0) - _MARGIN_AT_REST * size, reach.min(axis=0) - pad)
        high = np.maximum(corners.max(axis=0) + _MARGIN_AT_REST * size, reach.max(axis=0) + pad)
        return np.array([low, high])


def title_of(scene: Scene) -> str:
    """Return the title of a scene, or its file name if the title is empty, followed by the load case."""
    case = f": {scene.load_case.name}" if scene.load_case else ""
    return printable((" ".join(scene.title.split()) or Path(scene.origin).stem) + case)


def legend(marks: Iterable[Marks]) -> dict[str, list[Marks]]:
    """Group marks by the label of their legend entry."""
    entries: dict[str, list[Marks]] = {}
    for mark_group in marks:
        if mark_group.label:
            entries.setdefault(mark_group.label, []).append(mark_group)
    return entries


def scene_elements(assembly: Assembly) -> Elements:
    """Return the elements of a drawing of an unsolved scene: blocks, joints, loads, ties and props."""
    no_motion = _still(assembly)
    arrows = list(forces.load_marks(assembly, no_motion))
    yields = np.zeros(len(assembly.scene.ties) + len(assembly.scene.props), dtype=bool)
    layers = {"scene": [*_joints(assembly), *forces.strut_marks(assembly, no_motion, yields)]}
    return Elements(assembly, counts(assembly), "", no_motion, arrows, layers)


def result_elements(result: Outcome) -> Elements:
    """Return the elements of a drawing of a result: blocks, motions, forces, loads, ties and props."""
    assembly, d, movement = result.assembly, result.solution.d, _movement(result)
    motion = _still(assembly) if d is None else motion_of(assembly, d, d)
    layers = {"mechanism": list(_mechanism(result, motion)) if movement else []}
    if result.joints["n"].notna().all():
        layers["thrust"] = [*forces.thrust_marks(result), *forces.pressure_marks(result)]
        layers["utilisation"] = list(forces.utilisation_marks(result))
    struts = list(forces.strut_marks(assembly, motion, result.ties["yields"].to_numpy(dtype=bool)))
    layers = {kind: [*marks, *struts] for kind, marks in layers.items()}
    arrows = list(forces.load_marks(assembly, motion, live=result.status.live_load_acts))
    return Elements(assembly, heading(result), movement, motion, arrows, layers)


def _still(assembly: Assembly) -> np.ndarray:
    """Return an array of zero motions for all blocks, shape (blocks, 3), in space (blocks, 6)."""
    return np.zeros((len(assembly.scene.blocks), assembly.problem.layout.rows))


def motion_of(assembly: Assembly, d: np.ndarray, full: np.ndarray) -> np.ndarray:
    """Convert displacements d, shape (3b,), to motions of all blocks of the scene, scaled for drawing.

    The scale is chosen so that the displacements ``full``, shape (3b,), become a full motion; see
    ``FULL_MOTION``.
    """
    problem, motion = assembly.problem, _still(assembly)
    centroid = assembly.geometry.centroid[assembly.movable]
    d = FULL_MOTION * size_of(assembly) / fastest(assembly, full) * d
    rates = np.column_stack([problem.forces(d), problem.moments(d) / problem.length_unit])
    # Convert the velocity of each block's centroid to the velocity of the block's point at the origin.
    rates[:, : centroid.shape[1]] = moved(-centroid, rates) + centroid
    motion[assembly.movable] = rates
    return motion


def _mechanism(result: Outcome, motion: np.ndarray) -> Iterable[Marks]:
    """Generate marks of the joints that separate, slide, crush or hinge in the mechanism.

    In the plane, a mark moves with the mean motion of the two blocks of its joint. In space, the outline of a
    joint is drawn twice, and each outline moves with one of the two blocks.
    """
    joints, shrink = result.assembly.joints, shrink_of(result.assembly)
    moves = joint_motion(result.assembly, result.solution)
    midway = (motion[joints.first] + motion[joints.second]) / 2
    (ends, joint), width = joints.lines(), 2.3 * shrink
    with_joint = midway[joint]
    looks = [
        ("separates", "separating joint", SEPARATING_COLOUR, width, moves.separates, (1.6, 1.1)),
        ("slides", "sliding joint", SLIDING_COLOUR, width, moves.slides, ()),
        ("crushes", "crushing joint", CRUSHING_COLOUR, width, moves.crushes, ()),
    ]
    if result.assembly.scene.dimension == 3:
        with_joint = np.concatenate([motion[joints.first[joint]], motion[joints.second[joint]]])
        ends, joint = np.tile(ends, (2, 1, 1)), np.tile(joint, 2)
        opens = moves.hinges & ~moves.slides
        looks.append(("opens", "hinging joint", HINGING_COLOUR, 0.4 * width, opens, ()))
    for name, label, colour, line_width, has_motion, dashes in looks:
        drawn = has_motion[joint]
        lines = Marks(name, label, "line", colour, line_width, ends[drawn], with_joint[drawn], dashes)
        yield from joint_marks(lines)
    # Mark crushing joints by crosses and hinging joints by dots, because grey prints show no colours.
    if moves.crushes.any():
        middle = ends[moves.crushes].mean(axis=1, keepdims=True)
        motions = midway[moves.crushes]
        yield Marks("crosses", "crushing joint", "cross", CRUSHING_COLOUR, 6.0 * shrink, middle, motions)
    if moves.hinges.any():
        point = moves.hinge[moves.hinges][:, None]
        motions = midway[moves.hinges]
        yield Marks("hinges", "hinging joint", "dot", HINGING_COLOUR, 5.2 * shrink, point, motions)


def _movement(result: Outcome) -> str:
    """Return a description of the motion that a drawing of a result shows, or "" if there is no motion."""
    if not result.blocks["vx"].notna().all():
        return ""
    if result.load_factor is not None:
        return "the mechanism of collapse, magnified"
    if result.status is Status.UNSTABLE:
        return "failure mechanism under the dead load, magnified"
    return "last motion of the analysis, magnified; no collapse was found"


def heading(result: Outcome) -> str:
    """Return a line with the load factor at collapse, or with the status if there is no load factor."""
    if result.load_factor is None:
        if result.status is Status.STABLE or not result.assembly.problem.live_norm:
            return answer_line(result)
        movement = _movement(result)
        shows_last_motion = movement and result.status is not Status.UNSTABLE
        drawn = f"; drawn: {movement}" if shows_last_motion else ""
        return f"no load factor ({result.status}){drawn}"
    load_factor = numeral(result.load_factor, ".6g")
    line = f"collapses at the load factor λ = {load_factor} (method {result.method})"
    tilt = result.tilt_angle
    if tilt is None:
        return line
    return f"falls if the ground is tilted by {numeral(tilt, '.2f')}° (λ = {load_factor}, {result.method})"


def _joints(assembly: Assembly) -> Iterable[Marks]:
    """Generate marks of joints, of corners that touch without forming a joint, and of small gaps."""
    (ends, _), width = assembly.joints.lines(), 2.0 * shrink_of(assembly)
    in_point = "joint in a point" if assembly.scene.dimension == 3 else "joint of a corner on an edge"
    yield from joint_marks(Marks("joint", "joint", "line", JOINT, width, ends), in_point)
    corners, gaps = assembly.joints.meets, assembly.joints.facing
    if len(corners):
        yield Marks("corners", "corner on corner: no joint", "cross", MARKED, 3.0 * width, corners[:, None])
    if len(gaps):
        yield Marks("gaps", "small gap: no joint", "line", GAP, 2.6, gaps, dashes=(1.6, 1.1))


def counts(assembly: Assembly) -> str:
    """Return a text with the numbers of blocks, supports, joints, small gaps, and edges that touch fill."""
    movable, joints = len(assembly.movable), assembly.joints
    numbers = {"block": movable, "support": len(assembly.scene.blocks) - movable}
    numbers |= {"joint": len(joints.first), "small gap": len(joints.gaps)}
    phrases = [counted(number, noun) for noun, number in numbers.items() if number or noun == "joint"]
    touched = len({piece.edge for piece in assembly.filled_pieces})
    if touched:
        phrases.append(f"{counted(touched, 'edge')} touched by fill")
    return ", ".join(phrases)
