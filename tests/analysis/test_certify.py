"""``certify`` on states from users, compared with calculations by hand and with answers of the package.

A block of width 1, height 2 and weight 1 is pushed to the right at its centroid by λ times its weight. The
force unit is 1, and the length unit is half of its joint, 0.5. The state in which the block overturns about
its right corner is known by hand: λ = 1/2, all of the weight in the right corner, friction 1/2 to the left.
"""

from math import cos, radians, sin

import numpy as np
import pytest
from analysis.test_no_work import scene as lifted
from analysis.test_no_work import stone
from scenes import CASES, block_on_floor, small_wall, solved
from scenes_in_space import corner_wall, pushed_box
from unit.solution.test_recomputation import tied_boxes, wall_under_fill

import masonry_opt as mo

#: Rounding of sums of a few numbers of size one.
ROUNDING = 1e-14

#: Joint forces of the overturning block: n1 at its left corner, n2 at its right corner, s to the right.
Q = [0.0, 1.0, -0.5]

#: Velocities of a clockwise rotation at rate 1 about the right corner: v = ω × r with r = (-1/2, 1) from the
#: corner to the centroid, and ω times the length unit.
D = [1.0, 0.5, -0.5]


def failing(check: mo.StateCheck) -> dict[str, str]:
    """Return the place of each residual that exceeds its limit."""
    table = check.table[~check.table["passed"]]
    return dict(zip(table["residual"], table["largest_at"], strict=True))


def value(check: mo.StateCheck, residual: str) -> float:
    return float(check.table.set_index("residual")["value"][residual])


def test_a_state_by_hand_is_exact():
    check = mo.certify(block_on_floor(), 0.5, Q, D)
    assert check.exact
    assert check.certificate.worst <= ROUNDING
    assert check.load_factor == 0.5
    assert str(check).startswith("λ = 0.5: this is an exact collapse state")
    # Only the ratios of the velocities have a meaning.
    assert mo.certify(block_on_floor(), 0.5, Q, [7 * v for v in D]).exact


def test_rows_columns_and_conditions_are_named():
    check = mo.certify(block_on_floor(), 0.5, Q, D)
    tables = check.rows, check.columns, check.conditions
    rows, columns, conditions = (frame.set_index("name") for frame in tables)
    assert rows.loc["fx[A]", ["joints", "live", "dead", "unbalanced"]].tolist() == [-0.5, 0.5, 0.0, 0.0]
    assert rows.loc["fy[A]", ["joints", "live", "dead", "unbalanced"]].tolist() == [1.0, 0.0, -1.0, 0.0]
    assert dict(zip(rows["of_velocity"], rows["velocity"], strict=True)) == {
        "vx[A]": 1.0,
        "vy[A]": 0.5,
        "omega[A]": -0.5,
    }
    assert columns["force"].to_dict() == {"n1[A|floor]": 0.0, "n2[A|floor]": 1.0, "s[A|floor]": -0.5}
    # The left corner opens by ω times the width, which is 1. The joint does not slip.
    assert columns.set_index("of_motion")["motion"].to_dict() == pytest.approx(
        {"opening_1[A|floor]": 1.0, "opening_2[A|floor]": 0.0, "slip[A|floor]": 0.0}, abs=ROUNDING
    )
    # The slack of sliding is 0.6 - 0.5 to the right and 0.6 + 0.5 to the left. The slack of rocking is 2 n.
    slacks = conditions["slack"].to_dict()
    slides = [slacks.pop(f"slide_{sense}[A|floor]") for sense in ("plus", "minus")]
    assert sorted(slides) == pytest.approx([0.1, 1.1])
    assert slacks == {"rock_1[A|floor]": 0.0, "rock_2[A|floor]": 2.0}
    assert conditions["rate"]["rock_1[A|floor]"] == pytest.approx(0.5)


