"""The command line: what is printed where, exit codes, pictures and tables."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
from scenes import CASES, block_on_floor

import masonry_opt as mo
from masonry_opt.cli import main
from masonry_opt.report.mechanism_plot import joint_motion
from masonry_opt.report.terminal import markdown
from masonry_opt.studies.paper.table1 import table1
from masonry_opt.studies.paper.text import report_text

README = Path(__file__).parents[2] / "README.md"
WALL_1 = CASES / "ferris_tinloi" / "wall_1.toml"


def run(monkeypatch, capsys, *arguments):
    monkeypatch.setattr("sys.argv", ["masonry-opt", *map(str, arguments)])
    try:
        main()
        code = 0
    except SystemExit as end:
        code = end.code or 0
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_json_is_one_object_with_everything_asked_for(monkeypatch, capsys):
    code, out, _ = run(monkeypatch, capsys, "solve", WALL_1, "--json")
    answer = json.loads(out)
    assert code == 0
    assert answer["case"] == str(WALL_1)
    assert (answer["method"], answer["model"], answer["solver"]) == ("nonassociative", "cvxpy", "clarabel")
    assert answer["status"] == "converged"
    assert answer["load_factor"] == pytest.approx(0.63982, rel=3e-4)
    assert (answer["blocks"], answer["joints"]) == (33, 83)
    assert answer["iterations"] > answer["lp_solves"] > 1
    assert set(answer["certificate"]) == {"equilibrium", "yield", "flow", "complementarity"}
    assert set(answer["seconds"]) == {"scene", "dead_load", "build", "compile", "solve", "read"}
    assert all(seconds > 0 for seconds in answer["seconds"].values())
    assert len(answer["joint_results"]) == 83
    assert len(answer["block_results"]) == 33
    # The exact state at the end is one program more than there are sub-problems.
    assert len(answer["history"]) == answer["lp_solves"] - 1


@pytest.mark.parametrize("method", ["static", "kinematic"])
@pytest.mark.parametrize(("model", "solver"), [("cvxpy", "highs"), ("pyomo", "highs-ipm")])
def test_methods_models_and_solvers_can_be_chosen(monkeypatch, capsys, method, model, solver):
    options = ["--method", method, "--model", model, "--solver", solver, "--json"]
    code, out, _ = run(monkeypatch, capsys, "solve", WALL_1, *options)
    answer = json.loads(out)
    assert code == 0
    assert (answer["method"], answer["model"], answer["solver"]) == (method, model, solver)
    assert answer["load_factor"] == pytest.approx(0.642859, abs=1e-6)


def test_text_names_the_load_factor_and_its_certificate(monkeypatch, capsys):
    code, out, _ = run(monkeypatch, capsys, "solve", WALL_1)
    assert code == 0
    assert "load factor      0.6398" in out
    assert "equilibrium" in out
    assert "converged" in out


def test_options_of_the_method_and_published_values(monkeypatch, capsys):
    code, out, _ = run(monkeypatch, capsys, "solve", WALL_1, "-o", "start=cohesive", "-o", "beta=0.5")
    assert code == 0
    assert "published        0.63982 (Gilbert, Casapulla & Ahmed (2006), Table 1), here -0.0" in out
    for wrong, words in (("beta=2", "beta"), ("gamma=1", "no option 'gamma'"), ("beta", "NAME=VALUE")):
        code, out, err = run(monkeypatch, capsys, "solve", WALL_1, "-o", wrong)
        assert (code, out) == (2, "")
        assert words in err


def test_version(monkeypatch, capsys):
    code, out, _ = run(monkeypatch, capsys, "--version")
    assert (code, out) == (0, "0.1.0\n")


def test_installed_command_in_a_process_of_its_own(tmp_path):
    """Standard output holds the JSON object alone, and a failed run leaves it empty."""
    command = [sys.executable, "-c", "from masonry_opt.cli import main; main()", "solve"]
    good = subprocess.run([*command, str(WALL_1), "--json"], capture_output=True, text=True, check=False)
    assert good.returncode == 0
    assert json.loads(good.stdout)["blocks"] == 33
    bad = subprocess.run([*command, str(tmp_path / "no.toml")], capture_output=True, text=True, check=False)
    assert bad.returncode == 2
    assert bad.stdout == ""
    assert bad.stderr == f"error: {tmp_path / 'no.toml'}: no such file\n"


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_plot_is_written_in_the_format_of_its_name(monkeypatch, capsys, tmp_path, ending):
    picture = tmp_path / f"wall.{ending}"
    code, _, _ = run(monkeypatch, capsys, "solve", WALL_1, "--plot", picture)
    assert code == 0
    start = picture.read_bytes()[:100]
    assert {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[ending] in start
    assert list(tmp_path.iterdir()) == [picture]


def test_plot_shows_load_factor_and_legend(tmp_path):
    import matplotlib as mpl

    from masonry_opt.report.mechanism_plot import plot_mechanism

    with mpl.rc_context({"svg.fonttype": "none"}):
        plot_mechanism(mo.solve(WALL_1), tmp_path / "wall.svg")
    text = (tmp_path / "wall.svg").read_text()
    for words in ("Ferris &amp; Tin-Loi wall 1", "0.63982", "sliding joint", "hinging joint"):
        assert words in text


def test_titles_may_hold_anything(tmp_path):
    from masonry_opt.report.mechanism_plot import plot_mechanism

    scene = block_on_floor().model_copy(update={"title": "costs $\\frac{$ " + "very " * 40})
    plot_mechanism(mo.solve(scene), tmp_path / "picture.png")


@pytest.mark.parametrize(
    ("width", "friction", "slides", "hinges"), [(1, 0.8, False, True), (4, 0.5, True, False)]
)
def test_marked_joints_are_those_that_move(width, friction, slides, hinges):
    motion = joint_motion(mo.solve(block_on_floor(width, 2, friction)))
    assert (motion.slides[0], motion.hinges[0]) == (slides, hinges)


def test_block_overturns_about_its_far_toe():
    result = mo.solve(block_on_floor(1, 2, 0.8))
    toe = joint_motion(result).hinge[0] + result.assembly.geometry.origin
    assert toe == pytest.approx([1, 0])


def test_plot_of_blocks_that_fall(monkeypatch, capsys, tmp_path):
    case = tmp_path / "case.toml"
    overhang = mo.Scene(
        joints=mo.JointDefaults(friction=0.6),
        blocks=[
            mo.Block(name="A", vertices=[(0, 0), (3, 0), (3, 1), (0, 1)], weight=1, live=(1, 0)),
            mo.Block(name="base", vertices=[(-3, -1), (0.5, -1), (0.5, 0), (-3, 0)], fixed=True),
        ],
    )
    mo.save(overhang, case)
    code, out, _ = run(monkeypatch, capsys, "solve", case, "--plot", tmp_path / "falls.png")
    assert code == 1
    assert "unstable under dead load" in out
    assert (tmp_path / "falls.png").exists()


def test_check_command(monkeypatch, capsys):
    code, out, _ = run(monkeypatch, capsys, "check", WALL_1)
    assert code == 0
    assert "agree" in out
    assert "kinematic" in out


def cells(table):
    """Texts of a table in Markdown."""
    return [cell.strip() for row in table.splitlines() for cell in row.strip("| ").split("|")]


@pytest.mark.slow
def test_reproduce_table1(monkeypatch, capsys, tmp_path):
    """All six walls, every column within the tolerance of its case file; minutes."""
    code, out, err = run(monkeypatch, capsys, "reproduce", "table1", "--out", tmp_path, "--cases", CASES)
    assert code == 0, out
    assert "every value is within its tolerance" in out
    table = pd.read_csv(tmp_path / "table1.csv")
    assert list(table["wall"]) == [1, 2, 3, 4, 5, 6]
    assert list(table["assoc. paper"]) == [0.64286, 0.58, 0.40369, 0.33195, 0.23964, 0.34782]
    most = [0.638983, 0.557417, 0.355818, 0.263737, 0.207974, 0.291786]
    assert (table["refined"] <= most).all()
    assert (table["mpec"] / table["MPEC publ."] - 1).abs().max() < 1e-4
    assert (table["refined"] <= table["mpec"] + 1e-7).all()
    assert "index.html" in err
    assert 'href="table1.csv"' in (tmp_path / "index.html").read_text()
    residuals = pd.read_csv(tmp_path / "table1_residuals.csv")
    assert (residuals["status"] == "converged").all()
    parts = ["equilibrium", "yield", "flow", "complementarity"]
    assert (residuals.loc[residuals["method"] == "refined", parts] < 1e-8).all(axis=None)
    # What the README shows is what is printed today, to two units of the last digit.
    shown = README.read_text().split("<!-- table1 -->\n")[1].split("<!-- /table1 -->")[0]
    printed = markdown(pd.read_csv(tmp_path / "table1.csv"))
    assert len(cells(shown)) == len(cells(printed))
    for old, new in zip(cells(shown), cells(printed), strict=True):
        if re.fullmatch(r"-?\d+\.\d+", new):
            assert float(old) == pytest.approx(float(new), abs=2.1 * 10.0 ** -len(new.split(".")[1]))
        else:
            assert old == new
    # What is left at the loop's exact answers, to two orders of magnitude: below 1e-9 it is rounding.
    shown = README.read_text().split("<!-- residuals -->\n")[1].split("<!-- /residuals -->")[0]
    rows = [cells(row)[2:6] for row in shown.splitlines()[2:]]
    loops = residuals.loc[residuals["method"] == "loop", parts]
    assert len(rows) == len(loops)
    for old, new in zip(rows, loops.to_numpy(), strict=True):
        for was, value in zip(old, new, strict=True):
            assert value <= max(100 * float(was), 1e-9)
            assert float(was) <= max(100 * value, 1e-9)


def test_table1_says_which_value_misses(tmp_path):
    """One block that rocks at λ = 1/2 in the place of wall 1, for speed, with two wrong references."""
    wall = tmp_path / "ferris_tinloi" / WALL_1.name
    wall.parent.mkdir()
    values = {
        "associative": 0.5,
        "nonassociative": 0.6,
        "mpec": 0.5,
        "refined": 0.5,
        "blocks": 1,
        "joints": 2,
    }
    references = {
        name: mo.Reference(value=value, source="by hand", tolerance=1e-3) for name, value in values.items()
    }
    mo.save(block_on_floor().model_copy(update={"reference": references}), wall)
    table = table1(tmp_path, walls=[1])
    assert len(table.missed) == 2
    missed = "\n".join(table.missed)
    assert "wall 1 (cvxpy, clarabel): nonassociative: 0.5, published 0.6" in missed
    assert "wall 1: joints: 1, published 2" in missed
    assert missed in report_text("Table 1", table).replace("\n  ", "\n")
    assert set(table.tables["table1_residuals"]["method"]) == {"loop", "mpec", "refined"}


def test_reproduce_without_case_files_or_folder(monkeypatch, capsys, tmp_path):
    code, out, err = run(monkeypatch, capsys, "reproduce", "table1", "--cases", tmp_path)
    assert (code, out) == (2, "")
    assert "no such file" in err
    code, _, err = run(monkeypatch, capsys, "reproduce", "table9")
    assert code == 2
    assert "table1" in err


def test_check_of_a_scene_without_load_factor(monkeypatch, capsys, tmp_path):
    case = tmp_path / "case.toml"
    mo.save(block_on_floor(live=(0.0, -1.0)), case)
    code, out, err = run(monkeypatch, capsys, "check", case)
    assert (code, out) == (1, "")
    assert "unlimited" in err


def test_check_where_the_load_factor_is_zero(monkeypatch, capsys, tmp_path):
    case = tmp_path / "case.toml"
    mo.save(block_on_floor(friction=0.0), case)
    assert run(monkeypatch, capsys, "check", case)[0] == 0
