"""COMPAS JSON is read as scenes in the plane and in space, from files in the forms that COMPAS writes."""

import json

import numpy as np
import pytest
from touching_solids import contacts_of

import masonry_opt as mo
from masonry_opt.scene.space.shapes import shapes

BASE = [(-2, -1), (5, -1), (5, 0), (-2, 0)]
LOW = [(0, 0), (2, 0), (2, 1), (0, 1)]
HIGH = [(0, 1), (1.5, 1), (1.5, 4), (0, 4)]
#: Outline of a stone with a notch, which has two feet.
PORTAL = [(0, 0), (1, 0), (1, 2), (3, 2), (3, 0), (4, 0), (4, 3), (0, 3)]

#: Names of the coordinates of a point of a wall: along the wall, upwards, and across it.
ACROSS_Y = "xzy"
ACROSS_X = "yzx"


def prism(outline, begin=0.0, end=0.5, order=ACROSS_Y, old=False):
    """Return the content of a mesh of a prism: two ends, and a face for each edge of the outline."""
    corners = [(*point, depth) for depth in (begin, end) for point in outline]
    count = len(outline)
    faces = [list(range(count))[::-1], list(range(count, 2 * count))]
    faces += [[i, (i + 1) % count, (i + 1) % count + count, i + count] for i in range(count)]
    vertex = {str(number): dict(zip(order, corner, strict=True)) for number, corner in enumerate(corners)}
    keys = str if old else int
    face = {str(number): [keys(corner) for corner in face] for number, face in enumerate(faces)}
    return {"attributes": {"name": "Mesh"}, "vertex": vertex, "face": face, "facedata": {}, "edgedata": {}}


def wrapped(kind, data):
    return {"dtype": kind, "data": data, "guid": "8a1c"}


def assembly(meshes, supports):
    """Return an assembly in the present form of compas_assembly and compas_cra."""
    node = {
        str(number): {"block": wrapped("compas_assembly.datastructures/Block", mesh)}
        | ({"is_support": True} if number in supports else {})
        for number, mesh in enumerate(meshes)
    }
    graph = {"attributes": {"name": "Graph"}, "default_node_attributes": {"is_support": False}, "node": node}
    content = {"attributes": {"name": "Assembly"}, "graph": wrapped("compas.datastructures/Graph", graph)}
    return wrapped("compas_assembly.datastructures/Assembly", content)


def assembly_of_2021(meshes, supports):
    kind, node = "compas_assembly.datastructures", {}
    for number, mesh in enumerate(meshes):
        block = {"dtype": f"{kind}/Block", "value": {"data": mesh, "compas": "0.18"}}
        node[str(number)] = {"x": 0.0, "is_support": number in supports, "block": block}
    return {"dtype": f"{kind}/Assembly", "value": {"data": {"node": node, "edge": {}}}}


def assembly_of_2018(meshes, supports):
    vertex = {str(number): {"x": 0.0, "is_support": number in supports} for number in range(len(meshes))}
    blocks = {str(number): mesh for number, mesh in reversed(list(enumerate(meshes)))}
    return {"assembly": {"attributes": {"name": "Assembly"}, "vertex": vertex}, "blocks": blocks}


def model(meshes, supports):
    """Return a model in the form of compas_dem."""
    elements = {}
    for number, mesh in enumerate(meshes):
        geometry = wrapped("compas.datastructures/Mesh", mesh)
        own = {"transformation": None, "geometry": geometry, "is_support": number in supports}
        elements[f"guid-{number}"] = wrapped("compas_dem.elements/Block", own)
    return wrapped("compas_dem.models/BlockModel", {"transformation": None, "elements": elements})


def problem(meshes, supports):
    return wrapped("compas_dem.problem/Problem", {"name": "Problem", "model": model(meshes, supports)})


def assert_outline(block, outline):
    """Assert that a block has the corners of an outline, in any order."""
    found, expected = (np.array(sorted(map(tuple, np.round(ring, 6)))) for ring in (block.vertices, outline))
    assert found == pytest.approx(expected, abs=1e-6)


@pytest.fixture
def file(tmp_path):
    def write(data):
        path = tmp_path / "wall.json"
        path.write_text(json.dumps(data))
        return path

    return write


