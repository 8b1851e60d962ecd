"""Measure what each tuned constant or rule of the methods contributes, on scenes not used to tune it.

A rule is switched off, or a constant changed, by its name. The script prints the answers that are lost. A
rule without effect can be deleted.

    python benchmarks/ablation.py --list
    python benchmarks/ablation.py two-repairs further-starts --random 30
    python benchmarks/ablation.py rough-sub-problems --random 0 --large
    python benchmarks/ablation.py in-space --random 0 --walls "" --no-facades --space 3

The scenes are:

- small random scenes (tests/atlas) from seed 90000 on (--first)
- walls of Ferris & Tin-Loi (--walls) with other values of friction, and façades of up to 3 × 2 openings
- with --large, façades and walls of more than 1000 joints
- with --rubble, rubble walls of 60 and 200 stones
- with --atlas, the failure atlas (tests/atlas)
- with --space, random scenes from seed 97000 on (--first-in-space), and corner walls of 12 to 26 blocks

The name "in-space" selects all rules that concern only scenes in space.

Each name has a row that compares the changed methods with the unchanged methods:

- the numbers of answers, exact states and incremental load factors that are lost or gained
- how often and by how much λ is higher or lower, counted above a relative difference of 1e-6; a lower Coulomb
  load factor is better
- the ratios of steps and of processor time

--settings makes each number of the settings of exact states three times smaller and three times larger, and
solves the same scenes by the default method. For the settings of the incremental analysis see
benchmarks/incremental.py.
"""

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass, fields
from functools import partial
from importlib import import_module
from math import inf
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.entries import ATLAS  # noqa: E402
from atlas.held_scenes import held  # noqa: E402
from atlas.large_scenes import rubble  # noqa: E402
from atlas.random_scenes import KINDS, random_scene  # noqa: E402
from atlas.random_scenes_in_space import KINDS as KINDS_IN_SPACE  # noqa: E402
from atlas.random_scenes_in_space import random_scene_in_space  # noqa: E402
from scenes_in_space import corner_wall  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.methods.exact.settings import SEARCH, SearchSettings  # noqa: E402
from masonry_opt.methods.loop.nonassociative import REMEDIES  # noqa: E402
from masonry_opt.problem.assembly import assemble  # noqa: E402
from masonry_opt.problem.load_factor_scale import EQUALITY_TOLERANCE, SMALLEST  # noqa: E402
from masonry_opt.solution.reasons import Code  # noqa: E402

#: First seed of the random scenes in the plane, above all seeds that were used for tuning.
FIRST_SEED = 90_000
#: First seed of the random scenes in space, above all seeds that were used for tuning.
FIRST_SEED_IN_SPACE = 97_000

#: Sizes of the corner walls: blocks along x and y, courses.
CORNERS = ((2, 2, 3), (3, 3, 3), (3, 2, 5))
#: Values of friction of each corner wall.
CORNER_FRICTIONS = (0.45, 0.7)

#: Options of each measurement that an entry of ``ABLATIONS`` can name.
MEASURED: dict[str, dict[str, Any]] = {
    "nonassociative": {},
    "rough": {"method": "nonassociative", "sub_problems": "rough"},
    "coulomb": {"incremental": True},
    "incremental": {},
    "forces": {"method": "coulomb"},
    "search": {"method": "coulomb", "search": 2.0},
    "global": {"time_limit": 5.0},
}


def _without(*names: Any) -> Callable[[Any], Any]:
    """Return a function that copies a dictionary or tuple without the given keys or entries."""

    def reduced(old: Any) -> Any:
        left = [entry for entry in old if str(entry) not in names]
        return {name: old[name] for name in left} if isinstance(old, dict) else tuple(left)

    return reduced


_SETTINGS = "exact.settings:SEARCH."
_SEARCH = "exact.search:"
_RUN = "loop.run:"
_BOUND = "bracket.relaxation:"
_PRODUCTS = "bounds.products:"
_REMEDIES = "loop.nonassociative:REMEDIES"
_ENERGY = "exact.alternation:ExactPrograms.forces.__defaults__"


