"""The command limits numerical libraries to one thread before it imports them."""

import os
import subprocess
import sys

import pytest
from scenes import WALLS

from masonry_opt.threads import use_one_thread

#: Libraries that read the number of threads when they are imported.
LIBRARIES = ("numpy", "scipy", "highspy", "clarabel")


@pytest.mark.parametrize(
    ("before", "threads"), [({}, "1"), ({"OMP_NUM_THREADS": "3"}, "3"), ({"OPENBLAS_NUM_THREADS": "3"}, None)]
)
def test_numerical_libraries_use_one_thread_unless_the_user_sets_a_number(monkeypatch, before, threads):
    monkeypatch.setattr(os, "environ", dict(before))
    use_one_thread()
    assert os.environ.get("OMP_NUM_THREADS") == threads
    if before:
        assert os.environ == before


@pytest.mark.parametrize("module", ["masonry_opt", "masonry_opt.cli"])
def test_no_numerical_library_is_imported_before_the_number_of_threads_is_set(module):
    """The libraries read the number of threads when they are imported."""
    program = f"import sys, {module}; print([name for name in {LIBRARIES} if name in sys.modules])"
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"


def test_the_command_sets_the_number_of_threads_before_it_imports_numpy():
    """The script runs the command, and stops it at the first import of NumPy."""
    program = (
        "import os, sys\n"
        "class Stop:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'numpy':\n"
        "            sys.exit('threads: ' + os.environ.get('OMP_NUM_THREADS', 'all'))\n"
        "sys.meta_path.insert(0, Stop())\n"
        "from masonry_opt.cli import main\n"
        "main()\n"
    )
    variables = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    free = {name: value for name, value in os.environ.items() if name not in variables}
    command = [sys.executable, "-c", program, "solve", str(WALLS[0])]
    ended = subprocess.run(command, capture_output=True, text=True, check=False, env=free)
    assert ended.stderr.strip() == "threads: 1"
