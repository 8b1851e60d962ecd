"""Give a constant of the package another value for a while."""

from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from types import ModuleType
from typing import Any
from unittest.mock import patch


@contextmanager
def changed(modules: Iterable[ModuleType], name: str, value: Any) -> Iterator[None]:
    """Set a constant in all modules that use it. Its usual value is restored afterwards."""
    with ExitStack() as stack:
        for module in modules:
            stack.enter_context(patch.object(module, name, value))
        yield
