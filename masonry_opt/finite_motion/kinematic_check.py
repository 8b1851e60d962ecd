"""Kinematic checks of local mechanisms after Circolare 617/2009, C8A.4.2.2 and C8A.4.2.3 (NTC 2008)."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from masonry_opt.brief import brief
from masonry_opt.errors import OptionError
from masonry_opt.reporting.names import labelled
from masonry_opt.reporting.sentences import numeral


@dataclass(frozen=True)
class KinematicCheck:
    """Results of kinematic checks: capacity of a mechanism, and demand of an elastic response spectrum.

    The symbols are those of the code: P are the forces, δ their virtual displacements at the onset, d_k and
    δ_k those of the control point.

    Attributes
    ----------
    mass_fraction: Participating mass fraction e* = (Σ P δ)² / (Σ P Σ P δ²).
    mass: Participating mass M* = e* Σ P / g, in the case's unit of force over the unit of ``gravity``.
    acceleration: a*_0 = λ g / (e* FC) at which the mechanism is activated, in g.
    displacement: d*_0 of the equivalent oscillator at λ = 0, or at the end of a curve that ends before, with
        d* = d_k Σ P δ² / (δ_k Σ P δ).
    complete: True if the curve comes down to λ = 0; otherwise ``displacement`` is less than d*_0.
    ultimate: Ultimate displacement d*_u, a share of d*_0.
    secant, secant_acceleration: The point (d*_s, a*_s) of the curve, a*_s in g.
    period: Secant period T_s = 2π √(d*_s / a*_s), in seconds.
    demand_acceleration: S_e(0) / q, in g.
    demand_displacement: S_e(T_s) (T_s / 2π)², in the case's unit of length.
    linear: True if the linear check holds: ``acceleration`` is at least ``demand_acceleration``.
    non_linear: True if the non-linear check holds: ``ultimate`` is at least ``demand_displacement``.
    rests_on: Name and certainty of the load factor λ at the onset, on which both verdicts rest.
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

    __repr__ = brief

    def as_dict(self) -> dict[str, Any]:
        """Return the attributes as a dictionary of plain numbers and text."""
        return asdict(self)

    def __str__(self) -> str:
        linear = "holds" if self.linear else "does not hold"
        non_linear = "holds" if self.non_linear else "does not hold"
        short = "" if self.complete else " (the curve ends before λ = 0, so the true d*_0 is larger)"
        used, demanded = numeral(self.ultimate, ".5g"), numeral(self.demand_displacement, ".5g")
        lines = {
            "mass": f"e* = {self.mass_fraction:.4f}, M* = {self.mass:.6g}",
            "linear": f"a*_0 = {self.acceleration:.4f} g against {self.demand_acceleration:.4f} g: {linear}",
            "non-linear": f"d*_u = {used} against {demanded} at T_s = {self.period:.4g} s: {non_linear}",
            "rests on": f"{self.rests_on}; if a lower λ exists, the linear or non-linear check may fail",
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
    """Make the linear and the non-linear kinematic check of a capacity curve.

    Parameters
    ----------
    onset: Forces P and their rates δ at the onset, shape (f,) each, and the rate δ_k of the control point.
    curve: Columns d_k and λ of the curve, shape (states, 2).
    complete: True if the curve comes down to λ = 0.
    spectrum: Pairs of period (s) and acceleration (g).
    values: Numbers of :meth:`~.capacity.Capacity.check` by name.
    rests_on: Name and certainty of the load factor at the onset, as text.

    Raises
    ------
    OptionError
        If a number or the spectrum is wrong, or the spectrum ends before the secant period.
    """
    _check_values(values)
    periods, accelerations = _spectrum(spectrum)
    weights, rates, control_rate = onset
    first, second, total = float(weights @ rates), float(weights @ rates**2), float(weights.sum())
    fraction, g = first**2 / (total * second), values["gravity"]
    d = curve[:, 0] * (second / (control_rate * first))
    a = curve[:, 1] / (fraction * values["confidence_factor"])  # a* = λ g / (e* FC)
    ultimate = float(values["ultimate"] * d[-1])
    secant = values["secant"] * ultimate
    at_secant = _least_at(secant, d, a)
    period = 2 * math.pi * math.sqrt(secant / (at_secant * g)) if at_secant > 0 else math.inf
    if period > periods[-1]:
        raise OptionError(f"the spectrum ends at {periods[-1]:g} s, before T_s = {period:.4g} s: extend it")
    demand_displacement = float(np.interp(period, periods, accelerations)) * g * (period / (2 * math.pi)) ** 2
    demand_acceleration = float(accelerations[0]) / values["behaviour_factor"]
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
        demand_acceleration=demand_acceleration,
        demand_displacement=demand_displacement,
        linear=bool(a[0] >= demand_acceleration),
        non_linear=bool(ultimate >= demand_displacement),
        rests_on=rests_on,
    )


def _check_values(values: Mapping[str, float]) -> None:
    """Raise OptionError if a parameter of the check is not positive, or if a share exceeds 1."""
    for name, value in values.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < math.inf:
            raise OptionError(f"{name} must be a finite number above zero (found {value!r})")
    for name in ("ultimate", "secant"):
        if values[name] > 1:
            raise OptionError(f"{name} must be at most 1, as a share (found {values[name]!r})")


def _least_at(x: float, xs: np.ndarray, ys: np.ndarray) -> float:
    """Return the smallest ordinate of a polyline at an abscissa, which the polyline may cross repeatedly."""
    low, high = np.minimum(xs[:-1], xs[1:]), np.maximum(xs[:-1], xs[1:])
    segments = np.flatnonzero((low <= x) & (x <= high) & (high > low))
    share = (x - xs[segments]) / np.diff(xs)[segments]
    return float((ys[segments] + share * np.diff(ys)[segments]).min())


def _spectrum(spectrum: Sequence[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    """Return a spectrum's periods and accelerations. Raises OptionError if the spectrum is not valid."""
    try:
        pairs = np.array(spectrum, dtype=float)
    except (TypeError, ValueError):
        pairs = np.zeros(0)
    rising = pairs.shape[1:] == (2,) and len(pairs) > 1 and (np.diff(pairs[:, 0]) > 0).all()
    if not (rising and pairs[0, 0] == 0 and np.isfinite(pairs).all() and (pairs[:, 1] >= 0).all()):
        raise OptionError(
            "a spectrum is a list of pairs: period (s), increasing from 0, and acceleration (g), not negative"
        )
    return pairs[:, 0], pairs[:, 1]
