"""Entry point of the command `masonry-opt`, which can be interrupted from its first moment on."""

import atexit
import gc
import sys

from masonry_opt.cli.imports import garbage_collection_paused
from masonry_opt.threads import use_one_thread


def main() -> None:
    """Run the command line.

    The import is inside this function, so that Ctrl-C during the import is handled.
    """
    # Python collects garbage twice when a program ends, and would visit all modules. In development mode,
    # these collections report files that are left open, so they remain.
    if not sys.flags.dev_mode:
        atexit.register(gc.freeze)
    use_one_thread()
    try:
        with garbage_collection_paused():
            from masonry_opt.cli.app import main as run
    except KeyboardInterrupt:
        print("error: interrupted", file=sys.stderr)
        sys.exit(130)
    run()
