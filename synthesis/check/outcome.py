"""What can stop a check, and the clock that does it without signals."""

from __future__ import annotations

import time


class UnreadableError(Exception):
    """Input that is not a certificate of this format; one line that names the field (exit code 2)."""


class MismatchError(Exception):
    """A certificate that does not prove what its own specification asks for (exit code 6)."""


class FalseClaimError(Exception):
    """A statement of the certificate that does not hold (exit code 4)."""


class UndecidedError(Exception):
    """Out of time, or out of the work allowed for one step (exit code 5)."""


class Clock:
    """A deadline that is looked at inside every loop of unknown length."""

    def __init__(self, seconds: float) -> None:
        self.deadline = time.monotonic() + seconds

    def tick(self) -> None:
        """Raise UndecidedError once the time is over."""
        if time.monotonic() > self.deadline:
            raise UndecidedError("time limit reached")
