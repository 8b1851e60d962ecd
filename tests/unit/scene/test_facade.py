"""The ``[facade]`` generator, counted by hand on a façade of 30 blocks."""

import itertools

import pytest

import masonry_opt as mo

TINY = {
    "openings": (1, 1),
    "block": (2.0, 1.0),
    "jamb": 2,
    "opening": (1, 2),
    "sill": 1,
    "spandrel": 2,
    "weight": 3.0,
    "lintel_weight": 5.0,
    "live": (1.0, 0.0),
}


def facade(**changed):
    return mo.Facade(**TINY | {"omit_top_left": True} | changed)


def courses(built):
    """Blocks by course, bottom first, without the base."""
    rows = {}
    for block in built.blocks()[:-1]:
        rows.setdefault(int(block.name.split("-")[0]), []).append(block)
    return [rows[number] for number in sorted(rows)]


def test_blocks_are_those_counted_by_hand():
    """Five blocks wide, six courses. Sill: 5 whole. Opening: half, 1, half on either side; then 2 on
    either side. Lintel: half, 1, lintel (which bears half a block left and right), 1, half. Spandrel: 5
    whole; half, 4, half, of which the leftmost is left away."""
    assert [len(course) for course in courses(facade())] == [5, 6, 4, 5, 5, 5]
    assert len(courses(mo.Facade(**TINY))[-1]) == 6  # nothing is left away unless asked


def test_jambs_are_straight_and_the_lintel_spans_the_opening():
    rows = courses(facade())
    for course in rows[1:3]:
        ends = {x for block in course for x, _ in block.vertices}
        assert {4.0, 6.0} <= ends  # from two to three blocks of length 2
        assert not any(4.0 < x < 6.0 for x in ends)
    lintel = rows[3][2]
    assert lintel.vertices == [(3.0, 3.0), (7.0, 3.0), (7.0, 4.0), (3.0, 4.0)]
    assert lintel.weight == 5.0
    assert lintel.live_per_weight == (1.0, 0.0)


def test_joints_are_those_counted_by_hand():
    """Joints within courses, and between each course and what it lies on."""
    rows = courses(facade())
    within = sum(
        left.vertices[1][0] == right.vertices[0][0]
        for course in rows
        for left, right in itertools.pairwise(course)
    )
    assert within == 4 + 4 + 2 + 4 + 4 + 4  # two of these courses have a gap
    # On the base 5. Jamb courses on wholes, and wholes on them: 1 + 2 + 1 on either side, twice. The
    # lintel's course on wholes: 1 + 2 on either side and the lintel's two bearings. Wholes on that: 2 each,
    # but the middle one lies on the lintel alone. Half blocks on wholes, the leftmost left away: 4 · 2 + 1.
    between = 5 + 8 + 8 + 8 + 9 + 9
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.75), blocks=facade().blocks())
    size = mo.solve(scene, "static").size
    assert (size.blocks, size.joints) == (30, within + between)


def test_a_door_reaches_the_ground():
    """The opening of a façade of two, sills of three courses, counted by hand: twelve blocks wide, eight
    courses. The door leaves 2 blocks and half blocks at its jambs in the shifted course; the window's own
    sill stays, and the storey above has none."""
    keys = {"openings": (2, 2), "sill": 3, "opening": (2, 2), "spandrel": 2, "omit_top_left": False}
    closed, open_ = facade(**keys), facade(**keys, doors=[2])
    assert closed.width == 12
    assert [len(course) for course in courses(closed)[:3]] == [12, 13, 12]
    # The door spans blocks 8 to 10. Left of it 8 whole, right of it 2; shifted: a half, 7, a half, and as of
    # every jamb a half, 1, a half.
    assert [len(course) for course in courses(open_)[:3]] == [10, 12, 10]
    for course in courses(open_)[:5]:
        ends = {x for block in course for x, _ in block.vertices}
        assert {16.0, 20.0} <= ends
        assert not any(16.0 < x < 20.0 for x in ends)
    # What is gone weighs as much as the blocks that fill it, 2 in each of 3 courses; else all is as it was.
    without, weight = (sum(block.weight or 0 for block in one.blocks()) for one in (closed, open_))
    assert without - weight == pytest.approx(6 * 3.0)
    for below, above in zip(courses(closed)[3:], courses(open_)[3:], strict=True):
        assert [block.vertices for block in below] == [block.vertices for block in above]
    # Two piers on the ground carry it all.
    scene = mo.Scene(joints={"friction": 0.75}, blocks=open_.blocks())
    joints = mo.solve(scene, "static").joints
    on_base = joints[(joints["first"] == "base") | (joints["second"] == "base")]
    assert len(on_base) == 10
    assert on_base["n"].sum() == pytest.approx(weight, rel=1e-7)
