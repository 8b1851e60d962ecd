"""The last question to an answer: does its own certificate bear it out?"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

import numpy as np
import scipy.sparse as sp

from masonry_opt.answer.certificate import certify
from masonry_opt.answer.solution import Finding
from masonry_opt.answer.status import Status
from masonry_opt.problem.problem import Problem, yield_slacks


@dataclass(frozen=True)
class Gate:
    """Residuals beyond which a load factor is not given out.

    Attributes
    ----------
    complementarity, work: energy of what moves without being at yield, and work of forces out of balance,
        over |λ| (over ``SMALLEST`` at least).
    flow, equilibrium: as the certificate has them.
    balance: force out of balance on any one block, over the largest that acts on it.
    yielding: violation of the true law at any one joint, over the largest force on the lesser of its blocks.
    """

    complementarity: float
    work: float
    flow: float
    equilibrium: float
    balance: float
    yielding: float


#: Load factors below this are judged as if they were this large.
SMALLEST = 1e-2

#: Forces below this share of the live load at collapse do not matter, whatever acts on their block.
_NO_MATTER = 1e-4

#: Of methods that end exactly; of a linear program, complementarity is by how much λ can be off.
EXACT = Gate(complementarity=1e-3, work=1e-3, flow=1e-3, equilibrium=1e-3, balance=1e-3, yielding=1e-3)

#: Of the others. The paper's loop, stopped by its own rule, leaves up to some per cent, and at a joint that
#: does not slide half of its block's forces.
COULOMB = Gate(complementarity=5e-2, work=5e-2, flow=5e-2, equilibrium=1e-2, balance=5e-2, yielding=1.0)

#: Forces that no run of the loop that looks for an exact end may leave. How far its mechanism is from exact,
#: it judges itself.
FINISHED = replace(COULOMB, complementarity=inf, flow=inf, yielding=0.5)

#: Of a loop that looked for exact forces in vain: λ to one per cent.
IN_VAIN = replace(COULOMB, complementarity=1e-2)


def failing_residuals(problem: Problem, finding: Finding, gate: Gate) -> str:
    """The residuals with which an answer fails its gate, in words; empty if it passes."""
    load_factor, q, d = finding.load_factor, finding.q, finding.d
    if load_factor is None or q is None or d is None:
        return ""
    slope = problem.dilatancy if finding.slope is None else finding.slope
    left = certify(problem, load_factor, q, d, slope)
    unbalanced = problem.B @ q + load_factor * problem.live + problem.dead
    work = float(problem.live @ d)
    if work <= 0:
        return "the live load drives nothing"  # its entries are below what the solver takes for zero
    scale = max(abs(load_factor), SMALLEST)
    acting = largest_acting(problem, load_factor, q)
    failing = {
        "complementarity": (left.complementarity, gate.complementarity * scale),
        "flow": (left.flow, gate.flow),
        "equilibrium": (left.equilibrium, gate.equilibrium),
        "work of forces out of balance": (float(np.abs(unbalanced * d).sum()) / work, gate.work * scale),
        "equilibrium of one block": (_balance(problem, unbalanced, acting), gate.balance),
        "yield of one joint": (_yielding(problem, q, acting), gate.yielding),
    }
    return ", ".join(f"{name} {value:.1e}" for name, (value, most) in failing.items() if not value <= most)


# The certificate measures forces in median weights and total loads, in which a block very much lighter
# than the others disappears. If it carries the live load, λ is its alone: hence each block for itself.


def largest_acting(problem: Problem, load_factor: float, q: np.ndarray) -> np.ndarray:
    """Largest force (a load, n or s) that acts on each block, or the least that matters, shape (b,)."""
    loads = np.abs(problem.dead) + abs(load_factor * problem.live)
    loads = np.maximum(loads[0::3], loads[1::3])
    ends = _ends(problem)
    at_joints = np.maximum(np.abs(q[0::3]), np.abs(q[1::3]))
    carried = ends.multiply(at_joints[None, :]).max(axis=1).toarray().ravel()
    least = _NO_MATTER * max(abs(load_factor), SMALLEST) * problem.live_norm
    return np.maximum(np.maximum(loads, carried), least)


def _ends(problem: Problem) -> sp.csr_array:
    """1 where a joint (column) is one of a block's (row), shape (b, c)."""
    # A moment in a joint acts on both of its blocks.
    return abs(problem.B_m[2::3])


def _balance(problem: Problem, unbalanced: np.ndarray, acting: np.ndarray) -> float:
    """Largest force out of balance on a block over the largest that acts on it; a moment over that force
    at the longest arm."""
    arms = np.maximum(
        abs(problem.B_n[2::3]).max(axis=1).toarray(), abs(problem.B_s[2::3]).max(axis=1).toarray()
    )
    half = _ends(problem).multiply(problem.half_length[None, :]).max(axis=1).toarray()
    arm = np.maximum(arms, half).ravel()
    forces = np.maximum(np.abs(unbalanced[0::3]), np.abs(unbalanced[1::3])) / acting
    return float(np.maximum(forces, np.abs(unbalanced[2::3]) / (acting * arm)).max())


def _yielding(problem: Problem, q: np.ndarray, acting: np.ndarray) -> float:
    """Largest violation of yield over the largest force on the lesser of a joint's blocks."""
    z = yield_slacks(problem, q)
    violation = np.concatenate([-z[:2], -z[2:] / problem.half_length, -q[None, 0::3]]).max(axis=0)
    return float((np.maximum(violation, 0.0) / of_lesser_block(problem, acting)).max())


def of_lesser_block(problem: Problem, acting: np.ndarray) -> np.ndarray:
    """Of each joint, the largest force on that of its movable blocks that carries less, shape (c,)."""
    # Zeros of a sparse matrix count in a minimum, so the maximum of the inverse.
    return 1 / _ends(problem).multiply(1 / acting[:, None]).max(axis=0).toarray().ravel()


def refused(finding: Finding, failing: str) -> Finding:
    """The finding without its load factor."""
    message = (
        f"the answer found, {finding.load_factor:.6g}, is not borne out by its certificate ({failing}): "
        "try another solver, and look for weights or lengths of very different size"
    )
    return replace(finding, status=Status.SOLVER_FAILED, message=message, load_factor=None)
