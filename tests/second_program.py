"""Independent bounds on the associative load factor by linear programs with their own equilibrium matrix.

The programs also decide whether a scene is stable under its dead load. HiGHS solves them.

- Unknowns are λ, normal forces, shears and limited forces. Normal forces act at the contact points: the two
  ends of a joint in the plane, the corners of a polygon in space. There is one shear for each joint in the
  plane, and two for each contact point in space.
- The package supplies the positions and properties of joints, the loads, and the columns of limited forces.
  It supplies no rows of equilibrium or yield.
- Curved limits (cones of friction, parabolas of crushing) are enclosed between polygons inside and outside.
"""

from dataclasses import dataclass
from math import inf

import numpy as np
import scipy.sparse as sp
from atlas.held_scenes import held
from atlas.loaded_scenes import loaded
from atlas.random_scenes import KINDS, random_scene
from atlas.random_scenes_in_space import KINDS as KINDS_IN_SPACE
from atlas.random_scenes_in_space import random_scene_in_space
from scipy.optimize import linprog

import masonry_opt as mo
from masonry_opt.problem.assembly import Assembly, assemble
from masonry_opt.solution.reasons import Status

#: Number of sides of a friction polygon.
SIDES = 24
#: Number of chords or tangents of a parabola of crushing.
TANGENTS = 64

#: Codes with which SciPy reports that HiGHS ended at its time limit, or without a verdict.
UNDECIDED = (1, 4)

#: Time limit of a program in seconds, because HiGHS can cycle. After the time limit, the interior-point
#: method is tried.
LONGEST = 60.0


#: Relative difference allowed between load factors of two programs that are each solved to 1e-9.
SAME = 1e-6

#: Statuses of a scene that carries any multiple of its live load under associative flow.
ANY_LOAD = (Status.UNLIMITED, Status.LOCKED)


def random_of_any_kind(seed: int) -> mo.Scene:
    """Return a random scene in the plane or in space, bare, under fill, or held by ties and props.

    Some joints in the plane have limited strength. Loads are of every kind (:mod:`atlas.loaded_scenes`).
    """
    plain = [*KINDS, *KINDS_IN_SPACE]
    kinds = [*((kind, False) for kind in plain), *((kind, True) for kind in (*plain, "filled"))]
    kind, is_held = kinds[seed % len(kinds)]
    in_space = kind in KINDS_IN_SPACE
    if is_held:
        scene = held(kind, seed, in_space)
    else:
        scene = (random_scene_in_space if in_space else random_scene)(kind, seed)
    rng = np.random.default_rng([11, seed])
    if not in_space and rng.random() < 0.4:
        # The strength is the pressure below a wall of the same unit weight with a height of 3 to 100.
        strength = float(rng.uniform(3, 100)) * (20.0 if kind == "filled" else 1.0)
        joints = mo.JointDefaults(**scene.joints.model_dump(exclude_unset=True) | {"strength": strength})
        scene = mo.Scene(
            **{name: getattr(scene, name) for name in scene.model_fields_set} | {"joints": joints}
        )
    return loaded(scene, seed)


def verdict_on(scene: mo.Scene, coulomb: mo.Result | None = None) -> str:
    """Return "agrees" if methods "static" and the default agree with the bounds of this program.

    ``coulomb`` is the result of the default. If it is None, the default solves the scene.
    Otherwise the verdict begins with "on the edge" (polygons inside and outside disagree on stability),
    "open" (a method decided nothing) or "wrong". :mod:`claims` checks the claims other than load factors.
    """
    # The module claims imports this module, so it is imported here.
    from claims import wrong_claims

    assembly = assemble(scene)
    found, result = bounds(assembly), mo.solve(scene, "static")
    if found.stands is None:
        return "on the edge"
    if result.status is Status.SOLVER_FAILED:
        return f"open: static: {result.message}"
    coulomb = coulomb or mo.solve(scene)
    wrong = [*_wrong_associative(result, found), *_wrong_coulomb(coulomb, found)]
    for each in (result, coulomb):
        wrong += wrong_claims(each, found)
    if wrong:
        return f"wrong: {'; '.join(wrong)}"
    if coulomb.status is Status.SOLVER_FAILED:
        return f"open: {coulomb.message}"
    return "agrees"


def _wrong_associative(result: mo.Result, found: "Bounds") -> list[str]:
    if (result.status is Status.UNSTABLE) == found.stands:
        return [f"static: {result.status}, bounds {found}"]
    if not found.stands:
        return []
    inside, most = found.inside or 0.0, found.outside or 0.0
    if result.load_factor is None:
        right = result.status in ANY_LOAD and most == inf
    else:
        right = inside * (1 - SAME) - SAME <= result.load_factor <= most * (1 + SAME) + SAME
    return [] if right else [f"static: {result.status} {result.load_factor}, bounds {found}"]


