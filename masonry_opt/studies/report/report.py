"""``report``: answers with their inputs, what was checked and what was not, as one page that prints whole."""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import date
from functools import singledispatch
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar

from masonry_opt.answer.acceptance import LIMITS
from masonry_opt.answer.motion import joint_motion
from masonry_opt.answer.thresholds import IDLE
from masonry_opt.drawing.elements import counts, title_of
from masonry_opt.drawing.figure import Picture, is_page
from masonry_opt.drawing.forces import round_below
from masonry_opt.drawing.marks import movable_box
from masonry_opt.drawing.page import MOST_BLOCKS
from masonry_opt.drawing.pictures import result_picture, scene_picture
from masonry_opt.errors import OptionError, counted, printable
from masonry_opt.files import refuse_unwritable, write_whole
from masonry_opt.finite_motion.capacity import Capacity
from masonry_opt.problem.assembly import Assembly
from masonry_opt.result import Result
from masonry_opt.scene.blocks import Record
from masonry_opt.scene.case_file import toml_text
from masonry_opt.scene.road import Axles
from masonry_opt.scene.scene import Scene
from masonry_opt.studies.crossing.answer import Crossing
from masonry_opt.studies.load_cases.cases import Cases, Directions
from masonry_opt.studies.settle.answer import KIND_NAMES, Settlement
from masonry_opt.studies.writing import frame_table, render, table, versions
from masonry_opt.words.load_factors import certainty, known_least, named_factor
from masonry_opt.words.page import RESIDUALS
from masonry_opt.words.page import answer as in_full
from masonry_opt.words.sentences import numeral

Answer = Result | Crossing | Cases | Settlement | Capacity  #: What can be reported.
_NAMED = 60  #: Blocks whose names are written into the drawing, at most.
_BELOW = 0.08  #: Height below a drawing for its scale bar, over its width.
_ROWS, _LINES = 150, 600  #: Rows of a table, and lines of a case, that are printed at most.
#: Lists of a scene's records, by what their tables are headed.
_RECORDS = {"Joints that differ": "exceptions", "Fill": "fills", "Loads on blocks": "loads"}
_RECORDS |= {"Loads along edges": "edge_loads", "Ties": "ties", "Props": "props", "Load cases": "load_cases"}
#: Columns of the table of joints, in the plane and in space.
_JOINTS = ("first", "second", "x", "y", "z", "length", "area", "n", "s", "m", "e", "torsion", "utilisation")
_DOES = ("slides", "hinges", "separates", "crushes")  #: What joints do.
_LIST = re.compile(r"\[\n\s*([^][{}]*?),?\n\s*\]")  #: An innermost list of TOML, written over several lines.


@dataclass(frozen=True, kw_only=True)
class Part:
    """What an answer puts on the page."""

    heading: str  #: what it is of
    says: str  #: the answer in a line
    assembly: Assembly  #: of the scene as that was given
    told: Mapping[str, Result] = field(default_factory=dict)  #: told in full, by what they are
    others: Mapping[str, Result] = field(default_factory=dict)  #: results that are not
    facts: Mapping[str, str] = field(default_factory=dict)  #: of the answer itself, as the next two
    pictures: Mapping[str, Picture] = field(default_factory=dict)
    tables: Mapping[str, dict[str, Any]] = field(default_factory=dict)
    axles: Sequence[Axles] = ()  #: groups that crossed
    left_open: Sequence[str] = ()  #: what this answer alone leaves open
    left_out: Mapping[str, str] = field(default_factory=dict)  #: load cases without an answer, and why
    crossed: Collection[str] = ()  #: load cases in which axles crossed
    followed: bool = False  #: whether a mechanism was, beyond its onset
    pushed: bool = True  #: whether live loads play a part, so that results are load factors
    varied: Collection[str] = ()  #: keys of the scene that the answer's own scene has otherwise


