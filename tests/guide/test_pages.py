"""The pages of the guide: their examples run, and they have every key, status, code and name there is."""

import ast
import os
import re
from pathlib import Path

import pytest
from scenes import block_on_floor, pressed_down

import masonry_opt as mo
from masonry_opt.answer.reasons import Code
from masonry_opt.scene.case_file import CaseFile
from masonry_opt.scene.generator import Generator

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


def page(name):
    return (DOCS / f"{name}.md").read_text("utf-8")


def blocks(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


def section(text, title):
    """What stands under a heading, down to the next one."""
    return re.split(r"^#+ ", text.split(f" {title}\n", 1)[1], maxsplit=1, flags=re.MULTILINE)[0]


def told(text):
    """What the first columns of the tables of a text name."""
    rows = re.findall(r"^\| (`[^|]*) \|", text, re.MULTILINE)
    return [name for row in rows for name in re.findall(r"`\[*([^`\]]+)\]*`", row)]


def keys_of(record):
    return {field.alias or name for name, field in record.model_fields.items()}


def test_case_files_of_the_pages_are_some(tmp_path):
    """Each solves; one with a reference comes to it."""
    for name in ("start", "case_files"):
        (case,) = blocks(page(name), "toml")
        path = tmp_path / f"{name}.toml"
        path.write_text(case)
        scene = mo.load(path)
        reference = scene.reference.get("associative")
        expected = (reference.value, reference.tolerance) if reference else (0.65, 1e-6)
        assert mo.solve(scene, "static").load_factor == pytest.approx(expected[0], rel=expected[1])


@pytest.mark.parametrize(
    ("title", "expected"),
    [
        ("The scene", keys_of(CaseFile)),
        ("Joints", keys_of(mo.JointDefaults) | keys_of(mo.Joint)),
        ("Blocks", keys_of(mo.Block)),
        ("Solids", keys_of(mo.Solid)),
        ("Loads by name", keys_of(mo.Load)),
        ("Edge loads", keys_of(mo.EdgeLoad)),
        ("Generators", keys_of(Generator)),
        ("`[wall]`: courses of blocks", keys_of(mo.Wall) - keys_of(Generator)),
        ("`[arch]`: voussoirs", keys_of(mo.Arch) - keys_of(Generator)),
    ],
)
def test_every_key_of_a_table_stands_there_and_no_other(title, expected):
    names = told(section(page("case_files"), title))
    assert len(names) == len(set(names))
    assert set(names) == expected


@pytest.mark.slow
def test_case_file_of_axles_is_crossed(tmp_path):
    (case,) = blocks(page("loads/axles"), "toml")
    (tmp_path / "bridge.toml").write_text(case)
    crossed = mo.crossing(tmp_path / "bridge.toml", method="static")
    assert {*crossed.table["axles"]} == {"lorry", "bogie"}
    assert crossed.axles == "lorry"


@pytest.mark.parametrize(("name", "record"), [("fill", mo.Fill), ("axles", mo.Axles)])
def test_every_key_of_a_load_or_support_stands_on_its_page(name, record):
    assert set(told(page(f"loads/{name}"))) == keys_of(record)


@pytest.mark.parametrize(
    ("name", "expected"),
    [("loads/cases", keys_of(mo.LoadCase)), ("loads/earthquake", keys_of(mo.Earthquake))],
)
def test_every_key_of_load_cases_and_earthquakes_stands_on_their_page(name, expected):
    names = told(page(name).split("## ")[0])
    assert len(names) == len(set(names))
    assert set(names) == expected


def test_the_examples_of_load_cases_and_earthquakes_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("wall.toml").write_text(blocks(page("loads/cases"), "toml")[0], "utf-8")
    for name in ("loads/cases", "loads/earthquake"):
        exec(blocks(page(name), "python")[0], {})
    last = capsys.readouterr().out.splitlines()[-1]
    assert float(last) == pytest.approx(5 / (15 + 15 + 0.3 * 15 / 2), rel=1e-9)
    assert Path("cases.png").exists()


def test_every_status_and_code_has_a_row_and_no_other():
    text = page("messages")
    names = told(text)
    assert len(names) == len(set(names))
    assert set(names) == {str(code) for code in Code} | {str(status) for status in mo.Status}
    assert set(told(section(text, "Statuses"))) == {str(status) for status in mo.Status}


def test_every_name_of_the_package_is_in_the_reference():
    documented = re.findall(r"^\.\. auto\w+:: masonry_opt\.(\w+)$", page("reference"), re.MULTILINE)
    assert sorted(documented) == mo.__all__


def test_every_page_stands_in_the_contents():
    listed = re.findall(r"^([\w/]+)$", page("index"), re.MULTILINE)
    pages = {path.stem for path in DOCS.iterdir() if path.suffix in (".md", ".ipynb")} - {"index"}
    assert set(listed) == pages | {"examples/index"}


def test_parts_of_programs_that_are_shown_are_there():
    """Sphinx finds them too, but only as the guide is built."""
    shown = re.findall(r"\{literalinclude\} \.\./(\S+)\n:pyobject: ([\w.]+)\n", page("method"))
    assert len(shown) >= 10
    for path, name in shown:
        body = ast.parse((ROOT / path).read_text("utf-8")).body
        for part in name.split("."):
            (found,) = [node for node in body if getattr(node, "name", None) == part]
            body = found.body


def test_the_version_stands_in_one_place():
    version = re.search(r'^version = "(.+)"$', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)[1]
    for path in (DOCS / "conf.py", ROOT / "CITATION.cff", ROOT / "README.md", DOCS / "index.md"):
        assert version not in path.read_text("utf-8").replace("cff-version: 1.2.0", "")
    assert f"## {version}" in (ROOT / "CHANGELOG.md").read_text("utf-8")


def test_example_of_a_user_s_own_tests_holds_each_case_to_it(monkeypatch, capsys, tmp_path):
    """λ = 2 is enough, λ = 1/2 is not, and none at all says why."""
    (example,) = blocks(section(page("start"), "In your own tests"), "python")
    assert len(example.splitlines()) == 10
    (tmp_path / "test_masonry.py").write_text(example)
    (tmp_path / "cases").mkdir()
    scenes = {"enough": block_on_floor(live=(0.25, 0.0)), "weak": block_on_floor(), "none": pressed_down()}
    for name, scene in scenes.items():
        mo.save(scene, tmp_path / "cases" / f"{name}.toml")
    monkeypatch.chdir(tmp_path)
    without = [option for name in ("cacheprovider", "xdist") for option in ("-p", f"no:{name}")]
    assert (
        pytest.main(["-q", "-rA", "-c", os.devnull, "--import-mode=importlib", *without, str(tmp_path)]) == 1
    )
    printed = capsys.readouterr().out
    outcomes = re.findall(r"^(PASSED|FAILED) .*\[(\w+)\]", printed, re.MULTILINE)
    assert {name: word for word, name in outcomes} == {"enough": "PASSED", "weak": "FAILED", "none": "FAILED"}
    assert "unlimited: the live load cannot cause collapse" in printed
