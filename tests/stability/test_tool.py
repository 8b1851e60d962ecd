"""Tests of the program under strain: full disks, odd files and odd paths end in one line and an exit code."""

import json
import os
import re
import subprocess
import sys
import threading
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module

import pytest
from scenes import CASES, GOOD, run_command
from screens import full_from

import masonry_opt as mo
from masonry_opt.errors import CaseError, OptionError
from masonry_opt.files import write_whole
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.tables import LARGEST_FILE

WALL_1 = CASES / "ferris_tinloi" / "wall_1.toml"
TWO_BLOCKS = CASES / "gilbert" / "two_blocks.toml"


def in_file(tmp_path, content, name="case.toml"):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


# Output


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
@pytest.mark.parametrize("arguments", [["check", TWO_BLOCKS], ["--version"], ["--help"]])
def test_full_disk_behind_standard_output(command, arguments):
    with open("/dev/full", "w") as full, redirect_stdout(full):
        message = command.refused(*arguments)
    assert "cannot be written: No space left on device" in message


@pytest.mark.parametrize(
    "arguments",
    [
        ["check", TWO_BLOCKS],
        ["least", TWO_BLOCKS, "--vary", "joints.friction=0.01:1", "--load", "0.1", "--method", "static"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_reader_of_standard_output_went_away(monkeypatch, command, tmp_path, arguments):
    monkeypatch.chdir(tmp_path)
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as pipe, redirect_stdout(pipe):
        message = command.refused(*arguments, code=141)
    assert not re.search("Traceback|error", message)


@pytest.mark.slow
def test_help_of_which_a_reader_takes_lines_ends_without_a_word(tmp_path):
    """The reader ends while the last lines are not yet written."""
    of_this_tree = os.environ | {"PYTHONPATH": str(CASES.parent)}
    program = f"{sys.executable} -c 'from masonry_opt.cli import main; main()' sweep --help"
    pipeline = f"{program} 2> {tmp_path}/errors | head -90 > /dev/null"
    subprocess.run(["sh", "-c", pipeline], env=of_this_tree, timeout=120, check=True)
    assert (tmp_path / "errors").read_text() == ""


@pytest.mark.slow
def test_a_process_ends_without_a_word_when_nobody_reads_its_output(tmp_path):
    """The process ends with exit code 141, as programs do that this signal ends, and prints no error."""
    read, write = os.pipe()
    os.close(read)
    program = "from masonry_opt.cli import main; main()"
    command = [sys.executable, "-c", program, "solve", str(TWO_BLOCKS), "--json"]
    of_this_tree = os.environ | {"PYTHONPATH": str(CASES.parent)}
    with os.fdopen(write, "w") as pipe:
        ended = subprocess.run(
            command,
            stdout=pipe,
            stderr=subprocess.PIPE,
            text=True,
            timeout=120,
            check=False,
            cwd=tmp_path,
            env=of_this_tree,
        )
    assert ended.returncode == 141
    assert not re.search("Traceback|error|Broken pipe|Exception", ended.stderr)


def test_closed_standard_output_and_error(command):
    with redirect_stdout(None):
        assert "standard output is closed" in command.refused("solve", WALL_1)
        with redirect_stderr(None):
            command.refused("solve", WALL_1)


def test_picture_that_cannot_be_written(monkeypatch, capsys, tmp_path):
    case, old = in_file(tmp_path, GOOD), in_file(tmp_path, b"old", "wall.png")
    asked = ("solve", case, "--method", "static", "--plot", old, "--force")
    with full_from(0):
        code, _, output = run_command(monkeypatch, capsys, *asked)
    assert code == 2
    assert f"{old}: cannot be written: File too large" in output
    assert old.read_bytes() == b"old"


def test_unwritable_folder_is_told_before_long_work(monkeypatch, watched, command, tmp_path):
    monkeypatch.setattr("os.access", lambda path, mode: mode != os.W_OK)
    solved = watched(import_module("masonry_opt.cli.solve"), "solve_scene")
    message = command.refused("solve", WALL_1, "--plot", tmp_path / "wall.png")
    assert "is not writable" in message
    (tmp_path / "folder.png").mkdir()
    assert "a folder has this name" in command.refused("solve", WALL_1, "--plot", tmp_path / "folder.png")
    assert solved == []


def test_writers_of_one_file_leave_it_whole(tmp_path):
    path, contents = tmp_path / "table.csv", [letter * 200_000 for letter in "abcd"]
    write_whole(path, contents[0])
    writers = [
        threading.Thread(target=lambda text=text: [write_whole(path, text) for _ in range(40)])
        for text in contents
    ]
    for writer in writers:
        writer.start()
    seen = 0
    while any(writer.is_alive() for writer in writers) or not seen:
        assert path.read_text() in contents
        seen += 1
    for writer in writers:
        writer.join()
    assert path.read_text() in contents
    assert list(tmp_path.iterdir()) == [path]


def test_file_with_the_longest_name_is_written(tmp_path):
    path = tmp_path / ("x" * 251 + ".csv")
    write_whole(path, "text")
    assert path.read_text() == "text"


def test_names_of_blocks_make_no_paths(command, tmp_path):
    """Names of blocks and titles in a case file appear in the output, and make no files."""
    odd = "../../<script>alert(1)</script>[/red]{x}$\\\\frac{$"
    text = f'title = "{odd}"\nsource = "{odd}"\n' + GOOD.replace('"A"', f'"{odd}"')
    text += f'[reference]\nstatic = {{ value = 0.6, source = "{odd}" }}\n'
    path, folder = in_file(tmp_path, text), tmp_path / "out"
    folder.mkdir()
    record = command.json("solve", path, "--method", "static", "--plot", folder / "picture.svg")
    name = record["block_results"][0]["block"]
    assert name == odd.replace("\\\\", "\\")
    assert list(folder.iterdir()) == [folder / "picture.svg"]
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["case.toml", "out"]
    assert "<script>" not in (folder / "picture.svg").read_text()


# Paths and files


@pytest.mark.parametrize(
    ("path", "shown"),
    [
        ("-", "-"),
        ("", "."),
        ("/dev/zero", "/dev/zero"),
        ("[/red].toml", "[/red].toml"),
        ("a\x1b[2J\u202e.toml", r"a\x1b[2J\u202e.toml"),
        ("bytes\udcff.toml", r"bytes\udcff.toml"),
        ("x" * 5000 + ".toml", "File name too long"),
    ],
)
def test_odd_paths(path, shown, command):
    assert shown in command.refused("solve", path)


def test_pipes_and_circles_of_links(command, tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "loop.toml").symlink_to("loop.toml")
    for name in ("pipe.toml", "loop.toml"):
        assert name in command.refused("solve", tmp_path / name)
    with pytest.raises(CaseError, match="null"):
        mo.load("a\0.toml")


#: By kind of error: the name and the content of the file, and words that the message must contain.
ODD_FILES = {
    "UTF-16": ("case.toml", GOOD.encode("utf-16"), ""),
    "NUL": ("case.toml", GOOD.replace('"A"', '"\0"'), ""),
    "deep lists": ("case.toml", "a = " + "[" * 50_000, ""),
    "deep tables": ("case.toml", "a = " + "{a=" * 50_000, ""),
    "dotted key": ("case.toml", ".".join(["a"] * 20_000) + " = 1", "line 1"),
    "dotted table": ("case.toml", "\n[" + '"x]" . ' * 20 + "a]", "line 2"),
    "too large": ("case.toml", GOOD.replace("0.6", "1e400"), "1e400"),
    "long whole number": ("case.toml", GOOD.replace("0.6", "9" * 5000), ""),
    "NaN in JSON": ("case.json", '{"joints": {"friction": NaN}}', "'friction'"),
    "date": ("case.toml", GOOD.replace("0.6", "1979-05-27"), "datetime.date"),
    "half a character": ("case.json", '{"joints": {"friction": 1}, "title": "\\ud800"}', "'title'"),
    "escape in a name": ("case.toml", GOOD.replace('"A"', r'"\u001b[31m"'), ""),
    "turned writing": ("case.toml", GOOD.replace('"A"', r'"\u202egnp"'), ""),
    "escape in a key": ("case.toml", '"\\u001b[2J" = 1\n' + GOOD, r"'\x1b[2J'"),
    "long key": ("case.toml", f'"{"x" * 10**6}" = 1\n' + GOOD, "..."),
    "long name": ("case.toml", GOOD.replace('"A"', f'"{"x" * 10**6}"'), "200"),
    "long title": ("case.toml", f'title = "{"x" * 10**6}"\n' + GOOD, "2000"),
    "braces": (
        "case.toml",
        '[joints]\nfriction = 1\n[wall]\nblock = [1, 1]\nweight = 1\ncourses = ["{x}"]',
        "'{x}'",
    ),
    "endless wall": (
        "case.toml",
        "[joints]\nfriction = 1\n[wall]\nblock = [1, 1]\nweight = 1\nrepeat = 100000\ncourses = [[1, 1]]",
        "200000",
    ),
    "endless façade": (
        "case.toml",
        "[joints]\nfriction = 1\n[facade]\nopenings = [1000, 1000]\nblock = [2, 1]\njamb = 1\n"
        "opening = [1, 1]\nsill = 2\nspandrel = 2\nweight = 1\nlintel_weight = 1",
        "18000000",
    ),
    "many wrong blocks": ("case.json", json.dumps({"block": [{}] * 1000}), ""),
    "too many tables": ("case.toml", f"block = [{'{}, ' * 200_001}]", "200001"),
    "too many blocks": ("case.json", json.dumps({"block": [[]] * 200_001}), "200001"),
}


@pytest.mark.parametrize("name", ODD_FILES)
def test_odd_files_end_in_a_short_message(name, command, tmp_path):
    file, content, named = ODD_FILES[name]
    path = in_file(tmp_path, content, file)
    message = command.refused("solve", path)
    assert named in message
    assert str(path) in message
    assert len(message) < 5000
    assert all(letter == "\n" or letter.isprintable() for letter in message)


@pytest.mark.slow
def test_repeated_key_among_many_is_found_at_once(tmp_path):
    keys = ", ".join(f'"k{number}": 0' for number in range(300_000))
    with pytest.raises(CaseError, match="'z'"):
        mo.load(in_file(tmp_path, f'{{{keys}, "z": 0, "z": 0}}', "case.json"))


def test_file_of_fifty_megabytes(tmp_path):
    path = tmp_path / "case.toml"
    with path.open("wb") as stream:
        stream.truncate(50_000_000)
    with pytest.raises(CaseError, match=f"{LARGEST_FILE // 1_000_000} MB"):
        mo.load(path)


@pytest.mark.slow
def test_blocks_on_one_another_are_refused_before_all_pairs_are_made():
    block = mo.Block(name="0", vertices=[(0, 0), (1, 0), (1, 1)], weight=1)
    base = mo.Block(name="base", vertices=[(0, -1), (1, -1), (1, 0), (0, 0)], fixed=True)
    copies = [block.model_copy(update={"name": str(number)}) for number in range(5_000)]
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.5), blocks=[*copies, base])
    with pytest.raises(CaseError, match=str(300 * 5_000 - 300 * 299 // 2)):  # each pair counts once
        assemble(scene)


def test_outlines_too_fine_to_compare():
    """Two shallow arcs lie on the two sides of a diagonal, so that each lies in the bounding box of the
    other."""

    def arc(side):
        steps = [step / 12_000 for step in range(12_001)]
        return [(t + side * 0.2 * t * (1 - t), t - side * 0.2 * t * (1 - t)) for t in steps]

    scene = mo.Scene(
        joints=mo.JointDefaults(friction=0.5),
        tolerance=1e-12,
        blocks=[
            mo.Block(name="upper", vertices=arc(-1), weight=1, live=(1, 0)),
            mo.Block(name="lower", vertices=arc(1), fixed=True),
        ],
    )
    with pytest.raises(CaseError, match=r"'(upper|lower)'.*12001"):
        assemble(scene)


@pytest.mark.parametrize("error", [CaseError, OptionError])
def test_messages_show_what_they_quote(error):
    assert str(error("a\x1b[31m\u202e\ud800é\nλ")) == "a\\x1b[31m\\u202e\\ud800é\nλ"
