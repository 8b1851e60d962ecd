"""Loads, fill, ties and props, and what joints carry, as marks."""

from collections.abc import Iterable

import numpy as np
import shapely

from masonry_opt.answer.outcome import Outcome
from masonry_opt.answer.thresholds import IDLE
from masonry_opt.drawing import colours
from masonry_opt.drawing.marks import Marks, joint_marks, moved, shrink_of, size_of
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.problem.loads import Forces, LoadedPiece, loads, moment_of
from masonry_opt.scene.rows import linked

#: Number of weights, and of other parallel forces, above which one arrow shows the direction of all, by
#: dimension: fewer in space, where arrows lie on each other.
_MOST = {2: (30, 200), 3: (1, 8)}

_LONGEST = 0.09  #: Length of the longest arrow of a kind, over the size of the scene.
_LONE, _OF_BLOCK = 8, 0.6  #: Number of forces above which it is at most this share of a usual block.
_ALONG, _SPACE = 8, 0.3  #: Arrows along an edge load's line, and least space between them over their length.
_ABOVE = 0.16  #: Height of the one arrow for many over the blocks, moved too, over the size of the scene.
_DIRECTION = 0.07  #: Length of that arrow, over the size of the scene.

#: Kinds of loads: colour, width in points, what a legend says of their arrows, and of one arrow for all.
_KINDS = {
    "weight": (colours.DEAD, 0.8, "weight", "direction of all weights"),
    "dead": (colours.FURTHER_DEAD, 2.4, "further dead load", "direction of further dead loads"),
    # Last and thinner: it may lie on a dead load that it takes away from.
    "live": (colours.LIVE, 1.4, "live load, times λ", "direction of live loads, times λ"),
}

_APART = 0.02  #: Space between the columns that are drawn, over the size of the scene.
_PRESSURE = 0.1  #: Length of the arrow of the largest pressure, over the size of the scene.


def load_marks(assembly: Assembly, motion: np.ndarray, live: bool = True) -> Iterable[Marks]:
    """Fill, and each kind of load to a scale of its own; motions of blocks are as ``moved`` takes them."""
    yield from fill_marks(assembly, motion)
    most_weights, most = _MOST[assembly.scene.dimension]
    given = loads(assembly.scene, assembly.geometry, assembly.movable)
    for kind, (colour, width, each, of_all) in _KINDS.items():
        if kind == "live" and not live:
            continue
        forces: Forces = getattr(given, kind)
        pieces = [piece for piece in assembly.loaded_pieces if piece.kind == kind]
        label, points, moves = each, np.empty((0, 2, 2)), np.empty((0, 3))
        if _many_parallel(forces, most_weights if kind == "weight" else most):
            label, points = of_all, _direction(assembly, forces)
            moves = np.zeros((1, motion.shape[1]))
        elif len(forces.force):
            points, moves = _forces(assembly, forces, motion)
        if pieces:
            arrows, tails, owners = _rows(assembly, pieces)
            yield Marks(kind, "", "line", colour, 0.8, tails, np.array([motion[p.block] for p in pieces]))
            points, moves = np.concatenate([points, arrows]), np.concatenate([moves, motion[owners]])
        if len(points):
            # Many arrows are thin, but one that stands for all is thick.
            width = 2.2 if label == of_all else width if len(points) <= 100 else 0.4 * width
            yield Marks(kind, label, "arrow", colour, width, points, moves)


def _many_parallel(forces: Forces, most: int) -> bool:
    direction = forces.force / np.linalg.norm(forces.force, axis=1)[:, None]
    return len(direction) > most and bool((np.abs(direction - direction[0]) < 1e-9).all())


def _direction(assembly: Assembly, forces: Forces) -> np.ndarray:
    total, size = forces.force.sum(axis=0), size_of(assembly)
    tail = assembly.geometry.boxes[1][assembly.movable].max(axis=0)
    tail[-1] += _ABOVE * size
    # Longer in space, where it may point towards the eye.
    length = _DIRECTION * (len(tail) - 1) * size
    return np.array([[tail, tail + length * total / np.linalg.norm(total)]])


