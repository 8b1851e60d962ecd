"""The tool under strain: interrupts, full disks, odd files and paths end in one line and an exit code."""

from __future__ import annotations

import errno
import json
import os
import re
import signal
import subprocess
import sys
import threading
from types import SimpleNamespace

import pytest
from scenes import CASES, block_on_floor

import masonry_opt as mo
from masonry_opt.cli import main
from masonry_opt.errors import CaseError, OptionError
from masonry_opt.files import write_whole
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.tables import LARGEST_FILE

WALL_1 = CASES / "ferris_tinloi" / "wall_1.toml"
GOOD = """
[joints]
friction = 0.6
[[block]]
name = "A"
vertices = [[0, 0], [1, 0], [1, 1], [0, 1]]
weight = 1.0
live = [1.0, 0.0]
[[block]]
name = "base"
vertices = [[-4, -1], [9, -1], [9, 0], [-4, 0]]
fixed = true
"""


def run(monkeypatch, *arguments):
    """Exit code of the command line."""
    monkeypatch.setattr("sys.argv", ["masonry-opt", *map(str, arguments)])
    try:
        main()
    except SystemExit as end:
        return end.code or 0
    return 0


def in_file(tmp_path, content, name="case.toml"):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


# Interrupts


def press_ctrl_c():
    os.kill(os.getpid(), signal.SIGINT)


def interrupted_after(steps, swallow):
    """A stand-in for ``solve`` that is interrupted after some steps; a solver may swallow that."""

    def solve(*_, progress, **__):
        for number in range(steps):
            progress(SimpleNamespace(load_factor=0.5 - 0.1 * number))
        try:
            press_ctrl_c()
        except KeyboardInterrupt:
            if not swallow:
                raise
        return mo.solve(block_on_floor(), "static")

    return solve


@pytest.mark.parametrize("swallow", [False, True])
@pytest.mark.parametrize(("steps", "words"), [(0, "before the first λ"), (2, "namespace 2: λ = 0.400000")])
def test_ctrl_c_ends_with_what_is_known(monkeypatch, capsys, steps, words, swallow):
    monkeypatch.setattr("masonry_opt.cli.solve_scene", interrupted_after(steps, swallow))
    assert run(monkeypatch, "solve", WALL_1) == 130
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("error: interrupted")
    assert words in captured.err
    assert captured.err.count("\n") == 1
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_in_other_commands(monkeypatch, capsys):
    monkeypatch.setattr("masonry_opt.cli.check_duality", lambda _: press_ctrl_c())
    assert run(monkeypatch, "check", WALL_1) == 130
    assert capsys.readouterr().err == "error: interrupted: files already written are whole\n"


def test_ctrl_c_ends_a_search_with_the_lowest_state_so_far(monkeypatch, capsys):
    def interrupted(*arguments, progress, **options):
        def follow(step):
            progress(step)
            if getattr(step, "origin", "start") != "start":
                press_ctrl_c()

        return mo.solve(*arguments, progress=follow, **options)

    monkeypatch.setattr("masonry_opt.cli.solve_scene", interrupted)
    wall_5 = CASES / "ferris_tinloi" / "wall_5.toml"
    asked = ("--method", "refined", "-o", "search=60", "--json")
    assert run(monkeypatch, "solve", wall_5, *asked) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["load_factor"] < 0.2138
    (searched,) = [said for said in answer["reasons"] if said["code"] == "searched"]
    assert searched["interrupted"]


@pytest.mark.parametrize(
    "asked",
    [
        ("solve", "-o", "tolerance=1e-8"),
        ("solve", "-o", "progress=1"),
        ("least", "--vary", "joints.friction=0.1:0.9", "--load", "0.1", "-o", "tolerance=1e-8"),
    ],
)
def test_an_argument_of_the_command_is_no_option_of_the_method(monkeypatch, capsys, asked):
    assert run(monkeypatch, asked[0], WALL_1, *asked[1:]) == OptionError.exit_code
    told = capsys.readouterr().err
    assert told.startswith(f"error: option '{asked[-1].partition('=')[0]}'")


#: A command that is interrupted 0.2 s into a solve of IPOPT's, which takes longer on wall 6.
IN_IPOPT = """
import os, signal, sys, threading
from masonry_opt import cli
from masonry_opt.solvers.ipopt import CasadiIpopt

solve = CasadiIpopt.solve
signal.signal(signal.SIGINT, signal.default_int_handler)  # a parent in the background ignores it

def interrupted(self, epsilon):
    threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
    return solve(self, epsilon)

CasadiIpopt.solve = interrupted
sys.argv = ["masonry-opt", "solve", sys.argv[1], "--method", "mpec"]
cli.main()
"""


