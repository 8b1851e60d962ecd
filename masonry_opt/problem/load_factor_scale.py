"""Compare load factors with each other and with zero, on the scale of the load factors of a problem."""

from dataclasses import dataclass

#: Relative difference below which two load factors count as equal. On the case files, methods differ by up to
#: 2e-8 for one state, and different states differ by at least 8e-4.
EQUALITY_TOLERANCE = 1e-6

#: Relative size of rounding errors in load factors, resultants and margins. A load factor counts as lower
#: than another only if the relative difference is larger. The value is the limit on the residuals of exact
#: states (``LIMITS`` in ``solution/acceptance.py``).
RELATIVE_ROUNDING = 1e-8

#: A load factor counts as zero if its magnitude is below this multiple of ``LoadFactorScale.unit``.
ZERO = 1e-6

#: Relative differences and residuals are divided by |λ|, or by this multiple of ``LoadFactorScale.unit`` if
#: |λ| is smaller.
SMALLEST = 1e-2


@dataclass(frozen=True)
class LoadFactorScale:
    """Typical size of a problem's load factors, by which absolute tolerances are multiplied.

    Load factors are about one if the live load is as large as the dead load, and smaller if the live load is
    larger. Tolerances such as ``ZERO`` are therefore multiplied by ``unit``. The default unit 1 is used to
    compare load factors of several problems, such as the runs of a sweep.
    """

    unit: float = 1.0  #: unit of λ: sum of the dead loads divided by the sum of the live loads, but at most 1

    @classmethod
    def of_loads(cls, dead: float, live: float) -> "LoadFactorScale":
        """Return the scale, given the sums of the magnitudes of all dead loads and of all live loads.

        The unit is one if one of the sums is zero.
        """
        return cls(min(1.0, dead / live) if dead and live else 1.0)

    @property
    def zero(self) -> float:
        """Magnitude below which a load factor counts as zero."""
        return ZERO * self.unit

    def divisor(self, load_factor: float) -> float:
        """Return the divisor of relative differences and residuals: |λ|, but at least ``SMALLEST`` × unit."""
        return max(abs(load_factor), SMALLEST * self.unit)

    def equal(self, first: float, second: float) -> bool:
        """Return True if two load factors are equal up to the relative difference ``EQUALITY_TOLERANCE``."""
        larger = max(abs(first), abs(second))
        return abs(first - second) <= EQUALITY_TOLERANCE * self.divisor(larger)

    def is_distinctly_lower(self, load_factor: float, than: float) -> bool:
        """Return True if the difference between two load factors matters to the user.

        The tolerance is that of :meth:`equal`. Warnings and verdicts about load factors use this method. It
        ignores differences that may come from inaccurate solvers.
        """
        return load_factor < than and not self.equal(load_factor, than)

    def is_lower(self, load_factor: float, than: float) -> bool:
        """Return True if λ is lower than another λ by more than rounding errors (``RELATIVE_ROUNDING``).

        Comparisons between exact states use this method, because their load factors are accurate.
        """
        return load_factor < than - RELATIVE_ROUNDING * self.divisor(than)
