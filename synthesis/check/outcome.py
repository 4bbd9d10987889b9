"""What stops a check, with its exit code, and the clock that needs no signals."""

import time

UNREADABLE = 2  # input that is not a certificate of this format; one line that names the field
FALSE = 4  # a statement of the certificate that does not hold
UNDECIDED = 5  # out of time, or out of the work allowed for one step
MISMATCH = 6  # a certificate that does not prove what its own specification asks for


class CheckError(Exception):
    """A check that ends without a proof: its exit code and one line."""

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = code


def demand(holds: bool, message: str, code: int = UNREADABLE) -> None:
    """Raise CheckError unless the condition holds."""
    if not holds:
        raise CheckError(code, message)


def tick(deadline: float) -> None:
    """Raise CheckError once the time, monotonic, is over; called inside every loop of unknown length."""
    demand(time.monotonic() <= deadline, "time limit reached", UNDECIDED)
