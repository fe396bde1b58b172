"""What patchwright raises. Messages are those of the command line: one line that names file, element and value.

A result that misses its tolerance raises nothing: see Result.verdict.
"""


class PatchwrightError(Exception):
    """Base of all errors of this package."""

    exit_code: int = 5
    """What the command line would have ended with."""


class UsageError(PatchwrightError, ValueError):
    """An argument is wrong: its type, shape, value or name."""

    exit_code = 1


class InputError(PatchwrightError):
    """A file or its content cannot be used: missing, unreadable, malformed, unsuitable."""

    exit_code = 2


class TimeLimitError(PatchwrightError):
    """The time limit was reached before there was a first result; nothing was written."""

    exit_code = 3


class OutputError(PatchwrightError):
    """A file could not be written; the one that was there before is intact."""

    exit_code = 4


class InternalError(PatchwrightError):
    """Memory is used up, the system refuses, or a bug: please report the latter."""

    exit_code = 5


class CancelledError(PatchwrightError):
    """The progress callback returned False, or the event given as cancel is set."""

    exit_code = 130
