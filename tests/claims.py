"""Check claims of results other than load factors by linear and mixed-integer programs.

The claims are that statics fix all forces, that no mechanism lets the live load do work, that any multiple of
the live load is carried, and that no collapse state exists. Equilibrium and yield are those of
:mod:`second_program`; HiGHS solves all programs.
"""

from math import inf

import numpy as np
import scipy.sparse as sp
from scipy.optimize import Bounds as Box
from scipy.optimize import LinearConstraint, linprog, milp
from second_program import Bounds, program

import masonry_opt as mo
from masonry_opt.problem.assembly import Assembly, assemble
from masonry_opt.solution.reasons import Code, Status

#: Range of a force, relative to the largest load, above which the force counts as not unique.
RANGE = 1e-5
#: Number of forces whose ranges are computed, evenly spaced over all forces. Each range takes two programs.
SAMPLED = 20
#: Bounds of forces and of velocities in mixed-integer programs, relative to the largest load and the mean
#: motion of the live load. States beyond them are not found.
BIG = 1e3
#: Error of a reaction, relative to its size and to the weight of the scene.
REACTION = 1e-6
#: Relative difference above which two load factors count as different.
SAME = 1e-4
#: Largest number of joints of a scene for which a mixed-integer program looks for a state.
SMALL = 16
#: Time limit of a mixed-integer program, in seconds; a shorter one finds fewer states.
SECONDS = 20.0


def wrong_claims(result: mo.Result, bounds: Bounds) -> list[str]:
    """Return a sentence for each claim of a result that the programs refute."""
    assembly, found = result.assembly, []
    every = [*result.reasons, *result.incremental_reasons]
    codes = {reason.code for reason in every}
    if result.solution.is_only_state:
        found += refute_uniqueness(assembly, result.load_factor or 0.0)
    if result.status is Status.UNLIMITED and Code.NO_MECHANISM in codes:
        work = live_work(assembly)
        if work > 0:
            found.append("'no mechanism lets the live load do work', but one does")
    if Code.CARRIES_ANY in codes and bounds.outside != inf:
        found.append(f"'statics carry any multiple', but no more than {bounds.outside}")
    if result.status in (Status.JAMMED, Status.UNLIMITED) and result.load_factor is None:
        state = other_state(assembly)
        if state is not None:
            found.append(f"'{result.status}', but a state exists at {state}")
    return found


def refute_uniqueness(assembly: Assembly, load_factor: float) -> list[str]:
    """Return a sentence for each contradiction to the claim that equilibrium alone fixes all forces.

    The claim is contradicted by a rank of the equilibrium matrix below its number of columns, by a force
    whose range over equilibrium and yield is not zero, or by a state at a lower load factor.
    """
    statics, rows, limits = program(assembly, inside=False)
    least = other_state(assembly)
    rank = np.linalg.matrix_rank(statics.toarray())
    found = []
    if least is not None and least < load_factor * (1 - SAME) - SAME:
        found.append(f"'there is no other state' than {load_factor}, but one exists at {least}")
    if rank < statics.shape[1]:
        found.append(f"'statics fix all forces', but rank {rank} of {statics.shape[1]} forces")
    problem = assembly.problem
    load = problem.dead + load_factor * problem.live
    largest, count = 0.0, statics.shape[1]
    for column in np.unique(np.linspace(0, count - 1, SAMPLED).astype(int)):
        ends = [
            linprog(
                sign * np.eye(1, count, column)[0],
                A_ub=-rows,
                b_ub=limits + 1e-9 * np.abs(load).max(),
                A_eq=statics,
                b_eq=-load,
                bounds=[(None, None)] * count,
            )
            for sign in (1.0, -1.0)
        ]
        if any(end.status == 3 for end in ends):
            largest = inf
        elif all(end.status == 0 for end in ends):
            largest = max(largest, -ends[1].fun - ends[0].fun)
    if largest > RANGE * np.abs(load).max():
        found.append(f"forces range over {largest:.3g}")
    return found


