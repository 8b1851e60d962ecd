"""The answer of ``crossing``: the worst position, and the load factor by position."""

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

from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import same
from masonry_opt.drawing.colours import HATCH, LIVE, MARKED, SERIES
from masonry_opt.drawing.elements import title_of
from masonry_opt.drawing.figure import Picture, entitle, finish, save_as, style
from masonry_opt.drawing.page import notebook_html
from masonry_opt.drawing.pictures import draw_mechanism
from masonry_opt.errors import OptionError, counted, printable
from masonry_opt.result import Result
from masonry_opt.studies.crossing.search import Passage, PassageTrials
from masonry_opt.studies.many.runs import columns, framed
from masonry_opt.studies.warning_codes import StudyCode, study_warning
from masonry_opt.studies.writing import StudyAnswer, frame_table, records, render
from masonry_opt.words.load_factors import certainty, named_factor, own_name
from masonry_opt.words.names import some
from masonry_opt.words.sentences import numeral

_PLACE = ["axles", "direction", "position"]  #: Columns that tell positions apart.
WITHIN = 1e-3  #: Distance of the least load factor from what is proven, relative, where anything is.
_HIGH, _BETWEEN = 0.42, 0.1  #: Height of the chart, and room below it, over the width of both pictures.
_SHOWN_UP_TO = 4.0  #: Load factors are shown up to so many times the least.
_ARROW = 0.05  #: Length of the arrow of the greatest axle, as a share of the bridge's length.


