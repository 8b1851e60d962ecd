"""A chart as the files of it."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

from masonry_opt.files import picture_metadata
from masonry_opt.report.pictures.figure import style
from masonry_opt.report.pictures.letters import replace_missing


def chart_files(figure: Figure, name: str) -> dict[str, bytes]:
    """Contents by file names, ``name`` with .png and .svg: the same from run to run, to the last byte."""
    replace_missing(figure)
    files = {}
    for kind in ("png", "svg"):
        stream = io.BytesIO()
        with style():
            figure.savefig(stream, format=kind, dpi=150, metadata=picture_metadata(kind))
        figure.set_layout_engine("none")  # laid out: the next kind looks the same
        files[f"{name}.{kind}"] = stream.getvalue()
    return files
