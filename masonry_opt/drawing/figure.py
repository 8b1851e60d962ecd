"""Figures fitted to their scenes, marks and legends, their files, and charts of λ over displacement."""

import io
import textwrap
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from masonry_opt.answer.outcome import Outcome
from masonry_opt.answer.reasons import Code
from masonry_opt.drawing.colours import BLACK, BLOCK, FIXED, HATCH, HINGES, SLIDES
from masonry_opt.drawing.elements import KINDS, heading, legend, title_of
from masonry_opt.drawing.marks import Marks
from masonry_opt.errors import OptionError, printable
from masonry_opt.files import image_source, picture_metadata, refuse_unwritable, write_whole
from masonry_opt.scene.scene import Scene
from masonry_opt.words.sentences import numeral, sentences

FORMATS = ("png", "svg", "pdf")
CURVE = "curve"  #: Kind of picture that shows the load–displacement curve and no joints.

_WIDTH, _TALLEST = 6.0, 6.5  #: Inches: widest and tallest axes.
_BESIDE, _ABOVE = 0.5, 0.7  #: Inches free beside and above them.
_ALONG, _BAR, _LINE = 0.55, 0.6, 0.22  #: Inches below, of words along them, a colour bar, a line of legend.
_NOTE, _ROW = 95, 60  #: Characters in a line of a note, and in a legend of one line.

_NAME, _LETTER = 8.0, 0.62  #: Largest size of letters of block names in points, their width over height.

#: Markers of the shapes that have no ends.
_MARKERS = {"dot": "o", "point": "o", "square": "s", "cross": "x"}

#: How arrows look, beside colour and width: as long as they are in the case, heads over their width.
_ARROW: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "scale": 1, "units": "inches", "zorder": 5}
_ARROW |= {"minlength": 0.1, "headwidth": 4.5, "headlength": 5, "headaxislength": 4.5}

#: How blocks and supports look, beside the widths of their outlines.
BLOCK_LOOK: dict[str, Any] = {"facecolor": BLOCK, "edgecolor": "black"}
SUPPORT_LOOK: dict[str, Any] = {"facecolor": FIXED, "edgecolor": HATCH, "hatch": "////", "linewidth": 0}

Handle = Line2D | Patch  #: What a legend shows of a thing drawn.

_HIGH = 0.6  #: Height of the axes over their width.
_UNDER, _OVER = 0.2, 0.06  #: How far they reach below zero and beyond the highest line, over that.
_FAR = 2.0  #: A load factor so many times the curve's highest is told in the legend alone.

#: Of joints that start to move, by column: word, colour, marker and its size, height of numbers in the axes.
_STARTS = {
    "starts_sliding": ("slide", SLIDES, "s", 10.0, 0.085),
    "starts_opening": ("open", HINGES, "o", 6.0, 0.025),
}


class Picture(Figure):
    """A figure that a notebook shows as it is, whether or not pyplot was imported."""

    def savefig(self, fname: Any, **given: Any) -> None:
        """Write the figure with what stands beside its axes; as matplotlib does otherwise."""
        with boxes():
            super().savefig(fname, **{"bbox_inches": "tight"} | given)

    def image(self, kind: str) -> bytes:
        """The file's content, in one of ``FORMATS``."""
        stream = io.BytesIO()
        with style():
            self.savefig(stream, format=kind, dpi=160, metadata=picture_metadata(kind))
        return stream.getvalue()

    def source(self, kind: str = "png") -> str:
        """That content as the address of an image in HTML."""
        return image_source(self.image(kind), kind)

    def save(self, path: str | Path, force: bool = False) -> None:
        """Write the figure whole to ``path`` (.png, .svg or .pdf); raises as :meth:`Result.save`."""
        refuse_picture(path, force)
        write_whole(path, self.image(_ending(path)))

    def _repr_png_(self) -> bytes:
        return self.image("png")


def style() -> Any:
    """Context in which pictures are drawn and written."""
    # Names inside SVG files do not change from run to run.
    return mpl.rc_context({"font.size": 10, "svg.hashsalt": "masonry_opt", "hatch.linewidth": 0.6})


