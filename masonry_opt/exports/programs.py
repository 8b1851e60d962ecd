"""Optimisation programs of the methods as files for other solvers.

The files are written by Pyomo: linear programs as LP or MPS, all programs as AMPL NL.
"""

import io
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pyomo.environ as pyo
from pyomo.opt import WriterFactory
from pyomo.repn.plugins.lp_writer import LPWriter
from pyomo.repn.plugins.nl_writer import NLWriter

from masonry_opt.analysis import solve
from masonry_opt.effort import Effort
from masonry_opt.errors import NoLoadFactorError, OptionError
from masonry_opt.exports.header import comments, header
from masonry_opt.exports.solid_files import SOLID_ENDS
from masonry_opt.files import refuse_unwritable
from masonry_opt.methods.bounds.products import a_little_above
from masonry_opt.methods.bracket.relaxation import assumed_rates, bounds_of
from masonry_opt.methods.registry import METHODS
from masonry_opt.models.pyomo_kinematic import PyomoKinematic
from masonry_opt.models.pyomo_mcp import PyomoMcp, with_pairs
from masonry_opt.models.pyomo_mpec import PyomoGlobal, PyomoMpec, PyomoRelaxed
from masonry_opt.models.pyomo_static import PyomoStatic
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.problem import Problem, ShearLimits
from masonry_opt.scene.mistakes import instead_of
from masonry_opt.suitability import refuse_unsuited, refuse_without_live_load

#: Upper bound ε on the product of a slack z and a rate p. The constraint z p ≤ ε replaces the
#: complementarity condition z p = 0. ε must be larger than the feasibility tolerance of solvers. With a
#: larger value, the least load factor of the program is lower, and further below the load factor of an exact
#: state.
EPSILON = 1e-6

#: Exported program in Pyomo, and the comment lines at the top of the file to which it is written.
Declared = tuple[pyo.ConcreteModel, list[str]]


def _associative(model: type[PyomoStatic | PyomoKinematic], words: str, assembly: Assembly) -> Declared:
    """Return the static program, eq. (9), or the kinematic program, eq. (10), and its comment lines."""
    problem = assembly.problem
    return model(problem, ShearLimits.true(problem)).program, [_objective(words, problem)]


def _mcp(assembly: Assembly) -> Declared:
    """Return the mixed complementarity problem of a scene, and comment lines for its file."""
    model = PyomoMcp(assembly.problem)
    with_pairs(model)
    return model.program, ["no objective, because every collapse state is a solution"]


def _mpec(assembly: Assembly) -> Declared:
    """Return the MPEC, with complementarity relaxed to z p ≤ ε, and comment lines for its file."""
    model = PyomoRelaxed(PyomoMpec(assembly.problem))
    model.epsilon.set_value(EPSILON)
    comment = f"complementarity is relaxed: each product of slack and rate is at most {EPSILON:g}"
    return model.program, [_objective("load_factor", assembly.problem), comment]


def _global(assembly: Assembly) -> Declared:
    """Return the mixed-integer program of the least load factor, and comment lines for its file.

    The program has a binary variable for each yield condition. The bounds on its forces and rates are
    computed first. Raises NoLoadFactorError if the associative load factor is negative.
    """
    problem = assembly.problem
    static = solve(assembly.scene, "static")
    associative = static.required()
    if associative < 0:
        raise NoLoadFactorError(
            f"{assembly.scene.origin}: the program of method 'global' needs a load factor ≥ 0, but no load "
            f"factor is above {associative:g}: reverse the live load",
            static.warning_sentences,
        )
    highest = a_little_above(associative)
    known = solve(assembly.scene).solution.d
    bounds = bounds_of(problem, highest, assumed_rates(problem, known), Effort())
    rates = "this limit follows from kinematics" if bounds.rates_derived else "this limit is assumed"
    forces = (
        "all limits follow from statics"
        if bounds.forces_derived
        else "every limit that could not be derived from statics is assumed"
    )
    # If a joint rocks with rate p, one of its edges opens by 2 p. The limit on the rate is therefore half the
    # limit on edge openings.
    most_rates = np.full(problem.faces, bounds.rates)
    most_rates[problem.table.rocks] /= 2
    # The slack of a rocking condition is at most twice the largest normal force n.
    most_slack = 2 * bounds.normal[problem.face_joint]
    # The slack of a sliding condition is at most twice the shear limit c + μ n at the largest n.
    limits = ShearLimits.true(problem).at(bounds.normal[problem.sliding])
    most_slack[problem.table.slides] = 2 * np.tile(limits, 2)
    model = PyomoGlobal(problem, most_slack, most_rates, highest)
    return model.program, [
        _objective("load_factor", problem),
        f"load_factor is between 0 and {highest:.9g}, slightly above the associative load factor",
        f"the sum of all slips and edge openings is at most {bounds.rates:.9g}; {rates}",
        f"limits on the forces: {forces}",
    ]


