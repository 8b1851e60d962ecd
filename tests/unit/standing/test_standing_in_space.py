"""Whether boxes stand, what falls and how, and what would hold them, by hand."""

import math

import numpy as np
import pytest
from scenes_in_space import box_on_floor

import masonry_opt as mo
from masonry_opt.analysis import prepare
from masonry_opt.answer.infeasibility import Existence
from masonry_opt.answer.reasons import Code, Status
from masonry_opt.scene.contacts.find import find_joints

FLOOR = mo.box("floor", (-5, 2), (-5, 5), (-1, 0), fixed=True)


def scene(*blocks, friction=0.6, **keys):
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=[*blocks, FLOOR], **keys)


def told(result):
    return {reason.code: reason.values for reason in result.reasons}


def test_an_overhanging_box_falls_about_the_edge():
    """A physical pendulum: with its centroid e beyond the edge and h/2 above, α = g e / (k² + e² + h²/4) with
    k² = (a² + h²)/12, as the reaction α h/2 : g − α e is within the cone."""
    a, h, e = 1.6, 1.0, 0.4
    box = mo.box("A", (1.6, 1.6 + a), (0, 1), (0, h), weight=1.0, live=(1, 0, 0))
    result = mo.solve(scene(box), "static")
    assert result.status is Status.UNSTABLE
    assert told(result)[Code.FALLS] == {"blocks": ["A"]}
    assert told(result)[Code.NO_FRICTION_HOLDS] == {"blocks": ["A"]}
    alpha = e / ((a * a + h * h) / 12 + e * e + h * h / 4)
    assert alpha * h / 2 < 0.6 * (1 - alpha * e)
    block = result.blocks.iloc[0]
    assert block[["wx", "wy", "wz"]].to_numpy(float) == pytest.approx([0, alpha, 0], abs=1e-5)
    assert block[["vx", "vy", "vz"]].to_numpy(float) == pytest.approx(
        [alpha * h / 2, 0, -alpha * e], abs=1e-5
    )


def test_a_box_on_a_slope_needs_its_tangent():
    box = mo.box("A", (0, 1), (0, 1), (0, 1), weight=1.0, live=(1, 0, 0))
    result = mo.solve(scene(box, gravity=(0.66, 0, -1)), "static")
    held = told(result)[Code.FRICTION_WOULD_HOLD]
    assert held["pairs"] == [["A", "floor"]]
    assert held["factor"] == pytest.approx(1.1, rel=1e-3)
    assert not held["hangs"]


@pytest.mark.parametrize(("slope", "stands"), [(0.599, True), (0.601, False)])
@pytest.mark.parametrize("solver", ["clarabel", "highs"])
def test_the_cone_decides_whether_a_box_stands(slope, stands, solver):
    """Across a side, 7.5° off an axis, the polygon would hold up to 0.6 cos(π/24) = 0.5949 alone."""
    box = mo.box("A", (0, 1), (0, 1), (0, 1), weight=1.0, live=(0, 0, -1))
    gravity = (slope * math.cos(math.radians(7.5)), slope * math.sin(math.radians(7.5)), -1)
    result = mo.solve(scene(box, gravity=gravity), "static", solver=solver)
    assert (Code.FALLS not in told(result)) is stands
    assert 0.6 * math.cos(math.pi / 24) < 0.599


def test_what_hangs_is_named():
    box = mo.box("A", (0, 1), (0, 1), (-2, -1), weight=1.0, live=(1, 0, 0))
    result = mo.solve(scene(box), "mcp")
    assert told(result)[Code.HANGS] == {"blocks": ["A"]}
    assert told(result)[Code.FALLS] == {"blocks": ["A"]}


def between_walls(live):
    walls = (mo.box(f"wall {x}", (x, x + 1), (-1, 2), (0, 2), fixed=True) for x in (-1, 1))
    return scene(mo.box("A", (0, 1), (0, 1), (0, 1), weight=1.0, live=live), *walls)


def test_friction_between_walls_clamps_and_joints_are_named():
    """Pulled along the walls: associative flow has no room to open, and any clamping carries any load."""
    result = mo.solve(between_walls((0, 1, 0)), "static")
    assert result.status is Status.LOCKED
    assert result.infeasibility.existence is Existence.UNBOUNDED
    # Numbers of joints, not of contact points: three, with walls and floor.
    assert set(result.infeasibility.clamped) <= {0, 1, 2}
    points = np.array(result.solution.infeasibility.clamped)
    assert len(points) > 3
    assert set(result.infeasibility.clamped) == set(result.contacts["joint"].iloc[points])
    warning = next(w for w in result.warnings if w.code is Code.HELD_BY_CLAMPING)
    named = {name for pair in warning.values["pairs"] for name in pair}
    assert {"A", "wall -1", "wall 1"} <= named


def test_contacts_are_found_once_while_joints_alone_change(monkeypatch):
    found, session = [], prepare("static", keeps=True)

    def counted(*of, **how):
        found.append(of)
        return find_joints(*of, **how)

    monkeypatch.setattr("masonry_opt.problem.assembly.find_joints", counted)
    box = box_on_floor((2, 2, 1), 0.5)
    for friction in (0.3, 0.4, 0.45):
        changed = box.model_copy(update={"joints": mo.JointDefaults(friction=friction)})
        assert session.solve(changed).load_factor == pytest.approx(friction, rel=1e-6)
    assert len(found) == 1


def test_a_box_with_unlimited_friction_can_fall():
    """Without points that slide there is no cone."""
    box = mo.box("A", (1.6, 3.2), (0, 1), (0, 1), weight=1.0, live=(1, 0, 0))
    result = mo.solve(scene(box, friction=math.inf), "static")
    assert told(result)[Code.FALLS] == {"blocks": ["A"]}
