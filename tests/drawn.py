"""Access to the drawn elements of scenes and results by name, in the coordinates of the case file."""

import functools

import numpy as np

import masonry_opt as mo
from masonry_opt.drawing.elements import SHOWN_MOTION_SHARE, Elements, legend, result_elements, scene_elements
from masonry_opt.problem.assembly import assemble
from masonry_opt.result import Result
from masonry_opt.scene.case_file import as_scene

#: Solves a case file once, and returns the stored result afterwards.
solved = functools.cache(mo.solve)


def elements_of(what: object) -> tuple[Elements, str]:
    """Return the drawn elements of a scene or of a result, and the default kind of picture."""
    if isinstance(what, Result):
        return result_elements(what), "mechanism"
    return scene_elements(assemble(as_scene(what), floating=True)), "scene"


def marks(what: object, name: str, kind: str = "", shape: str = "") -> np.ndarray:
    """Return the positions of the marks with a name.

    Lines and arrows have two ends, shape (marks, 2, 2). Other marks have one point, shape (marks, 1, 2).
    """
    elements, first = elements_of(what)
    share = SHOWN_MOTION_SHARE if (kind or first) == "mechanism" else 0.0
    found = [
        each.moved(share) + elements.assembly.geometry.origin
        for each in elements.shown(kind or first)
        if each.name == name and shape in ("", each.shape)
    ]
    return np.concatenate(found) if found else np.empty((0, 2, 2))


def arrows(what: object, name: str) -> np.ndarray:
    """Return the tails and tips of the arrows of a kind of load, shape (arrows, 2, 2)."""
    return marks(what, name, shape="arrow")


def labels(what: object, kind: str = "") -> list[str]:
    elements, first = elements_of(what)
    return list(legend(elements.shown(kind or first)))
