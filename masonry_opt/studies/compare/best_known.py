"""The registry of best known Coulomb states: the lowest exact load factor of each scene and its method."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import tomli_w

from masonry_opt.answer.acceptance import Kind
from masonry_opt.answer.thresholds import is_lower
from masonry_opt.errors import CaseError
from masonry_opt.files import write_whole
from masonry_opt.studies.compare.plan import CaseScene
from masonry_opt.studies.compare.runs import by_sides, residuals_over_limit

#: The registry's name, in the folder of the case files.
FILE = "best_known.toml"

#: The kinds of answer that can be exact: in the loop's, sliding may contract.
_EXACT_KINDS = (Kind.ONE_PASS, Kind.RELAXED, Kind.EXACT)

_HEADER = """\
# The lowest exact Coulomb load factor known of each scene, and the method that found it. `content` is the
# scene's hash: a changed scene has no best known state. `--update-best-known` of `masonry-opt compare` (of
# case files) and of benchmarks/verdicts.py (of the scenes that tests/atlas makes) rewrites the file beside
# them when a run of mcp, mpec, refined or global, all of whose residuals are below 1e-8, finds a lower one.
"""


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


def improve(
    scenes: Iterable[CaseScene], best: Mapping[str, BestKnown], registry: Path | None, write: bool
) -> list[str]:
    """Lines on the states lower than the registry says; with ``write`` they are written to it, and those of
    scenes that have none yet. A registry that cannot be written is named in its line."""
    scenes = list(scenes)
    entries, known, lines = _read(registry), best_known(scenes, registry), []
    if registry is None:
        return []
    for scene in scenes:
        before, found = known.get(scene.name), best.get(scene.name)
        if found is None or (before and not is_lower(found.load_factor, before.load_factor)):
            continue
        entries[_key(scene)] = asdict(found) | {"content": scene.content}
        if before or write:
            which = "lower exact state" if before else "first exact state"
            lines.append(f"{_key(scene)}: {which} {found.load_factor:.9g}, found by {found.method}")
    done = f"--update-best-known writes it to {registry}"
    if lines and write:
        done = f"written to {registry}"
        try:
            write_whole(registry, _HEADER + tomli_w.dumps(dict(sorted(entries.items()))))
        except OSError as error:
            done = f"{registry} cannot be written ({error.strerror})"
    return [f"{line}; {done}" for line in lines]


def _key(scene: CaseScene) -> str:
    return f"{scene.name}.toml"


def _read(registry: Path | None) -> dict[str, Any]:
    if registry is None or not registry.exists():
        return {}
    try:
        return tomllib.loads(registry.read_text("utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise CaseError(f"{registry}: cannot be read: {error}") from None
