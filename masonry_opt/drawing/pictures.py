"""Pictures of scenes and results, drawn with matplotlib."""

from collections.abc import Iterator
from pathlib import Path as FilePath

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PathCollection
from matplotlib.colors import ListedColormap
from matplotlib.path import Path
from shapely import Polygon

from masonry_opt.drawing import figure
from masonry_opt.drawing.colours import AT_REST, UTILISATION
from masonry_opt.drawing.elements import SHOWN_MOTION_SHARE, Elements, result_elements, scene_elements
from masonry_opt.drawing.figure import Handle, Picture
from masonry_opt.drawing.forces import utilisation_label
from masonry_opt.drawing.marks import Marks, moved, outlines
from masonry_opt.drawing.solids import Solids, ViewAngles, best_view, refuse_view
from masonry_opt.errors import CaseError
from masonry_opt.problem.assembly import Assembly, assemble
from masonry_opt.reporting.sentences import sentences
from masonry_opt.scene.blocks import Block
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.contacts.joints import refuse_floating
from masonry_opt.scene.mistakes import suggests_arguments
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.solids import Solid
from masonry_opt.solution.outcome import Outcome
from masonry_opt.solution.reasons import Code
from masonry_opt.solution.sense import warnings_of

#: Smallest font size of block names in scenes of up to ``_MANY_BLOCKS`` blocks, in points. A name of this
#: size may be wider than its block.
_SMALLEST_NAME_SIZE = 3.0
#: Factor by which a name that does not fit into its block is made smaller, repeatedly. A larger factor finds
#: the largest size more exactly.
_SMALLER = 0.9
#: Smallest font size of block names in scenes of more than ``_MANY_BLOCKS`` blocks, in points. Names of this
#: size are legible only if the picture is enlarged.
_TINY_NAME = 1.0
#: Number of blocks above which names of blocks may be smaller than ``_SMALLEST_NAME_SIZE`` and have no white
#: rim.
_MANY_BLOCKS = 200


@suggests_arguments
def draw(
    scene: Scene | str | FilePath,
    path: str | FilePath | None = None,
    names: bool = False,
    force: bool = False,
    view: ViewAngles | None = None,
) -> Picture:
    """Draw a scene before it is solved, and return the picture as a matplotlib figure.

    The picture shows blocks, supports, loads and joints. It marks small gaps and touching corners, at which
    there is no joint. Notes below the picture list probable mistakes in the scene. The scene is not solved
    and may be unstable. The function does not use pyplot.

    Parameters
    ----------
    scene: A scene, or the path of a case file.
    path: File to which the picture is written, whole or not at all (.png, .svg or .pdf).
    names: If True, each block shows its name.
    force: If True, a file that masonry_opt did not write is replaced.
    view: Azimuth and elevation of the eye in degrees, for a scene in space; see :meth:`Result.plot`.

    Returns
    -------
    Picture
        The figure, a subclass of matplotlib's ``Figure``.

    Raises
    ------
    CaseError
        If the case file or scene is wrong. Blocks that touch nothing are drawn, with a note.
    OptionError
        If the file name has another ending, if the file cannot be written or replaced, if the view is
        invalid, or if the scene with a view is in the plane.
    OSError
        If writing the file fails.
    """
    if path is not None:
        figure.refuse_picture(path, force)
    scene = as_scene(scene)
    refuse_view(scene, view)
    made = scene_picture(assemble(scene, floating=True), names, view)
    if path is not None:
        made.save(path, force)
    return made


def scene_picture(assembly: Assembly, names: bool = False, view: ViewAngles | None = None) -> Picture:
    """Draw an assembled scene as :func:`draw` does, with the scene's warnings below the picture."""
    notes = tuple(f"warning: {sentence}" for sentence in doubts(assembly))
    return elements_picture(scene_elements(assembly), "scene", names, view, notes)


def doubts(assembly: Assembly) -> Iterator[str]:
    """Generate sentences about probable mistakes in a scene, such as blocks that touch no other block.

    The scene is not analysed, so there is no warning that an analysis ignores axles.
    """
    scene, joints = assembly.scene, assembly.joints
    try:
        joined = joints.first, joints.second
        refuse_floating(scene, assembly.geometry, joined, joints.closing)
    except CaseError as error:
        yield str(error)
    found = warnings_of(assembly, None)
    yield from sentences([warning for warning in found if warning.code is not Code.AXLES_LEFT_OUT])


def result_picture(
    result: Outcome, kind: str = "mechanism", names: bool = False, view: ViewAngles | None = None
) -> Picture:
    """Draw a picture of a result. See :meth:`Result.plot` for the parameters and the exceptions."""
    figure.refuse_kind(kind, names)
    refuse_view(result.assembly.scene, view)
    if kind == figure.CURVE:
        return figure.curve_picture(result)
    return elements_picture(result_elements(result), kind, names, view)


def draw_mechanism(result: Outcome, axes: Axes) -> list[Handle]:
    """Draw a mechanism in the plane, without loads, on existing axes, and return its legend entries."""
    elements = result_elements(result)
    marks = elements.layers["mechanism"]
    _frame(axes, elements, marks, SHOWN_MOTION_SHARE)
    _draw(axes, elements, marks, SHOWN_MOTION_SHARE)
    return figure.handles(marks)


