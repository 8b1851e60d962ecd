"""Other programs read exported files and find the load factors of the methods, under names that can be
traced."""

import re

import highspy
import numpy as np
import pytest
from nl_files import read_nl
from pysat.formula import CNF
from pysat.solvers import Minisat22
from scenes import (
    CASES,
    KINDS_OF_JOINTS,
    UNCRUSHED,
    irregular,
    overhanging,
    pressed_down,
    run_command,
    small_wall,
    solved,
    two_blocks,
)
from scenes_in_space import box_on_floor, corner_wall
from speeds import slow

import masonry_opt as mo
from masonry_opt.errors import NoLoadFactorError
from masonry_opt.exports.programs import EPSILON, names_in
from masonry_opt.models.pyomo_mcp import PyomoMcp, with_pairs
from masonry_opt.problem.assembly import assemble
from masonry_opt.problem.names import unique

FORMATS = {
    "static": (".lp", ".mps", ".nl"),
    "kinematic": (".lp", ".mps", ".nl"),
    "global": (".lp", ".mps", ".nl"),
    "mpec": (".nl",),
    "mcp": (".nl",),
}
NO_LIVE_LOAD = two_blocks().replace(blocks={"A": {"live": (0.0, 0.0)}})


def solved_by_highs(path):
    """Return HiGHS after it has read a file and solved its program."""
    highs = highspy.Highs()
    highs.silent()
    highs.setOptionValue("mip_rel_gap", 1e-9)
    assert highs.readModel(str(path)) == highspy.HighsStatus.kOk
    highs.run()
    assert highs.getModelStatus() == highspy.HighsModelStatus.kOptimal
    return highs


def times(text):
    """Return the number by which the objective is divided to obtain λ, as the header of the file states
    it."""
    return float(re.search(r"the objective is .* times ([\d.e+-]+); this number is the sum", text)[1])


@pytest.mark.parametrize(
    "name",
    [*(name for name in KINDS_OF_JOINTS if name != "no cohesion"), *slow("no cohesion")],
)
def test_highs_finds_the_associative_load_factor(tmp_path, name):
    """The reference is the static program of CVXPY, solved by the simplex method. Both programs have the same
    chords of the crushing law."""
    scene = KINDS_OF_JOINTS[name]
    expected = pytest.approx(mo.solve(scene, "static", model="cvxpy", solver="highs").required(), rel=1e-6)
    for end in (".lp", ".mps"):
        (path,) = mo.export(scene, tmp_path / f"static{end}", "static")
        highs = solved_by_highs(path)
        _, column = highs.getColByName("load_factor")
        assert highs.getSolution().col_value[column] == expected
        assert -highs.getInfo().objective_function_value / times(path.read_text()) == expected

        (path,) = mo.export(scene, tmp_path / f"kinematic{end}", "kinematic")
        highs = solved_by_highs(path)
        _, row = highs.getRowByName("c_e_live_work_")
        assert highs.getSolution().row_dual[row] == expected
        assert highs.getInfo().objective_function_value / times(path.read_text()) == expected


@pytest.mark.parametrize("end", [".lp", ".mps"])
def test_highs_finds_the_least_load_factor_of_two_blocks_by_binaries(tmp_path, end):
    (path,) = mo.export(two_blocks(), tmp_path / f"two{end}", "global")
    highs = solved_by_highs(path)
    # By hand, λ is 1.5 μ, or 2.5 μ if sliding dilates. Two joints can slide, and three can rock.
    assert highs.getInfo().objective_function_value / times(path.read_text()) == pytest.approx(0.15, abs=1e-7)
    lp = highs.getLp()
    binary = [name for name, kind in zip(lp.col_names_, lp.integrality_, strict=True) if int(kind)]
    assert len(binary) == 2 * 2 + 2 * 3
    assert all(name.startswith("y_") for name in binary)
    most = lp.col_upper_[lp.col_names_.index("load_factor")]
    assert most == pytest.approx(0.25, rel=1e-3)
    assert most > 0.25


@pytest.mark.parametrize(
    "name", ["one joint cannot slide", pytest.param("corner on an edge", marks=pytest.mark.slow)]
)
def test_ipopt_finds_the_load_factor_of_mpec(tmp_path, name):
    """IPOPT starts from the point in the file. Products of ε reduce λ by what they dissipate: about ε
    Σ|f_L|⁻¹ each."""
    scene = KINDS_OF_JOINTS[name]
    path, *_ = mo.export(scene, tmp_path / "program.nl", "mpec")
    found = solved_by_ipopt(path) / times(path.read_text())
    result = mo.solve(scene, "mpec")
    lower = EPSILON * result.assembly.problem.faces / times(path.read_text())
    assert result.required() - lower <= found <= result.required() + 1e-7


