"""Pictures and page of supports that settle."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import replace

from masonry_opt.drawing.elements import result_elements, title_of
from masonry_opt.drawing.figure import Picture
from masonry_opt.drawing.pictures import elements_picture
from masonry_opt.drawing.view import ViewAngles, refuse_view
from masonry_opt.errors import OptionError, printable
from masonry_opt.result import Result
from masonry_opt.studies.settle.settlement import Reactions
from masonry_opt.studies.writing import render
from masonry_opt.words.names import some
from masonry_opt.words.sentences import numeral

#: What a legend says of the arrows on supports.
_WAY = "way in which the support moves"


def picture(
    settlement: Reactions,
    end: str,
    kind: str | None = None,
    names: bool = False,
    view: ViewAngles | None = None,
) -> Picture:
    """What moves at one end; see :meth:`Settlement.plot`."""
    if end not in ("least", "greatest"):
        raise OptionError(f"there is no end '{end}': choose from least, greatest")
    if settlement.fallen:
        return _drawn(settlement.fallen, "no reaction holds it: how it falls", names, view)
    bound = settlement.ends[end]
    kind = kind or next(iter(bound.results))
    if kind not in bound.results:
        raise OptionError(f"there is no answer of kind '{kind}': choose from {', '.join(bound.results)}")
    row = next(row for row in bound.rows() if row["kind"] == kind)
    said = f"none ({row['status']})" if row["reaction"] is None else numeral(row["reaction"], ".6g")
    of = printable(some([repr(name) for name in settlement.supports]))
    return _drawn(bound.results[kind], f"{end} reaction of {of}: {said} ({kind})", names, view)


def _drawn(result: Result, heading: str, names: bool, view: ViewAngles | None) -> Picture:
    refuse_view(result.assembly.scene, view)
    elements = result_elements(result)
    loads = [replace(each, label=_WAY) if each.name == "live" else each for each in elements.loads]
    return elements_picture(replace(elements, heading=heading, loads=loads), "mechanism", names, view)


def page(settlement: Reactions, view: ViewAngles | None = None) -> str:
    """Both ends with their pictures, and the table, as HTML that stands by itself.

    Raises OptionError if Jinja2, of the extra "studies", is not installed.
    """
    ends = list(settlement.ends) or ["least"]
    drawn = {end: b64encode(picture(settlement, end, view=view).image("svg")).decode() for end in ends}
    rows = [
        (
            row["end"],
            row["kind"],
            "" if row["reaction"] != row["reaction"] else numeral(row["reaction"], ".6g"),
            row["status"],
            printable(some(row["moves"])),
        )
        for row in settlement.table.to_dict("records")
    ]
    title = title_of((settlement.fallen or next(iter(settlement.ends.values())).result).assembly.scene)
    return render("settlement.html", title=title, facts=settlement.facts(), pictures=drawn, rows=rows)
