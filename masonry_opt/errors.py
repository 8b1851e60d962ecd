"""What a user can put right: every error here ends as one message, never as a traceback."""


class MasonryError(Exception):
    """Base of the errors whose message tells a user what to do."""


class CaseError(MasonryError):
    """A case file or scene is wrong; the message names the file, the key or block, and the remedy."""


class OptionError(MasonryError):
    """A method, model, solver or option is wrong or not available here."""
