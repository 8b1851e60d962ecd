"""Parameters of a scene (the numbers in its case file) by name, and scenes with other values.

A name is the path to a number through the tables of a case file, with dots: ``joints.cohesion``,
``block.A.weight``, ``block.A.live.x``, ``joint.A/B.friction`` (an exception), ``column.left pier.height``,
``edge_load.2.force.y``, ``load_case.storm.live.wind``. A table that occurs once needs no name, and may have
one: ``arch.thickness``, and for a single tie ``tie.strength`` or ``tie.rod.strength``. The numbers of a list
or pair that is not a point are ``.1``, ``.2``, ...: ``column.width.2``, ``axles.bogie.loads.1``. Blocks of a
generator are varied by the parameters of the generator.
"""

from collections.abc import Iterator, Mapping
from typing import Any, get_args

from masonry_opt.errors import CaseError, OptionError, listed
from masonry_opt.scene.blocks import EXCLUSIVE_KEYS, Record
from masonry_opt.scene.case_file import CaseFile
from masonry_opt.scene.keys import SceneKeys
from masonry_opt.scene.mistakes import did_you_mean
from masonry_opt.scene.scene import Scene

_Path = tuple[str | int, ...]  #: Path to a number through nested records, as field names and list indices.
#: Tables whose entries are always named in parameters, as in block.A.weight. In other tables, the entry is
#: named only if the table has several entries.
_ALWAYS_NAMED = ("block", "joint")
_GENERATORS = tuple(name for name in CaseFile.model_fields if name not in SceneKeys.model_fields)
#: Keys of points, forces and moments, whose components are named x, y and z.
_POINTS = {
    *("at", "force", "gravity", "start", "end", "tilt", "weight_at", "dead", "dead_at", "dead_moment"),
    *("live", "live_at", "live_per_weight", "live_moment"),
}
#: Keys of a scene that cannot be varied. Answers change abruptly with the geometric ``tolerance``, which
#: decides whether blocks are in contact. Answers do not depend on the ``reference`` load factors.
_LEFT_OUT = ("tolerance", "reference")
_MOST_LISTED_PARAMETERS = 12  #: Largest number of names that a message lists.


class Parameters:
    """Parameters of a scene by name: all numbers in its case file, including the arguments of generators."""

    def __init__(self, scene: Scene) -> None:
        case = scene.case
        # If a scene was modified after loading, its parameters are read from the scene instead of its case
        # file.
        unchanged = isinstance(case, CaseFile) and case.scene().with_load_case(scene.load_case) == scene
        self.scene = scene
        self._source: Any = case if case and unchanged else scene
        #: Keys and indices that lead to each number of the scene, by the short name that messages show.
        self.names = self._paths()
        #: Keys and indices that lead to each number, by its short name and by its full name. The names differ
        #: if a table has a single entry: ``tie.strength`` is short for ``tie.rod.strength``.
        self._known = self._paths(in_full=True) | self.names
        self._last: tuple[dict[str, float], Scene] = ({}, scene)

    def _paths(self, in_full: bool = False) -> dict[str, _Path]:
        """Return the keys and indices that lead to the number of each parameter, by the parameter's name.

        A scene in space has neither the thickness nor joint strengths as parameters.
        """
        paths = dict(_numbers(self._source, in_full=in_full))
        if self.scene.dimension == 2:
            return paths
        of_plane = {name for name in paths if is_of_joints(name) and name.endswith(".strength")}
        of_plane.add("thickness")
        return {name: path for name, path in paths.items() if name not in of_plane}

    def check_names(self, names: Mapping[str, object]) -> None:
        """Raise OptionError if the parameters with the given names cannot be varied together.

        The error is raised in three cases:

        - The scene has load cases, but none is chosen, and no axles move in a load case.
        - A name is unknown. The message lists similar names.
        - Two names mean the same parameter, or two parameters that exclude each other.
        """
        if not self.scene.moves_axles:
            self.scene.refuse_without_case()
        by_path: dict[_Path, str] = {}
        for name in names:
            if name not in self._known:
                raise OptionError(f"{self.scene.origin}: no parameter is called '{name}'{self._near(name)}")
            first = by_path.setdefault(self._known[name], name)
            if first != name:
                raise OptionError(f"'{first}' and '{name}' are the same parameter: vary only one of them")
            head, _, key = name.rpartition(".")
            excluded = f"{head}.{EXCLUSIVE_KEYS.get(key, '')}"
            if excluded in names:
                raise OptionError(
                    f"'{name}' and '{excluded}' describe the same property: vary only one of them"
                )

    def at(self, values: Mapping[str, float]) -> Scene:
        """Return the scene with new values for some of its parameters.

        Successive scenes share their blocks as long as only properties of joints change. Raises OptionError
        if a name is unknown, and CaseError if the values make no valid scene.
        """
        self.check_names(values)
        of_joints = {name: value for name, value in values.items() if is_of_joints(name)}
        not_of_joints = {name: value for name, value in values.items() if name not in of_joints}
        try:
            if not_of_joints and self._last[0] != not_of_joints:
                source = self._source
                for name, value in not_of_joints.items():
                    source = _changed(source, self._known[name], value)
                self._last = not_of_joints, source.scene() if isinstance(source, CaseFile) else source
            scene = self._last[1] if not_of_joints else self.scene
            for name, value in of_joints.items():
                scene = _changed(scene, self._known[name], value)  # equal paths in scene and case file
        except CaseError as error:
            assignments = ", ".join(f"{name} = {value + 0.0:g}" for name, value in values.items())
            raise CaseError(f"{assignments}: {error}") from None
        return scene.read_from(self.scene.origin).in_case_of(self.scene)

    def _near(self, name: str) -> str:
        """Return advice on the unknown name of a parameter: similar names, or a list of known names.

        If the name belongs to a block that a generator builds, the advice is to vary the generator instead.
        """
        for block in self.scene.blocks:
            head = f"block.{block.name}."
            if name.startswith(head) and not any(known.startswith(head) for known in self.names):
                heads = tuple(f"{table}." for table in _GENERATORS)
                return (
                    f"; block '{block.name}' is built by a generator: vary the parameters of the generator; "
                    f"{self._listed(heads)}"
                )
        return did_you_mean(name, self._known) or "; " + self._listed((f"{name.split('.')[0]}.",))

    def _listed(self, heads: tuple[str, ...]) -> str:
        """Return a text that lists the known names that begin with one of the texts ``heads``.

        If no name begins with any of these texts, all known names are listed. If there are more than
        ``_MOST_LISTED_PARAMETERS`` names, the text lists the first names and states the number of the others.
        """
        names = [name for name in self.names if name.startswith(heads)] or [*self.names]
        return f"there are: {listed(names, _MOST_LISTED_PARAMETERS)}"


