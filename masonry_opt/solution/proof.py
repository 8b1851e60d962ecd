"""Record of a proof that no collapse state has a lower load factor.

A collapse state satisfies z_i p_i = 0 for each yield condition i: the rate is either positive (p_i > 0) at
yield (z_i = 0), or zero. One Boolean variable for each condition states whether its rate is positive. A
*conflict* is a clause that excludes one combination of values, by the multipliers of a linear program. The
proof is complete if no assignment satisfies all clauses.

Sums of *products* of statics and kinematics prove lower bounds on λ, see
:mod:`masonry_opt.solution.products`. If these lower bounds are below the bound of the proof, the conflicts
exclude the states between the two bounds.

The record holds data only. :func:`masonry_opt.check_proof` recomputes every conflict and every sum of
products from the matrices.
Forces, load factors and velocities are in the units of :class:`~masonry_opt.problem.problem.Problem`.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from masonry_opt.brief import brief
from masonry_opt.errors import CaseError, OptionError, counted
from masonry_opt.files import JSON_KEY, WRITER, refuse_unwritable, write_whole
from masonry_opt.solution.products import NormalLimit, ProductRelaxation

#: Version of the file format. A reader refuses files of other versions.
FORMAT = 2

#: Limit on the forces and velocities of the collapse states that a proof excludes. A proof with the bound λ₀
#: excludes each collapse state with 0 ≤ λ ≤ λ₀ that satisfies two conditions:
#:
#: - The sum of all forces is at most this multiple of the sum of all loads.
#: - The sum of all velocities of blocks and all rates of slip, opening and crushing is at most this multiple
#:   of the mean velocity of the live load.
#:
#: A larger value requires multipliers with smaller rounding errors.
REACH = 1e6


@dataclass(frozen=True, eq=False)
class StaticConflict:
    """Yield conditions that cannot all be at yield in a state with λ between 0 and the bound of the proof.

    The multipliers are a motion with Bᵀd = C(μ)ᵀp and p ≥ 0 on all other conditions. Every state of
    equilibrium satisfies z·p = c·p − f_D·d − λ f_L·d. The right-hand side is negative for 0 ≤ λ ≤ bound, so
    at least one condition with p < 0 is not at yield.
    """

    conditions: np.ndarray  #: indices of the conditions, shape (n,)
    d: np.ndarray  #: multiplier of each equation of equilibrium, shape (3b,)
    p: np.ndarray  #: multiplier of each yield condition, shape (faces,)

    __repr__ = brief

    @property
    def clause(self) -> list[int]:
        """Conflict as a DIMACS clause: at least one of its yield conditions has a rate of zero."""
        return [-(int(condition) + 1) for condition in self.conditions]


@dataclass(frozen=True, eq=False)
class KinematicConflict:
    """Yield conditions whose rates cannot all be zero in a state with λ between 0 and the proof's bound.

    The multipliers are forces that carry ``weight`` times the dead load and ``load_factor`` times the live
    load, where ``load_factor`` exceeds ``weight`` times the bound. They satisfy C(tan ψ) q + weight · e ≥ 0
    on all other conditions. Slip and crushing in a mechanism dissipate at least the energy e·p.
    """

    conditions: np.ndarray  #: indices of the conditions, shape (n,)
    q: np.ndarray  #: multiplier of each equation of compatibility, shape (3c + t,)
    load_factor: float  #: multiplier of the live load's work
    weight: float  #: multiplier of the energy balance, zero or more

    __repr__ = brief

    @property
    def clause(self) -> list[int]:
        """Conflict as a DIMACS clause: at least one of its yield conditions has a positive rate."""
        return [int(condition) + 1 for condition in self.conditions]


@dataclass(frozen=True, eq=False)
class EnergyBound:
    """Lower bound on the energy that friction in a joint dissipates per unit slip.

    The energy is (μ − tan ψ) n, where tan ψ is the dilatancy. The lower bound is valid for λ between 0 and
    the bound of the proof. The multipliers are a motion as in :class:`StaticConflict`, with
    Bᵀd + (μ − tan ψ) Nᵀ = C(μ)ᵀp. The rates satisfy p ≥ 0 on all conditions except the joint's own sliding
    condition, which is at yield.
    """

    condition: int  #: index of the joint's sliding condition
    value: float  #: lower bound on the energy per unit slip, (μ − tan ψ) n, which is a force
    d: np.ndarray  #: multiplier of each equation of equilibrium, shape (3b,)
    p: np.ndarray  #: multiplier of each yield condition, shape (faces,)

    __repr__ = brief


Conflict = StaticConflict | KinematicConflict


@dataclass(frozen=True, eq=False)
class Proof:
    """Proof that no collapse state has a load factor from 0 to ``bound``."""

    bound: float  #: load factor up to which the proof excludes all collapse states
    #: Lowest load factor of the exact states found. ``mo.check_proof`` does not verify that such a state
    #: exists, but only that this value exceeds ``bound`` and is at least ``excluded_by_products``.
    load_factor: float
    conditions: int  #: number of yield conditions; each corresponds to one Boolean variable
    #: Conflicts with their multipliers. No assignment satisfies the clauses of all conflicts and ``senses``,
    #: so no collapse state exists between ``excluded_by_products`` and ``bound``. A proof by products alone
    #: has no conflicts.
    conflicts: tuple[Conflict, ...]
    #: Lower bounds on the energy that friction dissipates. The kinematic conflicts use these bounds.
    energy_bounds: tuple[EnergyBound, ...]
    #: Indices of the two sliding conditions of each joint, shape (pairs, 2). By the flow rule, a joint cannot
    #: slide in both directions at once, so each pair forms a clause.
    senses: np.ndarray
    #: Relaxations whose products prove lower bounds on λ. Each relaxation raises the lower bound of the
    #: relaxations before it.
    relaxations: tuple[ProductRelaxation, ...] = ()
    #: Load factor up to which the products exclude all states, zero without products. If this load factor is
    #: below ``bound``, the conflicts exclude the states between the two load factors.
    excluded_by_products: float = 0.0

    def __str__(self) -> str:
        return (
            f"no collapse state has a load factor from 0 to {self.bound:.9g}: proof by {self.contents}, "
            f"for {self.conditions} yield conditions; mo.check_proof verifies it"
        )

    @property
    def contents(self) -> str:
        """Numbers of products and of conflicts, as in "1204 products and 35 conflicts"."""
        parts = [counted(self.product_count, "product")] if self.product_count else []
        if self.conflicts or not parts:
            parts.append(counted(len(self.conflicts), "conflict"))
        return " and ".join(parts)

    @property
    def product_count(self) -> int:
        """Number of products in all relaxations."""
        return sum(len(step.multipliers) for step in self.relaxations)

    def __repr__(self) -> str:
        sizes = f"conditions={self.conditions}, conflicts={len(self.conflicts)}"
        sizes += f", products={self.product_count}"
        return f"<Proof bound={self.bound!r}, load_factor={self.load_factor!r}, {sizes}>"

    def clauses(self) -> list[list[int]]:
        """Return the clauses of all conflicts and of ``senses`` as lists of signed variable numbers (DIMACS).

        Variable i stands for yield condition i, counted from 1. A negative number negates the variable.
        """
        own = [conflict.clause for conflict in self.conflicts]
        return own + [[-(int(first) + 1), -(int(second) + 1)] for first, second in self.senses]

    def to_dimacs(self) -> str:
        """Return the clauses in DIMACS format. Any SAT solver can show that they are unsatisfiable.

        Raises
        ------
        OptionError
            If products prove the bound, so that the proof has no clauses.
        """
        if self.excluded_by_products > self.bound:
            raise OptionError(
                "this proof has no clauses, because products prove the bound: "
                "call mo.prove_least(scene, products=False) to search for a proof with clauses"
            )
        clauses = self.clauses()
        lines = [
            f"c no collapse state of this masonry structure has a load factor in "
            f"[{self.excluded_by_products!r}, {self.bound!r}]",
            "c variable i is true if yield condition i has a positive rate",
            f"p cnf {self.conditions} {len(clauses)}",
        ]
        lines += [" ".join(map(str, [*clause, 0])) for clause in clauses]
        return "\n".join(lines) + "\n"

    def to_json(self) -> str:
        """Return the proof as JSON text with all digits of every number."""
        table: dict[str, Any] = {
            JSON_KEY: WRITER,
            "format": FORMAT,
            "bound": self.bound,
            "excluded_by_products": self.excluded_by_products,
            "load_factor": self.load_factor,
            "conditions": self.conditions,
            "senses": self.senses.tolist(),
            "relaxations": [
                _as_table(step) | {"limits": [_as_table(limit) for limit in step.limits]}
                for step in self.relaxations
            ],
            "energy_bounds": [_as_table(bound) for bound in self.energy_bounds],
            "static": [
                _as_table(conflict) for conflict in self.conflicts if isinstance(conflict, StaticConflict)
            ],
            "kinematic": [
                _as_table(conflict) for conflict in self.conflicts if isinstance(conflict, KinematicConflict)
            ],
        }
        return json.dumps(table)

    def save(self, path: str | Path, force: bool = False) -> None:
        """Write the proof to a JSON file.

        Parameters
        ----------
        path: File to write.
        force: True to replace a file that another program wrote.

        Raises
        ------
        OptionError
            If the file cannot be written, or exists and was not written by this package.
        OutputError
            If writing fails.
        """
        refuse_unwritable(Path(path), force)
        write_whole(path, self.to_json())

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a proof from a file.

        Parameters
        ----------
        path: File that ``save`` wrote.

        Returns
        -------
        Proof
            The proof.

        Raises
        ------
        CaseError
            If the file cannot be read, or does not contain a complete proof in this format.
        """
        try:
            table = json.loads(Path(path).read_text(encoding="utf-8"))
        except OSError as error:
            raise CaseError(f"{path}: cannot be read: {error.strerror}") from None
        except ValueError as error:
            raise CaseError(
                f"{path}: the file is not JSON ({error}): write the proof again with Proof.save"
            ) from None
        if not isinstance(table, dict) or table.get("format") != FORMAT:
            raise CaseError(
                f"{path}: the file is not a proof of format {FORMAT}: write the proof again with Proof.save"
            )
        try:
            return cls._from_table(table)
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
            damage = (
                f"key {error} is missing" if isinstance(error, KeyError) else f"a value is wrong: {error}"
            )
            raise CaseError(
                f"{path}: the file is not a complete proof ({damage}): write the proof again with Proof.save"
            ) from None

    @classmethod
    def _from_table(cls, table: dict[str, Any]) -> Self:
        """Return the proof that was saved in a JSON file, from the parsed contents of the file."""
        static = [StaticConflict(**_as_arrays(conflict)) for conflict in table["static"]]
        kinematic = [KinematicConflict(**_as_arrays(conflict)) for conflict in table["kinematic"]]
        return cls(
            bound=float(table["bound"]),
            excluded_by_products=float(table["excluded_by_products"]),
            load_factor=float(table["load_factor"]),
            conditions=int(table["conditions"]),
            conflicts=(*static, *kinematic),
            energy_bounds=tuple(EnergyBound(**_as_arrays(bound)) for bound in table["energy_bounds"]),
            senses=np.array(table["senses"], dtype=int).reshape(-1, 2),
            relaxations=tuple(_relaxation_of(step) for step in table["relaxations"]),
        )


