"""Count false alarms and hits of messages about mortar, errors of a survey, and tolerances.

    python benchmarks/drawing_warnings.py --scenes 24 --first 7900000
    python benchmarks/drawing_warnings.py --scenes 24 --first 7950000 --thresholds
    python benchmarks/drawing_warnings.py --scenes 8 --first 8412000 --uneven

Random walls, arches, tessellations and bonded walls are drawn in several ways: exactly, with errors of the
corners as in a survey, without their mortar, or both. The tolerances of a correct drawing are right; those of
a mistaken drawing are missing, too small or too large. Counted are the drawings with these outcomes:

- right: no message about a correct drawing. For a mistaken drawing, an error or a warning advises tolerances
  with which the scene has all joints of the same drawing with the right tolerances.
- other: a message, or advice with which joints are missing.
- silent: no message about a mistaken drawing.

Two rows are different. Fine arches have a large tolerance, which makes voussoirs parallel; a warning must
name the turned joints. In other scenes, a small gap separates the highest block from the block below it. With
--thresholds, the script also counts right drawings with other values of each threshold.

With --uneven, the script counts only the scenes of ``rough_sides.py`` with a warning about uneven sides.
"""

import argparse
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import numpy as np
import shapely

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.random_scenes import random_scene  # noqa: E402
from brickwork import drawn_to_touch, facade  # noqa: E402
from changed_constants import changed  # noqa: E402
from rough_sides import groups  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.problem.assembly import Assembly, assemble  # noqa: E402
from masonry_opt.reporting.sentences import sentences  # noqa: E402
from masonry_opt.scene import geometry  # noqa: E402
from masonry_opt.scene.contacts import gaps, mortar, overlaps  # noqa: E402
from masonry_opt.solution import wedges  # noqa: E402
from masonry_opt.solution.reasons import Code  # noqa: E402
from masonry_opt.solution.sense import warnings_of  # noqa: E402

KINDS = ("wall", "arch", "tessellation", "bond")
#: Name of the row of fine arches with a large tolerance.
FLATTENED = "fine arch, large tolerance"
#: Name of the row of drawings with one block at a wrong place.
MOVED = "highest block moved"
#: Least and largest distance of the block from its right place, relative to its width.
DISTANCES = (0.002, 0.02)
#: Codes of the warnings about drawings.
CODES = (Code.SMALL_GAPS, Code.LOST_JOINTS, Code.BRIDGED_BY_TOLERANCE, Code.ALIGNED, Code.UNEVEN_SIDES)


class Threshold(NamedTuple):
    """A constant of the messages, and the modules that use it."""

    name: str
    modules: tuple[ModuleType, ...]


THRESHOLDS = (
    Threshold("NEAR_MISS", (geometry, mortar, gaps)),
    Threshold("_NEAR_TOLERANCES", (geometry,)),
    Threshold("MORTAR", (mortar, overlaps)),
    Threshold("_WIDEST_OF_MORTAR", (mortar,)),
    Threshold("_MOST_OF_THICKNESS", (mortar,)),
    Threshold("_PARALLEL_ERROR", (mortar,)),
    Threshold("_SURVEY_ERROR", (mortar,)),
    Threshold("_SURVEY_FRACTION", (mortar,)),
    Threshold("_NAMED_TURN", (wedges,)),
    Threshold("_TOLERANCE_OVER_DIFFERENCE", (gaps,)),
    Threshold("TOLERANCE_OVER_ERROR", (gaps, wedges)),
)


#: Values with which the thresholds of the warning about uneven sides have no effect.
OFF = {"_UNEVEN_ANGLE": 2.0, "_UNEVEN_SHARE": 0.0}


class Drawing(NamedTuple):
    """A way to draw a scene: mortar and errors, relative to the mean width of a block, and tolerances."""

    name: str
    mortar: float
    error: float
    #: Return the tolerance and the contact tolerance from the mortar and the error; None for the default.
    tolerances: Callable[[float, float], tuple[float | None, float | None]]
    is_correct: bool


def _drawings() -> Iterator[Drawing]:
    """Yield all drawings. Each correct drawing precedes the mistaken drawings that should have its joints."""
    yield Drawing("exact", 0.0, 0.0, _default, is_correct=True)
    for error in (1e-4, 1e-3, 5e-3):
        name = f"survey {error:g}"
        yield Drawing(name, 0.0, error, lambda _, e: (3 * e, None), is_correct=True)
        yield Drawing(f"{name}, no tolerance", 0.0, error, _default, is_correct=False)
        yield Drawing(f"{name}, tolerance / 10", 0.0, error, lambda _, e: (0.3 * e, None), is_correct=False)
    yield Drawing("mortar 0.02", 0.02, 0.0, _right_for_mortar, is_correct=True)
    for share in (0.8, 1.0):
        # The joints are those of the exact drawing, although some stones overlap.
        yield Drawing(f"mortar 0.02, errors {share:g} of it", 0.02, share * 0.02, _default, is_correct=False)
    for gap in (0.03, 0.1):
        for error, name in ((0.0, f"mortar {gap:g}"), (2e-3, f"mortar {gap:g}, survey")):
            yield Drawing(name, gap, error, _right_for_mortar, is_correct=True)
            yield Drawing(f"{name}, no tolerance", gap, error, _default, is_correct=False)
            yield Drawing(f"{name}, as tolerance", gap, error, _tolerance_as_mortar, is_correct=False)


