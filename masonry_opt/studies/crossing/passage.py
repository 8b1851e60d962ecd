"""A group of axles on its way over a road, as live loads by position."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import shapely

from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.road import Road
from masonry_opt.scene.axles import Axles, TravelDirection
from masonry_opt.scene.loads import Load
from masonry_opt.scene.scene import Scene

#: Share of the road's length beside a break of the loads at which they are taken there, on either side: at
#: the break itself they may jump.
_BESIDE = 1e-9


@dataclass(frozen=True)
class Passage:
    """A group of axles that travels in one direction over a road of a scene with whatever other live loads.
    Its position is the abscissa of its first axle; the others follow."""

    axles: Axles
    direction: TravelDirection
    assembly: Assembly
    road: Road

    @cached_property
    def offsets(self) -> np.ndarray:
        """Abscissae of the axles from the position, shape (axles,)."""
        behind = np.cumsum([0.0, *self.axles.group.distances])
        return -behind if self.direction == "right" else behind

    def live(self, position: float) -> np.ndarray:
        """Live load f_L of all axles that are on the road, by their factor of a load case, and of whatever
        else is live, in the problem's units, shape (3b,)."""
        problem, movable = self.assembly.problem, self.assembly.movable
        factor = self.assembly.scene.factor_of_axles
        forces = factor * self._on_blocks(position)[movable] / problem.force_unit
        forces[:, 2] /= problem.length_unit
        return problem.live + forces.ravel()

    def loaded(self, live: np.ndarray) -> Assembly:
        """The assembly with that live load."""
        return replace(self.assembly, problem=replace(self.assembly.problem, live=live))

    def scene(self, position: float) -> Scene:
        """The scene with the axles there as loads of its blocks, one a block, and none that move."""
        scene, shapes = self.assembly.scene, self.assembly.geometry
        loads, group = list(scene.loads), None
        changed: dict[str, Any] = {"loads": loads, "axles": []}
        case = scene.load_case
        if case is not None:
            group = f"axles '{self.axles.name}'"
            live = {name: factor for name, factor in case.live.items() if name != "axles"}
            case = case.replace(live=live | {group: scene.factor_of_axles})
            changed["load_cases"] = [case if one.name == case.name else one for one in scene.load_cases]
        forces = self._on_blocks(position)
        for block in np.flatnonzero(forces[:, 1]):
            _, down, moment = forces[block]
            x = shapes.centroid[block, 0] + moment / down
            _, low, _, high = shapes.polygons[block].bounds
            met = shapely.intersection(
                shapes.polygons[block], shapely.linestrings([[x, low - 1.0], [x, high + 1.0]])
            )
            at = np.array([x, high if met.is_empty else met.bounds[3]]) + shapes.origin
            where = {"block": scene.blocks[block].name, "at": tuple(map(float, at))}
            loads.append(Load(**where, live=(0.0, float(down)), group=group))
        return scene.replace(**changed).read_from(scene.called).with_load_case(case)

    def pieces(self, longest: float) -> list[tuple[float, float]]:
        """Ranges of positions, from left to right, in which loads do not jump and some axle is on a movable
        block, none longer than that."""
        beside = _BESIDE * float(self.road.breaks[-1] - self.road.breaks[0])
        breaks = np.unique(self.road.breaks[:, None] - self.offsets)
        found: list[tuple[float, float]] = []
        for start, end in zip(breaks[:-1] + beside, breaks[1:] - beside, strict=True):
            if end - start > beside:
                ends = np.linspace(start, end, 1 + int(np.ceil((end - start) / longest))).tolist()
                found += pairwise(ends)
        return [ends for ends in found if any(self.carried(x) for x in (*ends, sum(ends) / 2))]

    def carried(self, position: float) -> bool:
        """Whether any axle there loads a block that can move."""
        return bool(self._on_blocks(position).any())

    def _on_blocks(self, position: float) -> np.ndarray:
        loads = np.array(self.axles.group.loads)
        return self.road.on_blocks(position + self.offsets, loads)
