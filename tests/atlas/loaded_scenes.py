"""Random loads of every kind on random scenes, generated from seeds."""

import math

import numpy as np

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble

Rng = np.random.Generator

#: Kinds of live loads. "live" keeps the live loads of the scene, and occurs in half of the scenes.
INSTEAD = ("live", "tilt", "earthquake", "load case", "earthquake in a load case")


def loaded(scene: mo.Scene, seed: int) -> mo.Scene:
    """Return a scene with further loads and, in one case of five, with joints that dilate.

    Dead forces, moments and loads along edges are added independently of each other. In half of the scenes,
    tilt, an earthquake or a load case replaces the live load.
    """
    rng = np.random.default_rng([13, seed])
    if rng.random() < 0.2 and not scene.joints.strength:
        dilatancy = float(rng.choice([0.3, 0.7, 1.0])) * scene.joints.friction
        scene = scene.replace(joints=scene.joints.replace(dilatancy=dilatancy))
    instead = INSTEAD[rng.integers(1, len(INSTEAD))] if rng.random() < 0.5 else "live"
    if instead == "tilt":
        return _tilted(rng, scene)
    problem = assemble(scene).problem
    weight = float(problem.force_sizes(problem.dead).mean() * problem.force_unit)
    loads = [*_dead_forces(rng, scene, weight), *_moments(rng, scene, weight)]
    edge_loads = _edge_loads(rng, scene, weight)
    if instead == "live":
        return scene.replace(loads=loads, edge_loads=edge_loads)
    if instead == "load case":
        return _in_load_case(rng, scene, loads, edge_loads)
    quake = _earthquake(rng, scene)
    loads = [load for load in loads if not load.has_force("live")]
    edge_loads = [load for load in edge_loads if load.kind == "dead"]
    if instead == "earthquake":
        return _without_live(scene).replace(loads=loads, edge_loads=edge_loads, earthquake=quake)
    case = mo.LoadCase(name="quake", dead={"dead": float(rng.uniform(0.5, 1.5))}, earthquake=quake)
    return scene.replace(loads=loads, edge_loads=edge_loads, load_cases=[case]).in_case("quake")


def _free(scene: mo.Scene) -> list[str]:
    return [block.name for block in scene.blocks if not block.fixed]


def _vector(rng: Rng, scene: mo.Scene, size: float) -> tuple[float, ...]:
    return tuple((size * rng.normal(size=scene.dimension)).tolist())


def _without_live(scene: mo.Scene) -> mo.Scene:
    none = {"live": (0.0,) * scene.dimension, "live_per_weight": (0.0,) * scene.dimension}
    if scene.dimension == 3:
        none["live_moment"] = (0.0, 0.0, 0.0)
    else:
        none["live_at"] = None
    blocks = [block if block.fixed else block.replace(**none) for block in scene.blocks]
    return scene.replace(blocks=blocks)


def _tilted(rng: Rng, scene: mo.Scene) -> mo.Scene:
    """Return the scene on ground that tilts, with no joint properties other than friction and dilatancy.

    Ties, props and fills are removed.
    """
    towards = str(rng.choice(["left", "right"]))
    tilt = towards if scene.dimension == 2 else (*_vector(rng, scene, 1.0)[:2], 0.0)
    joints = mo.JointDefaults(friction=scene.joints.friction, dilatancy=scene.joints.dilatancy)
    return _without_live(scene).replace(joints=joints, ties=[], props=[], fills=[], tilt=tilt)


def _dead_forces(rng: Rng, scene: mo.Scene, weight: float) -> list[mo.Load]:
    if rng.random() < 0.6:
        return []
    some = rng.choice(_free(scene), size=rng.integers(1, 4))
    return [mo.Load(block=str(name), dead=_vector(rng, scene, 0.3 * weight)) for name in some]


def _moments(rng: Rng, scene: mo.Scene, weight: float) -> list[mo.Load]:
    """Return a live force at a distance from the centroid, and in space a dead moment too."""
    if rng.random() < 0.7:
        return []
    name = str(rng.choice(_free(scene)))
    at = tuple(np.mean(scene[name].vertices, axis=0) + 0.1 * rng.normal(size=scene.dimension))
    force = mo.Load(block=name, live=_vector(rng, scene, weight), at=tuple(float(one) for one in at))
    if scene.dimension == 2:
        return [force]
    return [force, mo.Load(block=name, dead_moment=_vector(rng, scene, 0.05 * weight))]


def _edge_loads(rng: Rng, scene: mo.Scene, weight: float) -> list[mo.EdgeLoad]:
    """Return a load along the highest edge of the highest or of a random block; no load in space.

    The edge of a random block may be covered by another block. Assembly then refuses the scene.
    """
    if scene.dimension == 3 or rng.random() < 0.6:
        return []
    highest = max(_free(scene), key=lambda name: max(y for _, y in scene[name].vertices))
    corners = scene[highest if rng.random() < 0.8 else str(rng.choice(_free(scene)))].vertices
    edges = [(corners[number - 1], corners[number]) for number in range(len(corners))]
    start, end = max(edges, key=lambda edge: edge[0][1] + edge[1][1])
    pressure = float(rng.uniform(0.1, 1.0)) * weight / math.dist(start, end)
    kind = str(rng.choice(["dead", "live"]))
    return [mo.EdgeLoad(start=start, end=end, pressure=pressure, kind=kind)]


def _earthquake(rng: Rng, scene: mo.Scene) -> mo.Earthquake:
    side = str(rng.choice(["left", "right"]))
    direction = side if scene.dimension == 2 else float(rng.uniform(0, 360))
    vertical = float(rng.choice([0.0, 0.5, -0.5]))
    return mo.Earthquake(direction=direction, vertical=vertical, coefficient=float(rng.choice([1.0, 0.3])))


def _in_load_case(rng: Rng, scene: mo.Scene, loads: list[mo.Load], edge_loads: list[mo.EdgeLoad]) -> mo.Scene:
    push = mo.Load(block=str(rng.choice(_free(scene))), live=_vector(rng, scene, 1.0), group="wind")
    factors = {"live": float(rng.uniform(0.5, 1.5)), "wind": float(rng.uniform(-1, 1))}
    case = mo.LoadCase(name="all", dead={"weight": float(rng.uniform(0.8, 1.4)), "wind": 0.05}, live=factors)
    return scene.replace(loads=[*loads, push], edge_loads=edge_loads, load_cases=[case]).in_case("all")
