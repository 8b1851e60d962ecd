"""A stream that a test gives a command in place of its own."""

import io
import time


class Screen(io.StringIO):
    """A stream that is a terminal, or is none, and tells when a text has been written to it."""

    encoding = "utf-8"

    def __init__(self, terminal):
        super().__init__()
        self.isatty = lambda: terminal

    def shows(self, text, seconds=20.0):
        end = time.monotonic() + seconds
        while text not in self.getvalue() and time.monotonic() < end:
            time.sleep(0.001)
        return text in self.getvalue()
