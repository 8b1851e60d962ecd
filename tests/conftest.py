"""What every run of tests begins with."""

import gc


def pytest_collection_finish():
    """Tests and modules live as long as the run: leave them out of collections, else a tenth of its time."""
    gc.collect()
    gc.freeze()
