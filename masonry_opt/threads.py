"""Number of threads of numerical libraries."""

import os

#: Environment variables that limit numerical libraries to one thread. The libraries read them when they are
#: imported.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def use_one_thread() -> None:
    """Limit numerical libraries to one thread, unless the user has set a number of threads.

    Further threads do not factorise the stiffness matrices of an analysis faster. On a busy machine they wait
    for each other, and a factorisation takes much longer.
    """
    if not any(name in os.environ for name in ONE_THREAD):
        os.environ.update(ONE_THREAD)
