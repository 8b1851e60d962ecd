"""What a user can put right: every error here ends as one message, never as a traceback."""


class MasonryError(Exception):
    """Base of the errors whose message tells a user what to do."""

    #: What the command line ends with.
    exit_code = 2


class CaseError(MasonryError):
    """A case file or scene is wrong; the message names the file, the key or block, and the remedy."""


class OptionError(MasonryError):
    """A method, model, solver or option is wrong or not available here."""


class NoLoadFactorError(MasonryError):
    """What was asked for needs a load factor and the scene has none; the message says why."""

    exit_code = 1
