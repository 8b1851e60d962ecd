"""Answer for one scene of a study: the result of a method, or a crossing if axles move over the scene."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from masonry_opt.analysis import Session
from masonry_opt.errors import counted
from masonry_opt.reporting.load_factors import own_name
from masonry_opt.reporting.names import some
from masonry_opt.reporting.sentences import numeral
from masonry_opt.result import Result
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.reasons import Code, Status
from masonry_opt.studies.run_columns import columns
from masonry_opt.studies.warning_codes import StudyCode, study_warning

# The module of crossings imports CVXPY. The import of CVXPY often takes longer than a run, so the module is
# imported only if axles move over a scene.
if TYPE_CHECKING:
    from masonry_opt.studies.crossing.answer import Crossing

#: Reason codes for an analysis that the time limit ended. The last three codes are reasons of method
#: "global".
_ENDED_BY_TIME = (Code.TIME_LIMIT, Code.OUT_OF_TIME, Code.OUT_OF_TIME_WITHIN_IMPOSED, Code.NO_EXACT_STATE)


class SceneAnswer(NamedTuple):
    """Result of a scene and, if axles move over the scene, the answer of the crossing."""

    result: Result  #: result of the scene; for a crossing, the result at the worst position
    crossing: "Crossing | None" = None

    def columns(self) -> dict[str, Any]:
        """Return the values of ANSWER_COLUMNS and, for a crossing, of CROSSING_COLUMNS.

        If the time limit ended the crossing, the status says so, the load factor is that of the worst
        position solved by then, and ``any_load`` is False.
        """
        entries = columns(self.result)
        crossed = self.crossing
        if crossed is None:
            return entries
        # Axles are not moved over a scene that is unstable under its dead load.
        moved = crossed.least is not None
        entries |= crossed.place | {"bound": crossed.bound, "which": self.load_factor_name}
        entries["positions"] = len(crossed.governing) if moved else 0
        entries["undecided_positions"] = crossed.undecided if moved else 0
        if self.stopped:
            stopped = {"status": str(Status.TIME_LIMIT), "reason": str(Code.TIME_LIMIT), "any_load": False}
            entries |= stopped | {"message": self.stopped}
        # Column "at" with the positions of all axles is omitted: the first axle's position determines them.
        del entries["at"]
        return entries

    @property
    def load_factor_name(self) -> str:
        """Name of the load factor of the scene or of the crossing; "" if there is no load factor."""
        if self.result.load_factor is None:
            return ""
        return own_name(self.result) if self.crossing is None else self.crossing.load_factor_name

    @property
    def time_limit_reached(self) -> bool:
        """True if the time limit ended the analysis or the crossing. More time may change the answer."""
        if self.crossing is not None and self.crossing.time_limit_reached:
            return True
        return any(self.result.solution.has(code) for code in _ENDED_BY_TIME)

    @property
    def stopped(self) -> str:
        """Sentence which says that the time limit ended the crossing; empty if all positions were solved."""
        if self.crossing is None or self.crossing.time_limit is None:
            return ""
        return (
            f"the time limit of {self.crossing.time_limit:g} s ended the crossing, and λ may be less at "
            "positions that were not solved: raise the time limit"
        )

    @property
    def place(self) -> str:
        """Text with the worst position of the axles, such as "'bogie' at -0.27, travelling right"."""
        crossed = self.crossing
        if crossed is None or crossed.position is None:
            return ""
        return place_text(crossed.axles, crossed.position, crossed.direction, self.result.load_case)

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        """Warnings of the answer, as records for JSON output."""
        if self.crossing is None:
            return self.result.warning_records
        records = [*self.crossing.warning_records, *_warnings_of_crossing(self.crossing)]
        if self.stopped:
            seconds = self.crossing.time_limit
            records.append(study_warning(StudyCode.CROSSING_STOPPED, self.stopped, seconds=seconds))
        return records


def place_text(axles: object, position: float, direction: object, load_case: object) -> str:
    """Return the position of axles as text, with the name of the load case if there is one.

    The load case is a name, None, or NaN in a table of runs of which some were refused.
    """
    text = f"'{axles}' at {numeral(position, '.6g')}, travelling {direction}"
    return f"{text}, in load case '{load_case}'" if isinstance(load_case, str) else text


def solve_or_cross(session: Session, scene: Scene) -> SceneAnswer:
    """Solve a scene; if axles are among its live loads, move the axles over the scene.

    The axles cross in all load cases that have axles, unless a load case of the scene is chosen already. At
    the time limit, the answer is the worst position solved by then.

    Raises KeyboardInterrupt if the user interrupts a crossing, and the errors of ``mo.solve`` and
    ``mo.crossing``.
    """
    if not scene.moves_axles:
        return SceneAnswer(session.solve(scene))
    from masonry_opt.studies.crossing.crossing import cross

    crossed = cross(session, scene)
    if crossed.interrupted and not crossed.time_limit_reached:
        raise KeyboardInterrupt
    return SceneAnswer(crossed.worst, crossed)


def _warnings_of_crossing(crossed: "Crossing") -> Iterator[dict[str, Any]]:
    """Generate warnings about undecided positions, and about load cases in which no axles move."""
    if crossed.least is not None and crossed.undecided:
        count, first = crossed.undecided, crossed.undecided_at[0]["position"]
        place = f"first axle at {numeral(first, '.6g')}" + (" and elsewhere" if count > 1 else "")
        sentence = (
            "the least λ is uncertain, because λ could not be computed at "
            f"{counted(count, 'position')} of the axles: {place}"
        )
        yield study_warning(StudyCode.POSITIONS_UNDECIDED, sentence, count=count, positions=[first])
    if crossed.left_out:
        cases = some([*map(repr, crossed.left_out)])
        sentence = f"load cases without axles are left out ({cases}): use --load-case NAME to study one"
        yield study_warning(StudyCode.CASES_WITHOUT_AXLES, sentence, cases=list(crossed.left_out))
