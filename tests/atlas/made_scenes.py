"""Case files for comparisons from the failure atlas, and from small and large random scenes.

The scenes are written as case files, so that each run can read its scene in its own process.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import pandas as pd
from atlas.entries import ATLAS
from atlas.entry import Entry, Expectation
from atlas.large_scenes import LARGE, large_scene
from atlas.random_scenes import KINDS, random_scene

from masonry_opt.scene.case_file import save
from masonry_opt.scene.scene import Scene
from masonry_opt.solution.reasons import Status
from masonry_opt.studies.compare.judge import ANSWER, CLAIMS, REASON_NAMED, WRONG, claim_of, question_of
from masonry_opt.studies.compare.runs import content_of
from masonry_opt.studies.runner import REFUSED


def write_atlas(folder: Path, cases: Path) -> dict[Path, dict[str, str]]:
    """Write each scene of the atlas once, and return the right claims for each case file.

    See ``right_claims``. The argument ``cases`` is the folder of the case files from which entries are built.
    """
    first: dict[str, Path] = {}
    found: dict[Path, dict[str, str]] = {}
    for entry in ATLAS:
        scene = entry.scene(cases)
        name = re.sub(r"[^\w.-]+", "_", entry.name)
        path = first.setdefault(content_of(scene), folder / "atlas" / f"{name}.toml")
        if path not in found:
            _write(scene.model_copy(update={"title": entry.name}), path)
        found[path] = right_claims(entry) | found.get(path, {})
    return found


def write_random(folder: Path, count: int) -> list[Path]:
    """Write ``count`` random scenes, of each kind in turn, with seeds from 0, and return their case files."""
    paths = []
    for number in range(count):
        seed, kind = divmod(number, len(KINDS))
        name = list(KINDS)[kind]
        paths.append(folder / "random" / f"{name}_{seed}.toml")
        _write(random_scene(name, seed), paths[-1])
    return paths


def write_large(folder: Path, stones: Sequence[int], seeds: int) -> list[Path]:
    """Write large random scenes of each family for each number of stones, and return their case files.

    Seeds begin with 0.
    """
    paths = []
    for count in stones:
        for family in LARGE:
            for seed in range(seeds):
                paths.append(folder / "large" / f"{family}_{count}_{seed}.toml")
                _write(large_scene(family, count, seed), paths[-1])
    return paths


def right_claims(entry: Entry) -> dict[str, str]:
    """Return the right claim on the scene of an entry for each question.

    A claim is one of ``judge.CLAIMS``, a refusal or an answer. The right claim is an answer if any run must
    find a load factor, even if other runs are known to fail. Questions without a single right claim are left
    out.
    """
    found: dict[str, set[str]] = {}
    for run in entry.runs:
        found.setdefault(question_of(run.method), set()).update(_claims(run))
    right = {question: {ANSWER} if ANSWER in claims else claims for question, claims in found.items()}
    return {question: claims.pop() for question, claims in right.items() if len(claims) == 1}


def judged_by_hand(summary: pd.DataFrame, expected: Mapping[str, Mapping[str, str]]) -> pd.DataFrame:
    """Return the summary of a comparison with verdicts by the known right claims.

    ``expected`` has right claims by name of the scene and by question. Other claims are wrong. If the right
    claim is that no load factor exists, a result with this claim names the right reason.
    """
    judged = summary.copy()
    for at, row in summary.iterrows():
        right, claim = expected.get(row["scene"], {}).get(row["question"]), claim_of(row)
        if right and claim != right and claim in (*CLAIMS, REFUSED):
            said = row["reason"] or row["status"]
            judged.loc[at, ["verdict", "reason"]] = WRONG, f"{said} (right: {right})"
        elif right and claim == right != ANSWER:
            judged.loc[at, "verdict"] = REASON_NAMED
    return judged


def _claims(run: Expectation) -> Iterator[str]:
    if not isinstance(run.expected, Status):
        yield REFUSED
    elif run.expected.usable:
        yield ANSWER
    elif run.expected in CLAIMS:
        yield run.expected


def _write(scene: Scene, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    save(scene, path, force=True)  # the folder belongs to the comparison
