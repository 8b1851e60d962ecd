"""Tests of the command line, in the plane and in space: printed text, exit codes, pictures and tables."""

import json
import re
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module

import pytest
from forks import in_forks
from scenes import (
    CASES,
    WALLS,
    block_on_floor,
    overhanging,
    pressed_down,
    run_command,
    small_wall,
    two_blocks,
)
from scenes_in_space import box_on_floor
from screens import Screen

import masonry_opt as mo
from masonry_opt.reporting.terminal import print_result
from masonry_opt.scene.blocks import rectangle

cli_solve = import_module("masonry_opt.cli.solve")
WALL_1 = WALLS[0]
LOOP = ["--method", "nonassociative"]
AS_LOOP = ("nonassociative", "cvxpy", "clarabel")
AS_DEFAULT = ("coulomb", "matrices", "newton")


@pytest.fixture
def saved(tmp_path):
    """Return a function that writes a scene to a case file and returns its path."""

    def write(scene):
        mo.save(scene, tmp_path / "case.toml", force=True)
        return tmp_path / "case.toml"

    return write


@pytest.mark.parametrize(
    ("method", "said"), [("coulomb", AS_DEFAULT), (None, AS_DEFAULT), (LOOP[1], AS_LOOP)]
)
def test_json_is_one_object_with_everything_asked_for(command, method, said):
    """JSON has all parts of the answer, also if no method is named."""
    answer = command.json("solve", WALL_1, *(["--method", method] if method else []))
    assert answer["case"] == str(WALL_1)
    assert (answer["method"], answer["model"], answer["solver"]) == said
    assert answer["status"] == "converged"
    assert (answer["blocks"], answer["joints"]) == (33, 83)
    assert set(answer["certificate"]) == {"equilibrium", "yield", "flow", "complementarity"}
    parts = {"scene", "dead_load", "incremental", "build", "compile", "solve", "read", "associative"}
    assert set(answer["seconds"]) == parts
    assert answer["associative"] == pytest.approx(0.64286, abs=5e-6)
    # The load history of this wall ends in an exact state. The answer of the loop is not exact.
    assert answer["lowest"] == answer["load_factor" if answer["exact"] else "incremental"]
    assert answer["range"] == [None, answer["lowest"]]
    assert len(answer["joint_results"]) == 83
    assert len(answer["block_results"]) == 33
    if said == AS_LOOP:
        assert answer["load_factor"] == pytest.approx(0.63982, rel=3e-4)
        assert answer["iterations"] > answer["lp_solves"] > 1
        # The first sub-problem of the loop is the associative program.
        assert all(answer["seconds"][part] > 0 for part in parts - {"associative"})
        # The search for the exact state at the end is one more program than there are sub-problems.
        assert len(answer["history"]) == answer["lp_solves"] - 1
    else:
        # The answer is the lowest exact state known. Its history has a row for each Newton step, and for the
        # programs of the descent.
        assert answer["load_factor"] == pytest.approx(0.638982, abs=1e-6)
        assert answer["kind"] == "exact"
        assert answer["iterations"] > len(answer["history"]) > answer["lp_solves"] > 1
        assert max(answer["certificate"].values()) < 1e-8


@pytest.mark.parametrize(
    ("method", "model", "solver"), [("static", "cvxpy", "highs"), ("kinematic", "pyomo", "highs-ipm")]
)
def test_methods_models_and_solvers_can_be_chosen(command, method, model, solver):
    options = ("--method", method, "--model", model, "--solver", solver)
    answer = command.json("solve", WALL_1, *options)
    assert (answer["method"], answer["model"], answer["solver"]) == (method, model, solver)
    assert answer["load_factor"] == pytest.approx(0.642859, abs=1e-6)


def labels(text):
    """Return the label of each line, without lines that continue the one above."""
    return [line.split("  ")[0] for line in text.splitlines() if not line.startswith(" ")]


#: Labels of the lines that say how an answer was found, which are printed with --verbose only.
TECHNICAL = {"method", "status", "certificate", "programs", "solvers", "seconds", "not modelled"}


