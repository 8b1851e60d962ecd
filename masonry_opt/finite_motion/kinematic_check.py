"""Kinematic checks of local mechanisms after Circolare 617/2009, C8A.4.2.2, C8A.4.2.3 (NTC 2008)."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from masonry_opt.errors import OptionError
from masonry_opt.words.names import labelled
from masonry_opt.words.sentences import numeral


@dataclass(frozen=True)
class KinematicCheck:
    """Capacity of a mechanism beside what a spectrum demands of it.

    Attributes
    ----------
    mass_fraction: e* = (Σ P δ)² / (Σ P Σ P δ²), with virtual displacements δ of the onset along forces P.
    mass: M* = e* Σ P / g, in the case's unit of force over that of ``gravity``.
    acceleration: a*_0 = λ g / (e* FC), that sets the mechanism going, in g.
    displacement: d*_0, of the equivalent oscillator at λ = 0, or where the curve ends before:
        d* = d_k Σ P δ² / (δ_k Σ P δ) where the control point has moved by d_k.
    complete: whether the curve comes down to λ = 0; if not, ``displacement`` is less than d*_0.
    ultimate: d*_u, the share of d*_0 that may be used.
    secant, secant_acceleration: d*_s and a*_s (g), a point of the curve; period: T_s = 2π √(d*_s / a*_s) (s).
    demand_acceleration: S_e(0) / q, in g; ``demand_displacement``: S_e(T_s) (T_s / 2π)².
    linear, non_linear: whether a*_0 is at least the first, and d*_u the second.
    rests_on: name and certainty of the load factor λ at the onset, on which both verdicts rest.
    """

    mass_fraction: float
    mass: float
    acceleration: float
    displacement: float
    complete: bool
    ultimate: float
    secant: float
    secant_acceleration: float
    period: float
    demand_acceleration: float
    demand_displacement: float
    linear: bool
    non_linear: bool
    rests_on: str

    def as_dict(self) -> dict[str, Any]:
        """The same as plain numbers."""
        return asdict(self)

    def __str__(self) -> str:
        linear, non_linear = ("holds" if of else "does not hold" for of in (self.linear, self.non_linear))
        short = "" if self.complete else " (the curve ends before λ = 0: d*_0 is larger)"
        used, demanded = numeral(self.ultimate, ".5g"), numeral(self.demand_displacement, ".5g")
        lines = {
            "mass": f"e* = {self.mass_fraction:.4f}, M* = {self.mass:.6g}",
            "linear": f"a*_0 = {self.acceleration:.4f} g against {self.demand_acceleration:.4f} g: {linear}",
            "non-linear": f"d*_u = {used} against {demanded} at T_s = {self.period:.4g} s: {non_linear}",
            "rests on": f"{self.rests_on}; with a lower λ a check may not hold",
            "displacement": f"d*_0 = {numeral(self.displacement, '.5g')}{short}",
        }
        return labelled(lines)


def kinematic_check(
    onset: tuple[np.ndarray, np.ndarray, float],
    curve: np.ndarray,
    complete: bool,
    spectrum: Sequence[tuple[float, float]],
    values: Mapping[str, float],
    rests_on: str,
) -> KinematicCheck:
    """Check with the numbers of :meth:`~.capacity.Capacity.check` by name; at the onset forces P and their
    rates δ, shape (f,) each, and the control point's rate δ_k; the curve of d_k and λ, shape (states, 2).
    ``rests_on`` says what the load factor at the onset is."""
    for name, value in values.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < math.inf:
            raise OptionError(f"{name} must be a number above zero (found {value!r})")
    for name in ("ultimate", "secant"):
        if values[name] > 1:
            raise OptionError(f"{name} is a share: at most 1 (found {values[name]!r})")
    periods, accelerations = _spectrum(spectrum)
    weights, rates, control_rate = onset
    first, second, total = float(weights @ rates), float(weights @ rates**2), float(weights.sum())
    fraction, g = first**2 / (total * second), values["gravity"]
    d = curve[:, 0] * (second / (control_rate * first))
    a = curve[:, 1] / (fraction * values["confidence_factor"])  # a* = λ g / (e* FC)
    ultimate = float(values["ultimate"] * d[-1])
    secant = values["secant"] * ultimate
    # The curve may pass a displacement more than once: the least counts.
    low, high = np.minimum(d[:-1], d[1:]), np.maximum(d[:-1], d[1:])
    passes = np.flatnonzero((low <= secant) & (secant <= high) & (high > low))
    share = (secant - d[passes]) / np.diff(d)[passes]
    at_secant = float((a[passes] + share * np.diff(a)[passes]).min())
    period = 2 * math.pi * math.sqrt(secant / (at_secant * g)) if at_secant > 0 else math.inf
    if period > periods[-1]:
        raise OptionError(f"the spectrum ends at {periods[-1]:g} s, before T_s = {period:.4g} s: extend it")
    demanded = float(np.interp(period, periods, accelerations)) * g * (period / (2 * math.pi)) ** 2
    least = float(accelerations[0]) / values["behaviour_factor"]
    return KinematicCheck(
        mass_fraction=fraction,
        mass=fraction * total / g,
        acceleration=float(a[0]),
        displacement=float(d[-1]),
        complete=complete,
        ultimate=ultimate,
        secant=secant,
        secant_acceleration=at_secant,
        period=period,
        demand_acceleration=least,
        demand_displacement=demanded,
        linear=bool(a[0] >= least),
        non_linear=bool(ultimate >= demanded),
        rests_on=rests_on,
    )


def _spectrum(given: Sequence[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    try:
        pairs = np.array(given, dtype=float)
    except (TypeError, ValueError):
        pairs = np.zeros(0)
    rising = pairs.shape[1:] == (2,) and len(pairs) > 1 and (np.diff(pairs[:, 0]) > 0).all()
    if not (rising and pairs[0, 0] == 0 and np.isfinite(pairs).all() and (pairs[:, 1] >= 0).all()):
        raise OptionError("a spectrum is pairs of period (s), rising from 0, and acceleration (g), 0 or more")
    return pairs[:, 0], pairs[:, 1]
