"""The registry of best known Coulomb states: the lowest exact load factor of each scene and its method."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.thresholds import is_lower
from masonry_opt.errors import CaseError
from masonry_opt.studies.compare.plan import CaseScene
from masonry_opt.studies.compare.runs import by_sides, residuals_over_limit

#: The registry's name, in the folder of the case files.
FILE = "best_known.toml"

#: The kinds of answer that can be exact: in the loop's, sliding may contract.
_EXACT_KINDS = (Kind.ONE_PASS, Kind.RELAXED, Kind.EXACT)


@dataclass(frozen=True)
class BestKnown:
    """The lowest exact load factor of a scene, and the method that found it."""

    load_factor: float
    method: str


def best_known(scenes: Iterable[CaseScene], registry: Path | None) -> dict[str, BestKnown]:
    """The best known states of scenes in a registry, by scene name; none of a scene that has changed since.

    Raises CaseError if the registry is no TOML or an entry is not as written here.
    """
    entries, found = _read(registry), {}
    for scene in scenes:
        if (entry := entries.get(_key(scene))) is None:
            continue
        try:
            if entry["content"] == scene.content:
                found[scene.name] = BestKnown(float(entry["load_factor"]), str(entry["method"]))
        except (KeyError, TypeError, ValueError):
            raise CaseError(f"{registry}: '{_key(scene)}' needs load_factor, method and content") from None
    return found


def lowest_exact(
    rows: Iterable[dict[str, Any]], known: Mapping[str, BestKnown] | None = None
) -> dict[str, BestKnown]:
    """The lowest exact state among runs, by scene name.

    A single pass ends in any exact state: it counts only where a low one is known or was searched for.
    """
    exact = [row for row in rows if is_exact(row)]
    low = {*(known or {}), *(row["scene"] for row in exact if row["kind"] != Kind.ONE_PASS)}
    best: dict[str, BestKnown] = {}
    for row in exact:
        if row["scene"] in low:
            best = merged(best, {row["scene"]: BestKnown(row["load_factor"], row["method"])})
    return best


def is_exact(row: dict[str, Any]) -> bool:
    """Whether a run ended in an exact Coulomb state, in space by the cone, by the limits of exact answers."""
    can_be = row["load_factor"] is not None and row["kind"] in _EXACT_KINDS and not by_sides(row)
    return can_be and not residuals_over_limit(row, Kind.EXACT)


def merged(known: dict[str, BestKnown], found: dict[str, BestKnown]) -> dict[str, BestKnown]:
    """The lower of two states of each scene."""
    lower = {
        name: best
        for name, best in found.items()
        if name not in known or is_lower(best.load_factor, known[name].load_factor)
    }
    return known | lower


def lower_states(
    known: Mapping[str, BestKnown], best: Mapping[str, BestKnown], registry: Path | None
) -> list[str]:
    """Lines on the states that are lower than those known, which the registry has."""
    return [
        f"{name}.toml: lower exact state {best[name].load_factor:.9g}, found by {best[name].method}; "
        f"{registry} has {known[name].load_factor:.9g}"
        for name in known
        if best[name] != known[name]
    ]


def _key(scene: CaseScene) -> str:
    return f"{scene.name}.toml"


def _read(registry: Path | None) -> dict[str, Any]:
    if registry is None or not registry.exists():
        return {}
    try:
        return tomllib.loads(registry.read_text("utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise CaseError(f"{registry}: cannot be read: {error}") from None