def read(path, **more):
    return mo.read_compas(path, **({"friction": 0.5, "unit_weight": 10.0, "live": (1, 0)} | more))


@pytest.mark.parametrize("order", [ACROSS_X, pytest.param(ACROSS_Y, marks=pytest.mark.slow)])
@pytest.mark.parametrize("write", [assembly, assembly_of_2021, assembly_of_2018, model, problem])
def test_prisms_are_seen_across_the_wall(file, write, order):
    meshes = [prism(outline, order=order, old=write is assembly_of_2018) for outline in (BASE, LOW, HIGH)]
    scene = read(file(write(meshes, {0})))
    assert [block.name for block in scene.blocks] == ["0", "1", "2"]
    assert [block.fixed for block in scene.blocks] == [True, False, False]
    for block, outline in zip(scene.blocks, (BASE, LOW, HIGH), strict=True):
        assert_outline(block, outline)
    # A weight is unit weight times area times thickness.
    assert [block.weight for block in scene.blocks[1:]] == pytest.approx([10 * 2 * 0.5, 10 * 4.5 * 0.5])
    # The live load is the weight. The high stone overturns at half its width over half its height.
    assert mo.solve(scene, "static").required() == pytest.approx(0.5, rel=1e-6)
    rough = read(file(write(meshes, {0})), friction=2.0, live=(-1, 0))
    # To the left, both stones overturn about x = 0: the moments of the weights over those of the live loads.
    arm, height = (10 * 1 + 22.5 * 0.75), (10 * 0.5 + 22.5 * 2.5)
    assert mo.solve(rough, "static").required() == pytest.approx(min(0.75 / 1.5, arm / height), rel=1e-6)


def test_each_block_keeps_its_own_thickness(file):
    """Blocks may differ in thickness if their middles are in one plane, or if the option `along` names the
    direction."""
    middle = [prism(BASE, -1, 1), prism(LOW, -0.25, 0.25), prism(HIGH, -0.5, 0.5)]
    assert [block.weight for block in read(file(assembly(middle, {0}))).blocks[1:]] == pytest.approx([10, 45])
    aside = [prism(BASE, -1, 1), prism(LOW, -0.25, 0.25), prism(HIGH, 0, 1)]
    with pytest.raises(mo.CaseError, match=r"wall\.json: .*'2'"):
        read(file(assembly(aside, {0})))
    scene = read(file(assembly(aside, {0})), along="y")
    assert [block.weight for block in scene.blocks[1:]] == pytest.approx([10, 45])
    behind = [prism(BASE, -1, 1), prism(LOW, -0.25, 0.25), prism(HIGH, 0.25, 1)]
    with pytest.raises(mo.CaseError, match=r"'2'.*'1'"):
        read(file(assembly(behind, {0})), along="y")


def test_single_precision_and_triangles(file):
    """The mesh of a portal has coordinates of seven digits and ends in triangles."""
    mesh = prism([(x / 3, y / 3) for x, y in PORTAL], 0.1, 0.4)
    mesh["vertex"] = {
        key: {axis: float(f"{value:.7g}") for axis, value in point.items()}
        for key, point in mesh["vertex"].items()
    }
    ends = [[0, 1, 2, 7], [2, 3, 6, 7], [3, 4, 5, 6]]
    del mesh["face"]["0"], mesh["face"]["1"]
    for number, (a, b, c, d) in enumerate(ends):
        mesh["face"] |= {f"a{number}": [a, b, c], f"b{number}": [a, c, d]}
        mesh["face"] |= {f"c{number}": [d + 8, c + 8, b + 8], f"d{number}": [d + 8, b + 8, a + 8]}
    scene = read(file(assembly([prism(BASE, 0.1, 0.4), mesh], {0})))
    assert scene.blocks[1].weight == pytest.approx(10 * 8 / 9 * 0.3, rel=1e-6)
    assert len(contacts_of(scene).extent) == 2


