"""Marks of loads, fill, ties and props, and of the forces in joints."""

from collections import Counter
from collections.abc import Iterable

import numpy as np
import shapely

from masonry_opt.drawing import colours
from masonry_opt.drawing.marks import Marks, joint_marks, movable_box, moved, shrink_of, size_of
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.problem.loads import Forces, LoadedPiece, moment_of
from masonry_opt.scene.rows import linked
from masonry_opt.solution.outcome import Outcome
from masonry_opt.solution.thresholds import NEGLIGIBLE_SHARE

#: Largest number of parallel forces that are drawn as separate arrows, for each dimension of the scene. The
#: first limit applies to weights, the second to every other kind of load. If there are more parallel forces,
#: a single arrow shows their direction. In space the limits are lower, because arrows would overlap.
_MOST_ARROWS = {2: (30, 200), 3: (1, 8)}

_LONGEST = 0.09  #: Length of the longest arrow of each kind of load, relative to the size of the scene.
#: If a kind of load has more forces than this number, the length of their arrows is limited by
#: ``_LARGEST_ARROW_LENGTH``.
_MOST_UNLIMITED_ARROWS = 8
#: Largest length of an arrow if a kind of load has more than ``_MOST_UNLIMITED_ARROWS`` forces, relative to
#: the median size of a block.
_LARGEST_ARROW_LENGTH = 0.6
#: Distance between arrows of different kinds of load at one point, relative to the size of the scene.
_SIDE_STEP = 0.02
_EDGE_LOAD_INTERVALS = 8  #: Number of intervals into which arrows divide the line of an edge load.
#: Smallest distance between the arrows of an edge load, relative to the longest arrow.
_LEAST_ARROW_SPACING = 0.3
#: In space, a single arrow that represents many forces is drawn above the blocks. This is its height above
#: the highest block, relative to the size of the scene. With a smaller value, blocks that move upwards could
#: reach the arrow.
_SINGLE_ARROW_HEIGHT = 0.16
#: In the plane, a single arrow that represents many forces is drawn beside the blocks, at this distance
#: relative to the size of the scene.
_SINGLE_ARROW_DISTANCE = 0.04
#: Length of a single arrow that represents many forces, relative to the size of the scene. In space the arrow
#: is twice as long.
_SINGLE_ARROW_LENGTH = 0.07

#: In space, a single arrow that represents many forces is drawn above a corner of the blocks. The signs of
#: the horizontal components of the live load select the corner. A component counts as zero if its magnitude
#: is at most this fraction of the largest magnitude of a component.
_NEGLIGIBLE_PUSH = 1e-6
#: Style of each kind of load: colour, line width in points, legend entry, and the legend entry of a single
#: arrow that represents all forces.
_LOAD_STYLES = {
    "weight": (colours.DEAD, 0.8, "weight", "direction of all weights"),
    "dead": (colours.FURTHER_DEAD, 2.4, "further dead load", "direction of further dead loads"),
    # The live load is drawn last, over the dead load. Its lines are thinner than those of further dead loads,
    # so that a dead load in the opposite direction stays visible.
    "live": (colours.LIVE, 1.4, "live load, times λ", "direction of live loads, times λ"),
}

#: Distance between the vertical lines that represent fill, relative to the size of the scene.
_COLUMN_STEP = 0.02
_PRESSURE = 0.1  #: Length of the arrow of the largest pressure of fill, relative to the size of the scene.