def _solved_alone(solved: Callable[..., bool]) -> Callable[..., bool]:
    """Return a replacement of ``ExactPrograms._solved`` that accepts no point near the optimum."""

    def solved_alone(programs: Any, engines: list[Any], before_each: Callable[[], None]) -> bool:
        for engine in engines:
            before_each()
            if engine.solve().readable(nearly=False):
                return True
        return False

    return solved_alone


def _no_excess(*_: Any) -> float:
    """Replace the excess of a carried load that unbalanced forces explain by zero."""
    return 0.0


_WEIGHTS = _SETTINGS + "weight_series_in_space"
_TOLERANCES = _SETTINGS + "tolerances"
_SIDES = ".problem.matrices:SIDES"

#: Rules that concern only blocks in space, in the form of ``ABLATIONS``.
IN_SPACE: dict[str, tuple[str, dict[str, Any]]] = {
    "slowly-rising-weight": ("coulomb", {_WEIGHTS: lambda old: old[1:]}),
    "heavy-weight-next": ("coulomb", {_WEIGHTS: lambda old: old[:1]}),
    "rising-to-1e6": ("coulomb", {_WEIGHTS: lambda old: (old[0], old[1][:5])}),
    "seven-rises": ("coulomb", {_WEIGHTS: lambda old: (old[0][::2], old[1])}),
    "weights-from-3": ("coulomb", {_WEIGHTS: lambda old: (old[0][2:], old[1])}),
    "rougher-tolerances": ("coulomb", {_TOLERANCES: lambda old: old[:1]}),
    "tightest-tolerance": ("coulomb", {_TOLERANCES: lambda old: old[1:]}),
    "programs-nearly-solved": ("coulomb", {"exact.alternation:ExactPrograms._solved": _solved_alone}),
    "energy-left": ("coulomb", {_SETTINGS + "largest_energy": 1e-8}),
    "sixteen-sides": ("coulomb", {_SIDES: 16}),
    "thirty-two-sides": ("coulomb", {_SIDES: 32}),
    "search-random-forces-in-space": ("search", {_SEARCH + "_KINDS_IN_SPACE": _without("random forces")}),
    "search-self-stress-in-space": ("search", {_SEARCH + "_KINDS_IN_SPACE": _without("self-stress")}),
}

#: For each name, a key of ``MEASURED`` and the attributes to change. An attribute "module:NAME" is a NAME in
#: a module of ``masonry_opt.methods``, and ".module:NAME" in a module of ``masonry_opt``. Its value is the
#: new value, or a function of the old value.
ABLATIONS: dict[str, tuple[str, dict[str, Any]]] = {
    "small-cohesion-of-a-block": ("nonassociative", {"loop.steps:_LARGEST_FORCE_RATIO": inf}),
    "end-at-the-larger-mechanism": ("nonassociative", {_RUN + "_MOVING_RATE_SHARES": (1e-4,)}),
    "end-at-the-surer-mechanism": ("nonassociative", {_RUN + "_MOVING_RATE_SHARES": (1e-6,)}),
    "divergence": ("nonassociative", {_RUN + "_MOST_DOUBLINGS": 999, _RUN + "_MOST_STEADY_INCREASES": 999}),
    "slow-divergence": ("nonassociative", {_RUN + "_MOST_STEADY_INCREASES": 999}),
    "cycles": ("nonassociative", {_RUN + "_LARGEST_CYCLE_DRIFT": 0.0}),
    **{
        f"remedy-{failure.name.lower().replace('_', '-')}": (
            "nonassociative",
            {_REMEDIES: _without(str(failure))},
        )
        for failure in REMEDIES
    },
    "early-end": ("rough", {_RUN + "_NEARLY_TRUE": 0.0}),
    "early-end-not-before": ("rough", {_RUN + "_NEARLY_TRUE": inf}),
    "pause-between-ends": ("rough", {_RUN + "_SUB_PROBLEMS_BETWEEN_TRIALS": 1}),
    "energy-weighs-10": ("rough", {_ENERGY: lambda old: (10.0, *old[1:])}),
    "energy-weighs-100": ("rough", {_ENERGY: lambda old: (100.0, *old[1:])}),
    "rough-sub-problems": ("nonassociative", {"loop.options:ROUGH_FROM": inf}),
    "energy-weighs-100-in-repairs": ("coulomb", {_SETTINGS + "weight": 100.0}),
    "further-starts": ("coulomb", {_SETTINGS + "small": 0}),
    "hundred-in-a-row": ("coulomb", {_SETTINGS + "starts_in_vain": 30}),
    "random-forces": ("coulomb", {_SEARCH + "_KINDS_IN_PLANE": _without("random forces")}),
    "neighbours": ("coulomb", {_SEARCH + "_KINDS_IN_PLANE": _without("neighbour")}),
    "fixed-points": ("coulomb", {_SEARCH + "_KINDS_IN_PLANE": _without("fixed point")}),
    "fixed-points-settle": ("coulomb", {_SETTINGS + "fixed_point_iterations": 1}),
    "two-repairs": ("coulomb", {_SETTINGS + "repairs": 1}),
    "one-alternation": ("coulomb", {_SETTINGS + "weights_in_plane": (1e4,)}),
    "light-energy-first": ("coulomb", {_SETTINGS + "weights_in_plane": (30.0, 1e3)}),
    "a-heavier-energy": ("coulomb", {_SETTINGS + "weights_in_plane": (1e4, 1e5)}),
    "search-neighbours": ("search", {_SEARCH + "_KINDS_IN_PLANE": _without("neighbour")}),
    "search-fixed-points": ("search", {_SEARCH + "_KINDS_IN_PLANE": _without("fixed point")}),
    "repeat-what-pays": ("global", {_PRODUCTS + "_WORTH_REPEATING": inf}),
    "older-interior-point": ("global", {_BOUND + "_FEW_ROWS": 0}),
    "coarse-interior-point": ("global", {_BOUND + "_TOLERANCE_OVER_GAP": 0.0}),
    "fastest-velocity": ("global", {_BOUND + "_LARGEST_RATE": 1e3}),
    "excess-of-unbalanced-forces": ("incremental", {"incremental.analysis:_excess": lambda _: _no_excess}),
    "near-products-first": ("global", {_PRODUCTS + "_RADII": lambda old: old[3:]}),
    **IN_SPACE,
}


