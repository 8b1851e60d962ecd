"""Least or greatest reaction of supports, with the results of all analyses, as a table, text and picture."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import pandas as pd

from masonry_opt.brief import brief
from masonry_opt.drawing.colours import BLACK
from masonry_opt.drawing.elements import result_elements
from masonry_opt.drawing.figure import Picture
from masonry_opt.drawing.marks import Marks
from masonry_opt.drawing.pictures import elements_picture
from masonry_opt.drawing.solids import ViewAngles, refuse_view
from masonry_opt.reporting.load_factors import (
    ASSOCIATIVE,
    INCREMENTAL,
    known_least,
    load_history_ends_lower,
    search_remark,
    state_found,
)
from masonry_opt.reporting.names import some
from masonry_opt.reporting.sentences import numeral
from masonry_opt.result import Result
from masonry_opt.solution.motion import moving_names
from masonry_opt.studies.settle.openings import (
    after_movement,
    has_mechanism,
    joint_openings,
    largest_movement,
    movement_of_supports,
)
from masonry_opt.studies.writing import records

#: Columns of the table of reactions, without its first column "end".
REACTION_COLUMNS = ("kind", "reaction", "status", "certainty", "moves")
#: Printed names of the kinds of results.
KIND_NAMES = {"coulomb": "Coulomb", "incremental": INCREMENTAL, "associative": ASSOCIATIVE}
_WRITTEN_JOINTS = 12  #: A picture states the opening or slip of at most this number of joints, largest first.
#: Note on the numbers in a picture.
_NOTE = "Numbers at joints: opening, or sliding if marked s, {}"
_ARROWS = "direction in which the support moves"  #: Legend entry for the arrows on supports.


@dataclass(frozen=True)
class Bound:
    """Least or greatest reaction of supports, and the results of the analyses that compute this reaction.

    Reactions are in the case's unit of force.

    Attributes
    ----------
    result: Result of the chosen method, with its mechanism, tables and pictures. The live load pushes the
        supports, beginning at the reaction ``start``. The reaction at a load factor λ is
        ``start + per_load_factor * λ``.
    with_associative: Result with associative flow; ``result`` itself if the chosen method is associative.
    start: Reaction at λ = 0.
    per_load_factor: Change of the reaction per unit of λ.
    movement: Size of a support movement, in the unit of length, for which openings are reported too; or None.
    """

    result: Result
    with_associative: Result = field(repr=False)
    start: float = field(repr=False)
    per_load_factor: float = field(repr=False)
    movement: float | None = None

    __repr__ = brief

    @property
    def answered_by(self) -> str | None:
        """Key of ``results`` under which the result with the ``reaction`` is stored; None without reaction.

        It is the kind of the chosen method if this method found a load factor in the direction of movement.
        Otherwise it is "incremental", for the incremental analysis.
        """
        if self.result.load_factor is not None:
            return next(iter(self.results))
        return None if self.incremental is None else "incremental"

    @property
    def reaction(self) -> float | None:
        """Reaction by the chosen method, or by the incremental analysis if the method found no load factor.

        The property ``answered_by`` names the method.
        """
        load_factor = self.result.load_factor
        return self.incremental if load_factor is None else self._reaction(load_factor)

    @property
    def incremental(self) -> float | None:
        """Reaction at which equilibrium is lost as the supports move from their initial position.

        The value is None for an associative method, or if no preload was found.
        """
        return self._reaction(self.result.incremental)

    @property
    def associative(self) -> float | None:
        """Reaction of the supports at collapse with associative flow.

        In this direction of movement, no state has a reaction farther from the reaction at rest.
        """
        return self._reaction(self.with_associative.load_factor)

    @property
    def across_rest(self) -> float | None:
        """Reaction of an exact state on the wrong side of the reaction at rest; None if none was found.

        The wrong side is above the reaction at rest for the least reaction, and below for the greatest.
        """
        load_factor = self.result.solution.below_zero
        return self._reaction(load_factor) if load_factor < -self._zero else None

    @property
    def reaction_at_end(self) -> float | None:
        """Reaction at the end of the load history, or ``incremental`` if the history has no known end."""
        return self.incremental if self.result.end is None else self._reaction(self.result.end)

    @property
    def unlimited(self) -> bool:
        """True if a proof shows that the reaction is unlimited."""
        return self.result.solution.carries_any_load

    @property
    def results(self) -> dict[str, Result]:
        """Results by kind: "associative", and "coulomb" and "incremental" if the method computes them."""
        if self.result is self.with_associative:
            return {"associative": self.result}
        results = {"coulomb": self.result}
        if self.result.at_incremental:
            results["incremental"] = self.result.at_incremental
        return results | {"associative": self.with_associative}

    @cached_property
    def openings(self) -> pd.DataFrame:
        """Table of the joints that open or slide, in the first mechanism that ``results`` contains.

        If ``movement`` is set, two columns have the opening and the sliding at this movement of the supports.
        """
        table = joint_openings(self._with_mechanism)
        if self.movement is not None:
            for name in ("opening", "sliding"):
                table[f"{name}_at_movement"] = self.movement * table[name]
        return table

    @property
    def _with_mechanism(self) -> Result:
        """First result that has a mechanism; if no result has one, the result of the chosen method."""
        with_mechanism = (result for result in self.results.values() if result.solution.answer)
        return next(with_mechanism, self.result)

    @property
    def moves_no_support(self) -> bool:
        """True if there is a mechanism, but no support moves in it. It then has no openings."""
        result = self._with_mechanism
        return has_mechanism(result) and not movement_of_supports(result)

    @property
    def largest_movement(self) -> float:
        """Largest support movement for which the openings, computed for small rotations, are accurate."""
        return largest_movement(self._with_mechanism)

    def rows(self) -> list[dict[str, Any]]:
        """Return a table row for each result: reaction, status, certainty and moving blocks."""
        rows = []
        for kind, result in self.results.items():
            # The load factor of an incremental result belongs to the end of the load history. Equilibrium may
            # be lost at an earlier peak, so the reaction is taken from ``incremental``.
            reaction = self.incremental if kind == "incremental" else self._reaction(result.load_factor)
            values = (kind, reaction, str(result.status), self._certainty(kind, result), _moving(result))
            rows.append(dict(zip(REACTION_COLUMNS, values, strict=True)))
        return rows

    @property
    def is_proven(self) -> bool:
        """True if it is proven that no exact state has a reaction between this reaction and that at rest."""
        return bool(known_least(self.result))

    @property
    def history_ends_nearer(self) -> bool:
        """True if the load history ends at a reaction between ``reaction`` and the reaction at rest."""
        return self.answered_by == "coulomb" and load_history_ends_lower(self.result)

    def _certainty(self, kind: str, result: Result) -> str:
        """Return a text on what is proven about the reaction of a result, or "" if it has no reaction.

        The live load pushes the support away from its reaction at rest. A state with a lower load factor is
        therefore closer to the reaction at rest.
        """
        if kind == "incremental":
            return (
                ""
                if self.incremental is None
                else "equilibrium is lost at this reaction as the support moves from its initial position"
            )
        if result.load_factor is None:
            return ""
        if kind == "associative":
            return "in this direction of movement, no state has a reaction farther from the reaction at rest"
        if self.is_proven:
            return (
                f"{state_found(result)}; proven: no other exact state has a reaction closer to the reaction "
                "at rest"
            )
        return (
            f"{state_found(result)}; this reaction is not proven to be the limit: other exact states may "
            f"have a reaction closer to the reaction at rest{search_remark(result, 'them')}"
        )

    @property
    def _zero(self) -> float:
        """Magnitude below which a load factor counts as zero."""
        return self.result.assembly.problem.load_factor_scale.zero

    def _reaction(self, load_factor: float | None) -> float | None:
        """Return the reaction at a load factor. A reaction that is zero except for rounding becomes zero."""
        if load_factor is None:
            return None
        reaction = self.start + self.per_load_factor * load_factor
        return reaction if abs(reaction) > self._zero * abs(self.per_load_factor) else 0.0


def bound_as_dict(end: Bound) -> dict[str, Any]:
    """Return a dictionary of one reaction, with the joint openings and the results of all analyses."""
    names = ("reaction", "answered_by", "incremental", "associative", "across_rest", "unlimited")
    values: dict[str, Any] = {name: getattr(end, name) for name in names}
    values["openings"] = records(end.openings)
    values["results"] = {
        row["kind"]: {"reaction": row["reaction"], "moves": row["moves"]} | result.as_dict()
        for row, result in zip(end.rows(), end.results.values(), strict=True)
    }
    return values


def _moving(result: Result) -> list[str]:
    """Return the names of the blocks that move, in order of decreasing velocity."""
    answer = result.solution.answer
    return moving_names(result.assembly, answer.d) if answer else []


def mechanism_picture(
    result: Result, heading: str, names: bool, view: ViewAngles | None, movement: float | None
) -> Picture:
    """Return a picture of a mechanism, with numbers at the joints that open or slide most.

    The numbers are lengths after a movement of the supports, or per unit of their movement if it is None.
    """
    refuse_view(result.assembly.scene, view)
    elements, joints = result_elements(result), result.assembly.joints
    marks = [replace(mark, label=_ARROWS) if mark.name == "live" else mark for mark in elements.loads]
    widest, scale = joint_openings(result).head(_WRITTEN_JOINTS), 1.0 if movement is None else movement
    for number, opening, sliding in zip(widest["joint"], widest["opening"], widest["sliding"], strict=True):
        motion = elements.motion[[joints.first[number], joints.second[number]]].mean(axis=0)[None]
        text = f"{scale * opening:.3g}" if opening >= sliding else f"{scale * sliding:.3g} s"
        point = joints.middle[number][None, None]
        marks.append(Marks("openings", "", "point", BLACK, 0.0, point, motion, text=text))
    elements = replace(elements, heading=heading, loads=marks)
    notes = (_NOTE.format(after_movement(movement)),) if len(widest) else ()
    return elements_picture(elements, "mechanism", names, view, notes)


def bound_text(end: Bound) -> str:
    """Return a text on the least or greatest reaction: value, certainty, and results of other analyses."""
    by_kind = {row["kind"]: row for row in end.rows()}
    lines = [_reaction_text(end)]
    if end.answered_by is not None:
        lines.append(by_kind[end.answered_by]["certainty"])
    for kind in ("incremental", "associative"):
        row = by_kind.get(kind)
        if row is None or kind == end.answered_by or row["reaction"] is None:
            continue
        lines.append(f"{KIND_NAMES[kind]} {numeral(row['reaction'], '.6g')}: {row['certainty']}")
    return "\n".join(filter(None, lines))


def _reaction_text(end: Bound) -> str:
    """Return a text with the reaction and the moving blocks, or with the status if no reaction was found."""
    if end.reaction is None:
        return "unlimited" if end.unlimited else f"not found ({end.result.status})"
    value = numeral(end.reaction, ".6g")
    if end.answered_by == "incremental":
        return (
            f"{value} by the incremental analysis (no exact collapse state was found in this direction of "
            "movement)"
        )
    name = ASSOCIATIVE
    if end.answered_by == "coulomb":
        name = "proven" if end.is_proven else "found, not proven"
    return f"{value} ({name}); moves {some(_moving(end.result))}"