def test_text_says_what_moves_at_what_load_and_how_sure_that_is(monkeypatch, capsys):
    code, out, err = run_command(monkeypatch, capsys, "solve", WALL_1, *LOOP)
    assert (code, err) == (0, "")
    assert "33 blocks, 83 joints" in out.splitlines()[0]
    assert out.splitlines()[1] == "load factor λ"
    assert out.splitlines()[2].startswith("  found          0.6398")
    assert labels(out)[2].startswith("at the state found: ")
    assert labels(out)[3:] == ["live load", "reference"]
    # Sliding joints contract by 10⁻³ μ in the loop, so that no exact state is found and the flow residual is
    # printed.
    assert re.search(r"^  found .*flow \d\.\de-0[34]", out, re.MULTILINE)
    assert "\x1b" not in out


def test_verbose_adds_how_it_was_found(command):
    """The option adds lines to an answer that a descent found, and changes none."""
    plain, out = command("solve", WALL_1), command("solve", WALL_1, "--verbose")
    assert out.startswith(plain)
    assert set(labels(out)) - set(labels(plain)) >= TECHNICAL - {"not modelled"}
    assert not TECHNICAL & set(labels(plain))
    words = r"^status +converged: one exact state was found from 1 start$"
    assert re.search(words, out, re.MULTILINE)
    assert re.search(r"^programs +\d+ linear \(\d+ solver iterations\)$", out, re.MULTILINE)
    assert "incremental analysis: newton   refinement: highs" in out
    assert "reference        0.64285 (Ferris & Tin-Loi (2001) in Gilbert" in out


def test_quiet_prints_the_load_factor_alone(monkeypatch, capsys, command, saved):
    code, out, err = run_command(monkeypatch, capsys, "solve", saved(two_blocks()), "--quiet")
    assert (code, err) == (0, "")
    assert float(out) == pytest.approx(0.15, rel=1e-9)  # By hand, λ = 1.5 μ.
    assert "--quiet" in command.refused("solve", saved(two_blocks()), "--quiet", "--json")
    none = saved(pressed_down())
    assert command.refused("solve", none, "--quiet", code=1).startswith(f"error: {none}: unlimited")


def test_quiet_prints_warnings_on_standard_error(monkeypatch, capsys, saved):
    """A friction of 31 causes a warning, because it looks like an angle in degrees."""
    code, out, err = run_command(monkeypatch, capsys, "solve", saved(block_on_floor(friction=31)), "--quiet")
    assert code == 0
    assert len(out.splitlines()) == 1
    assert err.startswith("warning: the friction coefficient 31")


@pytest.mark.parametrize(("environment", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False)])
def test_colours_are_for_terminals(monkeypatch, terminal, environment, coloured):
    """Only the answer is bold and only warnings are yellow, on a terminal without NO_COLOR."""
    text = "case\nload factor λ\n  found 0.1\nlive load [bold] :smile:"
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    with redirect_stdout(Screen(terminal=False)) as pipe, redirect_stderr(Screen(terminal=False)) as errors:
        print_result(f"{text}\nwarning: odd")
    assert (pipe.getvalue(), errors.getvalue()) == (f"{text}\n", "warning: odd\n")
    with redirect_stdout(Screen(terminal=True)) as screen, redirect_stderr(Screen(terminal=True)) as errors:
        print_result(f"{text}\nwarning: odd")
    out = screen.getvalue()
    assert re.sub(r"\x1b\[[\d;]*m", "", out) == text + "\n"
    assert ("\x1b[1mload factor λ" in out, "33mwarning: odd" in errors.getvalue()) == (coloured, coloured)
    assert ("\x1b[1m  found 0.1" in out) is coloured
    assert "\x1b" not in out.splitlines()[3]


@pytest.mark.parametrize("environment", [{}, {"NO_COLOR": "1"}])
def test_long_lines_are_wrapped_between_words_on_a_terminal(monkeypatch, environment):
    """Continuation lines begin below the text of the line. Rows of tables, and text in a pipe, stay whole."""
    words = "equilibrium is lost as the live load grows from zero and continues to grow beyond this state"
    row = "a  1  2  3  " + 30 * "x  "
    lines = ["case", f"  lowest found   0.1   {words}", f"live load        {words}", f"{words}: {words}", row]
    for name, value in {"COLUMNS": "60", **environment}.items():
        monkeypatch.setenv(name, value)
    with redirect_stdout(Screen(terminal=False)) as pipe:
        print_result("\n".join(lines))
    assert pipe.getvalue().splitlines() == lines
    with redirect_stdout(Screen(terminal=True)) as screen:
        print_result("\n".join(lines))
    out = re.sub(r"\x1b\[[\d;]*m", "", screen.getvalue()).splitlines()
    assert max(map(len, out[:-1])) <= 60
    assert out[1:3] == [
        "  lowest found   0.1   equilibrium is lost as the live load",
        "                       grows from zero and continues to grow",
    ]
    assert any(line.startswith("                 from zero and") for line in out)
    assert " ".join(" ".join(out).split()) == " ".join(" ".join(lines).split())
    assert out[-1] == row
    table = [f" {70 * '─'}", f"{70 * ' '}of a cell"]
    with redirect_stdout(Screen(terminal=True)) as screen:
        print_result("\n".join(table), bold_line=None)
    assert screen.getvalue().splitlines() == table