@dataclass(frozen=True)
class Measured:
    """Results of one run.

    ``value`` is λ (for method "global" the proven bound), or None without an answer. ``exact`` is True if the
    state is exact, and ``incremental`` if an incremental load factor exists. ``seconds`` is processor time.
    """

    value: float | None
    exact: bool
    incremental: bool
    steps: int
    seconds: float


def measured(scene: mo.Scene, name: str) -> Measured:
    began = time.process_time()
    result = mo.solve(scene, **{"method": name, "incremental": False} | MEASURED[name])
    value = result.bound if name == "global" else result.load_factor
    exact = result.exact or any(reason.code is Code.COLLAPSE for reason in result.reasons)
    return Measured(
        value, exact, result.incremental is not None, result.iterations, time.process_time() - began
    )


def scenes(asked: argparse.Namespace) -> list[mo.Scene]:
    """Return the scenes that the options name. Random scenes with unconnected blocks are left out."""
    return [scene for scene in _named_scenes(asked) if _hangs_together(scene)]


def _named_scenes(asked: argparse.Namespace) -> Iterator[mo.Scene]:
    seeds = range(asked.first, asked.first + asked.random)
    yield from (random_scene(kind, seed) for kind in KINDS for seed in seeds)
    held_seeds = range(asked.first, asked.first + asked.held)
    yield from (held(kind, seed) for kind in KINDS for seed in held_seeds)
    for number in asked.walls:
        wall = mo.load(ROOT / "cases" / "ferris_tinloi" / f"wall_{number}.toml")
        for share in (0.6, 0.85, 1.2):
            title = f"{wall.title}, {share} of friction"
            yield wall.replace(friction=share * wall.joints.friction, title=title)
    for stones in (60, 200) if asked.rubble else ():
        yield from (rubble(stones, asked.first + number) for number in range(asked.rubble))
    yield from (entry.scene(ROOT / "cases") for entry in ATLAS) if asked.atlas else ()
    seeds = range(asked.first_in_space, asked.first_in_space + asked.space)
    yield from (random_scene_in_space(kind, seed) for kind in KINDS_IN_SPACE for seed in seeds)
    for size in CORNERS if asked.space else ():
        for friction in CORNER_FRICTIONS:
            title = f"corner {size}, friction {friction}"
            yield corner_wall(*size, friction).replace(title=title)
    sizes = [(1, 1, 3), (2, 1, 3), (2, 2, 3), (3, 2, 3)] if asked.facades else []
    common: Any = {"weight": 1, "live": (1, 0), "block": (3, 1)}
    common_facade = common | {"jamb": 1, "sill": 2, "spandrel": 2, "lintel_weight": 1}
    for across, up, high in sizes + ([(4, 4, 5), (3, 6, 7)] if asked.large else []):
        facade = mo.Facade(openings=(across, up), opening=(1, high), **common_facade)
        yield from _of_frictions(f"façade {across} x {up}", facade.blocks())
    if asked.large:
        wall = mo.Wall(courses=[[1.0] * 20, [0.5, *[1.0] * 19, 0.5]] * 10, **common)
        yield from _of_frictions("wall", wall.blocks())


