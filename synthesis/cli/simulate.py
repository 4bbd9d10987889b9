"""`robimp simulate`: a certificate back in the time domain."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from ..errors import ExitCode, InputError, Location, MismatchError
from .common import Json, certificate_bytes, complain, dumped, finish, say

Loads = Annotated[int, typer.Option(metavar="N", min=0, help="Loads to draw; 0: only the corners, no attacks.")]
Seed = Annotated[int, typer.Option(min=0, help="Of the loads drawn and their torques.")]
ExperimentName = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="Repeat the paper's fig9, fig10, fig11 or fig12 on this joint instead."),
]
Output = Annotated[
    Path | None, typer.Option("--output", "-o", metavar="DIR", help="Write simulation.json and joints.npz there.")
]


def simulate(
    certificate: Annotated[Path, typer.Argument(metavar="CERT", help="Certificate file (JSON).")],
    loads: Loads = 10_000,
    seed: Seed = 0,
    output: Output = None,
    experiment: ExperimentName = None,
    as_json: Json = False,
) -> None:
    """Move the certified joint in the time domain, attack every claim; agrees or contradicts."""
    from ..check import check_bytes
    from ..replay import repeat_experiment, replay
    from ..report.progress import status_line
    from ..report.simulated import arrays, summary, table
    from ..storage import demand_writable, write_atomic

    if output is not None:
        demand_writable(output)
    data = certificate_bytes(certificate)
    checked = check_bytes(data)
    if checked.exit_code == ExitCode.INPUT:
        raise InputError(checked.message, Location(str(certificate)))
    if checked.exit_code == ExitCode.MISMATCH:
        raise MismatchError(f"{certificate}: {checked.message}")
    content = json.loads(data)
    if experiment is not None:
        seen = repeat_experiment(content, str(certificate), experiment)
        if output is not None:
            write_atomic(output / f"{experiment}.json", dumped(seen.to_json()).encode())
        say(
            dumped(seen.to_json()) if as_json else "\n".join([seen.title, *(f"  {each}" for each in seen.observations)])
        )
        finish([ExitCode.PROVEN])
    with status_line() as progress:
        done = replay(content, checked, str(certificate), progress, count=loads, seed=seed)
    agrees = not done.contradictions
    found = {"agrees": agrees, "contradictions": done.contradictions, "seed": seed, **summary(done)}
    if output is not None:
        write_atomic(output / "joints.npz", arrays(done))
        write_atomic(output / "simulation.json", dumped(found).encode())
    if as_json:
        say(dumped(found))
    elif agrees:
        say(f"AGREES  {certificate}  {done.agreement.summary(len(done.trials.trials))}")
        if done.attacked:
            say(done.attacked.summary())
            say(table(done))
            for finding in done.attacked.findings:
                say(f"  {finding}")
    for contradiction in done.contradictions:
        complain(f"{certificate}: contradicts: {contradiction}")
    finish([ExitCode.PROVEN if agrees else ExitCode.REFUTED])
