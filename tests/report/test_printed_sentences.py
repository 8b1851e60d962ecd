"""The list of all sentences that the program can print is up to date."""

from report.printed_sentences import LISTED, printed_sentences


def test_the_list_of_printed_sentences_is_up_to_date():
    """A sentence that changed is read again: ``python tests/report/printed_sentences.py`` lists it anew."""
    assert printed_sentences() == LISTED.read_text("utf-8")
