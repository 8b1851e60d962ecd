"""Charts of studies, in Altair: as PNG and SVG for paper, as a script for pages."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import Any

import matplotlib

from masonry_opt.errors import OptionError
from masonry_opt.files import image_source
from masonry_opt.studies.writing import NEEDED, render

try:
    import altair as alt
    import vl_convert
except ImportError:
    raise OptionError(NEEDED) from None

# Altair is imported from here: one place says that it is missing.
__all__ = ["NamedChart", "alt", "axis", "chart_contents", "legend", "pictures", "script"]

#: On paper: width of a chart and of a panel in pixels; most panels side by side, and in all.
_WIDTH, _PANEL, _COLUMNS, _PANELS = 620, 230, 4, 24
_ENTRY = 300  #: Width of a legend's entry in pixels; there are as many columns as fit.
_LETTER = 6  #: Width of a letter of the notes in pixels.
_FONT = "DejaVu Sans"  #: From Matplotlib, with superscripts: pictures are the same on every machine.
vl_convert.register_font_directory(str(Path(matplotlib.get_data_path(), "fonts", "ttf")))

_CONFIG: dict[str, Any] = {
    "font": f"{_FONT}, Verdana, sans-serif",
    "axis": {"gridColor": "#E4E4E4", "labelFontSize": 11, "titleFontSize": 12, "titleFontWeight": "normal"},
    "axisX": {"labelOverlap": "greedy", "labelSeparation": 8, "labelFlush": False, "tickCount": 8},
    "view": {"stroke": "#BBBBBB"},
    "title": {"anchor": "start", "fontSize": 14, "subtitleFontSize": 11, "subtitleColor": "#555555"},
    "header": {"labelFontSize": 11, "title": None},
}
_LEGEND = {"orient": "bottom", "title": None, "labelLimit": 0, "symbolSize": 80, "symbolStrokeWidth": 1.5}


@dataclass(frozen=True)
class NamedChart:
    """A chart, the name of its files, its title and notes. ``panels``: a column with a panel for each of its
    values: side by side on paper, one at a time on a page."""

    name: str
    title: str
    chart: Any
    notes: str = ""
    panels: str = ""

    def on_paper(self) -> Any:
        """The chart in Altair, with title and notes."""
        chart, width, notes = self.chart, _WIDTH, self.notes
        if self.panels:
            named = self._panels()
            chart = chart.transform_filter(alt.FieldOneOfPredicate(self.panels, named[:_PANELS]))
            columns = min(_COLUMNS, len(named))
            width = columns * _PANEL
            chart = chart.properties(width=_PANEL, height=_PANEL).facet(f"{self.panels}:N", columns=columns)
            if len(named) > _PANELS:
                notes += f"; the first {_PANELS} of {len(named)}"
        else:
            chart = chart.properties(width=width)
        chart = chart.properties(title=alt.Title(self.title, subtitle=wrap(notes, width // _LETTER)))
        return _dressed(chart, max(1, width // _ENTRY))

    def on_page(self) -> dict[str, Any]:
        """The chart for Vega-Lite, as wide as its container, without title and notes."""
        chart = self.chart.properties(width="container", autosize={"type": "fit-x", "contains": "padding"})
        if self.panels:
            named = self._panels()
            select = alt.binding_select(options=named, name=f"{self.panels} ")
            chosen = alt.param("panel", value=named[0], bind=select)
            chart = chart.add_params(chosen).transform_filter(f"datum[{self.panels!r}] === panel")
        return specification(_dressed(chart, alt.expr(f"max(1, floor(containerSize()[0] / {_ENTRY}))")))

    def source(self) -> str:
        """Its picture as the address of an image in HTML."""
        return image_source(vl_convert.vegalite_to_svg(specification(self.on_paper())), "svg")

    def _panels(self) -> list[str]:
        return [*dict.fromkeys(self.chart.data[self.panels])]


def _dressed(chart: Any, columns: Any) -> Any:
    return chart.configure(**_CONFIG, legend=alt.LegendConfig(**_LEGEND, columns=columns))


def axis(title: str, least: float, greatest: float) -> dict[str, Any]:
    """The scale from least to greatest and the axis of a channel, such as alt.X(..., **axis(...))."""
    scale = alt.Scale(domain=(least, greatest), nice=False, zero=False)
    return {"scale": scale, "axis": alt.Axis(title=title)}


def legend(entries: object) -> dict[str, Any]:
    """The legend of a channel; none where it would have no entries, and no finite size."""
    return {} if entries else {"legend": None}


def specification(chart: Any) -> dict[str, Any]:
    """A chart of Altair for Vega-Lite, with any number of rows."""
    with alt.data_transformers.enable("default", max_rows=None):
        return chart.to_dict()


def pictures(drawings: Iterable[NamedChart]) -> dict[str, str | bytes]:
    """PNG and SVG of charts, by file name; the same to the last byte from run to run."""
    files: dict[str, str | bytes] = {}
    for drawing in drawings:
        described = specification(drawing.on_paper())
        files[f"{drawing.name}.png"] = vl_convert.vegalite_to_png(described, scale=2)
        files[f"{drawing.name}.svg"] = vl_convert.vegalite_to_svg(described)
    return files


def script() -> str:
    """The JavaScript of Vega, Vega-Lite and Vega-Embed, for the inside of a page."""
    return vl_convert.javascript_bundle()  # type: ignore[call-arg]  # it has a default, unlike its stub


def chart_contents(title: str, drawings: Sequence[NamedChart]) -> dict[str, str | bytes]:
    """Return the files of charts by name: PNG and SVG of each, and one page that needs no network."""
    page = render("charts.html", title=title, charts=drawings, script=script())
    return pictures(drawings) | {"charts.html": page}
