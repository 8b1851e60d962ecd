"""Collapse load factor of masonry: rigid blocks, dry Coulomb joints, linear programming.

>>> import masonry_opt as mo
>>> result = mo.solve("cases/ferris_tinloi/wall_1.toml")

after Gilbert, Casapulla & Ahmed (2006), Computers and Structures 84, 873-887.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from masonry_opt.analysis.check import DualityReport, check
    from masonry_opt.analysis.dilatancy_check import stressed_joints
    from masonry_opt.analysis.result import Result
    from masonry_opt.analysis.solve import solve
    from masonry_opt.analysis.status import Status
    from masonry_opt.errors import CaseError, MasonryError, OptionError
    from masonry_opt.problem.certificate import Certificate
    from masonry_opt.scene import (
        Arch,
        Block,
        Facade,
        Joint,
        JointDefaults,
        PointLoad,
        Reference,
        Scene,
        Wall,
        load,
        save,
    )

__all__ = [
    "Arch",
    "Block",
    "CaseError",
    "Certificate",
    "DualityReport",
    "Facade",
    "Joint",
    "JointDefaults",
    "MasonryError",
    "OptionError",
    "PointLoad",
    "Reference",
    "Result",
    "Scene",
    "Status",
    "Wall",
    "check",
    "load",
    "save",
    "solve",
    "stressed_joints",
]

#: Where the names are that are not of the scene. They are imported when first asked for: the modelling
#: languages take seconds, in which the command must be able to end on Ctrl-C.
_HOMES = {
    "CaseError": "errors",
    "Certificate": "problem.certificate",
    "DualityReport": "analysis.check",
    "MasonryError": "errors",
    "OptionError": "errors",
    "Result": "analysis.result",
    "Status": "analysis.status",
    "check": "analysis.check",
    "solve": "analysis.solve",
    "stressed_joints": "analysis.dilatancy_check",
}


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'masonry_opt' has no attribute '{name}'")
    value = getattr(import_module(f"masonry_opt.{_HOMES.get(name, 'scene')}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
