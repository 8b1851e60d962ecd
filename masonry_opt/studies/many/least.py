"""Functions ``least`` and ``most``: the threshold of a number at which a scene is stable or carries a load.

Evenly spread values are tried first. Brent's method then narrows the interval between two neighbouring
values, one at which the scene holds and one at which it fails.
"""

import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from masonry_opt.analysis import prepare
from masonry_opt.effort import ignore_progress
from masonry_opt.errors import CaseError, NoLoadFactorError, OptionError, TimeLimitError
from masonry_opt.methods.registry import DEFAULT
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.load_factor_scale import RELATIVE_ROUNDING
from masonry_opt.result import distinct_warnings
from masonry_opt.scene.case_file import as_scene
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.answer import Certificate
from masonry_opt.solution.reasons import Status
from masonry_opt.studies.many.jumps import jump_between
from masonry_opt.studies.many.scene_answer import SceneAnswer, solve_or_cross
from masonry_opt.studies.many.standing import standing
from masonry_opt.studies.many.threshold import Threshold
from masonry_opt.studies.many.trial import FALLS, UNLIMITED, Trial
from masonry_opt.studies.runner import whole

#: Function that returns the scene for a value of the varied parameter.
Make = Callable[[float], "Scene | str | Path"]
Tried = Callable[[Trial], None]  #: Type of a function that is called with every trial.

#: Default width of the interval that contains the threshold, as a fraction of the threshold.
THRESHOLD_TOLERANCE = 1e-6
#: Default number of evenly spread values, between the ends of the range, that are tried before the search.
SAMPLES = 5
#: The search ends when its interval is narrower than the tolerance times the threshold. If the threshold is
#: below this fraction of the searched range, the fraction of the range replaces the threshold.
_LEAST_SCALE = 1e-3
_LEAST_RTOL = 4 * np.finfo(float).eps  #: Least relative tolerance that Brent's method accepts.
#: Largest number of iterations of Brent's method. With the default tolerance, bisection alone needs about 30.
_MOST_ITERATIONS = 1000


def least(  # noqa: PLR0913 - options of the public API are keywords
    make: Make,
    lower: float,
    upper: float,
    *,
    load: float | None = None,
    method: str = DEFAULT,
    tolerance: float = THRESHOLD_TOLERANCE,
    samples: int = SAMPLES,
    progress: Tried = ignore_progress,
    **options: Any,
) -> Threshold:
    """Find the least value of a parameter at which a scene is stable, or carries a required load.

    >>> import masonry_opt as mo
    >>> arch = mo.Arch(radius=10, angles=(180, 0), thickness=1, voussoirs=27, unit_weight=1)
    >>> def of(thickness):
    ...     blocks = arch.replace(thickness=thickness).blocks()
    ...     return mo.Scene(joints=mo.JointDefaults(friction=0.7), blocks=blocks)
    >>> round(mo.least(of, 0.5, 3).value, 4)
    1.0678

    Without ``load`` the scene is examined under its dead load alone. It is stable if a state of equilibrium
    with admissible forces exists, unless these forces are self-stress between wedged blocks, which does not
    arise from rest.

    Parameters
    ----------
    make: Function of the value (a friction, a thickness, ...) that returns a scene or the path of a case
        file.
    lower, upper: Ends of the searched range. The scene must fail at ``lower`` and hold at ``upper``.
    load: Load factor that the scene must carry, computed with the given method. If None, live loads are
        ignored.
    method, **options: As for :func:`~masonry_opt.solve`, with ``model`` and ``solver``; only with
        ``load``. ``incremental`` is False by default, because only λ of the method is needed.
    tolerance: Width of the final interval that contains the threshold, relative to the threshold.
    samples: Number of evenly spread values that are tried first. If they show several thresholds, the answer
        is the uppermost, and ``contradictions`` has the others. Thresholds between the values are not found.
    progress: Function called with every :class:`~masonry_opt.studies.many.trial.Trial`.

    Returns
    -------
    Threshold
        The threshold, both ends of its interval, and all trials.

    Raises
    ------
    OptionError
        If the scene holds, or fails, at both ends, or an argument is wrong.
    CaseError
        If a scene is wrong. The message begins with the value.
    NoLoadFactorError
        If the methods cannot decide whether a scene holds.
    """
    return _Search(True, make, load, progress, method, options).threshold(lower, upper, tolerance, samples)


def most(  # noqa: PLR0913 - options of the public API are keywords
    make: Make,
    lower: float,
    upper: float,
    *,
    load: float | None = None,
    method: str = DEFAULT,
    tolerance: float = THRESHOLD_TOLERANCE,
    samples: int = SAMPLES,
    progress: Tried = ignore_progress,
    **options: Any,
) -> Threshold:
    """Find the greatest value of a parameter at which a scene is stable, or carries a required load.

    Parameters
    ----------
    make, load, method, tolerance, progress, **options: As in :func:`least`.
    lower, upper: Ends of the searched range. The scene must hold at ``lower`` and fail at ``upper``.
    samples: As in :func:`least`. If there are several thresholds, the answer is the lowest.

    Returns
    -------
    Threshold
        The threshold, both ends of its interval, and all trials.

    Raises
    ------
    OptionError
        As in :func:`least`.
    CaseError
        As in :func:`least`.
    NoLoadFactorError
        As in :func:`least`.
    """
    return _Search(False, make, load, progress, method, options).threshold(lower, upper, tolerance, samples)


