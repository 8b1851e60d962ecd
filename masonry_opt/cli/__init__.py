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
    # When a program ends, Python collects garbage twice and visits the objects of all modules. gc.freeze
    # excludes these objects from the collections, which saves time. In development mode nothing is excluded,
    # because the collections then report files that were not closed.
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
