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

#: The registry's name, in the folder of the case files or one above.
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


def best_known(scenes: Iterable[CaseScene]) -> dict[str, BestKnown]:
    """The best known states of scenes, by scene name.

    Raises CaseError if a registry is no TOML or an entry is not as written here.
    """
    found = {}
    for registry, keys in _by_registry(scenes).items():
        entries = _read(registry)
        for key, scene in keys.items():
            if (known := _known(registry, entries, key, scene)) is not None:
                found[scene.name] = known
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


def improve(scenes: Iterable[CaseScene], best: Mapping[str, BestKnown], write: bool) -> list[str]:
    """Lines on the states lower than the registries say, and on how many scenes have no entry yet; with
    ``write`` they are written to the registries. A registry that cannot be written is named in its line."""
    lines: list[str] = []
    for registry, keys in _by_registry(scenes).items():
        entries, lower, new = _read(registry), [], 0
        for key, scene in keys.items():
            known, found = _known(registry, entries, key, scene), best.get(scene.name)
            if found is None or (known and not is_lower(found.load_factor, known.load_factor)):
                continue
            if known is None:
                new += 1
            else:
                lower.append(f"{key}: lower exact state {found.load_factor:.9g}, found by {found.method}")
            entries[key] = asdict(found) | {"content": scene.content}
        if new:
            lower.append(f"scenes with an exact state and no entry yet: {new}")
        if lower:
            done = _write(registry, entries) if write else f"--update-best-known writes it to {registry}"
            lines += [f"{line}; {done}" for line in lower]
    return lines


def _by_registry(scenes: Iterable[CaseScene]) -> dict[Path, dict[str, CaseScene]]:
    """The scenes with a registry in their folder or the one above, by registry and by their key there."""
    found: dict[Path, dict[str, CaseScene]] = {}
    for scene in scenes:
        path = (scene.registered or scene.path).resolve()
        for folder in (path.parent, path.parent.parent):
            if (folder / FILE).is_file():
                found.setdefault(folder / FILE, {})[path.relative_to(folder).as_posix()] = scene
                break
    return found


def _known(registry: Path, entries: Mapping[str, Any], key: str, scene: CaseScene) -> BestKnown | None:
    """The entry of a scene in a registry; None without one, or if the scene has changed since."""
    entry = entries.get(key)
    if entry is None:
        return None
    try:
        same = entry["content"] == scene.content
        return BestKnown(float(entry["load_factor"]), str(entry["method"])) if same else None
    except (KeyError, TypeError, ValueError):
        raise CaseError(f"{registry}: '{key}' needs load_factor, method and content") from None


def _write(registry: Path, entries: Mapping[str, Any]) -> str:
    """Write a registry; tells in words whether it was written."""
    try:
        write_whole(registry, _HEADER + tomli_w.dumps(dict(sorted(entries.items()))))
    except OSError as error:
        return f"{registry} cannot be written ({error.strerror})"
    return f"written to {registry}"


def _read(registry: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(registry.read_text("utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise CaseError(f"{registry}: cannot be read: {error}") from None
