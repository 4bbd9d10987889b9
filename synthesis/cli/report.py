"""`robimp report`: certificates, or a map, as a page to read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import ExitCode
from .common import Json, complain, dumped, finish, say

if TYPE_CHECKING:
    from ..report.html.files import Reported

Files = Annotated[list[Path], typer.Argument(metavar="CERT...", help="Certificate files, or one map.json.")]
Output = Annotated[
    Path | None,
    typer.Option("--output", "-o", metavar="FILE", help="Default: report.html beside the (first) file."),
]


def report(
    certificates: Files,
    output: Output = None,
    time_limit: Annotated[float, typer.Option(metavar="SECONDS", min=0.01, help="For each check.")] = 60.0,
    as_json: Json = False,
) -> None:
    """Write a page (HTML, one file, works offline) about certificates, each re-checked first; several are compared.

    About a map.json of `robimp map`: the picture of the plane, and why cells are not proven.
    """
    from ..report.progress import status_line

    path = output or certificates[0].parent / "report.html"
    with status_line() as progress:
        progress("loading")
        from ..report.html.files import report_files

        found = report_files(certificates, path, progress, time_limit=time_limit)
    _say(found, path, as_json)
    finish([each.exit_code for each in found])


def _say(found: Sequence[Reported], path: Path, as_json: bool) -> None:
    if as_json:
        files = [{"file": each.file, "exit_code": int(each.exit_code), "message": each.message} for each in found]
        say(dumped({"report": str(path), "certificates": files}))
        return
    for each in found:
        if not each.message:
            say(f"MAP  {each.file}")
        elif each.exit_code is ExitCode.PROVEN:
            say(f"PROVEN  {each.file}  {each.message}")
        else:
            complain(f"{each.file}: {each.message}")
    say(f"report: {path}")