def _default(mortar: float, error: float) -> tuple[float | None, float | None]:
    return None, None


def _right_for_mortar(mortar: float, error: float) -> tuple[float | None, float | None]:
    return 3 * error or None, 1.01 * mortar + 4 * error


def _tolerance_as_mortar(mortar: float, error: float) -> tuple[float | None, float | None]:
    return 1.2 * mortar + 4 * error, None


DRAWINGS = tuple(_drawings())


def exact_scene(kind: str, seed: int) -> mo.Scene:
    """Return the exact drawing of a scene."""
    if kind != "bond":
        return random_scene(kind, seed)
    rng = np.random.default_rng([37, seed])
    return drawn_to_touch(facade(int(rng.integers(2, 5)), int(rng.integers(3, 8)), length=0.24))


def drawn(scene: mo.Scene, drawing: Drawing, seed: int) -> mo.Scene:
    """Return the scene in another drawing. Supports are exact."""
    width = float(assemble(scene).geometry.width[~scene.fixed].mean())
    gap, error = drawing.mortar * width, drawing.error * width
    rng, blocks = np.random.default_rng([41, seed]), []
    for block in scene.blocks:
        corners = np.array(block.vertices)
        if gap:
            shrunk = shapely.Polygon(corners).buffer(-gap / 2, join_style="mitre", mitre_limit=100)
            corners = shapely.get_coordinates(shapely.remove_repeated_points(shrunk))[:-1]
        if error and not block.fixed:
            corners = corners + rng.uniform(-error, error, corners.shape)
        blocks.append(block.replace(vertices=corners.tolist(), live_at=None))
    tolerance, contact_tolerance = drawing.tolerances(gap, error)
    scene = scene.replace(blocks=blocks)
    return with_tolerances(scene, tolerance, contact_tolerance)


def with_tolerances(scene: mo.Scene, tolerance: float | None, contact: float | None) -> mo.Scene:
    """Return the scene with both tolerances; None for the default."""
    return scene.replace(tolerance=tolerance, contact_tolerance=contact)


def pairs_of(scene: mo.Scene) -> set[frozenset[str]]:
    """Return the pairs of blocks that have a joint."""
    assembly = assemble(scene)
    return {frozenset(pair) for pair in assembly.pairs_of(np.arange(len(assembly.joints.first)))}


def messages(scene: mo.Scene) -> list[str]:
    """Return the error of a scene, or its warnings about the drawing."""
    try:
        found = warnings_of(assemble(scene), None)
    except mo.CaseError as error:
        return [str(error)]
    return list(sentences([warning for warning in found if warning.code in CODES]))


def outcome(scene: mo.Scene, drawing: Drawing, expected: set[frozenset[str]]) -> str:
    """Return "right", "other" or "silent" for a drawn scene with the expected joints."""
    said = messages(scene)
    if drawing.is_correct:
        return "other" if said else "right"
    if not said:
        return "silent"
    advised = dict(re.findall(r"'(contact_tolerance|tolerance)' to ([\d.e-]+\d)", " ".join(said)))
    kept = None if "remove 'tolerance'" in " ".join(said) else scene.tolerance
    tolerance = float(advised["tolerance"]) if "tolerance" in advised else kept
    contact = float(advised["contact_tolerance"]) if "contact_tolerance" in advised else None
    if not advised:
        return "other"
    try:
        return "right" if pairs_of(with_tolerances(scene, tolerance, contact)) >= expected else "other"
    except mo.CaseError:
        return "other"


def measured(first: int, count: int) -> dict[str, Counter[str]]:
    """Return the outcomes of all drawings of some scenes, by the name of the drawing."""
    names = [*(drawing.name for drawing in DRAWINGS), FLATTENED, MOVED]
    found: dict[str, Counter[str]] = {name: Counter() for name in names}
    for seed in range(first, first + count):
        scene, expected = exact_scene(KINDS[seed % len(KINDS)], seed), set()
        for drawing in DRAWINGS:
            made = drawn(scene, drawing, seed)
            if drawing.is_correct:
                expected = pairs_of(made)
            found[drawing.name][outcome(made, drawing, expected)] += 1
        found[FLATTENED][flattened(seed)] += 1
        mistaken = Drawing(MOVED, 0.0, 0.0, _default, is_correct=False)
        found[MOVED][outcome(moved(scene, seed), mistaken, pairs_of(scene))] += 1
    return found