def test_a_plain_tool_is_as_plain_of_what_falls(command, saved, tmp_path):
    out = command("solve", saved(overhanging()), "--plot", tmp_path / "falls.png", code=1)
    assert (tmp_path / "falls.png").exists()
    assert "unstable under dead load" in out.splitlines()[1]
    assert labels(out)[2:] == ["why", "falls"]
    assert re.search(r"^falls +1 of 1 block; 1 joint ", out, re.MULTILINE)


def test_text_where_no_load_factor_exists(command, saved):
    out = command("solve", saved(pressed_down()), "-v", code=1)
    # If λ of the load history grows without limit, a proof is sought first, and the loop does not run.
    assert re.search(r"^programs +none: \d+ load steps?$", out, re.MULTILINE)
    existence = "no load factor exists: the live load does no positive work in any mechanism"
    assert re.search(rf"^existence +{existence}$", out, re.MULTILINE)


def test_steps_are_named_while_it_runs(watched, command):
    """Each step is shown while the command runs; the message of Ctrl-C names the last step."""

    def interrupted(_):
        if len(recorded) == 3:
            raise KeyboardInterrupt

    recorded = watched(import_module("masonry_opt.cli.command"), "residuals_of_step", interrupted)
    err = command.refused("solve", WALL_1, code=130)
    assert (
        f"the last step was load step 3: λ = {recorded[-1][0].load_factor:.6f}, "
        "but its λ is not the collapse load factor" in err
    )


def test_the_command_prints_what_python_prints(command, saved):
    case = saved(two_blocks())
    for method in ("static", "nonassociative", "coulomb"):
        out = command("solve", case, "--method", method)
        assert out == f"{mo.solve(case, method)}\n"
        assert out.count("\n") > 3


def test_options_of_the_method_and_published_values(command):
    out = command("solve", WALL_1, *LOOP, "-o", "start=cohesive", "-o", "beta=0.5")
    reference = "reference        0.63982 (Gilbert, Casapulla & Ahmed (2006), Table 1)"
    assert f"{reference}; the λ of this result differs from the reference by -0.0" in out
    out = command("solve", CASES / "livesley" / "wedges.toml")
    assert "reference        1.280338 (by hand: 1 + (t9 - t1) / (t9 + t19)" in out
    for wrong, words in (("beta=2", "beta"), ("gamma=1", "no option 'gamma'"), ("beta", "NAME=VALUE")):
        assert words in command.refused("solve", WALL_1, *LOOP, "-o", wrong)


@pytest.mark.slow
def test_a_published_value_of_an_mcp_or_the_loop_serves_the_default():
    """The reference of method 'coulomb' is printed first, else that of an MCP, else that of the loop.

    The name of a value that is not of method 'coulomb' is printed, together with the value of an MPEC.
    """
    scene = mo.load(CASES / "livesley" / "wedges.toml")
    own, loop = scene.reference["coulomb"], scene.reference["nonassociative"]
    mcp = own.model_copy(update={"source": "an MCP"})
    for reference, words in (
        ({"nonassociative": loop, "mcp": mcp, "coulomb": own}, "1.280338 (by hand"),
        ({"nonassociative": loop, "mcp": mcp}, "1.280338 (an MCP; value 'mcp' of the case file);"),
        (
            {"mcp": mcp, "mpec": loop},
            "1.280338 (an MCP; value 'mcp' of the case file, which also has 'mpec' = 1.28);",
        ),
        (
            {"nonassociative": loop},
            "1.28 (Gilbert, Casapulla & Ahmed (2006), Fig. 8 (b); value 'nonassociative' of the case file); "
            "the λ of this result differs from the reference by +0.0",
        ),
    ):
        assert f"reference        {words}" in str(mo.solve(scene.replace(reference=reference)))


def test_version(command):
    assert command("--version") == "0.1.0\n"


