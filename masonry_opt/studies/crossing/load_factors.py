"""Load factors of a crossing: the worst position, its load factor, and tables by position."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.problem.load_factor_scale import LoadFactorScale
from masonry_opt.reporting.load_factors import LEAST, LEAST_AT_POSITION, LEAST_SO_FAR, own_name
from masonry_opt.result import Result
from masonry_opt.solution.solution import Solution
from masonry_opt.studies.crossing.search import Passage, PassageTrials
from masonry_opt.studies.run_columns import columns, framed
from masonry_opt.studies.writing import records

PLACE_COLUMNS = ["axles", "direction", "position"]  #: Columns that identify a position.

#: Texts and tables show a position as zero if its magnitude is at most this fraction of the road's length.
_ZERO_POSITION = 1e-6


@dataclass(frozen=True, kw_only=True)
class CrossingLoadFactors:
    """Load factors of a scene that axles cross: base class of :class:`~.answer.Crossing`."""

    worst: Result
    passages: tuple[PassageTrials, ...] = field(repr=False)
    interrupted: bool = False
    time_limit: float | None = None
    cases: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    default: Result | None = field(default=None, repr=False)
    no_default: str = field(default="", repr=False)
    by_parabola: float | None = field(default=None, repr=False)
    no_parabola: str = field(default="", repr=False)
    required_factor: float | None = None

    @property
    def load_factor(self) -> float | None:
        """Least load factor of all positions; None if no position has a load factor."""
        return self.worst.load_factor

    @property
    def load_factor_scale(self) -> LoadFactorScale:
        """Scale on which load factors of the positions are compared: the scale of the worst position."""
        return self.worst.assembly.problem.load_factor_scale

    @property
    def load_factor_name(self) -> str:
        """Name of the load factor, such as "lowest found", which states how much is proven about it.

        - If the crossing ended early, the name is ``LEAST_SO_FAR``.
        - If the load factor is proven to be the least at the worst position, but no lower bound along the
          road is known, the name is ``LEAST_AT_POSITION``.
        - Otherwise it is the name of the load factor at the worst position.
        """
        if self.interrupted:
            return LEAST_SO_FAR
        name = own_name(self.worst)
        return LEAST_AT_POSITION if name == LEAST and self.bound is None else name

    def required(self) -> float:
        """Return the least load factor.

        Returns
        -------
        float
            The least λ of all positions.

        Raises
        ------
        NoLoadFactorError
            If no position has a load factor.
        """
        return self.worst.required()

    @property
    def time_limit_reached(self) -> bool:
        """True if the time limit ended the crossing: λ may be less at other positions."""
        return self.time_limit is not None

    @property
    def least(self) -> PassageTrials | None:
        """Answers at all solved positions of the passage in which λ is least.

        A passage is one group of axles that travels in one direction, in one load case. The value is None if
        the scene may be unstable under its dead load.
        """
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
    def axle_loads(self) -> list[float]:
        """Load of each axle at λ = 1 in the governing group of axles, beginning with the first axle.

        The loads include the factor of the group and the factor of the load case. They act on the effective
        width, of which the scene carries a fraction.
        """
        if self.least is None:
            return []
        passage = self.least.passage
        return [passage.case_factor * load for load in passage.axles.group.loads]

    @property
    def capacity(self) -> list[float]:
        """Load of each axle at collapse: λ times ``axle_loads``.

        It is empty if no position has a load factor. It is also empty if the crossing ended early, because
        the axles may collapse the scene under smaller loads at positions that were not solved.
        """
        load_factor = self.load_factor
        if load_factor is None or self.interrupted:
            return []
        return [load_factor * load for load in self.axle_loads]

    @property
    def uniform_loads(self) -> list[float]:
        """Uniform loads per unit length at λ = 1 in the governing group of axles.

        The loads include the factor of the group and the factor of the load case.
        """
        if self.least is None:
            return []
        passage = self.least.passage
        return (passage.case_factor * passage.strips[:, 0]).tolist()

    @property
    def uniform_at(self) -> list[list[float]]:
        """Abscissae of the left and right end of each uniform load at the worst position."""
        return (self.least.position + self.least.passage.strips[:, 1:]).tolist() if self.least else []

    @property
    def place(self) -> dict[str, Any]:
        """Worst position, as a dict.

        The keys are ``load_case``, ``axles``, ``direction``, ``position`` and ``at``.
        """
        names = ("axles", "direction", "position", "at")
        return {"load_case": self.worst.load_case} | {name: getattr(self, name) for name in names}

    @property
    def resolution(self) -> float | None:
        """Distance from the worst position to the farther of the two solved positions next to it."""
        return self.least.resolution if self.least else None

    @property
    def bound(self) -> float | None:
        """Proven lower bound on the associative load factor at all positions; None if nothing is proven.

        The value is also None if the load factor is less than the bound; a warning then reports this
        contradiction. Joints of limited strength crush by the law of ``worst.crushing``. The default method
        uses chords inside the parabola, so its load factors may be lower than a bound for the parabola.
        """
        bounds = [trials.bound for trials in self.passages if trials.bound is not None]
        if self.interrupted or not bounds or len(bounds) < len(self.passages):
            return None
        bound, least = min(bounds), self.load_factor
        if least is None or least >= bound:
            return bound
        # If only a rounding error makes λ at the worst position less than the bound, λ itself is returned as
        # the bound.
        return least if self.load_factor_scale.equal(bound, least) else None

    @property
    def undecided(self) -> int:
        """Number of undecided positions: λ is not known, and it is not proven that λ is unlimited."""
        return len({tuple(row[name] for name in PLACE_COLUMNS) for row in self.undecided_at})

    @property
    def undecided_at(self) -> list[dict[str, Any]]:
        """Records of the undecided positions: axles, direction, position, and the load case (if any)."""
        unknown = self.table["load_factor"].isna() & ~self.table["any_load"].astype(bool)
        return records(self.table.loc[unknown, [*self._case, *PLACE_COLUMNS]])

    def printed_positions(self, positions: Sequence[float]) -> list[float]:
        """Return positions for output: a position that differs from zero by a rounding error becomes zero."""
        length = max((float(np.ptp(trials.passage.road.breaks)) for trials in self.passages), default=0.0)
        return [0.0 if abs(x) <= _ZERO_POSITION * length else float(x) for x in positions]

    @property
    def _case(self) -> list[str]:
        """Name of the table column of load cases, as a list; an empty list if the scene has no load cases."""
        return ["load_case"] if self.cases else []

    @cached_property
    def table(self) -> pd.DataFrame:
        """Table of all answers of the method, with one row for each position and load case.

        The columns are ``load_case`` (if any), ``axles``, ``direction``, ``position`` (abscissa of the first
        axle), then the columns of ``mo.sweep`` without ``seconds``. At a jump of the loads there is a row for
        each side of the jump.
        """
        rows = []
        for trials in self.passages:
            for position, solution in sorted(trials.answers.items()):
                result = self._result_at(trials.passage, position, solution)
                rows.append(_place(trials.passage, position) | columns(result))
        place_types = dict.fromkeys([*self._case, *PLACE_COLUMNS], "object") | {"position": "float64"}
        return framed(rows, place_types).drop(columns="seconds")

    def _result_at(self, passage: Passage, position: float, solution: Solution) -> Result:
        """Convert the solution for a position of the first axle to a result."""
        return replace(self.worst, assembly=passage.loaded(passage.live(position)), solution=solution)

    @cached_property
    def governing(self) -> pd.DataFrame:
        """Table with the least load factor of all load cases at each position.

        If no load case has a load factor, ``load_case`` is None. If a load case is undecided, the row then
        has the status of this load case.
        """
        least = self.table.sort_values(["load_factor", "any_load"]).drop_duplicates(PLACE_COLUMNS)
        rows = self.table[PLACE_COLUMNS].drop_duplicates().merge(least, how="left")
        known = rows["load_factor"].notna()
        return rows.assign(**{name: rows[name].where(known, None) for name in self._case})

    @property
    def by_case(self) -> dict[str, float | None]:
        """Least load factor of each load case with axles, by name of the load case.

        It is None if no position has a load factor.
        """
        known = self.table.dropna(subset="load_factor")
        least = known.groupby("load_case")["load_factor"].min().to_dict() if self._case else {}
        return {name: least.get(name) for name in self.cases}

    @property
    def not_crossed(self) -> list[str]:
        """Names of the load cases that have axles but no answer."""
        answered = {self.worst.load_case, *(trials.passage.case for trials in self.passages)}
        return [name for name in self.cases if name not in answered]

    @cached_property
    def envelope(self) -> pd.DataFrame:
        """Table of associative load factors, which are upper bounds on λ, by position and load case.

        The columns are ``load_case`` (if any), ``axles``, ``direction``, ``position`` and ``associative``.
        The load factor is NaN at positions at which the scene carries any load.
        """
        rows = []
        for trials in self.passages:
            bounds = trials.associative
            for x, value in zip(bounds.positions, bounds.load_factors, strict=True):
                rows.append(_place(trials.passage, x) | {"associative": value})
        frame = pd.DataFrame(rows, columns=[*self._case, *PLACE_COLUMNS, "associative"])
        return frame.replace(math.inf, math.nan)


def _place(passage: Passage, position: float) -> dict[str, Any]:
    """Return the columns of a table row that identify a position."""
    place = (passage.case, passage.axles.name, passage.direction, position)
    return dict(zip(("load_case", *PLACE_COLUMNS), place, strict=True))
