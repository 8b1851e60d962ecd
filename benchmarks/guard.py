"""Do all methods still say what they said? Every case and 200 random scenes, against numbers frozen before.

    python benchmarks/guard.py freeze            # write benchmarks/guard.json
    python benchmarks/guard.py compare           # what moved since, the largest first
    python benchmarks/guard.py compare --every 7 # of every seventh scene

Scenes: the case files; walls, arches, stacks and tessellations, their like in space, some under fill or held
by ties and props (seeds 500000+, which nothing is tuned on). Exit code 1: something moved by more than the
tolerance.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.held_scenes import held  # noqa: E402
from atlas.random_scenes import KINDS, random_scene  # noqa: E402
from atlas.random_scenes_in_space import KINDS as KINDS_IN_SPACE  # noqa: E402
from atlas.random_scenes_in_space import random_scene_in_space  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.methods.registry import METHODS  # noqa: E402
from masonry_opt.problem.assembly import assemble  # noqa: E402

FROZEN = ROOT / "benchmarks" / "guard.json"

#: Random scenes of each kind, and the first seed.
COUNT, FIRST = 200, 500_000

#: Joints (in space contact points) up to which a method is asked; others are asked of all.
UP_TO = {"global": 6, "mpec": 30, "refined": 40, "kinematic": 400, "mcp": 1200, "compliant": 1200}

#: What is compared as a number, relative to the larger one; all else must be equal.
NUMBERS = ("load_factor", "expected", "associative")


def scenes() -> Iterator[tuple[str, str, int]]:
    """Name, kind and seed of every scene; of a case its path and nothing."""
    for path in sorted((ROOT / "cases").rglob("*.toml")):
        if path.name != "best_known.toml":
            yield str(path.relative_to(ROOT)), "", 0
    kinds = [
        *KINDS,
        "filled",
        *(f"held {kind}" for kind in KINDS),
        *KINDS_IN_SPACE,
        "held boxes",
        "held piers",
    ]
    for number in range(COUNT):
        kind, seed = kinds[number % len(kinds)], FIRST + number
        yield f"{kind} {seed}", kind, seed


def scene_of(name: str, kind: str, seed: int) -> mo.Scene:
    """A scene by its kind and seed, or of its case file."""
    if not kind:
        return mo.load(ROOT / name)
    what = kind.removeprefix("held ")
    if what != kind or kind == "filled":
        return held(what, seed, what in KINDS_IN_SPACE)
    return (random_scene_in_space if kind in KINDS_IN_SPACE else random_scene)(kind, seed)


def told(scene: mo.Scene, method: str) -> dict[str, Any]:
    """What a method says of a scene."""
    try:
        result = mo.solve(scene, method)
    except mo.MasonryError as error:
        return {"refused": type(error).__name__}
    certificate = None if result.certificate is None else max(result.certificate.as_dict().values())
    return {
        **{name: getattr(result, name) for name in NUMBERS},
        "status": str(result.status),
        "codes": sorted(str(reason.code) for reason in result.reasons),
        "expected codes": sorted(str(reason.code) for reason in result.expected_reasons),
        "exact": result.exact,
        "residual": certificate,
    }


def all_told(of: tuple[str, str, int]) -> tuple[str, dict[str, Any]]:
    """What all methods say of a scene."""
    scene = scene_of(*of)
    joints = assemble(scene).problem.joints
    return of[0], {
        method: told(scene, method) for method in METHODS if joints <= UP_TO.get(method, sys.maxsize)
    }


def moved(before: dict[str, Any], now: dict[str, Any]) -> Iterator[tuple[float, str]]:
    """How far each of the things that a method says has moved: relative, infinite where it is no number."""
    for what in sorted({*before, *now} - {"residual"}):
        was, is_now = before.get(what), now.get(what)
        if was == is_now:
            continue
        both = what in NUMBERS and None not in (was, is_now)
        far = abs(was - is_now) / max(abs(was), abs(is_now), 1e-6) if both else float("inf")
        yield far, f"{what}: {was} -> {is_now}"
    worse = (now.get("residual") or 0.0) - max(before.get("residual") or 0.0, 1e-8)
    if worse > 0:
        yield worse, f"certificate: {before.get('residual')} -> {now.get('residual')}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=("freeze", "compare"))
    parser.add_argument("--every", type=int, default=1, help="of so many scenes one")
    parser.add_argument("--tolerance", type=float, default=1e-9)
    parser.add_argument("--show", type=int, default=40, help="lines at most")
    asked = parser.parse_args()
    chosen, start = list(scenes())[:: asked.every], time.perf_counter()
    with ProcessPoolExecutor(2) as pool:
        found = dict(pool.map(all_told, chosen))
    print(f"{len(chosen)} scenes in {time.perf_counter() - start:.0f} s")
    if asked.what == "freeze":
        FROZEN.write_text(json.dumps(found, indent=0, sort_keys=True) + "\n")
        return
    frozen = json.loads(FROZEN.read_text())
    lines = [
        (far, f"{name}, {method}: {words}")
        for name, methods in found.items()
        for method, now in methods.items()
        for far, words in moved(frozen[name].get(method, {}), now)
        if far > asked.tolerance
    ]
    lines.sort(key=lambda line: -line[0])
    for far, words in lines[: asked.show]:
        print(f"{far:.1e}  {words}")
    print(f"{len(lines)} things moved by more than {asked.tolerance:.0e}")
    sys.exit(bool(lines))


if __name__ == "__main__":
    main()
