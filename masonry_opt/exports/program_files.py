"""Declared programs as files that other solvers read, through Pyomo's writers: names of rows and columns, by
kind and by the joint or block they are of, and the text."""

import io
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pyomo.environ as pyo
from pyomo.opt import WriterFactory
from pyomo.repn.plugins.lp_writer import LPWriter
from pyomo.repn.plugins.nl_writer import NLWriter

from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.faces import CHORDS
from masonry_opt.problem.problem import Problem

#: Parts of a complementary pair, as Pyomo's transformations name them: the slack, the row that defines it,
#: its product with the rate, and the row paired with the rate.
_PAIR = {"v": "z", "bv": "z", "ve": "slack", "bc": "slack", "ccon": "product", "c": "pair"}

#: What LP files of some solver do not take in names, beside what names here are made of.
_ILLEGAL = r"[^A-Za-z0-9_.]"

_LONGEST = 200  #: LP and MPS files have names of at most 255 characters, kinds among them.

#: Names of what a joint and a block have, by component, in the plane and in space, and of faces that rock.
_OF_JOINTS: dict[int, dict[str, tuple[str, ...]]] = {
    2: {"q": ("n1", "n2", "s"), "compatibility": ("opening_1", "opening_2", "slip")},
    3: {"q": ("n", "s", "t"), "compatibility": ("opening", "slip_s", "slip_t")},
}
_OF_BLOCKS: dict[int, dict[str, tuple[str, ...]]] = {
    2: {"d": ("vx", "vy", "omega"), "equilibrium": ("fx", "fy", "moment")},
    3: {"d": ("vx", "vy", "vz", "wx", "wy", "wz"), "equilibrium": ("fx", "fy", "fz", "mx", "my", "mz")},
}
_ROCKS = {2: ("rock_1", "rock_2"), 3: ("open",)}

#: What a limited force is called among the joints' of a component; kinds of what there is one of a face.
_OF_LIMITED = {"q": "T", "compatibility": "length"}
_OF_FACES = {"p": "p", "y": "y", "within_yield": "yield", "at_rest": "at_rest", "at_yield": "at_yield"}

_SINGLE = ("load_factor", "live_work", "raising", "objective")  #: What there is one of.


@dataclass(frozen=True)
class Labels:
    """How joints and blocks are written in names, between brackets after the kind; no two are the same."""

    joints: list[str]  #: one for each of the problem's, ordered as ``Result.joints``, in space ``.contacts``
    blocks: list[str]  #: one for each movable block, in the order of ``Result.blocks``
    limited: list[str]  #: one for each limited force, in the order of ``Result.ties``


def labels_of(assembly: Assembly, legal: bool) -> Labels:
    """``[A|ground]``, names of blocks as the scene has them, or ``{A|ground}``, legal in LP files: with ``_``
    for what these do not take."""

    def written(name: str) -> str:
        return re.sub(_ILLEGAL, "_", name) if legal else name

    joints, names = assembly.joints, [written(block.name) for block in assembly.scene.blocks]
    ends = zip(joints.first[assembly.joint], joints.second[assembly.joint], strict=True)
    labels = (
        (f"{names[first]}|{names[second]}" for first, second in ends),
        (names[block] for block in assembly.movable),
        (written(force.name) for force in assembly.limited),
    )
    return Labels(*([f"{{{each}}}" if legal else f"[{each}]" for each in unique(of)] for of in labels))


def unique(labels: Iterable[str]) -> list[str]:
    """The labels, cut where too long, with ``~2``, ``~3``, ... after those that come again: of several joints
    of two blocks, of blocks whose names differ in what is not legal."""
    cut = [label[:_LONGEST] for label in labels]
    taken, different = {*cut}, dict[str, None]()
    for label in cut:
        name, times = label, 1
        while name in different or (times > 1 and name in taken):
            times += 1
            name = f"{label}~{times}"
        different[name] = None
    return [*different]


