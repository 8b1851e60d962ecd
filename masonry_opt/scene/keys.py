"""The keys that a scene and a case file share, and the directions that follow from them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, Tag

from masonry_opt.scene.axles import Axles
from masonry_opt.scene.blocks import ONE_OR_SEVERAL, Name, Positive, Record, Reference, Text
from masonry_opt.scene.fill import Fill
from masonry_opt.scene.joints import Joint, JointDefaults
from masonry_opt.scene.load_cases import Earthquake, LoadCases
from masonry_opt.scene.loads import EdgeLoad, Load
from masonry_opt.scene.solids import AnyBlock, PlaneOrSpaceVector, Vector
from masonry_opt.scene.ties import Prop, Tie

Tilt = Annotated[
    Annotated[Literal["left", "right"], Tag("<one>")] | Annotated[Vector, Tag("<several>")], ONE_OR_SEVERAL
]

#: Sine of the angle to gravity below which the direction of a tilt is gravity's own.
_ALONG_GRAVITY = 1e-9


class SceneKeys(Record):
    """The keys that a scene and a case file share."""

    title: Text = ""
    source: Text = ""
    gravity: PlaneOrSpaceVector = (0.0, -1.0)
    tolerance: Positive | None = None
    contact_tolerance: Positive | None = None
    thickness: Positive = 1.0
    tilt: Tilt | None = None
    joints: JointDefaults
    blocks: Annotated[list[AnyBlock], Field(alias="block")] = []
    exceptions: Annotated[list[Joint], Field(alias="joint")] = []
    edge_loads: Annotated[list[EdgeLoad], Field(alias="edge_load")] = []
    loads: Annotated[list[Load], Field(alias="load")] = []
    axles: list[Axles] = []
    fills: Annotated[list[Fill], Field(alias="fill")] = []
    ties: Annotated[list[Tie], Field(alias="tie")] = []
    props: Annotated[list[Prop], Field(alias="prop")] = []
    load_cases: LoadCases = []
    earthquake: Earthquake | None = None
    reference: dict[Name, Reference] = {}

    def model_post_init(self, _: Any) -> None:
        """Sets gravity straight down by default."""
        if "gravity" not in self.model_fields_set:
            # Records are frozen once they are made.
            self.__dict__["gravity"] = (*[0.0] * (self.dimension - 1), -1.0)

    @property
    def dimension(self) -> Literal[2, 3]:
        """Numbers of a point: 3 if the blocks are solids."""
        return self.blocks[0].dimension if self.blocks else 2

    @property
    def down(self) -> np.ndarray:
        """Unit vector of gravity, shape (2,) or (3,)."""
        return _unit(np.array(self.gravity))

    @property
    def tilt_direction(self) -> np.ndarray | None:
        """Unit vector square to gravity, shape (2,) or (3,), in which a tilted scene is pushed; None if it is
        not tilted, or only along gravity."""
        return None if self.tilt is None else self.sideways(self.tilt, self.tilt)

    def sideways(self, side: object, vector: Iterable[object]) -> np.ndarray | None:
        """Unit vector square to gravity to a side, "left" or "right", or in space towards a vector; None if
        that is along gravity."""
        if isinstance(side, str):
            x, y = self.down
            return np.array((-y, x) if side == "right" else (y, -x))
        given = np.array(vector, dtype=float)
        towards = _unit(given) if given.any() else self.down
        sideways = towards - (towards @ self.down) * self.down
        return _unit(sideways) if np.abs(sideways).max() > _ALONG_GRAVITY else None


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.hypot.reduce(vector)
