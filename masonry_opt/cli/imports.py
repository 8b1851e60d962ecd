"""Import modules of commands without a search for garbage."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def garbage_collection_paused() -> Iterator[None]:
    """Pause the garbage collector while modules are imported during a ``with`` block.

    The objects of modules live until the program ends. Collections would visit them again and again, and find
    no garbage. Afterwards the collector is switched on again, unless it was off before.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()
