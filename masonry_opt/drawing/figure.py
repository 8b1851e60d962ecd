"""Figures of matplotlib: their size, marks, legends and files, and charts of λ over displacement."""

import io
import textwrap
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from masonry_opt.drawing.colours import BLACK, BLOCK, HATCH, HINGING_COLOUR, SLIDING_COLOUR, SUPPORT_COLOUR
from masonry_opt.drawing.elements import PICTURE_KINDS, heading, legend, title_of
from masonry_opt.drawing.marks import Marks
from masonry_opt.errors import OptionError, printable
from masonry_opt.files import image_source, picture_metadata, refuse_unwritable, write_whole
from masonry_opt.reporting.sentences import numeral, sentences
from masonry_opt.scene.mistakes import instead_of
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.outcome import Outcome
from masonry_opt.solution.reasons import Code

PICTURE_FORMATS = ("png", "svg", "pdf")  #: File formats of pictures, which are also the file name endings.
CURVE = "curve"  #: Kind of picture that shows the load–displacement curve instead of blocks.

_MAX_WIDTH = 6.0  #: Largest width of the axes, in inches.
_MAX_HEIGHT = 6.5  #: Largest height of the axes, in inches.
_SIDE_MARGIN = 0.5  #: Free space on each side of the axes, in inches.
_TOP_MARGIN = 0.7  #: Space for the title above the axes, in inches.
_AXIS_LABELS = 0.55  #: Space for tick labels and the axis label below the axes, in inches.
_COLOUR_BAR = 0.6  #: Height of a colour bar with its label, in inches.
_LINE_HEIGHT = 0.22  #: Height of a line of the legend or of notes, in inches.
_NOTE_LENGTH = 95  #: Largest number of characters in a line of a note. Longer notes are wrapped.
#: Largest number of characters in a row of a legend. The sample of each entry counts as ``_SAMPLE_WIDTH``
#: characters. Longer labels are divided into several lines.
_ROW_LENGTH = 84
_SAMPLE_WIDTH = 7  #: Width of the sample of a legend entry and of the space next to it, in characters.

_MAX_LETTERS = 8.0  #: Largest font size of block names in a picture, in points.
_LETTER_WIDTH = 0.62  #: Assumed mean width of a letter, relative to the font size.

#: Matplotlib markers for the shapes of marks that are drawn at one point.
_MARKERS = {"dot": "o", "point": "o", "square": "s", "cross": "x"}

#: Style of arrows, except colour and width. The length of an arrow is in units of the axes, and the size of
#: its head is relative to its line width.
_ARROW_STYLE: dict[str, Any] = {
    "angles": "xy",
    "scale_units": "xy",
    "scale": 1,
    "units": "inches",
    "zorder": 5,
}
_ARROW_STYLE |= {"minlength": 0.1, "headwidth": 4.5, "headlength": 5, "headaxislength": 4.5}

#: Style of blocks, except the width of their outlines.
BLOCK_LOOK: dict[str, Any] = {"facecolor": BLOCK, "edgecolor": "black"}
#: Style of supports.
SUPPORT_LOOK: dict[str, Any] = {
    "facecolor": SUPPORT_COLOUR,
    "edgecolor": HATCH,
    "hatch": "////",
    "linewidth": 0,
}

Handle = Line2D | Patch  #: Entry of a legend: a sample of a drawn element, and its label.

_CURVE_ASPECT = 0.6  #: Height of the axes of a load–displacement curve, relative to their width.
_BELOW_ZERO = 0.2  #: Length of the λ axis below zero, relative to the highest λ that is drawn.
_ABOVE_HIGHEST = 0.06  #: Length of the λ axis above the highest λ that is drawn, relative to the highest λ.
#: Largest load factor that is drawn as a horizontal line, relative to the highest λ of the curve. Higher load
#: factors appear only in the legend.
_LARGEST_DRAWN_RATIO = 2.0

#: Styles of the marks at states in which joints start to slide or open. The keys are columns of the table
#: ``result.curve``. Each tuple contains a verb for labels, a colour, a marker, and its size in points. The
#: last entry is the height of the texts that count the joints, relative to the height of the axes.
_MOTION_START_STYLES = {
    "starts_sliding": ("slide", SLIDING_COLOUR, "s", 10.0, 0.085),
    "starts_opening": ("open", HINGING_COLOUR, "o", 6.0, 0.025),
}
#: Width that is reserved for each number of joints above the horizontal axis, relative to the width of the
#: axes. If the numbers of several states would overlap, the sum of the numbers is written instead.
_NUMBER_WIDTH = 0.03