def _of_frictions(title: str, blocks: list[mo.Block]) -> Iterator[mo.Scene]:
    for friction in (0.5, 0.8):
        joints = mo.JointDefaults(friction=friction)
        yield mo.Scene(title=f"{title}, friction {friction}", joints=joints, blocks=blocks)


def changed(changes: dict[str, Any]) -> ExitStack:
    """Change attributes, as in ``ABLATIONS``, and return a context manager that restores them at its end."""
    with ExitStack() as stack:
        for where, value in changes.items():
            module, path = where.split(":")
            *owners, attribute = path.split(".")
            of: Any = import_module(f".{module}", "masonry_opt.methods")
            for owner in owners:
                of = getattr(of, owner)
            old = getattr(of, attribute)
            new = value(old) if callable(value) else value
            if isinstance(of, SearchSettings):
                # Settings are frozen, so that patch.object cannot set them.
                object.__setattr__(of, attribute, new)
                stack.callback(object.__setattr__, of, attribute, old)
            else:
                stack.enter_context(patch.object(of, attribute, new))
        return stack.pop_all()


def lost(before: list[Measured], after: list[Measured]) -> str:
    pairs = list(zip(before, after, strict=True))
    both = [(old.value, new.value) for old, new in pairs if None not in (old.value, new.value)]
    change = np.array([(new - old) / max(abs(old), SMALLEST) for old, new in both])  # type: ignore[operator]
    answers = sum(new.value is not None for _, new in pairs) - sum(old.value is not None for old, _ in pairs)
    exact = sum(new.exact for new in after) - sum(old.exact for old in before)
    expected = sum(new.incremental for new in after) - sum(old.incremental for old in before)
    phrases = [f"answers {answers:+d}", f"exact {exact:+d}", f"incremental {expected:+d}"]
    for word, part in (
        ("higher", 100 * change[change > EQUALITY_TOLERANCE]),
        ("lower", -100 * change[change < -EQUALITY_TOLERANCE]),
    ):
        by = f" by {part.mean():.2g} %, at most {part.max():.2g}" if len(part) else ""
        phrases.append(f"λ {word} {len(part)}{by}")
    for word in ("steps", "seconds"):
        was, now = (sum(getattr(run, word) for run in runs) for runs in (before, after))
        phrases.append(f"{word} × {now / max(was, 1e-9):.2f}")
    return "; ".join(phrases)


def _hangs_together(scene: mo.Scene) -> bool:
    """Return True if all blocks of a random scene are connected to a support."""
    try:
        assemble(scene)
    except mo.CaseError:
        return False
    return True


def main(asked: argparse.Namespace) -> None:
    chosen, before = scenes(asked), {}
    print(f"{len(chosen)} scenes")
    names = [one for name in asked.names for one in (IN_SPACE if name == "in-space" else [name])]
    for name in names or ABLATIONS:
        method, changes = ABLATIONS[name]
        if method not in before:
            before[method] = [measured(scene, method) for scene in chosen]
        with changed(changes):
            after = [measured(scene, method) for scene in chosen]
        print(f"{name} ({method}): {lost(before[method], after)}", flush=True)
        if asked.verbose:
            for scene, old, new in zip(chosen, before[method], after, strict=True):
                if old.value != new.value:
                    print(f"    {scene.title}: {old} -> {new}")


