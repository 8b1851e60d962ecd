"""Distributions of the numbers of a scene, as a user writes them, and values drawn from them: one for all
joints, or one for each course or joint."""

import math
from collections.abc import Iterator, Mapping
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy import stats
from scipy.stats import qmc

from masonry_opt.errors import CaseError, OptionError
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.joints import Joint
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.many.parameters import Parameters, is_of_joints

BY = ("scene", "course", "joint")  #: What a property of joints is drawn once for.
#: Dimensions up to which points are Sobol's. In 83 dimensions, 128 of them have pairs correlated by 0.8,
#: where independent points have 0.3 at most.
_FEW = 10
_EDGE = 2.0**-32  #: Least distance of probabilities from 0 and 1, where distributions are infinite.
_LEVEL = 1e-3  #: Difference in height of joints of one course, over the median length of a joint.
_PROPERTIES = ("friction", "cohesion", "dilatancy", "strength")  #: Properties that an exception can have.
_HOW = (
    "write it as ('lognormal', 0.6, 0.1): the mean and the standard deviation of the number itself, or '15%' "
    "of the mean, both positive; ('normal', mean, positive deviation); ('uniform', least, greatest); or any "
    "frozen distribution of scipy.stats"
)


class Distribution(NamedTuple):
    """A frozen distribution of scipy.stats, and its text for readers."""

    text: str
    frozen: Any


def distribution(name: str, given: Any) -> Distribution:
    """The distribution of a number, as given to :func:`~.sample.sample`. A standard deviation above the mean,
    unless that is zero, must be a share of it. Raises OptionError, with the number's name, if it is none, or
    a value is out of range."""
    of = f"distribution of '{name}'"
    if callable(getattr(given, "ppf", None)) and callable(getattr(given, "cdf", None)):
        kind = getattr(getattr(given, "dist", None), "name", type(given).__name__)
        values = [*getattr(given, "args", ()), *getattr(given, "kwds", {}).values()]
        return Distribution(f"{kind}({', '.join(f'{value:g}' for value in values)})", given)
    try:
        kind, first, second = given
        frozen = _FROZEN[kind]
        first = _number(first)
        second = _number(second) if kind == "uniform" else _deviation(second, first, of)
        least = {"uniform": second - first, "normal": second, "lognormal": min(first, second)}[kind]
        if least <= 0:
            raise ValueError
    except (TypeError, ValueError, KeyError):
        raise OptionError(f"{of}: {_HOW} (found {given!r})") from None
    return Distribution(f"{kind}({first:g}, {second:g})", frozen(first, second))


def lognormal(mean: float, deviation: float) -> Any:
    """The lognormal distribution with this mean and standard deviation: its logarithm has the variance
    v = ln(1 + (deviation / mean)²) and the mean ln(mean) − v / 2."""
    variance = math.log1p((deviation / mean) ** 2)
    return stats.lognorm(math.sqrt(variance), scale=mean * math.exp(-variance / 2))


#: What makes a distribution of two numbers, by kind.
_FROZEN = {
    "normal": stats.norm,
    "lognormal": lognormal,
    "uniform": lambda least, greatest: stats.uniform(least, greatest - least),
}


def parse(text: str) -> tuple[str, tuple[str, Any, Any]]:
    """Name and distribution of a text such as ``joints.friction=lognormal:0.65:15%``; else OptionError."""
    name, equals, words = text.partition("=")
    parts = [_read(part.strip()) for part in words.split(":")]
    if not equals or not name.strip() or len(parts) != 3:
        lognormals = "NAME=lognormal:MEAN:DEVIATION (a number, or 15% of the mean)"
        others = "NAME=normal:MEAN:DEVIATION or NAME=uniform:LEAST:GREATEST"
        raise OptionError(f"'{text}': write it as {lognormals}, {others}")
    return name.strip(), tuple(parts)  # type: ignore[return-value]


