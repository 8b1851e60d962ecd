"""How a command runs: what it shows meanwhile, and how it ends where it is stopped or cannot write."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import typer
from rich.console import Console

from masonry_opt.errors import InterruptedByUserError, OutputError
from masonry_opt.words.terminal import print_text


@contextlib.contextmanager
def waiting(line: str) -> Iterator[Callable[[str], None]]:
    """Show a line until the end, and yield what changes it. Ctrl-C ends with nothing found."""
    with Console(stderr=True).status(line) as status:
        try:
            yield status.update
        except KeyboardInterrupt:
            raise InterruptedByUserError("interrupted: nothing was found") from None


@contextlib.contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn errors of writing a file into those of this package."""
    try:
        yield
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror}") from None


def tell(
    text: str, found: Any, usable: bool, plot: Path | None, drawing: Mapping[str, Any], say: Any = print_text
) -> None:
    """Print what was found, draw it where a file is given, and end with 1 if it is no usable answer."""
    say(text)
    if plot is not None:
        with writing(plot):
            found.save(plot, **drawing)
    if not usable:
        raise typer.Exit(1)


@contextlib.contextmanager
def interrupts() -> Iterator[Callable[[], None]]:
    """Remember Ctrl-C, which a solver may catch to stop itself alone, and yield a function that raises
    KeyboardInterrupt if there was one."""
    pressed = False

    def remember(*_: object) -> None:
        nonlocal pressed
        pressed = True
        raise KeyboardInterrupt

    def check() -> None:
        if pressed:
            raise KeyboardInterrupt

    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:  # else the caller has its own, or ignores it
        signal.signal(signal.SIGINT, remember)
    try:
        yield check
    finally:
        if before is signal.default_int_handler:
            signal.signal(signal.SIGINT, before)
