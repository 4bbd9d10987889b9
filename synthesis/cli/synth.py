"""`robimp synth`: from a specification to a proven controller."""

from __future__ import annotations

import time
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import ExitCode, InputError, RobimpError, UndecidedError
from .common import Json, complain, dumped, finish, located, say

if TYPE_CHECKING:
    from ..pipeline import Result
    from ..spec.model import Spec

Specs = Annotated[list[Path], typer.Argument(metavar="SPEC...", help="Specification files (YAML).")]
Orders = Annotated[
    str | None, typer.Option(metavar="A:B", help="Search every order from A to B instead, each with its certificate.")
]
TimeLimit = Annotated[
    float | None,
    typer.Option(
        metavar="SECONDS",
        min=0.0,
        help="Stop searching each order after this long, with the best known by then.",
    ),
]
Seed = Annotated[int, typer.Option(metavar="N", min=0, help="Of the random starts; the same seed, the same digits.")]


def synth(
    specs: Specs,
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="DIR", help="Default: out/NAME.")] = None,
    orders: Orders = None,
    time_limit: TimeLimit = None,
    seed: Seed = 0,
    as_json: Json = False,
) -> None:
    """Find the controller of largest bandwidth, prove it, have the proof re-checked, simulate it."""
    from ..spec import load_spec, spec_warnings
    from ..storage import demand_writable

    loaded = [(path, load_spec(path)) for path in specs]
    wanted = None if orders is None else [_of_orders(path, spec, orders) for path, spec in loaded]
    folders = _folders([spec for _, spec in loaded], output)
    for folder in folders:
        demand_writable(folder)
    codes = []
    for index, ((path, spec), folder) in enumerate(zip(loaded, folders, strict=True)):
        for warning in spec_warnings(spec):
            complain(f"{path}: warning: {warning}")
        if wanted is None:
            codes.append(_synth_one(path, spec, folder, time_limit, seed, as_json))
        else:
            codes += _synth_orders(path, wanted[index], folder, time_limit, seed, as_json)
    finish(codes)


def _of_orders(path: Path, spec: Spec, orders: str) -> list[Spec]:
    """The specification with each order of `A:B`. Raises: InputError."""
    from ..spec.demands import ORDERS

    low, high = ORDERS[spec.controller.type]
    ends = orders.split(":")
    if len(ends) != 2 or not all(end.isascii() and end.isdigit() for end in ends):
        raise InputError(f"--orders: expected two orders A:B, such as 2:8; found '{orders:.40}'")
    first, last = (int(end) for end in ends)
    if not low <= first <= last <= high:
        raise InputError(f"--orders: expected {low} ≤ A ≤ B ≤ {high}; found '{orders}'")
    if spec.controller.coefficients is not None:
        raise InputError(f"{path}: controller.coefficients: are given; --orders searches: write an order instead")
    given = [spec.controller.model_copy(update={"order": n, "form": None}) for n in range(first, last + 1)]
    return [spec.model_copy(update={"controller": controller}) for controller in given]


def _synth_orders(
    path: Path, specs: list[Spec], folder: Path, time_limit: float | None, seed: int, as_json: bool
) -> list[ExitCode]:
    """One certificate for each order, bandwidth against order under the bound; an order without one does not stop."""
    from ..design import Shared
    from ..pipeline import Result, synthesize
    from ..report.orders import OfOrder, figure, listed, show_orders
    from ..report.progress import status_line
    from ..storage import demand_writable, discard, write_atomic

    shared, rows, codes, results = Shared(), list[OfOrder](), list[ExitCode](), dict[str, Result]()
    for spec in specs:
        order, began = spec.controller.order or 0, time.monotonic()
        try:
            with located(path), status_line() as progress:
                progress(f"order {order}")
                result = synthesize(spec, progress, time_limit=time_limit, shared=shared, seed=seed)
        except UndecidedError as error:
            rows.append(OfOrder(order, None, time.monotonic() - began, str(error)))
            codes.append(error.exit_code)
            continue
        place = folder / f"order-{order}"
        demand_writable(place)
        discard(*(folder / name for name in ("report.html", "orders.json", "orders.svg")))
        results[f"{place.name}/certificate.json"] = result
        write_atomic(place / "certificate.json", result.certificate_bytes())
        corner = None if result.corner is None else float(result.corner.omega)
        seconds = time.monotonic() - began
        rows.append(OfOrder(order, float(result.omega_B), seconds, "", result.check_limit, corner))
        codes.append(result.exit_code)
    limit = shared.bound.omega_B if shared.bound is not None and shared.bound.limited else None
    write_atomic(folder / "orders.json", dumped(listed(rows, limit)).encode())
    write_atomic(folder / "orders.svg", figure(rows, limit, specs[0].name))
    if results:
        _report(results, folder)
    if as_json:
        say(dumped({"folder": str(folder), **listed(rows, limit)}))
        return codes
    from ..report.terminal import console

    show_orders(rows, limit, console())
    say(f"certificates: {folder}/order-*/certificate.json, figure: {folder / 'orders.svg'}")
    for name, result in results.items():
        _say_less(result)
        _say_slow(folder / name, result)
    return codes


