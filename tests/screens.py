"""Replacements for the output of a command: a stream that may be a terminal, and a full disk."""

import contextlib
import io
import signal
import time

import pytest


class Screen(io.StringIO):
    """A stream that is a terminal or not, with a method that waits until a text has been written to it."""

    encoding = "utf-8"

    def __init__(self, terminal):
        super().__init__()
        self.isatty = lambda: terminal

    def shows(self, text, seconds=20.0):
        end = time.monotonic() + seconds
        while text not in self.getvalue() and time.monotonic() < end:
            time.sleep(0.001)
        return text in self.getvalue()


@contextlib.contextmanager
def full_from(size):
    """Limit the size of files, as a full disk does: the part of a write that fits is written."""
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)
