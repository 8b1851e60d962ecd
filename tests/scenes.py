"""Scenes and paths that several tests share."""

from __future__ import annotations

from pathlib import Path

import masonry_opt as mo

CASES = Path(__file__).parent.parent / "cases"
ALL_CASES = sorted(CASES.glob("*/*.toml"))


def block_on_floor(
    width: float = 1.0, height: float = 2.0, friction: float = 0.6, **block: object
) -> mo.Scene:
    """One block of weight 1 on a fixed floor, live load = weight to the right at its centroid."""
    corners = [(0, 0), (width, 0), (width, height), (0, height)]
    properties = {"weight": 1.0, "live": (1.0, 0.0)} | block
    return mo.Scene(
        joints=mo.JointDefaults(friction=friction),
        blocks=[
            mo.Block(name="A", vertices=corners, **properties),
            mo.Block(name="floor", vertices=[(-5, -1), (6, -1), (6, 0), (-5, 0)], fixed=True),
        ],
    )


def two_blocks(friction: float = 0.1) -> mo.Scene:
    """Fig. 6 of the paper: B rests on a rough support and on A, which is pushed out."""
    rough = float("inf")
    return mo.Scene(
        joints=mo.JointDefaults(friction=friction),
        blocks=[
            mo.Block(name="A", vertices=[(2, 0), (5, 0), (5, 1), (2, 1)], weight=1, live=(1, 0)),
            mo.Block(name="B", vertices=[(0, 1), (3, 1), (3, 2), (0, 2)], weight=1),
            mo.Block(name="floor", vertices=[(1, -1), (9, -1), (9, 0), (1, 0)], fixed=True),
            mo.Block(name="support", vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], fixed=True),
        ],
        exceptions=[mo.Joint(between=("B", "support"), friction=rough)],
    )


def small_wall(courses: int = 4, length: int = 3, friction: float = 0.65, **joints: float) -> mo.Scene:
    """A running-bond wall of 4 × 1.75 blocks, live load = weight, horizontal."""
    half = [0.5, *[1.0] * (length - 1), 0.5]
    full = [1.0] * length
    wall = mo.Wall(
        block=(4, 1.75),
        weight=1,
        live=(1, 0),
        courses=[half if row % 2 == 0 else full for row in range(courses)],
    )
    return mo.Scene(joints=mo.JointDefaults(friction=friction, **joints), blocks=wall.blocks())
