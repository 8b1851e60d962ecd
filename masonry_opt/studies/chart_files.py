"""A chart as the files of it."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

from masonry_opt.report.pictures.figure import style


def chart_files(figure: Figure, name: str) -> dict[str, bytes]:
    """Contents by file names, ``name`` with .png and .svg: the same from run to run, to the last byte."""
    files = {}
    for kind in ("png", "svg"):
        stream = io.BytesIO()
        with style():
            figure.savefig(stream, format=kind, dpi=150, metadata={"Date": None} if kind == "svg" else None)
        figure.set_layout_engine("none")  # laid out: the next kind looks the same
        files[f"{name}.{kind}"] = stream.getvalue()
    return files
