"""Answer of ``crossing``: the worst position of axles, and the load factor by position."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from masonry_opt.brief import brief
from masonry_opt.drawing.colours import HATCH, LIVE, MARKED, SERIES
from masonry_opt.drawing.elements import title_of
from masonry_opt.drawing.figure import Picture, entitle, finish, save_as, style
from masonry_opt.drawing.page import notebook_html
from masonry_opt.drawing.pictures import draw_mechanism
from masonry_opt.errors import OptionError, counted, printable
from masonry_opt.reporting.load_factors import certainty, named_factor, own_name
from masonry_opt.reporting.names import some
from masonry_opt.reporting.sentences import numeral
from masonry_opt.result import Result
from masonry_opt.solution.solution import Solution
from masonry_opt.solution.thresholds import same
from masonry_opt.studies.crossing.search import Passage, PassageTrials
from masonry_opt.studies.many.runs import columns, framed
from masonry_opt.studies.warning_codes import StudyCode, study_warning
from masonry_opt.studies.writing import StudyAnswer, frame_table, records, render

_PLACE = ["axles", "direction", "position"]  #: Columns that identify a position.
WITHIN = 1e-3  #: Largest relative distance of the proven lower bound from the least load factor.
_CHART_HEIGHT = 0.42  #: Height of the chart relative to the width of the picture.
_CHART_GAP = 0.1  #: Distance between the chart and the mechanism, relative to the width of the picture.
_LARGEST_SHOWN = 4.0  #: Upper end of the chart's axis of λ, as a multiple of the least λ.
_AXLE_ARROW_LENGTH = 0.05  #: Length of the arrow of the heaviest axle, relative to the length of the bridge.


@dataclass(frozen=True, kw_only=True)
class Crossing(StudyAnswer):
    """Load factors of a scene for axles that move over its road, by the position of the axles.

    Attributes
    ----------
    worst: Result with the axles at the worst position as loads of blocks. If the scene is unstable it is
        the result of that load case. It has no incremental load factor if its solve was interrupted.
    passages: Answers for each group of axles, direction and load case.
    interrupted: True if the user interrupted the search: λ may be less at other positions.
    cases, left_out: Names of the load cases with axles, and of the load cases without.
    default: Result of the default method at the worst position, if the chosen method is associative.
    no_default: Reason why the default method has no result, if it was interrupted or raised an error.
    """

    worst: Result
    passages: tuple[PassageTrials, ...] = field(repr=False)
    interrupted: bool = False
    cases: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    default: Result | None = field(default=None, repr=False)
    no_default: str = field(default="", repr=False)

    __repr__ = brief

    @property
    def load_factor(self) -> float | None:
        """Least load factor of all positions; None if no position has a load factor."""
        return self.worst.load_factor

    def required(self) -> float:
        """Return the least load factor. Raises NoLoadFactorError if no position has a load factor."""
        return self.worst.required()

    @property
    def least(self) -> PassageTrials | None:
        """Answers of the passage with the least load factor; None if the scene is unstable."""
        return min(self.passages, key=lambda trials: trials.least, default=None)

    @property
    def axles(self) -> str | None:
        """Name of the group of axles at the worst position."""
        return self.least.passage.axles.name if self.least else None

    @property
    def direction(self) -> str | None:
        """Direction of travel at the worst position, "right" or "left"."""
        return self.least.passage.direction if self.least else None

    @property
    def position(self) -> float | None:
        """Abscissa of the first axle at the worst position, in the unit of length of the case."""
        return self.least.position if self.least else None

    @property
    def at(self) -> list[float]:
        """Abscissae of all axles at the worst position, beginning with the first axle."""
        return (self.least.position + self.least.passage.offsets).tolist() if self.least else []

    @property
    def resolution(self) -> float | None:
        """Larger one of the two distances from the worst position to the next solved positions."""
        return self.least.resolution if self.least else None

    @property
    def bound(self) -> float | None:
        """Proven lower bound of the associative load factor at all positions; None if nothing is proven.

        The value is also None if the load factor is less than the bound; a warning reports that.
        Joints of limited strength crush by the law of ``worst.crushing``. The default method has chords
        inside the parabola, so that its load factors may be lower than a bound by the parabola.
        """
        bounds = [trials.bound for trials in self.passages if trials.bound is not None]
        if self.interrupted or not bounds or len(bounds) < len(self.passages):
            return None
        bound, least = min(bounds), self.load_factor
        if least is None or least >= bound:
            return bound
        # The final λ of the worst position may be less than the bound because of rounding errors, so the
        # smaller value is returned.
        return least if same(bound, least) else None

    @property
    def undecided(self) -> int:
        """Number of positions at which neither a load factor nor a proof of "any load" was found."""
        return len({tuple(row[name] for name in _PLACE) for row in self.undecided_at})

    @property
    def undecided_at(self) -> list[dict[str, Any]]:
        """Records of the undecided positions, with axles, direction, position and, if any, load case."""
        unknown = self.table["load_factor"].isna() & ~self.table["any_load"].astype(bool)
        return records(self.table.loc[unknown, [*self._case, *_PLACE]])

    @property
    def _case(self) -> list[str]:
        """List with the name of the column of load cases; empty if the scene has no load cases."""
        return ["load_case"] if self.cases else []

    @cached_property
    def table(self) -> pd.DataFrame:
        """Table of all answers of the method, with one row for each position and load case.

        The columns are ``load_case`` (if any), ``axles``, ``direction``, ``position`` (abscissa of the first
        axle), then the columns of ``mo.sweep`` without ``seconds``. Where loads jump, there is a row on both
        sides.
        """
        rows = []
        for trials in self.passages:
            for position, solution in sorted(trials.answers.items()):
                result = self._result_at(trials.passage, position, solution)
                rows.append(_place(trials.passage, position) | columns(result))
        place_types = dict.fromkeys([*self._case, *_PLACE], "object") | {"position": "float64"}
        return framed(rows, place_types).drop(columns="seconds")

    def _result_at(self, passage: Passage, position: float, solution: Solution) -> Result:
        """Return the result of a solution with the first axle at a position."""
        return replace(self.worst, assembly=passage.loaded(passage.live(position)), solution=solution)

    @cached_property
    def governing(self) -> pd.DataFrame:
        """Table with the least load factor of all load cases at each position.

        If no load case has a load factor, ``load_case`` is None, and the status is that of an undecided load
        case, if any.
        """
        least = self.table.sort_values(["load_factor", "any_load"]).drop_duplicates(_PLACE)
        rows = self.table[_PLACE].drop_duplicates().merge(least, how="left")
        known = rows["load_factor"].notna()
        return rows.assign(**{name: rows[name].where(known, None) for name in self._case})

    @property
    def told(self) -> pd.DataFrame:
        """Columns of the table ``governing`` that a notebook shows."""
        return self.governing[[*_PLACE, *self._case, "load_factor", "mechanism", "status"]]

    @property
    def by_case(self) -> dict[str, float | None]:
        """Least load factor (or None) of each load case with axles, by the name of the load case."""
        known = self.table.dropna(subset="load_factor")
        least = known.groupby("load_case")["load_factor"].min().to_dict() if self._case else {}
        return {name: least.get(name) for name in self.cases}

    @property
    def not_crossed(self) -> list[str]:
        """Names of the load cases with axles that have no answer."""
        answered = {self.worst.load_case, *(trials.passage.case for trials in self.passages)}
        return [name for name in self.cases if name not in answered]

    @cached_property
    def envelope(self) -> pd.DataFrame:
        """Table of associative load factors, which are upper bounds, with one row for each position.

        The columns are ``axles``, ``direction``, ``position`` and ``associative``, NaN where any load is
        carried.
        """
        rows = []
        for trials in self.passages:
            bounds = trials.associative
            for x, value in zip(bounds.positions, bounds.load_factors, strict=True):
                rows.append(_place(trials.passage, x) | {"associative": value})
        frame = pd.DataFrame(rows, columns=[*self._case, *_PLACE, "associative"])
        return frame.replace(math.inf, math.nan)

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        """Warnings of the result at the worst position, and a warning if λ is less than its lower bound."""
        return [*self.worst.warning_records, *self._contradictions()]

    def _contradictions(self) -> Iterator[dict[str, Any]]:
        """Yield a warning if λ at the worst position contradicts (is less than) its proven lower bound."""
        bounds = [trials.bound for trials in self.passages if trials.bound is not None]
        least = self.load_factor
        if least is None or not bounds:
            return
        bound = min(bounds)
        if least >= bound or same(bound, least):
            return
        less = f"λ = {numeral(least, '.6f')} at the worst position is less than the lower bound"
        bound_text = f"{numeral(bound, '.6f')} by another program"
        sentence = f"{less} {bound_text}: no bound is reported; try another solver"
        yield study_warning(StudyCode.BELOW_BOUND, sentence, load_factor=least, bound=bound)

    def facts(self) -> dict[str, str]:
        """Return the printed lines of the answer as text by label."""
        worst = self.worst
        facts = {"case": worst.case, "method": worst.method} | self._load_case_facts()
        missing_cases = some([*map(repr, self.not_crossed)])
        if self.least is None:
            facts["status"] = f"{worst.status}: {worst.message}"
            return facts | ({"not crossed": missing_cases} if missing_cases else {})
        facts |= self._worst_facts(self.least.passage)
        if self.bound is not None:
            law = f", with crushing by the {worst.crushing}" if worst.crushing else ""
            proven = "proven lower bound of the associative load factor along the whole road"
            facts["bound"] = f"{numeral(self.bound, '.6f')}: {proven}{law}"
        if self.undecided:
            template = "{position:.6g} ('{axles}', {direction}"
            template += ", in '{load_case}')" if len(self.by_case) > 1 else ")"
            places = some([template.format(**place) for place in self.undecided_at])
            facts["undecided"] = f"{counted(self.undecided, 'position')}, at which λ may be less: {places}"
        if self.interrupted:
            not_reached = f", and in load cases not reached: {missing_cases}" if missing_cases else ""
            facts["interrupted"] = f"λ may be less at positions that were not solved{not_reached}"
        return facts

    def _load_case_facts(self) -> dict[str, str]:
        """Return the printed lines on load cases: the governing one, the others, and those without axles."""
        worst, facts = self.worst, dict[str, str]()
        if worst.load_case is not None:
            governs = ", governs" if len(self.by_case) - len(self.not_crossed) > 1 else ""
            facts["load case"] = f"'{worst.load_case}'{governs}: {worst.assembly.scene.load_case}"
        others = []
        for name, load_factor in self.by_case.items():
            if name not in (worst.load_case, *self.not_crossed):
                others.append(f"'{name}' {'none' if load_factor is None else numeral(load_factor, '.6f')}")
        if others:
            facts["other cases"] = f"least λ {', '.join(others)}"
        if self.left_out:
            facts["left out"] = f"{some([*map(repr, self.left_out)])}, without axles: see 'solve'"
        return facts

    def _worst_facts(self, passage: Passage) -> dict[str, str]:
        """Return the printed lines on the worst position, which belongs to a passage."""
        worst, group = self.worst, passage.axles
        governing = "none: any load is carried" if worst.solution.carries_any_load else str(worst.status)
        if worst.load_factor is not None:
            governing = f"{numeral(worst.load_factor, '.6f')} ({own_name(worst)})"
        first, *others = (numeral(x, ".6g") for x in self.at)
        source = f" ({group.group.source})" if group.group.source else ""
        facts = {
            "governing λ": governing,
            "known of it": certainty(worst),
            "at": f"axles at x = {first}{' (first)' if others else ''}{''.join(f', {x}' for x in others)}",
            "axles": f"'{self.axles}', travelling {self.direction}{source}",
        }
        if group.width:
            facts["width"] = f"{passage.across:.4g} of each load, for an effective width of {group.width:g}"
        positions, spacing = counted(len(self.governing), "position"), numeral(self.resolution or 0.0, ".3g")
        between = "" if self.bound is not None else "; λ may be less between positions"
        facts["solved"] = f"at {positions}; spacing at the worst position {spacing}{between}"
        first_look = self._first_look()
        if first_look:
            facts["first look"] = first_look
        if passage.assembly.problem.live.any():
            facts["beside them"] = "other live loads of the scene, which λ also multiplies"
        return facts

    def _first_look(self) -> str:
        """Return text on the λ of the default method at the worst position; "" if it was not computed.

        The load factor of the default method is compared with the associative load factor by its own law of
        crushing.
        """
        if self.default is None:
            return self.no_default and f"not compared with the default method: {self.no_default}"
        load_factor, associative, law = self.default.load_factor, self.load_factor, ""
        subject = f"method '{self.default.method}', the default, finds"
        if self.default.crushing != self.worst.crushing:
            associative = self.default.associative
            law = f", with crushing by {self.default.crushing}"
        if load_factor is None or associative is None:
            return f"{subject} there: {self.default.status}"
        difference = 1 - load_factor / associative if associative > 0 else 0.0
        much = f"{difference:.2%} less than" if difference > WITHIN else "the same as"
        compared = f"{much} the associative load factor{' by the same law' if law else ''}"
        at = f"λ = {numeral(load_factor, '.6f')} there{law}"
        return f"{subject} {at}: {compared}; λ may be less at other positions"

    def as_dict(self) -> dict[str, Any]:
        """Return the answer as plain numbers, strings, lists and dictionaries."""
        worst = self.worst.as_dict()
        of_worst = ("case", "load_case", "method", "model", "solver", "status", "load_factor")
        place = ("axles", "direction", "position", "at", "resolution")
        own = (*place, "bound", "undecided", "undecided_at", "interrupted", "by_case", "left_out")
        result = {key: worst[key] for key in of_worst} | {key: getattr(self, key) for key in own}
        result["default"] = self.default and self.default.load_factor
        result["default_associative"] = self.default and self.default.associative
        result["warnings"] = self.warning_records
        return result | {"positions": records(self.table), "governing": records(self.told), "worst": worst}

    def plot(self) -> Picture:
        """Return a matplotlib figure of λ by position, with the mechanism at the worst position below.

        Both have one scale of abscissae; the position is that of the first axle. Raises OptionError if the
        scene is unstable.
        """
        least, worst = self.least, self.worst
        if least is None:
            raise OptionError(f"{worst.case}: {worst.status}: no axle was moved, so there is nothing to draw")
        passage, heading = least.passage, str(worst.status)
        with style():
            picture = Picture()
            bridge = picture.add_subplot()
            if worst.load_factor is not None:
                draw_mechanism(worst, bridge)
                where = f"'{self.axles}' at {numeral(least.position, '.4g')}, travelling {self.direction}"
                heading = printable(f"governing {named_factor(worst)} with {where}")
            positions = np.concatenate([trials.positions for trials in self.passages])
            abscissae = [*bridge.get_xlim(), *positions]
            low, high = min(abscissae), max(abscissae)
            bottom, top = bridge.get_ylim()
            arrow = _AXLE_ARROW_LENGTH * (high - low)
            top = max(top, _axles(bridge, passage, least.position, arrow) + 1.5 * arrow)
            bridge.set(xlim=(low, high), ylim=(bottom, top), xlabel="x, y in the length unit of the case")
            aspect = (high - low) / (top - bottom)
            box = (0.0, 1 + _CHART_GAP * aspect, 1.0, _CHART_HEIGHT * aspect)
            chart: Any = bridge.inset_axes(box, sharex=bridge)
            self._draw_load_factors(chart, least.position)
            entitle(chart, title_of(worst.assembly.scene), heading)
            finish(picture, bridge, chart.get_legend_handles_labels()[0])
        return picture

    def _draw_load_factors(self, axes: Axes, position: float) -> None:
        """Draw the least λ of all load cases by position, for each group of axles and direction.

        Thin lines behind show each load case, if there are several, and the associative λ of other methods.
        """
        dots: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 7}
        coulomb = self.passages[0].beside is not None
        look = dots if coulomb else {"linewidth": 1.1}
        background = ["associative"] if coulomb else []
        background += ["each load case"] if len(self.by_case) > 1 else []
        if background:
            for _, rows in self.envelope.groupby([*self._case, "axles", "direction"], sort=False):
                axes.plot(rows["position"], rows["associative"], color=HATCH, linewidth=0.8, zorder=2)
        groups = self.governing.groupby(["axles", "direction"], sort=False)
        for ((axles, direction), rows), colour in zip(groups, cycle(SERIES), strict=False):
            name = printable(f"'{axles}', travelling {direction}")
            axes.plot(rows["position"], rows["load_factor"], color=colour, label=name, zorder=3, **look)
        if background:
            axes.plot([], [], color=HATCH, linewidth=0.8, label=", ".join(background))
        axes.set(xlabel="position of the first axle", ylabel="load factor λ")
        axes.grid(color="#E4E4E4", linewidth=0.6)
        if self.load_factor is not None:
            ring: dict[str, Any] = {"color": MARKED, "markersize": 11, "fillstyle": "none"}
            axes.plot(position, self.load_factor, "o", label="worst", zorder=4, **ring)
            highest = 1.1 * float(self.governing["load_factor"].max())
            axes.set_ylim(0.0, min(_LARGEST_SHOWN * self.load_factor, highest) or 1.0)

    def save(self, path: str | Path, force: bool = False) -> None:
        """Write the picture (.png, .svg, .pdf), or a page (.html).

        The page has the picture, the result at the worst position and the table. The file is written
        completely or not at all. Raises OptionError if the name has another ending, if the file cannot be
        written or replaced (``force`` replaces files of other programs), or if the scene is unstable.
        """
        save_as(path, force, self._page, self.plot)

    def _page(self) -> str:
        """Return the page as HTML."""
        title = title_of(self.worst.assembly.scene)
        parts = {"At the worst position": notebook_html(self.worst)}
        return render("study.html", title=title, answer=self, pictures=self.pictures(), parts=parts)

    def pictures(self) -> dict[str, Picture]:
        """Return the pictures of the page by caption."""
        return {"λ by the position of the first axle, and the mechanism at the worst position": self.plot()}

    def page_tables(self) -> dict[str, dict[str, Any]]:
        """Return the tables of the page by heading."""
        rows = frame_table(self.told, position="first axle at", load_case="load case that governs")
        return {f"Every position solved ({len(self.told)})": rows}


def _place(passage: Passage, position: float) -> dict[str, Any]:
    """Return the columns of a table row that identify a position."""
    place = (passage.case, passage.axles.name, passage.direction, position)
    return dict(zip(("load_case", *_PLACE), place, strict=True))


def _axles(axes: Axes, passage: Passage, position: float, arrow: float) -> float:
    """Draw the road, and the axles as arrows; return the height of the highest point of the road."""
    line = passage.road.line
    axes.plot(*line.T, color=LIVE, linewidth=0.8, zorder=6)
    loads = np.array(passage.axles.group.loads)
    for x, share in zip(position + passage.offsets, loads / loads.max(), strict=True):
        if line[0, 0] <= x <= line[-1, 0]:
            y = float(np.interp(x, *line.T))
            look = {"arrowstyle": "-|>", "color": LIVE, "linewidth": 1.3, "shrinkA": 0, "shrinkB": 0}
            axes.annotate("", (x, y), (x, y + share * arrow), arrowprops=look, zorder=7)
    return float(line[:, 1].max())
