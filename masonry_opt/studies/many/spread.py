"""Properties of joints that differ from joint to joint: what is drawn for which, and the scene it makes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from masonry_opt.errors import OptionError
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.blocks import Joint
from masonry_opt.scene.scene import Scene

#: Over what a joint property is drawn: once for all, for every course, for every joint.
BY = ("scene", "course", "joint")

#: Middles of joints nearer in height than this share of the median length of a joint are of one course.
_LEVEL = 1e-3

#: Properties that an exception can have.
_PROPERTIES = ("friction", "cohesion", "dilatancy", "strength")


@dataclass(frozen=True)
class Unit:
    """Joints that have one drawn value: their column's name, their pairs of blocks and their course."""

    name: str
    pairs: tuple[tuple[str, str], ...]
    course: int


class Spread:
    """One property of the joints of a scene, drawn by joint or by course.

    A course are the joints whose middles lie at one height (against gravity), 1 the lowest. Joints whose
    exception gives the property keep it.

    Parameters
    ----------
    scene: the scene.
    name: of the property, such as "joints.friction".
    by: "course" or "joint".
    correlation: of joints (of the same course), from 0 to 1; with 1 a course has one value.

    Raises
    ------
    OptionError
        If it is no property of joints, or no joint is left to draw for.
    CaseError
        If the scene is wrong.
    """

    def __init__(self, scene: Scene, name: str, by: str, correlation: float) -> None:
        head, _, self.property = name.partition(".")
        if head != "joints" or self.property not in _PROPERTIES:
            known = ", ".join(f"joints.{known}" for known in _PROPERTIES)
            raise OptionError(f"'{name}' cannot differ by {by}: only {known} can")
        given = {
            frozenset(exception.between)
            for exception in scene.exceptions
            if getattr(exception, self.property) is not None
        }
        courses = {pair: course for pair, course in _courses(scene).items() if frozenset(pair) not in given}
        if not courses:
            raise OptionError(f"'{name}': every joint has its own already: there is none to draw for")
        if by == "course" and correlation == 1:
            numbers = sorted(set(courses.values()))
            self.units = [
                Unit(
                    f"course.{number}.{self.property}",
                    tuple(pair for pair, course in courses.items() if course == number),
                    number,
                )
                for number in numbers
            ]
        else:
            self.units = [
                Unit(f"joint.{'/'.join(pair)}.{self.property}", (pair,), course)
                for pair, course in courses.items()
            ]
        self.groups = self._groups(by)

    def _groups(self, by: str) -> list[list[int]]:
        """Numbers of the units that are correlated."""
        if by == "joint":
            return [list(range(len(self.units)))]
        numbers = sorted({unit.course for unit in self.units})
        return [[k for k, unit in enumerate(self.units) if unit.course == number] for number in numbers]


def with_values(scene: Scene, spreads: list[Spread], values: Mapping[str, float]) -> Scene:
    """The scene with what was drawn for its joints, by the names of the units.

    Raises CaseError if a value is out of range, or dilatancy exceeds friction.
    """
    given = {
        exception.between: exception.model_dump(exclude={"between"}, exclude_none=True)
        for exception in scene.exceptions
    }
    order = {frozenset(between): between for between in given}
    for spread in spreads:
        for unit in spread.units:
            for pair in unit.pairs:
                between = order.setdefault(frozenset(pair), pair)
                given.setdefault(between, {})[spread.property] = values[unit.name]
    exceptions = [Joint(between=between, **properties) for between, properties in given.items()]
    for exception in exceptions:
        exception.over(scene.joints)
    return scene.model_copy(update={"exceptions": exceptions})


def _courses(scene: Scene) -> dict[tuple[str, str], int]:
    """Courses by pairs of blocks that touch, in the order of the joints."""
    assembly = assemble(scene)
    joints = assembly.joints
    height = joints.middle @ (-np.array(scene.gravity) / np.hypot(*scene.gravity))
    lengths = joints.length[joints.length > 0]
    apart = _LEVEL * float(np.median(lengths) if len(lengths) else 1.0)
    order = np.argsort(height, kind="stable")
    rises = np.diff(height[order], prepend=height[order[:1]]) > apart
    course = np.empty(len(height), dtype=int)
    course[order] = 1 + np.cumsum(rises)
    found: dict[tuple[str, str], int] = {}
    for first, second, number in zip(
        assembly.names(joints.first), assembly.names(joints.second), course.tolist(), strict=True
    ):
        if (second, first) not in found:
            found.setdefault((first, second), number)
    return found
