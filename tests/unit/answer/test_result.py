"""What a result says of joints and blocks, in the units of the case."""

import json
from dataclasses import replace

import pytest
from scenes import KINDS_OF_JOINTS, block_on_floor, pressed_down, two_blocks

import masonry_opt as mo
from masonry_opt.answer.frames import joint_frame


@pytest.mark.parametrize(
    ("width", "friction", "cohesion", "load_factor"),
    [
        (1, 0.5, 0, 0.5),
        (1, 0.8, 0, 0.5),
        (1, 1.0, 0, 0.5),
        (4, 0.5, 0, 0.5),
        (4, 0.25, 0, 0.25),
        (4, 0.3, 0.05, 0.5),
    ],
)
def test_utilisation_is_force_over_limit(width, friction, cohesion, load_factor):
    """A block 2 high overturns at λ = w/2, or slides at λ = μ + c L / W: it uses λ / (μ + c L / W) of its
    friction and λ h / w of its rocking."""
    scene = block_on_floor(width, 2, friction)
    joints = mo.JointDefaults(friction=friction, cohesion=cohesion)
    scene = scene.model_copy(update={"joints": joints})
    result = mo.solve(scene, "static", solver="highs")
    assert result.load_factor == pytest.approx(load_factor)
    joint = result.joints.iloc[0]
    assert abs(joint["s"]) / joint["n"] == pytest.approx(load_factor)
    assert abs(joint["m"]) / (joint["n"] * joint["length"] / 2) == pytest.approx(load_factor * 2 / width)
    assert joint["utilisation"] == pytest.approx(1.0)


def test_sliding_block_moves_as_it_should():
    """Associative: it slides to the right and opens by μ per unit slip; live load moves at rate 1."""
    result = mo.solve(block_on_floor(4, 2, 0.5), "static")
    block, joint = result.blocks.iloc[0], result.joints.iloc[0]
    assert block[["vx", "vy", "omega"]].to_numpy(float) == pytest.approx([1, 0.5, 0], abs=1e-6)
    assert joint[["slip", "opening", "rotation"]].to_numpy(float) == pytest.approx([1, 0.5, 0], abs=1e-6)
    assert joint[["n", "s"]].to_numpy(float) == pytest.approx([1, -0.5], abs=1e-6)


def test_overturning_block_turns_about_its_toe():
    result = mo.solve(block_on_floor(1, 2, 0.8), "static")
    block = result.blocks.iloc[0]
    # The centroid stands 1 above and 0.5 left of the toe: turning by -1 moves it (1, 0.5).
    assert block[["vx", "vy", "omega"]].to_numpy(float) == pytest.approx([1, 0.5, -1], abs=1e-6)


@pytest.mark.parametrize(("method", "kind"), [("nonassociative", "loop"), ("mcp", "exact")])
def test_json_is_everything_a_result_says(method, kind):
    result = mo.solve(two_blocks(), method)
    text = result.to_json()
    assert "NaN" not in text
    assert "Infinity" not in text
    answer = json.loads(text)
    assert answer["reasons"] == [reason.as_dict() for reason in result.reasons]
    assert len(answer["history"]) == len(result.history)
    assert answer["kind"] == kind
    assert answer["solvers"] == result.solvers
    assert answer["certificate"] == result.certificate.as_dict()
    assert (answer["blocks"], answer["joints"]) == (2, 3)
    assert len(answer["joint_results"]) == 3
    assert len(answer["block_results"]) == 2
    assert len(repr(result)) < 2000


def test_required_is_the_load_factor_or_an_error_that_says_why():
    assert mo.solve(two_blocks(), "static").required() == pytest.approx(0.25, rel=1e-7)
    with pytest.raises(mo.MasonryError, match=r"^scene: unlimited: .*no mechanism") as error:
        mo.solve(pressed_down(), "static").required()
    assert error.value.exit_code == 1


def test_a_corner_on_an_edge_does_not_rock():
    """Its two points are one: however they share n, the joint carries no moment and is used as much."""
    result = mo.solve(KINDS_OF_JOINTS["corner on an edge"], "static")
    assembly, solution = result.assembly, result.solution
    corners = assembly.joints.extent == 0
    assert corners.any()
    q = solution.q.copy()
    first, second, _ = assembly.problem.by_kind(q)
    first[corners] += second[corners]
    second[corners] = 0.0
    shifted = joint_frame(assembly, replace(solution, found=replace(solution.found, q=q)))
    for column in ("n", "m", "utilisation"):
        assert shifted[column].to_numpy() == pytest.approx(result.joints[column].to_numpy(), nan_ok=True)
    assert (result.joints["m"][corners] == 0).all()