def _folders(specs: list[Spec], output: Path | None) -> list[Path]:
    names = [spec.name for spec in specs]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"two specifications are named '{twice}' and would write the same folder; rename one")
    if output is not None and len(specs) == 1:
        return [output]
    return [(output or Path("out")) / name for name in names]


def _synth_one(path: Path, spec: Spec, folder: Path, time_limit: float | None, seed: int, as_json: bool) -> ExitCode:
    from ..pipeline import synthesize
    from ..report.progress import status_line
    from ..report.summary import simulation, summary
    from ..storage import discard, write_atomic

    try:
        with located(path), status_line() as progress:
            result = synthesize(spec, progress, time_limit=time_limit, seed=seed)
    except RobimpError:
        if (folder / "certificate.json").exists():
            complain(f"{path}: note: {folder / 'certificate.json'} is from an earlier run")
        raise
    discard(*(folder / name for name in ("report.html", "simulation.json", "joints.npz")))  # never beside a newer one
    write_atomic(folder / "certificate.json", result.certificate_bytes())
    write_atomic(folder / "simulation.json", dumped(simulation(result)).encode())
    _report({"certificate.json": result}, folder)
    if as_json:
        say(dumped({"file": str(folder / "certificate.json"), **summary(result)}))
        return result.exit_code
    from ..report.terminal import console, show

    show(result, console())
    say(f"certificate: {folder / 'certificate.json'}, report: {folder / 'report.html'}")
    _say_less(result)
    if result.bound is None and spec.controller.coefficients is None:
        say("note: no bound to compare with: its solver vouches for none")
    _say_slow(folder / "certificate.json", result)
    return result.exit_code


def _say_less(result: Result) -> None:
    """What the time limit, the order asked for, or the end of the corners searched made of the search."""
    controller, found = result.spec.controller, len(result.coefficients.denominator) - 1
    if result.late:
        asked = "" if controller.order in (None, found) else f" (order {controller.order} was asked for)"
        say(
            f"note: the time limit ended the search: this controller, of order {found}{asked}, is the best that was "
            "known then; with a longer --time-limit, or none, there may be a better one"
        )
        return
    if controller.coefficients is None and controller.order is not None and found < controller.order:
        say(
            f"note: order {controller.order} was asked for, and of that order nothing was proven: this controller has "
            f"order {found}; another --seed may find more"
        )
    if result.corner is not None and result.corner.note:
        say(f"note: controller.filters.force: {result.corner.note}")


def _say_slow(file: Path, result: Result) -> None:
    """Where a check may outlast the time it is allowed by default: better said here than by the user's CI."""
    from ..recheck import SECONDS

    if result.check_limit > SECONDS:
        enough = "is not enough" if result.check_seconds > SECONDS else "may not be enough on a slower machine"
        say(
            f"note: checking it took {result.check_seconds:.0f} s, and the {SECONDS:.0f} s that robimp check allows "
            f"{enough}; use: robimp check {quote(str(file))} --time-limit {result.check_limit}"
        )


def _report(results: dict[str, Result], folder: Path) -> None:
    from ..report.html import write_report
    from ..report.progress import status_line

    with status_line() as progress:
        write_report(
            {name: result.certificate_bytes() for name, result in results.items()},
            folder / "report.html",
            progress,
            checked={name: result.checked for name, result in results.items()},
        )
