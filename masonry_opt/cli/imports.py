"""Import modules of commands without a search for garbage."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def garbage_collection_paused() -> Iterator[None]:
    """Pause the garbage collector while modules are imported during a ``with`` block.

    The objects of modules live until the program ends. Collections would visit them again and again, and find
    no garbage. Therefore they are also excluded from later collections.
    """
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()