def test_ctrl_c_in_ipopt_ends_with_what_is_known():
    wall_6 = CASES / "ferris_tinloi" / "wall_6.toml"
    command = [sys.executable, "-c", IN_IPOPT, str(wall_6)]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert ended.returncode == 130, ended.stderr
    assert ended.stdout == ""
    assert "Traceback" not in ended.stderr
    # CasADi says in a line of its own that it was stopped, if IPOPT had begun.
    last = ended.stderr.splitlines()[-1]
    assert last.startswith("error: interrupted: the last was iteration ")
    assert last.endswith("not the answer; nothing was written")


# Output


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
@pytest.mark.parametrize(
    "arguments",
    [["solve", WALL_1], ["solve", WALL_1, "--json"], ["check", WALL_1], ["--version"], ["--help"]],
)
def test_full_disk_behind_standard_output(monkeypatch, capsys, arguments):
    with open("/dev/full", "w") as full:
        monkeypatch.setattr(sys, "stdout", full)
        assert run(monkeypatch, *arguments) == 2
    assert "cannot be written: No space left on device" in capsys.readouterr().err


@pytest.mark.parametrize("option", [[], ["--json"]])
def test_reader_of_standard_output_went_away(monkeypatch, capsys, option):
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as pipe:
        monkeypatch.setattr(sys, "stdout", pipe)
        assert run(monkeypatch, "solve", WALL_1, *option) == 141
    assert capsys.readouterr().err == ""


TWO_BLOCKS = CASES / "gilbert" / "two_blocks.toml"


@pytest.mark.parametrize(
    "arguments",
    [
        pytest.param(arguments, id=" ".join(map(str, arguments[:1])), marks=marks)
        for arguments, marks in [
            (["solve", TWO_BLOCKS, "--json"], ()),
            (["--version"], ()),
            (["check", TWO_BLOCKS], pytest.mark.slow),
            (["draw", TWO_BLOCKS, "two.png"], pytest.mark.slow),
            (["export", TWO_BLOCKS, "two.lp"], pytest.mark.slow),
            (["convert", TWO_BLOCKS, "two.dxf"], pytest.mark.slow),
            (["sweep", TWO_BLOCKS, "--vary", "joints.friction=0.1:0.2:2", "--out", "runs"], pytest.mark.slow),
            (["least", TWO_BLOCKS, "--vary", "joints.friction=0.01:1", "--load", "0.1"], pytest.mark.slow),
        ]
    ],
)
def test_commands_end_without_a_word_when_nobody_reads_their_output(tmp_path, arguments):
    """As programs do that the signal for it ends; in a process of its own, with all it says as it ends."""
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-c", "from masonry_opt.command import main; main()", *map(str, arguments)]
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


def test_closed_standard_output_and_error(monkeypatch, capsys):
    monkeypatch.setattr(sys, "stdout", None)
    assert run(monkeypatch, "solve", WALL_1) == 2
    assert "standard output is closed" in capsys.readouterr().err
    monkeypatch.setattr(sys, "stderr", None)
    assert run(monkeypatch, "solve", WALL_1) == 2


def test_picture_that_cannot_be_written(monkeypatch, capsys, tmp_path):
    old = in_file(tmp_path, b"old", "wall.png")

    def full(*_, **__):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("tempfile.mkstemp", full)
    assert run(monkeypatch, "solve", in_file(tmp_path, GOOD), "--plot", old) == 2
    assert f"{old}: cannot be written: No space left on device" in capsys.readouterr().err
    assert old.read_bytes() == b"old"