def is_of_joints(name: str) -> bool:
    """Return True if a parameter is a property of joints, such as the friction.

    Properties of joints do not change the equilibrium matrix.
    """
    return name.startswith(("joints.", "joint."))


def _numbers(
    record: Record, prefix: str = "", path: _Path = (), in_full: bool = False
) -> Iterator[tuple[str, _Path]]:
    """Iterate over the names and paths of all numbers in a record and its sub-records.

    With ``in_full``, names contain the name of the table's entry even if the table has only one entry.
    """
    for field, about in type(record).model_fields.items():
        if field in _LEFT_OUT:
            continue
        key, value = about.alias or field, getattr(record, field)
        name, field_path = prefix + key, (*path, field)
        if isinstance(value, Record):
            yield from _numbers(value, f"{name}.", field_path, in_full)
        elif isinstance(value, list) and value and all(isinstance(entry, Record) for entry in value):
            yield from _numbers_of_entries(value, key, prefix, field_path, in_full)
        elif _is_number(value) or (value is None and _takes_number(about.annotation)):
            yield name, field_path
        elif isinstance(value, dict) and all(map(_is_number, value.values())):
            yield from ((f"{name}.{entry}", (*field_path, entry)) for entry in value)
        elif isinstance(value, list | tuple) and all(map(_is_number, value)):
            for index in range(len(value)):
                component = "xyz"[index] if field in _POINTS else index + 1
                yield f"{name}.{component}", (*field_path, index)


def _numbers_of_entries(
    entries: list[Record], key: str, prefix: str, path: _Path, in_full: bool
) -> Iterator[tuple[str, _Path]]:
    """Iterate over the names and paths of all numbers in the entries of a table.

    Entries with equal names, such as two ties of one name, are called by their numbers instead.
    """
    alone = len(entries) == 1 and not in_full and key not in _ALWAYS_NAMED
    names = [key if alone else _entry_name(key, index, entry) for index, entry in enumerate(entries)]
    for index, entry in enumerate(entries):
        name = names[index] if names.count(names[index]) == 1 else f"{key}.{index + 1}"
        yield from _numbers(entry, f"{prefix}{name}.", (*path, index), in_full)


def _entry_name(key: str, index: int, entry: Record) -> str:
    """Return the name of an entry of a table, such as "block.A" or "joint.A/B"."""
    name = getattr(entry, "name", None) or getattr(entry, "between", None) or str(index + 1)
    return f"{key}.{name if isinstance(name, str) else '/'.join(name)}"


def _is_number(value: object) -> bool:
    """Return True for an int or a float, but not for a bool."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _takes_number(annotation: Any) -> bool:
    """Return True if a field of this type accepts a number.

    A field for a pair of numbers does not accept a single number, because the second number would be unknown.
    """
    pair = getattr(annotation, "__origin__", None) in (tuple, list)
    return not pair and (annotation in (int, float) or any(map(_takes_number, get_args(annotation))))


def _changed(holder: Any, path: _Path, value: float) -> Any:
    """Return a copy of a record, table, list or pair with a new number at a path, and validate the copy."""
    if not path:
        # A number that is an integer in the scene stays an integer.
        return int(value) if isinstance(holder, int) and float(value).is_integer() else float(value)
    first, remainder = path[0], path[1:]
    if isinstance(first, int):
        entries = [*holder]
        entries[first] = _changed(entries[first], remainder, value)
        return type(holder)(entries)
    if isinstance(holder, dict):
        return holder | {first: _changed(holder[first], remainder, value)}
    return holder.replace(**{first: _changed(getattr(holder, first), remainder, value)})
