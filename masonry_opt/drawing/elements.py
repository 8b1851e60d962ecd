"""Scenes and results as elements: made once, and shown by pictures and pages alike."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely

from masonry_opt.answer.motion import fastest, joint_motion
from masonry_opt.answer.outcome import Outcome
from masonry_opt.answer.reasons import Status
from masonry_opt.drawing import forces
from masonry_opt.drawing.colours import CRUSHES, GAP, HINGES, JOINT, MARKED, SEPARATES, SLIDES
from masonry_opt.drawing.marks import Marks, joint_marks, moved, shrink_of, size_of
from masonry_opt.errors import counted, printable
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.scene.scene import Scene
from masonry_opt.words.sentences import numeral

KINDS = ("mechanism", "thrust", "utilisation")  #: Kinds of pictures of a result: what its joints show.

FULL = 0.1  #: Share of the scene's size by which the fastest corner of a full motion has moved.
START = 0.6  #: The share of a full motion that pictures show, and pages show first.
#: Shares of that size free round the movable blocks, round what moves or acts on them, for a bar's text.
_MARGIN, _PAD, _TEXT = 0.07, 0.02, 0.15


@dataclass(frozen=True)
class Elements:
    """A scene, or a result, as it is drawn, relative to the geometry's origin, in the case's units."""

    assembly: Assembly  #: of the scene; its polygons, or solids, are the blocks
    heading: str  #: a line below the scene's title
    movement: str  #: name of the motion; "" where nothing moves
    #: Full motion of the scene's blocks, as ``moved`` takes it, shape (blocks, 3) or (blocks, 6).
    motion: np.ndarray
    loads: list[Marks]  #: arrows of loads
    #: Marks on joints: "scene" before it is solved; of a result those of ``KINDS`` that are known.
    layers: dict[str, list[Marks]]

    @property
    def title(self) -> str:
        return title_of(self.assembly.scene)

    @property
    def outline_width(self) -> float:
        """Width of the blocks' outlines, in points: those of many small blocks must not hide the rest."""
        return float(np.clip(15 / np.sqrt(len(self.assembly.movable) or 1), 0.1, 0.8))

    @property
    def supports(self) -> np.ndarray:
        """Indices of the blocks that are supports: those that are fixed, and those that settle."""
        settles = [force for force in self.assembly.limited if force.role is Role.SUPPORT]
        supported = np.array([action.block for force in settles for action in force.actions], dtype=int)
        return np.union1d(np.flatnonzero(self.assembly.scene.fixed), supported)

    @property
    def all_marks(self) -> list[Marks]:
        """Marks of all layers, and loads."""
        return [each for marks in (*self.layers.values(), self.loads) for each in marks]

    def shown(self, kind: str) -> list[Marks]:
        """Marks of a picture of that kind: loads are shown with what moves under them."""
        return [*self.layers.get(kind, ()), *(self.loads if kind in ("scene", "mechanism") else ())]

    def box(self, marks: Iterable[Marks], share: float) -> np.ndarray:
        """Lower left and upper right of movable blocks and marks, at rest and after a share, shape (2, 2)."""
        movable, size = self.assembly.movable, size_of(self.assembly)
        shapes = self.assembly.geometry.polygons[movable]
        corners, number = shapely.get_coordinates(shapes, return_index=True)
        points = [moved(corners, share * self.motion[movable][number])]
        for each in marks:
            points += [each.moved(when).reshape(-1, 2) for when in (0.0, share)]
            if each.text:
                points.append(each.points[:, -1] + [_TEXT * size, _PAD * size])
        reach, pad = np.concatenate(points), _PAD * size
        low = np.minimum(corners.min(axis=0) - _MARGIN * size, reach.min(axis=0) - pad)
        high = np.maximum(corners.max(axis=0) + _MARGIN * size, reach.max(axis=0) + pad)
        return np.array([low, high])


def title_of(scene: Scene) -> str:
    """The scene's title, or the name of its file, and its load case, in one line."""
    case = f": {scene.load_case.name}" if scene.load_case else ""
    return printable((" ".join(scene.title.split()) or Path(scene.origin).stem) + case)


def legend(marks: Iterable[Marks]) -> dict[str, list[Marks]]:
    """Marks by what a legend says of them."""
    entries: dict[str, list[Marks]] = {}
    for each in marks:
        if each.label:
            entries.setdefault(each.label, []).append(each)
    return entries


def scene_elements(assembly: Assembly) -> Elements:
    """What there is to draw of a scene before it is solved."""
    still = _still(assembly)
    arrows = list(forces.load_marks(assembly, still))
    yields = np.zeros(len(assembly.scene.ties) + len(assembly.scene.props), dtype=bool)
    layers = {"scene": [*_found(assembly), *forces.strut_marks(assembly, still, yields)]}
    return Elements(assembly, counts(assembly), "", still, arrows, layers)


def result_elements(result: Outcome) -> Elements:
    """What there is to draw of a result."""
    assembly, d, movement = result.assembly, result.solution.d, _movement(result)
    motion = _still(assembly) if d is None else motion_of(assembly, d, d)
    layers = {"mechanism": list(_mechanism(result, motion)) if movement else []}
    if result.joints["n"].notna().all():
        layers["thrust"] = [*forces.thrust_marks(result), *forces.pressure_marks(result)]
        layers["utilisation"] = list(forces.utilisation_marks(result))
    held = list(forces.strut_marks(assembly, motion, result.ties["yields"].to_numpy(dtype=bool)))
    layers = {kind: [*marks, *held] for kind, marks in layers.items()}
    arrows = list(forces.load_marks(assembly, motion, live=result.status.live_load_acts))
    return Elements(assembly, heading(result), movement, motion, arrows, layers)


