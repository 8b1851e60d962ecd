"""Passages of a crossing: groups of axles that move over a scene, in each direction and load case."""

from collections.abc import Sequence
from itertools import groupby

from masonry_opt.errors import CaseError, OptionError
from masonry_opt.finite_motion.settled_state import settled_scene
from masonry_opt.problem.assembly import Assembly, assemble, on_matrices_of
from masonry_opt.problem.fill import Road
from masonry_opt.problem.settled import Movements
from masonry_opt.scene.blocks import Point
from masonry_opt.scene.mistakes import did_you_mean
from masonry_opt.scene.road import Axles
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.crossing import search

#: Type of the argument ``axles``: records of axles, or the name of a group of axles of the scene.
AxlesArgument = str | Axles | Sequence[Axles] | None


def passages_of(
    scene: Scene, axles: AxlesArgument, settled: Movements | None = None
) -> tuple[list[list[search.Passage]], tuple[str, ...]]:
    """Return all passages of axles along the road, and the names of the load cases without axles.

    The passages are lists: one list for each group of axles and direction, with one passage for each load
    case. Raises CaseError if the scene cannot be crossed.
    """
    if scene.tilt:
        raise CaseError(f"{scene.origin}: axles cannot be combined with a tilted ground: remove 'tilt'")
    if scene.earthquake:
        raise CaseError(f"{scene.origin}: axles cannot be combined with an earthquake: remove 'earthquake'")
    groups = _groups(scene, axles)
    bare = scene.replace(axles=[])
    cases = [scene.load_case] if scene.load_case else scene.load_cases
    scenes = [bare.with_load_case(case) for case in cases] or [bare]
    crossed = [case_scene for case_scene in scenes if case_scene.factor_of_axles]
    if not crossed:
        named = ", ".join(f"'{case.name}' leaves axles out ({case})" for case in cases)
        raise CaseError(
            f"{scene.origin}: no axles move, because load case {named}; to move the axles, "
            "set 'live = { axles = 1 }' in a load case"
        )
    crossed = [settled_scene(case_scene, settled) for case_scene in crossed]
    first = assemble(crossed[0])
    assemblies = [on_matrices_of(first, case_scene) or assemble(case_scene) for case_scene in crossed]
    directions = []
    for group in groups:
        line = _line(scene, group)
        # If supports settle, each load case has its own displaced road, because the dead loads of the load
        # case influence the displacements.
        if first.at_rest is None:
            roads = [_road(first, group, line)] * len(assemblies)
        else:
            roads = [_road(assembly, group, line) for assembly in assemblies]
        for direction in group.directions:
            pairs = zip(assemblies, roads, strict=True)
            directions.append([search.Passage(group, direction, assembly, road) for assembly, road in pairs])
    return directions, tuple(case.name for case in cases if not case.factor("live", "axles"))


def _road(assembly: Assembly, group: Axles, line: list[Point]) -> Road:
    """Return the road on which a group of axles moves over the blocks of an assembly.

    ``line`` has the points of the road as drawn.
    """
    at_rest = None if assembly.at_rest is None else assembly.at_rest.geometry
    name = f"the road of axles '{group.name}'"
    return Road(assembly.scene, assembly.geometry, line, name, at_rest)


def _groups(scene: Scene, axles: AxlesArgument) -> list[Axles]:
    """Return the groups of axles that move over the road. Raises CaseError if no group exists."""
    if isinstance(axles, str):
        named = [group for group in scene.axles if group.name == axles]
        if not named:
            known = ", ".join(repr(group.name) for group in scene.axles) or "none"
            near = did_you_mean(axles, [group.name for group in scene.axles]) or f"; known: {known}"
            raise OptionError(f"{scene.origin}: no axles '{axles}'{near}")
        return named
    chosen = scene.axles if axles is None else axles
    groups = [*chosen] if isinstance(chosen, Sequence) else [chosen]
    if not groups:
        raise CaseError(
            f"{scene.origin}: the scene has no axles: add [[axles]], or in Python axles=mo.Axles(...)"
        )
    if not all(isinstance(group, Axles) for group in groups):
        raise OptionError(
            "axles must be one mo.Axles, a list of mo.Axles, or the name of a group of axles of the scene"
        )
    return groups


def _line(scene: Scene, group: Axles) -> list[Point]:
    """Return the road on which a group of axles moves, as the points of a polyline.

    If the group has no road of its own, the roads of all fills are joined from left to right.
    """
    if group.road is not None:
        return group.road
    points = [point for fill in sorted(scene.fills, key=lambda fill: fill.road[0]) for point in fill.road]
    if not points:
        raise CaseError(
            f"{scene.origin}: axles '{group.name}' have no road: set 'road' to the points of a line above "
            "the blocks, from left to right"
        )
    return [point for point, _ in groupby(points)]
