"""A picture of λ over displacement, and where joints start to slide and to open."""

from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from masonry_opt.answer.outcome import Outcome
from masonry_opt.answer.reasons import Code
from masonry_opt.drawing.colours import BLACK, HATCH, HINGES, SLIDES
from masonry_opt.drawing.elements import heading, title_of
from masonry_opt.drawing.figure import Handle, Picture, entitle, finish, style
from masonry_opt.errors import OptionError
from masonry_opt.scene.scene import Scene
from masonry_opt.words.sentences import numeral, sentences

_HIGH = 0.6  #: Height of the axes over their width.
_BELOW, _ABOVE = 0.2, 0.06  #: How far they reach below zero and beyond the highest line, over that.
_FAR = 2.0  #: A load factor so many times the curve's highest is told in the legend alone.

#: Of joints that start to move, by column: a word, colour, marker and its size, and how high in the axes
#: their numbers stand.
_STARTS = {
    "starts_sliding": ("slide", SLIDES, "s", 10.0, 0.085),
    "starts_opening": ("open", HINGES, "o", 6.0, 0.025),
}


def curve_axes(scene: Scene, said: str, along: str) -> tuple[Picture, Axes]:
    """A picture whose axes are λ and what is said along it, with a line below the scene's title."""
    made = Picture()
    axes = made.add_subplot()
    axes.set_box_aspect(_HIGH)
    axes.set(xlabel=along, ylabel="load factor λ")
    entitle(axes, title_of(scene), said)
    return made, axes


def curve_picture(result: Outcome) -> Picture:
    """Draw λ over displacement. Raises OptionError if the result has no curve."""
    curve = result.curve
    if curve is None or curve.empty:
        raise OptionError("there is no curve to draw: solve with method 'compliant' and option curve=True")
    along = "displacement of the live load, in what a mean contact gives under the dead load"
    with style():
        made, axes = curve_axes(result.assembly.scene, heading(result), along)
        axes.set_xscale("log")
        axes.plot(curve["displacement"], curve["load_factor"], color=BLACK, marker=".", zorder=3)
        handles, top = _levels(axes, result, float(curve["load_factor"].max()))
        axes.set_ylim(-_BELOW * top, (1 + _ABOVE) * top)
        axes.set_yticks([tick for tick in axes.get_yticks() if 0 <= tick <= (1 + _ABOVE) * top])
        axes.axhline(0.0, color=HATCH, linewidth=0.6)
        handles += [_starts(axes, result, column) for column in _STARTS if curve[column].map(bool).any()]
        finish(made, axes, handles, sentences([said for said in result.reasons if said.code is Code.CURVE]))
    return made


def _levels(axes: Axes, result: Outcome, highest: float) -> tuple[list[Handle], float]:
    """Draw the load factors beside a curve that comes so high; what a legend shows, and the highest."""
    handles: list[Handle] = []
    top = highest
    for value, what, colour, dashes in (
        (result.load_factor, "load factor", BLACK, (4, 2)),
        (result.associative, "associative", HATCH, ()),
    ):
        if value is None:
            continue
        far = value > _FAR * highest
        label = f"{what} λ = {numeral(value, '.5g')}{', above' if far else ''}"
        look: dict[str, Any] = {"color": colour, "dashes": dashes, "linewidth": 0.9}
        handles.append(Line2D([], [], label=label, **look))
        if not far:
            axes.axhline(value, **look)
            top = max(top, value)
    return handles, top


def _starts(axes: Axes, result: Outcome, column: str) -> Line2D:
    """Mark where the first joints start to move, and write below how many start at each state."""
    word, colour, marker, size, height = _STARTS[column]
    assert result.curve is not None
    starts = result.curve[result.curve[column].map(bool)]
    look: dict[str, Any] = {"color": colour, "marker": marker, "markersize": size, "fillstyle": "none"}
    look["linestyle"] = "none"
    first = starts.iloc[:1]
    axes.plot(first["displacement"], first["load_factor"], zorder=4, markeredgewidth=1.6, **look)
    letters: dict[str, Any] = {"color": colour, "fontsize": 7, "transform": axes.get_xaxis_transform()}
    for displacement, pairs in zip(starts["displacement"], starts[column], strict=True):
        axes.text(displacement, height, str(len(pairs)), ha="center", **letters)
    axes.text(-0.01, height, f"start to {word}", ha="right", **letters | {"transform": axes.transAxes})
    return Line2D([], [], label=f"the first joints {word}", **look)