@contextmanager
def boxes() -> Iterator[None]:
    """Context in which boxes stand for letters that a font lacks, without matplotlib's warning of each."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph .* missing from|Matplotlib currently does not support")
        yield


def entitle(axes: Axes, title: str, heading: str) -> None:
    """Write a title, which may hold dollar signs, and a line below it."""
    axes.set_title(f"{textwrap.fill(title, 60)}\n{heading}", parse_math=False)


def fit(figure: Figure, axes: Axes, below: float = _ALONG) -> None:
    """Size the figure so that the axes have their own proportions, or those of what fills them."""
    filled = 1.0 if axes.name == "polar" else np.ptp(axes.get_ylim()) / np.ptp(axes.get_xlim())
    slope = axes.get_box_aspect() or filled
    tall = min(_WIDTH * slope, _TALLEST)
    wide = tall / slope
    width, height = _WIDTH + 2 * _BESIDE, tall + _ABOVE + below
    figure.set_size_inches(width, height)
    axes.set_position(((width - wide) / 2 / width, below / height, wide / width, tall / height))


def finish(
    figure: Figure,
    axes: Axes,
    handles: list[Handle],
    notes: tuple[str, ...] = (),
    colours: tuple[ScalarMappable, str] | None = None,
) -> None:
    """Put a bar of colours and what they say, the legend and notes below the axes, and size the figure."""
    letters = sum(len(str(handle.get_label())) for handle in handles)
    columns = 4 if len(handles) <= 4 and letters <= _ROW else 3
    rows = -(-len(handles) // columns)
    lines = [line for note in notes for line in textwrap.wrap(printable(note), _NOTE)]
    along = _ALONG if axes.axison else 0.1
    at_legend = along + (_BAR if colours is not None else 0.0)
    at_notes = at_legend + rows * _LINE + 0.1
    below = at_notes + len(lines) * _LINE
    fit(figure, axes, below)
    width, height = figure.get_size_inches()
    if colours is not None:
        bar = figure.add_axes((0.2, (below - along - 0.12) / height, 0.6, 0.12 / height))
        figure.colorbar(colours[0], cax=bar, orientation="horizontal", label=colours[1])
    place: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, (below - at_legend) / height)}
    figure.legend(handles=handles, ncols=columns, frameon=False, borderaxespad=0.0, **place)
    at = _BESIDE / width, (below - at_notes) / height
    figure.text(*at, "\n".join(lines), va="top", fontsize=9, parse_math=False)


def handles(marks: list[Marks]) -> list[Handle]:
    """What a legend shows: blocks, supports, and marks by their labels."""
    told = [_handle(label, alike) for label, alike in legend(marks).items()]
    return [Patch(label="block", **BLOCK_LOOK), Patch(label="support", **SUPPORT_LOOK), *told]


def draw_marks(axes: Axes, marks: Marks, at: np.ndarray) -> None:
    """Draw marks at points of the case, shape (marks, 1 or 2, 2)."""
    look: dict[str, Any] = {"color": marks.colour}
    match marks.shape:
        case "line":
            look |= _line(marks) | {"capstyle": "butt" if marks.dashes else "round", "zorder": 3}
            axes.add_collection(LineCollection(list(at), **look))
        case "arrow":
            axes.quiver(*at[:, 0].T, *(at[:, 1] - at[:, 0]).T, width=marks.width / 72, **look, **_ARROW)
        case "bar":
            axes.plot(*at[0].T, linewidth=marks.width, marker="|", markersize=6, zorder=8, **look)
            beside: dict[str, Any] = {"xytext": (6, 0), "textcoords": "offset points"}
            axes.annotate(marks.text, at[0, 1], va="center", zorder=8, **beside)
        case shape:
            look |= {"edgecolor": "white"} if shape == "dot" else {}
            look["linewidth"] = {"dot": 0.4, "cross": 1.5}.get(shape, 0.0)
            x, y = at[:, 0].T
            axes.scatter(x, y, s=marks.width**2, marker=_MARKERS[shape], zorder=4, **look)
            for place in at[:, 0] if marks.text else ():
                write_name(axes, marks.text, place, 8.0, 0.3, va="center", clip_on=True)


def _line(marks: Marks) -> dict[str, Any]:
    return {"linewidth": marks.width, "linestyle": (0, marks.dashes) if marks.dashes else "solid"}


def write_name(axes: Axes, name: str, at: np.ndarray, letters: float, rim: float, **look: Any) -> None:
    """Write a block's name at a point, in letters so many points high, with a white rim, ``rim`` times
    their height wide."""
    # To find in a layout what room thousands take is slow.
    look |= {"fontsize": letters, "ha": "center", "zorder": 7, "parse_math": False, "in_layout": False}
    written = axes.annotate(printable(name), (at[0], at[1]), **look)
    if rim:
        written.set_path_effects([withStroke(linewidth=rim * letters, foreground="white")])


def points_in_unit(axes: Axes) -> float:
    """Points of a printed picture in a unit of the axes, whose size must be set."""
    return float(72 / axes.figure.dpi * axes.bbox.width / np.ptp(axes.get_xlim()))


def letters_in(name: str, wide: float) -> float:
    """Size of the letters, in points, in which a name is so many points wide, no larger than usual."""
    return min(wide / (_LETTER * len(name)), _NAME)


def _handle(label: str, alike: list[Marks]) -> Line2D:
    """What a legend shows of marks that share a label."""
    handle = Line2D([], [], color=alike[0].colour, linestyle="none", label=label)
    for marks in alike:
        if marks.shape == "line":
            handle.set(**_line(marks))
        elif marks.shape == "arrow":
            handle.set(marker=r"$\rightarrow$", markersize=14)
        else:
            handle.set(marker=_MARKERS[marks.shape], markersize=marks.width)
    return handle


def refuse_kind(kind: object, names: bool = False) -> None:
    """Raise OptionError if results have no such kind of picture, or it shows no names."""
    if kind not in (known := (*KINDS, CURVE)):
        raise OptionError(f"there is no picture of kind '{kind}': choose from {', '.join(known)}")
    if kind == CURVE and names:
        raise OptionError("a picture of kind 'curve' has no blocks whose names to write")


def refuse_picture(path: str | Path, force: bool = False) -> None:
    """Raise OptionError if a picture could not be written there: to be asked before long work."""
    refuse_file(path, force, FORMATS)


def refuse_file(path: str | Path, force: bool = False, endings: Sequence[str] = (*FORMATS, "html")) -> None:
    """Raise OptionError if neither picture nor page could be written there: to be asked before long work."""
    if _ending(path) not in endings:
        what = "the name of a picture or page" if "html" in endings else "a picture's name"
        raise OptionError(f"{path}: {what} ends in {', '.join(f'.{each}' for each in endings)}")
    refuse_unwritable(Path(path), force)


def save_as(path: str | Path, force: bool, page: Callable[[], str], picture: Callable[[], Picture]) -> None:
    """Write what can be shown as a page or as a picture, whole or not at all, as the path's ending says."""
    refuse_file(path, force)
    if is_page(path):
        write_whole(path, page())
    else:
        picture().save(path, force)


