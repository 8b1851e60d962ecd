"""Count false alarms and hits of the warnings about input, and what each rule and threshold is worth.

    python benchmarks/input_warnings.py --scenes 100 --first 7900000
    python benchmarks/input_warnings.py --scenes 60 --first 7950000 --thresholds

The scenes are random scenes of every kind with plausible materials, in one of several systems of units. Three
things are counted:

- False alarms: the correct scenes, and the case files and atlas of the repository, with each warning.
- Hits: copies of the scenes in kN and m with one typical mistake each. A mistake is named if the copy is
  refused, or has a warning that the correct scene lacks.
- With --thresholds, false alarms and hits if a rule is switched off, and if a threshold is a third or three
  times as large.

Nothing is solved: the warnings need the scene alone.
"""

import argparse
import copy
import math
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from atlas.entries import ATLAS  # noqa: E402
from changed_constants import changed  # noqa: E402
from mistakes import MISTAKES  # noqa: E402
from realistic_scenes import SYSTEMS, Tables, built, correct_scene, in_units  # noqa: E402

import masonry_opt as mo  # noqa: E402
from masonry_opt.problem.assembly import Assembly, assemble  # noqa: E402
from masonry_opt.solution import force_units, sense, typical_units  # noqa: E402
from masonry_opt.studies.crossing import units  # noqa: E402

REFUSED = "refused"

#: Functions that find the warnings of a rule, by the name of the rule.
FINDERS: dict[str, Callable[[Assembly], Any]] = {
    "joints": sense._joints,
    "weights": sense._weights,
    "fill weights": sense._fill_weights,
    "fill angles": sense._fill_angles,
    "struts": sense._strengths,
    "stresses": force_units.unusual_stresses,
    "lengths": force_units.unusual_lengths,
    "outside": sense._acting_outside,
    "axles": lambda assembly: units.unusual_axles(assembly, assembly.scene.axles),
}


class Threshold(NamedTuple):
    """A constant of the warnings: its modules and name, the rules that use it, and its value when off."""

    modules: tuple[ModuleType, ...]
    name: str
    rules: tuple[str, ...]
    off: Any


THRESHOLDS = (
    Threshold((sense,), "_OTHER_UNITS", ("weights", "fill weights"), math.inf),
    Threshold((typical_units,), "_TYPICAL", ("weights", "fill weights", "axles", "lengths"), {}),
    Threshold((sense,), "_OTHER_THICKNESS", ("weights",), math.inf),
    Threshold((sense,), "_WEIGHT_TO_FORCE_RATIO", ("weights", "struts"), math.inf),
    Threshold((sense,), "_DEAD_LOADS_TO_STRENGTH", ("struts",), math.inf),
    Threshold((sense,), "_SUM_TO_STRENGTH", ("struts",), math.inf),
    Threshold((force_units,), "_STRENGTH", ("stresses",), force_units._Range(0.0, math.inf)),
    Threshold((force_units,), "_COHESION", ("stresses",), force_units._Range(0.0, math.inf)),
    Threshold((sense,), "SMALL_FRICTION_ANGLE", ("fill angles",), 0.0),
    Threshold((sense,), "_HIGH_FRICTION", ("joints",), math.inf),
    Threshold((sense,), "_SMALL_FRICTION", ("joints",), 0.0),
    Threshold((force_units, units), "LARGEST_SCENE", ("lengths", "axles"), math.inf),
    Threshold((sense,), "_LARGEST_FORCE_DISTANCE", ("outside",), math.inf),
    Threshold((units,), "_LIGHTEST_AXLE", ("axles",), 0.0),
    Threshold((units,), "_HEAVIEST_AXLE", ("axles",), math.inf),
    Threshold((units,), "_LARGEST_RELATIVE_LOAD", ("axles",), math.inf),
)


class Sample(NamedTuple):
    """A scene with the name of its mistake ("" for a correct scene) and the codes of its warnings."""

    seed: int
    mistake: str
    assembly: Assembly | None  #: None if the scene is refused
    codes: dict[str, set[str]]  #: codes of the warnings of each rule


