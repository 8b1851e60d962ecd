"""The guide: its examples run, and its pages list every key, status, code and public name."""

import ast
import importlib
import inspect
import json
import os
import re
from pathlib import Path

import pytest
from brickwork import facade
from scenes import block_on_floor, pressed_down, run_command

import masonry_opt as mo
from masonry_opt.cli.app import FORMER_OPTIONS
from masonry_opt.methods.registry import FORMER_METHODS
from masonry_opt.scene.arch import ArchRing
from masonry_opt.scene.case_file import CaseFile
from masonry_opt.scene.generator import Generator
from masonry_opt.solution.outcome import FORMER_NAMES
from masonry_opt.solution.reasons import Code
from masonry_opt.studies.warning_codes import StudyCode

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


def page(name):
    return (DOCS / f"{name}.md").read_text("utf-8")


def blocks(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


def section(text, title):
    """Return the text between a heading and the next heading."""
    return re.split(r"^#+ ", text.split(f" {title}\n", 1)[1], maxsplit=1, flags=re.MULTILINE)[0]


def listed_names(text):
    """Return the names in the first columns of all tables of a text."""
    rows = re.findall(r"^\| (`[^|]*) \|", text, re.MULTILINE)
    return [name for row in rows for name in re.findall(r"`\[*([^`\]]+)\]*`", row)]


def keys_of(record):
    return {field.alias or name for name, field in record.model_fields.items()}


def test_case_files_of_the_pages_are_some(tmp_path):
    """The case files on the pages can be solved, and the results agree with their reference values."""
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
    names = listed_names(section(page("case_files"), title))
    assert len(names) == len(set(names))
    assert set(names) == expected


@pytest.mark.slow
def test_case_file_of_axles_is_crossed(tmp_path, monkeypatch):
    """The lorry has the least load factor. That of the bogie is a quarter higher, so that positions farther
    apart, and a bound within a tenth, decide which of the two governs."""
    crossing = importlib.import_module("masonry_opt.studies.crossing.crossing")
    monkeypatch.setattr(crossing, "_LONGEST_RANGE", 0.1)
    monkeypatch.setattr(crossing, "WITHIN", 0.1)
    (case,) = blocks(page("loads/axles"), "toml")
    (tmp_path / "bridge.toml").write_text(case)
    crossed = mo.crossing(tmp_path / "bridge.toml", method="static")
    assert {*crossed.table["axles"]} == {"lorry", "bogie"}
    assert crossed.axles == "lorry"


LOADS = {"fill": mo.Fill, "axles": mo.Axles, "cases": mo.LoadCase, "earthquake": mo.Earthquake}


@pytest.mark.parametrize(("name", "record"), LOADS.items(), ids=LOADS)
def test_every_key_of_a_load_stands_on_its_page(name, record):
    names = listed_names(page(f"loads/{name}").split("## ")[0])
    assert len(names) == len(set(names))
    assert set(names) == keys_of(record)


@pytest.mark.slow
def test_the_examples_of_load_cases_and_earthquakes_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("wall.toml").write_text(blocks(page("loads/cases"), "toml")[0], "utf-8")
    for name in ("loads/cases", "loads/earthquake"):
        exec(blocks(page(name), "python")[0], {})
    last = capsys.readouterr().out.splitlines()[-1]
    assert float(last) == pytest.approx(5 / (15 + 15 + 0.3 * 15 / 2), rel=1e-9)
    assert Path("cases.png").exists()


def test_the_example_of_stones_without_mortar_prints_what_the_page_shows(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    mo.write_dxf(facade(2, 10, length=0.24), "facade.dxf")
    (example,) = blocks(section(page("drawings"), "Stones drawn without their mortar"), "text")
    _, *runs = example.split("$ masonry-opt ")
    assert len(runs) == 2
    for run in runs:
        command, shown = run.split("\n", 1)
        _, out, err = run_command(monkeypatch, capsys, *command.split())
        assert (err + out).split() == shown.split()


@pytest.mark.slow
def test_the_answers_of_the_page_on_stability_are_those_shown(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = page("stability")
    Path("arch.toml").write_text(blocks(text, "toml")[0], "utf-8")
    assert f"{mo.solve('arch.toml')}\n" == blocks(text, "text")[0]
    exec(blocks(text, "python")[0], {})
    assert capsys.readouterr().out.startswith("stable WorstJoint(first='brick 1', second='brick 2'")
    assert Path("bricks.png").exists()
    assert set(listed_names(section(text, "What the answer contains"))) == {
        "forces",
        "least friction",
        "thrust",
        "worst joint",
    }


def test_every_status_and_code_has_a_row_and_no_other():
    text = page("messages")
    names = listed_names(text)
    assert len(names) == len(set(names))
    codes = {str(code) for code in (*Code, *StudyCode)}
    assert set(names) == codes | {str(status) for status in mo.Status}
    assert set(listed_names(section(text, "Statuses"))) == {str(status) for status in mo.Status}


def test_every_former_name_stands_in_the_glossary():
    rows = section(page("glossary"), "Former names")
    table = set(re.findall(r"^\| [^|]* \| `([^`]*)` \|", rows, re.MULTILINE))
    assert table == {*FORMER_METHODS, *FORMER_NAMES, *FORMER_OPTIONS}


def test_every_name_of_the_package_is_in_the_reference():
    documented = re.findall(r"^\.\. auto\w+:: masonry_opt\.(\w+)$", page("reference"), re.MULTILINE)
    assert sorted(documented) == mo.__all__


def test_the_help_of_the_package_lists_every_name_once_and_in_the_groups_of_the_reference():
    """The help of the package lists every public name once, in groups.

    The first group has the six functions that most users need, in the order of the reference.
    """
    groups = re.findall(r"^    ([\w ,;\n]+?)(?=\n\S|\n\n)", mo.__doc__, re.MULTILINE)
    listed = [re.findall(r"\w+", group.replace("in space", "")) for group in groups]
    assert sorted(name for names in listed for name in names) == mo.__all__
    first = section(page("reference"), "Six functions that most users need")
    assert listed[0] == re.findall(r"autofunction:: masonry_opt\.(\w+)$", first, re.MULTILINE)
    assert len(listed[0]) == 6


def test_the_version_stands_in_one_place():
    version = re.search(r'^version = "(.+)"$', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)[1]
    for path in (DOCS / "conf.py", ROOT / "CITATION.cff", ROOT / "README.md", DOCS / "index.md"):
        assert version not in path.read_text("utf-8").replace("cff-version: 1.2.0", "")
    assert f"## {version}" in (ROOT / "CHANGELOG.md").read_text("utf-8")


@pytest.mark.slow
def test_example_of_a_user_s_own_tests_holds_each_case_to_it(monkeypatch, capsys, tmp_path):
    """The example passes with λ = 2, fails with λ = 1/2, and fails with the message if no λ exists."""
    (example,) = blocks(section(page("start"), "In your own tests"), "python")
    assert len(example.splitlines()) == 13
    (tmp_path / "test_masonry.py").write_text(example)
    (tmp_path / "cases").mkdir()
    scenes = {"enough": block_on_floor(live=(0.25, 0.0)), "weak": block_on_floor(), "none": pressed_down()}
    for name, scene in scenes.items():
        mo.save(scene, tmp_path / "cases" / f"{name}.toml")
    monkeypatch.chdir(tmp_path)
    off = [option for name in ("cacheprovider", "xdist") for option in ("-p", f"no:{name}")]
    assert pytest.main(["-q", "-rA", "-c", os.devnull, "--import-mode=importlib", *off, str(tmp_path)]) == 1
    printed = capsys.readouterr().out
    outcomes = re.findall(r"^(PASSED|FAILED) .*\[(\w+)\]", printed, re.MULTILINE)
    assert {name: word for word, name in outcomes} == {"enough": "PASSED", "weak": "FAILED", "none": "FAILED"}
    assert "unlimited: the live load cannot cause collapse" in printed


#: Examples of the gallery. Those of the paper are tested by their command in `tests/reproduce`.
EXAMPLES = sorted(path for path in (DOCS / "gallery").glob("*/*.py") if path.parent.name != "paper")


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_asks_a_question_answers_it_and_shows_it(path):
    text = path.read_text("utf-8")
    tree = ast.parse(text)
    title = ast.get_docstring(tree).splitlines()[0]
    assert title.endswith("?")
    assert 20 <= len(text.splitlines()) <= 70
    assert any(isinstance(node, ast.Assert) for node in ast.walk(tree))
    last = ast.unparse(tree.body[-1])
    assert re.search(r"\.plot\(.*\)$|^figure$", last), "the last expression is the picture"


@pytest.mark.parametrize("name", ["notebook", "by_hand"])
def test_outputs_of_the_notebook_are_not_stored(name):
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(DOCS / f"{name}.ipynb", as_version=4)
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert len(cells) >= 4
    assert all(not cell.outputs and cell.execution_count is None for cell in cells)


RECORDS = [ArchRing, *(of for name in mo.__all__ if hasattr(of := getattr(mo, name), "model_fields"))]


def test_the_program_finds_the_numbers_by_hand_of_three_blocks(capsys):
    """The notebook prints the load factors by hand, 0.1 (1 + 2 N) with N = 1/4 and 3/4, and a valid proof.

    Its cells assert that the program finds the same numbers.
    """
    notebook = json.loads((DOCS / "by_hand.ipynb").read_text("utf-8"))
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    exec(compile("\n".join(cells), "by_hand.ipynb", "exec"), {})
    printed = capsys.readouterr().out.splitlines()
    assert printed[:2] == ["0.15 0.25", "0.25"]
    assert "λ = 0.15: this is an exact collapse state, because no residual exceeds its limit" in printed
    assert printed[-1] == "True"


def test_the_gallery_opens_with_examples_for_the_first_questions():
    header = (DOCS / "gallery" / "GALLERY_HEADER.rst").read_text("utf-8")
    linked = re.findall(r":doc:`([^`]+)`", header)
    assert [header.index(question) for question in ("stand?", "collapse?", "worst?", "answer?")] == sorted(
        header.index(question) for question in ("stand?", "collapse?", "worst?", "answer?")
    )
    assert len(linked) >= 4
    for name in linked:
        paths = [DOCS / "gallery" / f"{name}.py", DOCS / "gallery" / f"{name}.ipynb"]
        assert any(path.resolve().is_file() for path in paths), name


@pytest.fixture
def records(monkeypatch):
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "docs" / "_ext"))
    import records

    return records


@pytest.mark.parametrize("what", ["attribute", "property"])
def test_a_colon_in_the_docstring_of_an_attribute_separates_no_type(records, what):
    """Napoleon reads the text before the colon as the type of the attribute, so its result is replaced."""
    napoleon = pytest.importorskip("sphinx.ext.napoleon")
    lines = ["Largest number of joints (in space: contacts).", "", "More are slow."]
    written = list(lines)
    records._process(None, what, "most", None, None, lines)
    lines[:] = napoleon.NumpyDocstring(lines, what=what, name="most").lines()
    assert any("type" in line for line in lines)
    records._restore(None, what, "most", None, None, lines)
    assert lines == [*written, ""]


def test_defaults_that_are_settings_are_shown_without_their_fields(records):
    assert records._plain(mo.SearchSettings()) == "SearchSettings()"


@pytest.mark.slow
def test_pictures_of_matplotlib_and_altair_are_shown_once_and_below_each_other(records, tmp_path):
    """Two pictures of one block of an example are below each other, each in the width of the page."""
    pytest.importorskip("sphinx_gallery")
    alt = pytest.importorskip("altair")
    import figures

    chart = alt.Chart(alt.Data(values=[{"x": 1}])).mark_point().properties(title="a chart")
    picture = mo.draw(block_on_floor())
    paths = [tmp_path / "1.png", tmp_path / "2.png"]
    variables = {"example_globals": {"a": picture, "b": chart, "c": chart}}
    shown = variables | {"image_path_iterator": map(str, paths)}
    text = figures.scraper(None, shown, {"src_dir": str(tmp_path)})
    assert re.findall(r"image-sg:: /(\d)\.png", text) == ["1", "2"]
    assert text.count("sphx-glr-single-img") == 2
    assert re.findall(r":alt: (.*)", text) == [picture.axes[0].get_title().replace("\n", ": "), "a chart"]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in paths)
    assert not figures.scraper(None, shown, {"src_dir": str(tmp_path)})


