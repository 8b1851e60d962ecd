"""The best known Coulomb state changes for exact lower states alone; registries of such states."""

import tomllib

import pytest
from atlas.made_scenes import made_scenes, write_atlas, write_random
from lines import line
from scenes import CASES, block_on_floor, two_blocks

import masonry_opt as mo
from masonry_opt.studies.compare.judge import BestKnown, best_known, lowest_exact
from masonry_opt.studies.compare.runs import content_of, find_scenes

KNOWN = {"made/up": BestKnown(0.16, "by hand")}


def exact(**known):
    return line(**({"method": "refined"} | known))


@pytest.mark.parametrize("method", ["refined", "mcp"])
def test_a_lower_exact_state_is_kept_with_its_method(method):
    found = lowest_exact([exact(method=method, load_factor=0.15)], KNOWN)
    assert found == {"made/up": BestKnown(0.15, method)}


def test_a_pass_alone_is_no_measure_of_others():
    """It looks for no low state: where nothing else is known of the scene, its own is not the lowest."""
    one_pass = exact(method="mcp", load_factor=0.15)
    assert lowest_exact([one_pass], {}) == {}
    searched = exact(load_factor=0.151)
    assert lowest_exact([one_pass, searched], {}) == {"made/up": BestKnown(0.15, "mcp")}


@pytest.mark.parametrize(
    "known",
    [
        {"load_factor": 0.17},
        {"load_factor": 0.15, "method": "mcp", "complementarity": 1e-8},  # over λ
        {"load_factor": 0.16 - 1e-11},  # no lower than rounding makes it
        {"load_factor": 0.15, "yield": 1e-7},
        {"load_factor": 0.15, "complementarity": None},
        {"load_factor": 0.15, "flow": float("nan")},
        {"load_factor": 0.15, "method": "nonassociative"},
        {"load_factor": 0.15, "method": "mcp", "friction_law": "polygon of 24 sides"},
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


def test_a_scene_is_the_same_by_either_name_of_its_live_load():
    """A multiple of the weight, and the force that it is; not where a load says another weight."""
    force = block_on_floor(weight=4.0, live=(2, 0))
    times = block_on_floor(weight=4.0, live=(0, 0), live_per_weight=(0.5, 0))
    assert content_of(force) == content_of(times)
    heavier = {"loads": [mo.Load(block="A", weight=8.0)]}
    assert content_of(force.model_copy(update=heavier)) != content_of(times.model_copy(update=heavier))


def test_the_packages_registry_knows_its_cases():
    """Closed forms of Figs 6 and 8 among them."""
    scenes = find_scenes(["two_blocks", "wedges", "wall_1", "wall_6"], CASES)
    known = best_known(scenes, CASES)
    assert set(known) == {scene.name for scene in scenes}
    assert known["gilbert/two_blocks"].load_factor == pytest.approx(0.15, rel=1e-8)
    assert known["livesley/wedges"].load_factor == pytest.approx(1.280338166517, rel=1e-8)


def test_the_registry_of_made_scenes_knows_them(tmp_path):
    """Every entry is of a scene as it is made today; 1/2 and 0 by hand."""
    folder = CASES.parent / "tests" / "atlas"
    atlas = write_atlas(tmp_path, CASES)
    known = best_known(made_scenes(atlas, write_random(tmp_path, 160)), folder)
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
