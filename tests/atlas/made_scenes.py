"""Scenes of a comparison that come with no case file: the failure atlas, and random ones, small and large.

They are written as case files, so that each run reads its scene in its own process, as it does any other.
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
    """Write the atlas's scenes, each once; by case file, what the atlas says of it (see ``right_claims``).

    ``cases``: folder of the case files that entries build on.
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
    """Write the first ``count`` random scenes, of each kind in turn, by seed from 0; their case files."""
    paths = []
    for number in range(count):
        seed, kind = divmod(number, len(KINDS))
        name = list(KINDS)[kind]
        paths.append(folder / "random" / f"{name}_{seed}.toml")
        _write(random_scene(name, seed), paths[-1])
    return paths


def write_large(folder: Path, stones: Sequence[int], seeds: int) -> list[Path]:
    """Write large random scenes of each family, of so many stones each, by seed from 0; their case files."""
    paths = []
    for count in stones:
        for family in LARGE:
            for seed in range(seeds):
                paths.append(folder / "large" / f"{family}_{count}_{seed}.toml")
                _write(large_scene(family, count, seed), paths[-1])
    return paths


def right_claims(entry: Entry) -> dict[str, str]:
    """By question, the claim (see ``judge.CLAIMS``; or a refusal) that is right for an entry's scene.

    A load factor if any run must find one, whatever others are known to fail at. Questions on which the
    entry's runs say nothing of the scene are left out.
    """
    found: dict[str, set[str]] = {}
    for run in entry.runs:
        found.setdefault(question_of(run.method), set()).update(_claims(run))
    right = {question: {ANSWER} if ANSWER in claims else claims for question, claims in found.items()}
    return {question: claims.pop() for question, claims in right.items() if len(claims) == 1}


def judged_by_hand(summary: pd.DataFrame, expected: Mapping[str, Mapping[str, str]]) -> pd.DataFrame:
    """The summary of a comparison, in which the right claim, where one is known by scene name and question,
    decides: other claims are wrong, and it is the right reason why there is no load factor."""
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
    save(scene, path, force=True)  # the folder is the comparison's own
