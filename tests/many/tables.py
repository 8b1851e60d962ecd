"""Tables of sweeps, compared."""

import pandas as pd


def same(one: pd.DataFrame, two: pd.DataFrame) -> None:
    """Hold two tables to be the same to the last digit, but for the time that runs took."""
    pd.testing.assert_frame_equal(one.drop(columns="seconds"), two.drop(columns="seconds"), check_exact=True)
