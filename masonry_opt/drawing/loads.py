"""Loads as arrows: each force, or one arrow for the direction of many. Fill as lines: its road, its columns,
and the edges that it touches. Ties and props as lines between their ends."""

from collections.abc import Iterable

import numpy as np

from masonry_opt.answer.outcome import Outcome
from masonry_opt.drawing.colours import DEAD, FILL, FURTHER_DEAD, LIVE, STRUT
from masonry_opt.drawing.marks import Marks, moved, size_of
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.problem.loads import Forces, LoadedPiece, loads, moment_of

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
    "weight": (DEAD, 0.8, "weight", "direction of all weights"),
    "dead": (FURTHER_DEAD, 2.4, "further dead load", "direction of further dead loads"),
    # Last and thinner: it may lie on a dead load that it takes away from.
    "live": (LIVE, 1.4, "live load, times λ", "direction of live loads, times λ"),
}

_APART = 0.02  #: Space between the columns that are drawn, over the size of the scene.
_PRESSURE = 0.1  #: Length of the arrow of the largest pressure, over the size of the scene.


def load_marks(assembly: Assembly, motion: np.ndarray, live: bool = True) -> Iterable[Marks]:
    """Fill, then weights, further dead loads and, if they act, live loads, each kind to a scale of its own,
    with motions of the scene's blocks, shape (blocks, 3) or (blocks, 6)."""
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
    if len(forces.force) <= most:
        return False
    direction = forces.force / np.linalg.norm(forces.force, axis=1)[:, None]
    return bool((np.abs(direction - direction[0]) < 1e-9).all())


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
        yield Marks("fill", "fill", "line", FILL, 0.4, drawn, motion[below])
    if tops:
        yield Marks("backing", "backing", "line", FILL, 1.2, np.concatenate(backed))
        yield Marks("backing", "", "line", FILL, 0.8, np.array(tops))
    yield Marks("filled", "edge that fill touches", "line", FILL, 1.8, ends, motion[owner])
    for fill in assembly.scene.fills:
        road = np.array(fill.road) - assembly.geometry.origin
        yield Marks("road", "road", "line", FILL, 1.2, np.stack([road[:-1], road[1:]], axis=1))


def pressure_marks(result: Outcome) -> Iterable[Marks]:
    """What fill presses on each face that it touches, as arrows that end there."""
    assembly, force = result.assembly, result.pressures["force"].to_numpy()
    if len(force) and (most := force.max()) > 0:
        acting = [each.actions[0] for each in assembly.limited if each.role is Role.EARTH]
        tip, along = (np.array([getattr(each, of) for each in acting]) for of in ("point", "force"))
        tail = tip - _PRESSURE * size_of(assembly) / most * force[:, None] * along
        label = f"pressure of fill on a face, {most:.3g} at most"
        yield Marks("earth", label, "arrow", FILL, 1.0, np.stack([tail, tip], axis=1))


_WIDTH = {Role.TIE: 1.8, Role.PROP: 3.6}  #: Width in points, and dashes of those that yield.
_YIELDS = (1.2, 0.8)


def strut_marks(assembly: Assembly, motion: np.ndarray, yields: np.ndarray) -> Iterable[Marks]:
    """Ties and props, those that yield, in the order of ``Result.ties``, dashed, and their ends, with motions
    of the scene's blocks, shape (blocks, 3) or (blocks, 6)."""
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
                look = STRUT, width, halves[those], motions[those], dashes
                yield Marks(kind, f"{kind}{word}", "line", *look)
    yield Marks("ends", "", "square", STRUT, 4.0, at[:, None], of_ends.reshape(len(at), -1))