def live_work(assembly: Assembly) -> float:
    """Return the largest work of the live load in a mechanism that obeys the flow rule, at most 1.

    In the plane, contact points open at least by ψ times the slip. In space, they open at least by ψ times
    the slip along each of 24 directions.
    """
    problem, joints = assembly.problem, assembly.joints
    statics = program(assembly, inside=True)[0]
    motion, limited = sp.csr_array(statics.T), len(assembly.limited)
    space = assembly.scene.dimension == 3
    joint = joints.joint if space else np.arange(len(joints.first))
    count = len(joint)
    slope = np.where(np.isfinite(joints.friction[joint]), joints.dilatancy[joint], 0.0)
    crushes = np.isfinite(joints.strength[joint]) & (joints.extent[joint] > 0) & (not space)
    grips = ~np.isfinite(joints.friction[joint])
    kinds = [motion[kind * count : (kind + 1) * count] for kind in range(3)]
    points = 1 if space else 2
    normals, shears = kinds[:points], kinds[points:]
    directions: list[tuple[float, ...]] = [(1.0,), (-1.0,)]
    if space:
        angles = 2 * np.pi / 24 * np.arange(24)
        directions = [(float(np.cos(angle)), float(np.sin(angle))) for angle in angles]
    most = []
    for normal in normals:
        for direction in directions:
            slip = sum(part * shear for part, shear in zip(direction, shears, strict=True))
            most.append((sp.diags_array(slope) @ slip - normal)[~crushes])
    own = motion[3 * count :]
    lowest, highest = np.array([(one.lowest, one.highest) for one in assembly.limited]).reshape(-1, 2).T
    most += [-own[np.isinf(highest)], own[np.isinf(lowest)]] if limited else []
    equal = sp.vstack([shear[grips] for shear in shears]).tocsr()
    found = linprog(
        -problem.live / problem.live_norm,
        A_ub=sp.vstack([*most, sp.csr_array(problem.live[None] / problem.live_norm)]),
        b_ub=np.append(np.zeros(sum(of.shape[0] for of in most)), 1.0),
        A_eq=equal,
        b_eq=np.zeros(equal.shape[0]),
        bounds=[(-1e6, 1e6)] * len(problem.live),
    )
    assert found.status == 0, found.message
    return -found.fun if -found.fun > 1e-6 else 0.0


def other_state(assembly: Assembly, below: float = inf) -> float | None:
    """Return the least load factor λ ≥ 0 of a Coulomb collapse state of a small scene in the plane.

    The result is None if no state exists below the load factor ``below``, or if forces or velocities of all
    states exceed ``BIG``. It is also None if the scene is too large, has joints that crush, or is in space.
    :func:`scipy.optimize.milp` solves for forces and velocities, with a binary variable for each pair of
    slack and rate.
    """
    joints, problem = assembly.joints, assembly.problem
    count = len(joints.first)
    crushes = (np.isfinite(joints.strength) & (joints.extent > 0)).any()
    if assembly.scene.dimension == 3 or crushes or count > SMALL or not problem.live.any():
        return None
    statics, rows, limits = program(assembly, inside=True)
    # Rates p in the order of the rows: openings, slip in each sense, motion at the limits of limited forces.
    slides = np.flatnonzero(np.isfinite(joints.friction))
    forces, velocities, conditions = statics.shape[1], len(problem.live), rows.shape[0]
    flow = sp.lil_array((forces, conditions))
    flow[np.arange(2 * count), np.arange(2 * count)] = 1.0
    for number, sign in enumerate((1.0, -1.0)):
        at = 2 * count + number * len(slides) + np.arange(len(slides))
        flow[2 * count + slides, at] = sign
        for end in (slides, count + slides):
            flow[end, at] = joints.dilatancy[slides]
    limited = rows[2 * count + 2 * len(slides) :, 3 * count :]
    flow[3 * count :, 2 * count + 2 * len(slides) :] = limited.T.toarray()
    unit = max(np.abs(problem.dead).max(), 1e-9)
    live = problem.live / problem.live_norm
    motion = sp.csr_array(statics.T)
    nothing = sp.csr_array
    eye = sp.eye_array(conditions, format="csr")
    # Unknowns: λ · live norm / unit, forces / unit, velocities, rates, binaries.
    constraints = [
        LinearConstraint(
            sp.hstack([nothing(live[:, None]), statics, nothing((velocities, velocities + 2 * conditions))]),
            -problem.dead / unit,
            -problem.dead / unit,
        ),
        LinearConstraint(
            sp.hstack([nothing((forces, 1 + forces)), motion, -flow, nothing((forces, conditions))]), 0, 0
        ),
        LinearConstraint(
            sp.hstack([nothing((1, 1 + forces)), live[None], nothing((1, 2 * conditions))]), 1, 1
        ),
        # Slack z is at least 0. If a binary is 0, its slack is at most BIG; if it is 1, its rate is.
        LinearConstraint(
            sp.hstack([nothing((conditions, 1)), rows, nothing((conditions, velocities + 2 * conditions))]),
            -limits / unit,
            inf,
        ),
        LinearConstraint(
            sp.hstack(
                [nothing((conditions, 1)), rows, nothing((conditions, velocities + conditions)), BIG * eye]
            ),
            -inf,
            BIG - limits / unit,
        ),
        LinearConstraint(
            sp.hstack([nothing((conditions, 1 + forces + velocities)), eye, -BIG * eye]), -inf, 0
        ),
    ]
    total = 1 + forces + velocities + 2 * conditions
    low, high = np.full(total, -inf), np.full(total, inf)
    low[0], low[1 + forces + velocities :] = 0.0, 0.0
    high[0] = below * problem.live_norm / unit if below < inf else BIG
    high[-conditions:] = 1.0
    found = milp(
        np.eye(1, total)[0],
        integrality=np.append(np.zeros(total - conditions), np.ones(conditions)),
        bounds=Box(low, high),
        constraints=constraints,
        options={"time_limit": SECONDS, "mip_rel_gap": 1e-4},
    )
    if found.x is None:
        return None
    # Binaries are integer only within a tolerance, so products of rates and slacks may remain. A state counts
    # only if these products vanish.
    z = rows @ found.x[1 : 1 + forces] + limits / unit
    p = found.x[1 + forces + velocities : -conditions]
    if np.abs(z * p).max() > 1e-5 * max(found.x[0], 1.0):
        return None
    return float(found.x[0] * unit / problem.live_norm)


