"""Tables of sweeps, compared, and samples as if they had been run."""

from typing import Any

import numpy as np
import pandas as pd

from masonry_opt.solution.reasons import Status
from masonry_opt.studies.many.sample import Sample
from masonry_opt.studies.run_columns import RUN_COLUMNS, framed


def same(one: pd.DataFrame, two: pd.DataFrame) -> None:
    """Hold two tables to be the same to the last digit, but for the time that runs took."""
    pd.testing.assert_frame_equal(one.drop(columns="seconds"), two.drop(columns="seconds"), check_exact=True)


def sampled(values: Any, drawn: pd.DataFrame | None = None, **columns: Any) -> Sample:
    """A sample with these load factors, and numbers drawn.

    A load factor of -inf is that of a scene that falls by itself, inf that of one that carries any load, and
    NaN that of an undecided run.
    """
    drawn = pd.DataFrame({"x": np.arange(len(values))}) if drawn is None else drawn
    values = np.asarray(values, dtype=float)
    load_factor = np.where(np.isfinite(values), values, np.nan)
    given = {"load_factor": load_factor, "any_load": np.isposinf(values)}
    given["status"] = np.where(np.isneginf(values), str(Status.UNSTABLE), "optimal")
    given |= {"state_from": "", "warnings": ""} | columns
    table = framed(drawn.assign(**given).to_dict("records"), list(drawn), RUN_COLUMNS)
    return Sample(case="made", table=table, drawn=tuple(drawn), distributions=dict.fromkeys(drawn, "made"))
