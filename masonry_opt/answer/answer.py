"""A state and its certificate, made together: what methods hand on, and a result shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_opt.answer.acceptance import LIMITS, Kind
from masonry_opt.answer.certificate import Certificate, certify, residuals
from masonry_opt.problem.laws import BY_FACES, Forms
from masonry_opt.problem.problem import Problem


@dataclass(frozen=True, eq=False, kw_only=True)
class Found:
    """Forces and velocities that a method ended with, without a load factor; None where it found none.

    Attributes
    ----------
    q, d: joint forces (3c,) and block velocities (3b,).
    slope: opening per unit slip under the flow rule of the velocities, shape (k,).
    forms: by which laws friction and strength limited them.
    """

    q: np.ndarray | None = None
    d: np.ndarray | None = None
    slope: np.ndarray | None = None
    forms: Forms = BY_FACES


@dataclass(frozen=True, eq=False, kw_only=True)
class Answer(Found):
    """A load factor with its forces and mechanism, and what they leave of every condition.

    Made by :func:`certified` alone: each state has one certificate.

    Attributes
    ----------
    load_factor: λ.
    compliance: of the contacts under which it was certified (see :class:`~.problem.Problem`).
    certificate: residuals of the scene as a whole.
    residuals: everything that the limits of acceptance are for (see :func:`~.certificate.residuals`).
    """

    load_factor: float
    q: np.ndarray
    d: np.ndarray
    slope: np.ndarray
    compliance: np.ndarray | None
    certificate: Certificate
    residuals: dict[str, float]

    def failing(self, kind: Kind) -> dict[str, float | None]:
        """Residuals that exceed the limits of a kind of answer."""
        return LIMITS[kind].failing(self.residuals)

    @property
    def exact(self) -> bool:
        """Whether it is an exact state."""
        return not self.failing(Kind.EXACT)

    def certified_by(self, problem: Problem, slope: np.ndarray) -> Answer:
        """The same state under a flow rule, shape (k,), and the contacts and laws of a problem: itself if all
        are its own."""
        same = self.compliance is problem.compliance and self.forms == problem.forms
        if same and np.array_equal(self.slope, slope):
            return self
        return certified(problem, self.load_factor, self.q, self.d, slope)


def certified(
    problem: Problem,
    load_factor: float,
    q: np.ndarray,
    d: np.ndarray,
    slope: np.ndarray | None = None,
) -> Answer:
    """A state under a flow rule, by default the joints' own at these forces, with its certificate.

    Parameters are those of :func:`~.certificate.certify`.
    """
    slope = problem.dilatancy_at(problem.normal_forces(q)) if slope is None else slope
    certificate = certify(problem, load_factor, q, d, slope)
    return Answer(
        load_factor=load_factor,
        q=q,
        d=d,
        slope=slope,
        forms=problem.forms,
        compliance=problem.compliance,
        certificate=certificate,
        residuals=residuals(problem, certificate, load_factor, q, d),
    )
