"""Entry point of the command `masonry-opt`, which can be interrupted from its first moment on."""

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager


def main() -> None:
    """Run the command line.

    The import is inside this function, so that Ctrl-C during the import is handled.
    """
    try:
        with garbage_collection_paused():
            from masonry_opt.cli.app import main as run
    except KeyboardInterrupt:
        print("error: interrupted", file=sys.stderr)
        sys.exit(130)
    run()


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
