"""``export``: the program that a method declares as a file for other solvers, through Pyomo's writers."""

import io
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pyomo.environ as pyo
from pyomo.opt import WriterFactory
from pyomo.repn.plugins.lp_writer import LPWriter
from pyomo.repn.plugins.nl_writer import NLWriter

from masonry_opt.analysis import refuse_unsuited, solve
from masonry_opt.effort import Effort
from masonry_opt.errors import NoLoadFactorError, OptionError, OutputError
from masonry_opt.exports.solid_files import SOLID_ENDS, solid_file
from masonry_opt.files import MARK, refuse_unwritable, write_together
from masonry_opt.methods.bracket.relaxation import a_little_above, assumed_rates, bounds_of
from masonry_opt.methods.registry import METHODS
from masonry_opt.models.pyomo_kinematic import PyomoKinematic
from masonry_opt.models.pyomo_mcp import PyomoMcp, with_pairs
from masonry_opt.models.pyomo_mpec import PyomoGlobal, PyomoMpec, PyomoRelaxed
from masonry_opt.models.pyomo_static import PyomoStatic
from masonry_opt.problem.assembly import Assembly, assemble
from masonry_opt.problem.faces import CHORDS
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.result import Result
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.tables import write_file
from masonry_opt.words.sentences import by_sides

#: ε of the products z p ≤ ε that are written for complementarity: far above what solvers take for feasible,
#: and far below a load factor.
EPSILON = 1e-6

#: A declared program, and what is to be said of it, a line each.
Declared = tuple[pyo.ConcreteModel, list[str]]


def _associative(model: type[PyomoStatic | PyomoKinematic], words: str, assembly: Assembly) -> Declared:
    problem = assembly.problem
    return model(problem, ShearLimits.true(problem)).program, [_objective(words, problem)]


def _mcp(assembly: Assembly) -> Declared:
    model = PyomoMcp(assembly.problem)
    with_pairs(model)
    return model.program, ["no objective: every state of collapse"]


def _mpec(assembly: Assembly) -> Declared:
    model = PyomoRelaxed(PyomoMpec(assembly.problem))
    model.epsilon.set_value(EPSILON)
    said = f"complementarity as products of slack and rate, each at most {EPSILON:g}"
    return model.program, [_objective("load_factor", assembly.problem), said]


def _global(assembly: Assembly) -> Declared:
    problem = assembly.problem
    associative = solve(assembly.scene, "static").required()
    if associative < 0:
        raise NoLoadFactorError(
            f"{assembly.scene.origin}: the program of 'global' looks for load factors from 0 on, and none is "
            f"above {associative:g}: turn the live load round"
        )
    highest = a_little_above(associative)
    known = solve(assembly.scene).solution.d
    of = bounds_of(problem, highest, assumed_rates(problem, known), Effort())
    rates = "follows from kinematics" if of.rates_derived else "is assumed"
    forces = "follow from statics" if of.forces_derived else "are assumed where statics set none"
    # Where a face rocks its opening is twice its rate: half the limit.
    most_rates = np.full(problem.faces, of.rates)
    most_rates[problem.table.rocks] /= 2
    # Slacks are at most 2 (c + μ n̂) of sliding, 2 n̂ of rocking.
    most_slack = 2 * of.normal[problem.face_joint]
    limits = ShearLimits.true(problem).at(of.normal[problem.sliding])
    most_slack[problem.table.slides] = 2 * np.tile(limits, 2)
    model = PyomoGlobal(problem, most_slack, most_rates, highest)
    return model.program, [
        _objective("load_factor", problem),
        f"0 <= load_factor <= {highest:.9g} (a little above the associative one)",
        f"the sum of slips and edge openings is at most {of.rates:.9g}, which {rates}",
        f"limits of forces {forces}",
    ]


def _objective(words: str, problem: Problem) -> str:
    of = "live forces and moments, by their sizes" if problem.layout.round else "the live load's components"
    return f"objective: {words} times {problem.live_norm!r}, the sum of {of}"


#: By method, what declares its program.
_EXPORTS: dict[str, Callable[[Assembly], Declared]] = {
    "static": partial(_associative, PyomoStatic, "-load_factor"),
    "kinematic": partial(_associative, PyomoKinematic, "work of a mechanism; at its least: load_factor"),
    "global": _global,
    "mpec": _mpec,
    "mcp": _mcp,
}

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


