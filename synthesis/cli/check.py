"""`robimp check`: certificates re-proven, and compared with the specification and controller in use."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from ..errors import ExitCode, InputError, Location
from .common import Json, bounded_bytes, certificate_bytes, complain, finish, say

if TYPE_CHECKING:
    from ..controller_file import Controller
    from ..judgement import Judgement

T = TypeVar("T")

Certificates = Annotated[list[Path], typer.Argument(metavar="CERT...", help="Certificate files (JSON).")]
Specs = Annotated[
    list[Path] | None,
    typer.Option("--spec", metavar="SPEC", help="Also demand that it is this specification's; one, or one for each."),
]
Controllers = Annotated[
    list[Path] | None,
    typer.Option("--controller", metavar="FILE", help="Also demand that it is this controller's (JSON); as --spec."),
]
Junit = Annotated[Path | None, typer.Option("--junit", metavar="FILE", help="Write JUnit XML for CI, also on failure.")]


def check(
    certificates: Certificates,
    spec: Specs = None,
    controller: Controllers = None,
    junit: Junit = None,
    time_limit: Annotated[float, typer.Option(metavar="SECONDS", min=0.01, help="For each certificate.")] = 60.0,
    as_json: Json = False,
) -> None:
    """Re-prove every claim with the independent checker (standard library only). The gravest outcome decides."""
    report = _Report(junit, certificates, [*(spec or []), *(controller or [])])
    try:
        specs = _paired("--spec", spec or [], _canonical, len(certificates))
        controllers = _paired("--controller", controller or [], _controller, len(certificates))
        for path, its_spec, its_controller in zip(certificates, specs, controllers, strict=True):
            judgement = _judgement(path, its_spec, its_controller, time_limit)
            report.add(judgement)
            _show(judgement, as_json)
    except Exception as error:
        report.write(f"not checked: {error}", getattr(error, "exit_code", ExitCode.INTERNAL))
        raise
    report.write()
    finish([judgement.exit_code for judgement in report.judgements])


def _judgement(path: Path, spec: dict[str, Any] | None, controller: Controller | None, time_limit: float) -> Judgement:
    from ..judgement import judge, unreadable

    try:
        data = certificate_bytes(path)
    except InputError as error:
        return unreadable(str(path), error.message)
    return judge(str(path), data, spec, controller, time_limit)


def _show(judgement: Judgement, as_json: bool) -> None:
    if as_json:
        say(json.dumps(judgement.to_json(), ensure_ascii=False))
    elif judgement.exit_code is ExitCode.PROVEN:
        say(f"PROVEN  {judgement.file}  {judgement.message}")
    else:
        complain(f"{judgement.file}: {judgement.message}")


def _canonical(path: Path) -> dict[str, Any]:
    from ..spec import canonical, load_spec

    return canonical(load_spec(path))


def _controller(path: Path) -> Controller:
    from ..controller_file import MAX_BYTES, read_controller

    return read_controller(bounded_bytes(path, MAX_BYTES), str(path))


def _paired(option: str, paths: list[Path], read: Callable[[Path], T], count: int) -> list[T | None]:
    """For each of `count` certificates none, the only one, or its own. Raises: InputError for any other number."""
    if len(paths) not in (0, 1, count):
        raise InputError(
            f"{option} is given {len(paths)} times for {count} certificate{'s' if count > 1 else ''}: "
            "give it once, or once for each certificate in the same order"
        )
    found = [read(path) for path in paths]
    return list(found) if len(found) == count else [found[0] if found else None] * count


class _Report:
    """The JUnit file: red from the start, so that a run that is killed does not leave an earlier run's green one."""

    def __init__(self, path: Path | None, certificates: Sequence[Path], others: Sequence[Path]) -> None:
        self.path, self.certificates = path, certificates
        self.judgements: list[Judgement] = []
        if path is None:
            return
        from ..storage import demand_replaceable

        with_inputs = [other for other in (*certificates, *others) if _same(path, other)]
        if with_inputs:
            raise InputError(f"--junit would overwrite {with_inputs[0]}", Location(str(path)))
        demand_replaceable(path)
        self.write("the check did not finish", ExitCode.UNDECIDED)

    def add(self, judgement: Judgement) -> None:
        self.judgements.append(judgement)

    def write(self, rest: str = "", code: ExitCode = ExitCode.INTERNAL) -> None:
        """Write what was judged, and for every certificate that was not why."""
        if self.path is None:
            return
        from ..judgement import unreadable
        from ..report.junit import junit
        from ..storage import write_atomic

        missing = [unreadable(str(path), rest, code) for path in self.certificates[len(self.judgements) :]]
        write_atomic(self.path, junit([*self.judgements, *missing]))


def _same(one: Path, other: Path) -> bool:
    try:
        return one.absolute() == other.absolute() or one.samefile(other)
    except (OSError, ValueError):  # one of them is not there
        return False
