"""Function ``report``: answers on one page that prints completely, with inputs, checks and omissions.

Each kind of answer becomes a ``ReportPart`` of the page; the template ``report.html`` arranges the parts.
"""

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

from masonry_opt.drawing.elements import counts, title_of
from masonry_opt.drawing.figure import Picture, is_page
from masonry_opt.drawing.forces import round_below
from masonry_opt.drawing.marks import movable_box
from masonry_opt.drawing.page import MOST_BLOCKS_DRAWN
from masonry_opt.drawing.pictures import result_picture, scene_picture
from masonry_opt.errors import OptionError, counted, printable
from masonry_opt.files import refuse_unwritable, write_whole
from masonry_opt.finite_motion.capacity import Capacity
from masonry_opt.finite_motion.kinematic_check import activation
from masonry_opt.problem.assembly import Assembly
from masonry_opt.reporting.load_factors import certainty, known_least, named_factor
from masonry_opt.reporting.names import FORCE_UNIT
from masonry_opt.reporting.page import RESIDUAL_MEANINGS
from masonry_opt.reporting.page import answer as in_full
from masonry_opt.reporting.sentences import numeral
from masonry_opt.reporting.stability import answer_line
from masonry_opt.result import Result
from masonry_opt.scene.blocks import Record
from masonry_opt.scene.case_file import toml_text
from masonry_opt.scene.mistakes import suggests_arguments
from masonry_opt.scene.road import Axles
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.acceptance import LIMITS
from masonry_opt.solution.motion import joint_motion
from masonry_opt.solution.thresholds import NEGLIGIBLE_SHARE
from masonry_opt.studies.crossing.answer import Crossing
from masonry_opt.studies.load_cases.cases import Cases, Directions
from masonry_opt.studies.settle.answer import Settlement
from masonry_opt.studies.settle.bound import KIND_NAMES
from masonry_opt.studies.writing import frame_table, render, table, versions

Answer = Result | Crossing | Cases | Settlement | Capacity  #: Answers that a report can contain.
#: Largest number of blocks of a scene whose drawing shows the names of the blocks. Drawings of scenes with
#: more blocks have no names.
_MOST_NAMED_BLOCKS = 60
_SCALE_BAR_HEIGHT = 0.08  #: Height of the strip for the scale bar, relative to the width of the drawing.
_MOST_ROWS = 150  #: A report prints at most this many rows of a table, and leaves out all other rows.
#: Largest number of lines of a printed case file. A report omits a case file that has more lines.
_MOST_CASE_FILE_LINES = 600
#: Map from the heading of a table in a report to the scene's attribute whose records the table lists, such as
#: loads and ties.
_RECORDS = {
    "Joints that differ": "exceptions",
    "Fill": "fills",
    "Loads on blocks": "loads",
    "Loads along edges": "edge_loads",
    "Ties": "ties",
    "Props": "props",
    "Load cases": "load_cases",
}
#: Columns of the table of joints. Columns without any value, such as ``torsion`` in the plane, are omitted.
_JOINTS = ("first", "second", "x", "y", "z", "length", "area", "n", "s", "m", "e", "torsion", "utilisation")
#: Item in the list "What was not checked" of a report on a stable scene without live load.
_LEFT_OPEN_WITHOUT_LIVE_LOAD = (
    "Loads other than the dead load: the scene is stable under its dead load, but its safety against wind, "
    "impact, settlement and people is not known."
)
_MOTIONS = ("slides", "hinges", "separates", "crushes")  #: Motions of joints in a mechanism.


@dataclass(frozen=True, kw_only=True)
class ReportPart:
    """Contents of the part of a report that presents one answer."""

    heading: str  #: heading of the part in the report
    says: str  #: the answer in one line
    assembly: Assembly  #: assembly of the user's scene
    #: Results that the report prints in full, by the heading of the result.
    printed_in_full: Mapping[str, Result] = field(default_factory=dict)
    #: Further results, by name.
    further_results: Mapping[str, Result] = field(default_factory=dict)
    #: Facts about the answer: the text of each fact, by its label.
    facts: Mapping[str, str] = field(default_factory=dict)
    #: Pictures of the answer, by caption.
    pictures: Mapping[str, Picture] = field(default_factory=dict)
    #: Tables of the answer, by heading.
    tables: Mapping[str, dict[str, Any]] = field(default_factory=dict)
    axles: Sequence[Axles] = ()  #: groups of axles that crossed
    #: Sentences that say what was not checked, such as the positions of axles that were not solved.
    left_open: Sequence[str] = ()
    left_out: Mapping[str, str] = field(default_factory=dict)  #: load cases without an answer, and the reason
    crossed: Collection[str] = ()  #: load cases in which axles crossed
    followed: bool = False  #: True if a mechanism was followed over finite displacements
    pushed: bool = True  #: True if live loads are multiplied by the load factors of the answer
    #: Keys of a scene whose values may differ between the scene of the answer and the user's scene.
    varied: Collection[str] = ()