_TEXT_GAP = 4.0  #: Smallest distance between the texts of two marks, in pixels.
#: Matplotlib label of the texts that are written next to marks. The label is not visible; it identifies these
#: texts when overlapping texts are removed.
_MARK_TEXT = "text of a mark"


class Picture(Figure):
    """Matplotlib figure that a notebook can show, and that is not registered with pyplot."""

    def savefig(self, fname: Any, **options: Any) -> None:
        """Write the figure to a file; by default the picture includes all elements outside the axes."""
        with boxes():
            super().savefig(fname, **{"bbox_inches": "tight"} | options)

    def image(self, kind: str) -> bytes:
        """Return the figure as the content of a file in one of ``PICTURE_FORMATS``."""
        stream = io.BytesIO()
        with style():
            self.savefig(stream, format=kind, dpi=160, metadata=picture_metadata(kind))
        return stream.getvalue()

    def source(self, kind: str = "png") -> str:
        """Return the figure as a data URL, for the ``src`` attribute of an HTML image."""
        return image_source(self.image(kind), kind)

    def save(self, path: str | Path, force: bool = False) -> None:
        """Write the figure to ``path`` (.png, .svg or .pdf). No partial file is written if an error occurs.

        Raises the exceptions of :meth:`Result.save`.
        """
        refuse_picture(path, force)
        write_whole(path, self.image(_ending(path)))

    def _repr_png_(self) -> bytes:
        """Return the figure as PNG data, for notebooks."""
        return self.image("png")


def style() -> Any:
    """Return a context manager that sets matplotlib's options for drawing and writing pictures."""
    # The fixed salt makes the identifiers inside SVG files equal in every run.
    return mpl.rc_context({"font.size": 10, "svg.hashsalt": "masonry_opt", "hatch.linewidth": 0.6})


