"""Friction and dilatancy as angles in degrees, in place of their tangents."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BaseModel, Field, Strict, model_validator

#: The keys in degrees, and the tangents that are kept of them.
_TANGENTS = {"friction_angle": "friction", "dilatancy_angle": "dilatancy"}

Angle = Annotated[float, Strict(), Field(ge=0, lt=90)]


class InDegrees(BaseModel):
    """Keys that a record of joint properties takes and does not keep: they become ``friction`` and
    ``dilatancy``.

    Parameters
    ----------
    friction_angle, dilatancy_angle:
        φ and φ₀ in degrees, 0 or more and less than 90, in place of ``friction`` = tan φ and ``dilatancy`` =
        tan φ₀.
    """

    friction_angle: Angle | None = Field(default=None, exclude=True, repr=False)
    dilatancy_angle: Angle | None = Field(default=None, exclude=True, repr=False)

    @model_validator(mode="before")
    @classmethod
    def _as_tangents(cls, keys: Any) -> Any:
        if not isinstance(keys, Mapping):
            return keys
        keys = dict(keys)
        for angle, tangent in _TANGENTS.items():
            degrees = keys.get(angle)
            if degrees is None:
                continue
            if keys.get(tangent) is not None:
                raise ValueError(f"give '{tangent}' or '{angle}', not both")
            if type(degrees) in (int, float) and 0 <= degrees < 90:
                keys[tangent] = math.tan(math.radians(keys.pop(angle)))
            else:  # the field says what is wrong with it, and nothing else is
                keys[tangent] = 0.0
        return keys
