"""Tables in a folder: replaced by those that have all of their runs, others by force alone."""

import csv

import pytest
from scenes import block_on_floor

import masonry_opt as mo
from masonry_opt.errors import OptionError

pytestmark = pytest.mark.usefixtures("without_charts")

FRICTIONS = [0.1, 0.2, 0.3, 0.30000000000000004]


def swept(out, of, **keys):
    return mo.sweep(block_on_floor(), {"joints.friction": of}, method="static", workers=1, out=out, **keys)


def sampled(out, n, **keys):
    drawn = {"joints.friction": ("uniform", 0.3, 0.5)}
    return mo.sample(block_on_floor(), drawn, n=n, method="static", workers=1, out=out, **keys)


def frictions_in(out):
    with (out / "runs.csv").open(encoding="utf-8", newline="") as stream:
        return [float(row["joints.friction"]) for row in csv.DictReader(stream)]


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("others", [[0.1], [0.5, *FRICTIONS[:3]], [0.5, 0.6, 0.7, 0.8, 0.9]])
def test_a_table_does_not_lose_runs_to_another(tmp_path, others):
    """Not to a smaller sweep, nor to a larger one without some of them; nothing there is touched."""
    swept(tmp_path, FRICTIONS)
    before = contents(tmp_path)
    with pytest.raises(OptionError, match=r"runs\.csv.* another folder.*--force"):
        swept(tmp_path, others)
    assert contents(tmp_path) == before
    swept(tmp_path, others, force=True)
    assert frictions_in(tmp_path) == others
    # What was replaced by force is made of the journal again, without a run.
    journal = (tmp_path / "journal.jsonl").read_bytes()
    swept(tmp_path, FRICTIONS, force=True)
    assert frictions_in(tmp_path) == FRICTIONS
    assert (tmp_path / "journal.jsonl").read_bytes() == journal


def test_a_table_is_replaced_by_one_with_all_of_its_runs(tmp_path):
    swept(tmp_path, FRICTIONS[1:3])
    swept(tmp_path, FRICTIONS[1:3])
    swept(tmp_path, [*reversed(FRICTIONS), 7])
    assert frictions_in(tmp_path) == [*reversed(FRICTIONS), 7]


def test_a_sample_is_replaced_by_a_larger_one_alone(tmp_path):
    sampled(tmp_path, 2)
    sampled(tmp_path, 4)
    before = contents(tmp_path)
    with pytest.raises(OptionError, match="--force"):
        sampled(tmp_path, 2)
    with pytest.raises(OptionError, match="--force"):
        swept(tmp_path, FRICTIONS)
    assert contents(tmp_path) == before
    assert sampled(tmp_path, 2, force=True).runs == 2
    assert len(frictions_in(tmp_path)) == 2


@pytest.mark.parametrize("content", ["", "date,miles\nmonday,3\n", '"', "\udcff"])
def test_a_table_of_someone_else_is_kept(tmp_path, content):
    (tmp_path / "runs.csv").write_bytes(content.encode("utf-8", "surrogateescape"))
    before = contents(tmp_path)
    with pytest.raises(OptionError, match=r"runs\.csv.*--force"):
        swept(tmp_path, FRICTIONS)
    assert contents(tmp_path) == before
    swept(tmp_path, FRICTIONS, force=True)
    assert frictions_in(tmp_path) == FRICTIONS


def test_no_zero_of_a_table_has_a_sign(tmp_path):
    """A block of no friction that nothing pushes but its weight: λ is zero, of either sign."""
    frame = swept(tmp_path, [-0.0, 0.5])
    assert "-0.0" not in (tmp_path / "runs.csv").read_text()
    assert "-0.0" not in frame.to_csv()
