"""Tests of broken case files and records of solids: each ends in a message, never in a traceback or a
wrong number."""

import json
import random
import time
import tomllib
import warnings

import numpy as np
import pytest
from scenes_in_space import box_on_floor
from speeds import slow
from stability.test_fuzz import ODD_VALUES, mutant, outcomes
from unit.scene.test_solids import CASE, A, scene

import masonry_opt as mo
from masonry_opt.errors import MasonryError
from masonry_opt.scene.case_file import toml_text

SEEDS = [CASE, toml_text(scene(A, tilt=(1, 0.2, 0)))]

#: Numbers that are added to a coordinate: from rounding errors to beyond the range of numbers.
OFF = [1e-12, -1e-9, 1e-7, -1e-6, 1e-5, -1e-4, 1e-3, -0.01, 0.1, -0.5, 1.0, -2.0]
OFF += [1e3, 1e6, 1e10, -1e15, 1e20, 1e29, 1e31, 1e200, float("inf"), float("nan")]

#: Factors of lengths, or of a load.
TIMES = [0.0, -1.0, 1e-300, 1e-30, 1e-12, 1e-6, 1e-3, 1e3, 1e6, 1e12, 1e25, float("nan")]

TOLERANCES = [1e-15, 1e-9, 1e-3, 0.1, 0.5, 3.0, 1e6, 0.0, -1.0]

#: Longest processor time of one file in seconds, solved twice.
LONGEST = 10.0


def mutate_shape(tree, rng):
    """Change a solid in a way that is likely to be read.

    The change is to corners, to the corners or the number of faces, to the size, to a load, or to the
    tolerance.
    """
    blocks = [block for block in tree["block"] if isinstance(block, dict)]
    shapes = [shape for block in blocks for shape in (block, *block.get("parts", ()))]
    shape = rng.choice([shape for shape in shapes if "box" in shape or "vertices" in shape])
    points, faces = shape.get("box") or shape["vertices"], shape.get("faces")
    match rng.randrange(9 if faces else 4):
        case 0:
            point = rng.choice(points)
            point[rng.randrange(len(point))] += rng.choice(OFF)
        case 1:
            times = rng.choice(TIMES)
            points[:] = [[times * value for value in point] for point in points]
        case 2:
            tree["tolerance"] = rng.choice(TOLERANCES)
        case 3:
            block = rng.choice(blocks)
            times, key = (
                rng.choice(TIMES),
                rng.choice(["weight", "unit_weight", "live", "dead", "live_moment"]),
            )
            value = block.get(key, 1.0)
            block[key] = [times * part for part in value] if isinstance(value, list) else times * value
        case 4:
            rng.choice(faces).reverse()
        case 5:
            faces.pop(rng.randrange(len(faces)))
        case 6:
            rng.choice(faces).insert(rng.randrange(4), rng.randrange(len(points)))
        case 7:
            points[rng.randrange(len(points))] = list(rng.choice(points))
        case 8:
            faces.append(list(rng.choice(faces)))


def told_of(path):
    """Return the error message about a file, or what is wrong with its answers, or "" if nothing is.

    The polygons of friction lie inside the cones, so that their λ is at most that of the cones.
    """
    began = time.process_time()
    try:
        cone, polygon = mo.solve(path, "static"), mo.solve(path, "static", solver="highs")
    except MasonryError as error:
        return str(error)
    assert str(cone)
    assert cone.to_json()
    assert time.process_time() - began < LONGEST
    if cone.load_factor is None or polygon.load_factor is None:
        return "" if cone.status is polygon.status else f"WRONG: {cone.status} and {polygon.status}"
    room = 1e-6 * abs(cone.load_factor) + 1e-7
    if 0.9 * cone.load_factor - room <= polygon.load_factor <= cone.load_factor + room:
        return ""
    return f"WRONG: {cone.load_factor} by cones, {polygon.load_factor} by polygons"


def test_seeds_are_valid(tmp_path):
    for text in SEEDS:
        (tmp_path / "case.toml").write_text(text)
        assert told_of(tmp_path / "case.toml") == ""


@pytest.mark.slow
def test_mutated_solids_end_in_a_message_or_a_true_number(tmp_path):
    """Warnings of NumPy are raised as errors, so that they fail the test."""
    messages, path = [], tmp_path / "case.json"
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        for seed in range(25):
            rng = random.Random(seed)
            tree = tomllib.loads(rng.choice(SEEDS))
            for _ in range(rng.randint(1, 2)):
                mutate_shape(tree, rng)
            path.write_text(json.dumps(tree))
            try:
                messages.append(told_of(path))
            except Exception as error:
                error.add_note(f"{seed}: {path.read_text()}")
                raise
            assert "WRONG" not in messages[-1], (seed, messages[-1], path.read_text())
    assert 3 < messages.count("") < 19
    assert len({message.split(": ", 1)[-1][:40] for message in messages}) > 10


@pytest.mark.slow
def test_anything_in_place_of_keys_and_values_ends_in_a_message(tmp_path):
    made = ((seed, mutant(random.Random(seed), SEEDS)) for seed in range(25))
    assert len(list(outcomes(made, tmp_path))) == 25


#: Values for a key: the odd values of case files, and objects of Python.
THINGS = [*ODD_VALUES, None, b"A", 1j, np.zeros(3), np.eye(3), np.nan, object(), {1}, range(3), mo.Solid, []]


#: Keys that accept many of these values, so that many scenes are solved.
MOSTLY_ACCEPTED = ("name", "weight")


@pytest.mark.parametrize(
    "key", [*slow(*MOSTLY_ACCEPTED), *(key for key in mo.Solid.model_fields if key not in MOSTLY_ACCEPTED)]
)
def test_anything_for_a_key_of_a_solid_makes_a_solid_or_a_message(key):
    good = {"name": "B", "box": [[2, 3], [0, 1], [0, 1]], "weight": 1}
    scene = box_on_floor()
    made = 0
    for thing in THINGS:
        try:
            solid = mo.Solid(**good | {key: thing})
            result = mo.solve(mo.Scene(joints=scene.joints, blocks=[*scene.blocks, solid]), "static")
            made += result.load_factor is not None
        except MasonryError:
            continue
    assert made < len(THINGS) / 2
