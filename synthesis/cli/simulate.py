"""`robimp simulate`: a certificate back in the time domain."""

from __future__ import annotations

import json
from enum import StrEnum
from math import inf, isinf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import ExitCode, InputError, Location, MismatchError
from .common import Json, certificate_bytes, complain, dumped, finish, say

if TYPE_CHECKING:
    from ..challenge import Reality

Loads = Annotated[
    int, typer.Option(metavar="N", min=0, max=1_000_000, help="Loads to draw; 0: only the corners, no attacks.")
]
Seed = Annotated[int, typer.Option(min=0, help="Of the loads drawn and their torques.")]
ExperimentName = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="Repeat the paper's fig9, fig10, fig11, fig12 or hunting on this joint."),
]
Output = Annotated[
    Path | None, typer.Option("--output", "-o", metavar="DIR", help="Write simulation.json and joints.npz there.")
]


class Precision(StrEnum):
    """Of a sampled controller's arithmetic."""

    double = "double"
    single = "float"


SLOWEST, FASTEST = 1.0, 100_000.0  # Hz: the joints drawn move for 10 to 100 s
ALONE = ("certificate", "experiment", "output", "as_json")  # what an experiment takes


def _extra(help: str, least: float = 0, most: float | None = None) -> Any:
    return typer.Option(help=f"{help}. Not certified: for information.", min=least, max=most)


def simulate(
    context: typer.Context,
    certificate: Annotated[Path, typer.Argument(metavar="CERT", help="Certificate file (JSON).")],
    loads: Loads = 10_000,
    seed: Seed = 0,
    output: Output = None,
    experiment: ExperimentName = None,
    friction_load: Annotated[float, _extra("Coulomb friction on the load, N·m (N)")] = 0.0,
    friction_motor: Annotated[float, _extra("Coulomb friction on the motor, N·m (N)")] = 0.0,
    stiction: Annotated[float, _extra("What friction holds at rest, over Coulomb's", 1)] = 1.0,
    torque_limit: Annotated[float, _extra("Largest torque of the drive, N·m (N)")] = inf,
    encoder: Annotated[float, _extra("Step of the encoder, rad (m)")] = 0.0,
    noise: Annotated[float, _extra("Noise of the torque sensor, rms N·m (N)")] = 0.0,
    rate: Annotated[float | None, _extra("Sample the controller at this rate, Hz", SLOWEST, FASTEST)] = None,
    precision: Annotated[
        Precision, typer.Option(help="Arithmetic of the sampled controller. Not certified: for information.")
    ] = Precision.double,
    as_json: Json = False,
) -> None:
    """Move the certified joint in the time domain, attack every claim; agrees or contradicts."""
    from ..check import check_bytes
    from ..replay import repeat_experiment, replay
    from ..report.progress import status_line
    from ..report.simulated import arrays, summary, table
    from ..storage import demand_writable, write_atomic

    if experiment is not None:
        _demand_alone(context)
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
        if checked.exit_code != ExitCode.PROVEN:
            complain(f"{certificate}: {checked.message}")
            finish([ExitCode(checked.exit_code)])
        seen = repeat_experiment(content, str(certificate), experiment)
        if output is not None:
            write_atomic(output / f"{experiment}.json", dumped(seen.to_json()).encode())
        lines = [seen.title, *(f"  note: {each}" for each in seen.notes), *(f"  {each}" for each in seen.observations)]
        say(dumped(seen.to_json()) if as_json else "\n".join(lines))
        finish([ExitCode.PROVEN])
    faults = (friction_load, friction_motor, torque_limit, encoder, noise, stiction)
    real = reality(*faults, rate=rate, precision=precision, loads=loads, sampled=bool(content["spec"].get("sampling")))
    with status_line() as progress:
        done = replay(content, checked, str(certificate), progress, count=loads, seed=seed, reality=real)
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


def _demand_alone(context: typer.Context) -> None:
    """An experiment is the paper's: nothing else can be asked of it. Raises: InputError."""
    others = [
        f"--{name.replace('_', '-')}" for name in context.params
        if name not in ALONE and getattr(context.get_parameter_source(name), "name", "DEFAULT") != "DEFAULT"
    ]  # fmt: skip
    if others:
        raise InputError(f"--experiment has its own loads and friction: leave out {', '.join(others)}")


def reality(*faults: float, rate: float | None, precision: Precision, loads: int, sampled: bool) -> Reality | None:
    """What the options ask for beyond the certificate; None: nothing.

    Raises: InputError for options that are not finite or contradict each other.
    """
    from ..challenge import IDEAL, Imperfections, Reality

    if sum(isinf(value) for value in (*faults, rate or 0)) > isinf(Imperfections(*faults).torque_limit):
        raise InputError("friction, encoder, noise and rate must be finite")
    real = Reality(Imperfections(*faults), rate or None, "float32" if precision is Precision.single else "float64")
    if real == IDEAL:
        return None
    if not loads:
        raise InputError("friction, limits, noise and rate act on the loads drawn: --loads must not be 0")
    digital = real.faults.encoder or real.faults.torque_noise or precision is Precision.single
    if digital and not (sampled or real.rate):
        raise InputError("--encoder, --noise and --precision act on a sampled controller: give its --rate as well")
    return real
