"""Advice to search for lower states names a method that has the option `search`."""

import re

import numpy as np
import pandas as pd
import pytest
from many.tables import sampled
from sources import ROOT

import masonry_opt as mo
from masonry_opt.methods.registry import METHODS, HowToSolve
from masonry_opt.studies.many.run_warnings import warnings_of_falls

#: A bridge whose joints only hinge at collapse, so that its associative collapse state is exact under Coulomb
#: friction.
BRIDGE = ROOT / "cases" / "page" / "shinafoot.toml"

#: A wall whose lowest state is not proven to be the least.
WALL = ROOT / "cases" / "ferris_tinloi" / "wall_1.toml"


def names_accepted_search(text, method):
    """Assert that a text advises a search, and that the method in the text has the option for this search."""
    advice = re.search(r"(?:--method (\w+) )?(?:-o|option) search=10", text)
    assert advice is not None
    advised = advice.group(1) or method
    assert HowToSolve(advised, options={"search": 10.0}).own_options.search == 10.0
    assert METHODS[advised].seeks_lowest


@pytest.mark.parametrize("method", ["static", "kinematic", "coulomb"])
def test_the_command_that_the_advice_names_is_one_that_the_package_accepts(method):
    result = mo.solve(WALL if method == "coulomb" else BRIDGE, method, incremental=False)
    names_accepted_search(result.summary, method)


#: Methods whose sweeps and samples advise a search.
SEEKING = [name for name, method in METHODS.items() if method.seeks_lowest]


@pytest.mark.parametrize("method", SEEKING)
def test_sweeps_and_samples_advise_a_search_that_the_package_accepts(method):
    """If the load factor falls while friction grows, a warning advises a search for lower states. The methods
    "mpec" and "global" have no search, so their warnings name another method."""
    friction = np.linspace(0.3, 0.6, 20)
    rows = {"joints.friction": friction, "load_factor": 2 - friction, "status": "converged"}
    swept = pd.DataFrame(rows)
    (record,) = warnings_of_falls(swept, ["joints.friction"], method)
    names_accepted_search(record["sentence"], method)
    sample = sampled(2 - friction, pd.DataFrame({"joints.friction": friction}))
    sample.table.attrs["method"] = method
    (sentence,) = sample.warning_sentences
    names_accepted_search(sentence, method)