@suggests_arguments
def report(
    answer: Answer | Sequence[Answer], path: str | Path, *, units: str | None = None, force: bool = False
) -> None:
    """Write answers about a scene as one HTML page.

    The page has the answer, what was checked and what was not, the inputs, a drawing of the scene with a
    scale bar (in space with axes), results by load case and position, mechanism and thrust, the case file,
    versions and date. The page works offline and prints completely on A4; browsers save it as PDF. The file
    is written completely or not at all.

    Parameters
    ----------
    answer: answer of ``solve``, ``crossing``, ``solve_cases``, ``directions``, ``settle`` or ``capacity``, or
        a list of answers about equal scenes.
    path: file of the page.
    units: names of the units of length and force, as in "m, kN"; case files do not name them.
    force: True to replace a file of another program.

    Raises
    ------
    OptionError
        If an argument is no answer; if answers are about different scenes; if units are not two names; if
        the name of the file does not end in .html; if the file cannot be written or replaced; if Jinja2, of
        the extra "studies", is not installed.
    OSError
        If the file cannot be written.
    """
    refuse_report(path, units, force)
    parts = [_part(item) for item in (answer if isinstance(answer, list | tuple) else [answer])]
    # All answers must be about one scene, except for the values of these keys.
    varied = {key for part in parts for key in part.varied}
    scenes = [part.assembly.scene for part in parts]
    contents = [scene.model_dump(exclude=varied) for scene in scenes]
    if not scenes or any(content != contents[0] for content in contents):
        called = ", ".join(dict.fromkeys(scene.called for scene in scenes))
        actual = f"{called}, of different content" if scenes else "none"
        raise OptionError(f"a report needs answers about one scene (found {actual})")
    write_whole(path, _page(_with_distinct_headings(parts), _units(units)))


def _with_distinct_headings(parts: Sequence[ReportPart]) -> list[ReportPart]:
    """Return the parts of a report; headings that occur more than once are numbered."""
    headings, numbered = [part.heading for part in parts], []
    for count, part in enumerate(parts, start=1):
        occurs_again = headings.count(part.heading) > 1
        number = f" ({headings[:count].count(part.heading)})" if occurs_again else ""
        numbered.append(replace(part, heading=part.heading + number))
    return numbered


def refuse_report(path: str | Path, units: str | None = None, force: bool = False) -> None:
    """Raise OptionError if a report cannot be written to a file; call this before a long computation."""
    if not isinstance(path, str | Path):
        raise OptionError(f"the path of a file must be text or a pathlib.Path (found {path!r})")
    if not is_page(path):
        raise OptionError(
            f"{path}: the file of a report must end in .html (browsers can print the page as PDF)"
        )
    _units(units)
    refuse_unwritable(Path(path), force)


def _units(units: str | None) -> dict[str, str]:
    """Return the names of the units, with the keys "length" and "force"; empty texts if no names are set."""
    if units is None:
        return {"length": "", "force": ""}
    names = [name.strip() for name in units.split(",")] if isinstance(units, str) else []
    if len(names) != 2 or not all(names):
        raise OptionError(f"units must name length and force, as in 'm, kN' (found {units!r})")
    return dict(zip(("length", "force"), names, strict=True))


@singledispatch
def _part(answer: object) -> ReportPart:
    """Return the part of a report that presents an answer.

    Raises OptionError if the argument is not an answer.
    """
    raise OptionError(
        "a report needs answers of solve, crossing, solve_cases, directions, settle or capacity (found "
        f"{type(answer).__name__})"
    )


@_part.register
def _(answer: Result) -> ReportPart:
    is_question = not answer.assembly.problem.live_norm
    activated = activation(answer)
    return ReportPart(
        heading="Stability" if is_question else _of_case("Collapse", answer),
        says=answer_line(answer) if is_question else named_factor(answer),
        assembly=answer.assembly,
        printed_in_full={f"method {answer.method}": answer},
        left_open=[_LEFT_OPEN_WITHOUT_LIVE_LOAD] if answer.stability else [],
        pushed=not is_question,
        facts={} if activated is None else {"earthquake": str(activated)},
    )