def load_marks(assembly: Assembly, motion: np.ndarray, live: bool = True) -> Iterable[Marks]:
    """Generate marks of fill, and arrows of loads. Arrow lengths are scaled separately for each kind of load.

    ``motion`` is the full motion of blocks, see :func:`~.marks.moved`. If ``live`` is False, live loads are
    omitted.
    """
    yield from fill_marks(assembly, motion)
    most_weights, most_others = _MOST_ARROWS[assembly.scene.dimension]
    all_loads = assembly.block_loads
    rows = 0  # number of kinds of load that are drawn as a single arrow so far
    drawn = Counter[tuple[float, ...]]()  # number of arrows drawn so far, keyed by tail and direction
    for kind, (colour, width, label, label_of_all) in _LOAD_STYLES.items():
        if kind == "live" and not live:
            continue
        forces: Forces = getattr(all_loads, kind)
        pieces = [piece for piece in assembly.loaded_pieces if piece.kind == kind]
        points, motions = np.empty((0, 2, 2)), np.empty((0, 3))
        is_single = _many_parallel(forces, most_weights if kind == "weight" else most_others)
        if is_single:
            points, motions = _direction(assembly, forces, rows), np.zeros((1, motion.shape[1]))
            rows += 1
        elif len(forces.force):
            points, motions = _forces(assembly, forces, motion)
            if assembly.scene.dimension == 2:
                points = _side_by_side(points, drawn, size_of(assembly))
        if pieces:
            arrows, tails, owners = _rows(assembly, pieces)
            yield Marks(kind, "", "line", colour, 0.8, tails, np.array([motion[p.block] for p in pieces]))
            points, motions = np.concatenate([points, arrows]), np.concatenate([motions, motion[owners]])
        if len(points):
            # A single arrow that represents many forces has a thick line. If a kind of load has more than 100
            # arrows, their lines are thin.
            if is_single:
                label, width = label_of_all, 2.2
            elif len(points) > 100:
                width = 0.4 * width
            yield Marks(kind, label, "arrow", colour, width, points, motions)


def _side_by_side(arrows: np.ndarray, drawn: Counter[tuple[float, ...]], size: float) -> np.ndarray:
    """Shift arrows in the plane sideways if they would cover arrows of another kind of load.

    ``drawn`` counts the arrows that are drawn already, by tail and direction. The new arrows are added.
    """
    run = arrows[:, 1] - arrows[:, 0]
    direction = run / np.linalg.norm(run, axis=1)[:, None]
    tails = arrows[:, 0] / size
    keys = [(*row,) for row in (np.column_stack([tails, direction]).round(6) + 0.0).tolist()]
    steps = np.array([drawn[key] for key in keys])
    drawn.update(set(keys))
    sideways = np.column_stack([direction[:, 1], -direction[:, 0]])
    return arrows + (_SIDE_STEP * size * steps[:, None] * sideways)[:, None]


def _many_parallel(forces: Forces, most: int) -> bool:
    """Return True if there are more than ``most`` forces and all forces have the same direction."""
    direction = forces.force / np.linalg.norm(forces.force, axis=1)[:, None]
    return len(direction) > most and bool((np.abs(direction - direction[0]) < 1e-9).all())


def _direction(assembly: Assembly, forces: Forces, row: int) -> np.ndarray:
    """Return a single arrow that represents all forces of one kind of load, shape (1, 2, dim).

    In the plane the arrow is in an upper corner of the picture: in the corner from which the live load pushes
    the blocks away, because no moving block covers it. ``row`` is the number of similar arrows drawn before.
    In space the arrow is above the upper corner of the blocks from which the live load pushes away. The
    default view looks against the live load, so this corner is at the back of the picture.
    """
    total, size = forces.force.sum(axis=0), size_of(assembly)
    (low, high), push = movable_box(assembly), assembly.problem.forces(assembly.problem.live).sum(axis=0)
    direction, dimension = total / np.linalg.norm(total), len(high)
    tail = high.copy()
    if dimension == 3:
        tail[:2] = np.where(push[:2] > _NEGLIGIBLE_PUSH * np.abs(push).max(), low[:2], high[:2])
        tail[-1] += _SINGLE_ARROW_HEIGHT * size
        # The arrow is twice as long as in the plane, because it may point towards the viewer and look short.
        return np.array([[tail, tail + 2 * _SINGLE_ARROW_LENGTH * size * direction]])
    length, out = _SINGLE_ARROW_LENGTH * size * direction, _SINGLE_ARROW_DISTANCE * size
    tail[0] = low[0] - out - max(length[0], 0.0)
    if push[0] < 0:
        tail[0] = high[0] + out - min(length[0], 0.0)
    tail[1] -= max(length[1], 0.0)
    # Arrows of different kinds of load are drawn below each other.
    tail[1] -= row * 2 * _SINGLE_ARROW_LENGTH * size
    return np.array([[tail, tail + length]])


