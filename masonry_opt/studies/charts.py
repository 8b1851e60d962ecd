"""Charts of studies, made with Altair: PNG and SVG files for paper, interactive charts for pages."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from textwrap import wrap
from typing import Any

import matplotlib

from masonry_opt.errors import OptionError
from masonry_opt.files import image_source
from masonry_opt.studies.writing import MISSING_LIBRARY_MESSAGE, render

try:
    import altair as alt
    import vl_convert
except ImportError:
    raise OptionError(MISSING_LIBRARY_MESSAGE) from None

# Other modules import Altair from this module, because the import here raises an OptionError if Altair is
# missing.
__all__ = ["NamedChart", "alt", "axis", "chart_contents", "legend", "pictures", "script"]

_WIDTH = 620  #: Width of a chart in PNG and SVG files, in pixels.
_PANEL = 230  #: Width and height of a panel in PNG and SVG files, in pixels.
_MOST_PANELS_IN_ROW = 4  #: Largest number of panels in a row.
#: Largest number of panels in a PNG or SVG file. If a chart has more panels, the rest is omitted, and the
#: notes state the total number of panels.
_PANELS = 24
_ENTRY = 300  #: Assumed width of a legend entry, in pixels. It determines the number of legend columns.
_LETTER = 6  #: Mean width of a letter in pixels, for breaking the notes of a chart into lines.
_FONT = "DejaVu Sans"  #: Font that comes with Matplotlib, so that charts look the same on all computers.
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
    """Altair chart with the name of its files, a title and notes."""

    name: str  #: name of the files, without ending
    title: str
    chart: Any  #: chart of Altair
    notes: str = ""
    #: Name of a data column whose values divide the chart into panels. PNG and SVG files show the panels side
    #: by side; an HTML page shows one panel at a time.
    panels: str = ""

    def on_paper(self) -> Any:
        """Return the Altair chart with its title and notes, as it is drawn in PNG and SVG files."""
        chart, width, notes = self.chart, _WIDTH, self.notes
        if self.panels:
            values = self._panels()
            chart = chart.transform_filter(alt.FieldOneOfPredicate(self.panels, values[:_PANELS]))
            columns = min(_MOST_PANELS_IN_ROW, len(values))
            width = columns * _PANEL
            chart = chart.properties(width=_PANEL, height=_PANEL).facet(f"{self.panels}:N", columns=columns)
            if len(values) > _PANELS:
                notes += f"; the first {_PANELS} of {len(values)}"
        else:
            chart = chart.properties(width=width)
        chart = chart.properties(title=alt.Title(self.title, subtitle=wrap(notes, width // _LETTER)))
        return _configured(chart, max(1, width // _ENTRY))

    def on_page(self) -> dict[str, Any]:
        """Return the Vega-Lite specification of the chart without title, as wide as an HTML page."""
        chart = self.chart.properties(width="container", autosize={"type": "fit-x", "contains": "padding"})
        if self.panels:
            values = self._panels()
            select = alt.binding_select(options=values, name=f"{self.panels} ")
            chosen = alt.param("panel", value=values[0], bind=select)
            chart = chart.add_params(chosen).transform_filter(f"datum[{self.panels!r}] === panel")
        return specification(_configured(chart, alt.expr(f"max(1, floor(containerSize()[0] / {_ENTRY}))")))

    def source(self) -> str:
        """Return the chart as a data URL, for an image in an HTML page."""
        return image_source(vl_convert.vegalite_to_svg(specification(self.on_paper())), "svg")

    def _panels(self) -> list[str]:
        """Return the distinct values of the column ``panels``, in the order of the rows."""
        return [*dict.fromkeys(self.chart.data[self.panels])]


def _configured(chart: Any, columns: Any) -> Any:
    """Return a chart in the style of the package, with a legend in the given number of columns."""
    return chart.configure(**_CONFIG, legend=alt.LegendConfig(**_LEGEND, columns=columns))


def axis(title: str, least: float, greatest: float) -> dict[str, Any]:
    """Return a linear scale and an axis with a title, as keyword arguments for ``alt.X(...)``."""
    scale = alt.Scale(domain=(least, greatest), nice=False, zero=False)
    return {"scale": scale, "axis": alt.Axis(title=title)}


def legend(entries: object) -> dict[str, Any]:
    """Return keyword arguments that hide the legend of a chart channel if the legend has no entries."""
    return {} if entries else {"legend": None}


def specification(chart: Any) -> dict[str, Any]:
    """Return the Vega-Lite specification of an Altair chart, without Altair's limit on the number of rows."""
    with alt.data_transformers.enable("default", max_rows=None):
        return chart.to_dict()


def pictures(drawings: Iterable[NamedChart]) -> dict[str, str | bytes]:
    """Return the PNG and SVG files of charts by file name. Equal charts produce identical bytes."""
    files: dict[str, str | bytes] = {}
    for drawing in drawings:
        described = specification(drawing.on_paper())
        files[f"{drawing.name}.png"] = vl_convert.vegalite_to_png(described, scale=2)
        files[f"{drawing.name}.svg"] = vl_convert.vegalite_to_svg(described)
    return files


@cache
def script() -> str:
    """Return the JavaScript code of Vega, Vega-Lite and Vega-Embed, which draws charts in an HTML page."""
    return vl_convert.javascript_bundle()  # type: ignore[call-arg]  # the stub requires an optional argument


def chart_contents(title: str, drawings: Sequence[NamedChart]) -> dict[str, str | bytes]:
    """Return the files of charts by file name: a PNG and an SVG file for each chart, and one HTML page.

    The page contains all charts and works offline.
    """
    page = render("charts.html", title=title, charts=drawings, script=script())
    return pictures(drawings) | {"charts.html": page}
