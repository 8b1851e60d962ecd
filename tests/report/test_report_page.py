"""Tests of the report: its numbers equal those of the answers, and it prints completely."""

import functools
import math
import re
from base64 import b64decode
from dataclasses import replace
from html import unescape
from pathlib import Path

import pytest
from loads.overhang import OVERHANG, axles
from scenes import CASES, block_on_floor, pressed_down, run_command, two_blocks

import masonry_opt as mo
from masonry_opt.cli import studies
from masonry_opt.errors import OptionError
from masonry_opt.reporting.sentences import numeral
from masonry_opt.solvers.cvxpy_engine import CvxpyEngine

WHEEL = mo.Axles(name="wheel", loads=[2, 2], distances=[0.5])
#: A slab on a support, under fill that may press against its sides.
UNDER_FILL = OVERHANG.replace(
    fills=[mo.Fill(road=[(-1, 2), (1, 2)], unit_weight=2, friction_angle=30, mobilised=0.5)]
)

#: Case file of a slab on a pier, with wind in one load case and a wheel in the other.
BRIDGE = """
title = "slab"
joints.friction = 0.5
block = [
    { name = "slab", vertices = [[-1, 0], [1, 0], [1, 1], [-1, 1]], weight = 12 },
    { name = "pier", vertices = [[-0.5, -1], [0.5, -1], [0.5, 0], [-0.5, 0]], fixed = true },
]
load = [{ block = "slab", live = [1, 0], group = "wind" }]
axles = [{ name = "wheel", loads = [3], road = [[-2, 1], [2, 1]] }]
load_case = [{ name = "wind", live = { wind = 1 } }, { name = "traffic", live = { axles = 1.5 } }]
"""


class Read:
    """The text, the rows of tables as dictionaries, and the sources of a page."""

    def __init__(self, path):
        self.raw = page = path.read_text("utf-8")
        self.text = " ".join(unescape(re.sub("<[^>]*>", " ", page)).split())
        rows = (
            re.findall('<td[^>]* data-label="([^"]*)"[^>]*>([^<]+)', row) for row in page.split("<tr")[1:]
        )
        self.rows = [{unescape(label): unescape(cell) for label, cell in row} for row in rows]
        self.sources = re.findall(' (?:src|href)="([^"]*)"', page)

    def column(self, label):
        return [row[label] for row in self.rows if label in row]


def reported(tmp_path, answer, **given):
    mo.report(answer, tmp_path / "report.html", **given)
    return Read(tmp_path / "report.html")


ANSWERS = {
    "result": lambda: mo.solve(block_on_floor()),
    "lowest": lambda: mo.solve(two_blocks(), descent=False),
    "associative": lambda: mo.solve(block_on_floor().replace(joints={"dilatancy": 0.6}), "static"),
    "none": lambda: mo.solve(pressed_down()),
    "falls": lambda: mo.solve(block_on_floor(dead=(5.0, 0.0))),
    "crossing": lambda: mo.crossing(UNDER_FILL, WHEEL, method="static"),
    "settlement": lambda: mo.settle(block_on_floor(), "floor", (0, -1)),
    "capacity": lambda: mo.capacity(mo.solve(block_on_floor(), incremental=False)),
    "directions": lambda: mo.directions(block_on_floor(live=(0.0, 0.0))),
    "space": lambda: mo.solve(CASES / "space" / "pushed_box.toml", "static"),
}


