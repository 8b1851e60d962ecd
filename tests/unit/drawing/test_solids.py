"""Pictures of solids: their surfaces, their motion, and the parts that are hidden."""

import json
import re

import numpy as np
import pytest
import shapely
from drawn import elements_of, labels, marks
from scenes import CASES
from scenes_in_space import box_on_floor, corner_wall

import masonry_opt as mo
from masonry_opt.drawing.elements import FULL_MOTION, PICTURE_KINDS, result_elements, scene_elements
from masonry_opt.drawing.page import refuse_saving, three
from masonry_opt.drawing.solids import axes_of, best_view, raster, surface


@pytest.fixture(scope="module")
def result():
    return mo.solve(corner_wall(3, 2, 4), "static")


def enclosed(triangles):
    """Return the volume by Gauss's theorem, positive if the triangles are counter-clockwise seen from
    outside."""
    return float(np.linalg.det(triangles).sum()) / 6


def bracket():
    """Return a scene with a block of two parts, of which the upper part overhangs the lower one by half."""
    parts = [mo.Part(box=((0, 2), (0, 1), (0, 1))), mo.Part(box=((1, 3), (0, 1), (1, 2)))]
    floor = mo.box("floor", (0, 3), (0, 1), (-1, 0), fixed=True)
    return mo.Scene(joints={"friction": 0.6}, blocks=[mo.Solid(name="A", parts=parts, weight=1), floor])


@pytest.mark.parametrize("case", ["casapulla_lauro/arch.toml", "gilbert/two_blocks.toml", None])
def test_triangles_enclose_what_blocks_enclose(case):
    scene = bracket() if case is None else mo.extrude(CASES / case)
    elements, _ = elements_of(scene)
    drawn, shapes = surface(elements), elements.assembly.geometry
    for block in elements.assembly.movable:
        own = drawn.triangles[drawn.of_triangle == block]
        assert enclosed(own) == pytest.approx(shapes.size[block], rel=1e-9)


def test_each_edge_of_a_box_is_drawn_once():
    floor = mo.box("floor", (-0.1, 1.1), (0, 1), (-0.1, 0), fixed=True)
    blocks = [mo.box("A", (0, 1), (0, 1), (0, 1), weight=1), floor]
    elements, _ = elements_of(mo.Scene(joints={"friction": 0.6}, blocks=blocks))
    assert np.bincount(surface(elements).of_edge).tolist() == [12, 12]


@pytest.mark.parametrize("far", [3.0, 1e3, 1e6])
def test_supports_are_cut_where_they_reach_far(far):
    """A floor slopes by 1 in 10 and reaches far. The portion that is drawn is closed and has the same
    slope."""
    top = [(x, y, x / 10) for x, y in ((-far, -far), (far, -far), (far, far), (-far, far))]
    faces = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    floor = mo.Solid(name="f", vertices=[(x, y, -2 * far) for x, y, _ in top] + top, faces=faces, fixed=True)
    foot = [(x, y, x / 10) for x, y in ((0, 0), (2, 0), (2, 1), (0, 1))]
    corners = foot + [(x, y, 3 + z) for x, y, z in foot]
    block = mo.Solid(name="A", vertices=corners, faces=faces, weight=1, live=(1, 0, 0))
    elements, _ = elements_of(mo.Scene(joints={"friction": 0.6}, blocks=[block, floor]))
    drawn = surface(elements)
    own = drawn.triangles[drawn.of_triangle == 1] + elements.assembly.geometry.origin
    low, high = own.reshape(-1, 3).min(axis=0), own.reshape(-1, 3).max(axis=0)
    # The block is 3.2 high, and the floor is drawn up to a fifth of that height beside and below the block.
    reach = 0.2 * 3.2
    assert low == pytest.approx([-reach, -reach, -reach], abs=1e-6)
    assert high[:2] == pytest.approx([2 + reach, 1 + reach], abs=1e-6)
    wide, deep = 2 + 2 * reach, 1 + 2 * reach
    # The mean height of the slope z = x / 10 is its height in the middle, at x = 1.
    assert enclosed(own) == pytest.approx(wide * deep * (reach + 0.1), rel=1e-6)


