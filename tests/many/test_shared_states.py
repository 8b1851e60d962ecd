"""Tests of states that runs of a study share: a block by hand, a wall with a tie, and runs of a journal."""

import json

import pandas as pd
import pytest
from many.tables import same
from scenes import block_on_floor

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution.answer import certified
from masonry_opt.studies.many.run_warnings import warnings_of_falls
from masonry_opt.studies.many.shared_states import (
    RECORDED_UP_TO,
    FoundState,
    Screen,
    recorded_state,
    shared_answers,
)
from masonry_opt.studies.writing import JOURNAL, run_line

TOO_HIGH = 0.9  #: Load factor above all states of the block, which by hand overturns at 0.5 or slides at μ.
RISEN = {"load_factor": TOO_HIGH, "incremental": TOO_HIGH}


def row_of(scene, **changed):
    """Return the row of a run: its load factor, and the record of its state."""
    result = mo.solve(scene, incremental=False)
    record = recorded_state(result.assembly.problem, result.solution)
    return {"load_factor": result.load_factor, **record, **changed}


def standing_solid(friction):
    """Return a block in space, twice as high as wide, on a fixed floor, pushed along x."""
    block = mo.Solid(name="A", box=((0, 1), (0, 1), (0, 2)), weight=1.0, live_per_weight=(1, 0, 0))
    floor = mo.Solid(name="floor", box=((-1, 2), (-1, 2), (-1, 0)), fixed=True)
    return mo.Scene(joints=mo.JointDefaults(friction=friction), blocks=[block, floor], gravity=(0, 0, -1))


def shared(rows, scenes):
    return {
        one.run: (one.found_in, one.answer.load_factor) for one in shared_answers(rows, scenes.__getitem__)
    }


def test_a_state_is_shared_with_every_run_whose_limits_it_respects():
    """A state is shared with every run whose yield conditions it satisfies.

    A block twice as high as wide overturns at λ = 0.5 with a shear of 0.5 of its weight. This is a state for
    every friction of 0.5 or more, and for no smaller friction.
    """
    scenes = [block_on_floor(friction=friction) for friction in (0.6, 0.8, 0.45)]
    # These runs look as if their searches had missed the state.
    missed = {"load_factor": TOO_HIGH, "forces": None}
    rows = [row_of(scenes[0]), *(row_of(scene, **missed) for scene in scenes[1:])]
    assert shared(rows, scenes) == {1: (0, pytest.approx(0.5, abs=1e-9))}


def test_a_sliding_state_is_no_state_of_other_friction():
    """A joint that slides at μ = 0.3 has slack in its shear limit at μ = 0.4: the certificate rejects the
    state."""
    scenes = [block_on_floor(friction=friction) for friction in (0.3, 0.4)]
    rows = [row_of(scenes[0]), row_of(scenes[1], forces=None)]
    assert [row["load_factor"] for row in rows] == pytest.approx([0.3, 0.4], abs=1e-9)
    assert shared(rows, scenes) == {}


def test_other_loads_or_blocks_share_nothing():
    scenes = [block_on_floor(), block_on_floor(weight=2.0), block_on_floor(width=1.1), block_on_floor()]
    rows = [row_of(scenes[0]), *(row_of(scene, load_factor=TOO_HIGH, forces=None) for scene in scenes[1:])]
    assert shared(rows, scenes) == {3: (0, pytest.approx(0.5, abs=1e-9))}


@pytest.mark.slow
@pytest.mark.parametrize("of", [block_on_floor, standing_solid])
def test_the_screen_passes_every_state_that_the_certificate_accepts(of):
    """The screen is compared in the plane and in space, for blocks that slide, overturn, or have a
    friction far above 1."""
    results = [mo.solve(of(friction=friction), incremental=False) for friction in (0.2, 0.3, 0.5, 0.8, 5.0)]
    states = [
        FoundState(run, result.load_factor, result.solution.answer.q, result.solution.answer.d)
        for run, result in enumerate(results)
    ]
    screen = Screen.of(results[0].assembly.problem, states)
    accepted = 0
    for result in results:
        problem = result.assembly.problem.by_cone
        passed = {state.run for state in screen.possible(problem, states)}
        exact = {
            state.run
            for state in states
            if certified(problem, state.load_factor, state.q, state.d, problem.dilatancy).exact
        }
        assert exact <= passed
        accepted += len(exact)
    assert accepted > len(results)  # Each run has its own state, and runs that overturn share theirs.


