"""Advice to look for lower states: only the default method has the option that the advice names."""

import re

import pytest
from unit.test_house import ROOT

import masonry_opt as mo
from masonry_opt.methods.registry import METHODS, HowToSolve

#: A bridge whose associative collapse state is exact under Coulomb friction, as its joints only hinge.
BRIDGE = ROOT / "cases" / "page" / "shinafoot.toml"

#: A wall whose lowest state is not proven to be the least.
WALL = ROOT / "cases" / "ferris_tinloi" / "wall_1.toml"


@pytest.mark.parametrize("method", ["static", "kinematic", "coulomb"])
def test_the_command_that_the_advice_names_is_one_that_the_package_accepts(method):
    text = mo.solve(WALL if method == "coulomb" else BRIDGE, method, incremental=False).summary
    advice = re.search(r"(?:--method (\w+) )?(?:-o|option) search=10", text)
    assert advice is not None
    advised = advice.group(1) or method
    assert HowToSolve(advised, options={"search": 10.0}).own_options.search == 10.0
    assert METHODS[advised].seeks_lowest
