"""Answer of ``crossing``: the worst position of axles, and the load factor by position."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from masonry_opt.brief import brief
from masonry_opt.drawing.elements import title_of
from masonry_opt.reporting.sentences import numeral
from masonry_opt.studies.crossing.assessment import AssessmentOutcome, assessed
from masonry_opt.studies.crossing.load_factors import PLACE_COLUMNS, CrossingLoadFactors
from masonry_opt.studies.crossing.text import facts
from masonry_opt.studies.crossing.units import unusual_axles
from masonry_opt.studies.warning_codes import StudyCode, study_warning
from masonry_opt.studies.writing import StudyAnswer, frame_table, records, render

# Every worker process of a study imports this module. To save time, matplotlib is imported only when a
# picture is drawn.
if TYPE_CHECKING:
    from masonry_opt.drawing.figure import Picture


@dataclass(frozen=True, kw_only=True)
class Crossing(CrossingLoadFactors, StudyAnswer):
    """Answer of a crossing: the load factors of a scene for all solved positions of moving axles.

    Attributes
    ----------
    worst: Result with the axles at the worst position, as loads of blocks. If the scene is unstable under the
        dead load of a load case, it is the result of this load case. It has no incremental load factor if its
        solve was interrupted.
    passages: Answers for each group of axles, direction and load case.
    interrupted: True if the user or the time limit ended the search: λ may be less at other positions.
    time_limit: Time limit in seconds, if it ended the search; otherwise None.
    cases, left_out: Names of the load cases with axles, and of the load cases without.
    default: Result of the default method at the worst position, if the chosen method is associative.
    no_default: Reason why the default method has no result, if the user or the time limit ended its solve, or
        if it raised an error.
    by_parabola: Associative load factor at the worst position with the crushing parabola, if chords replace
        the parabola in ``worst``; otherwise None. It is an upper bound on λ.
    no_parabola: Reason why ``by_parabola`` is not known although ``worst`` uses chords: the user or the time
        limit ended its solve, it raised an error, or any load is carried.
    required_factor: Load factor that is required; None if none is required.
    """

    __repr__ = brief

    @property
    def notebook_table(self) -> pd.DataFrame:
        """Table that a notebook displays: position, λ, mechanism and status from the table ``governing``."""
        table = self.governing[[*PLACE_COLUMNS, *self._case, "load_factor", "mechanism", "status"]]
        return table.assign(position=self.printed_positions(table["position"].tolist()))

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        """Warnings about the worst position, about the units of axles, and about λ below its lower bound."""
        return [*self.worst.warning_records, *self._unusual_axles(), *self._contradictions()]

    def _unusual_axles(self) -> Iterator[dict[str, Any]]:
        """Generate warnings about axles if their loads and the weights seem to be in different units."""
        groups = {
            passage.axles.name: passage.axles for passage in (trials.passage for trials in self.passages)
        }
        if groups:
            yield from unusual_axles(self.passages[0].passage.assembly, groups.values())

    def _contradictions(self) -> Iterator[dict[str, Any]]:
        """Generate a warning if λ at the worst position is less than the proven lower bound on λ.

        The bound and λ come from different solves, so an inaccurate solver can cause this contradiction.
        """
        bounds = [trials.bound for trials in self.passages if trials.bound is not None]
        least = self.load_factor
        if least is None or not bounds:
            return
        bound = min(bounds)
        if not self.load_factor_scale.is_distinctly_lower(least, bound):
            return
        sentence = (
            f"λ = {numeral(least, '.6f')} at the worst position is less than the separately computed lower "
            f"bound {numeral(bound, '.6f')} on λ, so the bound is not reported: try another solver"
        )
        yield study_warning(StudyCode.BELOW_BOUND, sentence, load_factor=least, bound=bound)

    @property
    def passed(self) -> bool | None:
        """True if the required load factor is reached; None if no load factor is required.

        The value is also False if the comparison is undecided.
        """
        if self.required_factor is None:
            return None
        return assessed(self, self.required_factor).outcome is AssessmentOutcome.PASSED

    def facts(self) -> dict[str, str]:
        """Return the printed lines of the answer, as a dict from the label of each line to its text."""
        return facts(self)

    def as_dict(self) -> dict[str, Any]:
        """Return the answer as plain numbers, strings, lists and dictionaries.

        Returns
        -------
        dict
            The data by name. The list ``positions`` has a dictionary for each row of :attr:`table`. The value
            ``worst`` is the dictionary of the result at the worst position.
        """
        worst = self.worst.as_dict()
        of_worst = ("case", "load_case", "method", "model", "solver", "status", "load_factor")
        place = ("axles", "direction", "position", "at", "uniform_at", "resolution")
        loads = ("axle_loads", "capacity", "uniform_loads", "required_factor", "passed")
        complete = ("bound", "undecided", "undecided_at", "interrupted", "time_limit_reached")
        own = (*place, *loads, *complete, "by_case", "left_out")
        result = {key: worst[key] for key in of_worst} | {key: getattr(self, key) for key in own}
        result["default"] = self.default and self.default.load_factor
        result["default_associative"] = self.default and self.default.associative
        result["no_default"] = self.no_default or None
        result |= {"by_parabola": self.by_parabola, "no_parabola": self.no_parabola or None}
        result["warnings"] = self.warning_records
        return result | {
            "positions": records(self.table),
            "governing": records(self.notebook_table),
            "worst": worst,
        }

    def plot(self) -> "Picture":
        """Return a matplotlib figure: a chart of λ by position, above the mechanism at the worst position.

        Both parts have the same x axis. The x axis of the chart is the position of the first axle.

        Returns
        -------
        Picture
            The figure, a subclass of matplotlib's ``Figure``.

        Raises
        ------
        OptionError
            If the scene is unstable.
        """
        from masonry_opt.studies.crossing.picture import crossing_picture

        return crossing_picture(self)

    def save(self, path: str | Path, force: bool = False) -> None:
        """Write the picture to a .png, .svg or .pdf file, or a page with the picture to an .html file.

        The page also has the result at the worst position and the table. The file is written completely or
        not at all.

        Parameters
        ----------
        path: File to write.
        force: True to replace a file that another program wrote.

        Raises
        ------
        OptionError
            If the name has another ending, if the file cannot be written or replaced (``force`` replaces
            files of other programs), or if the scene is unstable.
        """
        from masonry_opt.drawing.figure import save_as

        save_as(path, force, self._page, self.plot)

    def _page(self) -> str:
        """Return the page as HTML."""
        from masonry_opt.drawing.page import notebook_html

        title = title_of(self.worst.assembly.scene)
        parts = {"At the worst position": notebook_html(self.worst)}
        return render("study.html", title=title, answer=self, pictures=self.pictures(), parts=parts)

    def pictures(self) -> dict[str, "Picture"]:
        """Return the pictures of the HTML page, by caption."""
        return {"λ by the position of the first axle, and the mechanism at the worst position": self.plot()}

    def page_tables(self) -> dict[str, dict[str, Any]]:
        """Return the tables of the HTML page, by heading."""
        rows = frame_table(self.notebook_table, position="first axle at", load_case="load case that governs")
        return {f"Every position solved ({len(self.notebook_table)})": rows}
