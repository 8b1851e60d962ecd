"""Comment lines at the top of the files of other programs."""

from pathlib import Path

from masonry_opt.files import MARK
from masonry_opt.problem.assembly import Assembly
from masonry_opt.reporting.linear_laws import by_sides


def comments(mark: str, lines: list[str]) -> str:
    """Return the lines as one text, with the comment mark of the file format before each line."""
    return "".join(f"{mark} {line}\n" for line in lines)


def header(contents: str, assembly: Assembly) -> list[str]:
    """Return the comment lines for the top of an exported file, in ASCII.

    The lines state what the file contains, the case, the size of the problem, and the units.
    """
    problem, scene = assembly.problem, assembly.scene
    name = " ".join(f"{Path(scene.origin).name} {scene.title}".split())
    points = f", contact points: {problem.joints}" if problem.layout.round else ""
    friction = by_sides(problem.layout) if len(problem.sliding) else "unlimited"
    lines = [
        f"{MARK}: {contents} for {name}",
        f"movable blocks: {problem.blocks}, joints: {len(assembly.joints.first)}{points}",
        *([f"friction: {friction}"] if points else []),
        f"in this file, one unit of force is {problem.force_unit!r} and one unit of length is "
        f"{problem.length_unit!r}, in the units of the case; the load factor is the same as in the case",
    ]
    return [line.encode("ascii", "replace").decode() for line in lines]
