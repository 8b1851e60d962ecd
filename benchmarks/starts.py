"""Measure which kinds of starts in space lead below the lowest load factor of a default without these starts.

    python benchmarks/starts.py --scenes 12 --first 7800000 --starts 3

Half of the random scenes have ties and props (tests/atlas). Each scene is first solved without further
starts. From its state, the script tries the starts of each kind. The table counts starts that lead to a load
factor that is lower by more than 1e-4, and starts that lead to no exact state. It also contains the number of
scenes on which a kind lowers the load factor, the largest decrease, and the mean processor time of a start.
"""

import argparse
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from functools import partial
from itertools import chain, islice

import numpy as np
from lowest import WITHOUT_STARTS, scenes

import masonry_opt as mo
from masonry_opt.methods.exact.alternation import alternation_of
from masonry_opt.methods.exact.refiner import ConeRefiner, ExactState, exact_state_of
from masonry_opt.methods.exact.search import Search, StateRecord
from masonry_opt.methods.exact.settings import SEARCH
from masonry_opt.methods.incremental.analysis import analysis_of
from masonry_opt.methods.task import Task
from masonry_opt.problem.load_factor_scale import LoadFactorScale

#: Relative decrease of the load factor above which a start leads to a lower state.
LOWER = 1e-4

#: Name of a kind of start, and function that draws its forces.
Start = tuple[str, Callable[[np.random.Generator], np.ndarray | None]]


def starts_of(search: Search, task: Task, best: ExactState, starts: int) -> Iterator[Start]:
    """Yield the starts of a scene, in the order of the table."""
    yield "forces of the lowest state", lambda _: best.q
    steps = analysis_of(task).run().history.steps
    for share in SEARCH.steps_in_space:
        number = int(share * (len(steps) - 1))
        if number:
            yield f"load step at {share:g} of the history", partial(lambda q, _: q, steps[number].forces)
    drawn: list[Start] = [
        ("random forces", partial(search.random_forces, best)),
        ("load history from other self-stress", partial(search.with_self_stress, best)),
    ]
    for start in drawn:
        yield from [start] * starts


def changes(scene: mo.Scene, starts: int, seed: int) -> Iterator[tuple[str, float | None, float]]:
    """Yield the kind of each start, the relative change of λ (None without a state), and its seconds."""
    result = mo.solve(scene, settings=WITHOUT_STARTS)
    answer = result.solution.answer
    if answer is None or not answer.exact or answer.load_factor <= LOWER:
        return
    task = Task(result.assembly.problem)
    best = exact_state_of(task.problem.by_cone, answer)
    alternation = alternation_of(task, SEARCH)
    finder = ConeRefiner(task.problem, task.effort, alternation, SEARCH.weight_series_in_space[0])
    search = Search(finder, analysis_of(task), StateRecord(LoadFactorScale()), SEARCH)
    for number, (kind, draw) in enumerate(starts_of(search, task, best, starts)):
        began = time.process_time()
        state = search.start(draw(np.random.default_rng((seed, number))))
        change = None if state is None else state.load_factor / best.load_factor - 1
        yield kind, change, time.process_time() - began


def main() -> None:
    """Try the starts of all scenes, and print the table."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("--scenes", type=int, default=12, help="number of scenes")
    parser.add_argument("--first", type=int, default=1_210_000, help="first seed")
    parser.add_argument("--starts", type=int, default=3, help="number of random starts of each kind")
    asked = parser.parse_args()
    half = asked.scenes // 2
    drawn = chain(scenes("space", asked.first, asked.scenes - half), scenes("ties", asked.first, half))
    table: dict[str, list[tuple[int, float | None, float]]] = defaultdict(list)
    solved = set()
    for number, (_, seed, scene) in enumerate(islice(drawn, asked.scenes)):
        for kind, change, seconds in changes(scene, asked.starts, seed):
            solved.add(number)
            table[kind].append((number, change, seconds))
    print(f"{len(solved)} of {asked.scenes} scenes have an exact state with λ > 0")
    print("| start from | lower, of starts | scenes | largest decrease | no exact state | s of a start |")
    print("|---" * 6 + "|")
    for kind, rows in table.items():
        lower = [(scene, -change) for scene, change, _ in rows if change is not None and change < -LOWER]
        most = f"{max((share for _, share in lower), default=0.0):.2%}"
        none = sum(change is None for _, change, _ in rows)
        seconds = np.mean([each for *_, each in rows])
        on = len({scene for scene, _ in lower})
        print(f"| {kind} | {len(lower)} of {len(rows)} | {on} | {most} | {none} | {seconds:.2f} |")


if __name__ == "__main__":
    main()
