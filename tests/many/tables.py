"""Comparison of tables of sweeps, and samples that are made from given load factors."""

from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.solution.reasons import Status
from masonry_opt.studies.many.sample import Sample
from masonry_opt.studies.run_columns import RUN_COLUMNS, framed


def same(one: pd.DataFrame, two: pd.DataFrame) -> None:
    """Assert that two tables are equal to the last digit, except for the time that runs took."""
    pd.testing.assert_frame_equal(one.drop(columns="seconds"), two.drop(columns="seconds"), check_exact=True)


def sampled(values: Any, drawn: pd.DataFrame | None = None, **columns: Any) -> Sample:
    """Return a sample with the given load factors and drawn values.

    A load factor of -inf means that the scene is unstable, inf that it carries any load, and NaN that the run
    is undecided.
    """
    drawn = pd.DataFrame({"x": np.arange(len(values))}) if drawn is None else drawn
    values = np.asarray(values, dtype=float)
    load_factor = np.where(np.isfinite(values), values, np.nan)
    given = {"load_factor": load_factor, "any_load": np.isposinf(values)}
    given["status"] = np.where(np.isneginf(values), str(Status.UNSTABLE), "optimal")
    given |= {"state_from": "", "warnings": ""} | columns
    table = framed(drawn.assign(**given).to_dict("records"), list(drawn), RUN_COLUMNS)
    return Sample(case="made", table=table, drawn=tuple(drawn), distributions=dict.fromkeys(drawn, "made"))
