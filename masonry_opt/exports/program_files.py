"""Declared programs as the text of files that other solvers read, through Pyomo's writers."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pyomo.environ as pyo
from pyomo.opt import WriterFactory
from pyomo.repn.plugins.lp_writer import LPWriter
from pyomo.repn.plugins.nl_writer import NLWriter

#: The files of a program, by the ends of their names.
Files = dict[str, str]


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
