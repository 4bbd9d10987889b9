"""`robimp synth`: from a specification to a proven controller."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import ExitCode, InputError, RobimpError
from .common import Json, complain, dumped, finish, located, say

if TYPE_CHECKING:
    from ..spec.model import Spec

Specs = Annotated[list[Path], typer.Argument(metavar="SPEC...", help="Specification files (YAML).")]
TimeLimit = Annotated[float | None, typer.Option(metavar="SECONDS", min=0.0, help="Stop searching after this long.")]


def synth(
    specs: Specs,
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="DIR", help="Default: out/NAME.")] = None,
    time_limit: TimeLimit = None,
    as_json: Json = False,
) -> None:
    """Find the controller of largest bandwidth, prove it, have the proof re-checked, simulate it."""
    from ..spec import load_spec, spec_warnings
    from ..storage import demand_writable

    loaded = [(path, load_spec(path)) for path in specs]
    folders = _folders([spec for _, spec in loaded], output)
    for folder in folders:
        demand_writable(folder)
    codes = []
    for (path, spec), folder in zip(loaded, folders, strict=True):
        for warning in spec_warnings(spec):
            complain(f"{path}: warning: {warning}")
        codes.append(_synth_one(path, spec, folder, time_limit, as_json))
    finish(codes)


def _folders(specs: list[Spec], output: Path | None) -> list[Path]:
    names = [spec.name for spec in specs]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"two specifications are named '{twice}' and would write the same folder; rename one")
    if output is not None and len(specs) == 1:
        return [output]
    return [(output or Path("out")) / name for name in names]


def _synth_one(path: Path, spec: Spec, folder: Path, time_limit: float | None, as_json: bool) -> ExitCode:
    from ..pipeline import synthesize
    from ..report.progress import status_line
    from ..report.summary import simulation, summary
    from ..storage import write_atomic

    try:
        with located(path), status_line() as progress:
            result = synthesize(spec, progress, time_limit=time_limit)
    except RobimpError:
        if (folder / "certificate.json").exists():
            complain(f"{path}: note: {folder / 'certificate.json'} is from an earlier run")
        raise
    write_atomic(folder / "simulation.json", dumped(simulation(result)).encode())
    write_atomic(folder / "certificate.json", result.certificate_bytes())
    if as_json:
        say(dumped({"file": str(folder / "certificate.json"), **summary(result)}))
        return result.exit_code
    from ..report.terminal import console, show

    show(result, console())
    say(f"certificate: {folder / 'certificate.json'}")
    return result.exit_code