def test_equilibrium_that_is_missed():
    """A load factor of 0.6 leaves an unbalanced force of 0.1, relative to a dead load of 1.

    At vx = 1 the work of this force is 0.1, relative to λ times the work of the live load, 1.
    """
    check = mo.certify(block_on_floor(), 0.6, Q, D)
    assert failing(check) == {"equilibrium": "fx[A]", "work": "fx[A]", "block": "A"}
    assert [value(check, name) for name in ("equilibrium", "work", "block")] == pytest.approx(
        [0.1, 0.1 / 0.6, 0.1]
    )
    assert "NOT an exact collapse state, because residuals are too large: equilibrium 1.0e-01" in str(check)


@pytest.mark.parametrize("size", [1.0, 1e6, 1e9])
def test_residuals_do_not_depend_on_the_size_of_the_live_load(size):
    """An error of λ of 1 % has the same residuals if the live load is multiplied, and λ divided, by a number.

    The unbalanced force is 0.005, relative to the weight 1, and to 1.01 times the live force 0.5.
    """
    scene = block_on_floor(1.0, 2.0, live=(size, 0.0))
    assert mo.certify(scene, 0.5 / size, Q, D).exact
    check = mo.certify(scene, 0.505 / size, Q, D)
    assert failing(check) == {"equilibrium": "fx[A]", "work": "fx[A]", "block": "A"}
    values = [value(check, name) for name in ("equilibrium", "work", "block")]
    assert values == pytest.approx([0.005, 0.005 / 0.505, 0.005])
    assert check.load_factor_error == pytest.approx(0.005 / size)


def test_a_slightly_wrong_load_factor_is_not_exact():
    """On wall 5, an error of λ of 4.6e-7 hides in the total weight, but not in the work of the mechanism."""
    wall = mo.load(CASES / "ferris_tinloi" / "wall_5.toml")
    result = solved(wall)
    right = mo.certify(wall, result.load_factor, result.q, result.d)
    wrong = mo.certify(wall, result.load_factor - 4.6e-7, result.q, result.d)
    assert right.exact
    assert right.load_factor_error < 1e-12
    assert set(failing(wrong)) == {"work"}
    assert 4.6e-7 * (1 - 1e-6) <= wrong.load_factor_error < 1e-6


def test_yield_that_is_missed():
    """At μ = 0.4, a friction force of 0.5 exceeds its limit by 0.1."""
    check = mo.certify(block_on_floor(friction=0.4), 0.5, Q, D)
    assert set(failing(check)) == {"yield", "joint"}
    assert all(place.startswith("slide_") for place in failing(check).values())
    assert value(check, "yield") == pytest.approx(0.1)


def test_a_flow_rule_that_is_missed():
    """If the centroid moves down instead of up by 0.5, the right corner enters the floor by 1."""
    check = mo.certify(block_on_floor(), 0.5, Q, [1.0, -0.5, -0.5])
    assert failing(check)["flow"] == "opening_2[A|floor]"
    assert value(check, "flow") == pytest.approx(1.0)


def test_complementarity_that_is_missed():
    """At λ = 0.4, the left corner has n = 0.5 - 0.4 = 0.1, by moments about the right corner.

    The left corner opens by 1. The work of n is 0.1, relative to λ times the work of the live load, 1.
    """
    check = mo.certify(block_on_floor(), 0.4, [0.1, 0.9, -0.4], D)
    assert failing(check) == {"complementarity": "A|floor"}
    assert check.certificate.complementarity == pytest.approx(0.1)
    assert value(check, "complementarity") == pytest.approx(0.25)


def test_a_motion_that_the_loads_do_not_drive():
    """A block at rest, or sliding to the left under a push to the right, fails: the loads do no work."""
    for d in ([0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]):
        check = mo.certify(block_on_floor(), 0.5, Q, d)
        assert not check.exact
        assert failing(check)["work"] == "d: the loads do no positive work"


def test_a_motion_backwards_enters_the_floor():
    """If the block turns counter-clockwise about its right corner at speed 1, its left corner sinks by 1."""
    check = mo.certify(block_on_floor(), 0.5, Q, [-v for v in D])
    assert failing(check)["flow"] == "opening_1[A|floor]"
    assert value(check, "flow") == pytest.approx(1.0)


