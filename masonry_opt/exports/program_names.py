"""Names of the rows and columns of a declared program: by kind, and by the joint or block they are of."""

from __future__ import annotations

import string
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import pyomo.environ as pyo

from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.chords import CHORDS
from masonry_opt.problem.problem import Problem

#: Parts of a complementary pair, as Pyomo's transformations name them: the slack, the row that defines it,
#: its product with the rate, and the row paired with the rate.
_PAIR = {"v": "z", "bv": "z", "ve": "slack", "bc": "slack", "ccon": "product", "c": "pair"}

#: What LP files of every solver take in names, but for what names here are made of.
_LEGAL = set(string.ascii_letters + string.digits + "_.")

#: LP and MPS files have names of at most 255 characters, kinds among them.
_LONGEST = 200


@dataclass(frozen=True)
class Labels:
    """How joints and blocks are written in names, as ``kind`` + ``opens`` + label + ``closes``.

    Attributes
    ----------
    joints: a different one for each of the problem's joints, in the order of ``Result.joints``, in space of
        ``Result.contacts``.
    blocks: a different one for each movable block, in the order of ``Result.blocks``.
    limited: a different one for each limited force, in the order of ``Result.ties``.
    """

    joints: list[str]
    blocks: list[str]
    limited: list[str]
    opens: str
    closes: str

    def of_joints(self, kind: str) -> list[str]:
        """Names of one kind, one a joint."""
        return [f"{kind}{self.opens}{label}{self.closes}" for label in self.joints]

    def of_limited(self, kind: str) -> list[str]:
        """Names of one kind, one a limited force."""
        return [f"{kind}{self.opens}{label}{self.closes}" for label in self.limited]

    def of_blocks(self, *kinds: str) -> list[str]:
        """Names of several kinds, block by block."""
        return [f"{kind}{self.opens}{label}{self.closes}" for label in self.blocks for kind in kinds]


def readable(assembly: Assembly) -> Labels:
    """``n[A|ground]``: names of blocks as the scene has them."""
    return _by_blocks(assembly, lambda name: name, "[", "]")


def legal(assembly: Assembly) -> Labels:
    """``n{A|ground}``, with ``_`` for what LP files do not take, and not too long for them."""
    return _by_blocks(
        assembly, lambda name: "".join(letter if letter in _LEGAL else "_" for letter in name), "{", "}"
    )


def _by_blocks(assembly: Assembly, written: Callable[[str], str], opens: str, closes: str) -> Labels:
    joints, names = assembly.joints, [written(block.name) for block in assembly.scene.blocks]
    ends = zip(joints.first[assembly.joint], joints.second[assembly.joint], strict=True)
    return Labels(
        unique(f"{names[first]}|{names[second]}" for first, second in ends),
        unique(names[block] for block in assembly.movable),
        unique(written(force.name) for force in assembly.limited),
        opens,
        closes,
    )


def unique(labels: Iterable[str]) -> list[str]:
    """The labels, cut where too long, with ``~2``, ``~3``, ... after those that come again: of several joints
    of two blocks, of blocks whose names differ in what is not legal."""
    cut = [label[:_LONGEST] for label in labels]
    taken, seen, different = set(cut), set(), []
    for label in cut:
        name, times = label, 1
        while name in seen or (times > 1 and name in taken):
            times += 1
            name = f"{label}~{times}"
        seen.add(name)
        different.append(name)
    return different


def names_in(program: pyo.ConcreteModel, problem: Problem, labels: Labels) -> dict[int, str]:
    """A name for every variable, constraint and objective of a declared program, by its identity.

    No two are the same, and none is of a row and of a column.
    """

    def joints(*kinds: str) -> list[str]:
        return [name for kind in kinds for name in labels.of_joints(kind)]

    block, space = labels.of_blocks, problem.layout.round
    of_components = {
        "load_factor": ["load_factor"],
        "q": joints(*(("n", "s", "t") if space else ("n1", "n2", "s"))) + labels.of_limited("T"),
        "d": block("vx", "vy", *(("vz", "wx", "wy", "wz") if space else ("omega",))),
        "equilibrium": block("fx", "fy", *(("fz", "mx", "my", "mz") if space else ("moment",))),
        "compatibility": joints(
            *(("opening", "slip_s", "slip_t") if space else ("opening_1", "opening_2", "slip"))
        )
        + labels.of_limited("length"),
        "live_work": ["live_work"],
        "raising": ["raising"],
        "objective": ["objective"],
    }
    of_faces = {"p": "p", "y": "y", "within_yield": "yield", "at_rest": "at_rest", "at_yield": "at_yield"}
    of_components |= {name: list(_faces(problem, labels, kind)) for name, kind in of_faces.items()}
    names = {}
    for component in program.component_objects((pyo.Var, pyo.Constraint, pyo.Objective), descend_into=False):
        for data, name in zip(component.values(), of_components[component.local_name], strict=True):
            names[id(data)] = name
    pairs: Any = program.component("complementarity")
    for part, kind in _PAIR.items() if pairs is not None else ():
        for pair, name in zip(pairs.values(), _faces(problem, labels, kind), strict=True):
            if (data := pair.component(part)) is not None:
                names[id(data)] = name
    return names


def _faces(problem: Problem, labels: Labels, kind: str) -> Iterator[str]:
    """Names of one kind, one a face."""
    slides, rocks = ["slide_plus", "slide_minus"], ["rock_1", "rock_2"]
    if problem.layout.round:
        slides, rocks = [f"slide_{side + 1}" for side in range(len(problem.layout.senses))], ["open"]
    motions = [motion for motion in slides for _ in problem.sliding]
    motions += [motion for motion in rocks for _ in range(problem.joints)]
    chords = range(1, len(CHORDS.slope) + 1)
    for point in (1, 2):
        motions += [f"crush_{point}_{chord}" for _ in problem.crushing for chord in chords]
    for motion, number in zip(motions, problem.face_joint.tolist(), strict=True):
        yield f"{kind}_{motion}{labels.opens}{labels.joints[number]}{labels.closes}"
    for motion, forces in (("least", problem.table.below), ("most", problem.table.above)):
        names = labels.of_limited(f"{kind}_{motion}")
        yield from (names[force] for force in forces)