#: Lines that let solvers print to the descriptor of standard output, in C and in Python. Output in C is
#: buffered until the end. The command named "interrupted" is interrupted while solvers print.
NOISY = """
import ctypes
from masonry_opt.effort import Effort

add = Effort.add

def prints(effort, part, seconds):
    os.write(1, b"banner\\n")
    ctypes.CDLL(None).printf(b"banner\\n")
    print("banner")
    if name == "interrupted":
        raise KeyboardInterrupt
    add(effort, part, seconds)

Effort.add = prints
"""

SMALL = CASES / "gilbert" / "two_blocks.toml"
IN_SPACE = CASES / "space" / "corner_wall.toml"
#: Commands whose standard output is one JSON object.
WITH_JSON = {
    "solve": ["solve", SMALL],
    "directions": ["directions", IN_SPACE, "--every", "180", "--method", "static"],
    "capacity": ["capacity", CASES / "oppenheim" / "seven_voussoirs.toml"],
    "settle": ["settle", SMALL, "--support", "floor", "--direction", "0,-1"],
    "least": ["least", SMALL, "--vary", "joints.friction=0.05:1", "--load", "0.3", "--samples", "0"],
}


@pytest.mark.slow
def test_nothing_but_the_object_whatever_solvers_print(tmp_path):
    """Standard output is one line of JSON. It is empty if a command is interrupted as a solver prints."""
    commands = {
        name: [*asked, "--json"] for name, asked in (WITH_JSON | {"interrupted": ["solve", SMALL]}).items()
    }
    imported = ("masonry_opt.studies.load_cases.cases", "masonry_opt.cli.studies", "cvxpy", "pandas")
    ended = in_forks(commands, tmp_path, imported, before=NOISY)
    assert all(error.count("banner") >= 3 for _, _, error in ended.values())
    assert ended.pop("interrupted")[:2] == (130, "")
    for name, (code, out, _) in ended.items():
        assert code in (0, 1), name
        assert json.loads(out), name
        assert out.count("\n") == 1, name


def test_kind_of_plot_and_names_can_be_chosen(command, saved, tmp_path):
    picture = tmp_path / "case.svg"
    options = ("--plot", picture, "--plot-kind", "utilisation", "--names")
    command("solve", saved(two_blocks()), *options)
    # Letters are drawn as paths, each with its text in a comment.
    assert "<!-- support -->" in picture.read_text()
    assert "<!-- utilisation of joints" in picture.read_text()


def test_a_curve_can_be_asked_for_and_drawn(command, saved, tmp_path):
    picture = tmp_path / "curve.svg"
    asked = ("--method", "incremental", "-o", "curve=true", "--plot", picture, "--plot-kind", "curve")
    curve = command.json("solve", saved(small_wall()), *asked)["curve"]
    load_factors = [state["load_factor"] for state in curve]
    assert load_factors == sorted(load_factors)
    assert any(state["starts_opening"] for state in curve)
    assert "<!-- the first joints open -->" in picture.read_text()


def test_draw_command(monkeypatch, capsys, saved, tmp_path):
    """A scene that cannot be solved is drawn: one block falls, one has a small gap next to it, and one
    floats."""
    scene, picture = overhanging(), tmp_path / "case.png"
    more = [
        mo.Block(name="B", vertices=rectangle(3.0005, 4, 0, 1), weight=1),
        mo.Block(name="C", vertices=rectangle(3.0005, 4, -1, 0), fixed=True),
        mo.Block(name="D", vertices=rectangle(0, 1, 3, 4), weight=1),
    ]
    case = saved(scene.replace(blocks=[*scene.blocks, *more]))
    code, out, err = run_command(monkeypatch, capsys, "draw", case, picture, "--names")
    assert (code, out) == (0, f"{picture}: 3 blocks, 2 supports, 2 joints, 1 small gap\n")
    # No block supports D, and there is a gap between B and A.
    assert err.count("warning: ") == 2
    assert all(f"'{name}'" in err for name in "DAB")
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("case", "picture", "named"), [(WALL_1, "none/wall.png", "none"), ("no.toml", "no.png", "no.toml")]
)
def test_draw_command_names_what_is_wrong(command, tmp_path, case, picture, named):
    assert named in command.refused("draw", case, tmp_path / picture)
    assert not list(tmp_path.iterdir())