def test_a_run_that_failed_takes_a_state_too():
    scenes = [block_on_floor(friction=friction) for friction in (0.6, 0.8)]
    rows = [row_of(scenes[0]), row_of(scenes[1], load_factor=None, forces=None)]
    assert shared(rows, scenes) == {1: (0, pytest.approx(0.5, abs=1e-9))}


def test_states_that_cannot_be_answers_are_not_recorded():
    """States of unstable scenes, and of scenes that are proven to carry any load, are not recorded."""
    falls = mo.solve(block_on_floor(dead=(2.0, 0.0)))
    assert falls.status is mo.Status.UNSTABLE
    carried = mo.solve(block_on_floor(live=(0.0, -1.0)))
    assert carried.solution.carries_any_load
    for result in (falls, carried):
        assert recorded_state(result.assembly.problem, result.solution) == {}
    assert RECORDED_UP_TO >= 1000


@pytest.mark.usefixtures("without_charts")
def test_runs_taken_up_from_a_journal_share_states(tmp_path):
    """A run of a journal takes a state of another run.

    The journal is changed so that its second run has λ = 0.9, as if its search had missed the state at 0.5.
    """
    asked = {"workers": 1, "out": tmp_path}
    vary = {"joints.friction": [0.6, 0.8]}
    found = mo.sweep(block_on_floor(), vary, **asked)
    assert found["state_from"].tolist() == ["", ""]
    path = tmp_path / JOURNAL
    head, *lines = path.read_text("utf-8").splitlines()
    rows = [json.loads(line) for line in lines]
    missed = next(row for row in rows if row["row"]["joints.friction"] == 0.8)
    missed["row"] |= RISEN | {"forces": None, "mechanism": "sliding", "slides": 1, "hinges": 0}
    changed = b"".join(run_line(line["key"], line["row"]) for line in rows)
    path.write_bytes(f"{head}\n".encode() + changed)
    before = path.read_text("utf-8")
    again = mo.sweep(block_on_floor(), vary, **asked)
    # No run was repeated, and the journal keeps the original results.
    assert path.read_text("utf-8") == before
    assert again["load_factor"].tolist() == pytest.approx([0.5, 0.5], abs=1e-9)
    assert again["state_from"].tolist() == ["", "state found at joints.friction = 0.6"]
    # The incremental λ stays that of the run.
    assert again["incremental"].tolist() == pytest.approx([0.5, TOO_HIGH], abs=1e-6)
    columns = ["exact", "mechanism", "slides", "hinges", "status"]
    pd.testing.assert_frame_equal(again[columns], found[columns])
    same(mo.sweep(block_on_floor(), vary, **asked), again)
    # A single run has no other run to share a state with.
    assert (
        mo.sweep(block_on_floor(), {"joints.friction": [0.8]}, force=True, **asked)["load_factor"][0] == 0.9
    )