@contextmanager
def boxes() -> Iterator[None]:
    """Suppress matplotlib's warnings about letters that are missing in its font and are drawn as boxes."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph .* missing from|Matplotlib currently does not support")
        yield


def entitle(axes: Axes, title: str, heading: str) -> None:
    """Write a title and a second line above the axes. Dollar signs are printed and do not start a formula."""
    axes.set_title(f"{textwrap.fill(title, 60)}\n{heading}", parse_math=False)


def fit(figure: Figure, axes: Axes, below: float = _AXIS_LABELS) -> None:
    """Fit the figure to its contents: set its size so that the axes have the aspect ratio of the contents.

    If a box aspect is set, it is used instead of the ratio of the axis limits. ``below`` is the space below
    the axes, in inches.
    """
    proportion = 1.0 if axes.name == "polar" else np.ptp(axes.get_ylim()) / np.ptp(axes.get_xlim())
    slope = axes.get_box_aspect() or proportion
    tall = min(_MAX_WIDTH * slope, _MAX_HEIGHT)
    wide = tall / slope
    width, height = _MAX_WIDTH + 2 * _SIDE_MARGIN, tall + _TOP_MARGIN + below
    figure.set_size_inches(width, height)
    axes.set_position(((width - wide) / 2 / width, below / height, wide / width, tall / height))


def finish(
    figure: Figure,
    axes: Axes,
    handles: list[Handle],
    notes: tuple[str, ...] = (),
    colours: tuple[ScalarMappable, str] | None = None,
) -> None:
    """Put the colour bar, the legend and notes below the axes, and set the size of the figure.

    ``colours`` are the colours of the bar and its label.
    """
    for handle in handles:
        handle.set_label(textwrap.fill(str(handle.get_label()), _ROW_LENGTH - _SAMPLE_WIDTH))
    labels = [str(handle.get_label()) for handle in handles]
    columns = _legend_columns(labels)
    rows = _lines_of_legend(labels, columns)
    lines = [line for note in notes for line in textwrap.wrap(printable(note), _NOTE_LENGTH)]
    axis_labels = _AXIS_LABELS + axes.get_xlabel().count("\n") * _LINE_HEIGHT if axes.axison else 0.1
    at_legend = axis_labels + (_COLOUR_BAR if colours is not None else 0.0)
    at_notes = at_legend + rows * _LINE_HEIGHT + 0.1
    below = at_notes + len(lines) * _LINE_HEIGHT
    fit(figure, axes, below)
    width, height = figure.get_size_inches()
    if colours is not None:
        bar = figure.add_axes((0.2, (below - axis_labels - 0.12) / height, 0.6, 0.12 / height))
        figure.colorbar(colours[0], cax=bar, orientation="horizontal", label=colours[1])
    place: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, (below - at_legend) / height)}
    figure.legend(handles=handles, ncols=columns, frameon=False, borderaxespad=0.0, **place)
    at = _SIDE_MARGIN / width, (below - at_notes) / height
    figure.text(*at, "\n".join(lines), va="top", fontsize=9, parse_math=False)


def _legend_columns(labels: list[str]) -> int:
    """Return the largest number of columns, at most four, with which a legend fits into the picture.

    Matplotlib fills the columns of a legend one after the other, and the first columns may have one entry
    more. A legend with more than four entries has at most three columns.
    """
    for columns in (4, 3, 2) if len(labels) <= 4 else (3, 2):
        parts = np.array_split(labels, columns)
        width = sum(max((len(label) for label in part), default=0) + _SAMPLE_WIDTH for part in parts)
        if width <= _ROW_LENGTH:
            return columns
    return 1


def _lines_of_legend(labels: list[str], columns: int) -> int:
    """Return the number of lines of text of a legend: the lines of its column with the most lines."""
    parts = np.array_split(labels, columns)
    return max(sum(str(label).count("\n") + 1 for label in part) for part in parts)


def handles(marks: list[Marks]) -> list[Handle]:
    """Return the entries of a legend: block, support, and one entry for each label of the marks."""
    samples = [_handle(label, alike) for label, alike in legend(marks).items()]
    return [Patch(label="block", **BLOCK_LOOK), Patch(label="support", **SUPPORT_LOOK), *samples]


def draw_marks(axes: Axes, marks: Marks, at: np.ndarray) -> None:
    """Draw marks at points in the coordinates of the case.

    The array ``at`` has one or two points for each mark, shape (marks, 1, 2) or (marks, 2, 2).
    """
    look: dict[str, Any] = {"color": marks.colour}
    match marks.shape:
        case "line":
            look |= _line(marks) | {"capstyle": "butt" if marks.dashes else "round", "zorder": 3}
            axes.add_collection(LineCollection(list(at), **look))
        case "arrow":
            axes.quiver(*at[:, 0].T, *(at[:, 1] - at[:, 0]).T, width=marks.width / 72, **look, **_ARROW_STYLE)
        case "bar":
            axes.plot(*at[0].T, linewidth=marks.width, marker="|", markersize=6, zorder=8, **look)
            offset: dict[str, Any] = {"xytext": (6, 0), "textcoords": "offset points"}
            axes.annotate(marks.text, at[0, 1], va="center", zorder=8, **offset)
        case shape:
            look |= {"edgecolor": "white"} if shape == "dot" else {}
            look["linewidth"] = {"dot": 0.4, "cross": 1.5}.get(shape, 0.0)
            x, y = at[:, 0].T
            axes.scatter(x, y, s=marks.width**2, marker=_MARKERS[shape], zorder=4, **look)
            for place in at[:, 0] if marks.text else ():
                write_name(axes, marks.text, place, 8.0, 0.3, va="center", clip_on=True, label=_MARK_TEXT)


def remove_overlapping_texts(figure: Figure, axes: Axes) -> None:
    """Remove the text of a mark if it overlaps the text of an earlier mark.

    The limits and the size of the axes must be set before.
    """
    texts = [text for text in axes.texts if text.get_label() == _MARK_TEXT]
    if len(texts) < 2:  # most pictures need no renderer here
        return
    canvas: Any = FigureCanvasAgg(figure)  # matplotlib's renderer has no type annotations
    renderer = canvas.get_renderer()
    extents = list[Any]()
    for text in texts:
        extent = text.get_window_extent(renderer).padded(_TEXT_GAP / 2)
        if any(extent.overlaps(other) for other in extents):
            text.remove()
        else:
            extents.append(extent)


def _line(marks: Marks) -> dict[str, Any]:
    """Return the width and style of the marks' lines, as matplotlib arguments."""
    return {"linewidth": marks.width, "linestyle": (0, marks.dashes) if marks.dashes else "solid"}


