"""Joints and small gaps found in a scene before it is solved, and what looks unintended."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from masonry_opt.answer.sense import warnings_of
from masonry_opt.drawing.colours import GAP, JOINT, MARKED
from masonry_opt.drawing.marks import Marks, joint_marks
from masonry_opt.errors import CaseError, counted
from masonry_opt.problem.assembly import Assembly
from masonry_opt.scene.contacts.pairs import refuse_floating
from masonry_opt.words.sentences import sentences


def found_marks(assembly: Assembly, shrink: float) -> Iterable[Marks]:
    """Joints, corners that meet in no joint, and small gaps."""
    (ends, _), width = assembly.joints.lines(), 2.0 * shrink
    solid = assembly.scene.dimension == 3
    in_point = "joint in a point" if solid else "joint of a corner on an edge"
    corners, gaps = assembly.joints.meets, assembly.joints.facing
    yield from joint_marks(Marks("joint", "joint", "line", JOINT, width, ends), in_point)
    if len(corners):
        label = "corner on corner: no joint"
        yield Marks("corners", label, "cross", MARKED, 3.0 * width, corners[:, None])
    if len(gaps):
        yield Marks("gaps", "small gap: no joint", "line", GAP, 2.6, gaps, dashes=(1.6, 1.1))


def counts(assembly: Assembly) -> str:
    """Numbers of blocks, supports, joints, small gaps and edges that fill touches, in words."""
    movable = len(assembly.movable)
    numbers = {
        "block": movable,
        "support": len(assembly.scene.blocks) - movable,
        "joint": len(assembly.joints.first),
        "small gap": len(assembly.joints.gaps),
    }
    told = [(noun, number) for noun, number in numbers.items() if number or noun == "joint"]
    said = [counted(number, noun) for noun, number in told]
    if touched := len(assembly.filled_pieces):
        said.append(f"{counted(touched, 'edge')} touched by fill")
    return ", ".join(said)


def doubts(assembly: Assembly) -> Iterator[str]:
    """Sentences on blocks that touch nothing, which no analysis takes, and on what looks unintended."""
    scene, joints = assembly.scene, assembly.joints
    try:
        refuse_floating(scene, assembly.geometry, joints.first, joints.second, joints.gaps)
    except CaseError as error:
        yield str(error)
    yield from sentences(warnings_of(assembly, None))
