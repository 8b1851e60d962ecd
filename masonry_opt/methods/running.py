"""Run a method, and look for a collapse in which the live load does no work if the method finds no answer.

Modules that declare programs are imported where they are used: modelling languages take seconds.
"""

import warnings

import numpy as np

from masonry_opt.errors import LongAnalysisWarning
from masonry_opt.methods.task import Method, Task
from masonry_opt.problem.load_factor_scale import EQUALITY_TOLERANCE
from masonry_opt.problem.problem import Problem
from masonry_opt.solution.acceptance import Kind
from masonry_opt.solution.reasons import Code, Status
from masonry_opt.solution.solution import Solution

#: If a Coulomb method finds no load factor, :func:`run_method` searches for a collapse without work of the
#: live load. On scenes with more joints than this number, the search is omitted.
_MOST_JOINTS_NO_WORK = 8000

#: Number of joints of a plane scene above which a warning says that a Coulomb method takes many minutes. See
#: "Façades" in benchmarks/README.md.
_MOST_JOINTS_IN_MINUTES = 30_000

#: Number of contact points of a scene in space above which a warning says that a Coulomb method takes many
#: minutes. The number is an estimate.
_MOST_CONTACTS_IN_MINUTES = 10_000

#: Largest work of the live load that counts as zero, relative to the product of the norms of load and motion.
#: With a larger value, a collapse without work of the live load is sought in more scenes.
NO_WORK = 1e-3


def warn_if_long(method: Method, problem: Problem, time_limit: float | None) -> None:
    """Warn before an analysis that will take more than a few minutes, if the user set no time limit."""
    contacts = "contact points" if problem.layout.round else "joints"
    most = _MOST_CONTACTS_IN_MINUTES if problem.layout.round else _MOST_JOINTS_IN_MINUTES
    if method.associative or time_limit is not None or problem.joints <= most:
        return
    warnings.warn(
        f"the scene has {problem.joints} {contacts}, and method '{method.name}' will take many minutes: "
        "use method 'static', which is several times as fast, or set 'time_limit' (--time-limit)",
        LongAnalysisWarning,
        stacklevel=2,
    )


def run_method(method: Method, task: Task) -> Solution:
    """Run a method, and return its solution.

    This function looks for a collapse in which the live load does no work in three cases:

    - before the method runs, if the incremental analysis ended in a collapse without work of the live load;
    - if a Coulomb method finds no load factor;
    - if a load history gives only a range that contains the collapse load, and the live load does no work in
      the collapse. An exact load factor inside the range then replaces the range.
    """
    before, incremental = None, task.incremental
    if incremental is None or not incremental.has(Code.NO_WORK):
        before = method.run(task)
        if before.status is Status.TIME_LIMIT:
            return before
        # If a method that seeks exact states returns the answer of the load history, it has found no exact
        # state.
        has_no_state = method.seeks_lowest and before.kind is Kind.INCREMENTAL
        if not has_no_state and _ends_without_work(task.problem, before):
            return _exact_without_work(task, method, before)
        falls = before.status is Status.UNSTABLE
        has_answer = before.answer is not None and not before.failing() and not has_no_state
        is_decided = has_answer or before.proven_none or falls
        if is_decided or before.kind is Kind.ASSOCIATIVE or task.problem.joints > _MOST_JOINTS_NO_WORK:
            return before
        from masonry_opt.methods.associative import with_associative

        before = with_associative(task, before)
        if before.associative is None:
            return before
    from masonry_opt.methods.no_work import without_work

    return without_work(task, method.run, before) or before or method.run(task)


def _ends_without_work(problem: Problem, solution: Solution) -> bool:
    """Return True if λ is known only to lie in a range, and the live load does no work in the collapse.

    The range is between two load factors of a load history: the scene carries the first, but not the second.
    """
    if not solution.has(Code.RANGE) or solution.followed_to_end or solution.d is None:
        return False
    sizes = np.linalg.norm(problem.live) * np.linalg.norm(solution.d)
    return bool(problem.live @ solution.d <= NO_WORK * sizes)


def _exact_without_work(task: Task, method: Method, before: Solution) -> Solution:
    """Return an exact collapse in which the live load does no work, or ``before`` if there is none.

    ``before`` is a solution whose load history shows that λ is in a range. The exact collapse must have its λ
    in this range.
    """
    from masonry_opt.methods.no_work import without_work

    exact = without_work(task, method.run, before)
    limits = before.values_of(Code.RANGE)
    if exact is None or exact.load_factor is None:
        return before
    is_within = (
        limits["carried"] * (1 - EQUALITY_TOLERANCE)
        <= exact.load_factor
        <= limits["not_carried"] * (1 + EQUALITY_TOLERANCE)
    )
    return exact if is_within else before
