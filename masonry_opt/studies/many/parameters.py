"""Numbers of a scene by name, and the scene with other values of them.

A name is the path to a number through the tables of a case file, with dots: ``joints.cohesion``,
``block.A.weight``, ``block.A.live.x``, ``joint.A/B.friction`` (an exception), ``column.left pier.height``,
``edge_load.2.force.y``, ``load_case.storm.live.wind``. A table that occurs once needs no name, and may have
one: ``arch.thickness``, and for a single tie ``tie.strength`` or ``tie.rod.strength``. The numbers of a pair
that is not a point are ``.1`` and ``.2``: ``column.width.2``.
Blocks of a generator are varied by the numbers of the generator.
"""

from collections.abc import Iterator, Mapping
from typing import Any, get_args

from masonry_opt.errors import CaseError, OptionError
from masonry_opt.scene.blocks import INSTEAD, Record
from masonry_opt.scene.case_file import CaseFile
from masonry_opt.scene.keys import SceneKeys
from masonry_opt.scene.mistakes import did_you_mean
from masonry_opt.scene.scene import Scene

_Way = tuple[str | int, ...]  #: A path through records: names of fields, and indices of entries.
_NAMED = ("block", "joint")  #: Tables whose entries are always named; of others where there are several.
_GENERATORS = tuple(name for name in CaseFile.model_fields if name not in SceneKeys.model_fields)
#: Points, forces and moments: their two or three numbers are x, y and z.
_POINTS = {"at", "force", "gravity", "start", "end", "tilt", "weight_at", "dead", "dead_at", "dead_moment"}
_POINTS |= {"live", "live_at", "live_per_weight", "live_moment"}
_LEFT_OUT = ("tolerance", "reference")  #: Keys of a scene that no analysis follows steadily.
_LISTED = 12  #: Names that a message lists.


class Parameters:
    """The numbers of a scene, by name; of a scene read from a case file those of its generators too."""

    def __init__(self, scene: Scene) -> None:
        case = scene.case
        # A changed copy of a scene differs from its file.
        unchanged = isinstance(case, CaseFile) and case.scene().with_load_case(scene.load_case) == scene
        self.scene = scene
        self._source: Any = case if case and unchanged else scene
        self.names = self._paths()  #: Paths to the numbers, by name, as messages list them.
        #: Paths by the listed names, and by the full names of numbers in tables that occur once.
        self._known = self._paths(in_full=True) | self.names
        self._last: tuple[dict[str, float], Scene] = ({}, scene)

    def _paths(self, in_full: bool = False) -> dict[str, _Way]:
        """Return the paths to the numbers by name, without numbers that no scene in space has."""
        found = dict(_numbers(self._source, in_full=in_full))
        if self.scene.dimension == 2:
            return found
        of_plane = {name for name in found if is_of_joints(name) and name.endswith(".strength")} | {
            "thickness"
        }
        return {name: way for name, way in found.items() if name not in of_plane}

    def check_names(self, names: Mapping[str, object]) -> None:
        """Raise OptionError for names that are no numbers of the scene, or not two numbers.

        - The scene has load cases and is in none of them.
        - A name is unknown: the message lists names like it.
        - Two names are of one number, or of two numbers that exclude each other.
        """
        self.scene.refuse_without_case()
        by_path: dict[_Way, str] = {}
        for name in names:
            if name not in self._known:
                raise OptionError(f"{self.scene.origin}: no number is called '{name}'{self._near(name)}")
            first = by_path.setdefault(self._known[name], name)
            if first != name:
                raise OptionError(f"'{first}' and '{name}' are one number: vary one of them")
            head, _, key = name.rpartition(".")
            other = f"{head}.{INSTEAD.get(key, '')}"
            if other in names:
                raise OptionError(f"'{name}' and '{other}' say the same of one thing: vary one of them")

    def at(self, values: Mapping[str, float]) -> Scene:
        """The scene with other values of its numbers; the blocks are the same objects as long as joint
        properties alone change. Raises OptionError if a name is unknown, CaseError if it is no scene."""
        self.check_names(values)
        of_joints = {name: value for name, value in values.items() if is_of_joints(name)}
        others = {name: value for name, value in values.items() if name not in of_joints}
        try:
            if others and self._last[0] != others:
                source = self._source
                for name, value in others.items():
                    source = _changed(source, self._known[name], value)
                self._last = others, source.scene() if isinstance(source, CaseFile) else source
            scene = self._last[1] if others else self.scene
            for name, value in of_joints.items():
                scene = _changed(scene, self._known[name], value)  # of a file's scene by the same path
        except CaseError as error:
            told = ", ".join(f"{name} = {value + 0.0:g}" for name, value in values.items())
            raise CaseError(f"{told}: {error}") from None
        return scene.read_from(self.scene.origin).in_case_of(self.scene)

    def _near(self, name: str) -> str:
        """Advice on an unknown name."""
        for block in self.scene.blocks:
            own = f"block.{block.name}."
            if name.startswith(own) and not any(known.startswith(own) for known in self.names):
                heads = tuple(f"{table}." for table in _GENERATORS)
                return f"; block '{block.name}' is built by a generator; {self._listed(heads)}"
        return did_you_mean(name, self.names) or "; " + self._listed((f"{name.split('.')[0]}.",))

    def _listed(self, heads: tuple[str, ...]) -> str:
        """The first names that begin so, or the first of all if none do."""
        found = [name for name in self.names if name.startswith(heads)] or [*self.names]
        more = f", ... ({len(found)} in all)" if len(found) > _LISTED else ""
        return f"there are: {', '.join(found[:_LISTED])}{more}"


