"""The certificate can be recomputed from the JSON of a result alone, without any other part of the package.

The sums of forces and moments, yield conditions, flow rule and energy are written here again, according to
the documented meaning of the keys. The residuals agree with those of the certificate, which are below 1e-8.
"""

import json
import math
from typing import Any

import numpy as np
import pytest

import masonry_opt as mo
from masonry_opt.scene.blocks import rectangle

#: Bounds of the residuals of exact states, and of associative programs solved to 1e-9, relative to the loads.
EXACT = 1e-8
SOLVED = 1e-6


def wall_under_fill() -> mo.Scene:
    """Return two stacks that are tied to each other under a fill, which presses on both sides. The loads act
    at a point and along an edge, and the joints have cohesion."""
    blocks = [
        mo.Block(name="left", vertices=rectangle(0, 1, 0, 2), unit_weight=20.0, live=(3.0, -1.0)),
        mo.Block(name="left top", vertices=[(0, 2), (1, 2), (1, 3.2), (0, 3)], unit_weight=20.0),
        mo.Block(name="right", vertices=rectangle(2.5, 3.3, 0, 2.2), unit_weight=22.0),
        mo.Block(name="ground", vertices=rectangle(-5, 8, -1, 0), fixed=True),
    ]
    load = mo.Load(block="left top", dead=(1.0, -4.0), live=(2.0, 0.5), at=(0.7, 2.5))
    edge = mo.EdgeLoad(start=(2.5, 2.2), end=(3.3, 2.2), pressure=(2.0, 5.0))
    fill = mo.Fill(road=[(-3, 3.6), (6, 3.6)], unit_weight=17.0, friction_angle=32, mobilised=0.4)
    tie = mo.Tie(between=("left top", "right"), at=((0.5, 2.4), (2.9, 1.4)), strength=9.0, prestress=1.0)
    prop = mo.Prop(between=("right", "ground"), at=((3.2, 1.0), (5.0, -0.5)), strength=4.0)
    return mo.Scene(
        joints=mo.JointDefaults(friction=0.55, cohesion=0.4),
        blocks=blocks,
        loads=[load],
        edge_loads=[edge],
        fills=[fill],
        ties=[tie],
        props=[prop],
        thickness=1.7,
    )


def tied_boxes() -> mo.Scene:
    """Return two boxes in space, one on the other, pushed obliquely and tied to the ground by a rod."""
    blocks = [
        mo.Solid(name="lower", box=[[0, 2], [0, 1.5], [0, 1]], unit_weight=18.0, live=(2.0, 1.0, 0.0)),
        mo.Solid(name="upper", box=[[0.2, 1.8], [0.1, 1.3], [1, 2.2]], weight=20.0, live=(3.0, -0.5, 0.2)),
        mo.Solid(name="ground", box=[[-5, 9], [-5, 9], [-1, 0]], fixed=True),
    ]
    load = mo.Load(block="upper", dead=(0.5, 0.2, -3.0), live=(1.0, 0.0, 0.0), at=(1.0, 0.5, 2.2))
    rod = mo.Tie(between=("upper", "ground"), at=((1.0, 0.7, 1.5), (-2.0, 1.0, -0.5)), strength=4.0)
    joints = mo.JointDefaults(friction=0.5, cohesion=0.3)
    return mo.Scene(joints=joints, blocks=blocks, loads=[load], ties=[rod])


def read(scene: mo.Scene, method: str) -> dict[str, Any]:
    return json.loads(mo.solve(scene, method, incremental=False).to_json())


def vector(row: dict[str, Any], *names: str) -> np.ndarray:
    return np.array([row[name] for name in names], dtype=float)


def pulls(record: dict[str, Any]) -> list[tuple[str, str, np.ndarray, np.ndarray]]:
    """Return both blocks, the point and the force on the first block, for all ties, props and fill
    pressures."""
    axes = "xyz" if "contact_results" in record else "xy"
    rows = record.get("tie_results", []) + record.get("pressure_results", [])
    at, unit = [*axes], [f"u{axis}" for axis in axes]
    return [
        (row["first"], row["second"], vector(row, *at), row["force"] * vector(row, *unit)) for row in rows
    ]


