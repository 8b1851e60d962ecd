"""What every run of tests begins with."""

import gc

import pytest


def pytest_collection_finish():
    """Tests and modules live as long as the run: leave them out of collections, else a tenth of its time."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def command(monkeypatch, capsys):
    from scenes import Command  # with all of the package, which not every test needs

    return Command(monkeypatch, capsys)
