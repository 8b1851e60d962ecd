"""Scraper of Sphinx-Gallery that shows every matplotlib Figure of an example.

The figure may be a variable or the last expression of a block. Sphinx-Gallery without this scraper collects
only figures of pyplot, which this package does not use.
"""

import weakref
from typing import Any

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

from masonry_opt.drawing.figure import Picture

#: Figures that were already shown, so that a later block of the same example does not show them again.
_shown: weakref.WeakSet[Figure] = weakref.WeakSet()


def scraper(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the new figures among an example's variables, and return the reStructuredText that shows them."""
    paths = []
    for value in list(block_vars["example_globals"].values()):
        if isinstance(value, Figure) and value not in _shown:
            _shown.add(value)
            paths.append(next(block_vars["image_path_iterator"]))
            if isinstance(value, Picture):
                value.save(paths[-1], force=True)
            else:
                value.savefig(paths[-1], dpi=160, bbox_inches="tight")
    return figure_rst(paths, gallery_conf["src_dir"])