def solved_by_ipopt(path):
    """Return the least objective by the IPOPT of CasADi, which reads the file itself."""
    casadi = pytest.importorskip("casadi")
    read = casadi.NlpBuilder()
    read.import_nl(str(path))
    program = {"x": casadi.vertcat(*read.x), "f": read.f, "g": casadi.vertcat(*read.g)}
    quiet = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False, "expand": True}
    solver = casadi.nlpsol("program", "ipopt", program, quiet)
    found = solver(x0=read.x_init, lbx=read.x_lb, ubx=read.x_ub, lbg=read.g_lb, ubg=read.g_ub)
    assert solver.stats()["success"]
    return float(found["f"])


def by_name(result, friction, cohesion=0.0, dilatancy=0.0):
    """Return the values of rows and columns by their names in an ``.nl`` file, computed from the tables of a
    result."""
    problem = result.assembly.problem
    force, length = problem.force_unit, problem.length_unit
    values, times_seen = {"load_factor": result.load_factor}, {}
    for joint in result.joints.itertuples():
        pair = f"{joint.first}|{joint.second}"
        times_seen[pair] = times_seen.get(pair, 0) + 1
        at = f"[{pair}~{times_seen[pair]}]" if times_seen[pair] > 1 else f"[{pair}]"
        # A corner on an edge has no length, so its moment is zero and its two points coincide.
        half = joint.length / 2
        n, s, m = joint.n / force, joint.s / force, joint.m / half / force if half else 0.0
        values |= {f"n1{at}": (n - m) / 2, f"n2{at}": (n + m) / 2, f"s{at}": s}
        opening, turning = joint.opening - dilatancy * abs(joint.slip), joint.rotation * half
        values |= {f"z_rock_1{at}": n - m, f"z_rock_2{at}": n + m}
        values |= {f"p_rock_1{at}": (opening - turning) / 2, f"p_rock_2{at}": (opening + turning) / 2}
        limit = cohesion * joint.length / force + friction * n
        values |= {f"z_slide_plus{at}": limit - s, f"z_slide_minus{at}": limit + s}
        values |= {f"p_slide_plus{at}": max(-joint.slip, 0.0), f"p_slide_minus{at}": max(joint.slip, 0.0)}
    for block in result.blocks.itertuples():
        at = f"[{block.block}]"
        values |= {f"vx{at}": block.vx, f"vy{at}": block.vy, f"omega{at}": block.omega * length}
    return values


def two_feet():
    """Return a pushed block on two feet. It has two joints with the ground, and units far from 1."""
    bridge = [(0, 0), (200, 0), (200, 100), (300, 100), (300, 0), (500, 0), (500, 300), (0, 300)]
    return mo.Scene(
        joints=mo.JointDefaults(friction=0.4, cohesion=0.5),
        blocks=[
            mo.Block(name="A", vertices=bridge, weight=2000, live=(1000, 0), live_at=(250, 50)),
            mo.Block(name="B", vertices=[(0, 300), (500, 300), (500, 400), (0, 400)], weight=1000),
            mo.Block(name="ground", vertices=[(-100, -50), (900, -50), (900, 0), (-100, 0)], fixed=True),
        ],
    )


ANSWERED = {**UNCRUSHED, "two feet": two_feet(), "irregular": irregular()}


@pytest.mark.parametrize("name", ANSWERED)
def test_mcp_s_equations_and_pairs_hold_at_our_answer(tmp_path, name):
    scene = ANSWERED[name]
    path, *_ = mo.export(scene, tmp_path / "program.nl", "mcp")
    file, result = read_nl(path), solved(scene)
    joints = scene.joints
    known = by_name(result, joints.friction, joints.cohesion, joints.dilatancy)
    x = np.array([known[column] for column in file.columns])
    scale = max(1.0, np.abs(x).max())

    rows = file.matrix @ x
    equations = np.array(list(file.equal))
    assert np.abs(rows[equations] - np.array(list(file.equal.values()))).max() <= 1e-9 * scale
    paired = np.array([column for column, _ in file.pairs.values()])
    bodies = rows[list(file.pairs)]
    assert min(bodies.min(), x[paired].min()) >= -1e-9 * scale
    assert np.abs(bodies * x[paired]).max() <= 1e-9 * scale
    # The mechanism moves, and some face is not at yield.
    assert x[paired].max() > 1e-2
    assert bodies.max() > 1e-2

    # Without the live load, the forces are not in equilibrium. Every column has a coefficient.
    at_rest = np.array([0.0 if column == "load_factor" else known[column] for column in file.columns])
    left = (file.matrix @ at_rest)[equations] - np.array(list(file.equal.values()))
    assert np.abs(left).max() > 1e-2
    assert np.abs(file.matrix).sum(axis=0).min() > 0

    # The problem is square, as solvers of complementarity problems require: z and p of each face, q, d and λ.
    # The header has no objective, and as many linear pairs as faces. Each slack is paired with its own rate.
    problem = result.assembly.problem
    assert file.matrix.shape == (2 * problem.faces + 3 * problem.joints + 3 * problem.blocks + 1,) * 2
    assert (file.counts[0][2], file.counts[1][2], len(file.pairs)) == (0, problem.faces, problem.faces)
    for row, (column, bounded) in file.pairs.items():
        ((slack,),) = np.nonzero(file.matrix[row])
        face = file.rows[row].removeprefix("pair_")
        assert (file.columns[slack], file.columns[column]) == (f"z_{face}", f"p_{face}")
        assert (bounded, file.lower[column], file.upper[column]) == (1, 0.0, np.inf)
        assert np.isinf([file.lower[slack], file.upper[slack]]).all()