def names_in(program: pyo.ConcreteModel, problem: Problem, labels: Labels) -> dict[int, str]:
    """A name for every variable, constraint and objective of a declared program, by its identity. No two are
    the same, and none is of a row and of a column."""
    dimension = problem.layout.dimension
    of_components: dict[str, list[str]] = {name: [name] for name in _SINGLE}
    for name, kinds in _OF_JOINTS[dimension].items():
        joints = [kind + label for kind in kinds for label in labels.joints]
        of_components[name] = joints + [_OF_LIMITED[name] + label for label in labels.limited]
    for name, kinds in _OF_BLOCKS[dimension].items():
        of_components[name] = [kind + label for label in labels.blocks for kind in kinds]
    of_components |= {name: list(_faces(problem, labels, kind)) for name, kind in _OF_FACES.items()}
    declared = program.component_objects((pyo.Var, pyo.Constraint, pyo.Objective), descend_into=False)
    named = [
        each for one in declared for each in zip(one.values(), of_components[one.local_name], strict=True)
    ]
    if (pairs := program.component("complementarity")) is not None:
        for part, kind in _PAIR.items():
            parts = (pair.component(part) for pair in pairs.values())
            named += zip(parts, _faces(problem, labels, kind), strict=True)
    return {id(data): name for data, name in named if data is not None}


def _faces(problem: Problem, labels: Labels, kind: str) -> Iterator[str]:
    """Names of one kind, one a face."""
    senses = range(1, len(problem.layout.senses) + 1)
    slides = [f"slide_{side}" for side in senses] if problem.layout.round else ["slide_plus", "slide_minus"]
    motions = [motion for motion in slides for _ in problem.sliding]
    motions += [motion for motion in _ROCKS[problem.layout.dimension] for _ in range(problem.joints)]
    chords = range(1, len(CHORDS.slope) + 1)
    motions += [f"crush_{point}_{chord}" for point in (1, 2) for _ in problem.crushing for chord in chords]
    for motion, number in zip(motions, problem.face_joint.tolist(), strict=True):
        yield f"{kind}_{motion}{labels.joints[number]}"
    for motion, forces in (("least", problem.table.below), ("most", problem.table.above)):
        yield from (f"{kind}_{motion}{labels.limited[force]}" for force in forces)


Files = dict[str, str]  #: The files of a program, by the ends of their names.


def _lp(program: pyo.ConcreteModel, names: dict[int, str], header: list[str]) -> Files:
    """An LP file, as CPLEX began them."""
    text = io.StringIO()
    LPWriter().write(program, text, labeler=lambda data: names[id(data)])
    return {".lp": _comments("\\", header) + text.getvalue()}


def _mps(program: pyo.ConcreteModel, names: dict[int, str], header: list[str]) -> Files:
    """A free MPS file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "program.mps"
        labelled = {"labeler": lambda data: names[id(data)]}
        WriterFactory("mps")(program, str(path), lambda _: True, labelled)
        return {".mps": _comments("*", header) + path.read_text(encoding="utf-8")}


def _nl(program: pyo.ConcreteModel, names: dict[int, str], header: list[str]) -> Files:
    """AMPL's NL file, and the names of its rows (then the objective) and columns, one a line."""
    # Comments have their place on the first line alone, where Pyomo writes the program's name.
    program.name = "; ".join(header)
    text = io.StringIO()
    written = NLWriter().write(program, text, linear_presolve=False, scale_model=False)

    def lines(*kinds: list[object]) -> Iterator[str]:
        return (f"{names[id(data)]}\n" for kind in kinds for data in kind)

    rows = "".join(lines(written.constraints, written.objectives))
    # The program is written last: whoever finds it finds the files of its names too.
    return {".row": rows, ".col": "".join(lines(written.variables)), ".nl": text.getvalue()}


def _comments(mark: str, lines: list[str]) -> str:
    return "".join(f"{mark} {line}\n" for line in lines)


#: Writers by the end of a file's name.
WRITERS: dict[str, Callable[[pyo.ConcreteModel, dict[int, str], list[str]], Files]]
WRITERS = {".lp": _lp, ".mps": _mps, ".nl": _nl}
