"""`robimp simulate`: a certificate back in the time domain."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from ..errors import ExitCode, InputError, Location, MismatchError
from .common import Json, certificate_bytes, complain, dumped, finish, say


def simulate(
    certificate: Annotated[Path, typer.Argument(metavar="CERT", help="Certificate file (JSON).")],
    as_json: Json = False,
) -> None:
    """Move the certified joint in the time domain: every corner of every box; agrees or contradicts."""
    from ..check import check_bytes
    from ..replay import replay
    from ..report.progress import status_line

    data = certificate_bytes(certificate)
    checked = check_bytes(data)
    if checked.exit_code == ExitCode.INPUT:
        raise InputError(checked.message, Location(str(certificate)))
    if checked.exit_code == ExitCode.MISMATCH:
        raise MismatchError(f"{certificate}: {checked.message}")
    with status_line() as progress:
        trials, agreement = replay(json.loads(data), checked, str(certificate), progress)
    agrees = not agreement.contradictions
    if as_json:
        say(dumped({"agrees": agrees, "contradictions": agreement.contradictions, **trials.to_json()}))
    elif agrees:
        say(f"AGREES  {certificate}  {agreement.summary(len(trials.trials))}")
    for contradiction in agreement.contradictions:
        complain(f"{certificate}: contradicts: {contradiction}")
    finish([ExitCode.PROVEN if agrees else ExitCode.REFUTED])