@_part.register
def _(answer: Crossing) -> ReportPart:
    worst, least = answer.worst, answer.least
    left_open = [
        f"Load case '{name}': no result, because the axles were not moved over the road."
        for name in answer.not_crossed
    ]
    left_out = dict.fromkeys(answer.left_out, "this load case has no axles: use 'solve'")
    # The axles were not moved, because the scene is not known to be stable under its dead load.
    if least is None:
        # In the scene of the result, loads on blocks replace the axles. Three keys may therefore have other
        # values than in the user's scene.
        varied = ("axles", "loads", "load_cases")
        return replace(_part(worst), varied=varied, left_open=left_open, left_out=left_out)
    facts, all_cases = answer.facts(), len(answer.by_case) > 1 and not left_open
    axles = {trials.passage.axles.name: trials.passage.axles for trials in answer.passages}
    subject = f"Axles {', '.join(map(repr, axles))}"
    verdict = [facts["required"]] if answer.required_factor is not None else []
    governs = f"; '{worst.load_case}' governs" if all_cases else ""
    if answer.bound is None:
        between = f"λ may be less between the solved positions ({facts['solved']})."
        left_open = [between, *left_open]
    return ReportPart(
        heading=f"{subject}, every load case" if all_cases else _of_case(subject, worst),
        says="; ".join([f"{_governing(answer)}: {facts['axles']}, {facts['position']}{governs}", *verdict]),
        assembly=least.passage.assembly,
        printed_in_full={f"worst position, method {worst.method}": worst},
        facts=facts,
        pictures=answer.pictures(),
        tables=answer.page_tables(),
        axles=list(axles.values()),
        varied=("axles",),
        left_open=left_open,
        left_out=left_out,
        crossed=[trials.passage.case for trials in answer.passages if trials.passage.case],
    )


@_part.register
def _(answer: Cases) -> ReportPart:
    drawn, kind, are_earthquakes = answer.to_draw, answer.what, isinstance(answer, Directions)
    certainties = [certainty(result) or result.message for result in answer.results.values()]
    rows = answer.table.assign(sure=certainties).drop(columns="exact")
    governs = f"'{answer.governing}' governs" if answer.governing else "none governs"
    return ReportPart(
        heading=_of_case("Earthquakes", drawn) if are_earthquakes else "Load cases",
        says=f"{named_factor(drawn)}: {governs} ({counted(len(answer.results), kind)})",
        assembly=drawn.assembly,
        printed_in_full={answer.governing or next(iter(answer.results)): drawn},
        further_results=answer.results,
        pictures={f"λ by {kind}": answer.plot()},
        tables={f"Every {kind} ({len(rows)})": frame_table(rows, load_case="load case", sure="certainty")},
        left_out=dict.fromkeys(answer.left_out, "axles move in this load case: use 'crossing'"),
        varied=("earthquake",) if are_earthquakes else (),
    )


@_part.register
def _(answer: Settlement) -> ReportPart:
    facts = answer.facts()
    reactions = [f"{end} reaction {facts[end].splitlines()[0].partition(';')[0]}" for end in answer.ends]
    results = {
        f"{name} reaction, {KIND_NAMES[kind]}": result
        for name, end in answer.ends.items()
        for kind, result in end.results.items()
    }
    return ReportPart(
        heading=f"Settlement, {facts['settles']}",
        says="; ".join(reactions) or facts["reaction"],
        assembly=answer.assembly,
        printed_in_full={"collapse mechanism": answer.fallen} if answer.fallen else {},
        further_results=results,
        facts=facts,
        pictures=answer.pictures() if answer.ends else {},
        tables=answer.page_tables(),
        pushed=False,
    )


@_part.register
def _(answer: Capacity) -> ReportPart:
    open_end = "The motion of the blocks after the end of the capacity curve is not known."
    return ReportPart(
        heading=_of_case("After the onset", answer.result),
        says=f"{named_factor(answer.result)} at the onset of collapse; {answer.message}",
        assembly=answer.result.assembly,
        printed_in_full={f"onset, method {answer.result.method}": answer.result},
        facts=answer.facts(),
        pictures={"λ over displacement": answer.plot(), "Blocks at its end, to scale": answer.plot(-1)},
        tables={f"Every state ({len(answer.table)})": frame_table(answer.table.drop(columns="pairs"))},
        left_open=[] if answer.reaches_zero else [open_end],
        followed=True,
    )


