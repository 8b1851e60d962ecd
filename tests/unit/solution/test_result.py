"""Results report the motion of joints and blocks by common thresholds, and each state has one certificate."""

import json
import pickle
import re
from collections import Counter
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from atlas.random_scenes import random_scene
from atlas.small_scenes import rectangle
from scenes import (
    KINDS_OF_JOINTS,
    WALLS,
    block_on_floor,
    declared,
    overhanging,
    pressed_down,
    small_wall,
    two_blocks,
    values_of,
)

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.solution import answer
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.answer import FinalState, certify
from masonry_opt.solution.frames import joint_frame
from masonry_opt.solution.motion import joint_motion, moving_blocks
from masonry_opt.solution.reasons import Code
from masonry_opt.solution.thresholds import MOVES, SLIDES
from masonry_opt.studies.run_columns import mechanism


@pytest.mark.parametrize(
    ("width", "friction", "cohesion", "load_factor"),
    [*((1, mu, 0, 0.5) for mu in (0.5, 0.8, 1.0)), (4, 0.5, 0, 0.5), (4, 0.25, 0, 0.25), (4, 0.3, 0.05, 0.5)],
)
def test_utilisation_is_force_over_limit(width, friction, cohesion, load_factor):
    """A block 2 high overturns at λ = w/2, or slides at λ = μ + c L / W. The ratios of its shear and moment
    to their limits are λ / (μ + c L / W) and λ h / w."""
    scene = block_on_floor(width, 2, friction).replace(cohesion=cohesion)
    result = mo.solve(scene, "static", solver="highs")
    assert result.load_factor == pytest.approx(load_factor)
    joint = result.joints.iloc[0]
    assert abs(joint["s"]) / joint["n"] == pytest.approx(load_factor)
    assert abs(joint["m"]) / (joint["n"] * joint["length"] / 2) == pytest.approx(load_factor * 2 / width)
    assert joint["utilisation"] == pytest.approx(1.0)


def test_a_block_slides_or_turns_as_it_should():
    """Under associative flow, a wide block slides to the right and opens by μ times its slip. A narrow block
    turns. The live load does work at the rate 1."""
    result = mo.solve(block_on_floor(4, 2, 0.5), "static")
    block, joint = result.blocks.iloc[0], result.joints.iloc[0]
    assert block[["vx", "vy", "omega"]].to_numpy(float) == pytest.approx([1, 0.5, 0], abs=1e-6)
    assert joint[["slip", "opening", "rotation"]].to_numpy(float) == pytest.approx([1, 0.5, 0], abs=1e-6)
    assert joint[["n", "s"]].to_numpy(float) == pytest.approx([1, -0.5], abs=1e-6)
    block = mo.solve(block_on_floor(1, 2, 0.8), "static").blocks.iloc[0]
    # The centroid is 1 above and 0.5 left of the toe, so a rotation of -1 moves it by (1, 0.5).
    assert block[["vx", "vy", "omega"]].to_numpy(float) == pytest.approx([1, 0.5, -1], abs=1e-6)


def test_json_is_everything_a_result_says():
    """JSON contains the reasons, the solvers and the certificate of a result of the loop, but neither NaN nor
    infinity. Some joints of this result carry no force."""
    result = mo.solve(two_blocks(), "nonassociative")
    text = result.to_json()
    assert "NaN" not in text
    assert "Infinity" not in text
    answer = json.loads(text)
    assert answer["reasons"] == [reason.as_dict() for reason in result.reasons]
    assert (answer["kind"], answer["solvers"]) == ("loop", result.solvers)
    assert answer["certificate"] == result.certificate.as_dict()
    assert len(repr(result)) < 2000


def test_required_is_the_load_factor_or_an_error_that_says_why():
    assert mo.solve(two_blocks(), "static").required() == pytest.approx(0.25, rel=1e-7)
    with pytest.raises(mo.MasonryError, match=r"^scene: unlimited: .*no mechanism") as error:
        mo.solve(pressed_down(), "static").required()
    assert error.value.exit_code == 1


def test_a_corner_on_an_edge_does_not_rock():
    """The two contact points of such a joint coincide. However the normal force is divided between them, the
    moment is zero and the utilisation is the same."""
    result = mo.solve(KINDS_OF_JOINTS["corner on an edge"], "static")
    assembly, solution = result.assembly, result.solution
    corners = assembly.joints.extent == 0
    assert corners.any()
    q = solution.q.copy()
    first, second, _ = assembly.problem.by_kind(q)
    first[corners] += second[corners]
    second[corners] = 0.0
    shifted = joint_frame(assembly, replace(solution, state=replace(solution.state, q=q)))
    for column in ("n", "m", "utilisation"):
        assert shifted[column].to_numpy() == pytest.approx(result.joints[column].to_numpy(), nan_ok=True)
    assert (result.joints["m"][corners] == 0).all()


def side_by_side(*beyond):
    """Return blocks 3 wide, each on its own ledge. The arguments are the distances of their centroids beyond
    the edges."""
    blocks = []
    for number, share in enumerate(beyond):
        x, name = 10 * number, "AB"[number]
        blocks.append(rectangle(name, x, 0, x + 3, 1, weight=1, live=(1, 0)))
        blocks.append(rectangle(f"under {name}", x - 1, -1, x + 1.5 - share, 0))
    return mo.Scene(joints={"friction": 0.6}, blocks=blocks)


