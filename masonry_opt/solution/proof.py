"""Record of a proof that no collapse state has a lower load factor.

A collapse state satisfies z_i p_i = 0 for each yield condition i: the condition moves (p_i > 0) and is at
yield (z_i = 0), or does not move. One Boolean variable per condition says which. A *conflict* is a clause: it
refutes one combination of values by the multipliers of a linear program. The proof is complete if no
assignment satisfies all clauses.

The record holds data only. :func:`masonry_opt.check_proof` recomputes every conflict from the matrices.
Forces, load factors and velocities are in the units of :class:`~masonry_opt.problem.problem.Problem`.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

#: Version of the file format. A reader refuses files of other versions.
FORMAT = 1

#: Forces that sum to this many times all loads are covered by a conflict, and motions that sum to this many
#: times the live load's mean velocity. A larger number asks for multipliers with smaller rounding errors.
REACH = 1e6


@dataclass(frozen=True, eq=False)
class StaticConflict:
    """Conditions that cannot be at yield together at any load factor from 0 to the bound.

    The multipliers are a motion with Bᵀd = C(μ)ᵀp and p ≥ 0 on all other conditions. Every state of
    equilibrium has z·p = c·p − f_D·d − λ f_L·d. The right-hand side is negative for 0 ≤ λ ≤ bound, so that a
    condition with p < 0 is not at yield.
    """

    conditions: np.ndarray  #: indices of the conditions, shape (n,)
    d: np.ndarray  #: multipliers of equilibrium, shape (3b,)
    p: np.ndarray  #: multipliers of the yield conditions, shape (faces,)

    @property
    def clause(self) -> list[int]:
        """The clause in DIMACS numbering: at least one of the conditions does not move."""
        return [-(int(condition) + 1) for condition in self.conditions]


@dataclass(frozen=True, eq=False)
class KinematicConflict:
    """Conditions of which one moves in every mechanism that a load factor up to the bound can drive.

    The multipliers are forces that carry ``weight`` times the dead load and ``load_factor`` times the live
    load, where ``load_factor`` exceeds ``weight`` times the bound. They satisfy C(tan ψ) q + weight · e ≥ 0
    on all other conditions. The energy e·p of a mechanism is the least that its slip and crushing dissipate.
    """

    conditions: np.ndarray  #: indices of the conditions, shape (n,)
    q: np.ndarray  #: multipliers of compatibility, shape (3c + t,)
    load_factor: float  #: multiplier of the live load's work
    weight: float  #: multiplier of the energy balance, zero or more

    @property
    def clause(self) -> list[int]:
        """The clause in DIMACS numbering: at least one of the conditions moves."""
        return [int(condition) + 1 for condition in self.conditions]


@dataclass(frozen=True, eq=False)
class EnergyBound:
    """Least value of (μ − tan ψ) n of a joint that slides, over all states from λ = 0 to the bound.

    The multipliers are a motion as in :class:`StaticConflict`, with Bᵀd + (μ − tan ψ) Nᵀ = C(μ)ᵀp and p ≥ 0
    on all conditions but the joint's own, which is at yield where the joint slides.
    """

    condition: int  #: index of the sliding condition
    value: float  #: the bound, a force
    d: np.ndarray  #: multipliers of equilibrium, shape (3b,)
    p: np.ndarray  #: multipliers of the yield conditions, shape (faces,)


Conflict = StaticConflict | KinematicConflict


@dataclass(frozen=True, eq=False)
class Proof:
    """Proof that no collapse state has a load factor from 0 to ``bound``."""

    bound: float  #: load factor below which no state exists
    load_factor: float  #: least load factor of the exact states that are known
    conditions: int  #: number of yield conditions, and of Boolean variables
    conflicts: tuple[Conflict, ...]  #: clauses that no assignment satisfies, with their multipliers
    energy_bounds: tuple[EnergyBound, ...]  #: least friction that the kinematic conflicts rely on
    #: Pairs of conditions that are the two senses of sliding of one joint, shape (pairs, 2). The flow rule
    #: lets a joint slide in one sense at a time, which is one more clause for each pair.
    senses: np.ndarray

    def clauses(self) -> list[list[int]]:
        """Return all clauses in DIMACS numbering: of the conflicts, then of the two senses of sliding."""
        own = [conflict.clause for conflict in self.conflicts]
        return own + [[-(int(one) + 1), -(int(other) + 1)] for one, other in self.senses]

    def to_dimacs(self) -> str:
        """Return the clauses as a file in DIMACS format, for any SAT solver: unsatisfiable."""
        clauses = self.clauses()
        lines = [
            f"c no collapse state of this masonry structure has a load factor in [0, {self.bound!r}]",
            "c variable i is true where yield condition i moves",
            f"p cnf {self.conditions} {len(clauses)}",
        ]
        lines += [" ".join(map(str, [*clause, 0])) for clause in clauses]
        return "\n".join(lines) + "\n"

    def to_json(self) -> str:
        """Return the proof as JSON. Every number is written with all its digits."""
        table: dict[str, Any] = {
            "format": FORMAT,
            "bound": self.bound,
            "load_factor": self.load_factor,
            "conditions": self.conditions,
            "senses": self.senses.tolist(),
            "energy_bounds": [_as_table(bound) for bound in self.energy_bounds],
            "static": [_as_table(one) for one in self.conflicts if isinstance(one, StaticConflict)],
            "kinematic": [_as_table(one) for one in self.conflicts if isinstance(one, KinematicConflict)],
        }
        return json.dumps(table)

    def save(self, path: str | Path) -> None:
        """Write the proof to a file as JSON."""
        Path(path).write_text(self.to_json(), encoding="utf-8")

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a proof from a file. Raise ValueError if the file is of another format."""
        table = json.loads(Path(path).read_text(encoding="utf-8"))
        if not isinstance(table, dict) or table.get("format") != FORMAT:
            raise ValueError(f"{path}: not a proof of format {FORMAT}: write it again with Proof.save")
        static = [StaticConflict(**_as_arrays(one)) for one in table["static"]]
        kinematic = [KinematicConflict(**_as_arrays(one)) for one in table["kinematic"]]
        return cls(
            bound=table["bound"],
            load_factor=table["load_factor"],
            conditions=table["conditions"],
            conflicts=(*static, *kinematic),
            energy_bounds=tuple(EnergyBound(**_as_arrays(one)) for one in table["energy_bounds"]),
            senses=np.array(table["senses"], dtype=int).reshape(-1, 2),
        )


def _as_table(record: Conflict | EnergyBound) -> dict[str, Any]:
    """Return the fields of a record, arrays as lists."""
    return {name: of.tolist() if isinstance(of, np.ndarray) else of for name, of in vars(record).items()}


def _as_arrays(table: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of a record, lists as arrays; indices are integers, all other entries floats."""
    types = {"conditions": int}
    return {
        name: np.array(of, dtype=types.get(name, float)) if isinstance(of, list) else of
        for name, of in table.items()
    }
