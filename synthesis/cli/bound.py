"""`robimp bound`: what no controller in a large basis can beat."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..errors import UndecidedError
from .common import Json, dumped, located, say


def bound(
    spec: Annotated[Path, typer.Argument(metavar="SPEC", help="Specification file (YAML).")],
    terms: Annotated[
        int | None, typer.Option(min=16, max=200, help="Functions in the basis of Q̃; default: as many as it takes.")
    ] = None,
    as_json: Json = False,
) -> None:
    """The bandwidth no controller in the basis can beat, and which constraint sets it, where."""
    from ..interruption import demanding
    from ..pipeline import setting_of
    from ..report.progress import status_line
    from ..solve.bound import bound as convex_bound
    from ..solve.infeasible import impossible
    from ..spec import load_spec

    with located(spec), status_line() as progress:
        setting = setting_of(load_spec(spec))
        reason = impossible(setting)
        if reason is not None:
            raise reason.error()
        limit = convex_bound(setting, terms, demanding(progress))
    if limit is None:
        raise UndecidedError(f"{spec}: no Q̃ in the basis satisfies the constraints, by the solver's word")
    if as_json:
        say(dumped(limit.to_json()))
        return
    from ..report.terminal import console, show_bound

    show_bound(limit, console())
