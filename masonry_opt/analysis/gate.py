"""The last question to an answer: does its own certificate bear it out?"""

from __future__ import annotations

from dataclasses import dataclass, replace

from masonry_opt.analysis.finding import Finding
from masonry_opt.analysis.status import Status
from masonry_opt.problem.certificate import certify
from masonry_opt.problem.problem import Problem


@dataclass(frozen=True)
class Gate:
    """Residuals beyond which a load factor is not given out.

    Attributes
    ----------
    complementarity: over |λ| (over ``SMALLEST`` at least).
    flow, equilibrium: as the certificate has them.
    """

    complementarity: float
    flow: float
    equilibrium: float


#: Load factors below this are judged as if they were this large.
SMALLEST = 1e-2

#: Of one linear program: its complementarity is by how much λ can be off.
ASSOCIATIVE = Gate(complementarity=1e-3, flow=1e-3, equilibrium=1e-3)

#: Of the other methods: the paper's loop, stopped by its own rule, leaves up to some per cent.
COULOMB = Gate(complementarity=5e-2, flow=5e-2, equilibrium=1e-2)


def failing_residuals(problem: Problem, finding: Finding, gate: Gate) -> str:
    """The residuals with which an answer fails its gate, in words; empty if it passes."""
    if finding.load_factor is None or finding.q is None or finding.d is None:
        return ""
    slope = problem.dilatancy if finding.slope is None else finding.slope
    left = certify(problem, finding.load_factor, finding.q, finding.d, slope)
    scale = max(abs(finding.load_factor), SMALLEST)
    failing = {
        "complementarity": (left.complementarity, gate.complementarity * scale),
        "flow": (left.flow, gate.flow),
        "equilibrium": (left.equilibrium, gate.equilibrium),
    }
    return ", ".join(f"{name} {value:.1e}" for name, (value, most) in failing.items() if not value <= most)


def refused(finding: Finding, failing: str) -> Finding:
    """The finding without its load factor."""
    message = (
        f"the answer found, {finding.load_factor:.6g}, is not borne out by its certificate ({failing}): "
        "try another solver, and look for weights or lengths of very different size"
    )
    return replace(finding, status=Status.SOLVER_FAILED, message=message, load_factor=None)
