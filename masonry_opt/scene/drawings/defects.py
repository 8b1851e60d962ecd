"""Collect the defects of a drawing, so that one error names all of them, sorted by kind."""

from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

from masonry_opt.errors import shortened
from masonry_opt.scene.drawings.stones import refuse
from masonry_opt.scene.tolerance_advice import above_gap

#: Part of a remedy that is replaced by a length slightly above the widest gap of all defects of one kind.
WIDEST_GAP = "{widest gap}"

#: A gap of an open outline is probably an error of the drawing if it is at most this fraction of the
#: outline's length. An error message then advises a larger `outline_tolerance`, which closes the gap. If the
#: gap is wider, the message advises drawing the missing side. With a larger value, messages would advise
#: tolerances that are as large as stones.
WIDEST_ERROR = 0.05

#: Largest number of places that a message lists for one kind of defect; further places are only counted.
_MOST_PLACES = 10


class Defect(NamedTuple):
    """Entity of a drawing that cannot be read as a part of a block."""

    label: str  #: kind, handle and layer of the entity
    mistake: str  #: predicate of the message about a single defect, such as "is open"
    #: subject and predicate of the message about several defects of one kind, such as "outlines are open"
    plural_mistake: str
    remedy: str
    place: str = ""  #: position of the entity, such as " near (1, 2)"
    gap: float = 0.0  #: width of the gap that the remedy closes; 0 if there is none


class Defects:
    """Defects that are found while a drawing is read."""

    def __init__(self) -> None:
        self._defects: list[Defect] = []

    def add(self, defect: Defect) -> None:
        """Add a defect without raising an error, so that further defects can be found."""
        self._defects.append(defect)

    def refuse(self) -> None:
        """Raise ValueError if there are defects. The message has one line for each kind of defect."""
        of_kind: defaultdict[tuple[str, str], list[Defect]] = defaultdict(list)
        for defect in self._defects:
            of_kind[defect.plural_mistake, defect.remedy].append(defect)
        refuse([_line(defects) for defects in of_kind.values()])


def _line(defects: Sequence[Defect]) -> str:
    """Return the message about defects of one kind."""
    first = defects[0]
    remedy = first.remedy
    if WIDEST_GAP in remedy:
        remedy = remedy.replace(WIDEST_GAP, above_gap(max(defect.gap for defect in defects)))
    if len(defects) == 1:
        return f"{first.label} {first.mistake}{first.place}: {remedy}"
    places = shortened([f"{defect.label}{defect.place}" for defect in defects], _MOST_PLACES)
    return f"{len(defects)} {first.plural_mistake} ({'; '.join(places)}): {remedy}"


def near(x: float, y: float) -> str:
    """Return a position in a drawing as the end of a message, such as ``near (1, 2)``."""
    # Adding 0.0 turns -0.0 into 0.0.
    return f" near ({x + 0.0:g}, {y + 0.0:g})"