def _forces(assembly: Assembly, forces: Forces, motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Arrows from where forces act, or to there if they push from outside; motions, which keep directions."""
    point, blocks = forces.point, assembly.movable[forces.block]
    own, dimension = np.linalg.norm(forces.force, axis=1), point.shape[1]
    longest = _LONGEST * size_of(assembly)
    if len(own) > _LONE:
        usual = float(np.median(assembly.geometry.size[blocks])) ** (1 / dimension)
        longest = min(longest, _OF_BLOCK * usual)
    arrow = longest * forces.force / own.max()
    behind = point - 0.02 * longest * forces.force / own[:, None]
    away = np.array([assembly.geometry.away(*each) for each in zip(blocks, behind, strict=True)])
    tail = point - np.where((away > assembly.geometry.tolerance)[:, None], arrow, 0.0)
    motions = np.zeros((len(point), motion.shape[1]))
    motions[:, :dimension] = moved(point, motion[blocks]) - point
    return np.stack([tail, tail + arrow], axis=1), motions


def _rows(assembly: Assembly, pieces: list[LoadedPiece]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A row of arrows on each loaded piece of edge, a line along their far ends, and the arrows' blocks."""
    longest = 0.8 * _LONGEST * size_of(assembly)
    most = max(np.hypot(*piece.intensity.T).max() for piece in pieces)
    arrows, lines, owners = [], [], []
    for piece in pieces:
        load = assembly.scene.edge_loads[piece.load]
        line = np.hypot(*(np.array(load.end) - load.start))
        length = np.hypot(*(piece.ends[1] - piece.ends[0]))
        count = max(1, min(round(_ALONG * length / line), int(length / (_SPACE * longest)))) + 1
        share = np.linspace(0, 1, count)[:, None]
        arrow = longest / most * ((1 - share) * piece.intensity[0] + share * piece.intensity[1])
        on_edge = (1 - share) * piece.ends[0] + share * piece.ends[1]
        # Arrows end at an edge that is pushed, and begin at one that is pulled.
        behind = piece.ends.mean(axis=0) - 1e-3 * arrow.sum(axis=0)
        pulled = assembly.geometry.away(piece.block, behind) <= 0
        tail = on_edge if pulled else on_edge - arrow
        arrows.append(np.stack([tail, tail + arrow], axis=1))
        lines.append((tail + arrow if pulled else tail)[[0, -1]])
        owners += [piece.block] * count
    return np.concatenate(arrows), np.array(lines), np.array(owners)


def fill_marks(assembly: Assembly, motion: np.ndarray) -> Iterable[Marks]:
    """Roads, which stay; with motions of the blocks, shape (blocks, 3), columns of fill and edges below."""
    pieces = assembly.filled_pieces
    if not pieces:
        return
    owner, ends = np.array([piece.block for piece in pieces]), np.array([piece.ends for piece in pieces])
    columns, below, backed, tops = [np.empty((0, 2, 2))], [], [], []
    for number, piece in enumerate(pieces):
        (right, left), apart = piece.ends[:, 0], _APART * size_of(assembly)
        x = apart * np.arange(np.ceil(left / apart), right / apart)
        low, deep = (np.interp(x, [left, right], of[::-1]) for of in (piece.ends[:, 1], piece.depth))
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
        yield Marks("road", "road", "line", colours.FILL, 1.2, np.stack([road[:-1], road[1:]], axis=1))


def pressure_marks(result: Outcome) -> Iterable[Marks]:
    """What fill presses on each face that it touches, as arrows that end there."""
    assembly, force = result.assembly, result.pressures["force"].to_numpy()
    if len(force) and (most := force.max()) > 0:
        acting = [each.actions[0] for each in assembly.limited if each.role is Role.EARTH]
        tip, along = (np.array([getattr(each, of) for each in acting]) for of in ("point", "force"))
        tail = tip - _PRESSURE * size_of(assembly) / most * force[:, None] * along
        label = f"pressure of fill on a face, {most:.3g} at most"
        yield Marks("earth", label, "arrow", colours.FILL, 1.0, np.stack([tail, tip], axis=1))


_WIDTH = {Role.TIE: 1.8, Role.PROP: 3.6}  #: Width in points, and dashes of those that yield.
_YIELDS = (1.2, 0.8)


def strut_marks(assembly: Assembly, motion: np.ndarray, yields: np.ndarray) -> Iterable[Marks]:
    """Ties and props, and their ends; those that yield, in the order of ``Result.ties``, are dashed."""
    struts = [force for force in assembly.limited if force.role in _WIDTH]
    if not struts:
        return
    ends = np.array([[action.point for action in force.actions] for force in struts])
    with_ground = np.concatenate([motion, np.zeros((1, motion.shape[1]))])
    of_ends = with_ground[[[action.block for action in force.actions] for force in struts]]
    there = moved(ends, of_ends)
    along, apart = (np.diff(of, axis=1)[:, 0] for of in (ends, there - ends))
    turning = np.repeat(moment_of(along, apart) / (along**2).sum(axis=1)[:, None], 2, axis=0)
    # Each half goes with its end and turns with the line, so that they part in the middle where it lengthens.
    at, middle = ends.reshape(len(turning), -1), np.repeat(ends.mean(axis=1), 2, axis=0)
    goes = there.reshape(at.shape) - moved(at, np.column_stack([np.zeros_like(at), turning]))
    halves, motions = np.stack([at, middle], axis=1), np.column_stack([goes, turning])
    role = np.array([force.role for force in struts])
    for kind, width in _WIDTH.items():
        for which, word, dashes in ((~yields, "", ()), (yields, ", yields", _YIELDS)):
            those = np.repeat((role == kind) & which, 2)
            if those.any():
                look = colours.STRUT, width, halves[those], motions[those], dashes
                yield Marks(kind, f"{kind}{word}", "line", *look)
    yield Marks("ends", "", "square", colours.STRUT, 4.0, at[:, None], of_ends.reshape(len(at), -1))


_CHAIN = 3  #: Blocks in a row, each between two others, from which their points of thrust make a line.
#: Length of the longest resultant, over the size of the scene; in space one joint may carry most.
_RESULTANT, _RESULTANT_IN_SPACE = 0.12, 0.3
_SCALE = 0.08  #: Height of the scale over the blocks, over that size.


def thrust(result: Outcome) -> tuple[np.ndarray, np.ndarray]:
    """Resultants on the joints' first blocks, and where they act (in the plane m / n from the middle), in the
    case's units, shape (c, 2) or (c, 3) each. NaN without forces; points also where nothing presses."""
    joints, frame = result.assembly.joints, result.joints
    if result.contacts is not None:
        force, point = (frame[[f"{kind}{axis}" for axis in "xyz"]].to_numpy() for kind in "fp")
        return force, point
    n, s, m = (frame[name].to_numpy() for name in ("n", "s", "m"))
    force = n[:, None] * joints.normal + s[:, None] * joints.tangent
    pressed = n > IDLE * np.abs(n).max(initial=0.0)
    off = np.divide(m, n, out=np.full_like(n, np.nan), where=pressed)
    return force, frame[["x", "y"]].to_numpy() + off[:, None] * joints.tangent


def chains(assembly: Assembly, acts: np.ndarray) -> np.ndarray:
    """Pairs of joints that a line of thrust joins, shape (pairs, 2): those of blocks with two joints, both of
    which press (``acts``, shape (c,)), in rows of at least three."""
    joints, count = assembly.joints, len(assembly.scene.blocks)
    sides = np.concatenate([joints.first, joints.second])
    number = np.tile(np.arange(len(joints.first)), 2)
    has, pressed = (np.bincount(of, minlength=count) for of in (sides, sides[acts[number]]))
    between = (has == 2) & (pressed == 2) & np.isin(np.arange(count), assembly.movable)
    along = between[joints.first] & between[joints.second]
    row = linked(count, joints.first[along], joints.second[along])
    in_chain = between & (np.bincount(row)[row] >= _CHAIN)
    order = np.argsort(sides, kind="stable")
    return number[order][in_chain[sides[order]]].reshape(-1, 2)


def thrust_marks(result: Outcome) -> Iterable[Marks]:
    """Resultants half to each side of where they act, and how large they are. In the plane also the line of
    thrust, along which only those on supports are drawn; in space, thinner, the forces at contact points."""
    assembly, (force, point) = result.assembly, thrust(result)
    size, shrink = size_of(assembly), shrink_of(assembly)
    shown: np.ndarray = np.isfinite(point).all(axis=1)
    point = point - assembly.geometry.origin
    points, who = result.contacts, "of a joint"
    if points is None and len(pairs := chains(assembly, shown)):
        on_line = np.isin(np.arange(len(shown)), pairs)
        at = point[on_line][:, None]
        yield Marks("line", "line of thrust", "line", colours.THRUST, 1.8 * shrink, point[pairs])
        yield Marks("points", "line of thrust", "point", colours.THRUST, 3.2 * shrink, at)
        ends = np.stack([assembly.joints.first, assembly.joints.second])
        on_support = np.logical_or(*~np.isin(ends, assembly.movable))
        shown &= ~on_line | on_support
        who = "on a support" if on_support[shown].all() else who
    if not shown.any():
        return
    most = float(np.linalg.norm(force[shown], axis=1).max())
    unit = (_RESULTANT if points is None else _RESULTANT_IN_SPACE) * size / most
    label = f"resultant {who}, in the case's unit of force"
    if points is not None:
        label = f"resultant {who}; the longest is {most:.3g} in the case's unit of force"
        carried = points[["fx", "fy", "fz"]].to_numpy()
        carries = np.linalg.norm(carried, axis=1) > IDLE * most
        at = points[["x", "y", "z"]].to_numpy()[carries] - assembly.geometry.origin
        lines, width = _through(at, unit * carried[carries], 0.4, 1.0)
        told = "force at a contact point, one state of many"
        yield Marks("contacts", told, "line", colours.AT_POINT, width, lines)
    lines, width = _through(point[shown], unit * force[shown], 0.8, 1.6)
    yield Marks("resultants", label, "line", colours.THRUST, width, lines)
    yield Marks("points", "", "point", colours.THRUST, 1.8 * width, point[shown][:, None])
    if points is None:
        scale = round_below(most)
        left, _, _, top = shapely.total_bounds(assembly.geometry.polygons[assembly.movable])
        ends = np.add([left, top + _SCALE * size], [[[0.0, 0.0], [scale * unit, 0.0]]])
        yield Marks("scale", "", "bar", colours.THRUST, 1.6, ends, text=f"= {scale:g}")


def _through(at: np.ndarray, arrows: np.ndarray, thin: float, thick: float) -> tuple[np.ndarray, float]:
    """Lines half to each side of points, and their width: the thinner the more they are."""
    lines = np.stack([at - arrows / 2, at + arrows / 2], axis=1)
    return lines, float(np.clip(25 / np.sqrt(len(at)), thin, thick))


def round_below(most: float) -> float:
    """The largest of 1, 2 and 5 times powers of ten that is no more."""
    power = 10.0 ** np.floor(np.log10(most))
    return float(max(digit * power for digit in (1, 2, 5) if digit * power <= most))


def utilisation_marks(result: Outcome) -> Iterable[Marks]:
    """Joints, in space the sides of outlines, coloured by utilisation: the most used last, idle ones thin."""
    ends, joint = result.assembly.joints.lines()
    used, steps = result.joints["utilisation"].to_numpy()[joint], len(colours.UTILISATION)
    step = np.where(np.isnan(used), -1, np.clip(np.nan_to_num(used) * steps, 0, steps - 1)).astype(int)
    for number, colour in enumerate((colours.IDLE, *colours.UTILISATION), start=-1):
        label, name = ("idle joint", "idle") if number < 0 else ("", "used")
        # Wider too where more is used, for readers of grey prints.
        width = 1.6 if number < 0 else 2.0 + 1.6 * number / (steps - 1)
        lines = Marks(name, label, "line", colour, width * shrink_of(result.assembly), ends[step == number])
        yield from joint_marks(lines)


def utilisation_label(assembly: Assembly) -> str:
    """What a legend says of the colours of utilisation."""
    limit = "slide, hinge or crush" if assembly.scene.dimension == 2 else "slide"
    return f"utilisation of joints (1: about to {limit})"
