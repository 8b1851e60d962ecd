"""Write scenes as DXF drawings."""

import io
from pathlib import Path

import shapely

from masonry_opt.errors import CaseError, OutputError
from masonry_opt.files import MARK, refuse_replacing
from masonry_opt.scene.blocks import Block
from masonry_opt.scene.drawings import outlines
from masonry_opt.scene.geometry import geometry
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.tables import as_path, write_file


def write_dxf(scene: Scene, path: str | Path, force: bool = False) -> None:
    """Write the blocks of a scene as a DXF drawing: closed polylines on the layers "blocks" and "fixed".

    Each block is drawn in the length unit of the scene, with its holes. Its name is a text inside the block,
    on the layer "names". Touching parts of a block are drawn as one outline. :func:`~masonry_opt.read_dxf`
    reads the same blocks again. Weights, loads and joints are not drawn.

    Parameters
    ----------
    scene: A scene in the plane.
    path: File to write, ``.dxf``.
    force: True to replace a file that another program wrote. Files of this package contain a mark.

    Raises
    ------
    CaseError
        If the argument is not a scene, if a block has no area or separate parts, or if the path does not end
        in ``.dxf``.
    OptionError
        If the scene is in space, if ezdxf is not installed, which is part of the extra "drawings", or if the
        file exists and must not be replaced.
    OutputError
        If the file cannot be written. An existing file is then not changed.
    """
    if not isinstance(scene, Scene):
        raise CaseError(f"only a Scene can be written as a drawing (found {type(scene).__name__})")
    path = as_path(path, "a DXF drawing", ".dxf")
    refuse_replacing(path, force)
    ezdxf = outlines.ezdxf()
    document = ezdxf.new("R2010")
    document.units = 0  # no unit, because a scene can have any
    for name in ("blocks", "fixed", "names"):
        document.layers.add(name)
    space = document.modelspace()
    geometry(scene)  # raises CaseError if the outline of a block has no area or crosses itself
    polygons = [(block, _block_polygon(block, scene)) for block in scene.in_plane()]
    # Write blocks with holes first: if a hole and the block in it have equal outlines, ``read_dxf`` reads the
    # first outline as the hole.
    for block, polygon in sorted(polygons, key=lambda entry: not entry[1].interiors):
        layer = {"layer": "fixed" if block.fixed else "blocks"}
        for ring in (polygon.exterior, *polygon.interiors):
            space.add_lwpolyline(list(ring.coords[:-1]), close=True, dxfattribs=layer)
        text_point = shapely.point_on_surface(polygon)
        text = space.add_text(block.name, height=0.1 * polygon.area**0.5, dxfattribs={"layer": "names"})
        middle = ezdxf.enums.TextEntityAlignment.MIDDLE_CENTER
        text.set_placement((text_point.x, text_point.y), align=middle)
    stream = io.StringIO()
    document.write(stream)
    # The code 999 begins a comment.
    write_file(path, f"999\n{MARK}\n{stream.getvalue()}", OutputError)


def _block_polygon(block: Block, scene: Scene) -> shapely.Polygon:
    """Return a block as one polygon.

    The corners of a block with one outline and no hole are not reordered. Raises CaseError if the block has
    separate parts.
    """
    rings = [shapely.Polygon(ring) for ring in block.rings]
    holes = [shapely.Polygon(ring) for ring in block.holes]
    if len(rings) == 1 and not holes:
        return rings[0]
    polygon = shapely.union_all(rings).difference(shapely.union_all(holes))
    if not isinstance(polygon, shapely.Polygon):
        raise CaseError(
            f"{scene.origin}: block '{block.name}' has separate parts, which a DXF outline cannot show"
        )
    return polygon
