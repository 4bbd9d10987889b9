"""`robimp init`: a commented specification to start from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..errors import InputError, Location
from .common import Json, dumped, say

Name = Annotated[str, typer.Argument(metavar="NAME", help="Name of the joint.")]
Actuator = Annotated[str, typer.Option(metavar="TYPE", help="series-elastic or ideal.")]


def init(
    name: Name = "my-joint",
    actuator: Actuator = "series-elastic",
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="FILE", help="Default: NAME.yaml.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a file that exists.")] = False,
    as_json: Json = False,
) -> None:
    """Write a commented specification, ready for `robimp synth`, to put your joint's numbers into."""
    from ..spec import parse_spec
    from ..spec.template import template
    from ..storage import demand_replaceable, write_atomic

    if actuator not in ("series-elastic", "ideal"):
        raise InputError(f"'{actuator}' is not series-elastic or ideal", Location("--actuator"))
    text = template(name, actuator)  # type: ignore[arg-type]
    parse_spec(text.encode(), "NAME")  # refuses a name that a specification cannot have
    path = output or Path(f"{name}.yaml")
    demand_replaceable(path)
    if path.exists() and not force:
        raise InputError("exists; --force replaces it", Location(str(path)))
    write_atomic(path, text.encode())
    say(dumped({"file": str(path)}) if as_json else f"wrote {path}; next: robimp synth {path}")
