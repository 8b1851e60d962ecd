"""Outlines and functions for tests that write and read DXF drawings."""

import masonry_opt as mo

FLOOR = [(-9, -1), (9, -1), (9, 0), (-9, 0)]
STONE = [(0, 0), (4, 0), (4, 1), (0, 1)]


def polylines(*rings, layer="stone"):
    def make(space):
        for ring in rings:
            space.add_lwpolyline(ring, close=True, dxfattribs={"layer": layer})

    return make


def read(path, **more):
    return mo.read_dxf(path, **({"friction": 0.5, "unit_weight": 2.0, "live": (1, 0)} | more))