def _governing(answer: Crossing) -> str:
    """Return a text with the governing λ of a crossing, or the least λ so far if the crossing ended early."""
    load_factor = named_factor(answer.worst, answer.load_factor_name)
    if not answer.interrupted:
        return f"governing {load_factor}"
    by = "stopped by the time limit" if answer.time_limit_reached else "interrupted"
    return f"{by}, so that λ may be less than {load_factor}"


def _in_unit(parts: Sequence[ReportPart], force: str) -> list[ReportPart]:
    """Return parts of a report whose facts name the user's unit of force, not ``FORCE_UNIT``."""
    named = []
    for part in parts:
        facts = {label: text.replace(FORCE_UNIT, f"in {force}", 1) for label, text in part.facts.items()}
        named.append(replace(part, facts=facts))
    return named


def _of_case(heading: str, result: Result) -> str:
    """Return a heading, followed by the name of the load case if the result has a load case."""
    return heading if result.load_case is None else f"{heading}, load case '{result.load_case}'"


def _page(parts: Sequence[ReportPart], units: dict[str, str]) -> str:
    """Return the page of a report as HTML."""
    assembly = parts[0].assembly
    scene, problem = assembly.scene, assembly.problem
    axles = [group for part in parts for group in part.axles] or scene.axles
    if not units["length"] and any(group.set for group in axles):
        units = _units("m, kN")  # units of the common sets of axles
    parts = _in_unit(parts, units["force"]) if units["force"] else parts
    results: dict[str, Result] = {}
    factors: dict[str, Result] = {}  # results with a load factor
    for part in parts:
        for name, result in {**part.printed_in_full, **part.further_results}.items():
            full_name = f"{part.heading}: {name}" if len(parts) > 1 else name
            results[full_name] = result
            if part.pushed and result.load_factor is not None:
                factors[full_name] = result
    proven = {name: known_least(result) for name, result in factors.items()}
    certified = {name: result for name, result in results.items() if result.certificate is not None}
    pushed = any(part.pushed for part in parts)
    loads = {"dead": _resultant(assembly, problem.dead)}
    loads |= {"live": _resultant(assembly, problem.live)} if pushed else {}
    low, high = movable_box(assembly)
    inputs = {"scene": scene, "problem": problem, "units": units, "loads": loads, "axles": axles}
    answers = {"parts": parts, "results": results, "proven": proven, "pushed": pushed}
    functions = {"pictures_of": _pictures, "tables_of": _of_result, "in_full": in_full}
    residuals = [[name, *_residuals(result)] for name, result in certified.items()]
    crossed = {name for part in parts for name in part.crossed}
    return render(
        "report.html",
        **inputs | answers | functions,
        printable=printable,
        title=title_of(scene.with_load_case(None)),
        day=date.today().isoformat(),
        versions=versions(),
        drawn_as="png" if len(scene.blocks) > MOST_BLOCKS_DRAWN else "svg",
        angle=lambda tangent: np.degrees(np.arctan(tangent)),
        residuals=table(["answer", *RESIDUAL_MEANINGS], residuals),
        meaning=RESIDUAL_MEANINGS,
        stands=certified,
        unproven={name: certainty(result) for name, result in factors.items() if not proven[name]},
        solved={result.load_case for result in results.values()} | crossed,
        counts=counts(assembly),
        size=" × ".join(numeral(side, ".5g") for side in (high - low).tolist()),
        inputs=_tables_of_inputs(scene, axles),
        drawing=_drawing(assembly, units["length"]),
        case=_case_text(scene),
    )


def _tables_of_inputs(scene: Scene, axles: Sequence[Axles]) -> dict[str, dict[str, Any]]:
    """Return the tables of a scene's inputs, such as loads, ties, fills and axles, by heading."""
    records = {heading: getattr(scene, name) for heading, name in _RECORDS.items()} | {"Axles": axles}
    records = {heading: rows for heading, rows in records.items() if rows}
    return {_counted(heading, rows): _of_records(rows[:_MOST_ROWS]) for heading, rows in records.items()}


def _residuals(result: Result) -> list[str]:
    """Return texts with the residuals of a certified answer and their limits."""
    limits = LIMITS[result.kind].as_dict()
    residuals = result.certificate.as_dict() if result.certificate else {}
    return [f"{numeral(value, '.1e')} ≤ {limits[name]:g}" for name, value in residuals.items()]