def test_holes_through_a_block(file):
    """A frame, [-2, 4] × [-1, 4], has a hole around the stones. Each end of the frame is four faces."""
    outer, inner = [(-2, -1), (4, -1), (4, 4), (-2, 4)], [(-1, 0), (3, 0), (3, 3), (-1, 3)]
    frame, hole = prism(outer), prism(inner)
    for key, point in hole["vertex"].items():
        frame["vertex"][f"1{key}"] = point
    ring = [0, 1, 2, 3]
    sides = {f"in{i}": [10 + i, 10 + (i + 1) % 4, 14 + (i + 1) % 4, 14 + i] for i in ring}
    ends = {
        f"{z}{i}": [i + z, (i + 1) % 4 + z, 10 + (i + 1) % 4 + z, 10 + i + z] for i in ring for z in (0, 4)
    }
    del frame["face"]["0"], frame["face"]["1"]
    frame["face"] |= sides | ends
    sill = prism([(-2, -2), (4, -2), (4, -1), (-2, -1)])
    scene = read(file(assembly([frame, prism(LOW), sill], {2})))
    assert scene.blocks[0].weight == pytest.approx(10 * (30 - 12) * 0.5)
    assert len(scene.blocks[0].holes) == 1
    assert len(contacts_of(scene).extent) == 2


def test_transformations_of_elements(file):
    data = model([prism(BASE), prism(LOW), prism(LOW)], {0})
    element = data["data"]["elements"]["guid-2"]["data"]
    # The matrix is a quarter turn about y (x to -z, z to x), then a translation onto the lower stone.
    matrix = [[0, 0, 1, 0.5], [0, 1, 0, 0], [-1, 0, 0, 3], [0, 0, 0, 1]]
    element["transformation"] = wrapped("compas.geometry/Transformation", {"matrix": matrix})
    scene = read(file(data))
    assert_outline(scene.blocks[2], [(0.5, 1), (1.5, 1), (1.5, 3), (0.5, 3)])
    data["data"]["transformation"] = element["transformation"]
    with pytest.raises(mo.CaseError, match=r"wall\.json: "):
        read(file(data))


def test_supports_by_name_and_by_a_mesh_of_a_list(file):
    meshes = [wrapped("compas.datastructures/Mesh", prism(outline)) for outline in (BASE, LOW)]
    assert [block.fixed for block in read(file(meshes), fixed=["0"]).blocks] == [True, False]
    meshes[0]["data"]["attributes"]["is_support"] = True
    assert [block.fixed for block in read(file([[mesh] for mesh in meshes])).blocks] == [True, False]
    del meshes[0]["data"]["attributes"]["is_support"]
    for fixed in ([], ["ground"]):
        with pytest.raises(mo.CaseError, match=r"wall\.json: .*0, 1"):
            read(file(meshes), fixed=fixed)


@pytest.mark.parametrize("as_objects", [False, True])
@pytest.mark.parametrize("upright", [False, True])
def test_polygons_are_taken_as_they_are(file, as_objects, upright):
    """Polygons are in the xy plane or vertical in space, and their unit weights are per area."""
    rings = [[(x, 0.3, y) if upright else (x, y) for x, y in [*ring, ring[0]]] for ring in (BASE, PORTAL)]
    if as_objects:
        rings = [wrapped("compas.geometry/Polygon", {"points": ring}) for ring in rings]
    scene = read(file(rings), fixed=["0"])
    (portal,) = scene.blocks[1:]
    assert_outline(portal, PORTAL)
    assert portal.unit_weight == 10
    assert portal.live_per_weight == (1, 0)
    assert mo.solve(scene, "static").required() == pytest.approx(0.5, rel=1e-6)


def wedge():
    """Return a prism whose far end is shifted along x, so that its sides are inclined."""
    mesh = prism(LOW)
    for key in "4567":
        mesh["vertex"][key]["x"] += 0.1
    return mesh


def stepped():
    """Return a prism with half of its far end moved back."""
    mesh = prism([(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1)])
    mesh["vertex"] |= {"12": {"x": 1, "y": 0.25, "z": 0}, "13": {"x": 1, "y": 0.25, "z": 1}}
    mesh["vertex"]["8"]["y"] = mesh["vertex"]["9"]["y"] = 0.25
    mesh["face"]["1"] = [6, 7, 10, 11]
    mesh["face"] |= {"s": [12, 8, 9, 13], "t": [7, 12, 13, 10]}
    return mesh