def _read(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _number(value: Any) -> float:
    """Raises TypeError if it is not a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not math.isfinite(value):
        raise TypeError
    return float(value)


def _deviation(value: Any, mean: float, of: str) -> float:
    if isinstance(value, str) and value.strip().endswith("%"):
        return abs(mean) / 100 * _number(_read(value.strip()[:-1]))
    number = _number(value)
    if mean and number > abs(mean):
        more = f"a standard deviation of {number:g} is more than the mean, {mean:g}"
        if_share = f"if per cent of the mean are meant, write '{number:g}%'"
        if_not = f"if it is meant as it stands, '{100 * number / abs(mean):.6g}%'"
        raise OptionError(f"{of}: {more}: {if_share}; {if_not}")
    return number


class DrawnColumn(NamedTuple):
    """A column of values drawn: of a number by name, for joints between pairs of blocks, or for the scene."""

    name: str
    of: str
    pairs: tuple[tuple[str, str], ...] = ()


class Draws:
    """The numbers drawn for a scene, and the scenes that they make.

    A course consists of the joints whose middles lie at one height (against gravity). A joint whose exception
    gives the property keeps it. Raises OptionError or CaseError, as :func:`~.sample.sample`.
    """

    def __init__(self, scene: Scene, distributions: Mapping[str, Any], by: str) -> None:
        if not isinstance(distributions, Mapping) or not distributions:
            such = "{'joints.friction': ('lognormal', 0.6, 0.1)}"
            raise OptionError(f"name what is uncertain, with its distribution: {such}")
        if by not in BY:
            raise OptionError(f"by='{by}' is unknown; choose from: {', '.join(BY)}")
        self._by, self._parameters = by, Parameters(scene)
        self._parameters.check_names(distributions)
        self._laws = {name: distribution(name, given) for name, given in distributions.items()}
        spread = [name for name in self._laws if by != "scene" and is_of_joints(name)]
        if by != "scene" and not spread:
            raise OptionError(f"by='{by}': no property of joints is uncertain, such as 'joints.friction'")
        courses = _courses(scene) if spread else {}
        self.columns: list[DrawnColumn] = []  #: of the table of values, in order
        for name in self._laws:
            self.columns += self._spread(name, courses) if name in spread else [DrawnColumn(name, name)]
        #: Distributions in words, by names of numbers.
        self.texts = {name: law.text + f" by {by}" * (name in spread) for name, law in self._laws.items()}

    def _spread(self, name: str, courses: Mapping[tuple[str, str], int]) -> Iterator[DrawnColumn]:
        """The columns of a property that differs by course, 1 the lowest, or by joint."""
        head, _, key = name.partition(".")
        if head != "joints" or key not in _PROPERTIES:
            known = ", ".join(f"joints.{known}" for known in _PROPERTIES)
            raise OptionError(f"'{name}' cannot differ by {self._by}: only {known} can")
        exceptions = self._parameters.scene.exceptions
        given = {frozenset(own.between) for own in exceptions if getattr(own, key) is not None}
        courses = {pair: course for pair, course in courses.items() if frozenset(pair) not in given}
        if not courses:
            raise OptionError(f"'{name}': every joint has its own already: there is none to draw for")

        def group(pair: tuple[str, str]) -> str:
            return f"course.{courses[pair]}" if self._by == "course" else f"joint.{'/'.join(pair)}"

        for of, pairs in groupby(sorted(courses, key=courses.__getitem__), group):
            yield DrawnColumn(f"{of}.{key}", name, tuple(pairs))

    def table(self, count: int, seed: int) -> pd.DataFrame:
        """The values of each run, shape (count, columns). Raises OptionError if the scene refuses one."""
        drawn = points(count, len(self.columns), seed)
        columns = zip(self.columns, drawn.T, strict=True)
        values = pd.DataFrame({c.name: self._laws[c.of].frozen.ppf(shares) for c, shares in columns})
        for name, law in self._laws.items():
            own = values[[c.name for c in self.columns if c.of == name]].to_numpy()
            if not np.isfinite(own).all():
                raise OptionError(f"'{name}': {law.text} gives values that are no number")
            for value in (float(own.min()), float(own.max())):
                self._refuse_impossible(name, law, value)
        return values

    def _refuse_impossible(self, name: str, law: Distribution, value: float) -> None:
        try:
            self._parameters.at({name: value})
        except CaseError as error:
            how = f" (values below 0: {law.frozen.cdf(0.0):.2g} of all)" if value < 0 else ""
            why = f"{law.text} gives {value:g}{how}, which the scene does not take: {error}"
            such = "such as a lognormal, or one cut off, such as scipy.stats.truncnorm"
            raise OptionError(f"'{name}': {why}; take a distribution without such values, {such}") from None

    def scene(self, values: Mapping[str, float]) -> Scene:
        """The scene of a run, its values by the names of the columns; CaseError if it refuses one."""
        scene = self._parameters.at({c.name: values[c.name] for c in self.columns if not c.pairs})
        if not any(c.pairs for c in self.columns):
            return scene
        given = {frozenset(own.between): own.model_dump(exclude_none=True) for own in scene.exceptions}
        for column in self.columns:
            for pair in column.pairs:
                properties = given.setdefault(frozenset(pair), {"between": pair})
                properties[column.of.removeprefix("joints.")] = values[column.name]
        return scene.replace(exceptions=[Joint(**properties) for properties in given.values()])


def points(count: int, dimensions: int, seed: int) -> np.ndarray:
    """Points of the unit cube, shape (count, dimensions): of few dimensions Sobol's scrambled sequence, else
    independent. The first of more points are those of fewer."""
    rng = np.random.default_rng(seed)
    if dimensions > _FEW:
        made = rng.random((count, dimensions))
    else:
        # Of a power of two, whose points are most even, as many as the user chose.
        made = qmc.Sobol(dimensions, seed=rng).random_base2((count - 1).bit_length())[:count]
    return np.clip(made, _EDGE, 1 - _EDGE)


def _courses(scene: Scene) -> dict[tuple[str, str], int]:
    """Courses, 1 the lowest, by pairs of blocks that touch, in the order of the joints."""
    assembly = assemble(scene)
    joints = assembly.joints
    height = pd.Series(joints.middle @ -scene.down).sort_values(kind="stable")
    course = 1 + (height.diff() > _LEVEL * 2 * assembly.problem.length_unit).cumsum().sort_index()
    pairs = zip(assembly.names(joints.first), assembly.names(joints.second), strict=True)
    found: dict[tuple[str, str], int] = {}
    for pair, number in zip(pairs, course, strict=True):
        found.setdefault(pair, number)
    return found
