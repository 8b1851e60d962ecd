"""Scene for tests of crossings: a slab that overhangs its support on both sides, and axles on a road over
it."""

import masonry_opt as mo

ROAD = [(-5, 1), (5, 1)]
WEIGHT = 12.0


def slab(name="slab", left=-1.0, **keys):
    """Return a block of width 2 and height 1 whose left edge is at x = `left`."""
    right = left + 2
    return mo.Block(name=name, vertices=[(left, 0), (right, 0), (right, 1), (left, 1)], weight=WEIGHT, **keys)


def support(left, right):
    return mo.Block(
        name=f"support {left}", vertices=[(left, -1), (right, -1), (right, 0), (left, 0)], fixed=True
    )


#: The slab overhangs its support by 0.5 on each side.
OVERHANG = mo.Scene(joints={"friction": 0.5}, blocks=[slab(), support(-0.5, 0.5)])


def axles(*loads, distances=(), **keys):
    return mo.Axles(**{"name": "a", "road": ROAD} | keys, loads=list(loads), distances=list(distances))


def interrupts(positions):
    """Return a progress callback that appends positions to `positions` and raises KeyboardInterrupt at the
    third."""

    def third(position, load_factor):
        positions.append(position)
        if len(positions) == 3:
            raise KeyboardInterrupt

    return third
