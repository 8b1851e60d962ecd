"""Sphinx extension that controls where browsers break lines of code.

Browsers break lines after each hyphen, so that ``--plot`` could become two lines. The style sheet does not
break inline code of short words. Long words and paths must be broken, because they do not fit on a phone. The
names of modules in signatures may be broken after each dot.
"""

from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

_LONGEST = 36  #: Number of letters up to which a word of code is kept on one line, which a phone can show.
_LONGEST_IN_TABLE = 20  #: Number of letters in a table, whose columns are narrow. Paths in tables are broken.


def _in_table(node: nodes.Node) -> bool:
    """Return True if a node is in a table."""
    return node.parent is not None and (isinstance(node.parent, nodes.table) or _in_table(node.parent))


def _fits(word: str, in_table: bool) -> bool:
    """Return True if a word of code is kept on one line."""
    return len(word) <= (_LONGEST_IN_TABLE if in_table else _LONGEST) and not (in_table and "/" in word)


def mark(app: Sphinx, doctree: nodes.document, name: str = "") -> None:
    """Mark inline code whose words are all short, and let names of modules be broken."""
    for code in doctree.findall(nodes.literal):
        if all(_fits(word, _in_table(code)) for word in code.astext().split()):
            code["classes"].append("short")
    for module in [*doctree.findall(addnodes.desc_addname)]:
        parts = module.astext().split(".")
        module.children = [nodes.Text(parts[0])]
        for part in parts[1:]:
            module += nodes.Text(".")
            module += nodes.raw("", "<wbr>", format="html")
            module += nodes.Text(part)


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the extension to Sphinx."""
    app.connect("doctree-resolved", mark)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
