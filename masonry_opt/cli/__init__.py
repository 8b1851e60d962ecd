"""Entry point of the command `masonry-opt`, which can be interrupted from its first moment on."""

import gc
import sys

#: Number of new objects after which Python looks for garbage. Imports create some 100,000 objects that live
#: until the command ends. With the default of 700 (Python 3.11), a short command would spend 5 % of its time
#: on the search for garbage.
_OBJECTS_BEFORE_COLLECTION = 100_000


def main() -> None:
    """Run the command line.

    The import is inside this function, so that Ctrl-C during the import is handled.
    """
    gc.set_threshold(_OBJECTS_BEFORE_COLLECTION)
    try:
        from masonry_opt.cli.app import main as run
    except KeyboardInterrupt:
        print("error: interrupted", file=sys.stderr)
        sys.exit(130)
    run()