def wrong_reactions(scene: mo.Scene, seed: int) -> list[str]:
    """Return a sentence for each wrong reaction of a random support that settles in a random direction.

    With associative flow, the least and the greatest reaction have bounds. The bounds are computed with
    polygons inside and outside the friction cones and the parabolas of crushing.
    """
    assembly, rng = assemble(scene), np.random.default_rng([17, seed])
    joints = assembly.joints
    touched = np.unique([*joints.first, *joints.second])
    supports = [int(block) for block in touched if scene.blocks[block].fixed]
    if not supports or scene.fills:
        return []
    support = int(rng.choice(supports))
    direction = rng.normal(size=scene.dimension)
    direction /= np.linalg.norm(direction)
    name = scene.blocks[support].name
    settled = mo.settle(scene, name, tuple(direction.tolist()), method="static")
    ends = {"least": settled.least, "greatest": settled.greatest}
    inside, outside = (_reactions(assembly, support, direction, inside=of) for of in (True, False))
    size = float(assembly.problem.force_sizes(assembly.problem.dead).sum() * assembly.problem.force_unit)
    if settled.fallen is not None:
        return [] if inside is None else [f"settle {name}: 'falls', but reactions are {inside}"]
    if outside is None:
        return [f"settle {name}: {ends}, but no reaction holds the scene"]
    found = []
    for number, (end, sign) in enumerate({"least": -1.0, "greatest": 1.0}.items()):
        of = ends[end]
        value = sign * inf if of is not None and of.unlimited else None if of is None else of.reaction
        limits = sorted(sign * each[number] for each in (inside or outside, outside))
        room = REACTION * size + REACTION * min(abs(limits[1]), 1e6 * size)
        if value is None:
            found.append(f"settle {name} along {direction}: no {end} reaction, but {outside[number]}")
        elif not limits[0] - room <= sign * value <= limits[1] + room:
            found.append(f"settle {name} along {direction}: {end} {value}, but {outside[number]}")
    return found


def _reactions(
    assembly: Assembly, support: int, direction: np.ndarray, inside: bool
) -> tuple[float, float] | None:
    """Return the least and the greatest reaction of a support against a direction; None if there is none."""
    statics, rows, limits = program(assembly, inside)
    joints, space = assembly.joints, assembly.scene.dimension == 3
    joint = joints.joint if space else np.arange(len(joints.first))
    normal = joints.normal[joint]
    if space:
        tangent = joints.tangent[joint]
        forces = [normal, tangent, np.cross(normal, tangent)]
    else:
        forces = [normal, normal, np.column_stack([normal[:, 1], -normal[:, 0]])]
    sign = (joints.first[joint] == support).astype(float) - (joints.second[joint] == support)
    cost = np.concatenate([*(sign * (of @ direction) for of in forces), np.zeros(len(assembly.limited))])
    ends = []
    for way in (1.0, -1.0):
        found = linprog(
            way * cost,
            A_ub=-rows,
            b_ub=limits,
            A_eq=statics,
            b_eq=-assembly.problem.dead,
            bounds=[(None, None)] * len(cost),
        )
        if found.status == 2:
            return None
        assert found.status in (0, 3), found.message
        ends.append(-way * inf if found.status == 3 else way * found.fun * assembly.problem.force_unit)
    return ends[0], ends[1]