def codes_by_rule(assembly: Assembly, rules: tuple[str, ...] = ()) -> dict[str, set[str]]:
    """Return the codes of the warnings about an assembly that each rule finds; by default, of all rules.

    The rule "other" has the warnings without a threshold.
    """
    found = {name: {_code(each) for each in FINDERS[name](assembly)} for name in rules or FINDERS}
    if not rules:
        every = {_code(each) for each in sense.warnings_of(assembly, None)}
        found["other"] = every.difference(*found.values()) - {"axles left out"}
    return found


def _code(warning: Any) -> str:
    """Return the code of a warning with the key or the kind of load that it names."""
    values = warning if isinstance(warning, dict) else warning.as_dict()
    detail = values.get("key") or values.get("load")
    return f"{values['code']} ({detail})" if isinstance(detail, str) else str(values["code"])


def sample(tables: Tables, seed: int, mistake: str = "") -> Sample:
    """Return a scene with its warnings."""
    try:
        assembly = assemble(built(tables))
    except mo.CaseError:
        return Sample(seed, mistake, None, {REFUSED: {REFUSED}})
    return Sample(seed, mistake, assembly, codes_by_rule(assembly))


def correct_samples(seed: int) -> Iterator[Sample]:
    """Yield a correct scene in kN and m and in another system of units."""
    tables = correct_scene(seed)
    yield sample(tables, seed)
    others = [name for name in SYSTEMS if name != "kN, m"]
    name = others[seed % len(others)]
    # A common set of axles is in kN and m, so its scene cannot be in other units.
    if not any("set" in group for group in tables.get("axles", [])):
        yield sample(in_units(tables, *SYSTEMS[name]), seed, "")


def mistaken_samples(seed: int) -> Iterator[Sample]:
    """Yield copies of the correct scene in kN and m with one mistake each."""
    tables = correct_scene(seed)
    for number, mistake in enumerate(MISTAKES):
        mistaken = copy.deepcopy(tables)
        if mistake.make(mistaken, np.random.default_rng([31, seed, number])):
            yield sample(mistaken, seed, mistake.name)


def own_samples() -> Iterator[tuple[str, Assembly]]:
    """Yield the case files, in each load case, and the scenes of the atlas that are not refused."""
    scenes = [(entry.name, entry.scene(ROOT / "cases")) for entry in ATLAS]
    for path in sorted((ROOT / "cases").glob("*/*.toml")):
        scene = mo.load(path)
        scenes += [(path.stem, scene.in_case(case.name)) for case in scene.load_cases] or [(path.stem, scene)]
    for name, scene in scenes:
        try:
            yield name, assemble(scene)
        except mo.CaseError:
            continue


def flat(codes: dict[str, set[str]]) -> set[str]:
    """Return the codes of all rules."""
    return set().union(*codes.values())


def random_samples(first: int, count: int) -> tuple[list[Sample], list[Sample]]:
    """Return the correct and the mistaken scenes of ``count`` seeds. Seeds of refused scenes are left out."""
    correct, mistaken = [], []
    for seed in range(first, first + count):
        try:
            found = list(correct_samples(seed))
        except mo.CaseError:
            continue
        if found[0].assembly is not None:
            correct += found
            mistaken += mistaken_samples(seed)
    return correct, mistaken


def new_codes(each: Sample, codes: dict[str, set[str]], usual: dict[int, set[str]]) -> set[str]:
    """Return the codes of a mistaken scene that the correct scene of the seed lacks."""
    return flat(codes) - usual[each.seed]


def named(mistaken: list[Sample], usual: dict[int, set[str]], codes: list[dict[str, set[str]]]) -> int:
    """Return the number of mistaken scenes that are refused or have a new warning."""
    return sum(bool(new_codes(each, own, usual)) for each, own in zip(mistaken, codes, strict=True))


def print_hits(mistaken: list[Sample], usual: dict[int, set[str]]) -> None:
    """Print a row for each mistake: how many copies are refused, warned about, or pass in silence."""
    print("mistake,scenes,refused,warned,silent,warnings")
    for mistake in dict.fromkeys(each.mistake for each in mistaken):
        new = [new_codes(each, each.codes, usual) for each in mistaken if each.mistake == mistake]
        refused, silent = sum(REFUSED in codes for codes in new), sum(not codes for codes in new)
        by_code = Counter(code for codes in new for code in codes - {REFUSED})
        said = "; ".join(f"{count} {code}" for code, count in by_code.most_common())
        print(mistake, len(new), refused, len(new) - refused - silent, silent, said, sep=",")