@pytest.mark.parametrize("little", [0.0015, 0.003, 0.006, 0.02, 0.5])
def test_words_name_the_blocks_that_the_summary_counts(little):
    """The message and the summary agree on the blocks that fall. The less the second block overhangs, the
    more slowly it falls, and very slow blocks are left out of both."""
    result = mo.solve(side_by_side(1.0, little))
    names = values_of(result, Code.FALLS)["blocks"]
    assert values_of(result, Code.NO_FRICTION_HOLDS)["blocks"] == names
    counted = re.search(r"^falls +(\d+) of 2 blocks", result.summary, re.MULTILINE)
    assert int(counted[1]) == len(names)
    speeds = result.blocks.set_index("block")[["vx", "vy"]].abs().max(axis=1)
    # Both blocks turn about the edge of their ledge, so that corners and centroids have the same ratio of
    # speeds.
    assert names == (["A", "B"] if speeds["B"] > MOVES * speeds["A"] else ["A"])


@pytest.mark.parametrize("seed", [911, 914, 917])
def test_the_joints_that_more_friction_would_hold_are_those_that_slide_in_the_picture(seed):
    """In the scenes of these seeds, some joints slip while they separate. Friction cannot hold these joints,
    and neither the message nor the picture names them."""
    result = mo.solve(random_scene("tessellation", seed), "static")
    slides = joint_motion(result.assembly, result.solution).slides
    named = result.joints.loc[slides, ["first", "second"]].to_numpy().tolist()
    slips = result.joints["slip"].abs() > SLIDES * result.blocks[["vx", "vy"]].abs().to_numpy().max()
    assert slips.sum() > len(named) > 0
    assert sorted(values_of(result, Code.FRICTION_WOULD_HOLD)["pairs"]) == sorted(named)


@pytest.mark.parametrize(("share", "moves"), [(0.5, False), (2.0, True)])
def test_a_joint_slides_and_its_block_moves_from_the_same_share_on(share, moves):
    """Two blocks slide on their ledges, one of them slowly, with velocities by hand. The slow joint counts as
    sliding exactly if its block counts as moving."""
    result = mo.solve(side_by_side(0.0, 0.0), "static")
    slow = share * MOVES
    found = FinalState(d=np.array([1.0, 0, 0, slow, 0, 0]), slope=np.zeros(2))
    solution = replace(result.solution, state=found)
    assert list(moving_blocks(result.assembly, solution.d)) == ([0, 1] if moves else [0])
    motion = joint_motion(result.assembly, solution)
    assert motion.slides.tolist() == [True, moves]
    assert mechanism(result.assembly, solution)["slides"] == 1 + moves


@pytest.mark.parametrize("method", ["coulomb", "static", "nonassociative"])
def test_a_state_has_one_certificate(method, watched):
    """A state is certified once, however often it is judged, compared and shown. On smaller scenes, several
    starts would lead to one state."""
    certified = watched(answer, "certify")
    result = mo.solve(WALLS[0], method)
    assert result.details
    assert result.to_json()
    # A state is identified by λ, forces, mechanism and flow rule.
    counts = Counter((load_factor, *map(bytes, state)) for _, load_factor, *state in certified)
    assert {*counts.values()} == {1}


def test_an_answer_cannot_be_changed():
    found = mo.solve(two_blocks()).solution.answer
    with pytest.raises(FrozenInstanceError):
        found.load_factor = 0.1


def test_an_associative_answer_is_judged_under_both_flow_rules():
    """An associative answer is not exact under Coulomb friction: the joint opens by μ as it slides, so its
    normal force does work."""
    result = mo.solve(block_on_floor(4, 2, 0.5), "static")
    found, problem = result.solution.answer, result.assembly.problem
    assert not found.failing(Kind.ASSOCIATIVE)
    assert found.certified_by(problem, problem.friction) is found
    left = found.certified_by(problem, problem.dilatancy).failing(Kind.EXACT)
    assert left == {"complementarity": pytest.approx(1.0)}
    assert not result.exact


@pytest.mark.parametrize("scene", [two_blocks(), pressed_down(), overhanging()])
def test_a_result_can_be_sent_to_another_process(scene):
    result = mo.solve(scene)
    sent = pickle.loads(pickle.dumps(result))
    assert sent.to_json() == result.to_json()
    assert sent.details == result.details


@pytest.fixture(scope="module")
def solved():
    problem = assemble(small_wall()).problem
    state = declared(problem, "static", "pyomo").solve().state
    return problem, state


def certificate(problem, state, **changed):
    values = {"load_factor": state.load_factor, "q": state.q, "d": state.d, "slope": problem.friction}
    return certify(problem, **(values | changed))


def test_an_exact_answer_has_none_and_a_wrong_load_factor_breaks_equilibrium(solved):
    problem, state = solved
    assert certificate(problem, state).worst < 1e-10
    wrong = certificate(problem, state, load_factor=state.load_factor * 1.01)
    largest = np.abs(problem.live).max() * 0.01 * state.load_factor
    total = np.abs(problem.dead).sum()
    assert wrong.equilibrium == pytest.approx(largest / total, rel=1e-6)


def test_forces_beyond_yield_and_motions_that_do_not_go_with_them_are_left(solved):
    problem, state = solved
    sheared, pulled, pressed = (state.q.copy() for _ in range(3))
    joint = problem.sliding[0]
    problem.shears(sheared)[0, joint] = problem.friction[0] * problem.normal_forces(sheared)[joint] + 0.25
    assert certificate(problem, state, q=sheared).yield_ == pytest.approx(0.25)
    pulled.reshape(3, -1)[:, 0] = [-0.5, 0.0, 0.0]
    assert certificate(problem, state, q=pulled).yield_ >= 0.5
    pressed[: problem.joints] += 1.0  # no face that moves is at yield
    assert certificate(problem, state, q=pressed).complementarity > 0.1
    d = state.d.copy()
    d[1] -= np.abs(d).max()  # the first block of the bottom course sinks into the base
    assert certificate(problem, state, d=d).flow > 0.4