@pytest.fixture(scope="module")
def answer_and_page(tmp_path_factory):
    """Return a function that makes one of `ANSWERS` and its report in m and kN, each only once."""
    folder = tmp_path_factory.mktemp("pages")

    @functools.cache
    def made(name):
        answer = ANSWERS[name]()
        return answer, reported(folder, answer, units="m, kN")

    return made


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in ANSWERS if name != "crossing"])
def test_every_answer_says_what_was_not_checked_and_needs_no_network(answer_and_page, name):
    _, page = answer_and_page(name)
    for words in ("What was not checked", "strength is infinite", "Foundations", "Values given", "Service"):
        assert words in page.text
    # The page names compared units under "What was checked", so the list of unchecked points must not.
    assert "not compared" not in page.text
    without = name in ("none", "falls")
    by_statics = name in ("result", "capacity", "directions")
    no_proof = name in ("lowest", "space")
    assert ("equilibrium alone fixes all forces, so no other λ above zero" in page.text) == by_statics
    assert ("it is not proven that the state found is the lowest one" in page.text) == no_proof
    # Methods without their own search advise "--method coulomb -o search=10".
    assert ("search=10" in page.text) == (no_proof or name == "settlement")
    assert ("reactions that are not in the table" in page.text) == (name == "settlement")
    assert ("for λ = 1" in page.text) == (name != "settlement")
    assert ("so no state has a lower load factor" in page.text) == (name == "associative")
    assert ("The table shows each residual" in page.text) == (not without)
    # The case is the last section, so that the versions are not alone on the last sheet in print.
    assert page.text.rfind("The case as it was read") > page.text.rfind("Versions")
    assert page.sources
    assert all(source.startswith("data:") for source in page.sources)


@pytest.mark.slow
def test_numbers_are_those_of_the_result(answer_and_page):
    """The report of a block has λ, its one joint, the residuals and the sums of its loads."""
    result, page = answer_and_page("result")
    assert f"λ = {result.load_factor:.6g} (least, proven)" in page.text
    assert "λ = " not in page.raw  # the equals sign is between spaces at which no line is broken
    (joint,) = result.joints.to_dict("records")
    (row,) = [row for row in page.rows if "utilisation" in row]
    for key in ("x", "length", "n", "s", "m", "utilisation"):
        assert float(row[key]) == pytest.approx(joint[key], rel=1e-4, abs=1e-9)
    assert float(row["e"]) == pytest.approx(joint["m"] / joint["n"], rel=1e-4)
    assert row["moves"] == "hinges"
    (row,) = [row for row in page.rows if "equilibrium" in row]
    assert row["flow"].startswith(f"{numeral(result.certificate.flow, '.1e')} ≤ ")
    assert "total [0, -1] kN" in page.text
    assert "total [1, 0] kN for λ = 1" in page.text
    assert "size of the movable blocks 1 × 2 m" in page.text
    assert "μ = 0.6 (φ = 30.96°)" in page.text


@pytest.mark.slow
def test_positions_and_the_passive_pressure_of_a_crossing(answer_and_page):
    """All positions are in tables, which print completely, with their heading on each page."""
    crossed, page = answer_and_page("crossing")
    for rule in ("size: A4", "overflow: visible; max-height: none", "thead { display: table-header-group; }"):
        assert rule in page.text
    (fill,) = crossed.passages[0].passage.assembly.scene.fills
    passive = math.tan(math.radians(45 + fill.friction_angle / 2)) ** 2
    assert f"K_p = {passive:.4g}" in page.text
    fraction = f"the fraction m = {fill.mobilised:.4g} of K_p may act"
    assert f"{fraction}: m K_p = {fill.mobilised * passive:.4g}" in page.text
    positions = [float(x) for x in page.column("first axle at")]
    # A position that differs from zero by a rounding error is printed as 0.
    assert positions == pytest.approx(crossed.table["position"], rel=1e-4, abs=1e-6)
    found = [row["λ"] for row in page.rows if "first axle at" in row]
    assert found == ["–" if math.isnan(value) else f"{value:.6g}" for value in crossed.table["load_factor"]]
    assert f"governing λ = {crossed.load_factor:.6g} (associative)" in page.text
    assert "2, 2" in page.text


TOLD = {
    "settlement": ("reaction", "reaction"),
    "capacity": ("λ", "load_factor"),
    "directions": ("λ", "load_factor"),
}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "label", "column"), [(name, *entry) for name, entry in TOLD.items()])
def test_reactions_states_and_directions(answer_and_page, name, label, column):
    answer, page = answer_and_page(name)
    assert [float(of) for of in page.column(label)] == pytest.approx(answer.table[column], rel=1e-5)
    if name == "settlement":
        assert f"least reaction {answer.least.reaction:.6g}" in page.text