def _still(assembly: Assembly) -> np.ndarray:
    """Motions of all blocks that stay."""
    return np.zeros((len(assembly.scene.blocks), assembly.problem.layout.rows))


def motion_of(assembly: Assembly, d: np.ndarray, full: np.ndarray) -> np.ndarray:
    """Displacements d (3b,) as motions of the scene's blocks, in the scale in which ``full`` is full."""
    problem, motion = assembly.problem, _still(assembly)
    centroid = assembly.geometry.centroid[assembly.movable]
    d = FULL * size_of(assembly) / fastest(assembly, full) * d
    rates = np.column_stack([problem.forces(d), problem.moments(d) / problem.length_unit])
    # Of the point of each block that lies in the origin.
    rates[:, : centroid.shape[1]] = moved(-centroid, rates) + centroid
    motion[assembly.movable] = rates
    return motion


def _mechanism(result: Outcome, motion: np.ndarray) -> Iterable[Marks]:
    """Joints by how they move, midway between their blocks; in space outlines of joints with each block."""
    joints, shrink = result.assembly.joints, shrink_of(result.assembly)
    moves = joint_motion(result.assembly, result.solution)
    midway = (motion[joints.first] + motion[joints.second]) / 2
    (ends, joint), width = joints.lines(), 2.3 * shrink
    with_joint = midway[joint]
    looks = [
        ("separates", "separating joint", SEPARATES, width, moves.separates, (1.6, 1.1)),
        ("slides", "sliding joint", SLIDES, width, moves.slides, ()),
        ("crushes", "crushing joint", CRUSHES, width, moves.crushes, ()),
    ]
    if result.assembly.scene.dimension == 3:
        with_joint = np.concatenate([motion[joints.first[joint]], motion[joints.second[joint]]])
        ends, joint = np.tile(ends, (2, 1, 1)), np.tile(joint, 2)
        opens = moves.hinges & ~moves.slides
        looks.append(("opens", "hinging joint", HINGES, 0.4 * width, opens, ()))
    for name, label, colour, wide, of_joints, dashes in looks:
        which = of_joints[joint]
        lines = Marks(name, label, "line", colour, wide, ends[which], with_joint[which], dashes)
        yield from joint_marks(lines)
    # Colour alone cannot be told apart in grey.
    if (which := moves.crushes).any():
        middle = ends[which].mean(axis=1, keepdims=True)
        yield Marks("crosses", "crushing joint", "cross", CRUSHES, 6.0 * shrink, middle, midway[which])
    if (which := moves.hinges).any():
        at = moves.hinge[which][:, None]
        yield Marks("hinges", "hinging joint", "dot", HINGES, 5.2 * shrink, at, midway[which])


def _movement(result: Outcome) -> str:
    if not result.blocks["vx"].notna().all():
        return ""
    if result.load_factor is not None:
        return "the mechanism of collapse, magnified"
    if result.status is Status.UNSTABLE:
        return "how the scene falls under its dead load, magnified"
    return "the last motion tried, magnified: no collapse"


def heading(result: Outcome) -> str:
    """The load factor, or why there is none."""
    if result.load_factor is None:
        movement = _movement(result)
        tried = movement and result.status is not Status.UNSTABLE
        return f"no load factor ({result.status}){f'; drawn: {movement}' if tried else ''}"
    line = f"load factor λ = {numeral(result.load_factor, '.5f')} ({result.method})"
    tilt = result.tilt_angle
    return line if tilt is None else f"falls when tilted by {numeral(tilt, '.2f')}°: {line}"


def _found(assembly: Assembly) -> Iterable[Marks]:
    """Joints, corners that meet in no joint, and small gaps."""
    (ends, _), width = assembly.joints.lines(), 2.0 * shrink_of(assembly)
    in_point = "joint in a point" if assembly.scene.dimension == 3 else "joint of a corner on an edge"
    yield from joint_marks(Marks("joint", "joint", "line", JOINT, width, ends), in_point)
    if len(at := assembly.joints.meets):
        yield Marks("corners", "corner on corner: no joint", "cross", MARKED, 3.0 * width, at[:, None])
    if len(gaps := assembly.joints.facing):
        yield Marks("gaps", "small gap: no joint", "line", GAP, 2.6, gaps, dashes=(1.6, 1.1))


def counts(assembly: Assembly) -> str:
    """Numbers of blocks, supports, joints, small gaps and edges that fill touches, in words."""
    movable, joints = len(assembly.movable), assembly.joints
    numbers = {"block": movable, "support": len(assembly.scene.blocks) - movable}
    numbers |= {"joint": len(joints.first), "small gap": len(joints.gaps)}
    said = [counted(number, noun) for noun, number in numbers.items() if number or noun == "joint"]
    if touched := len({piece.edge for piece in assembly.filled_pieces}):
        said.append(f"{counted(touched, 'edge')} touched by fill")
    return ", ".join(said)