class _Search:
    """Search for the threshold of a parameter, with a record of all solved scenes (trials)."""

    def __init__(
        self, is_least: bool, make: Make, load: float | None, progress: Tried, method: str, options: Any
    ) -> None:
        if load is None and (options or method != DEFAULT):
            # Check the arguments first, so that an error about a misspelt argument suggests the correct name.
            prepare(method, function=least, **options)
            named = ", ".join(options) or f"method '{method}'"
            raise OptionError(
                f"{named}: give a required load factor too with 'load' (--load), such as 1, because the "
                "search without 'load' tests only stability under the dead load"
            )
        self.session = prepare(method, function=least, keeps=True, **({"incremental": False} | options))
        if not callable(make):
            raise OptionError(
                "the scene must be a function that returns a scene for a value, such as lambda t: "
                f"mo.Scene(...) (found {make!r})"
            )
        self.make, self.progress, self.least = make, progress, is_least
        self.load = None if load is None else _number("load", load)
        #: Number that a trial must reach, up to rounding errors: the load factor ``load`` or, if ``load`` is
        #: None, a margin of stability of zero.
        self.required = self.load or 0.0
        self.trials: dict[float, Trial] = {}  #: by value

    def threshold(self, lower: float, upper: float, tolerance: float, samples: int) -> Threshold:
        """Return the threshold of the parameter between ``lower`` and ``upper``; see :func:`least`."""
        lower, upper = _number("lower", lower), _number("upper", upper)
        if not lower < upper:
            raise OptionError(f"lower must be less than upper (found {lower:g} and {upper:g})")
        if not 0 < _number("tolerance", tolerance) < 1:
            raise OptionError(f"tolerance must be between 0 and 1 (found {tolerance!r})")
        values = np.linspace(lower, upper, whole("samples", samples, 0) + 2)
        for value in dict.fromkeys((lower, upper, *values[1:-1].tolist())):
            self.at(value)
        # Sort the trials by value, in descending order for ``least``, and in ascending order for ``most``.
        # The scene should then meet the requirement in the first trial, and fail in the last.
        row = sorted(self.trials.values(), key=lambda trial: trial.value, reverse=self.least)
        if not row[0].holds or row[-1].holds:
            warnings = distinct_warnings([row[0].answer, row[-1].answer])
            raise OptionError(self._no_threshold(), [record["sentence"] for record in warnings])
        holds, fails = next((near, far) for near, far in pairwise(row) if not far.holds)
        holds, fails = self._narrow(holds, fails, tolerance, _LEAST_SCALE * (upper - lower))
        jump = jump_between(holds, fails, self.trials.values(), self.load)
        value, above, below = holds.value, holds.number - self.required, fails.number - self.required
        if not jump and math.isfinite(above) and math.isfinite(below) and above > 0:
            # Interpolate the threshold linearly between both ends of the interval.
            value += above / (above - below) * (fails.value - holds.value)
        trials = tuple(self.trials.values())
        holding_values = sorted(trial.value for trial in trials if trial.holds and trial is not holds)
        contradictions = tuple(holding for holding in holding_values if (holding < fails.value) == self.least)
        return Threshold(self.least, self.load, value, holds, fails, jump, contradictions, trials)

    def at(self, value: float) -> Trial:
        """Solve the scene for a value of the parameter; record and return the trial."""
        scene = None
        try:
            scene = as_scene(self.make(value))
            number, certificate, answer = self._solved(scene)
        except (CaseError, NoLoadFactorError, TimeLimitError) as error:
            remedy = ""
            if self.load is not None and scene is not None and not _has_live_load(scene):
                remedy = "; without 'load' (--load) the search tests stability under dead load only"
            raise type(error)(f"at {value:.9g}: {error.message}{remedy}", error.warnings) from None
        rounding = RELATIVE_ROUNDING * max(1.0, abs(self.required))
        holds = number >= self.required - rounding
        trial = self.trials[value] = Trial(value, holds, number, answer, certificate)
        self.progress(trial)
        return trial

    def _solved(self, scene: Scene) -> tuple[float, Certificate | None, SceneAnswer]:
        """Solve the scene, and return its load factor, its certificate, and the answer that contains both.

        Under dead load alone, the margin of stability replaces the load factor.
        Axles move over the scene, unless only its dead load is examined. If the method finds no load factor,
        the first value is -inf if the scene is unstable, inf if it carries any load, and the associative load
        factor if that is below the load. NoLoadFactorError is raised otherwise, and if the time limit ended
        the crossing before a load factor below the load was found.
        """
        if self.load is None:
            scene.refuse_without_case()
            last = next(reversed(self.trials.values()), None)
            margin = standing(scene, None if last is None else last.result.assembly)
            return margin.margin, margin.certificate, SceneAnswer(margin.result)
        answer = solve_or_cross(self.session, scene)
        result = answer.result
        if result.load_factor is not None:
            number = result.load_factor
        elif result.status is Status.UNSTABLE:
            number = FALLS
        elif result.solution.carries_any_load:
            number = UNLIMITED
        elif result.associative is not None and result.associative < self.load:
            # The associative load factor is an upper bound on all Coulomb load factors. Here it is less than
            # the required load factor ``load``, so the scene does not carry the load.
            number = result.associative
        else:
            raise NoLoadFactorError(
                "it could not be decided whether the load is carried: narrow the range, or choose another "
                f"method ({result.status}: {result.message})",
                result.warning_sentences,
            )
        if answer.stopped and number >= self.load:
            raise NoLoadFactorError(
                f"it could not be decided whether the load is carried: {answer.stopped}",
                result.warning_sentences,
            )
        return number, result.certificate, answer

    def _narrow(self, holds: Trial, fails: Trial, tolerance: float, least_size: float) -> tuple[Trial, Trial]:
        """Narrow the interval by Brent's method, and return the two trials at its ends.

        The scene carries the required load in the first trial, but not in the second. The distance between
        the ends is then below the tolerance times the larger of ``least_size`` and the value.
        """
        ends = {True: holds, False: fails}
        size = max(1.0, abs(self.required))

        def excess(value: float) -> float:
            """Return a positive number if the scene holds at ``value``, otherwise a negative number.

            Its absolute value is the difference between ``Trial.number`` and ``required``, clipped so that it
            is neither zero nor infinite.
            """
            trial = self.trials.get(value) or self.at(value)
            ends[trial.holds] = trial
            # Brent's method needs finite numbers. It would stop at a difference of zero, and only one end of
            # the interval would then be known.
            distance = float(np.clip(abs(trial.number - self.required), RELATIVE_ROUNDING * size, size))
            return distance if trial.holds else -distance

        # Brent's method stops when the distance of the ends of its interval is below xtol + rtol |value|.
        xtol, rtol = tolerance / 2 * least_size, max(tolerance / 2, _LEAST_RTOL)
        brentq(excess, holds.value, fails.value, xtol=xtol, rtol=rtol, maxiter=_MOST_ITERATIONS)
        return ends[True], ends[False]

    def _no_threshold(self) -> str:
        """Return the message that no threshold was found in the range, with advice."""
        words = (
            ("is unstable", "is stable")
            if self.load is None
            else ("does not carry the load", "carries the load")
        )
        row = sorted(self.trials.values(), key=lambda trial: trial.value)
        low, high = row[0], row[-1]
        does, not_so = words[low.holds], words[not low.holds]
        at = f"the scene {does} at {low.value:g}"
        if low.holds != high.holds:
            function = "'most' (--most)" if self.least else "'least' (the command without --most)"
            return f"{at} and {not_so} at {high.value:g}: use {function}"
        exceptions = ", ".join(f"{trial.value:.6g}" for trial in row if trial.holds != low.holds)
        if exceptions:
            return (
                f"{at} and at {high.value:g}, but {not_so} at {exceptions}: end or begin the range at one of "
                "these values"
            )
        remedies, count = ", or ".join(self._remedies(low, high)), len(row) - 2
        return (
            f"no threshold was found, because all trials agree ({at}, at {high.value:g} and at all {count} "
            f"intermediate values): {remedies}"
        )

    def _remedies(self, low: Trial, high: Trial) -> list[str]:
        """Return advice on how to find a threshold if all trials have the same outcome.

        ``low`` and ``high`` are the trials at the ends of the range.
        """
        remedies = []
        downwards = low.holds == self.least
        beyond = low.value - (high.value - low.value) if downwards else 2 * high.value - low.value
        if downwards and low.value > 0 >= beyond:
            beyond = low.value / 2
        if self._has_scene(beyond):
            end = "begin the range at a smaller value" if downwards else "end the range at a greater value"
            remedies.append(end)
        if self.load is None and _has_live_load(as_scene(self.make(low.value))):
            remedies.append(
                "set 'load' (--load) to the load factor to be carried: without 'load', live loads are ignored"
            )
        return [*remedies, "try more intermediate values ('samples')"]

    def _has_scene(self, value: float) -> bool:
        """Return True if the user's function makes a valid scene for a value outside of the range."""
        try:
            assemble(as_scene(self.make(value)))
        except Exception:  # for a value outside of the range, the user's function may raise any exception
            return False
        return True


def _has_live_load(scene: Scene) -> bool:
    """Return True if a block of a scene carries a live load, or axles move over the scene."""
    return scene.moves_axles or bool(assemble(scene).problem.live_norm)


def _number(name: str, value: object) -> float:
    """Check that an argument is a finite number, and return it as a float.

    Raises OptionError, with the name of the argument, for any other value.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not math.isfinite(value):
        raise OptionError(f"{name} must be a number (found {value!r})")
    return float(value)
