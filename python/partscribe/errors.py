"""What partscribe raises. The answer of a verification is never an exception: out of tolerance is a result."""

from __future__ import annotations

import sys
import warnings


class Error(Exception):
    """The world did not allow it.

    Attributes
    ----------
    message : str
        One line: what was expected, what was found, where. Options are named as on the command line: `--force` is
        the argument `force`.
    exit_code : int
        With which the command line ends for the same reason.
    meaning : str
        What that code stands for.
    """

    exit_code = 5
    meaning = "an error"

    def __init__(self, message: str) -> None:
        self.message = " ".join(message.split("\n"))
        super().__init__(self.message)


class UsageError(Error):
    """The request makes no sense: an argument out of its range, a file that would be overwritten."""

    exit_code = 2
    meaning = "usage"


class InputError(Error):
    """A scan, a mesh, a model or a CAD file cannot be used."""

    exit_code = 3
    meaning = "input cannot be used"


class MissingProgramError(Error):
    """A program that is needed is not installed."""

    exit_code = 4
    meaning = "a needed program is missing"


class StoppedError(Error):
    """A limit of time or memory was reached, or there is no room to write."""

    exit_code = 5
    meaning = "cancelled, a limit reached, or no room to write"


class ScanWarning(UserWarning):
    """What was mended or left out, and what looks doubtful in a scan."""


def of_kind(exit_code: int) -> type[Error]:
    """The class whose errors end the command line with this code."""
    return next((kind for kind in Error.__subclasses__() if kind.exit_code == exit_code), Error)


def warn(lines: list[str]) -> None:
    """Warns of each line at the place that called the package."""
    frame, level = sys._getframe(), 1
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] == "partscribe":
        frame, level = frame.f_back, level + 1
    for line in lines:
        warnings.warn(line, ScanWarning, stacklevel=level)