def _numbers(of: Any, *place: int) -> Iterator[tuple[tuple[int, ...], Any]]:
    """Yield the place and value of each number of a setting, which may be a tuple of tuples."""
    if isinstance(of, tuple):
        for key, part in enumerate(of):
            yield from _numbers(part, *place, key)
    else:
        yield place, of


def _with(number: Any, place: tuple[int, ...], of: Any) -> Any:
    """Return a setting with the number at a place replaced."""
    if not place:
        return number
    parts = list(of)
    parts[place[0]] = _with(number, place[1:], parts[place[0]])
    return tuple(parts)


def around(number: Any) -> tuple[Any, Any]:
    """Return a number divided and multiplied by three, or by ten for a tolerance; a share stays below one."""
    factor, most = 10 if abs(number) < 1e-5 else 3, 0.99 if 0 < number < 1 else inf
    less, more = number / factor, min(number * factor, most)
    return (round(less), round(more)) if isinstance(number, int) else (less, more)


def cells(*both: list[Measured]) -> list[str]:
    """Return the cells of a row: runs that lose or gain answers or exact states, changes of λ, time ratio.

    The changes of λ are the numbers of changes above 1e-6 and above 1e-3, and the largest change.
    """
    was, now = (np.array([[run.value, run.exact or None] for run in of], float) for of in both)
    less, more = ((np.isnan(b) > np.isnan(a)).any(axis=1).sum() for a, b in ((was, now), (now, was)))
    change = np.nan_to_num(np.abs(now - was) / np.maximum(np.abs(was), SMALLEST)).max(axis=1)
    before, after = (sum(run.seconds for run in of) for of in both)
    counts = [f"{(change > least).sum()}" for least in (EQUALITY_TOLERANCE, 1e-3)]
    return [f"-{less} +{more}", *counts, f"{change.max():.0e}", f"{after / before:.2f}"]


def vary_settings(asked: argparse.Namespace) -> None:
    """Print a row for each number of the search settings, smaller and larger."""
    chosen = scenes(asked)
    before = [measured(scene, "coulomb") for scene in chosen]
    print(f"{len(chosen)} scenes\n| setting | is | tried | answers | λ > 1e-6 | > 1e-3 | most | time × |")
    print("|---" * 8 + "|")
    for field in fields(SEARCH):
        if asked.settings and field.name not in asked.settings:
            continue
        for place, number in _numbers(getattr(SEARCH, field.name)):
            for new in around(number):
                row = ["not possible"]
                # The lower end of a range cannot be larger than its upper end.
                with suppress(ValueError), changed({_SETTINGS + field.name: partial(_with, new, place)}):
                    row = cells(before, [measured(scene, "coulomb") for scene in chosen])
                label = f"| `{field.name}{''.join(f'[{key}]' for key in place)}` | {number:g}"
                print(label, f"{new:.3g}", *row, "", sep=" | ", flush=True)


if __name__ == "__main__":
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument(
        "names", nargs="*", choices=[[], "in-space", *ABLATIONS], metavar="NAME", help="default: all"
    )
    parser.add_argument("--list", action="version", version="\n".join(ABLATIONS), help="the names there are")
    parser.add_argument("--random", type=int, default=10, help="random scenes of each of the four kinds")
    parser.add_argument("--held", type=int, default=0, help="plane scenes with ties and props of each kind")
    parser.add_argument("--first", type=int, default=FIRST_SEED, help="the first seed")
    parser.add_argument("--space", type=int, default=0, help="the same of the four kinds in space")
    parser.add_argument("--first-in-space", type=int, default=FIRST_SEED_IN_SPACE, help="the first seed")
    parser.add_argument("--rubble", type=int, default=0, help="rubble walls of 60 and of 200 stones")
    parser.add_argument("--atlas", action="store_true", help="the failure atlas")
    parser.add_argument("--walls", type=lambda text: text.split(",") if text else [], default=list("123"))
    parser.add_argument("--facades", action=argparse.BooleanOptionalAction, default=True)
    parser.add_argument("--large", action="store_true", help="scenes of more than 1000 joints too")
    parser.add_argument("--verbose", "-v", action="store_true", help="name each scene that ends elsewhere")
    parser.add_argument("--settings", nargs="*", metavar="FIELD", help="fields of SearchSettings; or all")
    asked = parser.parse_args()
    main(asked) if asked.settings is None else vary_settings(asked)