WRONG_BLOCKS = {
    "a wedge": wedge(),
    "a step": stepped(),
    "an open end": {**prism(LOW), "face": {k: f for k, f in prism(LOW)["face"].items() if k != "1"}},
    "one face": {**prism(LOW), "face": {"0": [0, 1, 2, 3]}},
    "no faces": {**prism(LOW), "face": {}},
    "a corner that is not there": {**prism(LOW), "face": {"0": [0, 1, 99]}},
    "no number": {**prism(LOW), "vertex": {"0": {"x": "left"}}},
    "nothing": None,
    "a box": wrapped("compas.geometry/Box", {"xsize": 1, "ysize": 1, "zsize": 1}),
}


@pytest.mark.parametrize("wrong", WRONG_BLOCKS.values(), ids=WRONG_BLOCKS)
def test_what_is_no_prism_is_named(file, wrong):
    for along in (None, "y"):
        with pytest.raises(mo.CaseError, match=r"wall\.json: .*'1'"):
            read(file(assembly([prism(BASE), wrong, prism(HIGH)], {0})), along=along)


def test_a_stack_of_boxes_has_two_directions(file):
    """Cubes are prisms both along x and along y, so the option 'along' is needed."""
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    cubes = [prism(square, 0, 1), prism([(x, y + 1) for x, y in square], 0, 1)]
    with pytest.raises(mo.CaseError, match=r"along y.*along x.*'along'"):
        read(file(assembly(cubes, {0})))
    for along in ("x", "y"):
        assert read(file(assembly(cubes, {0})), along=along).blocks[1].weight == pytest.approx(10)


def test_what_lies_down_is_seen_from_above_if_asked(file):
    lying = [prism(outline, order="xyz") for outline in (BASE, LOW)]
    assert_outline(read(file(assembly(lying, {0})), along="z").blocks[1], LOW)
    for along in ((1, 0, 1), "sideways"):
        with pytest.raises(mo.CaseError, match="'along'"):
            read(file(assembly(lying, {0})), along=along)


@pytest.mark.parametrize("content", [b"", b'{"dtype": "compas', b"\x00\xff\xfe", b"[" * 100_000])
def test_files_that_are_no_json(tmp_path, content):
    path = tmp_path / "broken.json"
    path.write_bytes(content)
    with pytest.raises(mo.CaseError, match=r"broken\.json: "):
        read(path)
    with pytest.raises(mo.CaseError):
        read(tmp_path / "wall.obj")


def test_ends_in_fans_of_triangles(file):
    """Some exporters divide notched ends into fans of triangles about the first corner. Some of these
    triangles are then outside of the outline and wound the other way."""
    mesh = prism(PORTAL)
    for end in ("0", "1"):
        first, *rest = mesh["face"].pop(end)
        mesh["face"] |= {f"{end}{i}": [first, *rest[i : i + 2]] for i in range(6)}
    scene = read(file(assembly([prism(BASE), mesh], {0})))
    assert_outline(scene.blocks[1], PORTAL)
    assert scene.blocks[1].weight == pytest.approx(10 * 8 * 0.5)


GIVEN = {"friction": 0.5, "unit_weight": 10.0}


def mesh(corners, faces):
    vertex = {str(n): dict(zip("xyz", map(float, corner), strict=True)) for n, corner in enumerate(corners)}
    return {"vertex": vertex, "face": {str(n): list(face) for n, face in enumerate(faces)}}


def frustum(low, high, z0, z1):
    """Return a stone that narrows upwards, which is no prism along a horizontal direction."""
    corners = [(x, y, z) for half, z in ((low, z0), (high, z1)) for x, y in _corners(half)]
    sides = [(i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4) for i in range(4)]
    return mesh(corners, [(3, 2, 1, 0), (4, 5, 6, 7), *sides])


def _corners(half):
    return [(-half, -half), (half, -half), (half, half), (-half, half)]


def box(size, middle, xaxis=(1, 0, 0), yaxis=(0, 1, 0)):
    frame = {"dtype": "compas.geometry/Frame", "data": {"point": middle, "xaxis": xaxis, "yaxis": yaxis}}
    x, y, z = size
    return {"dtype": "compas.geometry/Box", "data": {"frame": frame, "xsize": x, "ysize": y, "zsize": z}}