def wall_with_rod(strength):
    """Return a wall of 14 stones in four courses, pushed along y, with a tie from stone 3-2 to the ground
    behind."""
    half, whole = 0.6, 1.2
    courses = [[whole] * 3, [half, whole, whole, half]] * 2
    blocks = []
    for course, lengths in enumerate(courses):
        end = 0.0
        for number, length in enumerate(lengths):
            box = ((end, end + length), (0.0, 0.6), (0.6 * course, 0.6 * course + 0.6))
            name, end = f"{course + 1}-{number + 1}", end + length
            blocks.append(mo.Solid(name=name, box=box, weight=12 * length, live_per_weight=(0, -1, 0)))
    blocks.append(mo.Solid(name="base", box=((-1.2, 4.8), (0.0, 0.6), (-0.6, 0.0)), fixed=True))
    ends = ((1.8, 0.3, 1.5), (1.8, 6.0, 1.5))
    rod = mo.Tie(name="rod", between=("3-2", "ground"), at=ends, strength=strength)
    joints = mo.JointDefaults(friction=0.6)
    return mo.Scene(joints=joints, blocks=blocks, ties=[rod], gravity=(0.0, 0.0, -1.0))


@pytest.mark.slow
def test_a_stronger_rod_shows_a_state_of_the_weaker_one():
    """A sweep over the strength of a tie finds the state of the stronger tie for the weaker one too.

    Without further starts, ties of 30 and 40 kN lead to 0.467 and to 0.3, where the tie carries less than 30
    kN. An independent program recomputed equilibrium, yield and flow of a state at 0.3 with 17.5 kN in the
    tie.
    """
    alone = mo.solve(wall_with_rod(30.0), descent=False)
    assert alone.load_factor == pytest.approx(0.467014, rel=1e-5)
    found = mo.sweep(wall_with_rod(30.0), {"tie.strength": [30.0, 40.0]}, workers=2, descent=False)
    assert found["load_factor"].tolist() == pytest.approx([0.3, 0.3], rel=1e-6)
    assert found["exact"].all()
    assert found["state_from"].tolist() == ["state found at tie.strength = 40", ""]


@pytest.mark.slow
def test_the_certificate_decides_which_rods_bear_the_state():
    """The certificate accepts the state for a tie that is stronger than its force, and rejects it for a
    weaker tie."""
    result = mo.solve(wall_with_rod(40.0), incremental=False)
    assert result.load_factor <= 0.3 * (1 + 1e-6)
    (force,), answer = result.ties["force"], result.solution.answer
    assert 0 < force < 40
    exact = {}
    for share in (0.9, 1.1):
        problem = assemble(wall_with_rod(share * force)).problem.by_cone
        state = certified(problem, answer.load_factor, answer.q, answer.d, problem.dilatancy)
        exact[share] = state.exact
    assert exact == {0.9: False, 1.1: True}


def swept(names, *rows):
    return pd.DataFrame(rows, columns=[*names, "load_factor"]).assign(status="converged")


def test_a_load_factor_that_falls_as_strength_grows_is_told():
    frame = swept(["tie.rod.strength"], (30.0, 0.467), (60.0, 0.31), (10.0, 0.2), (40.0, 0.3))
    (record,) = warnings_of_falls(frame, ["tie.rod.strength"], "coulomb")
    sentence = record["sentence"]
    assert "falls from 0.467000 at tie.rod.strength = 30 to 0.300000 at 40:" in sentence
    rising = swept(["joints.friction"], (0.3, 0.1), (0.4, 0.2), (0.5, 0.2 * (1 - 1e-8)), (0.6, float("nan")))
    assert [*warnings_of_falls(rising, ["joints.friction"], "coulomb")] == []
    # A thickness is not a limit on forces, so that no warning is given.
    thickened = swept(["arch.thickness"], (1.0, 2.0), (2.0, 1.0))
    assert [*warnings_of_falls(thickened, ["arch.thickness"], "coulomb")] == []


def test_of_two_numbers_only_one_differs_between_the_load_factors_compared():
    names = ["joints.friction", "arch.thickness"]
    rows = [(0.3, 1.0, 0.9), (0.3, 2.0, 0.5), (0.4, 1.0, 0.8), (0.4, 2.0, 0.6)]
    (warning,) = warnings_of_falls(swept(names, *rows), names, "coulomb")
    where = "from 0.900000 at joints.friction = 0.3 to 0.800000 at 0.4 (arch.thickness = 1)"
    assert where in warning["sentence"]
    assert warning["code"] == "falls with strength"
