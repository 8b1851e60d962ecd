"""Plans of comparisons, runs in separate processes, and the registry of best known states."""

import subprocess
import sys
import tomllib
from functools import partial

import pytest
from atlas.made_scenes import write_atlas, write_random
from hogs import environment, is_gone, wait_until
from lines import line
from scenes import CASES, block_on_floor, two_blocks

import masonry_opt as mo
from masonry_opt.studies.compare.judge import BestKnown, best_known, lowest_exact
from masonry_opt.studies.compare.runs import Pair, find_scenes, plan, run_pair
from masonry_opt.studies.runner import FINISHED, run_alone


def test_a_run_returns_the_answer_and_its_cost():
    """A run in a process returns λ = 2.5 μ (by hand, Fig. 6 of the paper) to 1e-7, with times and memory."""
    case = CASES / "gilbert" / "two_blocks.toml"
    end = run_alone(partial(run_pair, case, Pair("static", "cvxpy", "clarabel", 1e-9), 30.0), 30, 4000)
    assert end.how == FINISHED
    assert end.value["load_factor"] == pytest.approx(0.25, rel=1e-7)
    assert end.value["incremental_seconds"] == 0  # runs do not compute the incremental load factor
    assert 0 < end.value["solve_seconds"] < end.value["wall"] < end.seconds
    assert end.peak > 50  # the libraries alone need more than 50 MB


def test_time_is_split_once_between_solves_of_one_model():
    """The times of all parts of a run do not exceed its total time.

    The clock of HiGHS continues in a model that stays loaded, so that times could be counted twice.
    """
    case = CASES / "ferris_tinloi" / "wall_1.toml"
    pair = Pair("nonassociative", "pyomo", "highs-ipm", 1e-8)
    value = run_alone(partial(run_pair, case, pair, 60.0), 60, 4000).value
    assert value["lp_solves"] > 3
    assert sum(value[name] for name in value if name.endswith("_seconds")) <= value["wall"]


@pytest.mark.slow
def test_a_comparison_that_is_killed_takes_its_run_along(tmp_path):
    """A comparison that is terminated within a run ends as with Ctrl-C, and leaves no process."""
    case = tmp_path / "two_blocks.toml"
    mo.save(two_blocks(), case)
    # Without the drawing library, the report at the end takes less time.
    program = "import hogs, sys; sys.modules['altair'] = None; "
    program += "from masonry_opt.studies.compare import comparison as c; "
    program += "c.runs.run_pair = hogs.start_and_sleep; from masonry_opt.cli import main; main()"
    arguments = ["compare", str(case), "--methods", "static", "--out", str(tmp_path)]
    comparison = subprocess.Popen(
        [sys.executable, "-c", program, *arguments],
        env=environment(),
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    wait_until(case.with_suffix(".started").exists, comparison)
    comparison.terminate()
    _, said = comparison.communicate(timeout=30)
    assert comparison.returncode == 130, said
    assert "repeat the command to continue" in said
    assert is_gone(comparison.pid)


def test_everything_admissible_is_planned_at_every_tolerance():
    found = plan(["static", "kinematic"], ["cvxpy", "pyomo"], ["clarabel", "highs"], [1e-4, 1e-8])
    combinations = {(pair.method, pair.model, pair.solver) for pair in found.pairs}
    assert combinations == {
        (method, model, solver)
        for method in ("static", "kinematic")
        for model, solver in (("cvxpy", "clarabel"), ("cvxpy", "highs"), ("pyomo", "highs"))
    }
    assert {pair.tolerance for pair in found.pairs} == {1e-4, 1e-8}
    assert len(found.pairs) == 12
    assert {item[1:3] for item in found.left_out} == {("pyomo", "clarabel")}
    assert all("solver 'clarabel' is unknown for model 'pyomo'" in reason for *_, reason in found.left_out)


@pytest.mark.parametrize(
    ("method", "models", "pair"),
    [
        ("mpec", ["cvxpy"], Pair("mpec", "pyomo", "casadi", None)),
        ("coulomb", ["cvxpy", "pyomo"], Pair("coulomb", "matrices", "newton", None)),
    ],
)
def test_a_method_with_tolerances_of_its_own_runs_once_with_its_own_solver(method, models, pair):
    assert plan([method], models, ["clarabel"], [1e-4, 1e-8]).pairs == (pair,)


def test_a_solver_the_method_does_not_take_is_left_out_with_a_reason():
    found = plan(["static", "nonassociative"], ["cvxpy", "pyomo"], ["scipy"], [1e-6])
    assert ("nonassociative", "pyomo", "scipy") in {item[:3] for item in found.left_out}
    assert all(reason for *_, reason in found.left_out)


def test_a_solver_that_is_not_installed_is_left_out_with_what_to_install(without):
    without("casadi")
    found = plan(["static", "mpec"], ["cvxpy"], ["highs"], [1e-6])
    assert {pair.solver for pair in found.pairs} == {"highs"}
    ((*_, solver, reason),) = found.left_out
    assert (solver, reason.endswith("pip install '.[mpec]'")) == ("casadi", True)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((["magic"], ["cvxpy"], ["clarabel"], [1e-6]), "method 'magic' is unknown"),
        ((["static"], ["ampl"], ["clarabel"], [1e-6]), "model 'ampl' is unknown"),
        ((["static"], ["cvxpy"], ["nix"], [1e-6]), "solver 'nix' is unknown"),
        ((["static"], ["cvxpy"], ["clarabel"], [0.0]), "tolerance must be"),
        ((["static"], ["pyomo"], ["clarabel"], [1e-6]), "nothing to compare: static, pyomo, clarabel"),
    ],
)
def test_wrong_names_are_refused(arguments, message):
    with pytest.raises(mo.OptionError, match=message):
        plan(*arguments)