@pytest.mark.parametrize(("method", "end"), [(one, end) for one in FORMATS for end in FORMATS["static"]])
def test_a_format_carries_a_program_or_is_refused_with_those_that_do(tmp_path, method, end):
    path = tmp_path / f"two{end}"
    if end in FORMATS[method]:
        assert mo.export(two_blocks(), path, method)[0] == path
        assert path.is_file()
        return
    with pytest.raises(mo.OptionError) as refused:
        mo.export(two_blocks(), path, method)
    assert all(other in str(refused.value) for other in FORMATS[method])
    assert list(tmp_path.iterdir()) == []


def test_a_program_is_not_written_without_its_names(tmp_path):
    (tmp_path / "two.col").mkdir()
    with pytest.raises(mo.OptionError, match=r"two\.col: cannot be written, because a folder has this name"):
        mo.export(two_blocks(), tmp_path / "two.nl", "mcp")
    assert not (tmp_path / "two.nl").exists()


FALLS_WITH_STRESS = small_wall(courses=2, length=1, dilatancy=0.2, dilatancy_stress=(0.1, 0.2))


@pytest.mark.parametrize(
    ("scene", "method", "error"),
    [
        (FALLS_WITH_STRESS, "mcp", mo.OptionError),
        (FALLS_WITH_STRESS, "mpec", mo.OptionError),
        (KINDS_OF_JOINTS["strength"], "global", mo.OptionError),
        (NO_LIVE_LOAD, "static", mo.CaseError),
        (NO_LIVE_LOAD, "mcp", mo.CaseError),
        ("missing.toml", "static", mo.CaseError),
        (overhanging(), "global", NoLoadFactorError),
        (pressed_down(), "global", NoLoadFactorError),
        (box_on_floor(), "global", mo.OptionError),
    ],
)
def test_scenes_that_a_method_does_not_know_are_refused(tmp_path, scene, method, error):
    with pytest.raises(error):
        mo.export(scene, tmp_path / "program.nl", method)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("end", [".lp", ".mps"])
@pytest.mark.parametrize(("method", "columns"), [("static", 3 * 28 + 1), ("kinematic", 6 * 4 + 25 * 28)])
def test_programs_in_space_are_exported_by_polygons(tmp_path, method, columns, end):
    """The wall has 7 joints of four points. The static program has n, s and t of each point, and λ. The
    kinematic program has the velocities of four blocks and the rates of all faces."""
    scene = corner_wall(1, 1, 2)
    (path,) = mo.export(scene, tmp_path / f"wall{end}", method)
    head = path.read_text().splitlines()[:6]
    # The polygon has at least cos(π/24) = 0.9914 times the friction of the cone.
    assert [line for line in head if "friction: " in line and " 24 sides" in line and "0.86 %" in line]
    highs, known = solved_by_highs(path), mo.solve(scene, method, solver="highs")
    work = abs(highs.getInfo().objective_function_value)
    assert work == pytest.approx(known.load_factor * known.assembly.problem.live_norm, rel=1e-8)
    assert highs.getNumCol() == columns


def test_the_command_prints_the_files_written(monkeypatch, capsys, tmp_path):
    case = CASES / "gilbert" / "two_blocks.toml"
    code, out, _ = run_command(monkeypatch, capsys, "export", case, tmp_path / "two.nl", "--method", "mcp")
    assert (code, out.split()) == (0, [str(tmp_path / f"two{end}") for end in (".nl", ".col", ".row")])
    code, out, err = run_command(monkeypatch, capsys, "export", case, tmp_path / "two.lp", "--method", "mcp")
    assert (code, out) == (2, "")
    assert err.startswith("error: ")


