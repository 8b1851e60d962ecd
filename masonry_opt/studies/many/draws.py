"""Random values for the parameters of a scene: distributions, and samples from the distributions.

A property of joints may have one random value for all joints, for each course, or for each joint.
"""

import math
from collections.abc import Iterator, Mapping
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy import stats
from scipy.stats import qmc

from masonry_opt.errors import CaseError, OptionError, rounded_down
from masonry_opt.problem.assembly import assemble
from masonry_opt.scene.joints import Joint
from masonry_opt.scene.mistakes import instead_of
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.many.parameters import Parameters, is_of_joints

#: Choices for the joints that share a random value of a property: all joints of the scene, the joints of a
#: course, or a single joint.
JOINT_GROUPS = ("scene", "course", "joint")
#: Largest number of dimensions (random values per run) for which samples use Sobol points. In more
#: dimensions, the points are independent. Coordinates of few Sobol points in many dimensions are correlated.
#: Of 128 points in 83 dimensions, the largest correlation of two coordinates is about 0.8 for Sobol points,
#: and about 0.3 for independent points.
_MOST_SOBOL_DIMENSIONS = 10
#: Least distance of the coordinates of random points from 0 and from 1. The coordinates are probabilities.
#: The quantiles of a distribution at the probabilities 0 and 1 may be infinite.
_LEAST_PROBABILITY = 2.0**-32
#: Largest difference in height between successive joints of one course, relative to the median joint length.
#: A larger difference begins a new course.
_COURSE_TOLERANCE = 1e-3
_PROPERTIES = ("friction", "cohesion", "dilatancy", "strength")  #: Properties that may differ by joint.
_DISTRIBUTION_FORMS = (
    "write ('lognormal', mean, deviation), ('normal', mean, deviation), ('uniform', least, greatest) or a "
    "frozen distribution of scipy.stats. A deviation is a positive number, or a share of the mean such as "
    "'15%'. For 'lognormal', the mean must be positive; mean and deviation are those of the value, not of "
    "its logarithm"
)


class Distribution(NamedTuple):
    """Distribution of scipy.stats with fixed parameters (frozen), and its printed text."""

    text: str
    frozen: Any


def distribution(name: str, definition: Any) -> Distribution:
    """Convert a user's distribution to a frozen distribution of SciPy, with its printed text.

    ``definition`` has one of the forms that :func:`~.sample.sample` accepts.

    A standard deviation that exceeds a nonzero mean must be written as a fraction of the mean. Raises
    OptionError, with the name of the number, if the form is unknown or a value is out of range.
    """
    subject = f"distribution of '{name}'"
    if callable(getattr(definition, "ppf", None)) and callable(getattr(definition, "cdf", None)):
        kind = getattr(getattr(definition, "dist", None), "name", type(definition).__name__)
        values = [*getattr(definition, "args", ()), *getattr(definition, "kwds", {}).values()]
        return Distribution(f"{kind}({', '.join(f'{value:g}' for value in values)})", definition)
    try:
        kind, first, second = definition
        frozen = _DISTRIBUTIONS[kind]
        first = _number(first)
        second = _number(second) if kind == "uniform" else _deviation(second, first, subject)
        least = {"uniform": second - first, "normal": second, "lognormal": min(first, second)}[kind]
        if least <= 0:
            raise ValueError
    except (TypeError, ValueError, KeyError):
        raise OptionError(f"{subject}: {_DISTRIBUTION_FORMS} (found {definition!r})") from None
    return Distribution(f"{kind}({first:g}, {second:g})", frozen(first, second))


def lognormal(mean: float, deviation: float) -> Any:
    """Return the lognormal distribution with a given mean and standard deviation.

    Its logarithm has the variance v = ln(1 + (deviation / mean)²) and the mean ln(mean) − v / 2.
    """
    variance = math.log1p((deviation / mean) ** 2)
    return stats.lognorm(math.sqrt(variance), scale=mean * math.exp(-variance / 2))


#: Functions that return a distribution from its two parameters, by the name of the distribution.
_DISTRIBUTIONS = {
    "normal": stats.norm,
    "lognormal": lognormal,
    "uniform": lambda least, greatest: stats.uniform(least, greatest - least),
}


