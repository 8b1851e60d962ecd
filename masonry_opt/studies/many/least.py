"""``least`` and ``most``: the least or greatest number with which a scene stands or carries a load."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import brentq

from masonry_opt.analysis import prepare
from masonry_opt.answer.answer import Certificate
from masonry_opt.answer.reasons import Status
from masonry_opt.answer.thresholds import JUMP, LOWER
from masonry_opt.errors import CaseError, NoLoadFactorError, OptionError
from masonry_opt.files import plain
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.problem.assembly import assemble
from masonry_opt.result import Result, distinct_warnings
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.many.runs import columns, framed
from masonry_opt.studies.many.standing import standing
from masonry_opt.studies.runner import whole
from masonry_opt.studies.warning_codes import StudyCode, study_warning
from masonry_opt.studies.writing import StudyAnswer
from masonry_opt.words.load_factors import ASSOCIATIVE, meaning, own_name
from masonry_opt.words.sentences import numeral

#: ``Trial.number`` of a scene without a load factor: it falls by itself, or no load makes it collapse.
FALLS, UNLIMITED = -math.inf, math.inf
_WORDS = {FALLS: "none (it falls by itself)", UNLIMITED: "any"}
_OWN = {"value": "float64", "holds": "bool", "number": "float64"}  #: What a table says of a trial itself.


@dataclass(frozen=True)
class Trial:
    """One value tried."""

    value: float
    holds: bool  #: whether the scene stands, or carries the load
    number: float  #: load factor, or margin under dead load; -inf: the scene falls; inf: it carries any load
    result: Result = field(repr=False)  #: state and mechanism: see :class:`~.standing.DeadLoadMargin`
    certificate: Certificate | None = field(repr=False)  #: residuals of ``number``, where that is finite

    @property
    def name(self) -> str:
        """Name of the load factor ``number``: the associative one if the method found none."""
        return ASSOCIATIVE if self.result.load_factor is None else own_name(self.result)


@dataclass(frozen=True)
class Threshold(StudyAnswer):
    """The least (or the greatest) value of a number at which a scene holds.

    Attributes
    ----------
    least: whether the scene holds from ``value`` upwards; else it holds up to it.
    load: load factor to be carried; None if the scene is to stand under its dead load alone.
    value: the threshold, interpolated between the ends; at a jump the end at which the scene holds.
    holds, fails: the ends, both solved: ``result`` has state and mechanism, ``certificate`` the residuals.
    jump: load factors (margins) at the failing and the holding end, if they differ although the ends do not
        (the mechanism changes, joints lock, or the scene itself changes); else None.
    contradictions: values tried below a least (above a greatest) at which the scene holds too.
    trials: every value tried, in order.
    """

    least: bool
    load: float | None
    value: float
    holds: Trial
    fails: Trial
    jump: tuple[float, float] | None
    contradictions: tuple[float, ...]
    trials: tuple[Trial, ...] = field(repr=False)

    @property
    def interval(self) -> tuple[float, float]:
        """Lower and upper end."""
        return min(self.holds.value, self.fails.value), max(self.holds.value, self.fails.value)

    @property
    def evaluations(self) -> int:
        """Number of scenes solved."""
        return len(self.trials)

    @property
    def history(self) -> pd.DataFrame:
        """One row a trial: ``value``, ``holds``, ``number``, then the columns of ``mo.sweep``."""
        rows = [
            {name: getattr(trial, name) for name in _OWN}
            | columns(trial.result)
            | {"seconds": sum(trial.result.seconds.values())}
            for trial in self.trials
        ]
        return framed(rows, _OWN)

    @property
    def told(self) -> pd.DataFrame:
        return self.history[[*_OWN]]

    @property
    def _kind(self) -> str:
        return "least" if self.least else "greatest"

    @property
    def _measure(self) -> str:
        return "margin" if self.load is None else "load factor"

    def facts(self) -> dict[str, str]:
        does = "stands under its dead load" if self.load is None else f"carries λ = {numeral(self.load, 'g')}"
        told = {
            f"{self._kind} value": f"{numeral(self.value, '.9g')}, at which the scene {does}",
            "holds": self._end(self.holds),
            "fails": self._end(self.fails),
            "scenes solved": str(self.evaluations),
        }
        if named := self._names:
            told["λ is"] = meaning(named)
        if self.jump:
            before, after = (_WORDS.get(number) or numeral(number, ".6g") for number in self.jump)
            told["jump"] = f"the {self._measure} goes from {before} to {after} at once"
        return told

    @property
    def warning_records(self) -> list[dict[str, Any]]:
        told = distinct_warnings([self.holds.result, self.fails.result])
        if not self.contradictions:
            return told
        values = ", ".join(f"{value:.6g}" for value in self.contradictions)
        side = "below" if self.least else "above"
        sentence = f"the scene holds {side} this value too, at {values}: search there by itself"
        beyond = list(self.contradictions)
        return [study_warning(StudyCode.SEVERAL_THRESHOLDS, sentence, values=beyond), *told]

    @property
    def _names(self) -> list[str]:
        """Names of the load factors at the two ends; none where only the dead load acts."""
        if self.load is None:
            return []
        return [end.name for end in (self.holds, self.fails) if math.isfinite(end.number)]

    def _end(self, end: Trial) -> str:
        known = math.isfinite(end.number)
        worst = end.certificate.worst if known and end.certificate else None
        residual = "" if worst is None else f" (largest residual {worst:.0e})"
        # As many digits as make the ends differ, and the failing end differ from the load.
        near = [number for number in (self.holds.number, self.load) if number is not None]
        said = numeral(end.number, _telling(self.fails.number, near, 6)) if known else str(end.result.status)
        value = numeral(end.value, _telling(self.fails.value, [self.holds.value], 9))
        return f"at {value}: {self._measure + ' ' if known else ''}{said}{residual}"

    def as_dict(self) -> dict[str, Any]:
        """All but the results, as plain numbers, strings and lists (not finite: None)."""
        own = ("load", "value", "interval", "jump", "contradictions", "evaluations")
        told = {"kind": self._kind} | {name: getattr(self, name) for name in own}
        told["warnings"] = self.warning_records
        for name, end in {"holds": self.holds, "fails": self.fails}.items():
            told[name] = {"value": end.value, "number": end.number, "status": end.result.status}
            told[name]["certificate"] = end.certificate
        tried = ({name: getattr(trial, name) for name in _OWN} for trial in self.trials)
        return plain(told | {"trials": [*tried]})


def _telling(number: float, others: Sequence[float], least: int) -> str:
    """The format with fewest significant digits, at least ``least``, that tells a number from others."""
    formats = [f".{digits}g" for digits in range(least, 18)]
    told = (form for form in formats if all(f"{number:{form}}" != f"{other:{form}}" for other in others))
    return next(told, formats[-1])


Make = Callable[[float], "Scene | str | Path"]  #: The scene of a number.
Tried = Callable[[Trial], None]  #: Called with every trial.

TOLERANCE = 1e-6  #: Distance of the two ends of the answer, relative to their value.
SAMPLES = 5  #: Values between the ends that are tried before the search: they may show several thresholds.
_OF_RANGE = 1e-3  #: Share of the range to which the tolerance applies at least: the threshold may be zero.
_FINEST = 4 * np.finfo(float).eps  #: Least tolerance that Brent's method takes.
_MOST_STEPS = 1000  #: Most steps of Brent's method; bisecting takes some 30.


def least(
    make: Make,
    lower: float,
    upper: float,
    *,
    load: float | None = None,
    method: str = DEFAULT,
    tolerance: float = TOLERANCE,
    samples: int = SAMPLES,
    progress: Tried = lambda _: None,
    **options: Any,
) -> Threshold:
    """Find the least value of a number at which a scene stands, or carries a load.

    >>> import masonry_opt as mo
    >>> arch = mo.Arch(radius=10, angles=(180, 0), thickness=1, voussoirs=27, unit_weight=1)
    >>> def of(thickness):
    ...     blocks = arch.replace(thickness=thickness).blocks()
    ...     return mo.Scene(joints=mo.JointDefaults(friction=0.7), blocks=blocks)
    >>> round(mo.least(of, 0.5, 3).value, 4)
    1.0678

    Under dead load alone, which is what counts unless ``load`` is given, a scene stands if any state of
    equilibrium within friction exists; below the threshold none exists under any flow rule.

    Raises OptionError if the scene holds, or fails, at both ends, or an argument is wrong; CaseError if a
    scene is wrong (the message begins with the value); NoLoadFactorError if the methods cannot decide whether
    a scene holds.

    Parameters
    ----------
    make: Function of the value (a friction, a thickness, ...) that returns a scene or the path of a case
        file.
    lower, upper: Ends of the search. The scene must fail at ``lower`` and hold at ``upper``.
    load: Load factor to be carried, as ``method`` finds it. Without it live loads are ignored.
    method, **options: As of :func:`~masonry_opt.analysis.solve`, ``model`` and ``solver`` too; only with
        ``load``. ``incremental`` is False unless given: the search asks for λ of the method alone.
    tolerance: Distance of the two ends of the answer, relative to their value.
    samples: Number of evenly spread values tried first. If they show several thresholds, the uppermost is
        taken and the others are in ``contradictions``. Nothing is known between these values.
    progress: Called with every :class:`Trial`.
    """
    return _Search(True, make, load, progress, method, options).threshold(lower, upper, tolerance, samples)


def most(
    make: Make,
    lower: float,
    upper: float,
    *,
    load: float | None = None,
    method: str = DEFAULT,
    tolerance: float = TOLERANCE,
    samples: int = SAMPLES,
    progress: Tried = lambda _: None,
    **options: Any,
) -> Threshold:
    """Find the greatest value of a number (a tilt, an opening) at which a scene stands, or carries a load.

    As :func:`least`, from the other side: the scene must hold at ``lower`` and fail at ``upper``, and of
    several thresholds the lowest is taken.
    """
    return _Search(False, make, load, progress, method, options).threshold(lower, upper, tolerance, samples)


class _Search:
    """The search for one threshold, and the trials so far."""

    def __init__(
        self, least: bool, make: Make, load: float | None, progress: Tried, method: str, options: Any
    ) -> None:
        if load is None and (options or method != DEFAULT):
            named = ", ".join(options) or f"method '{method}'"
            raise OptionError(f"{named}: goes with 'load', such as load=1; dead load alone needs no method")
        self.session = prepare(method, keeps=True, **({"incremental": False} | options))
        if not callable(make):
            needed = "a function of the value, such as lambda t: mo.Scene(...)"
            raise OptionError(f"the scene must be {needed} (found {make!r})")
        self.make, self.progress, self.least = make, progress, least
        self.load = None if load is None else _number("load", load)
        self.asked = self.load or 0.0  #: what a trial's number is to reach: a load factor, or no margin
        self.trials: dict[float, Trial] = {}

    def threshold(self, lower: float, upper: float, tolerance: float, samples: int) -> Threshold:
        lower, upper = _number("lower", lower), _number("upper", upper)
        if not lower < upper:
            raise OptionError(f"lower must be less than upper (found {lower:g} and {upper:g})")
        if not 0 < _number("tolerance", tolerance) < 1:
            raise OptionError(f"tolerance must be between 0 and 1 (found {tolerance!r})")
        tried = np.linspace(lower, upper, whole("samples", samples, 0) + 2)
        for value in dict.fromkeys((lower, upper, *tried[1:-1].tolist())):
            self.at(value)
        # From the end at which the scene should hold.
        row = sorted(self.trials.values(), key=lambda trial: trial.value, reverse=self.least)
        if not row[0].holds or row[-1].holds:
            raise OptionError(self._no_threshold())
        holds, fails = next((near, far) for near, far in pairwise(row) if not far.holds)
        holds, fails = self._narrow(holds, fails, tolerance, _OF_RANGE * (upper - lower))
        jump = self._jump(holds, fails)
        value, above, below = holds.value, holds.number - self.asked, fails.number - self.asked
        if not jump and math.isfinite(above) and math.isfinite(below) and above > 0:
            # Where the line through the ends has the load, or no margin.
            value += above / (above - below) * (fails.value - holds.value)
        trials = tuple(self.trials.values())
        held = sorted(trial.value for trial in trials if trial.holds and trial is not holds)
        beyond = tuple(value for value in held if (value < fails.value) == self.least)
        return Threshold(self.least, self.load, value, holds, fails, jump, beyond, trials)

    def at(self, value: float) -> Trial:
        """Return the trial of a value: its scene, solved."""
        scene = None
        try:
            scene = as_scene(self.make(value))
            scene.refuse_without_case()
            number, certificate, result = self._solved(scene)
        except (CaseError, NoLoadFactorError) as error:
            instead = ""
            if self.load is not None and scene is not None and not _has_live_load(scene):
                instead = "; without 'load' (--load) the search asks whether the scene stands"
            raise type(error)(f"at {value:.9g}: {error}{instead}") from None
        holds = number >= self.asked - LOWER * max(1.0, abs(self.asked))  # but for rounding
        trial = self.trials[value] = Trial(value, holds, number, result, certificate)
        self.progress(trial)
        return trial

    def _solved(self, scene: Scene) -> tuple[float, Certificate | None, Result]:
        if self.load is None:
            return standing(scene)
        result = self.session.solve(scene)
        if result.load_factor is not None:
            number = result.load_factor
        elif result.status is Status.UNSTABLE:
            number = FALLS
        elif result.solution.carries_any_load:
            number = UNLIMITED
        elif result.associative is not None and result.associative < self.load:
            number = result.associative  # which no Coulomb answer exceeds
        else:
            why = f"{result.status}: {result.message}; narrow the range, or name another method"
            raise NoLoadFactorError(f"whether the load is carried could not be decided: {why}")
        return number, result.certificate, result

    def _narrow(self, holds: Trial, fails: Trial, tolerance: float, least_size: float) -> tuple[Trial, Trial]:
        """Bring the ends together, by Brent's method."""
        ends = {True: holds, False: fails}
        size = max(1.0, abs(self.asked))

        def beyond(value: float) -> float:
            trial = self.trials.get(value) or self.at(value)
            ends[trial.holds] = trial
            # Never zero, at which the search would end with one end, nor infinite.
            far = np.clip(abs(trial.number - self.asked), LOWER * size, size)
            return float(far if trial.holds else -far)

        # Ends are then nearer than xtol + rtol |value|.
        of_size, of_value = tolerance / 2 * least_size, max(tolerance / 2, _FINEST)
        brentq(beyond, holds.value, fails.value, xtol=of_size, rtol=of_value, maxiter=_MOST_STEPS)
        return ends[True], ends[False]

    def _jump(self, holds: Trial, fails: Trial) -> tuple[float, float] | None:
        known = [abs(trial.number) for trial in self.trials.values() if math.isfinite(trial.number)]
        if not known or (self.load is None and fails.number == FALLS):
            return None  # only whether it stands is known
        # A scene that falls by itself has no load factor: the load asked for stands in its place.
        before = self.asked if fails.number == FALLS else fails.number
        far = holds.number - before > JUMP * max(known)
        return (fails.number, holds.number) if far else None

    def _no_threshold(self) -> str:
        """Return why there is no threshold, and what may show one.

        The scene does the same at both ends, or holds at the wrong one.
        """
        words = ("falls", "stands") if self.load is None else ("does not carry the load", "carries the load")
        row = sorted(self.trials.values(), key=lambda trial: trial.value)
        low, high = row[0], row[-1]
        does, not_so = words[low.holds], words[not low.holds]
        at = f"the scene {does} at {low.value:g}"
        if low.holds != high.holds:
            other = "'most' (--most)" if self.least else "'least' (the command without --most)"
            return f"{at} and {not_so} at {high.value:g}: ask for {other}"
        if odd := ", ".join(f"{trial.value:.6g}" for trial in row if trial.holds != low.holds):
            return f"{at} and at {high.value:g}, but {not_so} at {odd}: let one end of the range be there"
        tried = f"at {high.value:g} and at all {len(row) - 2} values tried between"
        return f"{at}, {tried}: {', or '.join(self._ways_on(low, high))}"

    def _ways_on(self, low: Trial, high: Trial) -> list[str]:
        """Return what may show a threshold where the scene does the same at all values tried."""
        ways = []
        downwards = low.holds == self.least
        beyond = low.value - (high.value - low.value) if downwards else 2 * high.value - low.value
        if downwards and low.value > 0 >= beyond:
            beyond = low.value / 2
        if self._has_scene(beyond):
            ways.append(
                "begin the range at a smaller value" if downwards else "end the range at a greater value"
            )
        if self.load is None and _has_live_load(as_scene(self.make(low.value))):
            ways.append(
                "give the load factor to be carried, 'load' (--load): live loads do not act without it"
            )
        return [*ways, "try more values between ('samples')"]

    def _has_scene(self, value: float) -> bool:
        """Return True if a scene can be made of a value outside of the range."""
        try:
            assemble(as_scene(self.make(value)))
        except Exception:  # outside of the range a user's function may raise anything
            return False
        return True


def _has_live_load(scene: Scene) -> bool:
    """Return True if a block of a scene carries a live load."""
    return bool(assemble(scene).problem.live_norm)


def _number(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not math.isfinite(value):
        raise OptionError(f"{name} must be a number (found {value!r})")
    return float(value)
