"""Existing files are replaced if they have the mark of this package, and otherwise only by force."""

import json
import os
import tomllib
from xml.etree import ElementTree

import pytest
from PIL import Image
from scenes import run_command, solved, two_blocks

import masonry_opt as mo
from masonry_opt.errors import OptionError
from masonry_opt.files import is_replaceable, is_written_by_package

FOREIGN = b"mine: written by hand, not by masonry_opt\n"

#: Names of files. The first letter selects the function that writes the file.
SAVED = ("a.png", "a.svg", "a.pdf", "a.html")
PROGRAMS = ("d.lp", "d.mps", "d.nl", "d.cnf")
CASE_FILES = ("c.toml", "c.json")


WAYS = {"b": mo.draw, "c": mo.save, "d": mo.export, "e": mo.write_dxf}


def write(path, **force):
    scene, way = two_blocks(), path.name[0]
    if way == "a":
        solved(scene).save(path, **force)
    else:
        WAYS[way](scene, path, **force)


@pytest.mark.parametrize("name", [*SAVED, "b.PDF", *CASE_FILES, *PROGRAMS, "e.dxf"])
def test_its_own_files_are_replaced_and_others_only_by_force(tmp_path, name):
    path = tmp_path / name
    path.touch()  # an empty file, like a temporary one, may be replaced
    write(path)
    written = path.read_bytes()
    write(path)
    path.write_bytes(FOREIGN)
    with pytest.raises(OptionError, match=name) as refused:
        write(path)
    assert "--force" in str(refused.value)
    assert refused.value.exit_code == 2
    assert path.read_bytes() == FOREIGN
    write(path, force=True)
    assert len(path.read_bytes()) == pytest.approx(len(written), rel=0.01)
    if b"masonry_opt" in written:
        # A file of the same kind without the mark is not replaced, even if it names the package elsewhere.
        path.write_bytes(written.replace(b"masonry_opt", b"masonry-opt") + b"\n% written by masonry_opt\n")
        with pytest.raises(OptionError):
            write(path)
    assert b"masonry_opt" in written or name in ("b.PDF", "e.dxf")


@pytest.mark.parametrize("name", ["b.svg", "d.nl", "d.row", "x.stl"])
def test_an_empty_file_may_be_replaced_but_was_not_written_by_the_package(tmp_path, name):
    path = tmp_path / name
    path.touch()
    assert is_replaceable(path)
    assert not is_written_by_package(path)


def test_what_no_file_is_is_not_replaced(tmp_path):
    pipe, link = tmp_path / "a.png", tmp_path / "a.svg"
    os.mkfifo(pipe)
    link.symlink_to(tmp_path / "nowhere")
    for path in (pipe, link):
        with pytest.raises(OptionError, match="--force"):
            write(path)
        assert path.is_symlink() or path.is_fifo()


@pytest.mark.parametrize("end", [".row", ".col"])
def test_names_beside_a_program_have_its_mark(tmp_path, end):
    path = tmp_path / "d.nl"
    path.with_suffix(end).write_bytes(FOREIGN)
    with pytest.raises(OptionError, match=f"d{end}"):
        write(path)
    assert os.listdir(tmp_path) == [f"d{end}"]
    write(path, force=True)
    write(path)
    assert path.with_suffix(end).read_bytes() != FOREIGN


def test_marks_are_where_other_tools_look_for_them(tmp_path):
    for name in ("a.png", "a.svg", *CASE_FILES):
        write(tmp_path / name)
    assert Image.open(tmp_path / "a.png").text["Software"] == "masonry_opt"
    named = ElementTree.parse(tmp_path / "a.svg").iter("{http://purl.org/dc/elements/1.1/}creator")
    assert [text.strip() for text in next(named).itertext() if text.strip()] == ["masonry_opt"]
    # The mark is a comment in TOML. In JSON it is a key, which is not a key of a scene.
    keys = json.loads((tmp_path / "c.json").read_text("utf-8"))
    assert keys.pop("written_by") == "masonry_opt"
    assert tomllib.loads((tmp_path / "c.toml").read_text("utf-8")).keys() == keys.keys()
    scenes = [mo.load(tmp_path / name) for name in CASE_FILES]
    assert all(scene.blocks == two_blocks().blocks for scene in scenes)


@pytest.mark.parametrize(
    ("command", "name"),
    [
        (("solve", "{case}", "--method", "static", "--plot"), "out.png"),
        (("solve", "{case}", "--method", "static", "--plot"), "out.html"),
        (("draw", "{case}"), "out.svg"),
        (("export", "{case}"), "out.mps"),
        (("convert", "{case}"), "out.dxf"),
        (("convert", "{drawing}"), "out.toml"),
    ],
)
def test_commands_refuse_with_code_2_before_they_print(monkeypatch, capsys, tmp_path, command, name):
    case, drawing, out = tmp_path / "case.toml", tmp_path / "drawing.dxf", tmp_path / name
    mo.save(two_blocks(), case)
    given = [part.format(case=case, drawing=drawing) for part in command] + [str(out)]
    if "{drawing}" in command:
        mo.write_dxf(two_blocks(), drawing)
        given += ["--friction", "0.1", "--unit-weight", "1", "--live", "1,0"]
    out.write_bytes(FOREIGN)
    code, printed, err = run_command(monkeypatch, capsys, *given)
    assert (code, printed) == (2, "")
    assert err.startswith(f"error: {out}: ")
    assert "--force" in err
    assert out.read_bytes() == FOREIGN
    for force in (["--force"], []):  # after one forced write, the file has the mark
        code, _, err = run_command(monkeypatch, capsys, *given, *force)
        assert (code, err) == (0, "")
        assert out.read_bytes() != FOREIGN
