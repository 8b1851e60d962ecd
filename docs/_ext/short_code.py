"""Sphinx extension that controls where browsers break lines of code.

Browsers break lines after each hyphen, so that ``--plot`` could become two lines. The style sheet does not
break inline code of short words. Long words and paths must be broken, because they do not fit on a phone. The
names of modules in signatures may be broken after each dot.
"""

from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

_LONGEST = 20  #: Number of letters up to which a word of code is kept on one line.


def mark(app: Sphinx, doctree: nodes.document, name: str = "") -> None:
    """Mark inline code whose words are all short and contain no slash, and let names of modules be broken."""
    for code in doctree.findall(nodes.literal):
        if all(len(word) <= _LONGEST and "/" not in word for word in code.astext().split()):
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