def _wrong_coulomb(result: mo.Result, found: "Bounds") -> list[str]:
    if not found.stands:
        return [] if result.status is Status.UNSTABLE else [f"by default {result.status}, but it falls"]
    most = found.outside or 0.0
    above = [
        of
        for of in (result.load_factor, result.incremental)
        if of is not None and of > most * (1 + SAME) + SAME
    ]
    return [f"Coulomb {of} above {most}" for of in above]


@dataclass(frozen=True)
class Bounds:
    """Largest load factors with polygons inside and outside the curved limits.

    A load factor is None if the scene is unstable with these polygons, and ``inf`` if it carries any load.
    """

    inside: float | None
    outside: float | None

    @property
    def stands(self) -> bool | None:
        """True if the scene is stable under its dead load; None if the two polygons disagree."""
        return True if self.inside is not None else False if self.outside is None else None


def bounds(assembly: Assembly) -> Bounds:
    return Bounds(_largest(assembly, inside=True), _largest(assembly, inside=False))


def _largest(assembly: Assembly, inside: bool) -> float | None:
    statics, rows, limits = program(assembly, inside)
    problem = assembly.problem
    unknowns = statics.shape[1]
    free = [(None, None)] * unknowns
    A = sp.csc_array(sp.hstack([problem.live[:, None] / problem.live_norm, statics]))
    yielding = sp.csc_array(sp.hstack([sp.csc_array((rows.shape[0], 1)), -rows]))
    for least in (0.0, None):
        for method in ("highs", "highs-ipm"):
            found = linprog(
                -np.eye(1, unknowns + 1)[0],
                A_ub=yielding,
                b_ub=limits,
                A_eq=A,
                b_eq=-problem.dead,
                bounds=[(least, 0.0 if least is not None else None), *free],
                method=method,
                options={
                    "primal_feasibility_tolerance": 1e-9,
                    "dual_feasibility_tolerance": 1e-9,
                    "time_limit": LONGEST,
                },
            )
            if found.status not in UNDECIDED:
                break
        if least is not None and found.status != 0:
            assert found.status == 2, found.message
            return None
    if found.status == 3:
        return inf
    assert found.status == 0, found.message
    return float(-found.fun) / problem.live_norm


def program(assembly: Assembly, inside: bool) -> tuple[sp.csr_array, sp.csr_array, np.ndarray]:
    """Return the equilibrium matrix, shape (rows, forces), and the rows and limits of yield.

    The yield conditions are rows @ forces + limits ≥ 0.
    """
    return _in_space(assembly, inside) if assembly.scene.dimension == 3 else _in_the_plane(assembly, inside)


def _acting(assembly: Assembly, joint: np.ndarray, at: np.ndarray, force: np.ndarray) -> sp.csc_array:
    """Return the equilibrium columns of unit forces at points of joints, shape (rows, forces)."""
    problem, joints = assembly.problem, assembly.joints
    row_of = np.full(len(assembly.scene.blocks), -1)
    row_of[assembly.movable] = np.arange(len(assembly.movable))
    columns = []
    for block, sign in ((joints.first[joint], 1.0), (joints.second[joint], -1.0)):
        arm = (at - assembly.geometry.centroid[block]) / problem.length_unit
        plane = arm.shape[1] == 2
        turning = (arm[:, :1] * force[:, 1:] - arm[:, 1:] * force[:, :1]) if plane else np.cross(arm, force)
        entries = sign * np.concatenate([force, turning], axis=1)
        size, moved = entries.shape[1], row_of[block] >= 0
        rows = (size * row_of[block][:, None] + np.arange(size))[moved]
        column = np.broadcast_to(np.arange(len(at))[:, None], entries.shape)[moved]
        shape = (size * len(assembly.movable), len(at))
        columns.append(sp.coo_array((entries[moved].ravel(), (rows.ravel(), column.ravel())), shape=shape))
    return sp.csc_array(columns[0] + columns[1])


def _in_the_plane(assembly: Assembly, inside: bool) -> tuple[sp.csr_array, sp.csr_array, np.ndarray]:
    joints, problem = assembly.joints, assembly.problem
    count, every = len(joints.first), np.arange(len(joints.first))
    along = np.column_stack([joints.normal[:, 1], -joints.normal[:, 0]])
    both = [_acting(assembly, every, end, joints.normal) for end in (joints.start, joints.end)]
    shear = _acting(assembly, every, (joints.start + joints.end) / 2, along)
    statics = sp.hstack([*both, shear, problem.matrices.of_limited], format="csr")
    force, area = problem.force_unit, joints.extent * assembly.scene.thickness
    one, nothing = sp.eye_array(count), sp.csr_array((count, count))
    rows, limits = (
        [sp.hstack([one, nothing, nothing]), sp.hstack([nothing, one, nothing])],
        [np.zeros(2 * count)],
    )
    slides = np.flatnonzero(np.isfinite(joints.friction))
    friction = sp.diags_array(joints.friction[slides])
    for sign in (1.0, -1.0):
        rows.append(sp.hstack([friction @ one.tocsr()[slides]] * 2 + [sign * one.tocsr()[slides]]))
        limits.append((joints.cohesion * area / force)[slides])
    crushes = np.flatnonzero(np.isfinite(joints.strength) & (joints.extent > 0))
    most = (joints.strength * area / force)[crushes]
    for slope, constant in _parabola(inside):
        # Each line limits |m| ≤ L/2 (slope n + constant most), with m = L/2 (b − a) and n = a + b.
        for sign in (1.0, -1.0):
            a, b = (sp.diags_array(np.full(len(crushes), slope + turn)) for turn in (sign, -sign))
            picked = one.tocsr()[crushes]
            rows.append(sp.hstack([a @ picked, b @ picked, nothing.tocsr()[crushes]]))
            limits.append(constant * most)
    return statics, *_limited(assembly, sp.vstack(rows), np.concatenate(limits))