@pytest.mark.parametrize(
    ("code", "in_text", "in_table"),
    [
        ("--plot FILE", True, True),
        ("sweep --vary axles.uniform.to=6:26:11 --out results/train", True, False),
        ("cases/examples/segmental_arch_on_columns.toml", False, False),
        ("scene/settings.py", True, False),
    ],
)
def test_short_words_of_code_are_marked_so_that_hyphens_do_not_break_them(records, code, in_text, in_table):
    from docutils import nodes, utils
    from short_code import mark

    doctree, table = utils.new_document("page"), nodes.table()
    doctree += [nodes.literal(code, code), table]
    table += nodes.literal(code, code)
    mark(None, doctree)
    assert ["short" in node["classes"] for node in doctree.findall(nodes.literal)] == [in_text, in_table]


#: Examples of the paper, of which the guide runs a few.
OF_PAPER = sorted((DOCS / "gallery" / "paper").glob("*.py"))


@pytest.mark.parametrize("path", OF_PAPER, ids=lambda path: path.stem)
def test_an_example_that_the_guide_does_not_run_says_so(path):
    """The page of such an example shows no output, so it names the command that computes it."""
    (pattern,) = re.findall(r'"filename_pattern": r"(.+)",', (DOCS / "conf.py").read_text("utf-8"))
    says_so = f"does not run this example. ``masonry-opt reproduce {path.stem}``" in path.read_text("utf-8")
    assert says_so == (re.search(pattern, str(path)) is None)


