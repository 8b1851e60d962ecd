"""The command `least`, as a user runs it."""

import json
import re

import pytest
from scenes import run_command


def test_friction_that_carries_a_load(case, monkeypatch, capsys):
    asked = ("--vary", "joints.friction=0.1:1", "--load", "0.3", "--method", "static", "--samples", "1")
    code, out, _ = run_command(monkeypatch, capsys, "least", case, *asked, "--json")
    assert code == 0
    assert json.loads(out)["value"] == pytest.approx(0.3, rel=1e-6)
    found = json.loads(out)
    code, out, _ = run_command(monkeypatch, capsys, "least", case, *asked)
    # What is printed of the ends differs, from the load asked too, and is what was found.
    printed = {
        end: [float(number) for number in re.findall(rf"^{end} +at (\S+): load factor (\S+)", out, re.M)[0]]
        for end in ("holds", "fails")
    }
    assert printed["fails"][1] < 0.3
    assert printed["fails"][1] < printed["holds"][1]
    for end, (value, number) in printed.items():
        assert value == pytest.approx(found[end]["value"], rel=1e-8)
        assert number == pytest.approx(found[end]["number"], rel=1e-6)
    code, out, _ = run_command(monkeypatch, capsys, "least", case, *asked, "-o", "beta=1")
    assert code == 2


def test_greatest_push_that_a_block_stands(case, monkeypatch, capsys):
    """A dead force in the middle of a block 1 wide and 2 high overturns it at half its weight."""
    asked = ("--vary", "block.A.dead.x=0:1", "--most", "--samples", "1", "--tolerance", "1e-4")
    code, out, _ = run_command(monkeypatch, capsys, "least", case, *asked, "--json")
    assert code == 0
    found = json.loads(out)
    assert found["kind"] == "greatest"
    assert found["value"] == pytest.approx(0.5, rel=1e-6)
    code, out, _ = run_command(monkeypatch, capsys, "least", case, *asked)
    assert "block.A.dead.x" in out.splitlines()[0]


@pytest.mark.parametrize(
    "vary", ["joints.friction", "joints.friction=1", "joints.friction=a:b", "joints.frictoin=0:1"]
)
def test_what_is_wrong_is_said(case, vary, monkeypatch, capsys):
    code, out, err = run_command(monkeypatch, capsys, "least", case, "--vary", vary)
    assert (code, out) == (2, "")
    assert "joints.friction" in err
