"""The shape of the package: how much each room holds, and that no two files need each other."""

import ast
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

ROOT = Path(__file__).parents[2]

#: Lines of Python that a room may hold. Whoever raises one writes the reason beside it.
BUDGETS = {
    "scene": 7153,  # what help and a prompt show of records; nets of joint lines
    "problem": 1881,  # layouts of the plane and of space, and laws, as objects; zones of a fill
    "solvers": 792,  # what is kept of programs, which problem held
    "methods": 4076,  # keyframes; states beside a stop; growth, and sharp contacts after it; the loop at last
    "standing": 573,
    "answer": 1562,
    "words": 982,  # equal load factors said once; why none is lower
    "drawing": 2006,  # the way of a push on pages, and what notebooks show
    "finite_motion": 1266,  # in space a body that turns about an edge; pictures loaded when asked
    "exports": 491,
    "studies": 5436,  # the report for the file; crossings in all load cases, openings
    "cli": 1119,  # commands of functions' signatures; reports; the paper's examples
    "rest": 952,  # plain data of files, which answer held; rest as proof that a scene stands
    "models": 1049,  # the energy of chords, said whole
    "tests": 25871,  # every claim once, each held by a few scenes
}


def room_of(path: Path) -> str:
    """The room that a file is in; what lies beside the rooms is the rest."""
    first, *others = path.relative_to(ROOT).parts
    return first if first != "masonry_opt" else others[0] if len(others) > 1 else "rest"


def files() -> list[Path]:
    return [path for top in ("masonry_opt", "models", "tests") for path in sorted((ROOT / top).rglob("*.py"))]


@pytest.mark.parametrize("room", BUDGETS)
def test_a_room_holds_no_more_lines_than_its_budget(room):
    lines = sum(path.read_bytes().count(b"\n") for path in files() if room_of(path) == room)
    assert 0 < lines <= BUDGETS[room]


def test_every_file_is_in_a_room():
    assert {room_of(path) for path in files()} == set(BUDGETS)


def test_no_two_files_import_each_other():
    """Neither at once nor by way of others, at the top or where first needed."""
    modules = {module_of(path): path for path in files() if room_of(path) != "tests"}
    number = {name: index for index, name in enumerate(modules)}
    known = {name: set(imports_of(path)) & modules.keys() for name, path in modules.items()}
    arrows = np.array([(number[name], number[to]) for name in modules for to in known[name]]).T
    graph = sp.coo_array((np.ones(len(arrows[0])), tuple(arrows)), shape=2 * (len(number),))
    count, circle = connected_components(graph, connection="strong")
    together = [[name for name in modules if circle[number[name]] == one] for one in range(count)]
    assert [names for names in together if len(names) > 1] == []


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    parts = ("masonry_opt", *parts) if parts[0] == "models" else parts
    return ".".join(part for part in parts if part != "__init__")


def imports_of(path: Path, within: Callable[[ast.Module], Iterable[ast.AST]] = ast.walk) -> Iterator[str]:
    """Full names of the modules that a file imports: wherever in it, or among certain nodes."""
    for node in within(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: a relative import"
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
