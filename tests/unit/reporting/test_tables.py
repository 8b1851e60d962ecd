"""Printed tables: numbers of a column have a format, and the text contains the table everywhere."""

import pandas as pd
import pytest

from masonry_opt.reporting.terminal import frame_text

TABLE = pd.DataFrame(
    {"direction (°)": [0.0, 22.5], "vertical / horizontal": [0.0, -0.3], "load_factor": [1.0, 0.12345678]}
)


def test_angles_and_ratios_have_no_more_digits_than_their_value():
    rows = frame_text(TABLE, "").splitlines()
    assert [row.split() for row in rows[-3:-1]] == [["0", "0", "1.00000"], ["22.5", "-0.3", "0.12346"]]


@pytest.mark.parametrize("in_notebook", [False, True])
def test_a_table_is_text_in_a_notebook_too(in_notebook, monkeypatch, capsys):
    """Rich shows what is printed in a notebook as an output of the cell, whatever file it is printed to."""
    monkeypatch.setattr("rich.console._is_jupyter", lambda: in_notebook)
    monkeypatch.setenv("FORCE_COLOR", "1")
    text = frame_text(TABLE, "results")
    assert "0.12346" in text
    assert "\x1b" not in text
    assert capsys.readouterr().out == ""
