"""Kinematic checks of local mechanisms by the Italian building codes NTC 2008 and NTC 2018.

The checks of NTC 2008 are those of Circolare 617/2009, C8A.4.2.2 and C8A.4.2.3. The checks of NTC 2018 are
those of Circolare 7/2019, C8.7.1.2.1.7 and C8.7.1.2.1.8. Both codes have equal formulas for the participating
mass and for the equivalent oscillator.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from masonry_opt.brief import brief
from masonry_opt.errors import OptionError
from masonry_opt.finite_motion.struts import StrutPath
from masonry_opt.problem.limited_forces import Role
from masonry_opt.reporting.names import labelled, warning_lines
from masonry_opt.reporting.sentences import numeral, sentences
from masonry_opt.result import Result
from masonry_opt.scene.typical_sizes import GRAVITY, GRAVITY_BY_UNIT, LARGEST_SCENE, SMALLEST_SCENE
from masonry_opt.solution.motion import moving_blocks
from masonry_opt.solution.reasons import Code, Reason, reason

#: Confidence factor FC of the lowest level of knowledge. NTC 2008 and NTC 2018 require this value if the
#: strength of masonry is neglected.
CONFIDENCE_FACTOR = 1.35
#: If a rocking block is higher than this value, in metres, a warning says that the unit of length is
#: doubtful. The highest brick towers are about 112 m high. With a smaller value, there would be warnings
#: about towers that rock as a whole. With a larger value, fewer of the walls that are drawn in centimetres
#: would cause a warning.
_HIGHEST_ROCKING_BLOCK = 120.0
#: The unit of length is recognised from the gravitational acceleration of a check: 9.81 implies metres, and
#: 981 implies centimetres. The acceleration may differ from such a number by at most this fraction.
_GRAVITY_TOLERANCE = 0.01
#: A change of the length of a tie or prop is reported if it exceeds this fraction of the length at rest.
#: Smaller changes are rounding errors.
_LEAST_STRUT_CHANGE = 1e-9


@dataclass(frozen=True)
class CodeRules:
    """Parameters of the kinematic check in one building code and limit state."""

    ultimate: float  #: ultimate displacement d*_u, as a fraction of the displacement d*_0 at λ = 0
    secant: float  #: displacement d*_s that defines the secant period, as a fraction of d*_u
    period: float  #: factor k in the secant period T_s = k √(d*_s / a*_s); a*_s is the acceleration at d*_s
    has_linear: bool  #: True if the building code has a linear check in this limit state
    #: True if the demand is the largest spectral displacement up to the secant period. False if the demand is
    #: the spectral displacement at the secant period.
    is_largest_demand: bool


#: Parameters of each building code and limit state. SLV is life safety, SLC is collapse prevention.
CODES = {
    "NTC 2008": CodeRules(0.4, 0.4, 2 * math.pi, has_linear=True, is_largest_demand=False),
    "NTC 2018 SLV": CodeRules(0.4, 1.0, 1.68 * math.pi, has_linear=True, is_largest_demand=True),
    "NTC 2018 SLC": CodeRules(0.6, 1.0, 1.56 * math.pi, has_linear=False, is_largest_demand=True),
}


@dataclass(frozen=True)
class CheckedCurve:
    """Capacity curve with all values that a kinematic check needs."""

    weights: np.ndarray  #: weights P of the moving masses, equal to their live forces, shape (f,)
    #: Virtual displacement δ of the point of action of each force P, in the direction of the force, when the
    #: collapse begins, shape (f,).
    rates: np.ndarray
    control_rate: float  #: virtual displacement δ_k of the control point when the collapse begins
    states: np.ndarray  #: columns d_k and λ of the curve, shape (states, 2)
    complete: bool  #: True if the curve reaches λ = 0
    extent: float  #: largest dimension of the box around all movable blocks
    struts: Sequence[StrutPath]  #: lengths of all ties and props along the curve
    rests_on: str  #: text that states the load factor at the onset of collapse and its certainty


@dataclass(frozen=True)
class StrutChange:
    """Largest extension of a tie, or shortening of a prop, up to the ultimate displacement of a mechanism."""

    role: str  #: "tie" or "prop"
    name: str  #: name of the tie or prop
    change: float  #: extension of the tie or shortening of the prop, in the case's unit of length
    share: float  #: change divided by the length at rest

    def __str__(self) -> str:
        verb = "lengthen" if self.role == Role.TIE else "shorten"
        size = f"{numeral(self.change, '.4g')} ({100 * self.share:.2g} % of its length)"
        return f"{self.role} '{self.name}' must {verb} by {size}"


@dataclass(frozen=True)
class KinematicCheck:
    """Results of kinematic checks, which compare the capacity of a mechanism with the demand of a spectrum.

    The symbols are those of the building code. P are the forces, and δ are the virtual displacements of their
    points of action when the collapse begins. The control point has the displacement d_k and the virtual
    displacement δ_k.

    Attributes
    ----------
    code: Name of the building code and its limit state: "NTC 2008", "NTC 2018 SLV" or "NTC 2018 SLC".
    mass_fraction: Participating mass fraction e* = (Σ P δ)² / (Σ P Σ P δ²) of the blocks that move.
    mass: Participating mass M* = e* Σ P / g, in the case's unit of force over the unit of ``gravity``.
    onset: Acceleration a_0 = λ of the masses at which the mechanism is activated, in g.
    acceleration: Spectral acceleration a*_0 = λ g / (e* FC) at which the mechanism is activated, in g.
    displacement: Displacement d*_0 of the equivalent oscillator at λ = 0, or at the end of a curve that ends
        earlier, with d* = d_k Σ P δ² / (δ_k Σ P δ).
    complete: True if the curve reaches λ = 0; otherwise ``displacement`` is less than d*_0.
    ultimate: Ultimate displacement d*_u, a fraction of d*_0.
    secant, secant_acceleration: Point (d*_s, a*_s) of the curve, with a*_s in g.
    period: Secant period T_s in seconds: √(d*_s / a*_s) times 2π, in NTC 2018 times 1.68π (SLV) or 1.56π
        (SLC).
    demand_acceleration: Demand S_e(0) / q of the linear check, in g. None if the code has no linear check in
        this limit state.
    demand_displacement: Demand S_e(T_s) (T_s / 2π)² of the non-linear check, in the case's unit of length. In
        NTC 2018, it is the largest value for periods up to T_s.
    linear: True if the linear check is satisfied: ``acceleration`` is at least ``demand_acceleration``. None
        without a linear check.
    non_linear: True if the non-linear check is satisfied: ``ultimate`` is at least ``demand_displacement``.
    rests_on: Text that states the load factor λ at the onset of collapse and its certainty. Both checks
        depend on this load factor.
    gravity: Gravitational acceleration of the check, in the case's unit of length per s².
    struts: Ties that must lengthen and props that must shorten until d*_u is reached, with the largest change
        of each. The check does not verify that they can.
    warnings: Warning that the gravitational acceleration belongs to another unit of length; else empty.
    """

    code: str
    mass_fraction: float
    mass: float
    onset: float
    acceleration: float
    displacement: float
    complete: bool
    ultimate: float
    secant: float
    secant_acceleration: float
    period: float
    demand_acceleration: float | None
    demand_displacement: float
    linear: bool | None
    non_linear: bool
    rests_on: str
    gravity: float
    struts: tuple[StrutChange, ...]
    warnings: tuple[Reason, ...]

    __repr__ = brief

    @property
    def warning_sentences(self) -> tuple[str, ...]:
        """Warning as a sentence, if the gravitational acceleration is probably wrong; otherwise empty."""
        return sentences(self.warnings)

    def as_dict(self) -> dict[str, Any]:
        """Return the attributes as a dictionary of plain numbers and text.

        Returns
        -------
        dict
            The attributes by name, in the same units. Every warning is a dictionary with its ``sentence``.
        """
        warnings = zip(self.warnings, self.warning_sentences, strict=True)
        records = [{"sentence": sentence} | warning.as_dict() for warning, sentence in warnings]
        return asdict(self) | {"struts": [asdict(strut) for strut in self.struts], "warnings": records}

    def __str__(self) -> str:
        linear = f"a_0 = {self.onset:.4f} g, a*_0 = {self.acceleration:.4f} g"
        if self.demand_acceleration is None:
            linear += " (the building code has no linear check in this limit state)"
        else:
            verdict = "satisfied" if self.linear else "not satisfied"
            linear += f", demand {self.demand_acceleration:.4f} g: {verdict}"
        non_linear = "satisfied" if self.non_linear else "not satisfied"
        if self.warnings:
            non_linear += ", if the gravity is correct"
        unit = " (in the length unit of the case)"
        short = "" if self.complete else " (the true d*_0 is larger, because the curve ends before λ = 0)"
        used, demanded = numeral(self.ultimate, ".5g"), numeral(self.demand_displacement, ".5g")
        lines = {
            "check": self.code,
            "mass": f"e* = {self.mass_fraction:.4f}, M* = {self.mass:.5g} (unit of force / unit of gravity)",
            "linear": linear,
            "non-linear": f"d*_u = {used}, demand {demanded} at T_s = {self.period:.4g} s: {non_linear}",
            "rests on": self.rests_on,
            "displacement": f"d*_0 = {numeral(self.displacement, '.5g')}{unit}{short}",
            "gravity": f"{self.gravity:g}{self._unit_of_length()}",
            "not checked": self._struts_in_words(),
        }
        return "\n".join([labelled(lines), *warning_lines(self.warning_sentences)])

    def _unit_of_length(self) -> str:
        """Return a clause with the unit of length that ``gravity`` implies, or "" if the unit is unknown.

        For example, gravity 9.81 implies metres.
        """
        for unit, value in GRAVITY_BY_UNIT.items():
            if abs(self.gravity - value) <= _GRAVITY_TOLERANCE * value:
                return f": lengths are in {unit}"
        return ""

    def _struts_in_words(self) -> str:
        """Return a sentence about ties and props that must change their length, or "" if there are none."""
        if not self.struts:
            return ""
        changes = "; ".join(map(str, self.struts))
        return f"{changes} until d*_u is reached: verify that this is possible"


@dataclass(frozen=True)
class Activation:
    """Accelerations at which an earthquake activates a mechanism, by NTC 2008 and NTC 2018."""

    mass_fraction: float  #: participating mass fraction e* of the blocks that move
    acceleration: float  #: acceleration a_0 of the masses, in g
    spectral: float  #: spectral acceleration a*_0 = a_0 / (e* FC), in g, with FC = 1.35

    def __str__(self) -> str:
        spectral = f"spectral acceleration a*_0 = {self.spectral:.4f} g (FC = {CONFIDENCE_FACTOR:g})"
        return (
            f"acceleration of the masses a_0 = {self.acceleration:.4f} g; participating mass fraction "
            f"e* = {self.mass_fraction:.4f}; {spectral}"
        )


def activation(result: Result) -> Activation | None:
    """Return the accelerations at which an earthquake activates the mechanism of a result.

    The masses of a block are concentrated at the point of action of their resultant. The value is None if the
    live load is not a horizontal earthquake, or if the result has no load factor or mechanism.
    """
    quake, d = result.assembly.scene.shaken_by, result.solution.d
    if quake is None or quake.vertical or result.load_factor is None or d is None:
        return None
    problem, moves = result.assembly.problem, moving_blocks(result.assembly, d)
    sizes = problem.force_sizes(problem.live)[moves]
    work = (problem.by_block(problem.live) * problem.by_block(d)).sum(axis=1)[moves]
    loaded = sizes > 0
    first, second = float(work.sum()), float((work[loaded] ** 2 / sizes[loaded]).sum())
    if not second > 0:
        return None
    fraction = first**2 / (float(sizes.sum()) * second)
    acceleration = result.load_factor * quake.coefficient
    return Activation(fraction, acceleration, acceleration / (fraction * CONFIDENCE_FACTOR))


def kinematic_check(
    curve: CheckedCurve, spectrum: Sequence[tuple[float, float]], values: Mapping[str, float | str]
) -> KinematicCheck:
    """Make the linear and the non-linear kinematic check with the values of a capacity curve.

    Parameters
    ----------
    curve: Capacity curve.
    spectrum: Pairs of period (s) and acceleration (g).
    values: Parameters of :meth:`~.capacity.Capacity.check` by name.

    Raises
    ------
    OptionError
        If a number or the spectrum is wrong, the spectrum ends before the secant period, or the acceleration
        at the secant displacement is zero.
    """
    code, rules, numbers = _rules(values)
    periods, accelerations = _spectrum(spectrum)
    weights, rates = curve.weights, curve.rates
    first, second, total = float(weights @ rates), float(weights @ rates**2), float(weights.sum())
    fraction, g = first**2 / (total * second), numbers["gravity"]
    d = curve.states[:, 0] * (second / (curve.control_rate * first))
    a = curve.states[:, 1] / (fraction * numbers["confidence_factor"])  # a* = λ g / (e* FC)
    ultimate = rules.ultimate * float(d[-1])
    secant = rules.secant * ultimate
    at_secant = float(_ordinates_at(secant, d, a).min())
    if not at_secant > 0:
        raise OptionError(
            f"no secant period exists, because a* is zero at d*_s = {secant:.4g}: reduce 'ultimate' or "
            "'secant'"
        )
    period = rules.period * math.sqrt(secant / (at_secant * g))
    height = _rocking_height(float(d[-1]), float(curve.states[0, 1]) / fraction)
    warnings = _gravity_warnings(g, curve.extent, height, period)
    if period > periods[-1]:
        remedy = "; ".join(sentences(warnings)) or "add longer periods"
        raise OptionError(f"the spectrum ends at {periods[-1]:g} s, before T_s = {period:.4g} s: {remedy}")
    demand = _spectral_displacement(periods, accelerations, period, rules.is_largest_demand) * g
    limit = float(accelerations[0]) / numbers["behaviour_factor"] if rules.has_linear else None
    return KinematicCheck(
        code=code,
        mass_fraction=fraction,
        mass=fraction * total / g,
        onset=float(curve.states[0, 1]),
        acceleration=float(a[0]),
        displacement=float(d[-1]),
        complete=curve.complete,
        ultimate=ultimate,
        secant=secant,
        secant_acceleration=at_secant,
        period=period,
        demand_acceleration=limit,
        demand_displacement=demand,
        linear=None if limit is None else bool(a[0] >= limit),
        non_linear=bool(ultimate >= demand),
        rests_on=curve.rests_on,
        gravity=g,
        struts=tuple(_strut_changes(curve.struts, ultimate, d)),
        warnings=warnings,
    )


def _rocking_height(displacement: float, acceleration: float) -> float:
    """Return the height of the slender rocking block that has the same capacity curve as the oscillator.

    The mechanism's equivalent oscillator has the displacement d*_0 at λ = 0 and the acceleration λ / e*, in
    g, at the onset. A block of width b and height H has d*_0 = b / 2 and λ / e* = b / H. The height is
    infinite if the acceleration is zero.
    """
    return 2 * displacement / acceleration if acceleration > 0 else math.inf


def _gravity_warnings(gravity: float, extent: float, height: float, period: float) -> tuple[Reason, ...]:
    """Return a warning if the gravitational acceleration is probably not in the length unit of the case.

    ``extent`` is the largest dimension of the movable blocks, ``height`` is the height of the rocking block
    with the same capacity curve, and ``period`` is the secant period. The secant period alone is no evidence:
    it is long for every mechanism if d*_s is close to d*_0.
    """
    metre = gravity / GRAVITY  # one metre, expressed in the unit of length of ``gravity``
    is_plausible = SMALLEST_SCENE <= extent / metre <= LARGEST_SCENE
    if is_plausible and min(extent, height) / metre <= _HIGHEST_ROCKING_BLOCK:
        return ()
    return (reason(Code.GRAVITY_DIFFERS, gravity=gravity, extent=extent, period=period),)


def _strut_changes(struts: Sequence[StrutPath], ultimate: float, d: np.ndarray) -> Iterator[StrutChange]:
    """Generate the ties that lengthen and the props that shorten as blocks move to the ultimate displacement.

    ``d`` are the displacements d* of the oscillator at the states of the capacity curve, and ``ultimate`` is
    the ultimate displacement. The largest change of a length up to the ultimate displacement is reported.
    """
    for strut in struts:
        on_the_way = strut.change[d <= ultimate]
        change = float(np.append(on_the_way, _ordinates_at(ultimate, d, strut.change)).max())
        if change > _LEAST_STRUT_CHANGE * strut.at_rest:
            yield StrutChange(str(strut.role), strut.name, change, change / strut.at_rest)


def _rules(values: Mapping[str, Any]) -> tuple[str, CodeRules, dict[str, float]]:
    """Return the name of the building code, its rules, and the other parameters that the user specified.

    The user's values of ``ultimate`` and ``secant`` replace the values of the building code.

    Raises OptionError if the code is unknown, or a number is wrong.
    """
    numbers = {name: value for name, value in values.items() if name != "code" and value is not None}
    code = values["code"]
    if code not in CODES:
        raise OptionError(f"unknown code {code!r}: choose from {', '.join(map(repr, CODES))}")
    _check_values(numbers)
    shares = {name: numbers.pop(name) for name in ("ultimate", "secant") if name in numbers}
    return code, replace(CODES[code], **shares), numbers


def _spectral_displacement(
    periods: np.ndarray, accelerations: np.ndarray, period: float, is_largest: bool
) -> float:
    """Return the spectral displacement S_e(T) (T / 2π)² at a period T, in units of g s².

    If ``is_largest`` is True, the result is the largest displacement at periods up to T. The spectral
    acceleration is interpolated linearly between the given periods.
    """
    at = np.array([period])
    if is_largest:
        slope = np.diff(accelerations) / np.diff(periods)
        # Between two periods, the spectrum is S = S₀ + k (T − T₀). The spectral displacement is proportional
        # to S T², so it is largest where its derivative vanishes: at T = −2 (S₀ − k T₀) / (3 k).
        falling = slope < 0
        constant = (accelerations[:-1] - slope * periods[:-1])[falling]
        inner = -2 * constant / (3 * slope[falling])
        within = (periods[:-1][falling] <= inner) & (inner <= periods[1:][falling])
        candidates = np.concatenate([periods, inner[within]])
        at = np.append(candidates[candidates < period], period)
    displacements = np.interp(at, periods, accelerations) * (at / (2 * math.pi)) ** 2
    return float(displacements.max())


def _check_values(values: Mapping[str, float]) -> None:
    """Raise OptionError if a parameter of the check is not positive, or if a ratio exceeds 1."""
    for name, value in values.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < math.inf:
            raise OptionError(f"{name} must be a finite number above zero (found {value!r})")
    for name in ("ultimate", "secant"):
        if values.get(name, 0.0) > 1:
            raise OptionError(f"{name} is a ratio that must be at most 1 (found {values[name]!r})")


def _ordinates_at(x: float, xs: np.ndarray, ys: np.ndarray) -> np.ndarray:
    """Return the ordinates y of a polyline at abscissa x.

    A polyline that is not monotonic may have several ordinates at x.
    """
    low, high = np.minimum(xs[:-1], xs[1:]), np.maximum(xs[:-1], xs[1:])
    segments = np.flatnonzero((low <= x) & (x <= high) & (high > low))
    share = (x - xs[segments]) / np.diff(xs)[segments]
    return ys[segments] + share * np.diff(ys)[segments]


def _spectrum(spectrum: Sequence[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    """Return the periods and accelerations of a spectrum; raise OptionError if it is not valid."""
    try:
        pairs = np.array(spectrum, dtype=float)
    except (TypeError, ValueError):
        pairs = np.zeros(0)
    rising = pairs.shape[1:] == (2,) and len(pairs) > 1 and (np.diff(pairs[:, 0]) > 0).all()
    if not (rising and pairs[0, 0] == 0 and np.isfinite(pairs).all() and (pairs[:, 1] >= 0).all()):
        raise OptionError(
            "the spectrum must be a list of pairs (period in s, acceleration in g): the periods must "
            "increase from 0, and no acceleration may be negative"
        )
    return pairs[:, 0], pairs[:, 1]