def test_associative_flow():
    """A block of height 1/2 slides at λ = μ = 0.6; with associative flow it rises by 0.6 times its slip.

    The push acts at height 1/4, so that n = 1/2 ± 0.6/4.
    """
    scene = block_on_floor(height=0.5)
    q = [0.5 - 0.15, 0.5 + 0.15, -0.6]
    assert mo.certify(scene, 0.6, q, [1.0, 0.0, 0.0]).exact
    assert mo.certify(scene, 0.6, q, [1.0, 0.6, 0.0], associative=True).exact
    assert "flow" in failing(mo.certify(scene, 0.6, q, [1.0, 0.0, 0.0], associative=True))
    assert "flow" not in failing(mo.certify(scene, 0.6, q, [1.0, 0.6, 0.0]))


def pushed_box_by_hand(size, friction, angle):
    """Return the state by hand of a box that slides at an angle, at λ = μ.

    The push at half the height moves the resultant by μ h/2 (cos θ, sin θ) from the middle. Corner forces
    that are linear in x and y have this resultant. The friction of each corner is μ n against the slip, with
    s along y and t along -x.
    """
    a, b, h = size
    scene = pushed_box(size, friction, angle)
    points = mo.assemble(scene).joints.point
    x, y = (points - points.mean(axis=0))[:, :2].T
    direction = cos(radians(angle)), sin(radians(angle))
    off = [friction * h / 2 * part for part in direction]
    n = 0.25 + off[0] * x / a**2 + off[1] * y / b**2
    q = np.concatenate([n, -friction * n * direction[1], friction * n * direction[0]])
    return scene, q, [*direction, 0.0, 0.0, 0.0, 0.0], n


def test_a_state_by_hand_in_space():
    size, friction, angle = (1.0, 2.0, 3.0), 0.2, 52.0
    scene, q, d, n = pushed_box_by_hand(size, friction, angle)
    assert mo.certify(scene, friction, q, d).exact
    # The polygon of 24 sides lies inside the cone: the side nearest to 52° faces 52.5°.
    check = mo.certify(scene, friction, q, d, friction="polygon")
    short = friction * n.max() * (cos(radians(0.5)) - cos(radians(7.5)))
    assert value(check, "yield") == pytest.approx(short)
    assert "yield" in failing(check)


def test_each_residual_in_space():
    """A box that slides at 52° in space, with one condition violated at a time, fails that condition."""
    size, friction, angle = (1.0, 2.0, 3.0), 0.2, 52.0
    scene, q, d, _ = pushed_box_by_hand(size, friction, angle)
    larger = mo.certify(scene, 0.21, q, d)
    assert failing(larger) == {"equilibrium": "fy[A]", "work": "fy[A]", "block": "A"}
    assert value(larger, "equilibrium") == pytest.approx(0.01 * sin(radians(angle)))
    smoother = mo.certify(scene.replace(friction=0.19), friction, q, d)
    assert set(failing(smoother)) >= {"yield", "joint"}
    sinking = mo.certify(scene, friction, q, [*d[:2], -0.1, 0.0, 0.0, 0.0])
    assert set(failing(sinking)) == {"flow"}
    assert value(sinking, "flow") == pytest.approx(0.1 / max(d))
    # Rising by 0.1 opens all corners, whose forces sum to 1.
    rising = mo.certify(scene, friction, q, [*d[:2], 0.1, 0.0, 0.0, 0.0])
    assert failing(rising)["complementarity"].startswith("A|floor")
    assert rising.certificate.complementarity == pytest.approx(0.1)
    # If the slip is at a right angle to the friction, friction does not resist the motion.
    aside = mo.certify(scene, friction, q, [d[0] - d[1], d[1] + d[0], 0.0, 0.0, 0.0, 0.0])
    assert set(failing(aside)) == {"complementarity"}


def strong_column() -> mo.Scene:
    """Return a block whose joint crushes before the block can turn about its corner."""
    return block_on_floor().replace(strength=8.0)


