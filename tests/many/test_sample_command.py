"""`sweep --sample`, as a user runs it."""

import pandas as pd
import pytest
from scenes import run_command


@pytest.mark.usefixtures("without_charts")
def test_a_sample_is_written_and_told(case, tmp_path, monkeypatch, capsys):
    asked = ("--sample", "joints.friction=lognormal:0.4:25%", "-n", "4", "--seed", "3", "--method", "static")
    code, out, _ = run_command(
        monkeypatch, capsys, "sweep", case, *asked, "--workers", "1", "--out", tmp_path / "out"
    )
    assert code == 0
    assert "rank correlation" in out
    kept = pd.read_csv(tmp_path / "out" / "runs.csv")
    pd.testing.assert_series_equal(
        kept["load_factor"], kept["joints.friction"].clip(upper=0.5), check_names=False, rtol=1e-7
    )


@pytest.mark.parametrize(
    "asked",
    [
        (),
        ("--sample", "joints.friction=gamma:1:2"),
        ("--sample", "joints.friction=normal:0.1:1"),
        ("--sample", "joints.friction=normal:1:0.01", "--vary", "joints.friction=0.3,0.4"),
        ("--sample", "joints.friction=normal:1:0.01", "--by", "stone"),
        ("--vary", "joints.friction=0.3,0.4", "--runs", "128"),
        ("--vary", "joints.friction=0.3,0.4", "--seed", "0"),
        ("--vary", "joints.friction=0.3,0.4", "--by", "course"),
        ("--vary", "joints.friction=0.3,0.4", "-o", "out=elsewhere"),
        ("--sample", "joints.friction=normal:1:0.01", "--method", "refined", "-o", "seed=1"),
    ],
)
def test_what_is_wrong_is_said(case, asked, tmp_path, monkeypatch, capsys):
    code, out, err = run_command(monkeypatch, capsys, "sweep", case, *asked, "--out", tmp_path / "out")
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert not (tmp_path / "out").exists()