def report(
    answer: Answer | Sequence[Answer], path: str | Path, *, units: str | None = None, force: bool = False
) -> None:
    """Write answers as one page (.html) for the file, whole or not at all.

    It has the answer, what was checked and what was not, the inputs, a drawing of the scene with a scale bar
    (in space axes), results by load case and position, mechanism and thrust, the case, versions and date. It
    needs no network, and prints whole on A4; browsers write it as PDF.

    Raises OptionError if there is no such answer, answers are of different scenes, units are not two names,
    the name does not end in .html, the file cannot be written or replaced, or Jinja2, of the extra "studies",
    is not installed; OSError if the file cannot be written.

    Parameters
    ----------
    answer: of ``solve``, ``crossing``, ``solve_cases``, ``directions``, ``settle`` or ``capacity``, or
        several of these about one scene, of equal content.
    path: of the page.
    units: of length and force, as in "m, kN", which case files do not say (default: not named).
    force: whether to replace a file that was not written here.
    """
    refuse_report(path, units, force)
    parts = [_part(one) for one in (answer if isinstance(answer, list | tuple) else [answer])]
    varied = {key for part in parts for key in part.varied}  # beside which all scenes must be alike
    scenes = [part.assembly.scene for part in parts]
    contents = [scene.model_dump(exclude=varied) for scene in scenes]
    if not scenes or any(content != contents[0] for content in contents):
        called = ", ".join(dict.fromkeys(scene.called for scene in scenes))
        found = f"{called}, of different content" if scenes else "none"
        raise OptionError(f"a report is of answers about one scene (found {found})")
    every, told = [part.heading for part in parts], []
    for number, part in enumerate(parts, start=1):
        # Headings that repeat get numbers.
        again = f" ({every[:number].count(part.heading)})" if every.count(part.heading) > 1 else ""
        told.append(replace(part, heading=part.heading + again))
    write_whole(path, _page(told, _units(units)))


def refuse_report(path: str | Path, units: str | None = None, force: bool = False) -> None:
    """Raise OptionError if a report could not be written so: to be asked before long work."""
    if not isinstance(path, str | Path):
        raise OptionError(f"the path of a file is text or a pathlib.Path (found {path!r})")
    if not is_page(path):
        raise OptionError(f"{path}: a report's name ends in .html; browsers print it as PDF")
    _units(units)
    refuse_unwritable(Path(path), force)


def _units(units: str | None) -> dict[str, str]:
    """By "length" and "force"; "" where they are not known."""
    if units is None:
        return {"length": "", "force": ""}
    named = [one.strip() for one in units.split(",")] if isinstance(units, str) else []
    if len(named) != 2 or not all(named):
        raise OptionError(f"units are those of length and force, as in 'm, kN' (found {units!r})")
    return dict(zip(("length", "force"), named, strict=True))


@singledispatch
def _part(answer: object) -> Part:
    studies = "solve, crossing, solve_cases, directions, settle or capacity"
    raise OptionError(f"a report is of what {studies} found (found {type(answer).__name__})")


@_part.register
def _(answer: Result) -> Part:
    heading, told = _of_case("Collapse", answer), {f"method {answer.method}": answer}
    return Part(heading=heading, says=named_factor(answer), assembly=answer.assembly, told=told)


@_part.register
def _(answer: Crossing) -> Part:
    worst, least = answer.worst, answer.least
    missed = [f"Load case '{name}': axles did not cross in it." for name in answer.not_crossed]
    left_out = dict.fromkeys(answer.left_out, "it leaves axles out, and only solve answers it")
    if least is None:  # the axles are loads of its scene
        varied = ("axles", "loads", "load_cases")
        return replace(_part(worst), varied=varied, left_open=missed, left_out=left_out)
    known, every = answer.facts(), len(answer.by_case) > 1 and not missed
    axles = {one.passage.axles.name: one.passage.axles for one in answer.passages}
    named = f"Axles {', '.join(map(repr, axles))}"
    governs = f"; '{worst.load_case}' governs" if every else ""
    open_ = f"Positions between those solved ({known['solved']}): λ may be less there."
    return Part(
        heading=f"{named}, every load case" if every else _of_case(named, worst),
        says=f"governing {named_factor(worst)}: {known['axles']}, {known['at']}{governs}",
        assembly=least.passage.assembly,
        told={f"worst position, method {worst.method}": worst},
        facts=known,
        pictures=answer.pictures(),
        tables=answer.page_tables(),
        axles=list(axles.values()),
        varied=("axles",),
        left_open=[*([open_] if answer.bound is None else []), *missed],
        left_out=left_out,
        crossed=[one.passage.case for one in answer.passages if one.passage.case],
    )


