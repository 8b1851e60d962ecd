"""Syntax trees of the files of the package, each parsed once for all tests."""

import ast
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]


@cache
def parsed(path: Path) -> ast.Module:
    """Return the syntax tree of a file, which several tests read."""
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def classes_and_imports(path: Path) -> list[ast.AST]:
    """Return the statements anywhere in a file that define a class or import something."""
    kinds = (ast.ClassDef, ast.Import, ast.ImportFrom)
    return [node for node in ast.walk(parsed(path)) if isinstance(node, kinds)]


def imports_of(path: Path, within: Callable[[ast.Module], Iterable[ast.AST]] | None = None) -> Iterator[str]:
    """Yield the full names of the modules that a file imports, anywhere or among certain nodes."""
    for node in within(parsed(path)) if within else classes_and_imports(path):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: a relative import"
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
