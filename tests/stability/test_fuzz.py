"""Tests of broken case files: whatever they contain, a message results, never a traceback."""

import json
import random
import tomllib

import pytest
import tomli_w
from scenes import CASES
from unit.scene.test_case_files import WRITTEN

import masonry_opt as mo
from masonry_opt.errors import MasonryError
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.case_file import toml_text

#: Published cases: a wall, a façade, and arches with point loads, skewbacks and loads by name.
PUBLISHED = [
    CASES / f"{name}.toml"
    for name in (
        *("ferris_tinloi/wall_1", "gilbert/facade_1x3", "pippard_ashby/rib"),
        "examples/segmental_arch_on_columns",
    )
]
SEEDS = [toml_text(scene) for name, scene in WRITTEN.items() if name not in ("wall", "load cases")]
SEEDS += [path.read_text("utf-8") for path in PUBLISHED]

#: Replacements of a value or a key: other types, extreme numbers, and words with a meaning for a terminal or
#: a file system.
ODD_VALUES = [
    *(0, -1, 1, 2, 7, 0.5, -0.5, 1e-9, 1e-12, 1e-30, 1e-300, 5e-324, 1e6, 1e15),
    *(1e29, 1e30, 1e31, 1e308, 10**18, float("inf"), float("-inf"), float("nan"), True, False),
    *("", "inf", "nan", "A", "base", "H", "../../etc", "a" * 300, "\x1b[31m", "\u202e"),
    *("{x}", "{0.__class__}", "%s", "[/red]", "\\", "$\\frac{$", "\U0001f9f1", "\ud800"),
    *([], [1], [1, 2], [1, 2, 3], [[0, 0]], [[]], {}, {"name": "A"}, [{"name": "A"}], [None]),
]  # fmt: skip
ODD_KEYS = [
    *("", "name", "block", "joints", "x" * 200, "a.b", "a\nb", "\x1b[2J", "{x}", "live_at", "fixed", "wall"),
]  # fmt: skip
ODD_BYTES = [
    *(b"\x00", b"\xff\xfe", b"\xc3\x28", b"[", b"]", b'"', b"'" * 3, b"=", b"\n"),
    *(b"1e400", b"9" * 5000, b"#"),
]  # fmt: skip


def places(tree):
    """Yield every container and key of a tree of dictionaries and lists."""
    for key, value in list(tree.items() if isinstance(tree, dict) else enumerate(tree)):
        yield tree, key
        if isinstance(value, dict | list):
            yield from places(value)


def mutate_tree(tree, rng):
    """Make one change: a value is scaled, replaced, copied, doubled or removed, or a key is renamed."""
    found = list(places(tree))
    numbers = [(part, key) for part, key in found if type(part[key]) in (int, float)]
    if numbers and rng.random() < 0.5:  # The changed case is likely to load.
        container, key = rng.choice(numbers)
        container[key] = container[key] * rng.choice([0, -1, 1 + 1e-7, 1.001, 3, 1e-6, 1e12]) + rng.choice(
            [0, 0, 1]
        )
        return
    container, key = rng.choice(found)
    other, other_key = rng.choice(found)
    match rng.randrange(5):
        case 0:
            container[key] = rng.choice(ODD_VALUES)
        case 1:
            del container[key]
        case 2:
            container[key] = json.loads(json.dumps(other[other_key], default=str))
        case 3 if isinstance(container, dict):
            container[rng.choice(ODD_KEYS)] = container.pop(key)
        case 3:
            container.insert(key, container[key])
        case _:
            container[key] = None


def mutate_bytes(data, rng):
    """Return the data with one change: bytes are overwritten, inserted, cut or repeated."""
    at = rng.randrange(len(data))
    to = min(len(data), at + rng.randrange(1, 40))
    return rng.choice(
        [
            data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :],
            data[:at] + rng.choice(ODD_BYTES) + data[at:],
            data[:at] + data[to:],
            data[:to] + data[at:],
            data[:at],
        ]
    )


def mutant(rng, texts=SEEDS):
    """Return the suffix and the bytes of a case file with one to four mutations of one of the texts."""
    text = rng.choice(texts)
    if rng.random() < 0.25:
        data = text.encode()
        for _ in range(rng.randint(1, 4)):
            data = mutate_bytes(data, rng) or b"\n"
        return ".toml", data
    tree = tomllib.loads(text)
    for _ in range(rng.randint(1, 3)):
        mutate_tree(tree, rng)
        if not any(True for _ in places(tree)):
            break
    if rng.random() < 0.5:
        try:
            return ".toml", tomli_w.dumps(tree).encode("utf-8", "surrogatepass")
        except (TypeError, ValueError):  # TOML has no null.
            pass
    return ".json", json.dumps(tree).encode()


def outcome(path):
    """Return "loads" if the case loads and its solve ends in any status, or else the error message."""
    try:
        scene = mo.load(path)
        assemble(scene)
        if len(scene.blocks) < 60:
            mo.solve(scene, "static").to_json()
    except MasonryError as error:
        message = str(error)
        assert message
        assert len(message) < 20_000
        assert all(letter == "\n" or letter.isprintable() for letter in message), ascii(message)
        return message
    return "loads"


def outcomes(mutants, folder):
    for made_of, (ending, data) in mutants:
        path = folder / f"case{ending}"
        path.write_bytes(data)
        try:
            yield outcome(path)
        except Exception as error:
            error.add_note(f"{made_of}: {data!r}")
            raise


@pytest.mark.slow
def test_seeds_are_valid(tmp_path):
    for text in SEEDS:
        (tmp_path / "case.toml").write_text(text)
        assert outcome(tmp_path / "case.toml") == "loads"


@pytest.mark.slow
def test_mutated_case_files_end_in_a_message(tmp_path):
    made = ((seed, mutant(random.Random(seed))) for seed in range(40))
    messages = list(outcomes(made, tmp_path))
    # The mutations have an effect, and not always at the same place.
    assert 3 < messages.count("loads") < 27
    assert len({message.split(": ", 1)[-1][:40] for message in messages}) > 20
