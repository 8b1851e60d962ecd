"""Results of analyses: outcomes with words, pictures and files."""

import json
from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from masonry_opt.effort import Effort
from masonry_opt.errors import NoLoadFactorError
from masonry_opt.files import plain
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.reporting.sentences import message, sentences
from masonry_opt.reporting.summary import left_out, summary
from masonry_opt.solution.outcome import Outcome, Size
from masonry_opt.solution.recomputation import (
    guide_columns,
    limit_columns,
    line_columns,
    load_columns,
    normal_columns,
)
from masonry_opt.solution.solution import Solution
from masonry_opt.solvers.registry import Solver

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

#: Attributes of the result in the order in which ``as_dict`` lists them, before the tables.
_DICTIONARY_NAMES = (
    "case",
    "load_case",
    "method",
    "model",
    "solver",
    "status",
    "message",
    "reasons",
    "warnings",
    "kind",
    "crushing",
    "friction_law",
    "time_limit_reached",
    "load_factor",
    "lowest",
    "tilt_angle",
    "blocks",
    "joints",
    "flow_rule_matters",
    "iterations",
    "lp_solves",
    "nlp_solves",
    "stationary",
    "incremental",
    "end",
    "incremental_reasons",
    "associative",
    "exact",
    "range",
    "bound",
    "seconds",
    "solvers",
    "certificate",
    "infeasibility",
    "stability",
    "largest_turn",
    "largest_shift",
    "size",
    "history",
)


