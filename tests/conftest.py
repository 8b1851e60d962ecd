"""Fixtures that all tests share, such as interrupts and solvers that fail."""

import contextlib
import gc
import signal
import sys

import pytest


def pytest_collection_finish():
    """Exclude tests and modules from garbage collection, and collect garbage less often.

    Otherwise it would take more than a tenth of the time of a run.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(100_000, 50, 100)


@pytest.fixture(scope="session", autouse=True)
def fork_server_with_all_modules():
    """Let the fork server of studies import the modelling languages once.

    Otherwise the worker processes of each study import what its method needs, which takes them a second.
    """
    from masonry_opt.studies import runner

    modules = {*runner._MODULES_OF_WORKERS, *runner._MODULES_OF_RUN_ALONE, "models.cvxpy_static"}
    with pytest.MonkeyPatch.context() as patch:
        for name in ("_MODULES_OF_WORKERS", "_MODULES_OF_RUN_ALONE"):
            patch.setattr(runner, name, tuple(sorted(modules)))
        yield


@pytest.fixture
def command(monkeypatch, capsys):
    from scenes import Command  # imports the whole package, which not every test needs

    return Command(monkeypatch, capsys)


@pytest.fixture
def watched(monkeypatch):
    """Return a function that records the arguments of all further calls of a function of a module or class.

    After each call, ``watch`` is called with the same arguments. It may raise an exception, as Ctrl-C does.
    """

    def of(owner, name, watch=lambda *_, **__: None):
        function, calls = getattr(owner, name), []

        def follow(*given, **options):
            calls.append(given)
            found = function(*given, **options)
            watch(*given, **options)
            return found

        monkeypatch.setattr(owner, name, follow)
        return calls

    return of


@pytest.fixture
def clock(monkeypatch):
    """Replace the clock of all time limits by one whose time ``now``, in seconds, only tests advance."""

    class Clock:
        now = 0.0

        def perf_counter(self):
            return self.now

    clock = Clock()
    monkeypatch.setattr("masonry_opt.deadline.time", clock)
    return clock


@pytest.fixture
def slow_positions(clock, monkeypatch):
    """Let each position of a crossing take ten seconds of the clock, and return the clock."""
    from masonry_opt.studies.crossing.search import PassageTrials

    solved = PassageTrials.of

    def slow(trials, live):
        answer = solved(trials, live)
        clock.now += 10.0
        return answer

    monkeypatch.setattr(PassageTrials, "of", slow)
    return clock


@pytest.fixture
def press_ctrl_c():
    """Return a function that raises Ctrl-C as a terminal does, also if the tests run in the background.

    With ``swallowed``, the exception is suppressed, as some solvers do.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def press(swallowed=False):
        with contextlib.suppress(*[KeyboardInterrupt] * swallowed):
            signal.raise_signal(signal.SIGINT)

    yield press
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def failing(monkeypatch):
    """Return a function that lets a solver fail if ``when`` is true of the arguments of a call.

    By default, every call fails. With "ray", HiGHS' infeasibility certificate is as small as rounding errors.
    """

    def of(solver, when=lambda *_: True):
        import numpy as np

        from masonry_opt.methods.mpec import CasadiIpopt
        from masonry_opt.solvers.cvxpy_engine import CvxpyEngine
        from masonry_opt.solvers.highs import HighsSession
        from masonry_opt.solvers.registry import Solved, Verdict

        owner, name, failure = {
            "cvxpy": (CvxpyEngine, "solve", Solved(Verdict.FAILED, "stopped", 0.0)),
            "highs": (HighsSession, "run", Verdict.FAILED),
            "ray": (HighsSession, "contradiction", (1.0, np.array([1e-8]))),
            "ipopt": (CasadiIpopt, "solve", (False, "Gave_Up", 7)),
        }[solver]
        function = getattr(owner, name)
        monkeypatch.setattr(owner, name, lambda *given: failure if when(*given) else function(*given))

    return of


@pytest.fixture
def certificates(monkeypatch):
    """Return a function that sets the named residuals, or all, of each state at the end of a load history.

    The programs that then look for an exact state find none.
    """

    def leave(residual, *names):
        from dataclasses import replace

        from masonry_opt.methods.incremental import collapse_state, method

        certified = collapse_state.certified

        def rough(*state):
            answer = certified(*state)
            changed = dict.fromkeys(names or answer.residuals, residual)
            return replace(answer, residuals=answer.residuals | changed)

        monkeypatch.setattr(collapse_state, "certified", rough)
        monkeypatch.setattr(method, "find_collapse_state", lambda *_: None)

    return leave


@pytest.fixture
def no_proof(monkeypatch):
    """Remove the step that proves the least state from the default method, as on scenes with many joints."""
    from masonry_opt.methods.coulomb import method
    from masonry_opt.methods.coulomb.steps import LeastProven

    others = tuple(step for step in method.STEPS if not isinstance(step, LeastProven))
    monkeypatch.setattr(method, "STEPS", others)


@pytest.fixture
def short_motions(monkeypatch):
    """Limit each damped motion of the default's load history to 200 linear solves, instead of 4000."""
    from masonry_opt.methods.coulomb import method
    from masonry_opt.methods.coulomb.steps import Incremental
    from masonry_opt.methods.incremental.settings import IncrementalSettings

    short = Incremental(IncrementalSettings(motion_solves=200))
    steps = tuple(short if isinstance(step, Incremental) else step for step in method.STEPS)
    assert steps.count(short) == 1
    monkeypatch.setattr(method, "STEPS", steps)


@pytest.fixture
def few_cuts(monkeypatch):
    """Limit the search for a proof that no load factor exists to a twelfth of its linear programs."""
    monkeypatch.setattr("masonry_opt.stability.existence._MOST_WORK", 10_000)


@pytest.fixture
def without(monkeypatch):
    """Return a function that makes a library appear not installed.

    The named modules of the package, which import the library, are removed from ``sys.modules``.
    """

    def library(name, *modules):
        monkeypatch.setitem(sys.modules, name, None)
        for module in modules:
            monkeypatch.delitem(sys.modules, f"masonry_opt.{module}", raising=False)

    return library


@pytest.fixture
def terminal(monkeypatch):
    """Set the environment of a terminal with 150 columns."""
    for name in ("NO_COLOR", "FORCE_COLOR", "TTY_COMPATIBLE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "150")
