"""Everything that can go wrong, and the exit code each outcome has.

RobimpError                    1  internal error
├── InputError                 2  a file, line, column, key: what was expected and what to do
├── InfeasibleError            3  no controller can: the constraint, the frequency, by how much
├── RefutedError               4  a claim is false: its witness
├── UndecidedError             5  neither proven nor refuted in the time given
└── MismatchError              6  certificate and specification do not belong together
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class ExitCode(IntEnum):
    """Process exit codes; frozen."""

    PROVEN = 0
    INTERNAL = 1
    INPUT = 2
    INFEASIBLE = 3
    REFUTED = 4
    UNDECIDED = 5
    MISMATCH = 6


class RobimpError(Exception):
    """Base of every error this package raises on purpose."""

    exit_code = ExitCode.INTERNAL


@dataclass(frozen=True)
class Location:
    """Where in a user's file something is: `file:line:column: key`."""

    file: str
    line: int | None = None
    column: int | None = None
    key: str | None = None

    def __str__(self) -> str:
        place = ":".join(str(part) for part in (self.file, self.line, self.column) if part is not None)
        return f"{place}: {self.key}" if self.key else place


class InputError(RobimpError):
    """A specification, certificate or data file that cannot be used."""

    exit_code = ExitCode.INPUT

    def __init__(self, message: str, location: Location | None = None) -> None:
        self.message, self.location = message, location
        super().__init__(f"{location}: {message}" if location else message)


class InfeasibleError(RobimpError):
    """No controller, of any order, can satisfy a constraint at some frequency; what: the constraints, by name."""

    exit_code = ExitCode.INFEASIBLE

    def __init__(self, message: str, what: str = "") -> None:
        self.what = what
        super().__init__(message)


class RefutedError(RobimpError):
    """A required claim is false."""

    exit_code = ExitCode.REFUTED


class UndecidedError(RobimpError):
    """Nothing was proven and nothing refuted."""

    exit_code = ExitCode.UNDECIDED


class MismatchError(RobimpError):
    """Certificate and specification, or controller, do not belong together."""

    exit_code = ExitCode.MISMATCH