class Result(Outcome):
    """Result of an analysis: load factors, state, certificate, tables, texts and pictures.

    Most users need ``load_factor``, ``status`` and ``summary``, the tables ``joints`` and ``blocks``, and the
    methods ``plot`` and ``save``.

    Attributes
    ----------
    message: reasons for the status, as sentences.
    summary: text that ``print`` shows: the load factors, what is proven for each, and the blocks that move.
    details: the summary, with residuals, programs, solvers and times.
    warning_sentences: probable mistakes in the scene, as sentences.
    """

    def __str__(self) -> str:
        return self.summary

    def _repr_html_(self) -> str:
        """Return the HTML that a notebook shows: load factor, status, picture and certificate."""
        from masonry_opt.drawing.page import notebook_html

        return notebook_html(self)

    @cached_property
    def message(self) -> str:
        """Sentences that state the reasons for the status of the result."""
        return message(self.reasons, self.method)

    @property
    def size(self) -> Size:
        """Numbers of blocks and joints, size of the linear program, and parts that the model leaves out."""
        return replace(super().size, left_out=left_out(self.assembly))

    @property
    def warning_sentences(self) -> tuple[str, ...]:
        """Warnings about the scene, as sentences."""
        return sentences(self.warnings)

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        """Warnings as records for JSON: sentence, code, and the values in the sentence."""
        warnings = zip(self.warnings, self.warning_sentences, strict=True)
        return [{"sentence": sentence, **plain(warning.as_dict())} for warning, sentence in warnings]

    @property
    def summary(self) -> str:
        """Text that ``print`` shows: the load factors with their certainty, and the moving blocks."""
        return summary(self)

    @property
    def details(self) -> str:
        """Text of the summary, extended by residuals, sizes of programs, solvers and times."""
        return summary(self, technical=True)

    def required(self) -> float:
        """Return the load factor, or raise an error if the result has none.

        Returns
        -------
        float
            The load factor λ.

        Raises
        ------
        NoLoadFactorError
            If the result has no load factor. The message has the case, the status, the reasons and the
            warnings.
        """
        if self.stability is not None:
            raise NoLoadFactorError(
                f"{self.case}: the scene is stable, but it has no load factor, because no live load acts: "
                "add a live load, such as 'live' of a block"
            )
        if self.load_factor is None:
            raise NoLoadFactorError(f"{self.case}: {self.status}: {self.message}", self.warning_sentences)
        return self.load_factor

    def plot(
        self, kind: str = "mechanism", names: bool = False, view: tuple[float, float] | None = None
    ) -> "Figure":
        """Draw the result and return the matplotlib figure, without changing pyplot's state.

        A notebook shows the figure.

        Parameters
        ----------
        kind: One of four kinds of picture:

            - "mechanism": displaced blocks with their loads, and joints coloured by their motion.
            - "thrust": the resultant of each joint at its point; in arches and columns the line of thrust.
            - "utilisation": force over limit of each joint, in colours.
            - "curve": λ over displacement, if there is a ``curve``.

        names: True to write the name of each block into it.
        view: In space, azimuth (from x towards y) and elevation of the viewpoint, in degrees. The default
            view shows the wider side of the scene, with the live load pushing towards the viewer.
            ``mo.draw`` has the same default.

        Returns
        -------
        Figure
            The matplotlib figure.

        Raises
        ------
        OptionError
            If the result has no picture of this kind, or the picture shows no names. If the view is not two
            angles, or the scene is in the plane and a view is given.
        """
        # Matplotlib is imported only for a picture, because its import is slow.
        from masonry_opt.drawing.pictures import result_picture

        return result_picture(self, kind, names, view)

    def save(
        self,
        path: str | Path,
        kind: str = "mechanism",
        names: bool = False,
        force: bool = False,
        view: tuple[float, float] | None = None,
    ) -> None:
        """Write a picture (.png, .svg, .pdf) or an interactive page (.html) of the result.

        A page needs no network. The file is written whole or not at all.

        Parameters
        ----------
        path: File to write.
        kind: Kind of picture, see ``plot``. For a page it is the property of joints that is shown first; the
            page shows a curve below.
        names: True to write the names of blocks, see ``plot``. A page shows the names at each joint.
        force: True to replace a file that another program wrote. Files of this package contain a mark.
        view: Viewpoint, see ``plot``. For a page it is the first view.

        Raises
        ------
        OptionError
            If the file's name has another ending, or the file cannot be written or replaced. If the kind or
            the view is wrong, see ``plot``. If a page in space needs trimesh, of the extra "meshes", and
            trimesh is not installed.
        OSError
            If the file cannot be written.
        """
        from masonry_opt.drawing import figure, page, pictures

        page.refuse_saving(self.assembly.scene, path, kind, names, force, view)
        drawn = partial(pictures.result_picture, self, kind, names, view)
        figure.save_as(path, force, partial(page.page, self, kind, view), drawn)

    def as_dict(self) -> dict[str, Any]:
        """Return all data as plain numbers, strings, lists and dictionaries; NaN and infinity become None.

        The tables have more columns than the result's data frames, so that the certificate can be recomputed
        from the dictionary alone.

        Returns
        -------
        dict
            The data by name, as the method ``to_json`` writes them.
        """
        attributes = {name: getattr(self, name) for name in _DICTIONARY_NAMES}
        attributes["warnings"] = self.warning_records
        attributes["blocks"] = self.size.blocks
        attributes["joints"] = self.size.joints
        attributes["size"] = asdict(self.size)
        frames = {
            "history": self.history,
            "block_results": self.blocks.assign(**load_columns(self.assembly)),
            **self._joint_tables(),
            "tie_results": self._limited_table(self.ties, Role.TIE, Role.PROP),
            "pressure_results": self._limited_table(self.pressures, Role.EARTH),
            "curve": self.curve,
            "support_results": self._guide_table(),
        }
        tables = {name: frame.to_dict("records") for name, frame in frames.items() if frame is not None}
        return plain(attributes | tables)

    def _joint_tables(self) -> dict[str, "pd.DataFrame"]:
        """Return the table of joints and, in space, also the table of contact points.

        In the plane, the table of joints has additional columns with the unit normals, the yield limits and
        the flow rule. In space, the table of contact points has additional columns with the yield limits and
        the flow rule.
        """
        limits = limit_columns(self.assembly, self.solution)
        if self.contacts is not None:
            return {"joint_results": self.joints, "contact_results": self.contacts.assign(**limits)}
        return {"joint_results": self.joints.assign(**normal_columns(self.assembly), **limits)}

    def _limited_table(self, table: "pd.DataFrame", *roles: Role) -> "pd.DataFrame | None":
        """Add the lines of action to a table of limited forces, such as forces of ties, and return the table.

        The result is None if the table is empty.
        """
        return table.assign(**line_columns(self.assembly, *roles)) if len(table) else None

    def _guide_table(self) -> "pd.DataFrame | None":
        """Return the table of the guide forces of supports that settle; None if no support settles.

        Guide forces prevent all motions of a support except its settlement.
        """
        import pandas as pd  # imported here, because the import takes a fifth of a second

        guides = guide_columns(self.assembly, self.solution)
        return None if guides is None else pd.DataFrame(guides)

    def to_json(self) -> str:
        """Return the dictionary of ``as_dict`` as one JSON object.

        Returns
        -------
        str
            One JSON object on one line.
        """
        return json.dumps(self.as_dict(), allow_nan=False, ensure_ascii=False)


class HasWarnings(Protocol):
    """Protocol for objects that have warnings, such as results of analyses and of studies."""

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        """Warnings as records for JSON: sentence, code, and the values in the sentence."""


def distinct_warnings(results: Sequence[HasWarnings]) -> list[dict[str, Any]]:
    """Return the warning records of several results, without repeating the codes of earlier results.

    For each code, all records of the first result with this code are returned.
    """
    first: dict[str, list[dict[str, Any]]] = {}
    for result in results:
        own: dict[str, list[dict[str, Any]]] = {}
        for record in result.warning_records:
            own.setdefault(record["code"], []).append(record)
        for code, records in own.items():
            first.setdefault(code, records)
    return [record for records in first.values() for record in records]


def make_result(
    assembly: Assembly, solution: Solution, effort: Effort, method: str, solver: Solver
) -> Result:
    """Return the result of an analysis: a solution together with its scene, method, solver and effort."""
    named: dict[str, Any] = {"method": method, "model": solver.language, "solver": solver.name}
    return Result(**named, assembly=assembly, solution=solution, **effort.counts())
