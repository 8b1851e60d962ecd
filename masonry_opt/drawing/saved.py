"""A result written to a file: a picture, or an interactive page."""

from __future__ import annotations

from pathlib import Path

from masonry_opt.answer.result import Result
from masonry_opt.drawing.elements import refuse_kind
from masonry_opt.drawing.figure import FORMATS, refuse_picture
from masonry_opt.drawing.page import page
from masonry_opt.drawing.pictures import result_picture
from masonry_opt.errors import OptionError
from masonry_opt.files import refuse_unwritable, write_whole


def refuse_saving(path: str | Path, kind: str, names: bool, force: bool = False) -> None:
    """Raise OptionError if a result could not be written so, before long work."""
    refuse_kind(kind, names)
    ending = Path(path).suffix.lower().removeprefix(".")
    if ending == "html":
        if names:
            raise OptionError(f"{path}: a page tells the blocks of each joint: leave names to pictures")
        refuse_unwritable(Path(path), force)
    elif ending in FORMATS:
        refuse_picture(path, force)
    else:
        known = ", ".join(f".{name}" for name in (*FORMATS, "html"))
        raise OptionError(f"{path}: the name of a picture or page ends in {known}")


def save(
    result: Result, path: str | Path, kind: str = "mechanism", names: bool = False, force: bool = False
) -> None:
    """Write a result; see :meth:`Result.save`."""
    refuse_saving(path, kind, names, force)
    if Path(path).suffix.lower() == ".html":
        write_whole(path, page(result, kind))
    else:
        result_picture(result, kind, names).save(path, force)
