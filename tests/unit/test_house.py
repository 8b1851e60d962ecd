"""The architecture of the package: no cycles of imports, no overlong files, and one meaning for each name."""

import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components
from sources import ROOT, classes_and_imports, imports_of, parsed

#: Largest number of lines of a file. A longer file has more than one reason to change.
MOST_LINES = 500


def files() -> list[Path]:
    return [path for top in ("masonry_opt", "models") for path in sorted((ROOT / top).rglob("*.py"))]


def test_no_file_is_longer_than_one_reason_to_change():
    longer = {
        path.name: lines for path in files() if (lines := len(path.read_text().splitlines())) > MOST_LINES
    }
    assert longer == {}


def test_a_constant_has_one_value_in_the_package():
    """A reader who knows a name from one file may expect its meaning in every other file."""
    values: dict[str, set[str]] = defaultdict(set)
    for path in files():
        for name, value in constants_of(path):
            values[name].add(value)
    assert {name: several for name, several in values.items() if len(several) > 1} == {}


def test_no_two_classes_share_a_name():
    paths: dict[str, list[str]] = defaultdict(list)
    for path in files():
        for node in classes_and_imports(path):
            if isinstance(node, ast.ClassDef):
                paths[node.name].append(path.relative_to(ROOT).as_posix())
    assert {name: several for name, several in paths.items() if len(several) > 1} == {}


def test_no_two_files_import_each_other():
    """There are no cycles of imports, neither direct nor indirect, at the top of a file or inside
    functions."""
    modules = {module_of(path): path for path in files()}
    number = {name: index for index, name in enumerate(modules)}
    known = {name: set(imports_of(path)) & modules.keys() for name, path in modules.items()}
    arrows = np.array([(number[name], number[to]) for name in modules for to in known[name]]).T
    graph = sp.coo_array((np.ones(len(arrows[0])), tuple(arrows)), shape=2 * (len(number),))
    count, circle = connected_components(graph, connection="strong")
    together = [[name for name in modules if circle[number[name]] == one] for one in range(count)]
    assert [names for names in together if len(names) > 1] == []


def constants_of(path: Path) -> Iterator[tuple[str, str]]:
    """Yield the names in capital letters that a file assigns at its top level, with the code of their
    values."""
    for node in parsed(path).body:
        if isinstance(node, ast.Assign):
            targets = node.targets
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            targets = [node.target]
        else:
            continue
        names = [target.id for target in targets if isinstance(target, ast.Name)]
        yield from ((name, ast.unparse(node.value)) for name in names if name.isupper())


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    parts = ("masonry_opt", *parts) if parts[0] == "models" else parts
    return ".".join(part for part in parts if part != "__init__")