@_part.register
def _(answer: Cases) -> Part:
    found, what, shaken = answer.to_draw, answer.what, isinstance(answer, Directions)
    sure = [certainty(result) or result.message for result in answer.results.values()]
    rows = answer.table.assign(sure=sure).drop(columns="exact")
    governs = f"'{answer.governing}' governs" if answer.governing else "none governs"
    return Part(
        heading=_of_case("Earthquakes", found) if shaken else "Load cases",
        says=f"{named_factor(found)}: {governs} of {counted(len(answer.results), what)}",
        assembly=found.assembly,
        told={answer.governing or next(iter(answer.results)): found},
        others=answer.results,
        pictures={f"λ by {what}": answer.plot()},
        tables={f"Every {what} ({len(rows)})": frame_table(rows, load_case="load case", sure="certainty")},
        left_out=dict.fromkeys(answer.left_out, "its axles move, and only a crossing answers it"),
        varied=("earthquake",) if shaken else (),
    )


@_part.register
def _(answer: Settlement) -> Part:
    known = answer.facts()
    results = {
        f"{name} reaction, {KIND_NAMES[kind]}": result
        for name, end in answer.ends.items()
        for kind, result in end.results.items()
    }
    said = [f"{end} reaction {known[end].splitlines()[0].partition(';')[0]}" for end in answer.ends]
    return Part(
        heading=f"Settlement, {known['settles']}",
        says="; ".join(said) or known["reaction"],
        assembly=answer.assembly,
        told={"how it falls": answer.fallen} if answer.fallen else {},
        others=results,
        facts=known,
        pictures=answer.pictures() if answer.ends else {},
        tables=answer.page_tables(),
        pushed=False,
    )


@_part.register
def _(answer: Capacity) -> Part:
    return Part(
        heading=_of_case("After the onset", answer.result),
        says=f"{named_factor(answer.result)} at the onset; {answer.message}",
        assembly=answer.result.assembly,
        told={f"onset, method {answer.result.method}": answer.result},
        facts=answer.facts(),
        pictures={"λ over displacement": answer.plot(), "Blocks at its end, to scale": answer.plot(-1)},
        tables={f"Every state ({len(answer.table)})": frame_table(answer.table.drop(columns="pairs"))},
        left_open=[] if answer.reaches_zero else ["What comes after the curve's end."],
        followed=True,
    )


def _of_case(heading: str, result: Result) -> str:
    return heading if result.load_case is None else f"{heading}, load case '{result.load_case}'"


def _page(parts: Sequence[Part], units: dict[str, str]) -> str:
    assembly = parts[0].assembly
    scene, problem = assembly.scene, assembly.problem
    axles = [group for part in parts for group in part.axles] or scene.axles
    if not units["length"] and any(group.set for group in axles):
        units = _units("m, kN")  # which common sets are in
    every = [
        (part, f"{part.heading}: {name}" if len(parts) > 1 else name, of)
        for part in parts
        for name, of in {**part.told, **part.others}.items()
    ]
    results = {name: of for _, name, of in every}
    factors = {name: of for part, name, of in every if part.pushed and of.load_factor is not None}
    proven = {name: known_least(of) for name, of in factors.items()}
    pushed = any(part.pushed for part in parts)
    loads = {"dead": _resultant(assembly, problem.dead)}
    loads |= {"live": _resultant(assembly, problem.live)} if pushed else {}
    found = {name: of for name, of in results.items() if of.certificate is not None}
    low, high = movable_box(assembly)
    records = {heading: getattr(scene, name) for heading, name in _RECORDS.items()} | {"Axles": axles}
    given_in = {"scene": scene, "problem": problem, "units": units, "loads": loads, "axles": axles}
    answers = {"parts": parts, "results": results, "proven": proven, "pushed": pushed}
    makers = {"pictures_of": _pictures, "tables_of": _of_result, "in_full": in_full, "printable": printable}
    return render(
        "report.html",
        **given_in | answers | makers,
        title=title_of(scene.with_load_case(None)),
        day=date.today().isoformat(),
        versions=versions(),
        drawn_as="png" if len(scene.blocks) > MOST_BLOCKS else "svg",
        angle=lambda tangent: np.degrees(np.arctan(tangent)),
        residuals=table(["answer", *RESIDUALS], [[name, *_residuals(of)] for name, of in found.items()]),
        meaning=RESIDUALS,
        stands=found,
        unproven={name: certainty(of) for name, of in factors.items() if not proven[name]},
        solved={of.load_case for of in results.values()} | {name for part in parts for name in part.crossed},
        counts=counts(assembly),
        size=" × ".join(numeral(side, ".5g") for side in (high - low).tolist()),
        given={_counted(heading, of): _of_records(of[:_ROWS]) for heading, of in records.items() if of},
        drawing=_drawing(assembly, units["length"] or "units"),
        case=_case_text(scene),
    )


