"""The architecture of the package: no circles of imports, and no file of many purposes."""

import ast
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

ROOT = Path(__file__).parents[2]


#: Lines of the longest file: what is longer has more than one reason to change.
MOST_LINES = 500


def files() -> list[Path]:
    return [path for top in ("masonry_opt", "models") for path in sorted((ROOT / top).rglob("*.py"))]


def test_no_file_is_longer_than_one_reason_to_change():
    longer = {
        path.name: lines for path in files() if (lines := len(path.read_text().splitlines())) > MOST_LINES
    }
    assert longer == {}


def test_no_two_files_import_each_other():
    """Neither at once nor by way of others, at the top or where first needed."""
    modules = {module_of(path): path for path in files()}
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