def _objective(words: str, problem: Problem) -> str:
    """Return the comment line that states the objective and the factor by which it is multiplied."""
    by_size = problem.layout.round
    terms = "the magnitudes of live forces and moments" if by_size else "all absolute live load components"
    return f"the objective is {words} times {problem.live_norm!r}; this number is the sum of {terms}"


#: Map from the name of a method to the function that declares its program.
_EXPORTS: dict[str, Callable[[Assembly], Declared]] = {
    "static": partial(_associative, PyomoStatic, "-load_factor"),
    "kinematic": partial(
        _associative,
        PyomoKinematic,
        "the dissipated energy minus the work of the dead load, both divided by the work of the live load "
        "(the minimum is the load factor),",
    ),
    "global": _global,
    "mpec": _mpec,
    "mcp": _mcp,
}

#: Pyomo divides each complementarity condition into variables and constraints. The keys are their names in
#: Pyomo. The values are the first parts of their names in the exported file:
#:
#: - "z": slack variable,
#: - "slack": constraint that defines z,
#: - "product": constraint z p ≤ ε,
#: - "pair": constraint that z is complementary to p.
_PAIR_NAMES = {"v": "z", "bv": "z", "ve": "slack", "bc": "slack", "ccon": "product", "c": "pair"}
#: Components of a program that have one variable or row for each yield condition. The values are the first
#: parts of the names of these variables and rows in the exported file. The name of the yield condition
#: follows.
_OF_FACES = {"p": "p", "y": "y", "within_yield": "yield", "at_rest": "at_rest", "at_yield": "at_yield"}
#: Names of the components of a program that consist of a single variable or row.
_SINGLE_COMPONENTS = ("load_factor", "live_work", "raising", "objective")


def names_in(program: pyo.ConcreteModel, assembly: Assembly, legal: bool) -> dict[int, str]:
    """Return a dictionary from the ``id`` of each variable, row and objective to its unique name."""
    names = assembly.problem_names(legal)
    faces = names.conditions
    by_component: dict[str, list[str]] = {name: [name] for name in _SINGLE_COMPONENTS}
    by_component |= {"q": names.forces, "compatibility": names.motions}
    by_component |= {"d": names.velocities, "equilibrium": names.balances}
    by_component |= {name: [f"{kind}_{face}" for face in faces] for name, kind in _OF_FACES.items()}
    named: list[tuple[object, str]] = []
    kinds_declared = (pyo.Var, pyo.Constraint, pyo.Objective)
    for declared in program.component_objects(kinds_declared, descend_into=False):
        named += zip(declared.values(), by_component[declared.local_name], strict=True)
    pairs = program.component("complementarity")
    if pairs is not None:
        for part, kind in _PAIR_NAMES.items():
            parts = (pair.component(part) for pair in pairs.values())
            named += zip(parts, (f"{kind}_{face}" for face in faces), strict=True)
    return {id(data): name for data, name in named if data is not None}


