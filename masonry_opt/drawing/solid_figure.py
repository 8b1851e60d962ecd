"""The figure of a page of a scene in space: its data, and three.js, which draws it."""

from __future__ import annotations

import importlib
from functools import cache
from typing import Any

import numpy as np

from masonry_opt.drawing.colours import BLOCK, FIXED
from masonry_opt.drawing.elements import INSIDE, Elements
from masonry_opt.drawing.marks import Marks, size_of
from masonry_opt.drawing.solids import surface
from masonry_opt.drawing.view import ViewAngles
from masonry_opt.errors import OptionError

#: Units of the figure along the scene's size: coordinates are whole numbers, which keeps large scenes short.
_UNITS = 20_000

#: Half the width of a mark of a point's width, over the size of the scene: of loads and resultants, which are
#: seen through blocks, and of marks on joints, these at most over the size of a usual joint.
_RADIUS_THROUGH, _RADIUS, _OF_JOINT = 1 / 900, 1 / 500, 1 / 80

#: What three.js ends with in the page that trimesh puts it in.
_END = 'Object.defineProperty(t,"__esModule",{value:!0})}));'


@cache
def three() -> str:
    """The script three.js, with its licence, as trimesh brings it.

    Raises OptionError if trimesh, of the extra "meshes", is not installed, or brings another one.
    """
    try:
        trimesh = importlib.import_module("trimesh")
        viewer = importlib.import_module("trimesh.viewer")
    except ImportError:
        raise OptionError(
            "pages of solids need trimesh, which brings three.js; install it with: pip install '.[meshes]'"
        ) from None
    script, end, _ = (
        viewer.scene_to_html(trimesh.creation.box().scene()).partition("<script>")[2].partition(_END)
    )
    if not end or "</script" in script:
        raise OptionError(
            f"trimesh {trimesh.__version__} does not bring the three.js that pages need: install the version "
            "that constraints.txt names"
        )
    return f"{script}{end}"


class Figure:
    """Elements in space in whole units of the figure."""

    def __init__(self, elements: Elements) -> None:
        self.elements = elements
        self.scale = _UNITS / size_of(elements.assembly)

    def data(self, view: ViewAngles) -> dict[str, Any]:
        """All that a page draws: see ``page_space.js``."""
        elements, assembly = self.elements, self.elements.assembly
        contacts = assembly.joints
        drawn = surface(elements)
        corners = np.concatenate([drawn.triangles.reshape(-1, 3), drawn.edges.reshape(-1, 3)])
        block = np.concatenate([np.repeat(drawn.of_triangle, 3), np.repeat(drawn.of_edge, 2)])
        rows, number = np.unique(np.column_stack([block, self._at(corners)]), axis=0, return_inverse=True)
        triangles = number[: 3 * len(drawn.triangles)]
        lines, joint = contacts.lines()
        middle = (rows[:, 1:].min(axis=0) + rows[:, 1:].max(axis=0)) / 2
        areas = contacts.extent[contacts.extent > 0]
        usual = np.sqrt(np.median(areas)) if len(areas) else np.inf
        self.radius = min(_RADIUS * _UNITS, _OF_JOINT * usual * self.scale)
        self.table: dict[tuple[float, ...], int] = {(0.0,) * 6: 0}
        layers = {name: [self._marks(each) for each in marks] for name, marks in elements.layers.items()}
        layers["loads"] = [self._marks(each) for each in elements.loads]
        return {
            "size": _UNITS,
            "middle": middle.tolist(),
            "view": view,
            "block": BLOCK,
            "fixed": FIXED,
            "radius": round(3 * self.radius, 2),
            "surface": {
                "points": rows[:, 1:].ravel().tolist(),
                "of": rows[:, 0].tolist(),
                "triangles": triangles.tolist(),
                "edges": number[len(triangles) :].tolist(),
                "hatching": self._at(drawn.hatching).ravel().tolist(),
            },
            "motions": [self._motion(motion) for motion in elements.motion],
            "outlines": {"points": self._at(lines).ravel().tolist(), "of": joint.tolist()},
            "layers": layers,
            "table": list(self.table),
        }

    def _at(self, points: np.ndarray) -> np.ndarray:
        return np.rint(points * self.scale).astype(int)

    def _motion(self, motion: np.ndarray) -> tuple[float, ...]:
        moved = np.round(motion[:3] * self.scale, 1) + 0.0
        return (*moved.tolist(), *(np.round(motion[3:], 6) + 0.0).tolist())

    def _marks(self, marks: Marks) -> dict[str, Any]:
        motion = None
        if marks.motion is not None:
            motion = [self.table.setdefault(self._motion(each), len(self.table)) for each in marks.motion]
        through = marks.shape == "arrow" or marks.name in INSIDE
        half = marks.width * (_RADIUS_THROUGH * _UNITS if through else self.radius)
        return {
            "shape": marks.shape,
            "points": self._at(marks.points).ravel().tolist(),
            "motion": motion,
            "radius": round(half, 2),
            "colour": marks.colour,
            "dashes": marks.dashes,
            "through": through,
        }
