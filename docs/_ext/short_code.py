"""Sphinx extension that marks inline code of short words, which the style sheet does not break into lines.

Browsers break lines after each hyphen, so that ``--plot`` could become two lines. Long words and paths must
be broken, because they do not fit on a phone.
"""

from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

_LONGEST = 24  #: Number of letters up to which a word of code is kept on one line.


def mark(app: Sphinx, doctree: nodes.document, name: str = "") -> None:
    """Add the class "short" to inline code whose words are all short and contain no slash."""
    for code in doctree.findall(nodes.literal):
        if all(len(word) <= _LONGEST and "/" not in word for word in code.astext().split()):
            code["classes"].append("short")


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the extension to Sphinx."""
    app.connect("doctree-resolved", mark)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
