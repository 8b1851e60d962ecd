"""Test that the list of all sentences that the program can print is up to date."""

from report.printed_sentences import LISTED, printed_sentences
from sources import parsed


def test_the_list_of_printed_sentences_is_up_to_date():
    """After a change of a sentence, ``python tests/report/printed_sentences.py`` writes the list anew."""
    assert printed_sentences(parsed) == LISTED.read_text("utf-8")
