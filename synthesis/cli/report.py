"""`robimp report`: certificates, or a map, as a page to read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import ExitCode, InputError, Location
from .common import Json, bounded_bytes, complain, dumped, finish, say

if TYPE_CHECKING:
    from ..check import Verdict

Certificates = Annotated[list[Path], typer.Argument(metavar="CERT...", help="Certificate files, or one map.json.")]
Output = Annotated[
    Path | None,
    typer.Option("--output", "-o", metavar="FILE", help="Default: report.html beside the (first) file."),
]


def report(
    certificates: Certificates,
    output: Output = None,
    time_limit: Annotated[float, typer.Option(metavar="SECONDS", min=0.01, help="For each check.")] = 60.0,
    as_json: Json = False,
) -> None:
    """Write a page (HTML, one file, works offline) about certificates, each re-checked first; several are compared.

    About a map.json of `robimp map`: the picture of the plane, and why cells are not proven.
    """
    from ..report.html.recorded import MAX_BYTES, is_map
    from ..report.progress import status_line
    from ..storage import demand_replaceable

    path = output or certificates[0].parent / "report.html"
    contents = {str(file): bounded_bytes(file, MAX_BYTES) for file in certificates}
    _demand_distinct(certificates, path)
    demand_replaceable(path)
    maps = [file for file, data in contents.items() if is_map(data)]
    if maps:
        if len(contents) > 1:
            raise InputError("is a map: report it alone", Location(maps[0]))
        finish([_report_map(maps[0], contents[maps[0]], path, as_json)])
    with status_line() as progress:
        progress("loading")
        from ..report.html import write_report

        verdicts = write_report(_shown(contents), path, progress, time_limit=time_limit)
    _say(list(contents), verdicts, path, as_json)
    finish([ExitCode(verdict.exit_code) for verdict in verdicts])


def _report_map(file: str, data: bytes, path: Path, as_json: bool) -> ExitCode:
    from ..report.progress import status_line

    with status_line() as progress:
        progress("loading")
        from ..report.html import write_map_report

        code = write_map_report(data, Path(file).name, path, progress)
    said = dumped({"report": str(path), "map": {"file": file, "exit_code": int(code)}})
    say(said if as_json else f"MAP  {file}\nreport: {path}")
    return code


def _demand_distinct(certificates: Sequence[Path], path: Path) -> None:
    for certificate in certificates:
        if path.absolute() == certificate.absolute() or (path.exists() and path.samefile(certificate)):
            raise InputError(f"would overwrite {certificate}; give another -o", Location(str(path)))


def _shown(contents: dict[str, bytes]) -> dict[str, bytes]:
    """Certificates by the name the page shows: the file's own where that tells them apart."""
    names = [Path(file).name for file in contents]
    if len(set(names)) < len(names):
        return contents
    return dict(zip(names, contents.values(), strict=True))


def _say(files: Sequence[str], verdicts: Sequence[Verdict], path: Path, as_json: bool) -> None:
    if as_json:
        found = [
            {"file": file, "exit_code": verdict.exit_code, "message": verdict.message}
            for file, verdict in zip(files, verdicts, strict=True)
        ]
        say(dumped({"report": str(path), "certificates": found}))
        return
    for file, verdict in zip(files, verdicts, strict=True):
        if verdict.exit_code == ExitCode.PROVEN:
            say(f"PROVEN  {file}  {verdict.message}")
        else:
            complain(f"{file}: {verdict.message}")
    say(f"report: {path}")