def print_codes(correct: list[Sample], mistaken: list[Sample], usual: dict[int, set[str]]) -> None:
    """Print a row for each warning: false alarms, hits, and hits that no other warning names."""
    new = [new_codes(each, each.codes, usual) for each in mistaken]
    false = Counter(code for each in correct for code in flat(each.codes))
    print("warning,false alarms,hits,hits of this warning alone")
    for code in sorted({*false, *set().union(*new)}):
        print(code, false[code], sum(code in codes for codes in new), new.count({code}), sep=",")


def variants(threshold: Threshold) -> Iterator[tuple[str, Any]]:
    """Yield the values of a threshold to compare: off, a third, and three times as large."""
    value = getattr(threshold.modules[0], threshold.name)
    yield "off", threshold.off
    if isinstance(value, force_units._Range):
        for key, number in value._asdict().items():
            yield f"{key} / 3", value._replace(**{key: number / 3})
            yield f"{key} x 3", value._replace(**{key: number * 3})
    elif threshold.name == "_TYPICAL":
        yield "wider", {unit: (low / 1.5, 1.5 * high) for unit, (low, high) in value.items()}
        yield "narrower", {unit: (1.3 * low, high / 1.3) for unit, (low, high) in value.items()}
    else:
        yield "/ 3", value / 3
        yield "x 3", 3 * value


def print_thresholds(correct: list[Sample], mistaken: list[Sample], usual: dict[int, set[str]]) -> None:
    """Print a row for each value of each threshold: changes of false alarms and of hits."""
    usual_alarms = sum(bool(flat(each.codes)) for each in correct)
    usual_hits = named(mistaken, usual, _own(mistaken))
    print(f"{usual_alarms} of {len(correct)} correct scenes have a warning")
    print(f"{usual_hits} of {len(mistaken)} mistakes are named")
    print("threshold,value,false alarms,hits")
    for threshold in THRESHOLDS:
        for label, value in variants(threshold):
            with changed(threshold.modules, threshold.name, value):
                of_correct, of_mistaken = _again(correct, threshold.rules), _again(mistaken, threshold.rules)
            then = _usual(correct, of_correct)
            alarms = sum(bool(flat(codes)) for codes in of_correct) - usual_alarms
            hits = named(mistaken, then, of_mistaken) - usual_hits
            print(threshold.name, label, f"{alarms:+d}", f"{hits:+d}", sep=",")


def _own(samples: list[Sample]) -> list[dict[str, set[str]]]:
    return [each.codes for each in samples]


def _usual(correct: list[Sample], codes: list[dict[str, set[str]]]) -> dict[int, set[str]]:
    """Return the codes of the correct scene in kN and m, which is the first of its seed, by seed."""
    usual: dict[int, set[str]] = {}
    for each, own in zip(correct, codes, strict=True):
        usual.setdefault(each.seed, flat(own))
    return usual


def _again(samples: list[Sample], rules: tuple[str, ...]) -> list[dict[str, set[str]]]:
    """Return the codes of all scenes after some rules have searched again."""
    return [
        each.codes | codes_by_rule(each.assembly, rules) if each.assembly else each.codes for each in samples
    ]


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenes", type=int, default=100, help="number of seeds")
    parser.add_argument("--first", type=int, default=7_900_000, help="first seed")
    parser.add_argument("--own", action="store_true", help="also the case files and the atlas")
    parser.add_argument("--thresholds", action="store_true", help="also other values of each threshold")
    asked = parser.parse_args()
    for name, assembly in own_samples() if asked.own else ():
        for code in flat(codes_by_rule(assembly)):
            print(f"{name}: {code}")
    correct, mistaken = random_samples(asked.first, asked.scenes)
    usual = _usual(correct, _own(correct))
    print_codes(correct, mistaken, usual)
    print_hits(mistaken, usual)
    if asked.thresholds:
        print_thresholds(correct, mistaken, usual)


if __name__ == "__main__":
    main()