def _relaxation_of(table: dict[str, Any]) -> ProductRelaxation:
    """Return a product relaxation from its table in the parsed JSON file of a proof."""
    limits = tuple(
        NormalLimit(int(limit["joint"]), float(limit["value"]), _floats(limit["d"]), _floats(limit["p"]))
        for limit in table["limits"]
    )
    return ProductRelaxation(
        lowest=float(table["lowest"]),
        highest=float(table["highest"]),
        limits=limits,
        static=np.array(table["static"], dtype=int).reshape(-1, 2),
        kinematic=np.array(table["kinematic"], dtype=int).reshape(-1, 2),
        multipliers=_floats(table["multipliers"]),
        corrections=_floats(table["corrections"]),
    )


def _floats(values: list[float]) -> np.ndarray:
    """Return a list of numbers as an array; raise TypeError if ``values`` is no list."""
    if not isinstance(values, list):
        raise TypeError(f"{values!r} is not a list of numbers")
    return np.array(values, dtype=float)


def _as_table(record: Conflict | EnergyBound | NormalLimit | ProductRelaxation) -> dict[str, Any]:
    """Return the fields of a record, with arrays converted to lists."""
    return {name: of.tolist() if isinstance(of, np.ndarray) else of for name, of in vars(record).items()}


def _as_arrays(table: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of a record, with lists converted to arrays of indices or of floats."""
    types = {"conditions": int}
    return {
        name: np.array(of, dtype=types.get(name, float)) if isinstance(of, list) else of
        for name, of in table.items()
    }