def presses(record: dict[str, Any]) -> list[tuple[str, str, np.ndarray, np.ndarray, float]]:
    """Return both blocks, the point, and the force and moment on the first block, for all joints. In space,
    each contact point has an entry without a moment."""
    if "contact_results" in record:
        forces = ("fx", "fy", "fz")
        return [
            (row["first"], row["second"], vector(row, *"xyz"), vector(row, *forces), 0.0)
            for row in record["contact_results"]
        ]
    found = []
    for row in record["joint_results"]:
        normal = vector(row, "nx", "ny")
        along = np.array([normal[1], -normal[0]])
        force = row["n"] * normal + row["s"] * along
        found.append((row["first"], row["second"], vector(row, "x", "y"), force, row["m"]))
    return found


def turning(arm: np.ndarray, force: np.ndarray) -> np.ndarray:
    if len(arm) == 2:
        return np.array([arm[0] * force[1] - arm[1] * force[0]])
    return np.cross(arm, force)


def out_of_balance(record: dict[str, Any]) -> dict[str, np.ndarray]:
    """Return the sum of all forces and of all moments about the centroid, for each block."""
    space = "contact_results" in record
    axes, moments = ("xyz", ["mx", "my", "mz"]) if space else ("xy", ["moment"])
    names = [*(f"f{axis}" for axis in axes), *moments]
    rows = record["block_results"]
    centroid = {row["block"]: vector(row, *axes) for row in rows}
    total = {
        row["block"]: vector(row, *(f"dead_{name}" for name in names))
        + record["load_factor"] * vector(row, *(f"live_{name}" for name in names))
        for row in rows
    }
    acting = [*presses(record), *((*pull, 0.0) for pull in pulls(record))]
    for first, second, at, force, moment in acting:
        for block, sign in ((first, 1.0), (second, -1.0)):
            if block in total:
                turns = turning(at - centroid[block], force) + (0.0 if space else moment)
                total[block] += sign * np.concatenate([force, turns])
    for row in record.get("support_results", []):
        total[row["block"]] += vector(row, *names)
    return total


def least_slack(record: dict[str, Any]) -> float:
    """Return the least slack of all limits: friction, tension, rocking and limited forces."""
    slacks = []
    for row in record.get("contact_results", record["joint_results"]):
        slacks.append(row["n"])
        if row["friction"] is not None:
            slacks.append(row["cohesion_force"] + row["friction"] * row["n"] - abs(row["s"]))
        if "m" in row:
            slacks.append(row["n"] * row["length"] / 2 - abs(row["m"]))
    for row in record.get("tie_results", []) + record.get("pressure_results", []):
        slacks.append(row["force"] - row["lowest"])
        slacks.append(math.inf if row["highest"] is None else row["highest"] - row["force"])
    return min(slacks)


def weights(record: dict[str, Any], dimension: int) -> np.ndarray:
    """Return the size of the dead load of each block."""
    names = [f"dead_f{axis}" for axis in "xyz"[:dimension]]
    return np.array([np.linalg.norm(vector(row, *names)) for row in record["block_results"]])


@pytest.mark.parametrize(
    ("make", "method", "within"),
    [
        (wall_under_fill, "coulomb", EXACT),
        (wall_under_fill, "static", SOLVED),
        pytest.param(tied_boxes, "coulomb", EXACT, marks=pytest.mark.slow),
        (tied_boxes, "static", SOLVED),
    ],
)
def test_forces_balance_and_respect_every_limit(make, method, within):
    record = read(make(), method)
    dimension = 3 if "contact_results" in record else 2
    loads = weights(record, dimension)
    left = np.concatenate(list(out_of_balance(record).values()))
    assert np.abs(left).max() <= within * loads.sum()
    assert least_slack(record) >= -within * np.median(loads)
    assert record["certificate"]["equilibrium"] <= within
    assert record["certificate"]["yield"] <= within


def test_without_the_pressure_of_fill_forces_do_not_balance():
    """Without the table of pressures, the check of equilibrium fails."""
    record = read(wall_under_fill(), "coulomb")
    assert len(record["pressure_results"]) >= 3
    pushed = sum(row["force"] for row in record["pressure_results"])
    del record["pressure_results"]
    left = np.concatenate(list(out_of_balance(record).values()))
    assert np.abs(left).max() > 0.1 * pushed


def test_weights_are_those_of_the_vertices():
    """The dead load of the left stone is its weight, with the area from the shoelace formula. The fill
    presses on its sides only, and the pressures have a table of their own."""
    record = read(wall_under_fill(), "static")
    row = next(row for row in record["block_results"] if row["block"] == "left")
    x, y = np.array(row["vertices"]).T
    area = abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
    assert vector(row, "dead_fx", "dead_fy") == pytest.approx([0.0, -20.0 * area * 1.7])
    assert vector(row, "live_fx", "live_fy") == pytest.approx([3.0, -1.0])