def _resultant(assembly: Assembly, load: np.ndarray) -> list[str]:
    """Return the resultant force of a load as text; empty if the load has no forces."""
    problem = assembly.problem
    total, size = problem.forces(load).sum(axis=0), float(problem.force_sizes(load).sum())
    total = np.where(np.abs(total) > 1e-9 * size, total, 0.0) * problem.force_unit
    return [f"{part:.5g}" for part in total] if size else []


def _pictures(result: Result) -> dict[str, Picture]:
    """Return the pictures of a result by caption."""
    pictures = {} if result.stability else {"Mechanism": result_picture(result)}
    if result.joints["n"].notna().all():
        pictures["Thrust"] = result_picture(result, "thrust")
    if result.stability:
        pictures["Utilisation"] = result_picture(result, "utilisation")
    if result.curve is not None and not result.curve.empty:
        pictures["λ over displacement"] = result_picture(result, "curve")
    return pictures


def _drawing(assembly: Assembly, length: str) -> Picture:
    """Return a picture of the scene without results, with a scale bar (in space, with axes)."""
    picture = scene_picture(assembly, names=len(assembly.scene.blocks) <= _MOST_NAMED_BLOCKS)
    if assembly.scene.dimension == 3:
        return picture
    axes = picture.axes[0]
    width = float(np.ptp(axes.get_xlim()))
    axes.set_ylim(bottom=axes.get_ylim()[0] - _SCALE_BAR_HEIGHT * width)
    bar = round_below(width / 4)
    words = f"{bar:g} {length or ('unit' if bar == 1 else 'units')}"
    scale = AnchoredSizeBar(axes.transData, bar, printable(words), "lower right", pad=0.3)
    scale.set_zorder(10)
    axes.add_artist(scale)
    return picture


def _counted(heading: str, rows: Sequence[object] | pd.DataFrame) -> str:
    """Return a heading with the number of rows, such as "Ties (12)" or "Joints (150 of 900)"."""
    count = len(rows)
    return f"{heading} ({count if count <= _MOST_ROWS else f'{_MOST_ROWS} of {count}'})"


def _of_records(records: Sequence[Record]) -> dict[str, Any]:
    """Convert records to a table of the page. Keys with the default value in all records are omitted."""
    rows = pd.DataFrame([record.model_dump(exclude_defaults=True) for record in records], dtype=object)
    return frame_table(rows.where(rows.notna(), "").map(_cell))


def _cell(value: object) -> str:
    """Convert a value to text for a table cell."""
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_cell(entry)}" for key, entry in value.items())
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_cell, value))}]"
    return f"{value:.6g}" if isinstance(value, float) else printable(str(value))


def _case_text(scene: Scene) -> str:
    """Return the content of the case file of a scene, or "" if it is too long to print.

    Generators are not expanded.
    """
    text = toml_text(scene.case or scene)
    return text if text.count("\n") <= _MOST_CASE_FILE_LINES else ""


def _of_result(result: Result) -> dict[str, dict[str, Any]]:
    """Return tables of joints, ties and fill pressures of a result, by heading."""
    frames, pressures = {"Joints": _joints(result)}, result.pressures.drop(columns=["kind", "second"])
    for name, limited in (("Ties and props", result.ties), ("Pressure of fill", pressures)):
        frame = limited.assign(yields=limited["yields"].map({True: "yes", False: "no"}))
        frames[name] = frame.drop(columns="lengthens").dropna(axis=1, how="all")
    frames = {name: frame for name, frame in frames.items() if len(frame)}
    return {_counted(name, frame): frame_table(frame.head(_MOST_ROWS)) for name, frame in frames.items()}


def _joints(result: Result) -> pd.DataFrame:
    """Return the table of joints, sorted by utilisation if only some joints are printed."""
    frame = result.joints.copy()
    if "m" in frame:
        pressed = frame["n"] > NEGLIGIBLE_SHARE * frame["n"].abs().max()
        frame["e"] = (frame["m"] / frame["n"]).where(pressed)
    frame = frame.reindex(columns=_JOINTS).dropna(axis=1, how="all")
    numbers = frame.select_dtypes("number")
    frame = frame.assign(**numbers.mask(numbers.abs() <= NEGLIGIBLE_SHARE * numbers.abs().max(), 0.0))
    if result.solution.d is not None:
        motion = joint_motion(result.assembly, result.solution)
        moves = zip(*(getattr(motion, name) for name in _MOTIONS), strict=True)
        frame["moves"] = [", ".join(compress(_MOTIONS, of_joint)) for of_joint in moves]
    if len(frame) > _MOST_ROWS and "utilisation" in frame:
        frame = frame.sort_values("utilisation", ascending=False, kind="stable")
    return frame