def test_check_command(command, saved):
    """The programs agree for a wall and for a scene with λ = 0; the check fails for a scene without a load
    factor."""
    for case in (WALL_1, saved(block_on_floor(friction=0.0))):
        out = command("check", case)
        assert "agree" in out
        assert "kinematic" in out
    assert "unlimited" in command.refused("check", saved(pressed_down()), code=1)


@pytest.fixture
def case(saved):
    return saved(box_on_floor((2, 2, 1), 0.5))


REFERENCE = '[reference]\nassociative = { value = 0.4, source = "none" }\n'
COUNTED = "1 block, 1 joint, 4 contacts"


@pytest.mark.parametrize(
    ("asked", "expected"),
    [
        (
            "solve {} --method static --verbose",
            [COUNTED, "associative    0.5   upper bound", "limited by the friction cone"],
        ),
        (
            "solve {}",
            [
                "associative 0.4 (none); the associative λ of this result differs from the reference by "
                "+25.000 %"
            ],
        ),
        ("check {}", ["agree"]),
        (
            "solve {} --method incremental -o curve=true --plot-kind curve --plot curve.png",
            ["load–displacement curve"],
        ),
    ],
)
def test_commands_tell_what_there_is_of_solids(monkeypatch, command, case, asked, expected):
    """Commands on a box print λ = μ = 0.5, which is 25 % above an associative reference of 0.4."""
    case.write_text(case.read_text() + REFERENCE)
    monkeypatch.chdir(case.parent)
    out = command(*asked.format(case).split())
    for words in expected:
        assert words in out
    assert (case.parent / "curve.png").exists() == ("--plot" in asked)


VIEWED = ["solve {} --method static --plot a.svg --view=", "draw {} a.svg --view="]


@pytest.mark.slow
@pytest.mark.parametrize("asked", [*(f"{each}30,45" for each in VIEWED), "export {} a.obj --method static"])
def test_pictures_and_meshes_are_written(monkeypatch, command, case, asked):
    monkeypatch.chdir(case.parent)
    command(*asked.format(case).split())
    (written,) = case.parent.glob("a.*")
    assert ("<svg" if written.suffix == ".svg" else "o fixed floor") in written.read_text()


@pytest.mark.parametrize("view", ["30", "30,north", "30,91", "nan,0"])
@pytest.mark.parametrize("asked", VIEWED)
def test_views_are_refused_before_anything_is_solved(monkeypatch, watched, command, case, asked, view):
    monkeypatch.chdir(case.parent)
    solved = watched(cli_solve, "solve_scene")
    assert "view" in command.refused(*f"{asked}{view}".format(case).split())
    assert solved == []
    assert not list(case.parent.glob("a.*"))


def test_a_plane_scene_has_no_view(command, tmp_path):
    plane = CASES / "gilbert" / "two_blocks.toml"
    assert "plane" in command.refused("draw", plane, tmp_path / "a.png", "--view=30,45")


@pytest.mark.parametrize(
    ("former", "present"), [("--no-expected", "--no-incremental"), ("--expected", "--incremental")]
)
def test_a_former_option_ends_in_its_present_name(command, former, present):
    err = command.refused("solve", WALL_1, former)
    assert err == f"error: option '{former}' is now called '{present}'\n"


def test_progress_with_json_is_written_to_standard_error(monkeypatch, capsys, saved):
    """Standard output stays one JSON object, and progress lines go to standard error."""
    monkeypatch.setattr("masonry_opt.reporting.terminal.SECONDS_BETWEEN_LINES", 0.01)
    code, out, error = run_command(monkeypatch, capsys, "solve", saved(two_blocks()), "--json")
    assert code == 0
    assert json.loads(out)["load_factor"] is not None
    assert re.search(r"^0 s: .*: ", error, re.MULTILINE)


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("capacity", ["--code", "NTC 2018 SLV"], "--code applies to a check against a spectrum"),
        ("capacity", ["--gravity", "981", "--confidence-factor", "1.2"], "--confidence-factor and --gravity"),
        ("capacity", ["--force"], "--force applies to a picture: add --plot FILE, or omit --force"),
        ("crossing", ["--force"], "--force applies to a picture"),
        ("directions", ["--force"], "--force applies to a picture"),
        ("settle", ["--support", "ground", "--direction", "0,-1", "--greatest"], "--greatest applies"),
        ("solve", ["--mechanism", "incremental", "--names"], "--names and --mechanism apply to a picture"),
    ],
)
def test_an_option_that_needs_another_option_is_refused_without_it(name, options, words, command, saved):
    assert words in command.refused(name, saved(block_on_floor()), *options)