def _forces(assembly: Assembly, forces: Forces, motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the arrows of forces, and the translations by which the arrows move with the blocks.

    An arrow starts at the point of action. If the force pushes on the block from outside, the arrow ends
    there.
    """
    point, blocks = forces.point, assembly.movable[forces.block]
    sizes, dimension = np.linalg.norm(forces.force, axis=1), point.shape[1]
    longest = _LONGEST * size_of(assembly)
    if len(sizes) > _MOST_UNLIMITED_ARROWS:
        median_side = float(np.median(assembly.geometry.size[blocks])) ** (1 / dimension)
        longest = min(longest, _LARGEST_ARROW_LENGTH * median_side)
    arrow = longest * forces.force / sizes.max()
    behind = point - 0.02 * longest * forces.force / sizes[:, None]
    away = np.array([assembly.geometry.away(*pair) for pair in zip(blocks, behind, strict=True)])
    tail = point - np.where((away > assembly.geometry.tolerance)[:, None], arrow, 0.0)
    motions = np.zeros((len(point), motion.shape[1]))
    motions[:, :dimension] = moved(point, motion[blocks]) - point
    return np.stack([tail, tail + arrow], axis=1), motions


def _rows(assembly: Assembly, pieces: list[LoadedPiece]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the arrows of edge loads, the lines through their outer ends, and the block of each arrow."""
    longest = 0.8 * _LONGEST * size_of(assembly)
    most = max(np.hypot(*piece.intensity.T).max() for piece in pieces)
    arrows, lines, owners = [], [], []
    for piece in pieces:
        load = assembly.scene.edge_loads[piece.load]
        line = np.hypot(*(np.array(load.end) - load.start))
        length = np.hypot(*(piece.ends[1] - piece.ends[0]))
        most_intervals = int(length / (_LEAST_ARROW_SPACING * longest))
        count = max(1, min(round(_EDGE_LOAD_INTERVALS * length / line), most_intervals)) + 1
        share = np.linspace(0, 1, count)[:, None]
        arrow = longest / most * ((1 - share) * piece.intensity[0] + share * piece.intensity[1])
        on_edge = (1 - share) * piece.ends[0] + share * piece.ends[1]
        # If the load pushes on the edge, arrows end at the edge; if it pulls, arrows start at the edge. The
        # load pulls if the middle of the edge, shifted slightly against the load, lies inside the block.
        behind = piece.ends.mean(axis=0) - 1e-3 * arrow.sum(axis=0)
        pulled = assembly.geometry.away(piece.block, behind) <= 0
        tail = on_edge if pulled else on_edge - arrow
        arrows.append(np.stack([tail, tail + arrow], axis=1))
        lines.append((tail + arrow if pulled else tail)[[0, -1]])
        owners += [piece.block] * count
    return np.concatenate(arrows), np.array(lines), np.array(owners)


def fill_marks(assembly: Assembly, motion: np.ndarray) -> Iterable[Marks]:
    """Generate the marks that represent fill: vertical hatching, backing, roads, and edges that fill touches.

    Hatching lines and edges move with the blocks below, whose motions have shape (blocks, 3). Roads and
    backing do not move.
    """
    pieces = assembly.filled_pieces
    if not pieces:
        return
    owner, ends = np.array([piece.block for piece in pieces]), np.array([piece.ends for piece in pieces])
    columns, below, backed, tops = [np.empty((0, 2, 2))], [], [], []
    for number, piece in enumerate(pieces):
        (right, left), step = piece.ends[:, 0], _COLUMN_STEP * size_of(assembly)
        x = step * np.arange(np.ceil(left / step), right / step)
        low, deep = (np.interp(x, [left, right], ends[::-1]) for ends in (piece.ends[:, 1], piece.depth))
        columns.append(np.stack([np.column_stack([x, low]), np.column_stack([x, low + deep])], axis=1))
        below += [owner[number]] * len(x)
        if piece.zone and left < right:
            fill = assembly.scene.fills[piece.fill]
            line = (np.array(fill.zones[piece.zone].road) - assembly.geometry.origin).T
            top = [np.column_stack([at, np.interp(at, *line)]) for at in (x, np.array([left, right]))]
            backed.append(np.stack([columns[-1][:, 0], top[0]], axis=1))
            tops.append(top[1])
    drawn = np.concatenate(columns)
    if len(drawn):
        yield Marks("fill", "fill", "line", colours.FILL, 0.4, drawn, motion[below])
    if tops:
        yield Marks("backing", "backing", "line", colours.FILL, 1.2, np.concatenate(backed))
        yield Marks("backing", "", "line", colours.FILL, 0.8, np.array(tops))
    yield Marks("filled", "edge that fill touches", "line", colours.FILL, 1.8, ends, motion[owner])
    for fill in assembly.scene.fills:
        road = np.array(fill.road) - assembly.geometry.origin
        if assembly.at_rest is not None:
            road = assembly.scene.settled.road(assembly.scene, assembly.at_rest.geometry, road)
        yield Marks("road", "road", "line", colours.FILL, 1.2, np.stack([road[:-1], road[1:]], axis=1))


def pressure_marks(result: Outcome) -> Iterable[Marks]:
    """Generate an arrow of earth pressure for each face that fill touches. The arrow ends at the face."""
    assembly, force = result.assembly, result.pressures["force"].to_numpy()
    if not len(force):
        return
    most = force.max()
    if most > 0:
        actions = [limited.actions[0] for limited in assembly.limited if limited.role is Role.EARTH]
        tip = np.array([action.point for action in actions])
        direction = np.array([action.force for action in actions])
        tail = tip - _PRESSURE * size_of(assembly) / most * force[:, None] * direction
        label = f"earth pressure as a force; longest arrow: {most:.3g}, in the case's unit of force"
        yield Marks("earth", label, "arrow", colours.FILL, 1.0, np.stack([tail, tip], axis=1))


_STRUT_WIDTH = {Role.TIE: 1.8, Role.PROP: 3.6}  #: Width of the lines of ties and props, in points.
#: Lengths of the dashes and of the gaps between them, for ties and props that yield, relative to the line
#: width.
_YIELD_DASHES = (1.2, 0.8)


def strut_marks(assembly: Assembly, motion: np.ndarray, yields: np.ndarray) -> Iterable[Marks]:
    """Generate marks of ties and props and of their ends.

    ``yields`` is True for ties and props that yield, in the order of ``Result.ties``; such lines are dashed.
    """
    struts = [force for force in assembly.limited if force.role in _STRUT_WIDTH]
    if not struts:
        return
    ends = np.array([[action.point for action in force.actions] for force in struts])
    with_ground = np.concatenate([motion, np.zeros((1, motion.shape[1]))])
    of_ends = with_ground[[[action.block for action in force.actions] for force in struts]]
    moved_ends = moved(ends, of_ends)
    along, apart = np.diff(ends, axis=1)[:, 0], np.diff(moved_ends - ends, axis=1)[:, 0]
    turning = np.repeat(moment_of(along, apart) / (along**2).sum(axis=1)[:, None], 2, axis=0)
    # Draw each tie or prop as two halves. Each half moves with one end of the tie or prop, and rotates like
    # the line between both ends. A gap opens between the halves if the distance between the ends increases.
    at, middle = ends.reshape(len(turning), -1), np.repeat(ends.mean(axis=1), 2, axis=0)
    goes = moved_ends.reshape(at.shape) - moved(at, np.column_stack([np.zeros_like(at), turning]))
    halves, motions = np.stack([at, middle], axis=1), np.column_stack([goes, turning])
    role = np.array([force.role for force in struts])
    for kind, width in _STRUT_WIDTH.items():
        for selected, word, dashes in ((~yields, "", ()), (yields, ", yields", _YIELD_DASHES)):
            drawn = np.repeat((role == kind) & selected, 2)
            if drawn.any():
                look = colours.STRUT, width, halves[drawn], motions[drawn], dashes
                yield Marks(kind, f"{kind}{word}", "line", *look)
    yield Marks("ends", "", "square", colours.STRUT, 4.0, at[:, None], of_ends.reshape(len(at), -1))


#: A line of thrust is drawn through at least this number of successive blocks with exactly two joints each.
#: In shorter rows, the resultant of each joint is drawn.
_FEWEST_BLOCKS_OF_THRUST_LINE = 3
_RESULTANT = 0.12  #: Length of the longest resultant in the plane, relative to the size of the scene.
#: Length of the longest resultant in space, relative to the size of the scene. It exceeds ``_RESULTANT``,
#: because in space most resultants are much shorter than the longest.
_RESULTANT_IN_SPACE = 0.3
_SCALE = 0.08  #: Height of the force scale above the blocks, relative to the size of the scene.


def thrust(result: Outcome) -> tuple[np.ndarray, np.ndarray]:
    """Return the resultant force of each joint on its first block, and the point of action.

    Both arrays are in the case's units and have shape (c, 2), in space (c, 3). In the plane, a resultant acts
    at the distance m / n from the middle of its joint. Forces that are unknown are NaN. The point of action
    is also NaN if the joint is not in compression.
    """
    joints, frame = result.assembly.joints, result.joints
    if result.contacts is not None:
        force, point = (frame[[f"{kind}{axis}" for axis in "xyz"]].to_numpy() for kind in "fp")
        return force, point
    n, s, m = (frame[name].to_numpy() for name in ("n", "s", "m"))
    force = n[:, None] * joints.normal + s[:, None] * joints.tangent
    pressed = n > NEGLIGIBLE_SHARE * np.abs(n).max(initial=0.0)
    off = np.divide(m, n, out=np.full_like(n, np.nan), where=pressed)
    return force, frame[["x", "y"]].to_numpy() + off[:, None] * joints.tangent


def chains(assembly: Assembly, acts: np.ndarray) -> np.ndarray:
    """Return the pairs of joints that a line of thrust connects through a block, shape (pairs, 2).

    Each pair belongs to a movable block with exactly two joints, both in compression. At least
    ``_FEWEST_BLOCKS_OF_THRUST_LINE`` such blocks must form a row. ``acts``, shape (c,), is True for joints in
    compression.
    """
    joints, count = assembly.joints, len(assembly.scene.blocks)
    sides = np.concatenate([joints.first, joints.second])
    joint_of_side = np.tile(np.arange(len(joints.first)), 2)
    joint_count = np.bincount(sides, minlength=count)
    pressed_count = np.bincount(sides[acts[joint_of_side]], minlength=count)
    between = (joint_count == 2) & (pressed_count == 2) & np.isin(np.arange(count), assembly.movable)
    along = between[joints.first] & between[joints.second]
    row = linked(count, joints.first[along], joints.second[along])
    in_chain = between & (np.bincount(row)[row] >= _FEWEST_BLOCKS_OF_THRUST_LINE)
    order = np.argsort(sides, kind="stable")
    return joint_of_side[order][in_chain[sides[order]]].reshape(-1, 2)


def thrust_marks(result: Outcome) -> Iterable[Marks]:
    """Generate marks of the resultant forces of joints, centred at their points of action, and a scale bar.

    In the plane, lines of thrust are drawn too, and along them only resultants on supports are shown. In
    space, forces at contact points are drawn too, with thinner lines.
    """
    assembly, (force, point) = result.assembly, thrust(result)
    contacts, size = result.contacts, size_of(assembly)
    is_shown: np.ndarray = np.isfinite(point).all(axis=1)
    point = point - assembly.geometry.origin
    owner = "of a joint"
    pairs = chains(assembly, is_shown) if contacts is None else np.empty((0, 2), dtype=int)
    if len(pairs):
        on_line = np.isin(np.arange(len(is_shown)), pairs)
        yield from _line_of_thrust(point[pairs], point[on_line][:, None], shrink_of(assembly))
        ends = np.stack([assembly.joints.first, assembly.joints.second])
        on_support = np.logical_or(*~np.isin(ends, assembly.movable))
        is_shown &= ~on_line | on_support
        owner = "on a support" if on_support[is_shown].all() else owner
    if not is_shown.any():
        return
    largest = float(np.linalg.norm(force[is_shown], axis=1).max())
    unit = (_RESULTANT if contacts is None else _RESULTANT_IN_SPACE) * size / largest
    label = f"resultant {owner}, in the case's unit of force"
    if contacts is not None:
        label = f"{label}; longest line: {largest:.3g}"
        contact_force = contacts[["fx", "fy", "fz"]].to_numpy()
        carries = np.linalg.norm(contact_force, axis=1) > NEGLIGIBLE_SHARE * largest
        at = contacts[["x", "y", "z"]].to_numpy()[carries] - assembly.geometry.origin
        lines, width = _through(at, unit * contact_force[carries], 0.4, 1.0)
        entry = "force at a contact point (in general not unique)"
        yield Marks("contacts", entry, "line", colours.AT_POINT, width, lines)
    lines, width = _through(point[is_shown], unit * force[is_shown], 0.8, 1.6)
    yield Marks("resultants", label, "line", colours.THRUST, width, lines)
    yield Marks("points", "", "point", colours.THRUST, 1.8 * width, point[is_shown][:, None])
    if contacts is None:
        yield _force_scale(assembly, largest, unit)


def _line_of_thrust(lines: np.ndarray, points: np.ndarray, shrink: float) -> Iterable[Marks]:
    """Generate marks of lines of thrust: segments between joints, and points of action on joints.

    The segments ``lines`` have shape (pairs, 2, 2), and ``points`` has shape (points, 1, 2).
    """
    yield Marks("line", "line of thrust", "line", colours.THRUST, 1.8 * shrink, lines)
    yield Marks("points", "line of thrust", "point", colours.THRUST, 3.2 * shrink, points)


def _force_scale(assembly: Assembly, largest: float, unit: float) -> Marks:
    """Return a scale bar for forces. The bar represents a force with a round value of at most ``largest``.

    ``unit`` is the drawn length of a unit force.
    """
    scale = round_below(largest)
    left, _, _, top = shapely.total_bounds(assembly.geometry.polygons[assembly.movable])
    origin = [left, top + _SCALE * size_of(assembly)]
    ends = np.add(origin, [[[0.0, 0.0], [scale * unit, 0.0]]])
    return Marks("scale", "", "bar", colours.THRUST, 1.6, ends, text=f"= {scale:g}")


def _through(at: np.ndarray, arrows: np.ndarray, thin: float, thick: float) -> tuple[np.ndarray, float]:
    """Return lines that represent forces, centred at the points ``at``, and the width of the lines.

    The width decreases with the number of lines.
    """
    lines = np.stack([at - arrows / 2, at + arrows / 2], axis=1)
    return lines, float(np.clip(25 / np.sqrt(len(at)), thin, thick))


def round_below(most: float) -> float:
    """Return the largest round number up to ``most``: 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(most))
    return float(max(digit * power for digit in (1, 2, 5) if digit * power <= most))


def utilisation_marks(result: Outcome) -> Iterable[Marks]:
    """Generate marks of joints, coloured by utilisation: lines in the plane, outlines in space.

    Lines with larger utilisation are drawn later, on top. Lines of joints without force are thin.
    """
    ends, joint = result.assembly.joints.lines()
    used, steps = result.joints["utilisation"].to_numpy()[joint], len(colours.UTILISATION)
    step = np.where(np.isnan(used), -1, np.clip(np.nan_to_num(used) * steps, 0, steps - 1)).astype(int)
    for number, colour in enumerate((colours.IDLE_COLOUR, *colours.UTILISATION), start=-1):
        label, name = ("joint without force", "idle") if number < 0 else ("", "used")
        # Lines are wider at larger utilisation, so that a grey print shows the utilisation too.
        width = 1.6 if number < 0 else 2.0 + 1.6 * number / (steps - 1)
        lines = Marks(name, label, "line", colour, width * shrink_of(result.assembly), ends[step == number])
        yield from joint_marks(lines)


def utilisation_label(assembly: Assembly) -> str:
    """Return the label of the colour bar of utilisation."""
    limit = "slide, hinge or crush" if assembly.scene.dimension == 2 else "slide"
    return f"utilisation of joints (1: about to {limit})"