def test_every_piece_of_code_on_a_page_begins_where_the_page_says():
    """The text at which a listing begins occurs once in its file, so that no other piece is shown."""
    for path in DOCS.glob("**/*.md"):
        for name, options in re.findall(r"```{literalinclude} (\S+)\n((?::.*\n)*)", path.read_text("utf-8")):
            text = (path.parent / name).read_text("utf-8")
            for start in re.findall(r":start-at: (.+)", options):
                assert text.count(start.strip("'\"")) == 1, (path.name, start)


def documented(records, of):
    """Return the lines of the docstring of a record after the project's Sphinx extension has changed them."""
    lines = inspect.getdoc(of).splitlines()
    records._process(None, "class", of.__name__, of, None, lines)
    return lines


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: record.__name__)
def test_every_field_of_a_record_is_told_with_its_type_and_nothing_of_pydantic(records, record):
    lines = documented(records, record)
    section = lines[lines.index("Fields") + 2 :]
    if "Raises" in section:
        section = section[: section.index("Raises")]
    entries = [line for line in section if line and not line.startswith(" ")]
    fields = [name for entry in entries for name in entry.split(" : ")[0].split(", ")]
    assert sorted(fields) == sorted(record.model_fields)
    # Fields that are described with another record have their types there.
    without_type = [section[section.index(entry) + 1] for entry in entries if not re.search(" : .*``", entry)]
    assert [text for text in without_type if not re.match(r" +(See|As in)\b", text)] == []
    assert not [line for line in lines if "model_" in line]


def test_types_and_defaults_are_those_of_the_class(records):
    text = "\n".join(documented(records, mo.Column))
    assert "drums : ``int``\n    Number of drums." in text
    assert "batter : ``'both' or 'left' or 'right'``, default ``'both'``" in text
    assert "width : ``float or tuple[float, float]``\n" in text
    assert "name, at, live_per_weight, live\n    See :class:" in text
    signature, _ = records._call(None, "class", "", mo.Column, None, "", "")
    assert signature.startswith("(*, width, height, drums, name=None, at=(0, 0), live_per_weight=(0, 0)")
