"""Whether a result could be written to a file, as a picture or an interactive page."""

from __future__ import annotations

from pathlib import Path

from masonry_opt.drawing.elements import refuse_kind
from masonry_opt.drawing.figure import is_page, refuse_file
from masonry_opt.drawing.solid_figure import three
from masonry_opt.drawing.view import ViewAngles, refuse_view
from masonry_opt.errors import OptionError
from masonry_opt.scene.scene import Scene


def refuse_saving(
    scene: Scene,
    path: str | Path,
    kind: str,
    names: bool = False,
    force: bool = False,
    view: ViewAngles | None = None,
) -> None:
    """Raise OptionError if a result of a scene could not be written so, before long work."""
    refuse_kind(kind, names)
    refuse_view(scene, view)
    if is_page(path) and names:
        raise OptionError(f"{path}: a page tells the blocks of each joint: leave names to pictures")
    refuse_file(path, force)
    if is_page(path) and scene.dimension == 3:
        three()
