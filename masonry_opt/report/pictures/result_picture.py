"""A picture of a result, by its kind."""

from __future__ import annotations

from collections.abc import Callable

from matplotlib.axes import Axes

from masonry_opt.answer.result import Result
from masonry_opt.errors import OptionError
from masonry_opt.report.pictures import mechanism, thrust, utilisation
from masonry_opt.report.pictures.blocks import frame
from masonry_opt.report.pictures.figure import Legend, Picture, finish, fit, style

#: By its name, what draws a result on axes, with the blocks' names or without.
_DRAWN: dict[str, Callable[[Result, Axes, bool], Legend]] = {
    "mechanism": mechanism.draw_kind,
    "thrust": thrust.draw_kind,
    "utilisation": utilisation.draw_kind,
}

KINDS = tuple(_DRAWN)


def refuse_kind(kind: object) -> None:
    """Raise OptionError if there is no such kind of picture."""
    if kind not in KINDS:
        raise OptionError(f"there is no picture of kind '{kind}': choose from {', '.join(KINDS)}")


def picture(result: Result, kind: str = "mechanism", names: bool = False) -> Picture:
    """Draw a result; see :meth:`Result.plot`."""
    refuse_kind(kind)
    with style():
        made = Picture()
        axes = made.add_subplot()
        # The size first: names are fitted into what is drawn.
        frame(axes, result.assembly)
        fit(made, axes)
        finish(made, axes, _DRAWN[kind](result, axes, names))
    return made
