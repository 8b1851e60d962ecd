"""Compare the loads of axles with the weights of a scene, to warn of inputs in different units."""

from collections.abc import Iterable, Iterator
from typing import Any

from masonry_opt.errors import rounded
from masonry_opt.problem.assembly import Assembly
from masonry_opt.scene.road import Axles
from masonry_opt.scene.typical_sizes import LARGEST_SCENE
from masonry_opt.solution.force_units import median_unit_weight
from masonry_opt.solution.typical_units import PER_KILONEWTON, typical_unit
from masonry_opt.studies.warning_codes import StudyCode, study_warning

#: Required unit of the unit weights if a scene uses a predefined set of axles, because the predefined sets
#: are in kN and m.
_UNIT_OF_SETS = "kN/m³"
#: Least plausible load, in kN, of the heaviest axle of a vehicle. A smaller load causes a warning. With a
#: smaller value, warnings would miss axle loads in kN in a scene with weights in N or kg.
_LIGHTEST_AXLE = 3.0
#: Greatest plausible load of the heaviest axle of a vehicle, in kN. A greater load causes a warning. Axle
#: loads in design standards reach 800 kN, including partial factors. With a larger value, warnings would
#: miss axle loads in kg or N in a scene with weights in kN.
_HEAVIEST_AXLE = 1500.0
#: The loads of a group of axles count as relative, without a unit, if the largest is below this value. An
#: example is a load of 1 for each axle. The ``factor`` of the group is not included. With a larger value,
#: light axles in tonnes or kN would be mistaken for relative loads.
_LARGEST_RELATIVE_LOAD = 10.0


def _are_unusual(group: Axles, unit: str) -> bool:
    """Return True if the heaviest axle is implausibly light or heavy for a vehicle.

    The axle loads are assumed to be in the force unit of ``unit``, such as "kN/m³": the unit that the unit
    weights seem to have.

    Relative loads have no unit and are never unusual: see ``_LARGEST_RELATIVE_LOAD``.
    """
    if not unit or max(group.loads, default=0.0) < _LARGEST_RELATIVE_LOAD:
        return False
    return not _LIGHTEST_AXLE <= max(group.group.loads) / PER_KILONEWTON[unit] <= _HEAVIEST_AXLE


def unusual_axles(assembly: Assembly, groups: Iterable[Axles]) -> Iterator[dict[str, Any]]:
    """Generate warnings about axles if their loads and the weights seem to be in different units.

    Warnings have the form of JSON output.
    """
    unit_weight = median_unit_weight(assembly)
    unit = typical_unit(unit_weight)
    looks = f"the median unit weight of the blocks, {rounded(unit_weight)}, seems to be in {unit}"
    extent = float(assembly.geometry.extent_of(assembly.movable).max())
    for group in groups:
        if group.set is None:
            if not _are_unusual(group, unit):
                continue
            heaviest = max(group.group.loads)
            values = {"load": heaviest, "unit_weight": unit_weight}
            sentence = f"the largest load of axles '{group.name}' is {rounded(heaviest)}, but {looks}"
        else:
            units_of_set = f"the set of axles '{group.name}' is in kN and m"
            if unit not in ("", _UNIT_OF_SETS):
                values, sentence = {"unit_weight": unit_weight}, f"{units_of_set}, but {looks}"
            elif extent > LARGEST_SCENE:
                values = {"extent": extent}
                sentence = f"{units_of_set}, but the blocks extend over {rounded(extent)}"
            else:
                continue
        advice = "use the same units for axles, weights and lengths"
        yield study_warning(StudyCode.AXLES_DIFFER, f"{sentence}: {advice}", name=group.name, **values)