def elements_picture(
    elements: Elements,
    kind: str = "mechanism",
    names: bool = False,
    view: ViewAngles | None = None,
    notes: tuple[str, ...] = (),
) -> Picture:
    """Draw an unsolved scene, or the mechanism, the forces or the utilisation of a result.

    ``kind`` is "scene" for an unsolved scene, or one of ``PICTURE_KINDS`` for a result. See :func:`draw` for
    the other parameters and the exceptions. ``notes`` are sentences below the picture.
    """
    marks, share = elements.shown(kind), SHOWN_MOTION_SHARE if kind == "mechanism" else 0.0
    with figure.style():
        made = Picture()
        axes = made.add_subplot()
        if elements.assembly.scene.dimension == 3:
            solids = Solids(axes, elements, marks, share, view or best_view(elements.assembly))
            figure.fit(made, axes)
            solids.draw(names)
            notes = (solids.note, *notes)
        else:
            # Set the size of the axes before names are drawn, because the font size of names depends on the
            # size of the axes.
            _frame(axes, elements, marks, share)
            figure.fit(made, axes)
            _draw(axes, elements, marks, share)
            if names:
                _draw_names(axes, elements, share)
        figure.entitle(axes, elements.title, elements.heading)
        colours = None
        if kind in ("thrust", "utilisation") and not marks:
            message = "no forces were found to draw"
            written = axes.text(0.5, 0.5, message, transform=axes.transAxes, zorder=8)
            written.set(ha="center", va="center", bbox={"facecolor": "white", "edgecolor": "black"})
        elif kind == "utilisation":
            colours = ScalarMappable(cmap=ListedColormap(UTILISATION)), utilisation_label(elements.assembly)
        figure.finish(made, axes, figure.handles(marks), notes, colours)
        figure.remove_overlapping_texts(made, axes)
    return made


def _frame(axes: Axes, elements: Elements, marks: list[Marks], share: float) -> None:
    """Set the limits of the axes to the drawn area, with equal scales for x and y."""
    box = elements.box(marks, share) + elements.assembly.geometry.origin
    axes.set(xlim=box[:, 0], ylim=box[:, 1], aspect="equal")
    axes.set(xlabel="x, y in the length unit of the case", ylabel="y")


def _draw(axes: Axes, elements: Elements, marks: list[Marks], share: float) -> None:
    """Draw the supports, the outlines of the blocks at rest, the displaced blocks and the marks.

    The blocks are displaced by the fraction ``share`` of their magnified motion.
    """
    assembly, origin = elements.assembly, elements.assembly.geometry.origin
    rings, supports = outlines(assembly.geometry.polygons), elements.supports
    blocks = np.setdiff1d(np.arange(len(rings)), supports)

    def paths(blocks: np.ndarray, share: float) -> list[Path]:
        """Return the outlines of blocks and of their holes after a fraction of the magnified motion."""
        moved_rings = [
            [moved(ring, share * elements.motion[b]) + origin for ring in rings[b]] for b in blocks
        ]
        return [
            Path.make_compound_path(*(Path(ring, closed=True) for ring in block_rings))
            for block_rings in moved_rings
        ]

    axes.add_collection(PathCollection(paths(supports, share), **figure.SUPPORT_LOOK))
    if elements.movement and share:
        at_rest = paths(assembly.movable, 0.0)
        axes.add_collection(PathCollection(at_rest, facecolor="none", edgecolor=AT_REST, linewidth=0.5))
    width = elements.outline_width
    axes.add_collection(PathCollection(paths(blocks, share), linewidth=width, **figure.BLOCK_LOOK))
    for mark_group in marks:
        figure.draw_marks(axes, mark_group, mark_group.moved(share) + origin)


def _fits(block: Block | Solid, polygon: Polygon, at: np.ndarray, letters: float) -> bool:
    """Return True if the name of a block, written at a point in its outline, is inside the outline.

    ``letters`` is the height of the letters in the unit of length. The name of a support has its middle at
    the point, and the name of any other block is above the point.
    """
    half, below = figure.width_of(block.name, letters) / 2, letters / 2 if block.fixed else 0.0
    name = shapely.box(at[0] - half, at[1] - below, at[0] + half, at[1] - below + letters)
    return bool(shapely.covers(polygon, name))


def _draw_names(axes: Axes, elements: Elements, share: float) -> None:
    """Write the name of each block in the block, as large as possible.

    The axes must have their final size.
    """
    assembly, blocks = elements.assembly, elements.assembly.scene.blocks
    origin = assembly.geometry.origin
    visible_area = shapely.box(*(np.column_stack([axes.get_xlim(), axes.get_ylim()]) - origin).ravel())
    points_per_unit = figure.points_in_unit(axes)
    least = _SMALLEST_NAME_SIZE if len(blocks) <= _MANY_BLOCKS else _TINY_NAME
    for number, (block, polygon) in enumerate(zip(blocks, assembly.geometry.polygons, strict=True)):
        if block.fixed:
            polygon = shapely.intersection(polygon, visible_area)
            if polygon.is_empty:
                continue
        west, south, east, north = polygon.bounds
        middle = shapely.centroid(polygon)
        if not shapely.contains(polygon, middle):
            middle = shapely.point_on_surface(polygon)
        place = shapely.get_coordinates(middle)[0]
        at = moved(place, share * elements.motion[number]) + origin
        wide, high = (east - west) * points_per_unit, (north - south) * points_per_unit
        letters = max(min(figure.letters_in(block.name, 0.9 * wide), 0.45 * high), least)
        while letters > least and not _fits(block, polygon, place, letters / points_per_unit):
            letters = max(_SMALLER * letters, least)
        # Arrows of loads start in the middle of a block. Write the name of a block just above the middle, and
        # the name of a support, which has no loads, in the middle.
        look = {"xytext": (0, 0 if block.fixed else 1), "textcoords": "offset points", "clip_on": True}
        look["va"] = "center" if block.fixed else "bottom"
        figure.write_name(axes, block.name, at, letters, 0.15 if len(blocks) <= _MANY_BLOCKS else 0.0, **look)
