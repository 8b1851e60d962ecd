"""Collapse load factor of masonry: rigid blocks, dry Coulomb joints, linear programming.

>>> import masonry_opt as mo
>>> result = mo.solve("cases/ferris_tinloi/wall_1.toml")

after Gilbert, Casapulla & Ahmed (2006), Computers and Structures 84, 873-887.
"""

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
