"""Command `masonry-opt reproduce`: run the paper's examples, which are scripts of the guide's gallery."""

import ast
import contextlib
import io
import sys
import time
import traceback
from pathlib import Path
from typing import Any

import pandas as pd
import typer
from matplotlib.figure import Figure

from masonry_opt.cli.command import CommandArguments, command
from masonry_opt.drawing.figure import boxes, style
from masonry_opt.errors import NoLoadFactorError, OptionError
from masonry_opt.files import (
    RECORD,
    picture_metadata,
    refuse_outputs,
    refuse_unwritable,
    write_folder,
    writing,
)
from masonry_opt.reporting.terminal import print_text
from masonry_opt.solvers.registry import find_solver
from masonry_opt.studies.writing import csv_text

#: Name of the script that "all" does not include, because it is not in the paper and takes a quarter of an
#: hour.
_NOT_IN_PAPER = "bracket"
_EXAMPLE_HELP = "Name of an example, or all; without a name the command lists the examples."
_OUTPUT_HELP = "Folder for tables (CSV) and pictures (PNG, SVG)."
_TABLE_PREFIX = "table"  #: Prefix of the names of variables that are saved as tables.
_FIGURE = "figure"  #: Prefix of the names of variables that are saved as pictures.
_PACKAGE = Path(__file__).parents[1]  #: Folder of the package.


def scripts() -> dict[str, Path]:
    """Return the scripts of the paper's examples by name, from the package or from the repository."""
    folders = _PACKAGE / "paper", _PACKAGE.parent / "docs" / "gallery" / "paper"
    folder = next((folder for folder in folders if folder.is_dir()), folders[0])
    # Sorting by length first puts fig6 before fig10.
    return {path.stem: path for path in sorted(folder.glob("*.py"), key=lambda path: (len(path.stem), path))}


@command(example=typer.Argument(metavar="EXAMPLE", help=_EXAMPLE_HELP), out=typer.Option(help=_OUTPUT_HELP))
def reproduce(
    _: CommandArguments, example: str = "", out: Path = Path("results"), force: bool = False
) -> bool:
    """Run an example of the paper, and compare its values with the published values.

    Exit code 0: every value is as published; 1: a value differs; 2: wrong example or folder. Each example
    states how close a value must be to the published value. Exit code 2 also means that an extra of the
    package is not installed.
    """
    known = scripts()
    listed = "\n".join(f"{name:10} {_title(path)}" for name, path in known.items())
    if not example:
        print_text(listed)
        return True
    names = [name for name in known if name != _NOT_IN_PAPER] if example == "all" else [example]
    unknown = set(names) - set(known)
    if unknown:
        raise OptionError(
            f"there is no example '{unknown.pop()}' to reproduce; choose 'all', or one of:\n{listed}"
        )
    if "table1" in names:
        find_solver("pyomo", "casadi")  # raises OptionError now if an optional package is missing
    # Create the folder before the computation, so that an unusable folder raises an error at once.
    with writing(out):
        out.mkdir(parents=True, exist_ok=True)
    refuse_unwritable(out / RECORD, force)
    for name in names:
        refuse_outputs(out, _outputs(name, known[name]), force)
    missed = False
    for name in names:
        print(f"{name}: {_title(known[name])} ...", file=sys.stderr, flush=True)
        start = time.perf_counter()
        missed = _run(name, known[name], out, force) or missed
        print(f"{name}: {time.perf_counter() - start:.1f} s, written to {out}", file=sys.stderr, flush=True)
    return not missed


def _title(path: Path) -> str:
    """Return the title of a script, which is the second line of its text."""
    return path.read_text("utf-8").split("\n", 2)[1]


def _outputs(name: str, path: Path) -> list[str]:
    """Return the names of all files to which the tables and figures of a script may be written."""
    nodes = ast.walk(ast.parse(path.read_text("utf-8")))
    variables = [node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)]
    return [file for variable in dict.fromkeys(variables) for file in _files(name, variable)]


def _files(name: str, variable: str) -> list[str]:
    """Return the file names of a table or figure of a script; an empty list for any other variable.

    For example, the variable ``table_x`` of the script fig6 is written to fig6_x.csv.
    """
    if variable.startswith(_TABLE_PREFIX):
        return [f"{name}{variable.removeprefix(_TABLE_PREFIX)}.csv"]
    if variable.startswith(_FIGURE):
        return [f"{name}{variable.removeprefix(_FIGURE)}.{kind}" for kind in ("png", "svg")]
    return []


def _run(name: str, path: Path, out: Path, force: bool) -> bool:
    """Run a script, print its output, and write its tables and figures to files.

    Returns True if a value of the script differs from the published value.
    """
    names: dict[str, Any] = {"__name__": "__main__", "__file__": str(path)}
    output, missed = io.StringIO(), ""
    with contextlib.redirect_stdout(output):
        try:
            # The script checks its values by assertions. With optimize=0, Python executes the assertions even
            # under "python -O".
            exec(compile(path.read_text("utf-8"), str(path), "exec", optimize=0), names)
        except (AssertionError, NoLoadFactorError) as error:
            line = traceback.extract_tb(error.__traceback__)[1].lineno  # line of the script
            missed = (
                f"{name}: a computed value differs from the published value "
                f"({path.name}, line {line}): {error}"
            )
    # Output is written before the next example begins, so that with Ctrl-C only the current example is lost.
    print_text(output.getvalue() + missed)
    write_folder(out, _written(name, names), force)
    return bool(missed)


def _written(name: str, names: dict[str, Any]) -> dict[str, str | bytes]:
    """Return the tables and figures of a script as a map from file names to contents of files."""
    files: dict[str, str | bytes] = {}
    for variable, value in names.items():
        if variable.startswith(_TABLE_PREFIX) and isinstance(value, pd.DataFrame):
            files |= dict.fromkeys(_files(name, variable), csv_text(value))
        elif variable.startswith(_FIGURE) and isinstance(value, Figure):
            files |= zip(_files(name, variable), _pictures(value), strict=True)
    return files


def _pictures(figure: Figure) -> tuple[bytes, bytes]:
    """Return a figure as PNG and as SVG. Repeated calls return identical bytes."""
    png, svg = io.BytesIO(), io.BytesIO()
    with style(), boxes():
        figure.savefig(png, format="png", dpi=150, metadata=picture_metadata("png"))
        figure.set_layout_engine("none")  # the SVG keeps the layout of the PNG
        figure.savefig(svg, format="svg", dpi=150, metadata=picture_metadata("svg"))
    return png.getvalue(), svg.getvalue()
