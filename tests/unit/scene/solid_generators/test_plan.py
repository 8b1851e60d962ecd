"""Walls along a plan: they fill it, whole and without gaps, in bond; what cannot be bonded is refused."""

from itertools import pairwise

import numpy as np
import pytest

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble

KEYS = {"block": (2.0, 1.0), "thickness": 1.0, "courses": 4, "unit_weight": 1.0}


def wall(name, *axis, **keys):
    return {"name": name, "axis": axis} | keys


def plan(*walls, **keys):
    return mo.Plan(walls=walls, **KEYS | keys)


MAIN = wall("main", (0, 0), (10, 0))
CORNER = wall("L", (0, 0), (8, 0), (8, 6))
ROOM = wall("room", (0, 0), (7, 0), (7, 9), (0, 9), (0, 0))
DOOR = {"at": 4, "width": 2, "height": 2}
WINDOW = {"at": 1, "width": 1.5, "height": 1, "sill": 1, "bearing": 0.5}

#: Of each its plan's area and the length of its outline, and what openings take: volume, area of the foot,
#: and of all faces what they add.
FILLED = {
    "straight": (plan(MAIN), 10, 22, ()),
    "corner": (plan(CORNER), 14, 30, ()),
    "T": (plan(MAIN, wall("stem", (5.5, 0), (5.5, 6))), 15.5, 33, ()),
    "T, butted": (plan(MAIN, wall("stem", (5.5, 0), (5.5, 6)), bond="butted"), 15.5, 33, ()),
    "X, not modular": (
        plan(wall("a", (0, 0), (10.3, 0)), wall("b", (5.2, -5.15), (5.2, 6))),
        20.45,
        42.9,
        (),
    ),
    "room": (plan(ROOM), 32, 64, ()),
    "two rooms": (plan(ROOM, wall("spine", (0, 4), (7, 4))), 38, 74, ()),
    "at its face": (plan(MAIN, wall("stem", (3, 0.5), (3, 4))), 13.5, 29, ()),
    "two leaves": (plan(CORNER | {"leaves": 2}), 28, 32, ()),
    "headers": (plan(CORNER | {"leaves": 2}, headers=2), 28, 32, ()),
    "two leaves and one": (plan(MAIN | {"leaves": 2}, wall("stem", (5, 0), (5, 6)), headers=3), 25, 34, ()),
    # 2 · 2 of a door two courses high; gone are two faces and the foot, new are jambs and soffit.
    "door": (plan(MAIN | {"openings": [DOOR]}), 10, 22, (4, 2, -8 + 4 + 2 - 2)),
    "window": (plan(MAIN | {"openings": [WINDOW]}), 10, 22, (1.5, 0, -3 + 2 + 3)),
    "both": (plan(MAIN | {"openings": [DOOR, WINDOW]}), 10, 22, (5.5, 2, -4 + 2)),
    # As far along x in the one leg as along y in the other, which are different places.
    "both legs": (plan(CORNER | {"openings": [DOOR | {"at": 2}, DOOR | {"at": 10}]}), 14, 30, (8, 4, -8)),
}


@pytest.mark.parametrize("name", FILLED)
def test_blocks_fill_the_walls_and_touch_wherever_they_meet(name):
    """Faces are outside, or in one joint with as much of another: the area of all joints is half of what all
    blocks have beyond the walls' own outside, and the foot."""
    made, foot, outline, openings = FILLED[name]
    volume, of_foot, faces = openings or (0, 0, 0)
    assembly = assemble(mo.Scene(joints={"friction": 0.6}, blocks=made.blocks()))
    sizes = np.array([np.ptp(block.box, axis=1) for block in assembly.scene.in_space() if not block.fixed])
    assert np.prod(sizes, axis=1).sum() == pytest.approx(4 * foot - volume)
    surface = 2 * (sizes[:, [0, 1, 2]] * sizes[:, [1, 2, 0]]).sum()
    outside = 2 * foot + 4 * outline + faces
    assert assembly.joints.extent.sum() == pytest.approx((surface - outside) / 2 + foot - of_foot)
    assert not assembly.joints.gaps
    assert made.size >= len(sizes)


#: Plans whose lengths are all multiples of half a block, and others: length and thickness of a block, axes.
BONDED = [
    (2, 1, [MAIN, wall("stem", (5.5, 0), (5.5, 6))]),
    (2, 1, [wall("a", (0, 0), (10.3, 0)), wall("b", (5.2, -5.15), (5.2, 6))]),
    (2, 1, [ROOM, wall("spine", (0, 4), (7, 4))]),
    (0.8, 0.6, [CORNER]),
    (1, 0.25, [CORNER]),
    (1, 0.45, [CORNER, wall("stem", (2, 0), (2, 3))]),
    (1, 1, [CORNER, wall("stem", (2.3, 0), (2.3, 3))]),
    (1, 0.5, [MAIN | {"openings": [DOOR | {"height": 1}]}, wall("stem", (9, 0), (9, 6))]),
]


