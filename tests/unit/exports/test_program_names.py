"""Names of rows and columns: each its own, legal where it stands, and readable."""

from __future__ import annotations

import re

import highspy
import pytest
from scenes import KINDS_OF_JOINTS

import masonry_opt as mo
from masonry_opt.exports.program_files import legal, names_in, readable, unique
from masonry_opt.models.pyomo_mcp import PyomoMcp, with_pairs
from masonry_opt.problem.assembly import assemble

ODD_NAMES = ["a b", "a-b", "a_b", "a_b~2", "größe [m]", "e1", "x" * 199 + "1", "x" * 199 + "2", "n|a"]


def row_of_stones(names=ODD_NAMES):
    """Stones side by side on a ground, each named oddly."""
    stones = [
        mo.Block(name=name, vertices=[(i, 0), (i + 1, 0), (i + 1, 1), (i, 1)], weight=1, live=(1, 0))
        for i, name in enumerate(names)
    ]
    ground = mo.Block(name="ground", vertices=[(-5, -1), (20, -1), (20, 0), (-5, 0)], fixed=True)
    return mo.Scene(joints=mo.JointDefaults(friction=0.5), blocks=[*stones, ground])


def test_what_comes_again_is_numbered_past_what_is_taken():
    assert unique(["a", "b", "a", "a~2", "a"]) == ["a", "b", "a~3", "a~2", "a~4"]


@pytest.mark.parametrize("scene", [*KINDS_OF_JOINTS.values(), row_of_stones()])
def test_every_row_and_column_has_a_name_of_its_own(scene):
    assembly = assemble(scene)
    problem, mcp = assembly.problem, PyomoMcp(assembly.problem)
    with_pairs(mcp)
    legal_names = {legal: r"[a-z][\w{}|.~]{0,249}", readable: None}
    for labels, pattern in legal_names.items():
        names = list(names_in(mcp.program, problem, labels(assembly)).values())
        assert len(names) == 2 * (1 + 3 * problem.joints + 3 * problem.blocks + 2 * problem.faces)
        assert len(set(names)) == len(names)
        assert not pattern or all(re.fullmatch(pattern, name, re.ASCII) for name in names)


@pytest.mark.parametrize("end", [".lp", ".mps"])
def test_highs_reads_every_name(tmp_path, end):
    """As many columns as forces and λ, under the names of the blocks, with what is not legal left out."""
    scene = row_of_stones()
    (path,) = mo.export(scene, tmp_path / f"stones{end}", "static")
    highs = highspy.Highs()
    highs.silent()
    assert highs.readModel(str(path)) == highspy.HighsStatus.kOk
    names = highs.getLp().col_names_
    joints = 2 * len(ODD_NAMES) - 1
    assert len(set(names)) == len(names) == 3 * joints + 1
    assert {"n1{a_b|ground}", "n1{a_b|ground~2}", "n2{a_b|ground~3}", "n2{gr__e__m_|ground}"} <= set(names)


def test_names_in_nl_files_are_the_blocks_own(tmp_path):
    path, *_ = mo.export(row_of_stones(), tmp_path / "stones.nl", "static")
    columns = path.with_suffix(".col").read_text(encoding="utf-8").splitlines()
    assert {"n1[a b|ground]", "n1[a-b|ground]", "n2[größe [m]|ground]", "n2[n|a|ground]"} <= set(columns)
