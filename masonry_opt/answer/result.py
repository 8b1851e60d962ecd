"""The result of an analysis: names and units put to what was found."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.answer.certificate import Certificate, certify
from masonry_opt.answer.solution import Finding
from masonry_opt.answer.status import Status
from masonry_opt.errors import NoLoadFactorError
from masonry_opt.problem.assembly import Assembly
from masonry_opt.problem.problem import yield_slacks


@dataclass(frozen=True)
class Size:
    """Size of the scene and of the linear program, and what was not modelled.

    Attributes
    ----------
    blocks, joints: movable blocks b and joints c.
    rows, columns, nonzeros: of the linear program as the solver received it; None if none was built.
    left_out: what the scene did not need, each with its reason.
    """

    blocks: int
    joints: int
    rows: int | None
    columns: int | None
    nonzeros: int | None
    left_out: tuple[str, ...] = ()


@dataclass(frozen=True)
class Result:
    """The answer to "at what load does this masonry collapse?", with its residuals.

    Attributes
    ----------
    case: case file or title of the scene.
    method, model, solver: what was asked, of which language and solver.
    status, message: how it ended, and in words.
    load_factor: λ; None unless ``status.usable``.
    certificate: residuals of λ, forces and mechanism, from the matrices alone; None without λ.
    joints: frame, one row a joint: ``first``, ``second``, ``x``, ``y`` (middle), ``length``, forces on
        the first block ``n`` (compression > 0), ``s``, ``m``, rates of the first block against the
        second ``slip``, ``opening``, ``rotation``, and ``utilisation`` (force over its limit, NaN
        where a joint is idle). Forces and lengths in the case's units.
    blocks: frame, one row a movable block: ``block``, ``x``, ``y`` (centroid), ``vx``, ``vy``, ``omega``;
        velocities scaled so that the live load does the work Σ|f_L|, the sum over its components.
    history: frame, one row a step: a sub-problem of the loop (see :class:`~.finding.Iteration`), a
        relaxation of the MPEC (:class:`~.mpec.Relaxation`), a lower state of the refinement
        (:class:`~.refined.Refinement`); empty for a single linear program.
    flow_rule_matters: False if the associative answer already obeys the joints' own flow rule.
    iterations: of the solver, summed.
    lp_solves, nlp_solves: linear and nonlinear programs solved (without the check of the dead load).
    stationary: of a refined answer: True if no mechanism tried among the faces at yield lowers λ, False if
        the solver could not tell for some; None for other methods.
    bound: proven lower bound of λ, of method "global"; None for other methods.
    seconds: by part (see :class:`~masonry_opt.effort.Stopwatch`).
    size: of scene and linear program.
    assembly, finding: the matrices, and forces and velocities in their units.
    """

    case: str
    method: str
    model: str
    solver: str
    status: Status
    message: str
    load_factor: float | None
    certificate: Certificate | None
    joints: pd.DataFrame = field(repr=False)
    blocks: pd.DataFrame = field(repr=False)
    history: pd.DataFrame = field(repr=False)
    flow_rule_matters: bool
    iterations: int
    lp_solves: int
    nlp_solves: int
    stationary: bool | None
    bound: float | None
    seconds: dict[str, float]
    size: Size
    assembly: Assembly = field(repr=False)
    finding: Finding = field(repr=False)

    def required(self) -> float:
        """The load factor; NoLoadFactorError, with case, status and message, if there is none."""
        if self.load_factor is None:
            raise NoLoadFactorError(f"{self.case}: {self.status}: {self.message}")
        return self.load_factor

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, strings, lists and dictionaries (NaN as None)."""
        return _plain(
            {
                "case": self.case,
                "method": self.method,
                "model": self.model,
                "solver": self.solver,
                "status": str(self.status),
                "message": self.message,
                "load_factor": self.load_factor,
                "blocks": self.size.blocks,
                "joints": self.size.joints,
                "flow_rule_matters": self.flow_rule_matters,
                "iterations": self.iterations,
                "lp_solves": self.lp_solves,
                "nlp_solves": self.nlp_solves,
                "stationary": self.stationary,
                "bound": self.bound,
                "seconds": self.seconds,
                "certificate": self.certificate.as_dict() if self.certificate else None,
                "size": asdict(self.size),
                "history": self.history.to_dict("records"),
                "block_results": self.blocks.to_dict("records"),
                "joint_results": self.joints.to_dict("records"),
            }
        )

    def to_json(self) -> str:
        """``as_dict`` as one JSON object."""
        return json.dumps(self.as_dict(), allow_nan=False, ensure_ascii=False)