@dataclass(frozen=True, kw_only=True)
class Crossing(StudyAnswer):
    """Load factors of a scene by the position of axles.

    Attributes
    ----------
    worst: result with the axles at the worst position as loads of blocks; of a scene that does not stand, the
        one that says so. Without an incremental load factor if that last solve was interrupted.
    passages: each group of axles in each direction in which it travelled.
    interrupted: whether the user ended it: λ may be less at other positions than those solved by then.
    cases, left_out: names of load cases that name axles, and of those that leave them out.
    default: what the default method finds at the worst position, if that asked for is associative; else None.
    no_default: why that found nothing, where it was interrupted or raised an error.
    """

    worst: Result
    passages: tuple[PassageTrials, ...] = field(repr=False)
    interrupted: bool = False
    cases: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    default: Result | None = field(default=None, repr=False)
    no_default: str = field(default="", repr=False)

    @property
    def load_factor(self) -> float | None:
        """The least load factor; None without one."""
        return self.worst.load_factor

    def required(self) -> float:
        """The least load factor; NoLoadFactorError if there is none."""
        return self.worst.required()

    @property
    def least(self) -> PassageTrials | None:
        """The passage with the worst position; None of a scene that does not stand."""
        return min(self.passages, key=lambda one: one.least, default=None)

    @property
    def axles(self) -> str | None:
        """Name of the worst group."""
        return self.least.passage.axles.name if self.least else None

    @property
    def direction(self) -> str | None:
        """In which it travels, "right" or "left"."""
        return self.least.passage.direction if self.least else None

    @property
    def position(self) -> float | None:
        """Abscissa of its first axle at the worst position."""
        return self.least.position if self.least else None

    @property
    def at(self) -> list[float]:
        """Abscissae of all its axles there, the first axle first."""
        return (self.least.position + self.least.passage.offsets).tolist() if self.least else []

    @property
    def resolution(self) -> float | None:
        """How finely it was sought: the larger distance from it to the next solved on either side."""
        return self.least.resolution if self.least else None

    @property
    def bound(self) -> float | None:
        """Proven lower bound of the associative load factor at all positions; None where nothing is proven.

        It is None too if the load factor contradicts it, of which a warning tells.
        Joints of limited strength crush by the law of ``worst.crushing``. The default method has chords
        inside the parabola, so that its load factors may be lower than a bound by the parabola.
        """
        bounds = [one.bound for one in self.passages if one.bound is not None]
        if self.interrupted or not bounds or len(bounds) < len(self.passages):
            return None
        bound, found = min(bounds), self.load_factor
        if found is None or found >= bound:
            return bound
        # The worst position is solved once more, by a program that may end lower in its last digits.
        return found if same(bound, found) else None

    @property
    def undecided(self) -> int:
        """Number of positions at which the method found no load factor and proved none."""
        return len({tuple(row[name] for name in _PLACE) for row in self.undecided_at})

    @property
    def undecided_at(self) -> list[dict[str, Any]]:
        """These, once for each load case: ``axles``, ``direction``, ``position``, ``load_case`` if any."""
        unknown = self.table["load_factor"].isna() & ~self.table["any_load"].astype(bool)
        return records(self.table.loc[unknown, [*self._case, *_PLACE]])

    @property
    def _case(self) -> list[str]:
        """Column of the load case, of a scene that has any."""
        return ["load_case"] if self.cases else []

    @cached_property
    def table(self) -> pd.DataFrame:
        """One row a position solved by the method, and load case: ``load_case`` (if any), ``axles``,
        ``direction``, ``position`` (abscissa of the first axle), then the columns of ``mo.sweep`` but for the
        seconds. Where loads jump there is a row on either side."""
        rows = [
            _place(one.passage, position) | columns(self._result_at(one.passage, position, answer))
            for one in self.passages
            for position, answer in sorted(one.answers.items())
        ]
        where = dict.fromkeys([*self._case, *_PLACE], "object") | {"position": "float64"}
        return framed(rows, where).drop(columns="seconds")

    def _result_at(self, passage: Passage, position: float, solution: Solution) -> Result:
        """Return the result of a solution with the first axle at a position."""
        return replace(self.worst, assembly=passage.loaded(passage.live(position)), solution=solution)

    @cached_property
    def governing(self) -> pd.DataFrame:
        """The row of the table with the least load factor at each position. Where no case has one
        ``load_case`` is None, and the status that of an undecided case, if any."""
        least = self.table.sort_values(["load_factor", "any_load"]).drop_duplicates(_PLACE)
        rows = self.table[_PLACE].drop_duplicates().merge(least, how="left")
        known = rows["load_factor"].notna()
        return rows.assign(**{name: rows[name].where(known, None) for name in self._case})

    @property
    def told(self) -> pd.DataFrame:
        """What is printed of ``governing``."""
        return self.governing[[*_PLACE, *self._case, "load_factor", "mechanism", "status"]]

    @property
    def by_case(self) -> dict[str, float | None]:
        """The least load factor of each load case that names axles (None without one) by its name."""
        known = self.table.dropna(subset="load_factor")
        least = known.groupby("load_case")["load_factor"].min().to_dict() if self._case else {}
        return {name: least.get(name) for name in self.cases}

    @property
    def not_crossed(self) -> list[str]:
        """Load cases that name axles and have no answer."""
        answered = {self.worst.load_case, *(one.passage.case for one in self.passages)}
        return [name for name in self.cases if name not in answered]

    @cached_property
    def envelope(self) -> pd.DataFrame:
        """One row a position: ``axles``, ``direction``, ``position`` and ``associative``, the load factor
        with associative flow (NaN where it carries any load), which no Coulomb answer exceeds."""
        rows = [
            _place(one.passage, x) | {"associative": value}
            for one in self.passages
            for x, value in zip(one.associative.positions, one.associative.load_factors, strict=True)
        ]
        frame = pd.DataFrame(rows, columns=[*self._case, *_PLACE, "associative"])
        return frame.replace(math.inf, math.nan)

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        return [*self.worst.warning_records, *self._contradictions()]

    def _contradictions(self) -> Iterator[dict[str, Any]]:
        """Yield a warning if the load factor at the worst position is less than its own bound."""
        bounds, found = [one.bound for one in self.passages if one.bound is not None], self.load_factor
        if found is None or not bounds or found >= min(bounds) or same(min(bounds), found):
            return
        values = {"load_factor": found, "bound": min(bounds)}
        less = f"λ = {numeral(found, '.6f')} at the worst position is less than {numeral(min(bounds), '.6f')}"
        sentence = f"{less}, its lower bound by another program: no bound is given; try another solver"
        yield study_warning(StudyCode.BELOW_BOUND, sentence, **values)

    def facts(self) -> dict[str, str]:
        worst, least = self.worst, self.least
        told = {"case": worst.case, "method": worst.method}
        if worst.load_case is not None:
            governs = ", governs" if len(self.by_case) - len(self.not_crossed) > 1 else ""
            told["load case"] = f"'{worst.load_case}'{governs}: {worst.assembly.scene.load_case}"
        if others := [
            f"'{name}' {'none' if least_of is None else numeral(least_of, '.6f')}"
            for name, least_of in self.by_case.items()
            if name not in (worst.load_case, *self.not_crossed)
        ]:
            told["other cases"] = f"least λ {', '.join(others)}"
        if self.left_out:
            told["left out"] = f"{some([*map(repr, self.left_out)])}, without axles: see 'solve'"
        missed = some([*map(repr, self.not_crossed)])
        if least is None:
            told["status"] = f"{worst.status}: {worst.message}"
            return told | ({"not crossed": missed} if missed else {})
        found = "none: any load is carried" if worst.solution.carries_any_load else str(worst.status)
        if worst.load_factor is not None:
            found = f"{numeral(worst.load_factor, '.6f')} ({own_name(worst)})"
        first, *others = (numeral(x, ".6g") for x in self.at)
        passage, group = least.passage, least.passage.axles
        source = f" ({group.group.source})" if group.group.source else ""
        positions, away = counted(len(self.governing), "position"), numeral(self.resolution or 0.0, ".3g")
        told |= {
            "governing λ": found,
            "known of it": certainty(worst),
            "at": f"axles at x = {first}{' (first)' if others else ''}{''.join(f', {x}' for x in others)}",
            "axles": f"'{self.axles}', travelling {self.direction}{source}",
        }
        if group.width:
            told["width"] = f"{passage.across:.4g} of each load: effective width {group.width:g}"
        between = "" if self.bound is not None else "; λ may be less between positions"
        told["solved"] = f"at {positions}; spacing at the worst position {away}{between}"
        if said := self._first_look():
            told["first look"] = said
        if passage.assembly.problem.live.any():
            told["beside them"] = "the scene's other live loads, which λ multiplies too"
        if self.bound is not None:
            law = f", with crushing by the {worst.crushing}" if worst.crushing else ""
            proven = "proven lower bound of the associative load factor along the whole road"
            told["bound"] = f"{numeral(self.bound, '.6f')}: {proven}{law}"
        if self.undecided:
            at = "{position:.6g} ('{axles}', {direction}"
            at += ", in '{load_case}')" if len(self.by_case) > 1 else ")"
            named = some([at.format(**one) for one in self.undecided_at])
            told["undecided"] = f"{counted(self.undecided, 'position')}, at which λ may be less: {named}"
        if self.interrupted:
            not_reached = f", and in load cases not reached: {missed}" if missed else ""
            told["interrupted"] = f"λ may be less at positions that were not solved{not_reached}"
        return told

    def _first_look(self) -> str:
        """Return how the default method's load factor differs at the worst position; "" if it was not run.

        Its load factor is compared with the associative one by its own law of crushing.
        """
        if self.default is None:
            return self.no_default and f"not compared with the default method: {self.no_default}"
        found, associative, law = self.default.load_factor, self.load_factor, ""
        said = f"method '{self.default.method}', the default, finds"
        if self.default.crushing != self.worst.crushing:
            associative = self.default.associative
            law = f", with crushing by {self.default.crushing}"
        if found is None or associative is None:
            return f"{said} there: {self.default.status}"
        less = 1 - found / associative if associative > 0 else 0.0
        much = f"{less:.2%} less than" if less > WITHIN else "the same as"
        compared = f"{much} the associative load factor{' by the same law' if law else ''}"
        at = f"λ = {numeral(found, '.6f')} there{law}"
        return f"{said} {at}: {compared}; at other positions it may find less"

    def as_dict(self) -> dict[str, Any]:
        worst = self.worst.as_dict()
        keys = ("case", "load_case", "method", "model", "solver", "status", "load_factor")
        where = ("axles", "direction", "position", "at", "resolution")
        own = (*where, "bound", "undecided", "undecided_at", "interrupted", "by_case", "left_out")
        told = {key: worst[key] for key in keys} | {key: getattr(self, key) for key in own}
        told["default"] = self.default and self.default.load_factor
        told["default_associative"] = self.default and self.default.associative
        told["warnings"] = self.warning_records
        return told | {"positions": records(self.table), "governing": records(self.told), "worst": worst}

    def plot(self) -> Picture:
        """Draw the load factor over the position of the first axle, and below it, in the same scale, the
        mechanism at the worst, as a matplotlib figure; a notebook shows it. Raises OptionError of a scene
        that does not stand."""
        least, worst = self.least, self.worst
        if least is None:
            raise OptionError(f"{worst.case}: {worst.status}: no axle was moved, none can be drawn")
        passage, heading = least.passage, str(worst.status)
        with style():
            made = Picture()
            bridge = made.add_subplot()
            if worst.load_factor is not None:
                draw_mechanism(worst, bridge)
                where = f"'{self.axles}' at {numeral(least.position, '.4g')}, travelling {self.direction}"
                heading = printable(f"governing {named_factor(worst)} with {where}")
            ends = [*bridge.get_xlim(), *np.concatenate([one.positions for one in self.passages])]
            low, high = min(ends), max(ends)
            bottom, top = bridge.get_ylim()
            arrow = _ARROW * (high - low)
            top = max(top, _axles(bridge, passage, least.position, arrow) + 1.5 * arrow)
            bridge.set(xlim=(low, high), ylim=(bottom, top), xlabel="x, y in the length unit of the case")
            wide = (high - low) / (top - bottom)
            chart: Any = bridge.inset_axes((0.0, 1 + _BETWEEN * wide, 1.0, _HIGH * wide), sharex=bridge)
            self._draw_load_factors(chart, least.position)
            entitle(chart, title_of(worst.assembly.scene), heading)
            finish(made, bridge, chart.get_legend_handles_labels()[0])
        return made

    def _draw_load_factors(self, axes: Axes, position: float) -> None:
        """The least over load cases; behind it several cases, and the associative λ of Coulomb methods."""
        dots: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 7}
        coulomb = self.passages[0].beside is not None
        look = dots if coulomb else {"linewidth": 1.1}
        lines = {"associative": coulomb, "each load case": len(self.by_case) > 1}
        below = [name for name, drawn in lines.items() if drawn]
        ways = self.envelope.groupby([*self._case, "axles", "direction"], sort=False)
        for _, rows in ways if below else ():
            axes.plot(rows["position"], rows["associative"], color=HATCH, linewidth=0.8, zorder=2)
        ways = self.governing.groupby(["axles", "direction"], sort=False)
        for ((axles, direction), rows), colour in zip(ways, cycle(SERIES), strict=False):
            name = printable(f"'{axles}', travelling {direction}")
            axes.plot(rows["position"], rows["load_factor"], color=colour, label=name, zorder=3, **look)
        if below:
            axes.plot([], [], color=HATCH, linewidth=0.8, label=", ".join(below))
        axes.set(xlabel="position of the first axle", ylabel="load factor λ")
        axes.grid(color="#E4E4E4", linewidth=0.6)
        if self.load_factor is not None:
            ring: dict[str, Any] = {"color": MARKED, "markersize": 11, "fillstyle": "none"}
            axes.plot(position, self.load_factor, "o", label="worst", zorder=4, **ring)
            most = 1.1 * float(self.governing["load_factor"].max())
            axes.set_ylim(0.0, min(_SHOWN_UP_TO * self.load_factor, most) or 1.0)

    def save(self, path: str | Path, force: bool = False) -> None:
        """Write the picture (.png, .svg, .pdf), or a page with it, the worst position's result and the table
        (.html), whole or not at all. Raises OptionError if the file's name has another ending, it cannot be
        written or replaced (``force`` replaces what was not written here), or the scene does not stand."""
        save_as(path, force, self._page, self.plot)

    def _page(self) -> str:
        title = title_of(self.worst.assembly.scene)
        parts = {"At the worst position": notebook_html(self.worst)}
        return render("study.html", title=title, answer=self, pictures=self.pictures(), parts=parts)

    def pictures(self) -> dict[str, Picture]:
        return {"λ by the position of the first axle, and the mechanism at the worst": self.plot()}

    def page_tables(self) -> dict[str, dict[str, Any]]:
        rows = frame_table(self.told, position="first axle at", load_case="load case that governs")
        return {f"Every position solved ({len(self.told)})": rows}


def _place(passage: Passage, position: float) -> dict[str, Any]:
    place = (passage.case, passage.axles.name, passage.direction, position)
    return dict(zip(("load_case", *_PLACE), place, strict=True))


def _axles(axes: Axes, passage: Passage, position: float, arrow: float) -> float:
    """Draw the road and the axles on it; the highest point of the road."""
    line = passage.road.line
    axes.plot(*line.T, color=LIVE, linewidth=0.8, zorder=6)
    loads = np.array(passage.axles.group.loads)
    for x, share in zip(position + passage.offsets, loads / loads.max(), strict=True):
        if line[0, 0] <= x <= line[-1, 0]:
            y = float(np.interp(x, *line.T))
            look = {"arrowstyle": "-|>", "color": LIVE, "linewidth": 1.3, "shrinkA": 0, "shrinkB": 0}
            axes.annotate("", (x, y), (x, y + share * arrow), arrowprops=look, zorder=7)
    return float(line[:, 1].max())
