"""Scraper of Sphinx-Gallery that shows every matplotlib Figure and every Altair chart of an example.

The picture may be a variable or the last expression of a block. Sphinx-Gallery without this scraper collects
only figures of pyplot, which this package does not use.
"""

from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

from masonry_opt.drawing.figure import Picture
from masonry_opt.studies.charts import alt, specification, vl_convert

#: Pictures that were already shown, so that a later block of the same example does not show them again.
#: Altair charts have no hash, so pictures are compared by identity.
_shown: list[Any] = []


def scraper(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the new pictures among an example's variables, and return the reStructuredText that shows them.

    Each picture fills the width of the page, because two pictures side by side are too small to read.
    """
    shown = []
    for value in list(block_vars["example_globals"].values()):
        is_picture = isinstance(value, Figure | alt.TopLevelMixin)
        if is_picture and not any(value is earlier for earlier in _shown):
            _shown.append(value)
            path = next(block_vars["image_path_iterator"])
            _save(value, path)
            shown.append(figure_rst([path], gallery_conf["src_dir"], fig_titles=_title(value)))
    return "\n".join(shown)


def _title(picture: Any) -> str:
    """Return the title of a picture on one line, as its text for readers who do not see it."""
    if isinstance(picture, Figure):
        title = picture.axes[0].get_title() if picture.axes else ""
    else:
        written = getattr(picture.title, "text", picture.title)
        title = "" if written is alt.Undefined else str(written)
    return title.replace("\n", ": ")


def _save(picture: Any, path: str) -> None:
    """Write a picture to a PNG file."""
    if isinstance(picture, Picture):
        picture.save(path, force=True)
    elif isinstance(picture, Figure):
        picture.savefig(path, dpi=160, bbox_inches="tight")
    else:
        Path(path).write_bytes(vl_convert.vegalite_to_png(specification(picture), scale=2))