#: Scenes of each kind, with a method and the options by which its answer is certified.
ANSWERS = {
    "wall": (small_wall, "coulomb", {}),
    "wall, static": (small_wall, "static", {"associative": True}),
    "fill, tie and prop": (wall_under_fill, "coulomb", {}),
    "strength": (strong_column, "coulomb", {}),
    "boxes and rod": (tied_boxes, "coulomb", {}),
    "corner in space": (lambda: corner_wall(1, 1, 2), "coulomb", {}),
    "two blocks": (lambda: mo.load(CASES / "gilbert" / "two_blocks.toml"), "coulomb", {}),
    "dilatant": (lambda: small_wall(dilatancy=0.2), "coulomb", {}),
}


@pytest.fixture(scope="module", params=ANSWERS.values(), ids=ANSWERS)
def answer(request):
    """Return a scene, its result, and the options of ``certify``."""
    make, method, options = request.param
    scene = make()
    return scene, mo.solve(scene, method, incremental=False), options


@pytest.mark.slow
def test_answers_of_the_package_have_their_own_certificates(answer):
    scene, result, options = answer
    for of in (scene, result.assembly):
        check = mo.certify(of, result.load_factor, result.q, result.d, **options)
        assert check.certificate == result.certificate
    assert check.exact == result.solution.answer.exact


@pytest.mark.slow
def test_answers_that_are_perturbed_are_not_exact(answer):
    """A change of λ, q or d by a thousandth of its size violates the conditions that contain it.

    A change of λ or d violates no other condition.
    """
    scene, result, options = answer
    load_factor, q, d = result.load_factor, result.q, result.d
    rng = np.random.default_rng(5)
    noise_q = 1e-3 * np.abs(q).max() * rng.standard_normal(len(q))
    noise_d = 1e-3 * np.abs(d).max() * rng.standard_normal(len(d))
    statics = {"equilibrium", "work", "block"}
    larger = failing(mo.certify(scene, load_factor * 1.001, q, d, **options))
    assert "equilibrium" in larger
    assert set(larger) <= statics
    shaken = failing(mo.certify(scene, load_factor, q + noise_q, d, **options))
    assert {"equilibrium", "block"} & set(shaken)
    moved = failing(mo.certify(scene, load_factor, q, d + noise_d, **options))
    assert set(moved) & {"flow", "complementarity"}
    assert set(moved) <= {"flow", "complementarity", "work"}


def test_a_state_in_which_the_live_load_does_no_work():
    """A block of weight 10 is pushed by 2 at μ = 0.5 and lifted by λ; it slides at n = 10 - λ = 2/0.5."""
    scene = lifted(stone(push=2.0, live=(0.0, 1.0)))
    result = mo.solve(scene)
    assert result.load_factor == pytest.approx(6.0)
    check = mo.certify(scene, result.load_factor, result.q, result.d)
    assert check.exact
    assert not mo.certify(scene, 6.01, result.q, result.d).exact
    assert not mo.certify(scene, 6.0, result.q, -result.d).exact


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((True, Q, D), "load_factor must be a finite number (found True)"),
        (("0.5", Q, D), "load_factor must be a finite number (found '0.5')"),
        ((float("nan"), Q, D), "load_factor must be a finite number (found nan)"),
        ((0.5, None, D), "joint forces, one for each column of problem.B, shape (3,) (found None)"),
        ((0.5, 1.0, D), "shape (3,) (found the number 1.0)"),
        ((0.5, Q[:2], D), "shape (3,) (found an array of shape (2,))"),
        ((0.5, [[0.0], [1.0, 2.0]], D), "q must be"),
        ((0.5, ["a", "b", "c"], D), "q must be"),
        ((0.5, [0.0, np.nan, -0.5], D), "q must contain only finite numbers, but entry no. 1 (n2[A|floor])"),
        ((0.5, Q, [1.0, 0.5, np.inf]), "d must contain only finite numbers, but entry no. 2 (omega[A]) is"),
        ((0.5, Q, [1.0, 0.5]), "d must be an array of velocities, one for each row of problem.B, shape (3,)"),
    ],
)
def test_arguments_of_another_form_are_refused_by_name(arguments, words):
    with pytest.raises(mo.OptionError) as error:
        mo.certify(block_on_floor(), *arguments)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_laws_and_load_cases_of_another_name_are_refused():
    with pytest.raises(mo.OptionError, match="friction must be 'cone' or 'polygon' \\(found 'cones'\\)"):
        mo.certify(block_on_floor(), 0.5, Q, D, friction="cones")
    with pytest.raises(mo.OptionError, match="crushing must be 'chords' or 'parabola'"):
        mo.certify(block_on_floor(), 0.5, Q, D, crushing=None)
    with pytest.raises(mo.CaseError, match="live load"):
        mo.certify(block_on_floor(live=(0.0, 0.0)), 0.5, Q, D)
    with pytest.raises(mo.CaseError, match="a scene must be a Scene"):
        mo.certify(7, 0.5, Q, D)


