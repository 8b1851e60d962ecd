"""Name the rows and columns of the matrices of a problem.

A name consists of a kind and a label: ``n1[A|ground]`` is the normal force at the first end of the joint
between the blocks A and ground. Exported programs, proofs and certified states use these names.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from masonry_opt.brief import brief
from masonry_opt.problem.faces import CHORDS
from masonry_opt.problem.problem import Problem

#: Labels are truncated to this number of characters, before brackets and suffixes such as ~2 are added. Names
#: in LP and MPS files may have at most 255 characters.
_LONGEST_LABEL = 200

#: Characters that some solvers reject in names of LP files.
_ILLEGAL = r"[^A-Za-z0-9_.]"

#: Names of the joint forces in the order of the columns of B, for each dimension of the scene (2 or 3).
_FORCE_KINDS: dict[int, tuple[str, ...]] = {2: ("n1", "n2", "s"), 3: ("n", "s", "t")}

#: Names of the joint motions Bᵀd in the order of the columns of B, for each dimension of the scene (2 or 3).
_MOTION_KINDS: dict[int, tuple[str, ...]] = {
    2: ("opening_1", "opening_2", "slip"),
    3: ("opening", "slip_s", "slip_t"),
}

#: Names of the block velocities in the order of the rows of B, for each dimension of the scene (2 or 3).
_VELOCITY_KINDS: dict[int, tuple[str, ...]] = {
    2: ("vx", "vy", "omega"),
    3: ("vx", "vy", "vz", "wx", "wy", "wz"),
}

#: Names of the equilibrium equations in the order of the rows of B, for each dimension of the scene (2 or 3).
_BALANCE_KINDS: dict[int, tuple[str, ...]] = {
    2: ("fx", "fy", "moment"),
    3: ("fx", "fy", "fz", "mx", "my", "mz"),
}

#: Names of the rocking conditions of a joint, for each dimension of the scene (2 or 3).
_ROCK_KINDS = {2: ("rock_1", "rock_2"), 3: ("open",)}


@dataclass(frozen=True)
class ProblemNames:
    """Names of the rows and columns of a problem's matrices.

    Each name consists of a kind and the label of a joint, block or limited force.
    """

    problem: Problem
    joints: list[str]  #: labels of the joints (in space, of the contact points), such as ``[A|ground]``
    blocks: list[str]  #: label of each movable block, such as ``[A]``
    limited: list[str]  #: label of each limited force

    __repr__ = brief

    @property
    def forces(self) -> list[str]:
        """Return a name for each entry of the joint forces q, in the order of the columns of B."""
        return self._of_columns(_FORCE_KINDS, "T")

    @property
    def motions(self) -> list[str]:
        """Return a name for each entry of the joint motions Bᵀd, in the order of the columns of B."""
        return self._of_columns(_MOTION_KINDS, "length")

    @property
    def velocities(self) -> list[str]:
        """Return a name for each entry of the block velocities d, in the order of the rows of B."""
        return self._of_rows(_VELOCITY_KINDS)

    @property
    def balances(self) -> list[str]:
        """Return a name for each equation of equilibrium, in the order of the rows of B."""
        return self._of_rows(_BALANCE_KINDS)

    @property
    def conditions(self) -> list[str]:
        """Return a name for each yield condition, in the order of the rows of the yield matrix C."""
        return [*self._conditions()]

    def _of_columns(self, kinds: dict[int, tuple[str, ...]], of_limited: str) -> list[str]:
        own = kinds[self.problem.layout.dimension]
        names = [kind + label for kind in own for label in self.joints]
        return names + [of_limited + label for label in self.limited]

    def _of_rows(self, kinds: dict[int, tuple[str, ...]]) -> list[str]:
        own = kinds[self.problem.layout.dimension]
        return [kind + label for label in self.blocks for kind in own]

    def _conditions(self) -> Iterator[str]:
        problem = self.problem
        senses = range(1, len(problem.layout.senses) + 1)
        slides = ["slide_plus", "slide_minus"]
        if problem.layout.round:
            slides = [f"slide_{side}" for side in senses]
        kinds = [kind for kind in slides for _ in problem.sliding]
        kinds += [kind for kind in _ROCK_KINDS[problem.layout.dimension] for _ in range(problem.joints)]
        chords = range(1, len(CHORDS.slope) + 1)
        kinds += [f"crush_{point}_{chord}" for point in (1, 2) for _ in problem.crushing for chord in chords]
        for kind, number in zip(kinds, problem.face_joint.tolist(), strict=True):
            yield kind + self.joints[number]
        yield from (f"least{self.limited[force]}" for force in problem.table.below)
        yield from (f"most{self.limited[force]}" for force in problem.table.above)


def labels_of(names: Sequence[str], legal: bool) -> list[str]:
    """Return unique labels for given names, in the form ``[A|ground]``.

    If ``legal`` is True, the form is ``{A|ground}``, which all solvers can read in LP files.
    """
    template = "{{{}}}" if legal else "[{}]"
    return [template.format(label) for label in unique(names)]


def legal_name(name: str) -> str:
    """Return a name in which ``_`` replaces every character that some solvers reject in LP files."""
    return re.sub(_ILLEGAL, "_", name)


def unique(labels: Iterable[str]) -> list[str]:
    """Return unique labels: append ``~2``, ``~3``, ... to repeated labels, and truncate long labels."""
    cut = [label[:_LONGEST_LABEL] for label in labels]
    originals, different = {*cut}, dict[str, None]()
    for label in cut:
        name, number = label, 1
        while name in different or (number > 1 and name in originals):
            number += 1
            name = f"{label}~{number}"
        different[name] = None
    return [*different]