def moved(scene: mo.Scene, seed: int) -> mo.Scene:
    """Return the scene with a small gap below its highest block."""
    shapes = assemble(scene).geometry
    index = int(np.argmax(np.where(scene.fixed, -np.inf, shapes.centroid[:, 1])))
    distance = np.random.default_rng([47, seed]).uniform(*DISTANCES) * shapes.width[index]
    block = scene.blocks[index]
    corners = [(x, y + distance) for x, y in block.vertices]
    return scene.replace(blocks={block.name: {"vertices": corners, "live_at": None}})


def flattened(seed: int) -> str:
    """Return "right" if a warning names the turned joints of a fine arch with a large tolerance."""
    rng = np.random.default_rng([43, seed])
    span, thickness = float(rng.uniform(2, 20)), float(rng.uniform(0.03, 0.08))
    # A flat arch of angle β has a rise of about span β / 8. The angle of a voussoir is 0.006 to 0.015 rad.
    voussoirs, angle = int(rng.integers(30, 80)), float(rng.uniform(0.006, 0.015))
    arch = mo.Arch(
        span=span,
        rise=span * voussoirs * angle / 8,
        thickness=thickness * span,
        voussoirs=voussoirs,
        unit_weight=20,
        live_per_weight=(1, 0),
    )
    tolerance = float(rng.uniform(0.6, 1.5)) * angle * thickness * span
    warned = messages(mo.Scene(joints={"friction": 0.6}, blocks=arch.blocks(), tolerance=tolerance))
    return "right" if any("joints were turned" in sentence for sentence in warned) else "silent"


def right(found: dict[str, Counter[str]]) -> tuple[int, int]:
    """Return the numbers of correct and of mistaken drawings with the right outcome."""
    correct = sum(found[drawing.name]["right"] for drawing in DRAWINGS if drawing.is_correct)
    return correct, sum(each["right"] for each in found.values()) - correct


def print_uneven(first: int, count: int) -> None:
    """Print how many scenes have a warning about uneven sides, for several values of each threshold."""
    found: dict[tuple[str, bool], list[Assembly]] = {}
    for group, is_survey, assembly in groups(first, count, lambda seed: exact_scene(KINDS[seed % 4], seed)):
        found.setdefault((group, is_survey), []).append(assembly)

    def named() -> dict[tuple[str, bool], int]:
        return {key: sum(any(wedges.uneven_sides(each)) for each in found[key]) for key in found}

    usual = named()
    print("scenes,number,warnings,expected")
    for (group, is_survey), number in usual.items():
        total = len(found[group, is_survey])
        print(f'"{group}"', total, number, total if is_survey else 0, sep=",", flush=True)
    print("threshold,value,hits,false alarms,changed groups")
    for name, off in OFF.items():
        value = getattr(wedges, name)
        for label, other in (("/ 3", value / 3), ("x 3", 3 * value), ("off", off)):
            with changed([wedges], name, other):
                more = {key: number - usual[key] for key, number in named().items()}
            hits, alarms = (
                sum(more[key] for key in more if key[1] == expected) for expected in (True, False)
            )
            where = "; ".join(f"{key[0]} {number:+d}" for key, number in more.items() if number)
            print(name, label, f"{hits:+d}", f"{alarms:+d}", f'"{where}"', sep=",", flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenes", type=int, default=24, help="number of seeds")
    parser.add_argument("--first", type=int, default=7_900_000, help="first seed")
    parser.add_argument("--thresholds", action="store_true", help="also other values of each threshold")
    parser.add_argument("--uneven", action="store_true", help="only the warning about uneven sides")
    asked = parser.parse_args()
    if asked.uneven:
        print_uneven(asked.first, asked.scenes)
        return
    found = measured(asked.first, asked.scenes)
    print("drawing,right,other,silent")
    for name, ends in found.items():
        print(f'"{name}"', ends["right"], ends["other"], ends["silent"], sep=",", flush=True)
    usual = right(found)
    print("threshold,factor,correct drawings,mistaken drawings")
    for threshold in THRESHOLDS if asked.thresholds else ():
        value = getattr(threshold.modules[0], threshold.name)
        for label, factor in (("/ 3", 1 / 3), ("x 3", 3.0)):
            with changed(threshold.modules, threshold.name, factor * value):
                then = right(measured(asked.first, asked.scenes))
            changes = (f"{new - old:+d}" for new, old in zip(then, usual, strict=True))
            print(threshold.name, label, *changes, sep=",", flush=True)


if __name__ == "__main__":
    main()