@pytest.mark.parametrize("scenes", [[two_blocks()], two_blocks()])
def test_a_scene_made_in_python_is_to_be_saved_first(scenes):
    with pytest.raises(mo.OptionError, match=r"mo\.save"):
        mo.compare(scenes)


KNOWN = {"made/up": BestKnown(0.16, "by hand")}


def exact(**known):
    return line(**({"method": "mpec"} | known))


@pytest.mark.parametrize("method", ["mpec", "coulomb"])
def test_a_lower_exact_state_is_kept_with_its_method(method):
    found = lowest_exact([exact(method=method, load_factor=0.15)], KNOWN)
    assert found == {"made/up": BestKnown(0.15, method)}


def test_a_nearly_exact_state_alone_is_no_measure_of_others():
    """A single state that is nearly exact is not recorded as the lowest of its scene."""
    nearly_exact = exact(method="coulomb", load_factor=0.15)
    assert lowest_exact([nearly_exact], {}) == {}
    searched = exact(load_factor=0.151)
    assert lowest_exact([nearly_exact, searched], {}) == {"made/up": BestKnown(0.15, "coulomb")}


@pytest.mark.parametrize(
    "known",
    [
        {"load_factor": 0.17},
        {"load_factor": 0.15, "method": "coulomb", "complementarity": 1e-8},  # too large relative to λ
        {"load_factor": 0.16 - 1e-11},  # lower only by rounding
        {"load_factor": 0.15, "yield": 1e-7},
        {"load_factor": 0.15, "complementarity": None},
        {"load_factor": 0.15, "flow": float("nan")},
        {"load_factor": 0.15, "method": "nonassociative"},
        {"load_factor": 0.15, "method": "coulomb", "friction_law": "polygon of 24 sides"},
        {"load_factor": None},
    ],
)
def test_nothing_else_is(known):
    assert lowest_exact([exact(**known)], KNOWN) == KNOWN


def test_words_do_not_change_a_scene_but_numbers_do(tmp_path):
    mo.save(two_blocks(), tmp_path / "two.toml")
    (case,) = find_scenes([tmp_path / "two.toml"])
    mo.save(mo.load(case.path).model_copy(update={"title": "other"}), case.path)
    assert find_scenes([case.path])[0].content == case.content
    mo.save(two_blocks(0.2), case.path)
    assert find_scenes([case.path])[0].content != case.content


def test_the_packages_registry_knows_its_cases():
    """Every entry of the registry belongs to a case file in its present form.

    The entries of Figs 6 and 8 of the paper have the closed forms 0.15 and 1.280338, to 1e-8.
    """
    entries = tomllib.loads((CASES / "best_known.toml").read_text("utf-8"))
    scenes = find_scenes([CASES / name for name in entries])
    known = best_known(scenes, CASES)
    assert set(known) == {scene.name for scene in scenes}
    assert known["gilbert/two_blocks"].load_factor == pytest.approx(0.15, rel=1e-8)
    assert known["livesley/wedges"].load_factor == pytest.approx(1.280338166517, rel=1e-8)


@pytest.mark.slow
def test_the_registry_of_made_scenes_knows_them(tmp_path):
    """Every entry of the registry belongs to a scene in its present form; 1/2 and 0 are known by hand."""
    folder = CASES.parent / "tests" / "atlas"
    atlas = write_atlas(tmp_path, CASES)
    known = best_known(find_scenes([*atlas, *write_random(tmp_path, 160)]), folder)
    made = set(tomllib.loads((folder / "best_known.toml").read_text("utf-8")))
    assert {key for key in made if not key.startswith("large/")} == {f"{name}.toml" for name in known}
    assert len(made) >= 160
    assert known["atlas/locking_by_dilatancy_confined_block"].load_factor == pytest.approx(0.5, rel=1e-8)
    assert known["atlas/μ_0_nothing_resists"].load_factor == 0
    assert known["atlas/cycling_on_wall_6"].load_factor < 0.2918


@pytest.mark.parametrize("text", ["[wall", '["NAME"]\ncontent = "CONTENT"', '["NAME"]\nload_factor = 1'])
def test_a_registry_that_is_not_as_written_is_named(text, tmp_path):
    mo.save(block_on_floor(), tmp_path / "block.toml")
    (scene,) = scenes = find_scenes([tmp_path / "block.toml"], tmp_path)
    text = text.replace("NAME", f"{scene.name}.toml").replace("CONTENT", scene.content)
    (tmp_path / "best_known.toml").write_text(text)
    with pytest.raises(mo.CaseError, match=r"best_known\.toml"):
        best_known(scenes, tmp_path)
