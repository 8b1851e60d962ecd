"""Warn about stresses of joints and about lengths whose units seem not to match the units of the weights.

The package takes any consistent units. Its warnings rest on two comparisons:

- A strength or cohesion is compared with a stress due to weight. The units probably do not match if the ratio
  is far outside of the range that occurs in masonry.
- A unit weight may look like a weight per cubic metre. The lengths are then probably not in metres if the
  scene is far larger than masonry.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.loads import weights
from masonry_opt.scene.scene import Scene
from masonry_opt.scene.typical_sizes import LARGEST_SCENE
from masonry_opt.solution.reasons import Code, Reason, reason
from masonry_opt.solution.typical_units import typical_unit


class _Range(NamedTuple):
    """Usual range of a strength or cohesion, as a multiple of the stress at the foot of a column of blocks.

    The column is as high as the scene's largest dimension, and has the median unit weight of the blocks. A
    wider range detects fewer strengths and cohesions in a wrong unit.
    """

    least: float
    greatest: float


#: Usual range of a strength, as a multiple of the stress at the foot of a column of blocks. The column is as
#: high as the scene's largest dimension. Rubble with a strength of 1 MPa in a scene of 50 m has the multiple
#: 1. Stone with a strength of 50 MPa in a scene of 0.5 m has the multiple 5000. A strength outside the range
#: causes a warning.
_STRENGTH = _Range(0.3, 1e4)
#: Usual range of a cohesion, as a multiple of the stress at the foot of a column of blocks. The column is as
#: high as the scene's largest dimension. A cohesion of 20 kPa in a wall of 120 m has the multiple 0.008. A
#: cohesion of 1 MPa in a model of 0.1 m has the multiple 450. A cohesion outside the range causes a warning.
_COHESION = _Range(0.003, 600.0)


def unit_weights(assembly: Assembly) -> np.ndarray:
    """Return the weight of each movable block divided by its area or volume, shape (b,)."""
    scene, movable = assembly.scene, assembly.movable
    size = assembly.geometry.size[movable] * scene.thickness
    return weights(scene, assembly.geometry, movable) / size


def is_per_area(scene: Scene) -> bool:
    """Return True if unit weights are weights per area: the scene is in the plane, without a thickness."""
    has_thickness = "thickness" in scene.model_fields_set or scene.thickness != 1
    return scene.dimension == 2 and not has_thickness


def lower_median(values: np.ndarray) -> float:
    """Return the median of values; if their number is even, the lower of the two middle values."""
    return float(np.quantile(values, 0.5, method="lower"))


def median_unit_weight(assembly: Assembly) -> float:
    """Return the median unit weight of all movable blocks that have a weight, or 0 if no block has one."""
    density = unit_weights(assembly)
    return lower_median(density[density > 0]) if density.any() else 0.0


def unusual_stresses(assembly: Assembly) -> Iterator[Reason]:
    """Generate warnings about strengths and cohesions that do not seem to fit the units of the weights."""
    # Use the largest dimension instead of the height: the thrust of a flat arch grows with its span.
    extent = float(assembly.geometry.extent_of(assembly.movable).max())
    weight = median_unit_weight(assembly) * extent
    if not weight:
        return
    joints = assembly.joints
    for key, values, usual in (
        ("strength", joints.strength, _STRENGTH),
        ("cohesion", joints.cohesion, _COHESION),
    ):
        positive = values[np.isfinite(values) & (values > 0)]
        unusual = positive[(positive < usual.least * weight) | (positive > usual.greatest * weight)]
        if len(unusual):
            farthest = float(unusual[np.abs(np.log(unusual / weight)).argmax()])
            yield reason(Code.STRESS_DIFFERS, key=key, value=farthest, weight=weight)


def unusual_lengths(assembly: Assembly) -> Iterator[Reason]:
    """Generate a warning if the unit weight seems to be per m³, but the lengths seem not to be in metres.

    In the plane without a thickness, the unit weight is that of a strip 1 m thick. If blocks have weights
    instead of unit weights, the thickness of such a scene is unknown, so there is no warning. There is no
    warning either for a unit weight like that of stone in t/m³, which is also the unit weight in gf/cm³.
    """
    blocks = assembly.scene.blocks
    if is_per_area(assembly.scene) and all(blocks[index].unit_weight is None for index in assembly.movable):
        return
    unit_weight = median_unit_weight(assembly)
    extent = float(assembly.geometry.extent_of(assembly.movable).max())
    if typical_unit(unit_weight) not in ("", "t/m³") and extent > LARGEST_SCENE:
        yield reason(Code.LENGTHS_DIFFER, extent=extent, unit_weight=unit_weight)
