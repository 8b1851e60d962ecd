"""Files of a sweep: whole or not at all where the disk is full, and the same numbers in each."""

import contextlib
import shutil
import signal

import pandas as pd
import pytest
from scenes import block_on_floor

import masonry_opt as mo
from masonry_opt.errors import OutputError
from masonry_opt.studies import journal

VARY = {"joints.friction": [0.1, 0.2, 0.3, 0.4, -1.0]}


def sweep(**keys):
    return mo.sweep(block_on_floor(), VARY, method="static", workers=1, **keys)


def same(one, other):
    pd.testing.assert_frame_equal(
        one.drop(columns="seconds"), other.drop(columns="seconds"), check_exact=True
    )


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A table, and the folder that it was written to."""
    out = tmp_path_factory.mktemp("swept")
    return sweep(out=out), out


@contextlib.contextmanager
def full_from(size):
    """No file can be longer, as where the disk is full: what fits of a write is written."""
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)


@pytest.mark.parametrize("full", [journal.NAME, "runs.csv", "load_factor.png"])
def test_a_full_disk_keeps_what_was_made(swept, tmp_path, full):
    frame, folder = swept
    lines = (folder / journal.NAME).read_bytes().splitlines(keepends=True)
    if full == journal.NAME:
        # In the middle of the third run's line.
        size, whole = sum(map(len, lines[:3])) + 20, 1 + 2
    else:
        # As after a last run for which the disk had just room. (Pictures are longer than the journal.)
        sweep(out=tmp_path)
        size, whole = (tmp_path / full).stat().st_size - 20, len(lines)
        for file in (full, "load_factor.png"):
            (tmp_path / file).unlink(missing_ok=True)
    with full_from(size), pytest.raises(OutputError, match="cannot be written") as failed:
        sweep(out=tmp_path)
    assert str(tmp_path / full) in str(failed.value)
    kept = (tmp_path / journal.NAME).read_bytes()
    assert len([line for line in kept.splitlines(keepends=True) if line.endswith(b"\n")]) == whole
    assert not list(tmp_path.glob(".writing*"))
    assert not (tmp_path / "load_factor.png").exists()
    same(sweep(out=tmp_path), frame)
    assert len((tmp_path / journal.NAME).read_bytes().splitlines()) == len(lines)
    assert (tmp_path / "load_factor.png").read_bytes() == (folder / "load_factor.png").read_bytes()


def test_csv_is_the_table_to_the_last_digit(swept, tmp_path):
    frame, folder = swept
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)  # with the journal: nothing is run again
    sweep(out=tmp_path)
    assert (tmp_path / "runs.csv").read_bytes() == (folder / "runs.csv").read_bytes()
    written = pd.read_csv(tmp_path / "runs.csv", dtype=str, keep_default_na=False)
    for name in ("joints.friction", "load_factor", "equilibrium", "yield", "seconds"):
        digits = ["" if pd.isna(value) else repr(float(value)) for value in frame[name]]
        assert written[name].tolist() == digits