def _residuals(result: Result) -> list[str]:
    """Residuals of a certified answer, with what they may be at most."""
    limits = LIMITS[result.kind].as_dict()
    found = result.certificate.as_dict() if result.certificate else {}
    return [f"{numeral(value, '.1e')} ≤ {limits[of]:g}" for of, value in found.items()]


def _resultant(assembly: Assembly, load: np.ndarray) -> list[str]:
    """Sum of the forces of a load; none where it has no forces."""
    problem = assembly.problem
    total, size = problem.forces(load).sum(axis=0), float(problem.force_sizes(load).sum())
    total = np.where(np.abs(total) > 1e-9 * size, total, 0.0) * problem.force_unit
    return [f"{part:.5g}" for part in total] if size else []


def _pictures(result: Result) -> dict[str, Picture]:
    drawn = {"Mechanism": result_picture(result)}
    if result.joints["n"].notna().all():
        drawn["Thrust"] = result_picture(result, "thrust")
    if result.curve is not None and not result.curve.empty:
        drawn["λ over displacement"] = result_picture(result, "curve")
    return drawn


def _drawing(assembly: Assembly, length: str) -> Picture:
    """The scene before it is solved, with a scale bar below; in space, with the axes that solids have."""
    made = scene_picture(assembly, names=len(assembly.scene.blocks) <= _NAMED)
    if assembly.scene.dimension == 3:
        return made
    axes = made.axes[0]
    wide = float(np.ptp(axes.get_xlim()))
    axes.set_ylim(bottom=axes.get_ylim()[0] - _BELOW * wide)
    bar = round_below(wide / 4)
    scale = AnchoredSizeBar(axes.transData, bar, printable(f"{bar:g} {length}"), "lower right", pad=0.3)
    scale.set_zorder(10)
    axes.add_artist(scale)
    return made


def _counted(heading: str, rows: Sequence[object] | pd.DataFrame) -> str:
    count = len(rows)
    return f"{heading} ({count if count <= _ROWS else f'{_ROWS} of {count}'})"


def _of_records(records: Sequence[Record]) -> dict[str, Any]:
    rows = pd.DataFrame([one.model_dump(exclude_defaults=True) for one in records], dtype=object)
    return frame_table(rows.where(rows.notna(), "").map(_said))


def _said(value: object) -> str:
    """A value of a record as a cell."""
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_said(one)}" for key, one in value.items())
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_said, value))}]"
    return f"{value:.6g}" if isinstance(value, float) else printable(str(value))


def _case_text(scene: Scene) -> str:
    """Content of the scene's case file, generators not expanded; "" where that is too long to print."""
    text = toml_text(scene.case or scene)
    while (joined := _LIST.sub(lambda found: f"[{' '.join(found[1].split())}]", text)) != text:
        text = joined
    return text if text.count("\n") <= _LINES else ""


def _of_result(result: Result) -> dict[str, dict[str, Any]]:
    """Joints, ties and pressures of fill as tables of a page by their headings."""
    frames, pressures = {"Joints": _joints(result)}, result.pressures.drop(columns=["kind", "second"])
    for name, limited in (("Ties and props", result.ties), ("Pressure of fill", pressures)):
        told = limited.assign(yields=limited["yields"].map({True: "yes", False: "no"}))
        frames[name] = told.drop(columns="lengthens").dropna(axis=1, how="all")
    kept = {name: frame for name, frame in frames.items() if len(frame)}
    return {_counted(name, frame): frame_table(frame.head(_ROWS)) for name, frame in kept.items()}


def _joints(result: Result) -> pd.DataFrame:
    """Forces on joints, and how these move, the most used first where not all are printed."""
    frame = result.joints.copy()
    if "m" in frame:
        pressed = frame["n"] > IDLE * frame["n"].abs().max()
        frame["e"] = (frame["m"] / frame["n"]).where(pressed)
    frame = frame.reindex(columns=_JOINTS).dropna(axis=1, how="all")
    numbers = frame.select_dtypes("number")
    frame = frame.assign(**numbers.mask(numbers.abs() <= IDLE * numbers.abs().max(), 0.0))
    if result.solution.d is not None:
        motion = joint_motion(result.assembly, result.solution)
        does = zip(*(getattr(motion, word) for word in _DOES), strict=True)
        frame["moves"] = [", ".join(compress(_DOES, which)) for which in does]
    if len(frame) > _ROWS and "utilisation" in frame:
        frame = frame.sort_values("utilisation", ascending=False, kind="stable")
    return frame
