"""List every sentence that the program can print, so that all can be read in one sitting.

``python tests/report/printed_sentences.py`` writes the list anew to ``printed_sentences.txt``. The difference
between two versions of that file shows a reviewer each sentence that changed.
"""

import ast
from collections.abc import Callable, Iterator
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "masonry_opt"
LISTED = Path(__file__).with_suffix(".txt")

#: Strings of fewer words are keys, labels and units rather than sentences.
FEWEST_WORDS = 4


def parse(path: Path) -> ast.Module:
    """Return the syntax tree of a file."""
    return ast.parse(path.read_text("utf-8"))


def printed_sentences(tree_of: Callable[[Path], ast.Module] = parse) -> str:
    """Return the sentences of all files of the package, each below the name of its file."""
    parts = []
    for path in sorted(PACKAGE.rglob("*.py")):
        sentences = list(_sentences(tree_of(path)))
        if sentences:
            parts.append("\n".join([f"# {path.relative_to(PACKAGE)}", *sentences, ""]))
    return "\n".join(parts)


def _sentences(tree: ast.Module) -> Iterator[str]:
    """Yield the strings of several words in a file, in the order of its lines, without docstrings."""
    for node in _outermost_strings(tree):
        text = " ".join(_text(node).split())
        if len(text.split()) >= FEWEST_WORDS and not text.startswith("<"):
            yield text


def _outermost_strings(node: ast.AST) -> Iterator[ast.Constant | ast.JoinedStr]:
    """Yield the strings below a node that are neither docstrings nor parts of another string."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant):
            continue  # The expression is a docstring.
        is_text = isinstance(child, ast.Constant) and isinstance(child.value, str)
        if is_text or isinstance(child, ast.JoinedStr):
            yield child
            continue
        yield from _outermost_strings(child)


def _text(node: ast.Constant | ast.JoinedStr) -> str:
    """Return a string, with the expressions of an f-string in braces."""
    if isinstance(node, ast.Constant):
        return node.value
    parts = (
        part.value if isinstance(part, ast.Constant) else f"{{{ast.unparse(part.value)}}}"
        for part in node.values
    )
    return "".join(parts)


if __name__ == "__main__":
    LISTED.write_text(printed_sentences(), "utf-8")
