"""The tolerance that a message advises both closes gaps and aligns joints, so that no second advice follows.

Each drawing is the two blocks of the README with an error at one corner. The load factors of the exact
drawing are 0.15 (lowest) and 0.25 (associative) by hand, and 0.188 (incremental) by explicit dynamics of its
contacts.
"""

import math
import re
from collections.abc import Callable

import ezdxf
import pytest
from atlas.random_scenes import random_scene
from atlas.random_scenes_in_space import random_scene_in_space
from drawing_errors import with_errors
from mappings import mapped, turned
from meshes import obj, prism
from scenes import solved
from speeds import slow_after

import masonry_opt as mo
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.geometry import TOLERANCE_OVER_ERROR

Outlines = dict[str, list[list[float]]]

#: Block and corner with the error: corners of A and B on their common bed, on the bed of A and on the support
#: of B.
CORNERS = [("A", 0), ("A", 1), ("A", 2), ("A", 3), ("B", 0), ("B", 1)]


def outlines(block: str, corner: int, error: float) -> Outlines:
    """Return the corners of the two blocks and their supports. One corner is too high by an error."""
    drawn: Outlines = {
        "A": [[2, 0], [5, 0], [5, 1], [2, 1]],
        "B": [[0, 1], [3, 1], [3, 2], [0, 2]],
        "floor": [[2, -1], [9, -1], [9, 0], [2, 0]],
        "rough": [[0, 0], [1, 0], [1, 1], [0, 1]],
    }
    drawn[block][corner][1] += error
    return drawn


def scene_of(drawn: Outlines, tolerance: float | None) -> mo.Scene:
    loads = {"A": {"weight": 1, "live": (1, 0)}, "B": {"weight": 1}}
    blocks = [
        mo.Block(
            name=name, vertices=list(map(tuple, corners)), fixed=name not in loads, **loads.get(name, {})
        )
        for name, corners in drawn.items()
    ]
    held = mo.Joint(between=("B", "rough"), friction=math.inf)
    return mo.Scene(joints={"friction": 0.1}, blocks=blocks, exceptions=[held], tolerance=tolerance)


def advice(sentences: tuple[str, ...]) -> set[float]:
    """Return the tolerances that sentences advise."""
    return {float(value) for said in sentences for value in re.findall(r"'tolerance' to ([\d.e+-]*\d)", said)}


def as_advised(
    drawing: Callable[[float | None], mo.Scene], method: str = "coulomb"
) -> tuple[mo.Result, float]:
    """Return the result after the advice of the first message is followed, and the advised tolerance."""
    try:
        said = mo.solve(drawing(None), method).warning_sentences
    except mo.CaseError as error:
        said = (str(error),)
    advised = advice(said)
    assert len(advised) == 1, f"one tolerance is advised in: {said}"
    (tolerance,) = advised
    result = mo.solve(drawing(tolerance), method)
    assert advice(result.warning_sentences) == set()
    return result, tolerance


def three(result: mo.Result) -> list[float | None]:
    return [result.load_factor, result.incremental, result.associative]


#: Each corner is once too high and once too low, by errors of two sizes.
OFF = [
    (corner, error)
    for number, corner in enumerate(CORNERS)
    for error in ((1e-3, -1e-4) if number % 2 else (1e-4, -1e-3))
]


@pytest.mark.parametrize(("corner", "error"), slow_after(4, OFF))
def test_advice_for_a_corner_too_high_or_too_low(corner: tuple[str, int], error: float) -> None:
    result, tolerance = as_advised(lambda tolerance: scene_of(outlines(*corner, error), tolerance))
    assert three(result) == pytest.approx([0.15, 0.188, 0.25], rel=3e-3)
    assert tolerance == pytest.approx(TOLERANCE_OVER_ERROR * abs(error), rel=0.05)


@pytest.mark.parametrize("error", [1e-4, -1e-4])
def test_advice_along_a_slanted_bed(error: float) -> None:
    """The scene is rotated by 17°, together with gravity."""

    def drawing(tolerance: float | None) -> mo.Scene:
        slanted = mapped(scene_of(outlines("A", 2, error), tolerance), turned(0.3), turned(0.3))
        return slanted.replace(tolerance=tolerance)

    result, _ = as_advised(drawing)
    assert three(result) == pytest.approx([0.15, 0.188, 0.25], rel=3e-3)


@pytest.mark.parametrize(
    ("method", "error"),
    [
        pytest.param("coulomb", 1e-3, marks=pytest.mark.slow),
        pytest.param("coulomb", -1e-4, marks=pytest.mark.slow),
        ("static", 1e-4),
        ("static", -1e-3),
    ],
)
def test_advice_in_space(error: float, method: str) -> None:
    """In space, the lowest load factor of the exact drawing is lower than in the plane, because blocks can
    rotate about any axis."""
    exact = solved(mo.extrude(scene_of(outlines("A", 2, 0.0), None)), method, incremental=True).load_factor
    assert exact == pytest.approx({"coulomb": 0.149, "static": 0.25}[method], rel=1e-3)
    result, _ = as_advised(lambda tolerance: mo.extrude(scene_of(outlines("A", 2, error), tolerance)), method)
    assert result.load_factor == pytest.approx(exact, rel=3e-3)