@pytest.mark.parametrize(("length", "thickness", "walls"), BONDED)
def test_no_upright_joint_goes_on_in_the_next_course(length, thickness, walls):
    made = plan(*walls, block=(length, 1.0), thickness=thickness)
    joints = assemble(mo.Scene(joints={"friction": 0.6}, blocks=made.blocks())).joints
    heads: list[set] = [set() for _ in range(4)]
    for joint, normal in enumerate(joints.normal):
        outline = joints.point[joints.joint == joint]
        if abs(normal[2]) < 0.5:
            low, high = outline.min(axis=0), outline.max(axis=0)
            axis = int(np.abs(normal).argmax())
            heads[round(low[2] - joints.point[:, 2].min())].add(
                (axis, low[axis], low[1 - axis], high[1 - axis])
            )
    assert all(heads)
    for below, above in pairwise(heads):
        for axis, at, low, high in below:
            on = [each for each in above if each[0] == axis and abs(each[1] - at) < 1e-6]
            assert all(min(high, each[3]) - max(low, each[2]) < 1e-6 for each in on)


def test_blocks_are_as_long_as_given_but_for_pieces_at_ends_and_crossings():
    """A wall of 10.25 blocks of 1 and a closer: the last block of every other course is longer by it."""
    made = plan(wall("w", (0, 0), (10.2, 0)), block=(1.0, 1.0), thickness=0.5)
    lengths = [round(np.ptp(block.box[0]), 9) for block in made.blocks()[:-1]]
    assert lengths[:10] == [1] * 9 + [1.2]
    assert lengths[10:21] == [0.5] + [1] * 9 + [0.7]


def test_blocks_are_named_by_wall_course_and_number_and_placed():
    made = plan(MAIN | {"openings": [DOOR]}, name="west", at=(10, 20, 30))
    blocks = {block.name: block for block in made.blocks()}
    # Under a lintel that bears a block's half, 3 to 7, in the third course.
    (lintel,) = [block for block in blocks.values() if np.ptp(block.box[0]) == 4]
    assert lintel.name == "west main 3-3"
    assert lintel.box == ((13, 17), (19.5, 20.5), (32, 33))
    assert blocks["west base"].box == ((9, 21), (18.5, 21.5), (29, 30))
    assert blocks["west base"].fixed


def test_a_lower_wall_is_crossed_no_higher():
    made = plan(MAIN, wall("low", (5, 0), (5, 4), courses=2))
    names = [block.name for block in made.blocks()]
    assert [name for name in names if name.startswith("low 3")] == []
    assert {name[:4] for name in names if " 4-" in name} == {"main"}
    top = [block.box[0] for block in made.blocks() if block.name.startswith("main 4-")]
    assert all(one[1] == other[0] for one, other in pairwise(top))


REFUSED = [
    ([wall("w", (0, 0), (3, 1))], {}, "neither along x nor along y from point no. 1"),
    ([wall("w", (0, 0), (0, 0))], {}, "neither along x"),
    ([wall("w", (0, 0), (3, 0), (5, 0))], {}, "does not turn"),
    ([wall("w", (0, 0))], {}, "axis"),
    ([MAIN, MAIN], {}, "two walls are named 'main'"),
    ([MAIN, wall("s", (0.2, 0), (0.2, 4))], {}, "'main' ends within wall 's'"),
    ([MAIN, wall("s", (3, 0.3), (3, 4))], {}, "'s' ends within wall 'main'"),
    ([MAIN, wall("s", (3, 0.3), (8, 0.3))], {}, "'main' and 's' overlap"),
    ([MAIN, wall("s", (10, 0), (14, 0)), wall("t", (10, 0), (10, 5))], {}, "'main' and 's' overlap"),
    ([wall("w", (0, 0), (0.3, 0))], {}, "0.3 long, less than a quarter"),
    ([MAIN | {"openings": [DOOR | {"at": 1.2}]}], {}, "course 3 would be 0.2 long"),
    ([MAIN | {"openings": [DOOR | {"at": 8}]}], {}, "opening no. 1.*beyond the wall"),
    ([MAIN | {"openings": [DOOR | {"height": 4}]}], {}, "ends at course 5, of 4"),
    ([MAIN | {"openings": [DOOR, DOOR | {"at": 7}]}], {}, "no. 1 and no. 2 overlap"),
    ([MAIN | {"openings": [DOOR]}, wall("s", (5, 0), (5, 4))], {}, "into one that crosses"),
    ([MAIN], {"headers": 2}, "'leaves = 2'"),
    ([MAIN | {"leaves": 3}], {}, "leaves"),
    ([MAIN], {"block": (1e-4, 1)}, "blocks large"),
    ([], {}, "walls"),
]


@pytest.mark.parametrize(("walls", "keys", "words"), REFUSED)
def test_what_cannot_be_built_is_refused(walls, keys, words):
    with pytest.raises(mo.CaseError, match=words):
        plan(*walls, **keys)