def write_name(axes: Axes, name: str, at: np.ndarray, letters: float, rim: float, **look: Any) -> None:
    """Write a block's name at a point.

    ``letters`` is the font size in points. ``rim`` is the width of a white rim, relative to the font size.
    """
    # Exclude names from matplotlib's layout, because the layout of thousands of texts is slow.
    look |= {"fontsize": letters, "ha": "center", "zorder": 7, "parse_math": False, "in_layout": False}
    written = axes.annotate(printable(name), (at[0], at[1]), **look)
    if rim:
        written.set_path_effects([withStroke(linewidth=rim * letters, foreground="white")])


def points_in_unit(axes: Axes) -> float:
    """Return the number of points (1/72 inch) per unit of the axes.

    The size of the axes must be set before.
    """
    return float(72 / axes.figure.dpi * axes.bbox.width / np.ptp(axes.get_xlim()))


def letters_in(name: str, wide: float) -> float:
    """Return the largest font size, up to ``_MAX_LETTERS``, with which a name fits into the width ``wide``.

    Font size and width are in points.
    """
    return min(wide / width_of(name, 1.0), _MAX_LETTERS)


def width_of(name: str, letters: float) -> float:
    """Return the width of a name, in the unit of the font size ``letters``."""
    return _LETTER_WIDTH * len(name) * letters


def _handle(label: str, alike: list[Marks]) -> Line2D:
    """Return the legend entry of marks that share a label."""
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
    """Raise OptionError if a kind of picture is unknown, or if names of blocks are requested for a curve."""
    known = (*PICTURE_KINDS, CURVE)
    if kind not in known:
        raise OptionError(f"kind of picture '{kind}' is unknown{instead_of(kind, known)}")
    if kind == CURVE and names:
        raise OptionError("a picture of kind 'curve' shows no blocks: omit the names of blocks")


def refuse_picture(path: str | Path, force: bool = False) -> None:
    """Raise OptionError if no picture can be written to ``path``.

    Call this function before a long analysis.
    """
    refuse_file(path, force, PICTURE_FORMATS)


def refuse_file(
    path: str | Path, force: bool = False, endings: Sequence[str] = (*PICTURE_FORMATS, "html")
) -> None:
    """Raise OptionError if neither a picture nor a page can be written to ``path``.

    Call this function before a long analysis.
    """
    if _ending(path) not in endings:
        kinds = "a picture or page" if "html" in endings else "a picture"
        raise OptionError(
            f"{path}: the file name of {kinds} must end in {', '.join(f'.{ending}' for ending in endings)}"
        )
    refuse_unwritable(Path(path), force)


def save_as(path: str | Path, force: bool, page: Callable[[], str], picture: Callable[[], Picture]) -> None:
    """Write a page or a picture, depending on the ending of ``path``. An error leaves no partial file."""
    refuse_file(path, force)
    if is_page(path):
        write_whole(path, page())
    else:
        picture().save(path, force)


def is_page(path: str | Path) -> bool:
    """Return True if the file name ends in .html."""
    return _ending(path) == "html"


def _ending(path: str | Path) -> str:
    """Return the ending of a file name in lower case, without the dot."""
    return Path(path).suffix.lower().removeprefix(".")


def curve_axes(scene: Scene, subtitle: str, along: str) -> tuple[Picture, Axes]:
    """Return a picture with empty axes for a curve of λ over another quantity.

    ``along`` is the label of the horizontal axis. ``subtitle`` is a line below the scene's title.
    """
    made = Picture()
    axes = made.add_subplot()
    axes.set_box_aspect(_CURVE_ASPECT)
    axes.set(xlabel=along, ylabel="load factor λ")
    entitle(axes, title_of(scene), subtitle)
    return made, axes


