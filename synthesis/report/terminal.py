"""The result on a terminal: a table of claims, honest colours, plain text when piped."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from ..certificate.claim import Claim
from ..certificate.outcome import Outcome
from .phrases import margin_phrase

if TYPE_CHECKING:
    from ..pipeline import Result
    from ..solve.bound import Bound

HEADINGS = ("claim", "form", "on ω [rad/s]", "status", "proven margin", "next level fails at")
COLOUR = {Outcome.PROVEN: "green", Outcome.REFUTED: "red", Outcome.UNDECIDED: "yellow"}


def console() -> Console:
    """A console that keeps a table's rows on one line each when the output is piped."""
    plain = Console(highlight=False)
    return plain if plain.is_terminal else Console(highlight=False, width=160)


def show(result: Result, to: Console) -> None:
    """The verdict, the claims, what the simulation saw, and the controller."""
    colour = COLOUR[result.outcome]
    to.print(f"[bold {colour}]{result.outcome.name}[/]  {result.spec.name}  {_headline(result)}")
    to.print(_controller(result))
    if result.corner is not None:
        to.print(f"force filter {decimal(result.corner.omega)} rad/s, found with it")
    to.print(claims_table(result.claims, result.spec.motion))
    _show_bode(result, to)
    agreement, sampled = result.agreement, result.sampled
    to.print(f"simulation: {agreement.summary(len(result.trials.trials))}")
    for note in _notes(result):
        to.print(f"[yellow]note:[/] {note}")
    if sampled.rms_difference is not None and sampled.rms_theta:
        effect = f"changes the step response by {100 * sampled.rms_difference / sampled.rms_theta:.2g} % rms"
    else:
        effect = "is unstable" if not sampled.stable else "cannot be compared: the simulated loop is unstable"
    late = "" if not sampled.delay else f" and {sampled.delay} tick{'s' if sampled.delay > 1 else ''} late"
    to.print(f"for information, not certified: sampled at {sampled.rate:g} Hz{late} the controller {effect}")


def _show_bode(result: Result, to: Console) -> None:
    from .sparkline import bode_lines  # loads NumPy

    proven = result.outcome is Outcome.PROVEN
    for line in bode_lines(result.spec, result.coefficients, float(result.omega_B), proven, to):
        to.print(line, soft_wrap=True)


def _notes(result: Result) -> Iterator[str]:
    """What the claims do not say, though one could think so."""
    if result.outcome is Outcome.PROVEN and not result.robust:
        yield (
            "no claim covers loads other than the nominal one; (18) physical, or (12) structured or disc on the whole "
            "axis, would"
        )
    constraints, actuator = result.spec.constraints, result.spec.actuator
    if constraints.eq12 is not None and constraints.eq12.form == "paper" and actuator.type != "ideal":
        yield "(12) as printed speaks of an ideal actuator; form: structured or disc says whether this port is passive"
    for equation in result.unstable_behind_ideal:
        yield f"{equation} speaks of an ideal actuator, behind which this controller is not stable"


def _headline(result: Result) -> str:
    if result.outcome is not Outcome.PROVEN:
        short = [c.id for c in result.claims if c.required and c.status is not Outcome.PROVEN]
        return f"not proven: {', '.join(short)}"
    limit = result.bound
    bound = "" if limit is None else f", {'bound' if limit.limited else 'no bound below'} {limit.omega_B:.4g}"
    return f"ω_B ≥ {decimal(result.omega_B)} rad/s{bound}, in {result.seconds:.1f} s"


def _controller(result: Result) -> str:
    return f"{'Q' if result.spec.controller.type == 'dob' else 'C_imp'}(s) = {result.coefficients}"


def claims_table(claims: tuple[Claim, ...], motion: str) -> Table:
    """One row per claim: what it is, on which interval, its status, the margin and where the next level fails."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for heading in HEADINGS:
        table.add_column(heading)
    for claim in claims:
        id, form, span, status, margin, failure = cells(claim, motion)
        word, rest = status.split(" ")[0], status[len(claim.status.value) :]
        colour = COLOUR[claim.status] if claim.required else "dim"
        table.add_row(id, form, span, f"[{colour}]{word}[/]{rest}", margin, failure)
    return table


def cells(claim: Claim, motion: str) -> tuple[str, str, str, str, str, str]:
    """A claim's row, as plain text."""
    low, high = claim.interval
    span = f"[{decimal(low, ROUND_CEILING)}, {'∞' if high is None else decimal(high)}]"
    status = claim.status.value + ("" if claim.required else " (reported)")
    return claim.id, claim.form, span, status, _margin(claim, motion), _failure(claim)


def _margin(claim: Claim, motion: str) -> str:
    if claim.margin is None:
        return ""
    phrase, rounding = margin_phrase(claim.form, motion)
    return phrase.format(decimal(claim.margin, rounding))


def _failure(claim: Claim) -> str:
    if claim.refuted_at is None:
        return ""
    witness = claim.refuted_at.witness
    if witness is None:
        return decimal(claim.refuted_at.value)
    where = "∞" if witness.omega is None else decimal(witness.omega)
    return f"{decimal(claim.refuted_at.value)} at {where} rad/s"


def decimal(value: Fraction, rounding: str = ROUND_FLOOR) -> str:
    """Six digits for reading, rounded to where what is proven still holds; exact text is in the certificate."""
    short = Context(prec=6, rounding=rounding).divide(Decimal(value.numerator), Decimal(value.denominator))
    return f"{float(short):.6g}"


def show_bound(limit: Bound, to: Console) -> None:
    """The bound, what binds where, and what it leaves out."""
    if not limit.limited:
        to.print(
            f"[bold]bound[/]  nothing limits ω_B below {limit.omega_B:.4g} rad/s, far above the joint's frequencies"
        )
        return
    grown = "" if limit.growth is None else f"; enlarging the basis to them added {100 * limit.growth:.2g} %"
    to.print(f"[bold]bound[/]  ω_B ≤ {limit.omega_B:.4g} rad/s with {limit.terms} terms{grown}")
    if limit.stopped:
        to.print(f"  not enlarged further: {limit.stopped}")
    for b in limit.binding:
        to.print(f"  {b.constraint} binds between {b.low:.4g} and {b.high:.4g} rad/s, most at {b.most:.4g}")
    if limit.dropped:
        to.print(f"  left out, as not convex in Q̃ (this can only raise the figure): {', '.join(limit.dropped)}")
    to.print("a solver's figure on a frequency grid, not a proof")
