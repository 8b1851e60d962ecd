"""Problems with joints of every kind, and random numbers in place of a state of each."""

import numpy as np
import pytest
from scenes import KINDS_OF_JOINTS

from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.problem import Problem, State

PROBLEMS = {name: assemble(scene).problem for name, scene in KINDS_OF_JOINTS.items()}


@pytest.fixture(params=PROBLEMS)
def problem(request) -> Problem:
    return PROBLEMS[request.param]


@pytest.fixture
def numbers(problem) -> State:
    rng = np.random.default_rng(4)
    shapes = (3 * problem.joints, 3 * problem.blocks)
    return State(0.7, *(rng.normal(size=size) for size in shapes), rng.uniform(size=problem.faces))