def curve_picture(result: Outcome) -> Picture:
    """Return a picture of the load–displacement curve. Raises OptionError if the result has no curve."""
    curve = result.curve
    if result.stability is not None:
        remedy = "use kind 'thrust' or 'utilisation' to draw the forces under dead load"
        raise OptionError(f"{result.case}: without a live load there is no curve to draw: {remedy}")
    if curve is None or curve.empty:
        raise OptionError("there is no curve to draw: solve with method 'incremental' and option curve=True")
    along = (
        "displacement of the live load (unit: distance by which an elastic joint\n"
        "of mean length closes under the mean contact force of the dead load)"
    )
    with style():
        made, axes = curve_axes(result.assembly.scene, heading(result), along)
        jumps = _draw_curve(
            axes, *(curve[name].to_numpy() for name in ("displacement", "load_factor", "jump"))
        )
        handles, top = _levels(axes, result, float(curve["load_factor"].max()))
        axes.set_ylim(-_BELOW_ZERO * top, (1 + _ABOVE_HIGHEST) * top)
        axes.set_yticks([tick for tick in axes.get_yticks() if 0 <= tick <= (1 + _ABOVE_HIGHEST) * top])
        axes.axhline(0.0, color=HATCH, linewidth=0.6)
        handles += jumps
        starts: list[Handle] = [
            _starts(axes, result, column) for column in _MOTION_START_STYLES if curve[column].map(bool).any()
        ]
        notes = sentences([reason for reason in result.reasons if reason.code is Code.CURVE])
        if starts:
            notes += ("numbers below the curve: joints that start to slide or to open",)
        finish(made, axes, handles + starts, notes)
    return made


def _draw_curve(
    axes: Axes, displacement: np.ndarray, load_factor: np.ndarray, jump: np.ndarray
) -> list[Handle]:
    """Draw the load–displacement curve. A dashed line shows a jump of the blocks to another equilibrium.

    Returns the legend entry of jumps in a list, which is empty if the curve has no jumps.
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
    """Draw the load factors of a result as horizontal lines across the picture of its curve.

    ``highest`` is the highest λ of the curve. Returns the legend samples and the highest λ that is drawn.
    """
    handles, top = list[Handle](), highest
    for value, name, colour, dashes in (
        (result.load_factor, "load factor", BLACK, (4, 2)),
        (result.associative, "associative", HATCH, ()),
    ):
        if value is None:
            continue
        far = value > _LARGEST_DRAWN_RATIO * highest
        label = f"{name} λ = {numeral(value, '.6g')}{', above' if far else ''}"
        look: dict[str, Any] = {"color": colour, "dashes": dashes, "linewidth": 0.9}
        handles.append(Line2D([], [], label=label, **look))
        if not far:
            axes.axhline(value, **look)
            top = max(top, value)
    return handles, top


def _starts(axes: Axes, result: Outcome, column: str) -> Line2D:
    """Mark the point of the curve at which joints first start to slide, or to open; return a legend entry.

    The number of joints that start is written above the lower axis: for each state, or for several states
    whose numbers would overlap. ``column`` is the column of the curve, a key of ``_MOTION_START_STYLES``.
    """
    verb, colour, marker, size, height = _MOTION_START_STYLES[column]
    assert result.curve is not None
    starts = result.curve[result.curve[column].map(bool)]
    look: dict[str, Any] = {"color": colour, "marker": marker, "markersize": size, "fillstyle": "none"}
    look["linestyle"] = "none"
    first = starts.iloc[:1]
    axes.plot(first["displacement"], first["load_factor"], zorder=4, markeredgewidth=1.6, **look)
    letters: dict[str, Any] = {"color": colour, "fontsize": 7, "transform": axes.get_xaxis_transform()}
    spacing = _NUMBER_WIDTH * float(np.ptp(axes.get_xlim()))
    for displacement, number in _grouped_numbers(starts["displacement"], starts[column].map(len), spacing):
        axes.text(displacement, height, str(number), ha="center", **letters)
    axes.text(-0.01, height, f"start to {verb}", ha="right", **letters | {"transform": axes.transAxes})
    return Line2D([], [], label=f"the first joints {verb}", **look)


def _grouped_numbers(at: Iterable[float], numbers: Iterable[int], spacing: float) -> list[tuple[float, int]]:
    """Add up numbers at positions closer than ``spacing``; return one position and sum for each group.

    The positions ``at`` are in increasing order. Each sum is at the first position of its group.
    """
    groups = list[tuple[float, int]]()
    for place, number in zip(at, numbers, strict=True):
        if groups and place - groups[-1][0] < spacing:
            groups[-1] = groups[-1][0], groups[-1][1] + number
        else:
            groups.append((place, number))
    return groups