def parse(text: str) -> tuple[str, tuple[str, Any, Any]]:
    """Split a text such as ``joints.friction=lognormal:0.65:15%`` into the name and the distribution.

    Raises OptionError if the text has another form.
    """
    name, equals, words = text.partition("=")
    parts = [_read(part.strip()) for part in words.split(":")]
    if not equals or not name.strip() or len(parts) != 3:
        lognormals = (
            "NAME=lognormal:MEAN:DEVIATION (DEVIATION is a number, or a share of the mean such as 15%)"
        )
        other_forms = "NAME=normal:MEAN:DEVIATION or NAME=uniform:LEAST:GREATEST"
        raise OptionError(f"'{text}': write it as {lognormals}, {other_forms}")
    return name.strip(), tuple(parts)  # type: ignore[return-value]


def _read(text: str) -> float | str:
    """Convert a text to a number. A text that is not a number is returned unchanged."""
    try:
        return float(text)
    except ValueError:
        return text


def _number(value: Any) -> float:
    """Return a finite number as a float. Raises TypeError for any other value."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not math.isfinite(value):
        raise TypeError
    return float(value)


def _deviation(value: Any, mean: float, subject: str) -> float:
    """Return a standard deviation from a number, or from a fraction of the mean such as "15%".

    Raises OptionError, with the subject, if the number exceeds a nonzero mean. Raises TypeError if the value
    is not a number.
    """
    if isinstance(value, str) and value.strip().endswith("%"):
        return abs(mean) / 100 * _number(_read(value.strip()[:-1]))
    number = _number(value)
    if mean and number > abs(mean):
        more = f"a standard deviation of {number:g} is more than the mean, {mean:g}"
        if_share = f"for a percentage of the mean, write '{number:g}%'"
        if_not = f"for the number itself, write '{100 * number / abs(mean):.6g}%'"
        raise OptionError(f"{subject}: {more}: {if_share}; {if_not}")
    return number


class DrawnColumn(NamedTuple):
    """Column of random values in a table of runs."""

    name: str
    of: str  #: name of the parameter whose distribution provides the values
    #: Pairs of blocks whose joints have the value; empty if the value belongs to the whole scene.
    pairs: tuple[tuple[str, str], ...] = ()


class Draws:
    """Generator of random values for the parameters of a scene, and of scenes with these values.

    A course consists of the joints whose middles are at one height (against gravity). A joint with its own
    value of a property, by an exception, keeps this value. Raises OptionError or CaseError as
    :func:`~.sample.sample`.
    """

    def __init__(self, scene: Scene, distributions: Mapping[str, Any], by: str) -> None:
        if not isinstance(distributions, Mapping) or not distributions:
            example = "{'joints.friction': ('lognormal', 0.6, 0.1)}"
            raise OptionError(f"pass the uncertain parameters with their distributions: {example}")
        if by not in JOINT_GROUPS:
            raise OptionError(f"by='{by}' is unknown{instead_of(by, JOINT_GROUPS)}")
        self._by, self._parameters = by, Parameters(scene)
        self._parameters.check_names(distributions)
        self._laws = {name: distribution(name, definition) for name, definition in distributions.items()}
        by_group = [name for name in self._laws if by != "scene" and is_of_joints(name)]
        if by != "scene" and not by_group:
            raise OptionError(f"by='{by}' needs an uncertain property of joints, such as 'joints.friction'")
        courses = _courses(scene) if by_group else {}
        #: Columns of the table of random values, in the order of the table.
        self.columns: list[DrawnColumn] = []
        #: Distribution of each uncertain parameter as text, by the name of the parameter.
        self.texts: dict[str, str] = {}
        for name, law in self._laws.items():
            if name in by_group:
                self.columns += self._columns_by_group(name, courses)
                self.texts[name] = f"{law.text} by {by}"
            else:
                self.columns.append(DrawnColumn(name, name))
                self.texts[name] = law.text

    def _columns_by_group(self, name: str, courses: Mapping[tuple[str, str], int]) -> Iterator[DrawnColumn]:
        """Generate the columns of a joint property that has a random value for each course or each joint."""
        head, _, key = name.partition(".")
        if head != "joints" or key not in _PROPERTIES:
            known = ", ".join(f"joints.{known}" for known in _PROPERTIES)
            raise OptionError(f"'{name}' cannot have one value per {self._by}: choose from {known}")
        exceptions = self._parameters.scene.exceptions
        own_values = {frozenset(joint.between) for joint in exceptions if getattr(joint, key) is not None}
        courses = {pair: course for pair, course in courses.items() if frozenset(pair) not in own_values}
        if not courses:
            raise OptionError(
                f"'{name}' cannot be random, because every joint has its own value in the scene: remove "
                "the values of single joints"
            )

        def group_name(pair: tuple[str, str]) -> str:
            return f"course.{courses[pair]}" if self._by == "course" else f"joint.{'/'.join(pair)}"

        for group, pairs in groupby(sorted(courses, key=courses.__getitem__), group_name):
            yield DrawnColumn(f"{group}.{key}", name, tuple(pairs))

    def table(self, count: int, seed: int) -> pd.DataFrame:
        """Return the random values of all runs, shape (count, columns).

        Raises OptionError if the scene does not accept the least or the greatest value of a number.
        """
        probabilities = points(count, len(self.columns), seed)
        columns = zip(self.columns, probabilities.T, strict=True)
        values = pd.DataFrame({column.name: self._laws[column.of].frozen.ppf(p) for column, p in columns})
        for name, law in self._laws.items():
            samples = values[[column.name for column in self.columns if column.of == name]].to_numpy()
            if not np.isfinite(samples).all():
                raise OptionError(
                    f"the distribution {law.text} of '{name}' has infinite or undefined values: use "
                    "another distribution"
                )
            for value in (float(samples.min()), float(samples.max())):
                self._refuse_impossible(name, law, value)
        return values

    def _refuse_impossible(self, name: str, law: Distribution, value: float) -> None:
        """Raise OptionError if a value of a distribution is impossible for the scene."""
        try:
            self._parameters.at({name: value})
        except CaseError as error:
            how = f" ({_share_below_zero(law)} are below 0)" if value < 0 else ""
            raise OptionError(
                f"the distribution {law.text} of '{name}' contains {value:g}{how}, which the scene does not "
                f"accept: {error}; use a distribution without such values, for example a lognormal or a "
                "truncated distribution (scipy.stats.truncnorm)"
            ) from None

    def scene(self, values: Mapping[str, float]) -> Scene:
        """Return the scene with the random values of a run.

        Raises CaseError if the scene does not accept a value.
        """
        of_scene = [column.name for column in self.columns if not column.pairs]
        scene = self._parameters.at({name: values[name] for name in of_scene})
        if not any(column.pairs for column in self.columns):
            return scene
        exceptions = {
            frozenset(joint.between): joint.model_dump(exclude_none=True) for joint in scene.exceptions
        }
        for column in self.columns:
            for pair in column.pairs:
                properties = exceptions.setdefault(frozenset(pair), {"between": pair})
                properties[column.of.removeprefix("joints.")] = values[column.name]
        return scene.replace(exceptions=[Joint(**properties) for properties in exceptions.values()])


def _share_below_zero(law: Distribution) -> str:
    """Return the share of negative values of a distribution as text, such as "0.62 % of the values"."""
    share = float(law.frozen.cdf(0.0))
    return "all values" if share == 1 else f"{rounded_down(100 * share)} % of the values"


def points(count: int, dimensions: int, seed: int) -> np.ndarray:
    """Return random points of the unit cube, shape (count, dimensions).

    In few dimensions the points are a scrambled Sobol sequence, otherwise they are independent. The points of
    a smaller count are the first points of a larger count.
    """
    rng = np.random.default_rng(seed)
    if dimensions > _MOST_SOBOL_DIMENSIONS:
        unit_points = rng.random((count, dimensions))
    else:
        # The number of Sobol points must be a power of two, so the next power of two is generated.
        unit_points = qmc.Sobol(dimensions, seed=rng).random_base2((count - 1).bit_length())[:count]
    return np.clip(unit_points, _LEAST_PROBABILITY, 1 - _LEAST_PROBABILITY)


def _courses(scene: Scene) -> dict[tuple[str, str], int]:
    """Return a dict from the names of two blocks to the number of the course that contains their joint.

    The lowest course has the number 1, and the numbers increase upwards.
    """
    assembly = assemble(scene)
    joints = assembly.joints
    height = pd.Series(joints.middle @ -scene.down).sort_values(kind="stable")
    median_length = 2 * assembly.problem.length_unit
    course = 1 + (height.diff() > _COURSE_TOLERANCE * median_length).cumsum().sort_index()
    pairs = zip(assembly.names(joints.first), assembly.names(joints.second), strict=True)
    course_of_pair: dict[tuple[str, str], int] = {}
    for pair, number in zip(pairs, course, strict=True):
        course_of_pair.setdefault(pair, number)
    return course_of_pair
