"""What every run of tests begins with, and what happens to programs: interrupts, failures."""

import contextlib
import gc
import signal
import sys

import pytest


def pytest_collection_finish():
    """Tests and modules live as long as the run: leave them out of collections, else a tenth of its time."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def command(monkeypatch, capsys):
    from scenes import Command  # with all of the package, which not every test needs

    return Command(monkeypatch, capsys)


@pytest.fixture
def watched(monkeypatch):
    """The arguments of each call of a function of a module or class from now on; after each call ``watch`` is
    called with the same, and may end all as Ctrl-C does."""

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
    """The clock of all time limits, whose time ``now`` in seconds only tests advance."""

    class Clock:
        now = 0.0

        def perf_counter(self):
            return self.now

    clock = Clock()
    monkeypatch.setattr("masonry_opt.deadline.time", clock)
    return clock


@pytest.fixture
def slow_positions(clock, monkeypatch):
    """Each position of a crossing takes ten seconds of the clock, which is returned."""
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
    """Ctrl-C as a terminal sends it (a job in the background ignores it), which a solver may swallow."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def press(swallowed=False):
        with contextlib.suppress(*[KeyboardInterrupt] * swallowed):
            signal.raise_signal(signal.SIGINT)

    yield press
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def failing(monkeypatch):
    """Lets a solver fail whenever ``when`` says so of the program and of what it is asked; always by default.
    "ray": HiGHS' proof that a program is infeasible is one that rounding explains."""

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
    """Lets every certificate at a collapse leave so much of the named conditions, or of all.

    The programs that look for an exact state where there is none yet find nothing.
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
    """Leaves the proof that no state is lower out of the default, as on scenes with many joints."""
    from masonry_opt.methods.coulomb import method
    from masonry_opt.methods.coulomb.steps import LeastProven

    others = tuple(step for step in method.STEPS if not isinstance(step, LeastProven))
    monkeypatch.setattr(method, "STEPS", others)


@pytest.fixture
def without(monkeypatch):
    """As where a library is not installed; modules of the package that import it are forgotten."""

    def library(name, *modules):
        monkeypatch.setitem(sys.modules, name, None)
        for module in modules:
            monkeypatch.delitem(sys.modules, f"masonry_opt.{module}", raising=False)

    return library


@pytest.fixture
def terminal(monkeypatch):
    """The environment of a terminal of 150 columns."""
    for name in ("NO_COLOR", "FORCE_COLOR", "TTY_COMPATIBLE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "150")