def make_result(
    assembly: Assembly,
    finding: Finding,
    *,
    case: str,
    method: str,
    model: str,
    solver: str,
    seconds: dict[str, float],
) -> Result:
    """Put the scene's names and units to a finding."""
    problem = assembly.problem
    certificate = None
    if finding.load_factor is not None and finding.q is not None and finding.d is not None:
        slope = problem.dilatancy if finding.slope is None else finding.slope
        certificate = certify(problem, finding.load_factor, finding.q, finding.d, slope)
    lp = finding.size
    return Result(
        case=case,
        method=method,
        model=model,
        solver=solver,
        status=finding.status,
        message=finding.message,
        load_factor=finding.load_factor,
        certificate=certificate,
        joints=_joint_frame(assembly, finding),
        blocks=_block_frame(assembly, finding),
        history=pd.DataFrame(finding.history).drop(columns=["state", "limits"], errors="ignore"),
        flow_rule_matters=finding.flow_rule_matters,
        iterations=finding.iterations,
        lp_solves=finding.lp_solves,
        nlp_solves=finding.nlp_solves,
        stationary=finding.stationary,
        bound=finding.bound,
        seconds=seconds,
        size=Size(
            blocks=problem.blocks,
            joints=problem.joints,
            rows=lp.rows if lp else None,
            columns=lp.columns if lp else None,
            nonzeros=lp.nonzeros if lp else None,
            left_out=_left_out(assembly, cohesive=method == "nonassociative"),
        ),
        assembly=assembly,
        finding=finding,
    )


def _left_out(assembly: Assembly, cohesive: bool) -> tuple[str, ...]:
    problem, joints = assembly.problem, assembly.joints
    left_out = ["n ≥ 0 of every joint: that it does not rock about either edge implies it"]
    if unlimited := problem.joints - len(problem.sliding):
        left_out.append(f"sliding of {_count(unlimited, 'joint')}: friction is unlimited")
    if not cohesive and not problem.cohesion.any():
        left_out.append("cohesion terms: no joint has cohesion")
    if joints.fixed_pairs:
        left_out.append(f"{_count(joints.fixed_pairs, 'joint')} between two fixed blocks: neither moves")
    if joints.near_misses:
        first, second = joints.near_misses[0]
        left_out.append(
            f"{_count(len(joints.near_misses), 'pair')} of blocks that face each other across a small gap "
            f"and so do not touch, such as {assembly.scene.blocks[first].name!r} and "
            f"{assembly.scene.blocks[second].name!r}: raise 'tolerance' if they should"
        )
    return tuple(left_out)


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _names(assembly: Assembly, indices: np.ndarray) -> list[str]:
    return [assembly.scene.blocks[index].name for index in indices]


def _block_frame(assembly: Assembly, finding: Finding) -> pd.DataFrame:
    problem, shapes = assembly.problem, assembly.geometry
    centroid = shapes.centroid[assembly.movable] + shapes.origin
    velocity = np.full(3 * problem.blocks, np.nan) if finding.d is None else finding.d
    return pd.DataFrame(
        {
            "block": _names(assembly, assembly.movable),
            "x": centroid[:, 0],
            "y": centroid[:, 1],
            "vx": velocity[0::3],
            "vy": velocity[1::3],
            "omega": velocity[2::3] / problem.length_unit,
        }
    )


def _joint_frame(assembly: Assembly, finding: Finding) -> pd.DataFrame:
    problem, joints = assembly.problem, assembly.joints
    nothing = np.full(3 * problem.joints, np.nan)
    q = nothing if finding.q is None else finding.q
    u = nothing if finding.d is None else problem.B.T @ finding.d
    force, length = problem.force_unit, problem.length_unit
    middle = joints.middle + assembly.geometry.origin
    return pd.DataFrame(
        {
            "first": _names(assembly, joints.first),
            "second": _names(assembly, joints.second),
            "x": middle[:, 0],
            "y": middle[:, 1],
            "length": joints.length,
            "n": q[0::3] * force,
            "s": q[1::3] * force,
            "m": q[2::3] * force * length,
            "slip": u[1::3],
            "opening": u[0::3],
            "rotation": u[2::3] / length,
            "utilisation": _utilisation(assembly, q),
        }
    )


def _utilisation(assembly: Assembly, q: np.ndarray) -> np.ndarray:
    """Largest of |s| over the true Coulomb limit and |m| over n L/2; NaN where a joint is idle.

    Forces below 1e-6 of the scene's largest normal force are nothing: limits are no smaller.
    """
    problem = assembly.problem
    n, s, m = q[0::3], q[1::3], q[2::3] / problem.half_length
    nothing = 1e-6 * (np.abs(n).max() or 1.0)
    slide, _, rock, _ = yield_slacks(problem, q) + np.stack([q[1::3], -q[1::3], q[2::3], -q[2::3]])
    shear = np.abs(s) / np.maximum(slide, nothing)
    rocking = np.abs(m) / np.maximum(rock / problem.half_length, nothing)
    idle = np.stack([np.abs(n), np.abs(s), np.abs(m)]).max(axis=0) <= nothing
    return np.where(idle, np.nan, np.maximum(shear, rocking))


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
