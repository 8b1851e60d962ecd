"""The names of the package, for type checkers: ``__init__.py`` imports each when it is first wanted."""

from masonry_opt.analysis import solve as solve
from masonry_opt.answer.certificate import Certificate as Certificate
from masonry_opt.answer.result import Result as Result
from masonry_opt.answer.status import Status as Status
from masonry_opt.duality import DualityReport as DualityReport
from masonry_opt.duality import check as check
from masonry_opt.errors import CaseError as CaseError
from masonry_opt.errors import MasonryError as MasonryError
from masonry_opt.errors import OptionError as OptionError
from masonry_opt.explain.stressed_joints import stressed_joints as stressed_joints
from masonry_opt.exports import export as export
from masonry_opt.scene.arch import Arch as Arch
from masonry_opt.scene.arch import PointLoad as PointLoad
from masonry_opt.scene.blocks import Block as Block
from masonry_opt.scene.blocks import Joint as Joint
from masonry_opt.scene.blocks import JointDefaults as JointDefaults
from masonry_opt.scene.blocks import Reference as Reference
from masonry_opt.scene.case_file import load as load
from masonry_opt.scene.case_file import save as save
from masonry_opt.scene.facade import Facade as Facade
from masonry_opt.scene.scene import Scene as Scene
from masonry_opt.scene.wall import Wall as Wall
from masonry_opt.studies.compare.api import compare as compare
