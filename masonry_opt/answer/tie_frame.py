"""Table of the limited forces of a solution: ties, props, and what else acts within limits."""

from __future__ import annotations

import numpy as np
import pandas as pd

from masonry_opt.answer.frames import unsigned
from masonry_opt.answer.motion import fastest
from masonry_opt.answer.solution import Solution
from masonry_opt.answer.thresholds import AT_HIGHEST, MOVES
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.limited_forces import Role


def tie_frame(assembly: Assembly, solution: Solution, *roles: Role) -> pd.DataFrame:
    """A row a limited force of these roles (NaN without forces, or mechanism)."""
    problem, forces = assembly.problem, assembly.limited
    nothing = np.full(len(forces), np.nan)
    T = nothing if solution.q is None else problem.of_forces(solution.q) * problem.force_unit
    closing = nothing if solution.d is None else problem.of_forces(problem.B.T @ solution.d)
    speed = np.nan if solution.d is None else MOVES * fastest(assembly, solution.d)
    names = [*(block.name for block in assembly.scene.blocks), "ground"]
    rows = [
        {
            "name": force.name,
            "kind": str(force.role),
            "first": names[force.actions[0].block],
            "second": names[force.actions[-1].block] if len(force.actions) > 1 else "ground",
            "force": T[number],
            "lowest": force.lowest,
            "highest": force.highest,
            # What a force works on, it goes along with: a tie shortens, a prop lengthens.
            "lengthens": closing[number] if force.role is Role.PROP else -closing[number],
            # Of a scene that falls no forces are known.
            "yields": bool(
                force.highest > 0 and -closing[number] > speed and not T[number] < AT_HIGHEST * force.highest
            ),
        }
        for number, force in enumerate(forces)
        if force.role in roles
    ]
    columns = ("name", "kind", "first", "second", "force", "lowest", "highest", "lengthens", "yields")
    frame = pd.DataFrame(rows, columns=columns)
    numbers = ["force", "lowest", "highest", "lengthens"]
    return unsigned(frame.astype(dict.fromkeys(numbers, float)))