def _lp(program: pyo.ConcreteModel, names: dict[int, str], lines: list[str]) -> dict[str, str]:
    """Return the program as the text of an LP file (CPLEX format), in a dictionary with key ".lp"."""
    text = io.StringIO()
    # Pyomo adds a variable with coefficient 0 to empty rows, so the labeller must accept a variable that has
    # no entry in ``names``.
    LPWriter().write(program, text, labeler=lambda data: names.get(id(data), str(data)))
    return {".lp": comments("\\", lines) + text.getvalue()}


def _mps(program: pyo.ConcreteModel, names: dict[int, str], lines: list[str]) -> dict[str, str]:
    """Return the program as the text of a file in free MPS format, in a dictionary with key ".mps"."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "program.mps"
        labelled = {"labeler": lambda data: names[id(data)]}
        WriterFactory("mps")(program, str(path), lambda _: True, labelled)
        return {".mps": comments("*", lines) + path.read_text(encoding="utf-8")}


def _nl(program: pyo.ConcreteModel, names: dict[int, str], lines: list[str]) -> dict[str, str]:
    """Return the texts of an AMPL NL file and of its two lists of names, keyed by the file endings."""
    # In an NL file only the first line can contain a comment. Pyomo writes the name of the program to this
    # line, so the comment lines are stored as the name.
    program.name = "; ".join(lines)
    text = io.StringIO()
    written = NLWriter().write(program, text, linear_presolve=False, scale_model=False)

    def listed_names(*kinds: list[object]) -> Iterator[str]:
        return (f"{names[id(data)]}\n" for kind in kinds for data in kind)

    rows = "".join(listed_names(written.constraints, written.objectives))
    # The files are written in this order. The .nl file is last, so its two lists of names always exist when
    # it appears.
    return {".row": rows, ".col": "".join(listed_names(written.variables)), ".nl": text.getvalue()}


#: Map from the ending of a program's main file to the function that returns the texts of all its files.
_WRITERS = {".lp": _lp, ".mps": _mps, ".nl": _nl}


def program_texts(assembly: Assembly, method: str, ending: str) -> dict[str, str]:
    """Return the text of each file of a method's program, in a dict by the ending of the file, such as ".lp".

    Raises OptionError if the method does not support the joints of the scene. Raises CaseError if no block
    that can move has a live load, and NoLoadFactorError as :func:`_global` does.
    """
    entry = METHODS["coulomb" if method == "mcp" else method]
    # If dilatancy depends on stress, a Coulomb method solves several programs, but only one can be exported.
    refuses = entry.refuses if entry.associative else entry.refuses | {"dilatancy"}
    refuse_unsuited(replace(entry, name=method, refuses=refuses), assembly)
    refuse_without_live_load(assembly)
    program, declared = _EXPORTS[method](assembly)
    program.name = method
    names = names_in(program, assembly, legal=ending != ".nl")
    return _WRITERS[ending](program, names, [*header(f"program of method {method}", assembly), *declared])


def refuse_program(path: Path, method: str, force: bool) -> None:
    """Raise OptionError if the program of a method cannot be exported to a file.

    This is the case if the method is unknown or solves several programs, if the file format cannot represent
    the program, or if a file must not be replaced.
    """
    ending = path.suffix.lower()
    if method not in _EXPORTS:
        if method not in METHODS:
            raise OptionError(f"method '{method}' is unknown{instead_of(method, _EXPORTS)}")
        raise OptionError(
            f"method '{method}' solves a series of programs, which cannot be written to one file: choose one "
            f"of {', '.join(_EXPORTS)}"
        )
    # Only the .nl format can represent products of variables (mpec) and complementary pairs (mcp).
    endings = (".nl",) if method in ("mpec", "mcp") else tuple(_WRITERS)
    if ending not in endings:
        note = f"files of solids end in {', '.join(SOLID_ENDS)}"
        if ending in _WRITERS:
            note = f"a {ending} file can contain only linear programs, with or without binary variables"
        raise OptionError(
            f"{path}: the file name for the program of method '{method}' must end in {', '.join(endings)} "
            f"({note})"
        )
    refuse_unwritable(path, force)
    if ending == ".nl":
        for names in (".row", ".col"):
            refuse_unwritable(path.with_suffix(names), force)