@pytest.mark.slow
def test_the_command_solves_load_cases_and_crosses(monkeypatch, capsys, command, tmp_path):
    monkeypatch.chdir(tmp_path)
    # On a busy machine, a part may take longer than the time after which a line tells how long it has run.
    monkeypatch.setattr("masonry_opt.reporting.terminal.SECONDS_BETWEEN_LINES", 1000.0)
    Path("bridge.toml").write_text(BRIDGE)
    asked = ("--method", "static", "--units", "m, kN")
    code, out, error = run_command(monkeypatch, capsys, "report", "bridge.toml", *asked)
    assert (code, out.splitlines()[-1]) == (0, "bridge_report.html")
    # If standard error is not a terminal, one line is printed for each part as it begins.
    assert error == "".join(f"report: {part} ...\n" for part in ("load cases", "crossing", "page"))
    page = Read(tmp_path / "bridge_report.html")
    crosses = "Axles 'wheel', load case 'traffic': governing λ = 2.66667 (associative)"
    for words in ("Load cases: λ = 6 (associative)", crosses, "1.5"):
        assert words in page.text
    assert "axles move in this load case" not in page.text
    assert "axles move in this load case" in reported(tmp_path, mo.solve_cases("bridge.toml", "static")).text
    mo.save(pressed_down(), "none.toml")
    command("report", "none.toml", "--out", "none.html", code=1)
    assert "unlimited" in Read(tmp_path / "none.html").text


def test_a_report_shows_the_positions_of_axles_as_it_solves_them(tmp_path):
    (tmp_path / "bridge.toml").write_text(BRIDGE)
    shown = []
    scene = mo.load(tmp_path / "bridge.toml")
    studies._answers(scene, lambda _: None, shown.append, {"method": "static"})
    solved = [line for line in shown if line.startswith("crossing: first axle at")]
    assert solved[0].endswith("; positions solved so far: 1")
    assert solved[-1].endswith(f"; positions solved so far: {len(solved)}")


@pytest.mark.slow
def test_a_crossing_begins_with_its_verdict_in_the_named_units(tmp_path):
    case = mo.LoadCase(name="normal", dead={"weight": 1.2}, live={"axles": 1})
    group = axles(3.0)
    found = mo.crossing(
        OVERHANG.replace(load_cases=[case]), group, method="static", incremental=False, required_factor=4.5
    )
    page = reported(tmp_path, found, units="m, kN")
    head = page.text.partition("What was checked")[0]
    assert "λ ≥ 4.5: passed, 4.8" in head
    assert "in kN: axle loads 14.4 = λ × 3" in page.text
    assert "the force unit" not in page.text
    assert "kN, with the factors of load case 'normal'" in page.text
    assert "Lengths are in m, forces in kN, moments in kN m." in head
    early = reported(tmp_path, replace(found, interrupted=True, time_limit=7.0))
    assert "Lengths, forces and moments are in the units of the case." in early.text.partition("What was")[0]
    assert "stopped by the time limit, so that λ may be less than λ = 4.8" in early.text


