"""What scenes in space do not have is refused by name, and what works for them is not."""

import highspy
import pytest
from scenes_in_space import box_on_floor, corner_wall

import masonry_opt as mo

SCENE = box_on_floor((2, 2, 1), 0.5)


@pytest.fixture(scope="module")
def result():
    return mo.solve(SCENE, "static")


def test_solids_are_not_drawn_as_dxf(tmp_path):
    with pytest.raises(mo.OptionError, match="solids"):
        mo.write_dxf(SCENE, tmp_path / "a.dxf")


def test_global_search_is_of_the_plane(tmp_path):
    with pytest.raises(mo.OptionError, match="'global'"):
        mo.solve(SCENE, "global")
    with pytest.raises(mo.OptionError, match="'global'"):
        mo.export(SCENE, tmp_path / "a.lp", "global")


@pytest.mark.parametrize("ending", ["lp", "mps"])
@pytest.mark.parametrize("method", ["static", "kinematic"])
def test_programs_are_exported_by_polygons(method, ending, tmp_path):
    """Read again and solved by HiGHS, the objective is λ over Σ|f_L|, or the work."""
    scene = corner_wall(1, 1, 2)
    (path,) = mo.export(scene, tmp_path / f"a.{ending}", method)
    said = path.read_text().splitlines()[:6]
    # cos(π/24) = 0.9914.
    assert [line for line in said if "friction: " in line and " 24 sides" in line and "0.86 %" in line]
    solver = highspy.Highs()
    solver.setOptionValue("output_flag", False)
    solver.readModel(str(path))
    solver.run()
    known = mo.solve(scene, method, solver="highs")
    work = abs(solver.getInfo().objective_function_value)
    assert work == pytest.approx(known.load_factor * known.assembly.problem.live_norm, rel=1e-8)
    # 7 joints of four points: n, s and t of each, and λ; or velocities of four blocks and rates of the faces.
    columns = {"static": 3 * 28 + 1, "kinematic": 6 * 4 + 25 * 28}
    assert solver.getNumCol() == columns[method]