def test_unwritable_folder_is_told_before_long_work(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr("os.access", lambda path, mode: mode != os.W_OK)
    monkeypatch.setattr("masonry_opt.cli.solve_scene", lambda *_, **__: pytest.fail("solved all the same"))
    assert run(monkeypatch, "solve", WALL_1, "--plot", tmp_path / "wall.png") == 2
    assert "does not let files be written" in capsys.readouterr().err
    (tmp_path / "folder.png").mkdir()
    assert run(monkeypatch, "solve", WALL_1, "--plot", tmp_path / "folder.png") == 2
    assert "is a folder" in capsys.readouterr().err


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


def test_names_of_blocks_make_no_paths(monkeypatch, capsys, tmp_path):
    """What a case file calls its blocks and itself stays in the output."""
    odd = "../../<script>alert(1)</script>[/red]{x}$\\\\frac{$"
    text = f'title = "{odd}"\nsource = "{odd}"\n' + GOOD.replace('"A"', f'"{odd}"')
    text += f'[reference]\nstatic = {{ value = 0.6, source = "{odd}" }}\n'
    path, folder = in_file(tmp_path, text), tmp_path / "out"
    folder.mkdir()
    code = run(monkeypatch, "solve", path, "--method", "static", "--json", "--plot", folder / "picture.svg")
    assert code == 0
    name = json.loads(capsys.readouterr().out)["block_results"][0]["block"]
    assert name == odd.replace("\\\\", "\\")
    assert list(folder.iterdir()) == [folder / "picture.svg"]
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["case.toml", "out"]
    assert "<script>" not in (folder / "picture.svg").read_text()


# Paths and files


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("-", "no such file"),
        ("", "is a folder"),
        ("/dev/zero", "pipe or device"),
        ("[/red].toml", "[/red].toml: no such file"),
        ("a\x1b[2J\u202e.toml", r"a\x1b[2J\u202e.toml: no such file"),
        ("bytes\udcff.toml", r"bytes\udcff.toml: no such file"),
        ("x" * 5000 + ".toml", "File name too long"),
    ],
)
def test_odd_paths(path, words, monkeypatch, capsys):
    assert run(monkeypatch, "solve", path) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert words in captured.err


