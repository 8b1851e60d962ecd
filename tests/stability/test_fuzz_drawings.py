"""Tests of broken drawings: whatever they contain, a scene or a message results, never a traceback."""

import copy
import json
import logging
import random

import ezdxf
import pytest
from meshes import box
from stability.test_fuzz import places

import masonry_opt as mo
from masonry_opt.errors import MasonryError

VALUES = [b"nan", b"inf", b"-1e400", b"1e308", b"", b"0", b"-1", b"9" * 30, b"\xff\xfe", b"abc", b"10", b"70"]
VALUES += [b"LWPOLYLINE", b"SPLINE", b"INSERT", b"ENDSEC", b"EOF"]
THINGS = [None, True, -1, 0, 1e308, float("nan"), "", "x", [], {}, [[]], [1, 2], {"data": {}}, 2**70, [["a"]]]


@pytest.fixture(autouse=True)
def without_log(caplog):
    """Suppress the log of ezdxf: broken texts in it cannot be sent between the processes of a test run."""
    caplog.set_level(logging.CRITICAL + 1, "ezdxf")


@pytest.fixture(scope="module")
def drawings(tmp_path_factory):
    """Return one drawing of stones in DXF twice: as text, and as a binary file."""
    document = ezdxf.new("R2010")
    space = document.modelspace()
    ground = [(-2, -1), (4, -1), (4, 0), (-2, 0)]
    space.add_lwpolyline([(0, 0, 0), (2, 0, 0.2), (2, 1, 0), (0, 1, -0.1)], format="xyb", close=True)
    space.add_polyline2d([(0, 1), (2, 1), (2, 2), (0, 2)], close=True)
    space.add_lwpolyline(ground, close=True, dxfattribs={"layer": "fixed"})
    space.add_line((0, 2), (1, 2))
    space.add_arc((0.5, 2), 0.5, 0, 180)
    space.add_circle((1.5, 2.5), 0.2)
    space.add_ellipse((3, 0.5), (0.5, 0), 0.5)
    space.add_open_spline([(2.2, 2), (3, 2), (3, 3), (2.2, 2)])
    space.add_text("A", height=0.1).set_placement((1, 0.5))
    space.add_mtext("B").set_location((1, 1.5))
    written = []
    for kind in ("asc", "bin"):
        path = tmp_path_factory.mktemp("drawings") / f"{kind}.dxf"
        document.saveas(path, fmt=kind)
        written.append(path.read_bytes())
    return written


def broken(data, rng):
    """Return data that is cut, or has other bytes, or has other lines, most of them among the entities."""
    kind = rng.random()
    if kind < 0.2:
        return data[: rng.randrange(len(data))]
    if kind < 0.4:
        changed = bytearray(data)
        for _ in range(rng.randint(1, 20)):
            changed[rng.randrange(len(changed))] = rng.randrange(256)
        return bytes(changed)
    lines = data.split(b"\n")
    entities = lines.index(b"ENTITIES") if b"ENTITIES" in lines else 0
    for _ in range(rng.randint(1, 3)):
        number = rng.randrange(entities if rng.random() < 0.8 else 0, len(lines))
        if rng.random() < 0.7:
            lines[number] = rng.choice(VALUES)
        elif len(lines) > 1:
            del lines[number]
            entities = min(entities, len(lines) - 1)
    return b"\n".join(lines)


def ends_in_message(read, path):
    """Return True if reading ended in a message, which names the file, and False if it returned a scene."""
    message = ""
    try:
        scene = read(path, friction=0.6, unit_weight=1.0, live=(1, 0))
    except MasonryError as error:
        message = str(error)
    assert str(path) in message if message else isinstance(scene, mo.Scene)
    return bool(message)


@pytest.mark.slow
def test_broken_dxf_ends_with_a_message(drawings, tmp_path):
    rng = random.Random(7)
    path = tmp_path / "broken.dxf"
    path.write_bytes(drawings[0])
    assert not ends_in_message(mo.read_dxf, path)
    messages = 0
    for number in range(100):
        path.write_bytes(broken(drawings[number % 4 == 0], rng))
        messages += ends_in_message(mo.read_dxf, path)
    assert 50 < messages < 100


@pytest.mark.slow
def test_broken_compas_data_ends_with_a_message(tmp_path):
    rng = random.Random(7)

    def node(height, **more):
        corners, faces = box((height / 2, 2 + height / 2), (0, 1), (height, height + 1))
        vertex = {n: dict(zip("xyz", corner, strict=True)) for n, corner in enumerate(corners.tolist())}
        return {"block": {"data": {"vertex": vertex, "face": dict(enumerate(faces))}}, **more}

    nodes = {"0": node(0, is_support=True), "1": node(1)}
    whole = json.loads(json.dumps({"data": {"graph": {"data": {"node": nodes}}}}))
    path = tmp_path / "broken.json"
    path.write_text(json.dumps(whole))
    assert not ends_in_message(mo.read_compas, path)

    messages = 0
    for _ in range(100):
        data = copy.deepcopy(whole)
        inner, key = rng.choice([*places(data)])
        if rng.random() < 0.8:
            inner[key] = rng.choice(THINGS)
        else:
            del inner[key]
        text = json.dumps(data)
        path.write_text(text[: rng.randrange(len(text))] if rng.random() < 0.1 else text)
        messages += ends_in_message(mo.read_compas, path)
    assert 50 < messages < 100