def test_the_fastest_corner_moves_by_a_tenth_of_the_wall_s_length(result):
    """The wall is 6 long. The tests of solid files check the motion of each block."""
    elements = result_elements(result)
    drawn = surface(elements)
    steps = drawn.moved(elements.motion)[0] - drawn.moved(np.zeros_like(elements.motion))[0]
    assert np.linalg.norm(steps, axis=-1).max() == pytest.approx(FULL_MOTION * 6.0, rel=1e-9)


def through(boxes, points, towards):
    """Return the greatest length that each ray, from a point towards the eye, has inside one of the
    axis-parallel boxes."""
    low, high = (side[None] for side in np.moveaxis(boxes, -1, 0))
    with np.errstate(divide="ignore"):
        first, last = ((side - points[:, None]) / towards for side in (low, high))
    enter, leave = np.minimum(first, last).max(axis=-1), np.maximum(first, last).min(axis=-1)
    return np.clip(leave - np.maximum(enter, 0.0), 0.0, None).max(axis=1)


@pytest.mark.parametrize("view", [(-60, 22), (137, -15)])
def test_what_blocks_hide_is_hidden_and_nothing_else(view):
    """The raster and rays through the boxes agree on the points that are visible."""
    scene = corner_wall(3, 2, 4)
    elements, _ = elements_of(scene)
    drawn, axes, origin = surface(elements), axes_of(view), elements.assembly.geometry.origin
    flat = drawn.triangles @ axes.T
    box = np.array([flat.min(axis=(0, 1))[:2], flat.max(axis=(0, 1))[:2]])
    seen = raster(flat, box, 1000)
    share = np.linspace(0.07, 0.93, 11)[:, None]
    points = np.concatenate([(1 - share) * start + share * end for start, end in drawn.edges])
    boxes = np.array([block.box for block in scene.blocks], dtype=float) - origin[:, None]
    grown = boxes + np.array([-0.03, 0.03])
    shrunk = boxes - np.array([-0.03, 0.03])
    # Rays start a little off the surface, so that they do not run along the faces of their own block.
    start = points + 0.05 * axes[2]
    free, hidden = through(grown, start, axes[2]) == 0, through(shrunk, start, axes[2]) > 0
    found = seen.sees(points @ axes.T)
    assert free.sum() > 200
    assert hidden.sum() > 300
    assert found[free].all()
    assert not found[hidden].any()


@pytest.mark.slow
def test_a_scene_and_its_results_are_drawn_from_one_view():
    """An oblique push along its wider side makes the box slide. All pictures of the scene and of its result
    have one view."""
    scene = box_on_floor((4.0, 1.0, 4.0), live=(1.0, 0.4, 0.0))
    result = mo.solve(scene, "static")
    pictures = [mo.draw(scene), *(result.plot(kind) for kind in PICTURE_KINDS)]
    views = {re.search("seen from .*", picture.texts[0].get_text())[0] for picture in pictures}
    assert len(views) == 1


def test_the_view_is_of_the_wider_side_and_what_comes_nearer():
    for push in ((0, -1, 0), (0, 1, 0)):
        scene = box_on_floor((4.0, 1.0, 4.0), live=push)
        azimuth, _ = best_view(mo.assemble(scene))
        towards = axes_of((azimuth, 0))[2]
        assert abs(towards[1]) > abs(towards[0])
        assert towards @ push > 0
    # A load of 37° to the x axis is seen from the side, because it would point at a viewer at 30°.
    oblique = (0.8, 0.6, 0)
    azimuth, _ = best_view(mo.assemble(box_on_floor((1.0, 2.0, 3.0), live=oblique)))
    assert 0 < axes_of((azimuth, 0))[2] @ oblique < 0.9
    assert axes_of((0, 0)) == pytest.approx(np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]))
    assert axes_of((-90, 0)) == pytest.approx(np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]))


@pytest.mark.parametrize("kind", PICTURE_KINDS)
def test_a_picture_has_the_legend_of_its_marks(result, kind):
    """An entry that is longer than a line of the legend is wrapped."""
    entries = [" ".join(text.get_text().split("\n")) for text in result.plot(kind).legends[0].get_texts()]
    assert entries == ["block", "support", *labels(result, kind)]
    assert len(entries) > 2