@pytest.mark.parametrize(
    "corner", [*CORNERS[:2], *(pytest.param(corner, marks=pytest.mark.slow) for corner in CORNERS[2:])]
)
def test_advice_in_space_for_each_corner_in_millimetres(corner: tuple[str, int]) -> None:
    """The error of 0.1 mm is not a binary fraction: a tolerance as large as the error would lose the joint of
    A and B."""

    def drawing(tolerance: float | None) -> mo.Scene:
        drawn = outlines(*corner, 1e-4)
        in_mm = {name: [[1000 * x, 1000 * y] for x, y in corners] for name, corners in drawn.items()}
        return mo.extrude(scene_of(in_mm, tolerance), 1000)

    result, _ = as_advised(drawing, "static")
    assert result.load_factor == pytest.approx(0.25, rel=3e-3)


def completed(read: mo.Scene, up: int) -> mo.Scene:
    """Return a scene read from a drawing, with the loads and the joint that a drawing does not contain.

    ``up`` is the vertical axis. Each block is identified by its position.
    """
    middle = assemble(read, floating=True).geometry
    at = middle.centroid + middle.origin
    high = at[:, up] > 1.2
    blocks = []
    for block, place, is_high in zip(read.blocks, at, high, strict=True):
        pushed = {} if block.fixed or is_high else {"live": (1, 0) if up == 1 else (1, 0, 0)}
        blocks.append(block if block.fixed else block.replace(weight=1, unit_weight=None, **pushed))
        if block.fixed and place[0] < 1:
            rough = block.name
    above = next(block.name for block, is_high in zip(blocks, high, strict=True) if is_high)
    held = mo.Joint(between=(above, rough), friction=math.inf)
    return read.replace(blocks=blocks, exceptions=[held])


@pytest.mark.parametrize("error", [1e-3, 1e-4, -1e-4])
def test_advice_for_drawings(error: float, tmp_path) -> None:
    document = ezdxf.new()
    for name, corners in outlines("A", 2, error).items():
        layer = "supports" if name in ("floor", "rough") else "stones"
        document.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})
    document.saveas(tmp_path / "blocks.dxf")

    def drawing(tolerance: float | None) -> mo.Scene:
        read = mo.read_dxf(tmp_path / "blocks.dxf", friction=0.1, unit_weight=1, tolerance=tolerance)
        return completed(read, 1)

    result, _ = as_advised(drawing)
    assert three(result) == pytest.approx([0.15, 0.188, 0.25], rel=3e-3)


@pytest.mark.slow
@pytest.mark.parametrize("error", [1.2345678e-3, -1.2345678e-4])
def test_advice_for_meshes(error: float, tmp_path) -> None:
    """The coordinates have nine digits, so the reader cannot infer their accuracy from the digits."""
    blocks = {name: prism(corners, 1.0) for name, corners in outlines("A", 2, error).items()}
    (tmp_path / "blocks.obj").write_bytes(obj(blocks))

    def drawing(tolerance: float | None) -> mo.Scene:
        fixed = ["floor", "rough"]
        more = {"friction": 0.1, "unit_weight": 1, "fixed": fixed, "tolerance": tolerance}
        return completed(mo.read_mesh(tmp_path / "blocks.obj", **more), 2)

    result, _ = as_advised(drawing)
    assert result.load_factor == pytest.approx(0.1489, rel=3e-3)


@pytest.mark.slow
@pytest.mark.parametrize("error", [1e-4, 1e-3])
@pytest.mark.parametrize("seed", [7_310_002, 7_310_005])
def test_advice_for_walls_whose_corners_are_all_off(seed: int, error: float) -> None:
    """With the advised tolerance, the load factor is that of the exact wall, up to ten times the error."""
    scene = random_scene("wall", seed)
    noisy = with_errors(scene, error, 1)
    result, tolerance = as_advised(lambda tolerance: noisy.replace(tolerance=tolerance))
    assert noisy.tolerance < tolerance < 3 * noisy.tolerance
    assert result.load_factor == pytest.approx(mo.solve(scene).load_factor, rel=10 * error)


def test_advice_in_space_where_all_corners_are_off() -> None:
    """The first message is about faces that are not flat, and its tolerance also joins the blocks."""
    scene = random_scene_in_space("boxes", 7_310_003)
    noisy = with_errors(scene, 1e-4, 1)
    result, _ = as_advised(lambda tolerance: noisy.replace(tolerance=tolerance), "static")
    assert result.load_factor == pytest.approx(mo.solve(scene, "static").load_factor, rel=1e-3)


def test_faces_bent_by_a_tenth_are_no_matter_of_tolerance() -> None:
    corners, faces = prism(outlines("A", 2, 0.0)["A"], 1.0)
    corners[0, 2] -= 0.5
    vertices, faces = list(map(tuple, corners.tolist())), [[*face] for face in faces]
    solid = mo.Solid(name="A", weight=1, vertices=vertices, faces=faces)
    support = mo.Solid(name="B", fixed=True, vertices=vertices, faces=faces)
    with pytest.raises(mo.CaseError, match="is not flat") as error:
        assemble(mo.Scene(joints={"friction": 0.1}, blocks=[solid, support]))
    assert "tolerance'" not in str(error.value)


def test_a_joint_across_a_small_gap_is_refused_with_the_tolerance_that_closes_it() -> None:
    scene = scene_of(outlines("B", 0, 1e-3), None)
    with pytest.raises(mo.CaseError, match=r"do not touch.*up to 0\.001 wide: set 'tolerance'"):
        assemble(scene)
