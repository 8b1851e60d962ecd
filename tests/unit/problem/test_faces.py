"""Yield conditions and flow rule, against each joint written out by hand, and normality between them."""

import numpy as np
import pytest
from scenes import KINDS_OF_JOINTS, block_on_floor, irregular

from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.faces import CHORDS

PROBLEMS = {name: assemble(scene).problem for name, scene in KINDS_OF_JOINTS.items()} | {
    "irregular": assemble(irregular()).problem
}


@pytest.fixture(params=PROBLEMS)
def problem(request):
    return PROBLEMS[request.param]


def slacks_by_hand(problem, q, slope, cohesion, whole):
    """|s| ≤ c + slope n and |m| ≤ n L / 2 over L / 2, or what chords leave of it where ``whole`` crushes,
    joint by joint."""
    first, second, s = q.reshape(3, -1)
    n, m = first + second, second - first  # m over L / 2
    plus, minus, start, end = [], [], [], []
    for joint in range(problem.joints):
        if joint in problem.sliding:
            at = list(problem.sliding).index(joint)
            limit = cohesion[at] + slope[at] * n[joint]
            plus.append(limit - s[joint])
            minus.append(limit + s[joint])
        start.append(n[joint] - m[joint])
        end.append(n[joint] + m[joint])
    crushing = []
    for sense in (-1, 1):
        for joint, force in zip(problem.crushing, whole, strict=True):
            for lean, constant in zip(*CHORDS, strict=True):
                crushing.append(lean * n[joint] + constant * force + sense * m[joint])
    return np.array([*plus, *minus, *start, *end, *crushing])


def motion_by_hand(problem, p, slope):
    """Opening of each joint at its start and end, and its slip: sliding opens by the slope, each rate of
    rocking about the other end."""
    k, c = len(problem.sliding), problem.joints
    plus, minus, start, end, crushing = np.split(p, [k, 2 * k, 2 * k + c, 2 * k + 2 * c])
    opening, turning, slip = start + end, start - end, np.zeros(c)
    of_chords = crushing.reshape(2, len(problem.crushing), len(CHORDS.slope))
    for at, joint in enumerate(problem.crushing):
        opening[joint] += (of_chords[:, at] @ CHORDS.slope).sum()
        turning[joint] += of_chords[0, at].sum() - of_chords[1, at].sum()
    for at, joint in enumerate(problem.sliding):
        slip[joint] = minus[at] - plus[at]
        opening[joint] += slope[at] * (plus[at] + minus[at])
    return np.concatenate([opening + turning, opening - turning, slip])


def test_yield_conditions_are_those_of_each_joint(problem):
    rng = np.random.default_rng(0)
    q = rng.normal(size=3 * problem.joints)
    expected = slacks_by_hand(problem, q, problem.friction, problem.cohesion, problem.crushing_force)
    assert problem.slacks(q).shape == (problem.faces,)
    np.testing.assert_allclose(problem.slacks(q), expected, atol=1e-13)
    slope = rng.normal(size=len(problem.sliding))
    without = slacks_by_hand(problem, q, slope, np.zeros_like(slope), np.zeros(len(problem.crushing)))
    np.testing.assert_allclose(problem.C(slope) @ q, without, atol=1e-13)


def test_the_flow_rule_is_that_of_each_joint(problem):
    rng = np.random.default_rng(1)
    p, slope = rng.uniform(size=problem.faces), rng.normal(size=len(problem.sliding))
    np.testing.assert_allclose(problem.D(slope) @ p, motion_by_hand(problem, p, slope), atol=1e-13)
    np.testing.assert_allclose(
        problem.D(problem.dilatancy) @ p, motion_by_hand(problem, p, problem.dilatancy)
    )


def test_normality(problem):
    """Flow that opens joints by the friction is normal to the yield surface; any other is not."""
    D, C = problem.D(problem.friction).toarray(), problem.C(problem.friction).toarray()
    np.testing.assert_array_equal(D, C.T)
    steeper = problem.D(problem.friction + 0.1).toarray()
    assert np.count_nonzero(steeper != C.T) == 2 * 2 * len(problem.sliding)


@pytest.mark.parametrize("sense", [0, 1])
def test_rates_give_back_what_moved(sense):
    """A block slides in one sense and rocks about both edges, as any opening lets it."""
    problem = assemble(block_on_floor()).problem
    p = np.array([0.0, 0.0, 0.25, 0.5])
    p[sense] = 0.75
    slope = np.array([0.2])
    d = np.linalg.solve(problem.B.T.toarray(), problem.D(slope) @ p)
    np.testing.assert_allclose(problem.rates(d, slope), p, atol=1e-12)


def test_rates_of_blocks_that_pass_into_each_other_are_never_negative():
    problem = assemble(irregular()).problem
    rng = np.random.default_rng(3)
    for _ in range(20):
        d = rng.normal(size=3 * problem.blocks)
        p, u = problem.rates(d, problem.friction), problem.B.T @ d
        assert p.min() >= 0
        # Slip is kept whole; only what points open may fall short.
        departure = u - problem.D(problem.friction) @ p
        np.testing.assert_allclose(departure[2 * problem.joints + problem.sliding], 0, atol=1e-12)
        assert departure.max() < 1e-12
