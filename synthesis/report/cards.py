"""Results as they look in a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..errors import ExitCode
from ..notebook import card
from .terminal import HEADINGS, cells, decimal

if TYPE_CHECKING:
    from ..check import Verdict
    from ..judgement import Judgement
    from ..pipeline import Result
    from ..sweep.result import Map

TONE = {ExitCode.PROVEN: "good", ExitCode.UNDECIDED: "open"}  # anything else is bad
MOST_CELLS = 30  # rows and columns of a map in a notebook


def tone(code: int) -> str:
    """The colour of an outcome."""
    return TONE.get(ExitCode(code), "bad")


def result_card(result: Result) -> str:
    """Verdict, bandwidth, controller, claims."""
    rows = []
    if result.exit_code is ExitCode.PROVEN:
        rows.append(("bandwidth", f"ω_B ≥ {decimal(result.omega_B)} rad/s"))
    if result.bound is not None and result.bound.limited:
        rows.append(("bound, of a solver", f"{result.bound.omega_B:.4g} rad/s"))
    rows.append(("Q(s)" if result.Q is not None else "C_imp(s)", str(result.coefficients)))
    if result.corner is not None:
        rows.append(("force filter found", f"{decimal(result.corner.omega)} rad/s"))
    claims = HEADINGS, [cells(claim, result.spec.motion) for claim in result.claims]
    return card(result.spec.name, result.outcome.name, tone(result.exit_code), rows, claims)


def judgement_card(judgement: Judgement) -> str:
    """What the checker says of a certificate, and whether it belongs to what it was compared with."""
    code = judgement.exit_code
    return card(judgement.file, code.name, tone(code), [("says", judgement.message)], _claims(judgement.verdict))


def _claims(verdict: Verdict) -> tuple[tuple[str, ...], list[tuple[str, str, str]]]:
    return ("claim", "form", "status"), [claim[:3] for claim in verdict.claims]


def map_card(found: Map) -> str:
    """A table of the plane, first axis upwards: ω_B [rad/s], or how the cell ended."""
    first, second = found.plane.axes
    said = ", ".join(f"{n} {status.value}" for status, n in found.counts.items() if n)
    rows, columns = range(min(len(first.values), MOST_CELLS)), range(min(len(second.values), MOST_CELLS))
    body = [
        [f"{first.floats[i]:.4g}"]
        + [
            cell.status.value if cell.omega_B is None else decimal(cell.omega_B)
            for cell in (found.cells[i, j] for j in columns)
        ]
        for i in reversed(rows)
    ]
    heading = [f"{first.key} ↑ {second.key} →", *(f"{second.floats[j]:.4g}" for j in columns)]
    return card(f"map of {found.plane.spec.name}", said, tone(found.exit_code), table=(heading, body))
