"""The benchmark: scenes × methods × models × solvers × tolerances, timed and judged."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from masonry_opt.studies.compare.api import compare
    from masonry_opt.studies.compare.comparison import Comparison

__all__ = ["Comparison", "compare"]


def __getattr__(name: str) -> object:
    # Imported when first used: the solvers take seconds to import.
    if name == "compare":
        from masonry_opt.studies.compare.api import compare

        return compare
    if name == "Comparison":
        from masonry_opt.studies.compare.comparison import Comparison

        return Comparison
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
