"""A slab that reaches beyond its support on either side, and axles over a road on it."""

import masonry_opt as mo

ROAD = [(-5, 1), (5, 1)]
WEIGHT = 12.0


def slab(name="slab", left=-1.0, **keys):
    """A block 2 wide and 1 high, from its left end."""
    right = left + 2
    return mo.Block(name=name, vertices=[(left, 0), (right, 0), (right, 1), (left, 1)], weight=WEIGHT, **keys)


def support(left, right):
    return mo.Block(
        name=f"support {left}", vertices=[(left, -1), (right, -1), (right, 0), (left, 0)], fixed=True
    )


#: A slab that reaches .5 beyond its support on either side.
OVERHANG = mo.Scene(joints={"friction": 0.5}, blocks=[slab(), support(-0.5, 0.5)])


def axles(*loads, distances=(), **keys):
    return mo.Axles(**{"name": "a", "road": ROAD} | keys, loads=list(loads), distances=list(distances))


def interrupts(told):
    """Progress of a crossing that ends like Ctrl-C at the third position, and keeps those."""

    def third(position, load_factor):
        told.append(position)
        if len(told) == 3:
            raise KeyboardInterrupt

    return third