def test_pipes_and_circles_of_links(monkeypatch, capsys, tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    assert run(monkeypatch, "solve", tmp_path / "pipe.toml") == 2
    assert "pipe or device" in capsys.readouterr().err
    (tmp_path / "loop.toml").symlink_to("loop.toml")
    assert run(monkeypatch, "solve", tmp_path / "loop.toml") == 2
    assert "symbolic links" in capsys.readouterr().err
    with pytest.raises(CaseError, match="null"):
        mo.load("a\0.toml")


ODD_FILES = {
    "UTF-16": ("case.toml", GOOD.encode("utf-16"), "not UTF-8"),
    "Latin-1": ("case.toml", GOOD.replace('"A"', '"é"').encode("latin-1"), "not UTF-8"),
    "NUL": ("case.toml", GOOD.replace('"A"', '"\0"'), "not valid TOML"),
    "only NUL": ("case.json", b"\0" * 100, "not valid JSON"),
    "deep lists": ("case.toml", "a = " + "[" * 50_000, "nested too deeply"),
    "deep tables": ("case.toml", "a = " + "{a=" * 50_000, "nested too deeply"),
    "dotted key": ("case.toml", ".".join(["a"] * 20_000) + " = 1", "more than 9 parts (line 1)"),
    "dotted table": (
        "case.toml",
        "\n[" + '"x]" . ' * 20 + "a]",
        "more than 9 parts (line 2)",
    ),
    "too large": ("case.toml", GOOD.replace("0.6", "1e400"), "the number 1e400 is too large"),
    "too large in JSON": ("case.json", '{"joints": {"friction": 1e400}}', "1e400 is too large"),
    "long whole number": ("case.toml", GOOD.replace("0.6", "9" * 5000), "thousands of digits"),
    "long whole number in JSON": ("case.json", '{"a": ' + "9" * 5000 + "}", "thousands of digits"),
    "long hexadecimal": ("case.toml", GOOD.replace("0.6", "0x" + "f" * 9000), "thousands of digits"),
    "NaN in JSON": ("case.json", '{"joints": {"friction": NaN}}', "'friction'"),
    "date": ("case.toml", GOOD.replace("0.6", "1979-05-27"), "must be a number (found datetime.date"),
    "half a character": ("case.json", '{"joints": {"friction": 1}, "title": "\\ud800"}', "'title'"),
    "escape in a name": ("case.toml", GOOD.replace('"A"', r'"\u001b[31m"'), "control characters"),
    "C1 in a name": ("case.toml", GOOD.replace('"A"', r'"\u009b31m"'), "control characters"),
    "turned writing": ("case.toml", GOOD.replace('"A"', r'"\u202egnp"'), "control characters"),
    "escape in a key": ("case.toml", '"\\u001b[2J" = 1\n' + GOOD, r"unknown key '\x1b[2J'"),
    "line end in a key": ("case.toml", '"a\\nerror: b" = 1\n' + GOOD, r"unknown key 'a\nerror: b'"),
    "long key": ("case.toml", f'"{"x" * 10**6}" = 1\n' + GOOD, "..."),
    "long name": ("case.toml", GOOD.replace('"A"', f'"{"x" * 10**6}"'), "at most 200 characters"),
    "long title": ("case.toml", f'title = "{"x" * 10**6}"\n' + GOOD, "at most 2000 characters"),
    "repeated key": ("case.json", '{"a": 1, "b": 2, "a": 1}', "'a' is given twice"),
    "braces": (
        "case.toml",
        '[joints]\nfriction = 1\n[wall]\nblock = [1, 1]\nweight = 1\ncourses = ["{x}"]',
        "no course is named '{x}'",
    ),
    "endless wall": (
        "case.toml",
        "[joints]\nfriction = 1\n[wall]\nblock = [1, 1]\nweight = 1\nrepeat = 100000\ncourses = [[1, 1]]",
        "has 200000 blocks and gaps",
    ),
    "endless façade": (
        "case.toml",
        "[joints]\nfriction = 1\n[facade]\nopenings = [1000, 1000]\nblock = [2, 1]\njamb = 1\n"
        "opening = [1, 1]\nsill = 2\nspandrel = 2\nweight = 1\nlintel_weight = 1",
        "is 18000000 blocks large",
    ),
    "many wrong blocks": ("case.json", json.dumps({"block": [{}] * 1000}), "more mistakes"),
    "too many tables": ("case.toml", "[[block]]\n" * 200_001, "200001 entries"),
    "too many blocks": ("case.json", json.dumps({"block": [[]] * 200_001}), "200001 entries"),
}


@pytest.mark.parametrize("name", ODD_FILES)
def test_odd_files_end_in_a_short_message(name, monkeypatch, capsys, tmp_path):
    file, content, words = ODD_FILES[name]
    path = in_file(tmp_path, content, file)
    assert run(monkeypatch, "solve", path) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert words in captured.err
    assert str(path) in captured.err
    assert len(captured.err) < 5000
    assert all(letter == "\n" or letter.isprintable() for letter in captured.err)


def test_repeated_key_among_many_is_found_at_once(tmp_path):
    keys = ", ".join(f'"k{number}": 0' for number in range(300_000))
    with pytest.raises(CaseError, match="'z' is given twice"):
        mo.load(in_file(tmp_path, f'{{{keys}, "z": 0, "z": 0}}', "case.json"))


def test_file_of_fifty_megabytes(tmp_path):
    path = tmp_path / "case.toml"
    with path.open("wb") as stream:
        stream.truncate(50_000_000)
    with pytest.raises(CaseError, match=f"larger than {LARGEST_FILE // 1_000_000} MB"):
        mo.load(path)


def test_blocks_on_one_another_are_refused_before_all_pairs_are_made():
    block = mo.Block(name="0", vertices=[(0, 0), (1, 0), (1, 1)], weight=1)
    base = mo.Block(name="base", vertices=[(0, -1), (1, -1), (1, 0), (0, 0)], fixed=True)
    copies = [block.model_copy(update={"name": str(number)}) for number in range(20_000)]
    scene = mo.Scene(joints=mo.JointDefaults(friction=0.5), blocks=[*copies, base])
    with pytest.raises(CaseError, match="lie on one another"):
        assemble(scene)


def test_outlines_too_fine_to_compare():
    """Two shallow arcs on the two sides of a diagonal, so that each lies in the other's box."""

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
    with pytest.raises(CaseError, match=r"too fine to find joints \(block '(upper|lower)' has 12001 corners"):
        assemble(scene)


@pytest.mark.parametrize("error", [CaseError, OptionError])
def test_messages_show_what_they_quote(error):
    assert str(error("a\x1b[31m\u202e\ud800é\nλ")) == "a\\x1b[31m\\u202e\\ud800é\nλ"


@pytest.mark.parametrize(
    ("library", "words"), [("pandas", ""), ("cvxpy", ": before the first λ; nothing was written")]
)
def test_ctrl_c_while_the_libraries_load_is_a_message(library, words):
    """They take seconds, of which an interrupt may fall into any: those of the command, or of the solve."""
    program = f"""
import sys
class Interrupted:
    def find_spec(self, name, *_):
        if name == "{library}":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupted())
from masonry_opt.command import main
main()
"""
    command = [sys.executable, "-c", program, "solve", str(WALL_1)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", f"error: interrupted{words}\n")
