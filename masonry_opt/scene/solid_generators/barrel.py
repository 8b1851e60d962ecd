"""The generator ``[barrel]``: a barrel vault, an arch's voussoirs made long and cut into stones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Literal

from masonry_opt.scene.arch import ArchRing
from masonry_opt.scene.blocks import Point, Positive
from masonry_opt.scene.generator import PartKeys, SolidGenerator
from masonry_opt.scene.solid_generators.bond import cut, every
from masonry_opt.scene.solids import Solid, prism


class Barrel(ArchRing, SolidGenerator):
    """A barrel vault along y, the point (x, y) of its arch being (x, t, y), t from 0 to its
    length: without ``stone`` that arch, extruded.

    Raises CaseError if the measures make no arch, or the stones are longer than the vault.

    Parameters
    ----------
    radius, angles, span, rise, thickness, voussoirs, weights, skewbacks, abutments: Of its ring: see
        :class:`~masonry_opt.scene.arch.ArchRing`.
    length: Of the vault, along y.
    stone: Length of a stone, along y (default: that of the vault). Pieces at the ends are no shorter than a
        quarter of it: where one would be, its neighbour is as much longer.
    bond: "running": every other voussoir begins with half a stone. "stacked": stones lie as rings side by
        side.
    unit_weight: Weight per unit volume.
    name, at, live_per_weight: See :class:`~masonry_opt.scene.generator.SolidGenerator`; the origin is that of
        the arch, at y = 0.
    """

    length: Positive
    stone: Positive | None = None
    bond: Literal["running", "stacked"] = "running"

    def _mistakes(self) -> Iterator[str]:
        yield from super()._mistakes()
        if self.stone is not None and self.stone > self.length:
            yield f"'stone' is longer than the vault: at most its 'length', {self.length:g}"

    @property
    def size(self) -> int:
        """Number of stones, or a few more."""
        return self.voussoirs * (1 if self.stone is None else 2 + int(min(self.length / self.stone, 1e9)))

    def blocks(self) -> list[Solid]:
        """The stones, voussoir by voussoir from the left, named ``v1-1``, ``v1-2``, ... along y; those of
        skewbacks, ``skewback 1-1``; then ``abutment 1`` and ``abutment 2``."""
        built = []
        # Skewbacks lie in bond with the voussoirs on them; abutments come last and are whole.
        rows = [*range(self.voussoirs), 1, self.voussoirs, 0, 0]
        for stone, row in zip(self._stones(), rows, strict=False):
            if stone.area is None:
                built.append(self._support(stone.name, _slice(stone.corners, 0.0, self.length)))
                continue
            for number, (start, end) in enumerate(self._cuts(row), start=1):
                weight: dict[str, Any] = {"weight": self.unit_weight * stone.area * (end - start)}
                if stone.weight_at is not None:
                    x, z = stone.weight_at
                    weight["weight_at"] = (x, (start + end) / 2, z)
                shape = _slice(stone.corners, start, end)
                built.append(self._stone(f"{stone.name}-{number}", shape, **weight))
        return built

    def _cuts(self, row: int) -> list[tuple[float, float]]:
        """Ends of the stones of a voussoir along y."""
        if self.stone is None:
            return [(0.0, self.length)]
        begins = self.stone / 2 if self.bond == "running" and row % 2 else 0.0
        return cut(0.0, self.length, every(self.stone, begins, self.length), self.stone)


def _slice(corners: Sequence[Point], start: float, end: float) -> PartKeys:
    """The piece of a stone of this section between two places along y."""
    front, back = ([(x, y, z) for x, z in corners] for y in (start, end))
    return prism(front, back)