@pytest.mark.parametrize("view", [(1, 2, 3), "30,40", (0, 91), (float("nan"), 0), (True, 0), 30])
def test_no_view_is_refused(result, view, tmp_path):
    with pytest.raises(mo.OptionError, match="view"):
        result.plot(view=view)
    with pytest.raises(mo.OptionError, match="view"):
        mo.draw(box_on_floor(), tmp_path / "a.png", view=view)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_names_are_written_where_blocks_are_seen(result):
    written = {text.get_text() for text in result.plot(names=True, view=(-60, 22)).axes[0].texts}
    assert {"x 1-1", "x 4-3", "y 4-2", "base"} <= written
    # This block is hidden behind the other wall.
    assert "y 1-2" not in written


def test_a_name_is_written_on_one_face():
    """A name does not cross the edge between two visible faces of its block: it is in the larger face."""
    scene = box_on_floor()
    axes = mo.draw(scene, names=True, view=(30, 22)).axes[0]
    (name,) = [text for text in axes.texts if text.get_text() == "A"]
    corners = np.array([(1, 0, 0), (1, 2, 0), (1, 2, 3), (1, 0, 3)])
    face = shapely.Polygon(((corners - mo.assemble(scene).geometry.origin) @ axes_of((30, 22)).T)[:, :2])
    assert shapely.contains(face.buffer(-0.3), shapely.Point(name.xy))


@pytest.mark.parametrize("push", [(0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)])
def test_the_arrow_of_all_weights_is_beside_the_blocks(push):
    """The arrow is at the back of the default view, and does not cover a block."""
    scene = corner_wall(2, 2, 2)
    blocks = [block if block.fixed else block.replace(live_per_weight=push) for block in scene.blocks]
    elements = scene_elements(mo.assemble(scene.replace(blocks=blocks)))
    axes = axes_of(best_view(elements.assembly))
    (weight,) = [marks for marks in elements.loads if marks.name == "weight"]
    movable = np.isin(surface(elements).of_triangle, elements.assembly.movable)
    drawn = [shapely.Polygon((triangle @ axes.T)[:, :2]) for triangle in surface(elements).triangles[movable]]
    arrow = shapely.LineString((weight.points[0] @ axes.T)[:, :2])
    assert not shapely.intersects(shapely.union_all(drawn).buffer(-1e-6), arrow)


@pytest.mark.slow
@pytest.mark.parametrize("kind", PICTURE_KINDS[1:2])
def test_a_page_shows_first_the_kind_asked_for(kind, tmp_path):
    pytest.importorskip("trimesh", reason="needs the extra meshes")
    result = mo.solve(box_on_floor((2, 2, 1), 0.5), "static")
    result.save(tmp_path / "a.html", kind, view=(10, 20))
    text = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert len(text) < 1_200_000
    (chosen,) = [line for line in text.splitlines() if " checked" in line]
    assert f'value="{kind}"' in chosen
    record = json.loads(re.search(r'id="data">(.*?)</script>', text, re.DOTALL)[1])
    assert record["figure"]["view"] == [10, 20]
    # The box slides without rotating, and the base presses on it evenly. Both values are exactly zero,
    # without rounding.
    assert record["joints"]["n"] == [pytest.approx(1.0)]
    assert record["joints"]["rotation"] == [0]
    assert record["joints"]["torsion"] == [0]
    assert record["joints"]["utilisation"] == [pytest.approx(1.0, abs=1e-4)]


def test_a_page_without_trimesh_is_refused_before_long_work(without, tmp_path):
    three.cache_clear()
    without("trimesh")
    with pytest.raises(mo.OptionError, match="meshes"):
        refuse_saving(box_on_floor(), tmp_path / "a.html", "mechanism")


def test_forces_at_contact_points_are_drawn_to_the_scale_of_resultants():
    """A box 1 × 2 × 3 of weight 1 overturns at λ = 1/3 about the edge x = 1. Each end of the edge carries
    half of the resultant."""
    result = mo.solve(box_on_floor(), "static")
    ends, resultant = (np.sort(marks(result, name, "thrust"), axis=1) for name in ("contacts", "resultants"))
    assert sorted(ends.mean(axis=1)[:, 1]) == pytest.approx([0, 2], abs=1e-6)
    drawn = np.ptp(ends, axis=1)
    assert drawn[:, 0] == pytest.approx(drawn[:, 2] / 3, rel=1e-5)
    assert drawn.sum(axis=0) == pytest.approx(np.ptp(resultant, axis=1)[0], rel=1e-6)
