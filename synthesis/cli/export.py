"""`robimp export`: a certified controller as code for a drive."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import ExitCode
from .common import Json, certificate_bytes, complain, dumped, finish, located, say

if TYPE_CHECKING:
    from ..export import Exported

Target = Annotated[str, typer.Option(metavar="TARGET", help="c, json, control or ros2.")]
Rate = Annotated[
    str | None,
    typer.Option(metavar="HZ", help="Rate of the control loop, '1 kHz'; needed where the spec has no sampling."),
]
Output = Annotated[
    Path | None, typer.Option("--output", "-o", metavar="DIR", help="Default: export/ beside the certificate.")
]


def export(
    certificate: Annotated[Path, typer.Argument(metavar="CERT", help="Certificate file (JSON).")],
    target: Target,
    rate: Rate = None,
    precision: Annotated[str, typer.Option(metavar="P", help="double or float.")] = "double",
    output: Output = None,
    force: Annotated[bool, typer.Option("--force", help="Write the files although a required claim is lost.")] = False,
    time_limit: Annotated[
        float, typer.Option(metavar="SECONDS", min=0.01, help="For the check, not the proofs.")
    ] = 60.0,
    as_json: Json = False,
) -> None:
    """Write a certified controller as discrete sections; what was certified is proven again for exactly these."""
    from ..report.progress import status_line
    from ..storage import demand_writable

    folder = output or certificate.parent / "export"
    demand_writable(folder)
    data = certificate_bytes(certificate)
    with status_line() as progress, located(certificate):
        progress("loading")
        from ..export import export as exported

        done = exported(
            data,
            target=target,
            rate=rate,
            precision=precision,
            time_limit=time_limit,
            progress=progress,
        )
        files = done.files
    proven = done.exit_code == ExitCode.PROVEN
    written = [str(path) for path in done.write(folder)] if proven or force else []
    if as_json:
        say(dumped({"exit_code": int(done.exit_code), "files": written, **done.to_json()}))
    else:
        _say(done, written)
    if not proven:
        complain(f"{certificate}: {_lost(done)}" + ("" if written else f"; {', '.join(files)} not written (--force)"))
    finish([done.exit_code])


def _say(done: Exported, written: list[str]) -> None:
    from ..export.carried import bandwidth

    word = "PROVEN" if done.exit_code == ExitCode.PROVEN else "LOST"
    say(f"{word}  {done.subject.name}  {bandwidth(done.claims)}; {done.subject.timing}")
    for claim in done.claims:
        say(f"  {claim.line}")
    for path in written:
        say(f"wrote {path}")


def _lost(done: Exported) -> str:
    from ..export.carried import LOST, bandwidth, lost

    short = [
        f"{each.id} {each.form}" + (f", {bandwidth([each])}" if each.status == LOST else "")
        for each in lost(done.claims)
    ]
    advice = (
        "give the specification `sampling: {rate: …, delay: …}` and synthesise again: then the hold is certified, too"
        if done.subject.assumed_hold
        else "ask the specification for some room, such as eq12: {form: structured, margin: 0.01}, or a higher rate"
    )
    if done.law.precision == "float":
        advice = f"try --precision double, or {advice}"
    return f"at this rate not proven: {', '.join(short)}; {advice}"
