"""What fills do to a scene, in words."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_opt.errors import counted
from masonry_opt.problem.assembly import Assembly


def of_fills(assembly: Assembly) -> Iterator[str]:
    """A line on each fill: how many edges it touches, what of it weighs on blocks that can move, how loads
    spread, how it presses."""
    scene, movable = assembly.scene, set(assembly.movable.tolist())
    for number, fill in enumerate(scene.fills):
        pieces = [piece for piece in assembly.filled_pieces if piece.fill == number]
        below = [piece for piece in pieces if piece.area and piece.block in movable]
        weight = scene.thickness * fill.unit_weight * sum(piece.area for piece in below)
        blocks = counted(len({piece.block for piece in below}), "block")
        said = [f"touches {counted(len(pieces), 'edge')}"]
        said.append(f"weighs {weight:.4g} on {blocks}" if fill.weight else "without weight")
        spread = f"loads on the road spread by {fill.spread:g}° to the vertical"
        said.append("loads go straight down" if fill.spread is False else spread)
        if fill.pressure:
            active, at_rest, passive = fill.coefficients
            said.append(
                f"pressure between {active:.4g} σ (K_a) and {passive:.4g} σ (m K_p), at rest {at_rest:.4g} σ "
                "(K_0), σ its unit weight times depth"
            )
        else:
            said.append("no pressure")
        yield "; ".join(said)