def test_slopes_and_motions_of_a_problem():
    """A single slope applies to every joint, and D is the transpose of C."""
    problem = mo.assemble(small_wall()).problem
    joints = len(problem.sliding)
    every = np.full(joints, 0.3)
    for one in (0.3, np.float64(0.3), [0.3] * joints):
        assert (problem.C(one) != problem.C(every)).nnz == 0
        assert (problem.D(one) != problem.C(every).T).nnz == 0
    d = np.arange(float(3 * problem.blocks))
    np.testing.assert_array_equal(problem.rates(d, 0.3), problem.rates(list(d), every))
    assert problem.C(1).dtype == float
    words = f"slope must be a number, or one number.* {joints} joints"
    for wrong in (every[:-1], every[None], "rough", None, True, [0.3, "rough"]):
        for function in (problem.C, problem.D, lambda slope: problem.rates(d, slope)):
            with pytest.raises(mo.OptionError, match=words):
                function(wrong)
    for infinite in (np.nan, [np.inf] * joints):
        with pytest.raises(mo.OptionError, match="slope must contain only finite numbers"):
            problem.C(infinite)
    with pytest.raises(mo.OptionError, match="d must be an array of velocities of all movable blocks"):
        problem.rates(d[:-1], 0.3)


def test_a_state_by_the_crushing_parabola():
    """Method static with Clarabel uses the parabola, which permits larger moments than chords inside it."""
    scene = block_on_floor().replace(strength=7.3)
    result = mo.solve(scene, "static")
    assert result.crushing == "parabola"
    by_chords = mo.certify(scene, result.load_factor, result.q, result.d, associative=True)
    assert not by_chords.exact
    assert "if your program uses the parabola, pass crushing='parabola'" in str(by_chords)
    by_parabola = mo.certify(
        scene, result.load_factor, result.q, result.d, associative=True, crushing="parabola"
    )
    assert by_parabola.exact
    assert "crushing=" not in str(by_parabola)


@pytest.mark.parametrize("factor", [0.5, 1.5])
def test_forces_outside_the_crushing_parabola_get_no_advice_on_it(factor):
    """The moment at the joint is scaled, while the normal force stays equal to the weight.

    At 1.5 times the moment of collapse, the forces are outside the parabola. At half of it, they are inside
    the chords.
    """
    scene = block_on_floor().replace(strength=7.3)
    result = mo.solve(scene, "static")
    n1, n2, s = result.q
    moment = factor * (n2 - n1) / 2
    q = [(n1 + n2) / 2 - moment, (n1 + n2) / 2 + moment, s]
    check = mo.certify(scene, result.load_factor, q, result.d, associative=True)
    assert not check.exact
    assert "crushing=" not in str(check)


def test_forces_of_another_shape_have_no_slacks():
    problem = mo.assemble(block_on_floor()).problem
    with pytest.raises(mo.OptionError, match=r"q must be an array of joint forces, shape \(3,\)"):
        problem.slacks(np.zeros(2))
