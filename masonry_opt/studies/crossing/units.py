"""Compare the loads of axles with the weights of a scene, to warn of inputs in different units."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from masonry_opt.problem.assembly import Assembly
from masonry_opt.reporting.sentences import numeral
from masonry_opt.scene.road import Axles
from masonry_opt.solution.force_units import median_unit_weight
from masonry_opt.solution.typical_units import typical_unit
from masonry_opt.studies.warning_codes import StudyCode, study_warning

#: Required unit of the unit weights if a scene uses a common set of axles, because these sets are in kN and
#: m.
_UNIT_OF_SETS = "kN/m³"
#: Ratio of the axle loads of a group to the sum of all dead loads, above which a warning says that their
#: units probably differ. With a larger value, axles in N on heavy bridges with weights in kN cause no
#: warning.
_LARGEST_RATIO = 1000.0
#: Load that every axle of a vehicle exceeds (about 3 kN), in N or kg, for unit weights that seem to be in
#: N/m³ or kg/m³. If all axles are lighter, their loads are probably in kN. With a smaller value, heavy axles
#: in kN cause no warning.
_LIGHTEST_AXLE = {"N/m³": 3000.0, "kg/m³": 300.0}
#: If the largest axle load of a group is smaller, the loads count as relative, such as 2 for one axle and 1
#: for each other axle. Relative loads have no unit. The ``factor`` of the group is not included. With a
#: larger value, light axles in tonnes or kN cause no warning.
_LARGEST_RELATIVE_LOAD = 10.0


def _rounded(value: float) -> str:
    """Return a number rounded to three significant digits, without a power of ten."""
    return numeral(float(f"{value:.3g}"), ".6g")


def _are_light(group: Axles, unit: str) -> bool:
    """Return True if the axles are too light for the unit of the unit weights.

    Relative loads have no unit and are never too light: see ``_LARGEST_RELATIVE_LOAD``.
    """
    if unit not in _LIGHTEST_AXLE or max(group.loads, default=0.0) < _LARGEST_RELATIVE_LOAD:
        return False
    return max(group.group.loads) < _LIGHTEST_AXLE[unit]


def unusual_axles(assembly: Assembly, groups: Iterable[Axles]) -> Iterator[dict[str, Any]]:
    """Generate warnings about axles if their loads and the weights seem to be in different units.

    Warnings have the form of JSON output.
    """
    problem, unit_weight = assembly.problem, median_unit_weight(assembly)
    all_dead = float(np.hypot.reduce(problem.forces(problem.dead), axis=1).sum()) * problem.force_unit
    thickness = assembly.scene.thickness
    for group in groups:
        values: dict[str, float] = {}
        if group.set is not None and typical_unit(unit_weight) not in ("", _UNIT_OF_SETS):
            values = {"unit_weight": unit_weight}
            given = f"the set of axles '{group.name}' is in kN and m"
            unit = typical_unit(unit_weight)
            compared = f"the median unit weight of the blocks, {_rounded(unit_weight)}, looks like {unit}"
            sentence = f"{given}, but {compared}"
        else:
            total = thickness / (group.width or thickness) * float(sum(group.group.loads))
            if all_dead and total > _LARGEST_RATIO * all_dead:
                values = {"load": total, "weight": all_dead}
                share = ", times thickness / width," if group.width else ""
                added = f"the loads of axles '{group.name}'{share} add up to {_rounded(total)}"
                sentence = f"{added}, but all dead loads to {_rounded(all_dead)}"
            elif _are_light(group, typical_unit(unit_weight)):
                heaviest = max(group.group.loads)
                values = {"load": heaviest, "unit_weight": unit_weight}
                looks = f"{_rounded(unit_weight)}, looks like {typical_unit(unit_weight)}"
                largest = f"the largest load of axles '{group.name}' is {_rounded(heaviest)}"
                sentence = f"{largest}, but the median unit weight of the blocks, {looks}"
        if values:
            advice = "use the same unit for axles and weights"
            yield study_warning(StudyCode.AXLES_DIFFER, f"{sentence}: {advice}", name=group.name, **values)
