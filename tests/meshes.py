"""Mesh files as modelling programs write them: OBJ, PLY, STL and glTF."""

import json
import struct
from itertools import pairwise

import numpy as np

QUADS = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]


def box(x, y, z):
    """Return the corners and faces of a box; faces are counter-clockwise as seen from outside."""
    corners = [(a, b, c) for c in z for a, b in ((x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1]))]
    return np.array(corners, dtype=float), QUADS


def damaged_copies(data):
    """Yield 60 copies of a file, in each of which one to five random bytes are replaced."""
    rng = np.random.default_rng(0)
    for _ in range(60):
        damaged = bytearray(data)
        for position in rng.integers(len(data), size=rng.integers(1, 6)):
            damaged[position] = rng.integers(256)
        yield bytes(damaged)


def divided_box(x, y, z, count):
    """Return the corners and triangles of a box whose sides have count × count pairs of triangles each."""
    low, high = np.array([x, y, z], dtype=float).T
    numbers, faces = {}, []
    for axis in range(3):
        for end in (0, 1):
            for row, column in np.ndindex(count, count):
                quad = []
                for across, up in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    share = np.roll([end, (row + across) / count, (column + up) / count], axis)
                    quad.append(numbers.setdefault(tuple(share), len(numbers)))
                own = [(quad[0], quad[1], quad[2]), (quad[0], quad[2], quad[3])]
                faces += own if end else [face[::-1] for face in own]
    return low + np.array(list(numbers)) * (high - low), faces


def prism(outline, depth):
    """Return a prism over a polygon in x and z, from y = 0 to a depth.

    Each of its two ends is one face, even if the polygon is not convex.
    """
    count = len(outline)
    corners = [(x, y, z) for y in (0.0, depth) for x, z in outline]
    sides = [(i, i + count, (i + 1) % count + count, (i + 1) % count) for i in range(count)]
    return np.array(corners), [tuple(range(count)), tuple(range(2 * count - 1, count - 1, -1)), *sides]


def obj(blocks, digits=9, word="o"):
    lines, first = ["# stones"], 1
    for name, (corners, faces) in blocks.items():
        lines.append(f"{word} {name}")
        lines += ["v " + " ".join(f"{value:.{digits}f}" for value in corner) for corner in corners]
        lines += ["f " + " ".join(f"{first + corner}//1" for corner in face) for face in faces]
        first += len(corners)
    return "\n".join(lines).encode()


def triangles(blocks):
    for corners, faces in blocks.values():
        for face in faces:
            for second, third in pairwise(face[1:]):
                yield corners[[face[0], second, third]]


def stl(blocks):
    found = list(triangles(blocks))
    rows = [struct.pack("<12fH", *np.zeros(3), *corners.ravel(), 0) for corners in found]
    return b"\0" * 80 + struct.pack("<I", len(found)) + b"".join(rows)


def ply(blocks):
    """Return a PLY file of quadrilaterals that do not share corners, as modelling programs write it."""
    quads = [corners[list(face)] for corners, faces in blocks.values() for face in faces]
    head = (
        f"ply\nformat ascii 1.0\nelement vertex {4 * len(quads)}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {len(quads)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = [" ".join(map(str, corner)) for corner in np.concatenate(quads)]
    rows += [f"4 {4 * n} {4 * n + 1} {4 * n + 2} {4 * n + 3}" for n in range(len(quads))]
    return (head + "\n".join(rows) + "\n").encode()


def glb(nodes, meshes):
    """Return a binary glTF file, version 2.0, written directly from the standard.

    Each node is a dictionary of the standard's keys. Nodes that no other node names as a child are roots.
    Each mesh is a list of primitives, each a pair of corners and triangles.
    """
    binary, views, accessors, entries = b"", [], [], []
    for primitives in meshes:
        written = []
        for corners, faces in primitives:
            points, indices = np.asarray(corners, "<f4"), np.asarray(faces, "<u2").ravel()
            for numbers, kind, code in ((points, "VEC3", 5126), (indices, "SCALAR", 5123)):
                views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": numbers.nbytes})
                row = {"bufferView": len(views) - 1, "componentType": code, "count": len(numbers)}
                accessors.append(row | {"type": kind})
                binary += numbers.tobytes() + bytes(-numbers.nbytes % 4)
            written.append({"attributes": {"POSITION": len(views) - 2}, "indices": len(views) - 1})
        entries.append({"primitives": written})
    below = {child for node in nodes for child in node.get("children", ())}
    tree = {"asset": {"version": "2.0"}, "scene": 0, "nodes": nodes, "meshes": entries}
    tree |= {"scenes": [{"nodes": [number for number in range(len(nodes)) if number not in below]}]}
    tree |= {"bufferViews": views, "accessors": accessors, "buffers": [{"byteLength": len(binary)}]}
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    chunks = (
        struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    )
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