def is_of_joints(name: str) -> bool:
    """Whether a number is a property of joints, which changes no matrix."""
    return name.startswith(("joints.", "joint."))


def _numbers(
    record: Record, prefix: str = "", way: _Way = (), in_full: bool = False
) -> Iterator[tuple[str, _Way]]:
    """Yield the names of the numbers of a record and of the records in it, with the paths to them.

    ``in_full``: names of tables that occur once have the name of their entry too.
    """
    for field, about in type(record).model_fields.items():
        if field in _LEFT_OUT:
            continue
        key, value, here = about.alias or field, getattr(record, field), (*way, field)
        if isinstance(value, Record):
            yield from _numbers(value, f"{prefix}{key}.", here, in_full)
        elif isinstance(value, list) and value and all(isinstance(entry, Record) for entry in value):
            alone = len(value) == 1 and not in_full and key not in _NAMED
            names = [key if alone else _entry_name(key, number, entry) for number, entry in enumerate(value)]
            for number, entry in enumerate(value):
                # Two ties of one name are told apart by their numbers.
                name = names[number] if names.count(names[number]) == 1 else f"{key}.{number + 1}"
                yield from _numbers(entry, f"{prefix}{name}.", (*here, number), in_full)
        elif _is_number(value) or (value is None and _takes_number(about.annotation)):
            yield prefix + key, here
        elif isinstance(value, dict) and all(map(_is_number, value.values())):
            for name in value:
                yield f"{prefix}{key}.{name}", (*here, name)
        elif isinstance(value, tuple) and all(map(_is_number, value)):
            for number, place in enumerate(("xyz" if field in _POINTS else "123")[: len(value)]):
                yield f"{prefix}{key}.{place}", (*here, number)


def _entry_name(key: str, number: int, entry: Record) -> str:
    name = getattr(entry, "name", None) or getattr(entry, "between", None) or str(number + 1)
    return f"{key}.{name if isinstance(name, str) else '/'.join(name)}"


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _takes_number(annotation: Any) -> bool:
    # One number of a pair that is not given would leave the other unknown.
    pair = getattr(annotation, "__origin__", None) in (tuple, list)
    return not pair and (annotation in (int, float) or any(map(_takes_number, get_args(annotation))))


def _changed(holder: Any, way: _Way, value: float) -> Any:
    """A record, table, list or pair with another number, validated."""
    if not way:
        # A whole number stays whole where the scene has a whole one.
        return int(value) if isinstance(holder, int) and float(value).is_integer() else float(value)
    first, rest = way[0], way[1:]
    if isinstance(first, int):
        numbered = enumerate(holder)
        return type(holder)(_changed(of, rest, value) if number == first else of for number, of in numbered)
    if isinstance(holder, dict):
        return holder | {first: _changed(holder[first], rest, value)}
    return holder.replace(**{first: _changed(getattr(holder, first), rest, value)})