def test_units_and_titles_stand_in_the_header_whatever_the_title(tmp_path):
    titled = two_feet().replace(title='Brücke \\* a "b"; $ontext\n*\\ End')
    for end in (".lp", ".mps"):
        (path,) = mo.export(titled, tmp_path / f"program{end}", "static")
        head = path.read_text().split("Source")[0]
        # The median weight of a block is 1500. Feet are 200 wide, and blocks are 500 wide.
        assert "movable blocks: 2, joints: 3" in head
        assert "one unit of force is 1500.0 and one unit of length is 100.0, in the units of the case" in head
        assert "Br?cke" in head
        found = abs(solved_by_highs(path).getInfo().objective_function_value) / times(head)
        assert found == pytest.approx(mo.solve(two_feet(), "static").required(), rel=1e-6)


ODD_NAMES = ["a b", "a-b", "a_b", "a_b~2", "größe [m]", "e1", "x" * 199 + "1", "x" * 199 + "2", "n|a"]


def row_of_stones(names=ODD_NAMES):
    """Return stones side by side on a ground, with unusual names."""
    stones = [
        mo.Block(name=name, vertices=[(i, 0), (i + 1, 0), (i + 1, 1), (i, 1)], weight=1, live=(1, 0))
        for i, name in enumerate(names)
    ]
    ground = mo.Block(name="ground", vertices=[(-5, -1), (20, -1), (20, 0), (-5, 0)], fixed=True)
    return mo.Scene(joints={"friction": 0.5}, blocks=[*stones, ground])


def test_what_comes_again_is_numbered_past_what_is_taken():
    assert unique(["a", "b", "a", "a~2", "a"]) == ["a", "b", "a~3", "a~2", "a~4"]


@pytest.mark.parametrize("scene", [*KINDS_OF_JOINTS.values(), row_of_stones()])
def test_every_row_and_column_has_a_name_of_its_own(scene):
    assembly = assemble(scene)
    problem, mcp = assembly.problem, PyomoMcp(assembly.problem)
    with_pairs(mcp)
    for legal, pattern in ((True, r"[a-z][\w{}|.~]{0,249}"), (False, None)):
        names = list(names_in(mcp.program, assembly, legal).values())
        assert len(names) == 2 * (1 + 3 * problem.joints + 3 * problem.blocks + 2 * problem.faces)
        assert len(set(names)) == len(names)
        assert not pattern or all(re.fullmatch(pattern, name, re.ASCII) for name in names)


@pytest.mark.parametrize("end", [".lp", ".mps"])
def test_highs_reads_every_name(tmp_path, end):
    """There is one column for each force and for λ. Its name contains the names of the blocks, without
    illegal characters."""
    scene = row_of_stones()
    (path,) = mo.export(scene, tmp_path / f"stones{end}", "static")
    names = solved_by_highs(path).getLp().col_names_
    joints = 2 * len(ODD_NAMES) - 1
    assert len(set(names)) == len(names) == 3 * joints + 1
    assert {"n1{a_b|ground}", "n1{a_b|ground~2}", "n2{a_b|ground~3}", "n2{gr__e__m_|ground}"} <= set(names)


def test_a_sat_solver_refutes_the_clauses_of_a_proof(tmp_path):
    """The two blocks have three joints, of which two can slide: 2 × 2 + 2 × 3 yield conditions."""
    (path,) = mo.export(two_blocks(), tmp_path / "two.cnf")
    formula = CNF(from_file=str(path))
    assert formula.nv == 10
    named = re.findall(r"^c variable \d+: (.+)$", "\n".join(formula.comments), re.MULTILINE)
    assert len(set(named)) == formula.nv
    assert named[:2] == ["slide_plus{A|B}", "slide_plus{A|floor}"]
    with Minisat22(bootstrap_with=formula.clauses) as solver:
        assert solver.solve() is False


def test_the_clauses_of_a_result_are_those_of_its_proof(tmp_path):
    result = solved(two_blocks())
    assert result.proof is not None
    (path,) = mo.export(result, tmp_path / "two.cnf")
    assert path.read_text().endswith(result.proof.to_dimacs())


@pytest.mark.slow
def test_clauses_without_a_proof_are_refused(tmp_path):
    with pytest.raises(mo.OptionError, match="no proof was found: proofs exist only for scenes in the plane"):
        mo.export(corner_wall(2, 2, 2), tmp_path / "corner.cnf")
    with pytest.raises(mo.OptionError, match="'method' cannot be used for the clauses"):
        mo.export(two_blocks(), tmp_path / "two.cnf", "static")
    assert not list(tmp_path.iterdir())
