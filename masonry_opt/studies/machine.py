"""The machine, the versions and the command of a study."""

from __future__ import annotations

import os
import platform
import shlex
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from masonry_opt.studies.journal import digest

#: Packages whose versions decide times and answers.
_PACKAGES = (
    *("masonry_opt", "cvxpy", "pyomo", "clarabel", "highspy", "osqp", "scs", "casadi", "scipy", "numpy"),
)


def versions() -> dict[str, str]:
    """Python's and the packages' versions; "not installed" where there is none."""
    found = {"python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def versions_hash() -> str:
    """Short hash of versions and processor: only measurements with the same may be compared."""
    return digest((versions(), _processor()))[:8]


def machine() -> dict[str, str]:
    """Processor, cores, memory and system."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9 if hasattr(os, "sysconf") else 0
    return {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "memory": f"{memory:.0f} GB",
        "system": f"{platform.system()} {platform.release()}",
        "threads": "one a run, on one core",
        "command": shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]]),
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    named = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.processor() or platform.machine()