def _parabola(inside: bool) -> list[tuple[float, float]]:
    """Return slopes and constants of lines that enclose x (1 − x) from 0 to 1, closely spaced near 0 and 1.

    The lines are chords if ``inside``, otherwise tangents.
    """
    at = np.concatenate([[0.0], np.geomspace(1e-6, 0.5, TANGENTS // 2)])
    at = np.concatenate([at, 1 - at[-2::-1]])
    if not inside:
        return [(1 - 2 * x, x**2) for x in at.tolist()]
    return [(1 - low - high, low * high) for low, high in zip(at[:-1].tolist(), at[1:].tolist(), strict=True)]


@dataclass(frozen=True)
class Points:
    """Equilibrium and contact areas of a scene in space, in the units of its problem.

    Attributes
    ----------
    B: equilibrium matrix, with columns n (compression > 0), s and t for each contact point.
    dead, live: loads, so that B q + λ live + dead = 0.
    share: area of each contact point, which is a part of the area of its joint, over the unit of force.
    """

    B: sp.csc_array
    dead: np.ndarray
    live: np.ndarray
    share: np.ndarray


def points_of(scene: mo.Scene) -> Points:
    assembly = assemble(scene)
    forces, share = _at_points(assembly)
    in_turn = np.arange(3 * len(share)).reshape(3, -1).T.ravel()
    B = sp.csc_array(sp.hstack(forces, format="csc")[:, in_turn])
    return Points(B, assembly.problem.dead, assembly.problem.live, share)


def _at_points(assembly: Assembly) -> tuple[list[sp.csc_array], np.ndarray]:
    """Return the columns of n, s and t of all contact points, and the area of each over the force unit."""
    joints = assembly.joints
    joint = joints.joint
    normal, tangent = joints.normal[joint], joints.tangent[joint]
    kinds = (normal, tangent, np.cross(normal, tangent))
    count = np.bincount(joint, minlength=len(joints.extent))
    share = (joints.extent / count)[joint] / assembly.problem.force_unit
    return [_acting(assembly, joint, joints.point, of) for of in kinds], share


def _in_space(assembly: Assembly, inside: bool) -> tuple[sp.csr_array, sp.csr_array, np.ndarray]:
    joints, problem = assembly.joints, assembly.problem
    joint, count = joints.joint, len(joints.joint)
    forces, share = _at_points(assembly)
    statics = sp.hstack([*forces, problem.matrices.of_limited], format="csr")
    one, nothing = sp.eye_array(count, format="csr"), sp.csr_array((count, count))
    rows, limits = [sp.hstack([one, nothing, nothing])], [np.zeros(count)]
    slides = np.flatnonzero(np.isfinite(joints.friction[joint]))
    held, cohesion = joints.friction[joint][slides], (joints.cohesion[joint] * share)[slides]
    factor = np.cos(np.pi / SIDES) if inside else 1.0
    for angle in 2 * np.pi / SIDES * (np.arange(SIDES) + 0.5):
        pressed = sp.diags_array(factor * held) @ one[slides]
        rows.append(sp.hstack([pressed, -np.cos(angle) * one[slides], -np.sin(angle) * one[slides]]))
        limits.append(factor * cohesion)
    return statics, *_limited(assembly, sp.vstack(rows), np.concatenate(limits))


def _limited(assembly: Assembly, rows: sp.csr_array, limits: np.ndarray) -> tuple[sp.csr_array, np.ndarray]:
    """Return the rows and limits of yield with the limits of ties, props and earth pressure appended."""
    force, one = assembly.problem.force_unit, sp.eye_array(len(assembly.limited), format="csr")
    ends = np.array([(each.lowest, each.highest) for each in assembly.limited]).reshape(-1, 2) / force
    below, above = np.isfinite(ends).T
    own = sp.vstack([one[below], -one[above]])
    return sp.block_diag([rows, own], "csr"), np.concatenate([limits, -ends[below, 0], ends[above, 1]])
