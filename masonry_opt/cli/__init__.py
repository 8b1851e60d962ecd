"""Entry point of the command `masonry-opt`, which can be interrupted from its first moment on."""

import atexit
import gc
import os
import sys

from masonry_opt.cli.imports import garbage_collection_paused

#: Environment variables that set the number of threads of numerical libraries. The libraries read them when
#: they are imported.
_THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def use_one_thread() -> None:
    """Limit numerical libraries to one thread, unless the user has set a number of threads.

    Further threads do not factorise the stiffness matrices of an analysis faster. On a busy machine they wait
    for each other, and one factorisation takes hundreds of times as long.
    """
    if not any(name in os.environ for name in _THREAD_VARIABLES):
        os.environ.update(dict.fromkeys(_THREAD_VARIABLES, "1"))


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