def _labels(assembly: Assembly, legal: bool) -> list[list[str]]:
    """How joints (in space contact points), movable blocks and limited forces are written in names after the
    kind, in the order of a result's frames: ``[A|ground]``, or legal in LP files: ``{A|ground}``."""

    def written(name: str) -> str:
        return re.sub(_ILLEGAL, "_", name) if legal else name

    joints, names = assembly.joints, [written(block.name) for block in assembly.scene.blocks]
    ends = zip(joints.first[assembly.joint], joints.second[assembly.joint], strict=True)
    labels = (
        (f"{names[first]}|{names[second]}" for first, second in ends),
        (names[block] for block in assembly.movable),
        (written(force.name) for force in assembly.limited),
    )
    return [[f"{{{each}}}" if legal else f"[{each}]" for each in unique(of)] for of in labels]


def unique(labels: Iterable[str]) -> list[str]:
    """The labels, cut where too long, with ``~2``, ``~3``, ... after those that come again."""
    cut = [label[:_LONGEST] for label in labels]
    taken, different = {*cut}, dict[str, None]()
    for label in cut:
        name, times = label, 1
        while name in different or (times > 1 and name in taken):
            times += 1
            name = f"{label}~{times}"
        different[name] = None
    return [*different]


def names_in(program: pyo.ConcreteModel, assembly: Assembly, legal: bool) -> dict[int, str]:
    """Names, all different, of variables, constraints and objective of a declared program, by identity."""
    dimension, (joints, blocks, limited) = assembly.scene.dimension, _labels(assembly, legal)
    faces = [*_faces(assembly.problem, joints, limited)]
    of_components: dict[str, list[str]] = {name: [name] for name in _SINGLE}
    for name, kinds in _OF_JOINTS[dimension].items():
        of_components[name] = [kind + label for kind in kinds for label in joints]
        of_components[name] += [_OF_LIMITED[name] + label for label in limited]
    for name, kinds in _OF_BLOCKS[dimension].items():
        of_components[name] = [kind + label for label in blocks for kind in kinds]
    of_components |= {name: [f"{kind}_{face}" for face in faces] for name, kind in _OF_FACES.items()}
    declared = program.component_objects((pyo.Var, pyo.Constraint, pyo.Objective), descend_into=False)
    named = [
        each for one in declared for each in zip(one.values(), of_components[one.local_name], strict=True)
    ]
    if (pairs := program.component("complementarity")) is not None:
        for part, kind in _PAIR.items():
            parts = (pair.component(part) for pair in pairs.values())
            named += zip(parts, (f"{kind}_{face}" for face in faces), strict=True)
    return {id(data): name for data, name in named if data is not None}


def _faces(problem: Problem, joints: list[str], limited: list[str]) -> Iterator[str]:
    """Names of faces, behind the kind."""
    senses = range(1, len(problem.layout.senses) + 1)
    slides = [f"slide_{side}" for side in senses] if problem.layout.round else ["slide_plus", "slide_minus"]
    motions = [motion for motion in slides for _ in problem.sliding]
    motions += [motion for motion in _ROCKS[problem.layout.dimension] for _ in range(problem.joints)]
    chords = range(1, len(CHORDS.slope) + 1)
    motions += [f"crush_{point}_{chord}" for point in (1, 2) for _ in problem.crushing for chord in chords]
    for motion, number in zip(motions, problem.face_joint.tolist(), strict=True):
        yield motion + joints[number]
    yield from (f"least{limited[force]}" for force in problem.table.below)
    yield from (f"most{limited[force]}" for force in problem.table.above)


def _lp(program: pyo.ConcreteModel, names: dict[int, str], header: list[str]) -> dict[str, str]:
    """An LP file, as CPLEX began them."""
    text = io.StringIO()
    LPWriter().write(program, text, labeler=lambda data: names[id(data)])
    return {".lp": _comments("\\", header) + text.getvalue()}


