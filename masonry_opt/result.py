"""The result of an analysis: its outcome, which asks words, pictures and files to show it."""

import json
from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_opt.answer.outcome import Outcome, Size
from masonry_opt.answer.recomputation import limit_columns, line_columns, load_columns, normal_columns
from masonry_opt.answer.solution import Solution
from masonry_opt.effort import Effort
from masonry_opt.errors import NoLoadFactorError
from masonry_opt.files import plain
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role
from masonry_opt.solvers.registry import Solver
from masonry_opt.words.sentences import message, sentences
from masonry_opt.words.summary import left_out, summary

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

#: What ``as_dict`` tells first, in order; then block by block and joint by joint.
_TOLD = (
    *("case", "load_case", "method", "model", "solver", "status", "message", "reasons", "warnings", "kind"),
    *("crushing", "friction_law", "load_factor", "tilt_angle", "blocks", "joints", "flow_rule_matters"),
    *("iterations", "lp_solves", "nlp_solves", "stationary", "expected", "end", "expected_reasons"),
    *("associative", "exact", "range", "bound", "seconds", "solvers", "certificate", "infeasibility"),
    *("largest_turn", "largest_shift", "size", "history"),
)


class Result(Outcome):
    """The answer to "at what load does this masonry collapse?", in numbers (see
    :class:`~.answer.outcome.Outcome`), words and pictures.

    Attributes
    ----------
    message: why it ended so, in words.
    summary: what ``print`` shows: the load factors, what is proven of each, and what moves.
    details: the summary, with residuals, programs, solvers and times.
    warning_sentences: what looks unintended in the scene, in words.
    """

    def __str__(self) -> str:
        return self.summary

    def _repr_html_(self) -> str:
        """What a notebook shows: load factor, status, picture, certificate."""
        from masonry_opt.drawing.page import notebook_html

        return notebook_html(self)

    @cached_property
    def message(self) -> str:
        return message(self.reasons, self.method)

    @property
    def size(self) -> Size:
        return replace(super().size, left_out=left_out(self.assembly))

    @property
    def warning_sentences(self) -> tuple[str, ...]:
        return sentences(self.warnings)

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        """Warnings as JSON output has them: sentence, code and the values of the code."""
        told = zip(self.warnings, self.warning_sentences, strict=True)
        return [{"sentence": sentence, **warning.as_dict()} for warning, sentence in told]

    @property
    def summary(self) -> str:
        return summary(self)

    @property
    def details(self) -> str:
        return summary(self, technical=True)

    def required(self) -> float:
        """The load factor; NoLoadFactorError, with case, status, message and warnings, if there is none."""
        if self.load_factor is None:
            warnings = "".join(f"; warning: {sentence}" for sentence in self.warning_sentences)
            raise NoLoadFactorError(f"{self.case}: {self.status}: {self.message}{warnings}")
        return self.load_factor

    def plot(
        self, kind: str = "mechanism", names: bool = False, view: tuple[float, float] | None = None
    ) -> "Figure":
        """Draw the result, as a matplotlib figure without pyplot's state; a notebook shows it.

        Parameters
        ----------
        kind: "mechanism" (blocks displaced, with their loads; joints by how they move), "thrust" (the
            resultant of each joint where it acts; through arches and columns the line of thrust) or
            "utilisation" (of each joint the force over its limit, in colours), or "curve" (λ over
            displacement, where there is a ``curve``).
        names: whether to write each block's name into it.
        view: in space, azimuth (from x towards y) and elevation of the eye, in degrees. By default one that
            shows the scene's wider side, and its mechanism coming nearer.

        Raises
        ------
        OptionError
            If there is no such kind, of this result, or it shows no names, or the view is none, or of a scene
            in the plane.
        """
        # Matplotlib is loaded where a picture is asked for.
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
        """Write the result whole or not at all: a picture (.png, .svg, .pdf), or one interactive page (.html)
        that needs no network.

        Parameters
        ----------
        kind: as in ``plot``; of a page, what joints show first (a curve it shows below).
        names: as in ``plot``; a page tells them of each joint.
        force: whether to replace a file that was not written here, which is known by a mark in it.
        view: as in ``plot``; of a page, the one that it shows first.

        Raises
        ------
        OptionError
            If the file's name has another ending, there is no such kind, the file cannot be written or
            replaced, the view is none, or of a scene in the plane; of a page in space also if trimesh, of the
            extra "meshes", is not installed.
        OSError
            If the file cannot be written.
        """
        from masonry_opt.drawing import figure, page, pictures

        page.refuse_saving(self.assembly.scene, path, kind, names, force, view)
        drawn = partial(pictures.result_picture, self, kind, names, view)
        figure.save_as(path, force, partial(page.page, self, kind, view), drawn)

    def as_dict(self) -> dict[str, Any]:
        """Return everything as plain numbers, strings, lists and dictionaries (NaN and infinity as None).

        The tables have more columns here (see :mod:`~.answer.recomputation`): the certificate can be
        recomputed from the dictionary alone.
        """
        told = {name: getattr(self, name) for name in _TOLD}
        told["warnings"] = self.warning_records
        told["blocks"], told["joints"], told["size"] = self.size.blocks, self.size.joints, asdict(self.size)
        frames = {
            "history": self.history,
            "block_results": self.blocks.assign(**load_columns(self.assembly)),
            **self._joint_tables(),
            "tie_results": self._limited_table(self.ties, Role.TIE, Role.PROP),
            "pressure_results": self._limited_table(self.pressures, Role.EARTH),
            "curve": self.curve,
        }
        return plain(told | {name: of.to_dict("records") for name, of in frames.items() if of is not None})

    def _joint_tables(self) -> dict[str, "pd.DataFrame"]:
        """Return the tables of joints, in space also of contact points, with their limits."""
        limits = limit_columns(self.assembly, self.solution)
        if self.contacts is not None:
            return {"joint_results": self.joints, "contact_results": self.contacts.assign(**limits)}
        return {"joint_results": self.joints.assign(**normal_columns(self.assembly), **limits)}

    def _limited_table(self, table: "pd.DataFrame", *roles: Role) -> "pd.DataFrame | None":
        """Return a table of limited forces with their lines of action; None if there are none."""
        return table.assign(**line_columns(self.assembly, *roles)) if len(table) else None

    def to_json(self) -> str:
        """``as_dict`` as one JSON object."""
        return json.dumps(self.as_dict(), allow_nan=False, ensure_ascii=False)


def distinct_warnings(results: Sequence[Result]) -> list[dict[str, Any]]:
    """Return the records of the warnings of results: of each code those of the first result that has any."""
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
    """A solution with the names and units of its scene, and what it took."""
    spent = {name: count for name, count in vars(effort).items() if name != "begins"}
    named: dict[str, Any] = {"method": method, "model": solver.language, "solver": solver.name}
    return Result(**named, assembly=assembly, solution=solution, **spent)
