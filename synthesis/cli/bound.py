"""`robimp bound`: what no controller in a large basis can beat."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .common import Json, dumped, located, say


def bound(
    spec: Annotated[Path, typer.Argument(metavar="SPEC", help="Specification file (YAML).")],
    terms: Annotated[
        int | None, typer.Option(min=16, max=200, help="Functions in the basis of Q̃; default: as many as it takes.")
    ] = None,
    as_json: Json = False,
) -> None:
    """The bandwidth no controller in the basis can beat, and which constraint sets it, where."""
    from .. import api
    from ..report.progress import status_line

    with located(spec), status_line() as progress:
        limit = api.bound(spec, terms, progress)
    if as_json:
        say(dumped(limit.to_json()))
        return
    from ..report.terminal import console, show_bound

    show_bound(limit, console())