def heap(*meshes, supports=(0,)):
    node = {str(n): {"block": {"data": own}, "is_support": n in supports} for n, own in enumerate(meshes)}
    return {"data": {"graph": {"data": {"node": node}}}}


def test_what_is_no_prism_of_one_wall_is_read_whole(file):
    data = heap(frustum(2, 2, -1, 0), frustum(1, 0.5, 0, 3))
    for scene in (
        mo.read_compas(file(data), **GIVEN),
        mo.read_compas(file(data), **GIVEN, live=(1, 0, 0)),
        mo.read_compas(file(data), **GIVEN, space=True),
    ):
        assert scene.dimension == 3
        # The volume of a frustum is h (A + a + sqrt(A a)) / 3.
        assert shapes(scene).size[1] == pytest.approx(3 * (4 + 1 + 2) / 3)
    pushed = mo.read_compas(file(data), **GIVEN | {"friction": 2.0}, live=(1, 0, 0))
    # It overturns about an edge of its base, at half the width of the base over the height of its centroid.
    height = 3 / 4 * (4 + 2 * 2 + 3 * 1) / (4 + 2 + 1)
    assert mo.solve(pushed, "static").required() == pytest.approx(1 / height, rel=1e-5)
    with pytest.raises(mo.CaseError, match=r"not a prism.*give 'live' three components"):
        mo.read_compas(file(data), **GIVEN, live=(1, 0))


def test_prisms_are_read_whole_if_asked(file):
    data = heap(frustum(2, 2, -1, 0), frustum(1, 1, 0, 3))
    assert mo.read_compas(file(data), **GIVEN, live=(0, 1, 0)).dimension == 3
    assert mo.read_compas(file(data), **GIVEN, along="y").dimension == 2


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (3, 2, 1, 0)])
def test_a_flat_support_is_the_top_of_a_slab(file, order):
    ground = mesh([(x, y, 0) for x, y in _corners(4)], [order])
    scene = mo.read_compas(file(heap(ground, frustum(1, 1, 0, 3))), **GIVEN, live=(1, 0, 0))
    assert scene.blocks[0].corners()[:, 2].max() == 0
    assert contacts_of(scene).extent == pytest.approx([4])
    with pytest.raises(mo.CaseError, match="block '0' is a single face"):
        mo.read_compas(file(heap(ground, frustum(1, 1, 0, 3), supports=(1,))), **GIVEN, space=True)


def test_boxes_in_courses(file):
    """The boxes are in lists of lists, and the upper box is rotated by 90° about the vertical."""
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


SKEWED = [box((1, 1, 1), (0, 0, 5), xaxis=axis) for axis in ((0, 0, 0), (0, 2, 0))]


@pytest.mark.parametrize("wrong", [box((1, 1, 0), (0, 0, 5)), *SKEWED])
def test_boxes_that_are_none_are_named(file, wrong):
    with pytest.raises(mo.CaseError, match="block '1' is a box"):
        mo.read_compas(file([box((1, 1, 1), (0, 0, 0)), wrong]), **GIVEN, fixed=["0"])


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        *(({"live": 0.1}, "COMPAS data: key 'live'"), ({"live": ()}, "live")),
        *(({"live": (1, 0), "space": True}, "live"), ({"fixed_below": "ground"}, "fixed_below")),
        *(({"along": "y", "live": (1, 0, 0)}, "along"), ({"along": 3}, "along")),
    ],
)
def test_options_that_mean_nothing_are_named(file, wrong, named):
    with pytest.raises(mo.CaseError, match=named):
        mo.read_compas(file(heap(frustum(2, 2, -1, 0), frustum(1, 0.5, 0, 3))), **GIVEN, **wrong)


@pytest.mark.parametrize("more", [{}, {"along": "y"}, {"live": (1, 0, 0)}], ids=["plane", "along y", "space"])
@pytest.mark.parametrize("number", range(6))
def test_a_missing_face_is_refused(file, more, number):
    """Faces 0 and 1 are the ends of the prism, and the others are its sides."""
    stone = prism(LOW)
    del stone["face"][str(number)]
    with pytest.raises(mo.CaseError, match=r"wall\.json: .*is not closed at its edge from"):
        read(file(assembly([prism(BASE), stone], {0})), **more)
