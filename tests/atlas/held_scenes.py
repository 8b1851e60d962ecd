"""Random scenes under fill, and random scenes with ties and props, generated from seeds."""

import itertools
import math

import numpy as np
from atlas.random_scenes import random_scene
from atlas.random_scenes_in_space import random_scene_in_space

from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.blocks import Block, rectangle
from masonry_opt.scene.joints import JointDefaults
from masonry_opt.scene.loads import GROUND, Prop, Tie
from masonry_opt.scene.road import Fill
from masonry_opt.scene.scene import Scene


def filled(seed: int) -> Scene:
    """Return two to six stacks next to each other, under a fill with a road that bends.

    Half of the stacks have sloping tops.
    """
    rng = np.random.default_rng(seed)
    x = np.append(0, np.cumsum(rng.uniform(0.4, 1.5, rng.integers(2, 7))))
    blocks = []
    for stack, (left, right) in enumerate(itertools.pairwise(x)):
        low, count = 0.0, int(rng.integers(1, 4))
        for course in range(count):
            high = low + rng.uniform(0.3, 1.0)
            slope = rng.uniform(-0.2, 0.4) if course == count - 1 and rng.random() < 0.5 else 0.0
            corners = [(left, low), (right, low), (right, high + slope), (left, high)]
            live = (float(rng.normal()), -float(rng.random()))
            blocks.append(Block(name=f"{stack}-{course}", vertices=corners, unit_weight=20.0, live=live))
            low = high
    ground = rectangle(-3, x[-1] + 3, -1, 0)
    start, end = rng.uniform(-2, x[1]), rng.uniform(x[-2], x[-1] + 2)
    road = [(at, rng.uniform(3.5, 4.2)) for at in (start, rng.uniform(start, end), end)]
    earth = {"unit_weight": (10, 22), "friction_angle": (20, 40), "mobilised": (0.3, 1.0)}
    fill = Fill(road=road, **{name: rng.uniform(*ends) for name, ends in earth.items()})
    joints = JointDefaults(friction=float(rng.uniform(0.4, 0.8)))
    supports = [Block(name="ground", vertices=ground, fixed=True)]
    return Scene(joints=joints, blocks=[*blocks, *supports], fills=[fill])


def held(kind: str, seed: int, space: bool = False) -> Scene:
    """Return a random scene with one to four ties and props; kind "filled" is a scene under fill.

    Ties and props connect the middles of two blocks, or a block and a point of the ground. Their strengths
    are about the mean weight. Some ties have a prestress, and some have no limit.
    """
    if kind == "filled":
        scene = filled(seed)
    else:
        scene = (random_scene_in_space if space else random_scene)(kind, seed)
    rng = np.random.default_rng([7, seed])
    free = [block for block in scene.blocks if not block.fixed]
    middles = {block.name: np.array(block.vertices).mean(axis=0) for block in free}
    size = np.ptp(list(middles.values()), axis=0).max() or 1.0
    problem = assemble(scene).problem
    weight = float(problem.force_sizes(problem.dead).mean() * problem.force_unit)
    ties, props = [], []
    for _ in range(rng.integers(1, 5)):
        first = str(rng.choice(list(middles)))
        others = [name for name in middles if name != first]
        if others and rng.random() < 0.5:
            second = str(rng.choice(others))
            far = middles[second]
        else:
            second = GROUND
            direction = rng.normal(size=len(middles[first]))
            far = middles[first] + size * direction / np.linalg.norm(direction)
        at = tuple(middles[first].tolist()), tuple(far.tolist())
        strength = None if rng.random() < 0.2 else weight * float(math.exp(rng.normal()))
        if rng.random() < 0.6:
            prestress = float(rng.uniform(0, 0.2)) * (strength or weight) * bool(rng.random() < 0.4)
            ties.append(Tie(between=(first, second), at=at, strength=strength, prestress=prestress))
        else:
            props.append(Prop(between=(first, second), at=at, strength=strength))
    return scene.model_copy(update={"ties": ties, "props": props})