def is_page(path: str | Path) -> bool:
    return _ending(path) == "html"


def _ending(path: str | Path) -> str:
    return Path(path).suffix.lower().removeprefix(".")


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
        raise OptionError("there is no curve to draw: solve with method 'incremental' and option curve=True")
    along = "displacement of the live load, in the closing of a mean joint under the dead load"
    with style():
        made, axes = curve_axes(result.assembly.scene, heading(result), along)
        jumps = _draw_curve(
            axes, *(curve[name].to_numpy() for name in ("displacement", "load_factor", "jump"))
        )
        handles, top = _levels(axes, result, float(curve["load_factor"].max()))
        axes.set_ylim(-_UNDER * top, (1 + _OVER) * top)
        axes.set_yticks([tick for tick in axes.get_yticks() if 0 <= tick <= (1 + _OVER) * top])
        axes.axhline(0.0, color=HATCH, linewidth=0.6)
        handles += jumps
        handles += [_starts(axes, result, column) for column in _STARTS if curve[column].map(bool).any()]
        finish(made, axes, handles, sentences([said for said in result.reasons if said.code is Code.CURVE]))
    return made


def _draw_curve(
    axes: Axes, displacement: np.ndarray, load_factor: np.ndarray, jump: np.ndarray
) -> list[Handle]:
    """Draw the load–displacement curve, with dashed lines where the blocks jump to another equilibrium.

    Return what a legend shows of the jumps.
    """
    axes.plot(displacement, load_factor, color=BLACK, linestyle="none", marker=".", zorder=3)
    look: dict[bool, dict[str, Any]] = {
        False: {"color": BLACK},
        True: {"color": BLACK, "dashes": (2, 2), "linewidth": 0.9},
    }
    points = np.column_stack([displacement, load_factor])
    for before, after, is_jump in zip(points[:-1], points[1:], jump[1:], strict=True):
        axes.plot(*np.column_stack([before, after]), zorder=3, **look[bool(is_jump)])
    if not np.any(jump[1:]):
        return []
    return [Line2D([], [], label="jump to another equilibrium", **look[True])]


def _levels(axes: Axes, result: Outcome, highest: float) -> tuple[list[Handle], float]:
    """Draw the load factors beside a curve that comes so high; what a legend shows, and the highest."""
    handles, top = list[Handle](), highest
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