@pytest.mark.slow
def test_answers_of_one_kind_stand_beside_each_other(tmp_path, answer_and_page):
    """Answers of one kind are named by load case, number and support.

    Remarks on exact states are not made on an answer that is unstable.
    """
    calm, storm = {"name": "calm", "live": {"live": 1}}, {"name": "storm", "live": {"live": 2}}
    falls = {"name": "falls", "live": {"live": 1}, "dead": {"push": 1}}
    push = mo.Load(block="A", dead=(5, 0), group="push")
    scene = block_on_floor().replace(load_cases=[calm, storm, falls], loads=[push])
    results = {name: mo.solve(scene, "coulomb", load_case=name) for name in ("calm", "storm", "falls")}
    page = reported(tmp_path, [results["calm"], results["storm"]])
    names = [f"Collapse, load case '{name}': method coulomb" for name in ("calm", "storm")]
    assert [row["answer"] for row in page.rows if "equilibrium" in row] == names
    assert all(f"{name}: exact collapse state; equilibrium alone" in page.text for name in names)
    assert "dead load alone: forces" in page.text
    assert ", with the factors of load case 'calm'" in page.text
    shaken = {"name": "shaken", "earthquake": {"direction": "right", "coefficient": 0.5}}
    text = reported(tmp_path, mo.solve(scene.replace(load_cases=[shaken]), load_case="shaken")).text
    assert "with earthquake 0.5 × weights to the right" in text[text.index("live load") :]
    assert text.count("with earthquake 0.5 ×") == 1
    page = reported(tmp_path, [results["storm"], results["storm"], results["falls"]])
    names = [f"Collapse, load case 'storm' ({number}): method coulomb" for number in (1, 2)]
    assert [row["answer"] for row in page.rows if "equilibrium" in row] == names
    assert all(f"{name}: exact collapse state; equilibrium alone" in page.text for name in names)
    assert f"dead load alone ({'; '.join(names)}): forces" in page.text
    settled, alone = answer_and_page("settlement")
    one = alone.column("equilibrium")
    pushed_in = mo.settle(block_on_floor(), "floor", (1, -1))
    page = reported(tmp_path, [settled, pushed_in, answer_and_page("result")[0]])
    assert len({row["answer"] for row in page.rows if "equilibrium" in row}) == 2 * len(one) + 1


@pytest.mark.slow
def test_what_is_not_proven_of_several_answers_is_said_once(tmp_path, answer_and_page):
    lowest, _ = answer_and_page("lowest")
    page = reported(tmp_path, [lowest, lowest])
    names = [row["answer"] for row in page.rows if "equilibrium" in row]
    assert len(names) == 2
    assert f"{'; '.join(names)}: exact collapse state, from" in page.text


@pytest.mark.slow
def test_a_scale_bar_stands_in_the_plane_and_axes_in_space(answer_and_page):
    for name, bars in (("result", 1), ("space", 0)):
        sources = answer_and_page(name)[1].sources
        drawn = b64decode(sources[0].partition(",")[2]).decode()
        assert len(re.findall(r"<!-- [\d.]+ m -->", drawn)) == bars
        assert ("azimuth" in drawn) == (not bars)


def test_an_interrupted_search_writes_no_page(watched, press_ctrl_c, command, tmp_path):
    """A search catches Ctrl-C and returns the lowest state by then, but no report of it is written."""
    watched(CvxpyEngine, "solve", lambda _: press_ctrl_c(swallowed=True))
    mo.save(block_on_floor(), tmp_path / "block.toml")
    page = tmp_path / "page.html"
    asked = ("report", tmp_path / "block.toml", "--method", "static", "--out", page)
    error = command.refused(*asked, code=130)
    assert not page.exists()
    assert "interrupted: no page was written" in error


def test_what_cannot_be_reported_is_named(command, tmp_path):
    result = mo.solve(block_on_floor(), "static")
    named = mo.solve(block_on_floor().replace(title="other"), "static")
    rough = [result, mo.solve(block_on_floor(friction=0.7), "static")]
    refused = (("wall", "found str"), ([], "found none"), ([result, named], "scene, other"))
    for answer, said in (*refused, (rough, "scene, of different content")):
        with pytest.raises(OptionError, match=said):
            mo.report(answer, tmp_path / "report.html")
    for units in ("m", "m, ", 3):
        with pytest.raises(OptionError, match="units must name length and force"):
            mo.report(result, tmp_path / "report.html", units=units)
    with pytest.raises(OptionError, match=r"end in \.html"):
        mo.report(result, tmp_path / "report.pdf")
    with pytest.raises(OptionError, match="the path of a file must be text"):
        mo.report(result, 3)
    (tmp_path / "report.html").write_text("mine")
    with pytest.raises(OptionError, match="exists already"):
        mo.report(result, tmp_path / "report.html")
    case = CASES / "gilbert" / "two_blocks.toml"
    error = command.refused("report", case, "--out", tmp_path / "report.pdf")
    assert "report.pdf: the file of a report must end in .html" in error
