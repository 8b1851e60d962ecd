"""A result written to a file: a picture, or an interactive page."""

from __future__ import annotations

from pathlib import Path

from masonry_opt.answer.outcome import Outcome
from masonry_opt.drawing.elements import refuse_kind
from masonry_opt.drawing.figure import FORMATS, refuse_picture
from masonry_opt.drawing.page import page
from masonry_opt.drawing.pictures import result_picture
from masonry_opt.drawing.solid_figure import three
from masonry_opt.drawing.view import View, refuse_view
from masonry_opt.errors import OptionError
from masonry_opt.files import refuse_unwritable, write_whole
from masonry_opt.scene.scene import Scene


def refuse_saving(
    scene: Scene,
    path: str | Path,
    kind: str,
    names: bool = False,
    force: bool = False,
    view: View | None = None,
) -> None:
    """Raise OptionError if a result of a scene could not be written so, before long work."""
    refuse_kind(kind, names)
    refuse_view(scene, view)
    ending = Path(path).suffix.lower().removeprefix(".")
    if ending == "html":
        if names:
            raise OptionError(f"{path}: a page tells the blocks of each joint: leave names to pictures")
        refuse_unwritable(Path(path), force)
        if scene.dimension == 3:
            three()
    elif ending in FORMATS:
        refuse_picture(path, force)
    else:
        known = ", ".join(f".{name}" for name in (*FORMATS, "html"))
        raise OptionError(f"{path}: the name of a picture or page ends in {known}")


def save(
    result: Outcome,
    path: str | Path,
    kind: str = "mechanism",
    names: bool = False,
    force: bool = False,
    view: View | None = None,
) -> None:
    """Write a result; see :meth:`Result.save`."""
    refuse_saving(result.assembly.scene, path, kind, names, force, view)
    if Path(path).suffix.lower() == ".html":
        write_whole(path, page(result, kind, view))
    else:
        result_picture(result, kind, names, view).save(path, force)
