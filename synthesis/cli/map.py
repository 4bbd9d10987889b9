"""`robimp map`: proven bandwidth over a plane of two keys, in parallel, resumable."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import InputError
from .common import Json, complain, dumped, finish, located, say

if TYPE_CHECKING:
    from ..sweep.axis import Axis
    from ..sweep.result import Map

Range = Annotated[str | None, typer.Option(metavar="A:B:N[:log]", help="N values from A to B, in SI.")]
Vary = Annotated[
    list[str] | None,
    typer.Option("--vary", metavar="KEY=A:B:N[:log]", help="Any other key, such as objective.attenuation=0.1:0.5:9."),
]
Processes = Annotated[int | None, typer.Option("--processes", min=1, help="Default: one for each core.")]
Dask = Annotated[str | None, typer.Option("--dask", metavar="ADDRESS", help="Use a Dask cluster instead.")]


def map_(
    spec: Annotated[Path, typer.Argument(metavar="SPEC", help="Specification file (YAML).")],
    stiffness: Range = None,
    damping: Range = None,
    vary: Vary = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="DIR", help="Default: out/NAME-map.")] = None,
    processes: Processes = None,
    dask: Dask = None,
    time_limit: Annotated[float | None, typer.Option(metavar="SECONDS", min=0.0, help="For each cell.")] = None,
    certificates: Annotated[bool, typer.Option("--certificates", help="Write each proven cell's certificate.")] = False,
    as_json: Json = False,
) -> None:
    """Map the proven bandwidth over stiffness and damping, or any two keys. The same command resumes a map."""
    from ..spec import load_spec
    from ..storage import demand_replaceable, write_atomic
    from ..sweep.figure import figure
    from ..sweep.progress import progress_bar
    from ..sweep.run import map_plane

    axes = _axes(stiffness, damping, vary or [])
    folder = output or Path("out") / f"{load_spec(spec).name}-map"
    files = {form: folder / f"map.{form}" for form in ("json", "svg", "png")}
    for file in files.values():
        demand_replaceable(file)
    try:
        with located(spec), progress_bar(len(axes[0].values) * len(axes[1].values)) as progress:
            found = map_plane(
                spec,
                axes,
                folder,
                processes=processes,
                dask=dask,
                time_limit=time_limit,
                certificates=certificates,
                progress=progress,
            )
    except KeyboardInterrupt:
        complain(f"{folder}: every finished cell is kept; the same command goes on")
        raise
    for form in ("svg", "png"):
        write_atomic(files[form], figure(found, form))
    write_atomic(files["json"], dumped(found.to_json()).encode())
    _show(found, folder, as_json)
    finish([found.exit_code])


def _axes(stiffness: str | None, damping: str | None, vary: list[str]) -> tuple[Axis, Axis]:
    from ..sweep.axis import Axis

    named = {"impedance.stiffness": stiffness, "impedance.damping": damping}
    axes = [Axis.parse(key, text) for key, text in named.items() if text is not None]
    axes += [Axis.assignment(text) for text in vary]
    if len(axes) != 2:
        raise InputError(f"a map has two axes, {len(axes)} given: --stiffness A:B:N, --damping A:B:N, --vary KEY=A:B:N")
    return axes[0], axes[1]


def _show(found: Map, folder: Path, as_json: bool) -> None:
    if as_json:
        say(dumped(found.to_json()))
        return
    from ..sweep.picture import picture

    for line in picture(found):
        say(line)
    say(f"map: {folder / 'map.json'}, map.svg, map.png")