def _mps(program: pyo.ConcreteModel, names: dict[int, str], header: list[str]) -> dict[str, str]:
    """A free MPS file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "program.mps"
        labelled = {"labeler": lambda data: names[id(data)]}
        WriterFactory("mps")(program, str(path), lambda _: True, labelled)
        return {".mps": _comments("*", header) + path.read_text(encoding="utf-8")}


def _nl(program: pyo.ConcreteModel, names: dict[int, str], header: list[str]) -> dict[str, str]:
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


#: Writers by the end of a file's name: each gives the texts of its files by their ends.
_WRITERS = {".lp": _lp, ".mps": _mps, ".nl": _nl}


def export(
    scene: Scene | Result | str | Path,
    path: str | Path,
    method: str | None = None,
    force: bool = False,
    *,
    moved: float | None = None,
) -> tuple[Path, ...]:
    """Write the program that a method declares, for other solvers; or, in space, blocks, forces and motion,
    for other programs. Returns the files written, each whole.

    Of programs rows and columns are named by kind and blocks, units are those of
    :class:`~masonry_opt.problem.problem.Problem`, and λ is the scene's; see ``docs/solver_people.md``.

    Of solids, which are written in the case's own units, OBJ and glTF have one object a block; names of
    supports begin with ``fixed``. COMPAS JSON is an assembly of compas_assembly: blocks at rest, joints as
    interfaces with forces at their contact points, velocities as displacements.

    Raises CaseError if the case file or scene is wrong, or nothing carries a live load; OptionError if the
    method declares no single program or does not know the scene's joints, the format cannot carry its
    program, the file cannot be written or replaced, or solids are asked of a scene in the plane; OutputError
    if a file cannot be written; NoLoadFactorError if "global" has no associative load factor to bound λ with.

    Parameters
    ----------
    scene: A scene, or the path of a case file; of solids also a result, with its motion and forces.
    path: Of the file, by whose end its format is known: ``.lp`` or ``.mps`` (linear programs, and with
        binaries) or ``.nl`` (and with products or complementary pairs). Beside a ``.nl`` the names of its
        rows and columns are written to ``.row`` and ``.col``. Of solids: ``.obj``, ``.glb`` or ``.gltf``
        (with trimesh, of the extra "meshes"), or ``.json`` (COMPAS).
    method: Of programs: "static", eq. (9), the default, "kinematic", eq. (10), "global" (complementarity with
        a binary for each face; its bounds are computed first, by linear programs), "mpec" (with products z p
        ≤ 10⁻⁶), or "mcp" (with complementary pairs).
    force: Whether to replace files that were not written here, which are known by a mark in them.
    moved: Of a result's meshes: how far its mechanism has moved, 0 at rest, 1 as far as pages move it
        (default: as pictures show it).
    """
    if not isinstance(path, str | Path):
        raise OptionError(f"the path of a file is text or a pathlib.Path (found {path!r})")
    path = Path(path)
    if (end := path.suffix.lower()) in SOLID_ENDS:
        if method is not None:
            raise OptionError(f"{path}: 'method' goes with programs: give the result of one for its motion")
        refuse_unwritable(path, force)
        what = scene if isinstance(scene, Result) else as_scene(scene)
        write_file(path, solid_file(what, end, moved), OutputError)
        return (path,)
    if moved is not None:
        raise OptionError(f"{path}: 'moved' goes with meshes: {', '.join(SOLID_ENDS[1:])}")
    method = method or "static"
    if method not in _EXPORTS:
        why = "solves a series of programs" if method in METHODS else "is unknown"
        raise OptionError(f"method '{method}' {why}; those with one program: {', '.join(_EXPORTS)}")
    # Products of variables, and complementary pairs, only .nl files carry.
    ends = (".nl",) if method in ("mpec", "mcp") else tuple(_WRITERS)
    if end not in ends:
        others = f"{end} carries linear programs" if end in _WRITERS else f"solids to {', '.join(SOLID_ENDS)}"
        named = f"is written to a file whose name ends in {', '.join(ends)} ({others})"
        raise OptionError(f"{path}: a program of method '{method}' {named}")
    refuse_unwritable(path, force)
    for beside in (".row", ".col") if end == ".nl" else ():
        refuse_unwritable(path.with_suffix(beside), force)
    assembly = assemble(scene.assembly.scene if isinstance(scene, Result) else as_scene(scene))
    # Where dilatancy falls with stress a method may ask the loop: programs of flow have a constant one.
    known = METHODS[method]
    refuses = known.refuses if known.associative else known.refuses | {"dilatancy"}
    refuse_unsuited(replace(known, refuses=refuses), assembly)
    program, said = _EXPORTS[method](assembly)
    program.name = method
    names = names_in(program, assembly, legal=end != ".nl")
    files = _WRITERS[end](program, names, [*_header(method, assembly), *said])
    paths = {of: path.with_suffix(path.suffix if of == end else of) for of in files}
    write_together({paths[of]: text for of, text in files.items()})
    return tuple(reversed(paths.values()))


def _header(method: str, assembly: Assembly) -> list[str]:
    """What every program says of itself, in ASCII."""
    problem, scene = assembly.problem, assembly.scene
    name = " ".join(f"{Path(scene.origin).name} {scene.title}".split())
    points = f", contact points: {problem.joints}" if problem.layout.round else ""
    friction = by_sides(problem.layout) if len(problem.sliding) else "unlimited"
    lines = [
        f"{MARK}: program of method {method} for {name}",
        f"movable blocks: {problem.blocks}, joints: {len(assembly.joints.first)}{points}",
        *([f"friction: {friction}"] if points else []),
        f"units: forces {problem.force_unit!r}, lengths {problem.length_unit!r} of the case's; the load "
        "factor is the same in both",
    ]
    return [line.encode("ascii", "replace").decode() for line in lines]
