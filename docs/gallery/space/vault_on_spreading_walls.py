"""
How thick must the walls under a barrel vault be?
=================================================

A barrel vault thrusts its side walls apart. A plane analysis of the section neglects an end wall that is
toothed into both side walls. How much thinner may the side walls be with an end wall?
"""

import masonry_opt as mo

SPAN = 3.0  # m
HEIGHT = 3.0  # m
LENGTH = 3.0  # m
VAULT = {"span": SPAN, "rise": 1.0, "thickness": 0.3, "voussoirs": 7, "skewbacks": 0.3, "abutments": False}
STONE = {"unit_weight": 20}  # kN/m³
FRICTION = mo.JointDefaults(friction=0.7)


def room(wall: float, end_wall: bool) -> mo.Scene:
    """Return two side walls of the given thickness under a vault, with or without an end wall."""
    middle = (SPAN + wall) / 2
    axes = {"left": [(-middle, 0), (-middle, LENGTH)], "right": [(middle, 0), (middle, LENGTH)]}
    if end_wall:
        axes["end"] = [(-middle, LENGTH - wall / 2), (middle, LENGTH - wall / 2)]
    walls = [mo.PlanWall(name=name, axis=axis) for name, axis in axes.items()]
    plan = mo.Plan(block=(1, 0.5), thickness=wall, courses=6, walls=walls, **STONE)
    vault = mo.Barrel(at=(0, 0, HEIGHT), length=LENGTH, stone=1, **VAULT, **STONE).blocks()
    crown = [mo.Load(block=block.name, live=(0, 0, -1)) for block in vault if block.name.startswith("v4-")]
    return mo.Scene(
        title="barrel vault on walls", joints=FRICTION, blocks=[*plan.blocks(), *vault], loads=crown
    )


def section(wall: float) -> mo.Scene:
    """Return the section of the room without an end wall, in the plane and 1 m wide."""
    blocks = mo.Arch(at=(0, HEIGHT), **VAULT, **STONE).blocks()
    for name, left in (("left", -SPAN / 2 - wall), ("right", SPAN / 2)):
        blocks += mo.Column(name=name, at=(left, 0), width=wall, height=HEIGHT, drums=6, **STONE).blocks()
    return mo.Scene(title="section", joints=FRICTION, blocks=blocks)


# %%
# Without an end wall the room needs the same thickness as its section, because each wall leans along its
# whole length. With an end wall the side walls may be thinner by 40 %.
roughly = {"samples": 0, "tolerance": 1e-3}
in_the_plane = mo.least(section, 0.2, 0.8, **roughly).value
alone = mo.least(lambda wall: room(wall, end_wall=False), 0.2, 0.8, **roughly).value
held = mo.least(lambda wall: room(wall, end_wall=True), 0.2, 0.8, **roughly).value
print(f"section {in_the_plane:.2f} m, room {alone:.2f} m, with an end wall {held:.2f} m")
assert abs(alone - in_the_plane) < 2e-3
assert 0.58 < held / alone < 0.62

# %%
# The least thickness requires only that a state of equilibrium exists. With the end wall, this state needs
# friction along the teeth. The picture shows walls of 0.6 m without an end wall, under a load on the crown:
result = mo.solve(room(0.6, end_wall=False))
assert abs(result.associative / result.required() - 1) < 1e-5
result.plot(view=(-50, 25))
