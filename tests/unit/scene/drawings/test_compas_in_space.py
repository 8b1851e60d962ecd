"""COMPAS JSON to scenes in space: blocks whole, flat supports, boxes."""

import json

import numpy as np
import pytest
from touching_solids import contacts_of

import masonry_opt as mo
from masonry_opt.scene.space.shapes import shapes

GIVEN = {"friction": 0.5, "unit_weight": 10.0}


def mesh(corners, faces):
    vertex = {str(n): dict(zip("xyz", map(float, corner), strict=True)) for n, corner in enumerate(corners)}
    return {"vertex": vertex, "face": {str(n): list(face) for n, face in enumerate(faces)}}


def frustum(low, high, z0, z1):
    """A stone that narrows upwards: a prism along no level direction."""
    corners = [(x, y, z) for half, z in ((low, z0), (high, z1)) for x, y in _corners(half)]
    sides = [(i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4) for i in range(4)]
    return mesh(corners, [(3, 2, 1, 0), (4, 5, 6, 7), *sides])


def _corners(half):
    return [(-half, -half), (half, -half), (half, half), (-half, half)]


def box(size, middle, xaxis=(1, 0, 0), yaxis=(0, 1, 0)):
    frame = {"dtype": "compas.geometry/Frame", "data": {"point": middle, "xaxis": xaxis, "yaxis": yaxis}}
    x, y, z = size
    return {"dtype": "compas.geometry/Box", "data": {"frame": frame, "xsize": x, "ysize": y, "zsize": z}}


def assembly(*meshes, supports=(0,)):
    node = {str(n): {"block": {"data": own}, "is_support": n in supports} for n, own in enumerate(meshes)}
    return {"data": {"graph": {"data": {"node": node}}}}


@pytest.fixture
def file(tmp_path):
    def write(data):
        path = tmp_path / "stones.json"
        path.write_text(json.dumps(data))
        return path

    return write


def test_a_load_of_one_number_is_refused_by_its_key(file):
    with pytest.raises(mo.CaseError, match="COMPAS data: key 'live'"):
        mo.read_compas(file(assembly(frustum(2, 2, -1, 0), frustum(1, 0.5, 0, 3))), **GIVEN, live=3)


def test_what_is_no_prism_of_one_wall_is_read_whole(file):
    data = assembly(frustum(2, 2, -1, 0), frustum(1, 0.5, 0, 3))
    for scene in (
        mo.read_compas(file(data), **GIVEN),
        mo.read_compas(file(data), **GIVEN, live=(1, 0, 0)),
        mo.read_compas(file(data), **GIVEN, space=True),
    ):
        assert scene.dimension == 3
        # Of a frustum h (A + a + sqrt(A a)) / 3.
        assert shapes(scene).size[1] == pytest.approx(3 * (4 + 1 + 2) / 3)
    pushed = mo.read_compas(file(data), **GIVEN | {"friction": 2.0}, live=(1, 0, 0))
    # It overturns about an edge of its base: half of it over the height of its centroid.
    height = 3 / 4 * (4 + 2 * 2 + 3 * 1) / (4 + 2 + 1)
    assert mo.solve(pushed, "static").required() == pytest.approx(1 / height, rel=1e-5)
    with pytest.raises(mo.CaseError, match=r"no prism.*'live' of three numbers"):
        mo.read_compas(file(data), **GIVEN, live=(1, 0))


def test_prisms_are_read_whole_if_asked(file):
    data = assembly(frustum(2, 2, -1, 0), frustum(1, 1, 0, 3))
    assert mo.read_compas(file(data), **GIVEN, live=(0, 1, 0)).dimension == 3
    assert mo.read_compas(file(data), **GIVEN, along="y").dimension == 2


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (3, 2, 1, 0)])
def test_a_flat_support_is_the_top_of_a_slab(file, order):
    ground = mesh([(x, y, 0) for x, y in _corners(4)], [order])
    scene = mo.read_compas(file(assembly(ground, frustum(1, 1, 0, 3))), **GIVEN, live=(1, 0, 0))
    assert scene.blocks[0].corners()[:, 2].max() == 0
    assert contacts_of(scene).extent == pytest.approx([4])
    with pytest.raises(mo.CaseError, match="block '0' is a single face"):
        mo.read_compas(file(assembly(ground, frustum(1, 1, 0, 3), supports=(1,))), **GIVEN, space=True)


def test_boxes_in_courses(file):
    """As lists of lists; the upper one turned by a quarter about the vertical."""
    low, high = box((4, 2, 1), (0, 0, 0.5)), box((2, 4, 1), (0, 0, 1.5), xaxis=(0, 1, 0), yaxis=(-1, 0, 0))
    scene = mo.read_compas(file({"courses": [[low], [high]]}), **GIVEN, fixed_below=0, space=True)
    assert [block.fixed for block in scene.blocks] == [True, False]
    assert np.ptp(scene.blocks[1].corners(), axis=0) == pytest.approx([4, 2, 1])
    assert contacts_of(scene).extent == pytest.approx([8])


def test_models_with_a_list_of_elements(file):
    elements = [
        {"data": {"shape": {"data": frustum(2, 2, -1, 0)}, "is_support": True}},
        {"data": {"shape": {"data": frustum(1, 0.5, 0, 3)}, "is_support": False}},
    ]
    scene = mo.read_compas(file({"data": {"elements": elements}}), **GIVEN)
    assert [block.fixed for block in scene.blocks] == [True, False]


@pytest.mark.parametrize(
    "wrong",
    [
        box((1, 1, 0), (0, 0, 5)),
        box((1, 1, 1), (0, 0, 5), xaxis=(0, 0, 0)),
        box((1, 1, 1), (0, 0, 5), xaxis=(0, 2, 0)),
    ],
)
def test_boxes_that_are_none_are_named(file, wrong):
    with pytest.raises(mo.CaseError, match="block '1' is a box"):
        mo.read_compas(file([box((1, 1, 1), (0, 0, 0)), wrong]), **GIVEN, fixed=["0"])


@pytest.mark.parametrize(
    "wrong",
    [
        {"live": 0.1},
        {"live": ()},
        {"live": (1, 0), "space": True},
        {"fixed_below": "ground"},
        {"along": "y", "live": (1, 0, 0)},
        {"along": 3},
    ],
    ids=str,
)
def test_options_that_mean_nothing_are_named(file, wrong):
    with pytest.raises(mo.CaseError, match=next(iter(wrong))):
        mo.read_compas(file(assembly(frustum(2, 2, -1, 0), frustum(1, 0.5, 0, 3))), **GIVEN, **wrong)