def test_flow_rule_and_energy_from_json():
    """The mechanism of the wall satisfies the flow rule: joints open at least by the dilatancy times their
    slip. The power of all loads equals the dissipation in joints, ties and fill that yield."""
    record = read(wall_under_fill(), "coulomb")
    speed = max(np.abs(vector(row, "vx", "vy")).max() for row in record["block_results"])
    λ, power, dissipated = record["load_factor"], 0.0, 0.0
    for row in record["block_results"]:
        motion = vector(row, "vx", "vy", "omega")
        for share, kind in ((1.0, "dead"), (λ, "live")):
            power += share * float(vector(row, f"{kind}_fx", f"{kind}_fy", f"{kind}_moment") @ motion)
    for row in record["joint_results"]:
        opens = row["opening"] - abs(row["rotation"]) * row["length"] / 2
        assert opens >= row["flow_slope"] * abs(row["slip"]) - 1e-8 * speed
        dissipated += (row["cohesion_force"] + row["friction"] * row["n"]) * abs(row["slip"])
    for row in record["tie_results"]:
        sense = 1.0 if row["kind"] == "tie" else -1.0
        dissipated += sense * row["force"] * row["lengthens"]
    for row in record["pressure_results"]:
        dissipated += row["force"] * row["lengthens"]
    assert power == pytest.approx(dissipated, rel=1e-7)
    assert power > 0


def lintel_on_two_piers(**changes: Any) -> mo.Scene:
    """Return a lintel on two piers of unequal weight, each on a foundation that can settle."""
    blocks = [
        mo.Block(name="left pier", vertices=rectangle(0, 1.1, 0, 3), unit_weight=19.0),
        mo.Block(name="right pier", vertices=rectangle(3, 4.2, 0, 3), unit_weight=21.0, live=(2.0, 1.0)),
        mo.Block(name="lintel", vertices=rectangle(-0.2, 4.4, 3, 3.8), unit_weight=23.0, live=(1.0, -0.5)),
        mo.Block(name="left", vertices=rectangle(-2, 1.5, -1, 0), fixed=True),
        mo.Block(name="right", vertices=rectangle(2.5, 6, -1, 0), fixed=True),
    ]
    return mo.Scene(**{"joints": mo.JointDefaults(friction=0.5), "blocks": blocks} | changes)


@pytest.mark.parametrize(
    ("supports", "turns", "space"),
    [
        ("right", False, False),
        (["left", "right"], False, False),
        ("right", True, False),
        ("right", False, True),
    ],
)
def test_the_forces_that_guide_a_settling_support_are_in_json(supports, turns, space):
    """Without the forces that guide the support, its forces do not balance."""
    scene = lintel_on_two_piers()
    scene = mo.extrude(scene, 1.3) if space else scene
    direction = (0.3, 0.2, -1.0) if space else (0.3, -1.0)
    settled = mo.settle(scene, supports, direction, method="static", turns=turns)
    record = json.loads(settled.least.result.to_json())
    weight = weights(record, 3 if space else 2).sum()
    left = np.concatenate(list(out_of_balance(record).values()))
    assert np.abs(left).max() <= SOLVED * weight
    named = [supports] if isinstance(supports, str) else supports
    assert [row["block"] for row in record["support_results"]] == named
    del record["support_results"]
    left = np.concatenate(list(out_of_balance(record).values()))
    assert np.abs(left).max() > 1e-3 * weight


def test_no_support_guided_no_row():
    assert "support_results" not in mo.solve(lintel_on_two_piers(), "static").as_dict()


def test_crushing_joints_follow_the_documented_flow_rule():
    """A joint with a strength rotates about a point between its middle and its edge when it yields."""
    record = read(lintel_on_two_piers(joints=mo.JointDefaults(friction=0.5, strength=500.0)), "static")
    assert record["crushing"] == "parabola"
    speed = max(np.abs(vector(row, "vx", "vy")).max() for row in record["block_results"])
    turning_rows = [row for row in record["joint_results"] if abs(row["rotation"]) > 1e-3 * speed]
    assert turning_rows
    for row in turning_rows:
        arm = (1 - 2 * row["n"] / row["crushing_force"]) * row["length"] / 2
        opens = abs(row["rotation"]) * arm + row["flow_slope"] * abs(row["slip"])
        assert row["opening"] == pytest.approx(opens, abs=1e-5 * speed)
        assert row["opening"] < abs(row["rotation"]) * row["length"] / 2 - 1e-3 * speed
