"""One cell of a map: what is asked of a worker, and what it answers. Runs in another process, or on another machine."""

from __future__ import annotations

import time
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from ..errors import ExitCode, InfeasibleError, RobimpError
from ..spec.exact import number_text
from ..spec.model import Polynomials, Spec

if TYPE_CHECKING:
    from ..pipeline import Result


class Status(Enum):
    """How a cell ended. Everything but UNDECIDED and ERROR is an answer."""

    PROVEN = "proven"
    REFUTED = "refuted"  # a given controller, with its witness
    INFEASIBLE = "infeasible"  # no controller can, and why
    UNDECIDED = "undecided"  # none was found that can be proven
    ERROR = "error"


BY_CODE = {
    ExitCode.INFEASIBLE: Status.INFEASIBLE,
    ExitCode.REFUTED: Status.REFUTED,
    ExitCode.UNDECIDED: Status.UNDECIDED,
}


@dataclass(frozen=True)
class Start:
    """A neighbour's controller, its bandwidth [rad/s], and the corner of its force filter [rad/s] if that was free."""

    coefficients: Polynomials
    omega_B: Fraction
    corner: Fraction | None = None


@dataclass(frozen=True)
class Task:
    """A cell to solve. time_limit [s] bounds the search."""

    index: tuple[int, int]
    spec: Spec
    start: Start | None = None
    time_limit: float | None = None


@dataclass(frozen=True)
class Cell:
    """A solved cell. omega_B: proven [rad/s]; cause: what cells of one reason share; reason: all of it."""

    index: tuple[int, int]
    status: Status
    omega_B: Fraction | None = None
    cause: str = ""
    reason: str = ""
    seconds: float = 0.0
    coefficients: Polynomials | None = None
    corner: Fraction | None = None  # of the force filter, where it was free [rad/s]

    @property
    def start(self) -> Start | None:
        """What a neighbour's search may start from."""
        if self.coefficients is None or self.omega_B is None:
            return None
        return Start(self.coefficients, self.omega_B, self.corner)

    def to_json(self) -> dict[str, Any]:
        """As a line of the journal; numbers that matter are exact text."""
        return {
            "cell": list(self.index),
            "status": self.status.value,
            "omega_B": None if self.omega_B is None else number_text(self.omega_B),
            "cause": self.cause,
            "reason": self.reason,
            "seconds": round(self.seconds, 3),
            "coefficients": None if self.coefficients is None else _plain(self.coefficients),
            "force_filter": None if self.corner is None else number_text(self.corner),
        }

    @classmethod
    def from_json(cls, line: dict[str, Any]) -> Cell:
        """The inverse. Raises: KeyError, TypeError, ValueError or AttributeError for anything else."""
        i, j = line["cell"]
        given, corner = line["coefficients"], line.get("force_filter")  # a younger key: older journals go on
        return cls(
            (int(i), int(j)),
            Status(line["status"]),
            None if line["omega_B"] is None else Fraction(line["omega_B"]),
            str(line["cause"]),
            str(line["reason"]),
            float(line["seconds"]),
            None if given is None else Polynomials(**{k: tuple(map(Fraction, v)) for k, v in given.items()}),
            None if corner is None else Fraction(corner),
        )


def _plain(coefficients: Polynomials) -> dict[str, list[str]]:
    return {
        "numerator": [number_text(c) for c in coefficients.numerator],
        "denominator": [number_text(c) for c in coefficients.denominator],
    }


def solve_cell(task: Task) -> tuple[Cell, bytes | None]:
    """A cell's answer, whatever happens in it, and the certificate of a proven one."""
    from ..pipeline import synthesize

    began = time.monotonic()

    def failed(status: Status, cause: str, reason: str) -> tuple[Cell, None]:
        return Cell(task.index, status, None, cause, reason, time.monotonic() - began), None

    try:
        starts = _starts(task.spec, task.start)
        result = synthesize(task.spec, time_limit=task.time_limit, starts=starts, advise=False)
    except InfeasibleError as error:
        return failed(Status.INFEASIBLE, error.what or "infeasible", str(error))
    except RobimpError as error:
        status = BY_CODE.get(error.exit_code, Status.ERROR)
        return failed(status, status.value, str(error))
    except Exception as error:  # a cell must not end the map
        return failed(Status.ERROR, type(error).__name__, f"{type(error).__name__}: {error}")
    return _answer(task, result, time.monotonic() - began)


def _starts(spec: Spec, start: Start | None) -> tuple[tuple[Polynomials, float], ...]:
    """For a free filter the neighbour's controller with its own in it: the search begins from what the two do."""
    if start is None:
        return ()
    given = start.coefficients
    if start.corner is not None:
        from ..problem.setting import Setting

        given = Setting.of(spec).resolved(start.corner).unfiltered(given)
    return ((given, float(start.omega_B)),)


def _answer(task: Task, result: Result, seconds: float) -> tuple[Cell, bytes | None]:
    from ..certificate.outcome import Outcome

    if result.outcome is Outcome.PROVEN:
        corner = None if result.corner is None else result.corner.omega
        cell = Cell(task.index, Status.PROVEN, result.omega_B, "", "", seconds, result.coefficients, corner)
        return cell, result.certificate_bytes()
    short = [c for c in result.claims if c.required and c.status is not Outcome.PROVEN]
    status = Status.REFUTED if result.outcome is Outcome.REFUTED else Status.UNDECIDED
    reason = f"not proven: {', '.join(f'{c.id} {c.form}' for c in short)}"
    return Cell(task.index, status, None, short[0].id, reason, seconds, result.coefficients), None
