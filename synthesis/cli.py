"""The command line. Heavy libraries load inside the commands that use them."""

from __future__ import annotations

import json
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .errors import ExitCode, InputError, Location, RobimpError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from .pipeline import Result
    from .spec.model import Spec

app = typer.Typer(
    name="robimp",
    help="Robust impedance controllers with the largest bandwidth that can be proven.",
    epilog="Exit codes: 0 proven, 1 internal error, 2 bad input, 3 infeasible, 4 refuted, 5 undecided, 6 mismatch.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")]
Specs = Annotated[list[Path], typer.Argument(metavar="SPEC...", help="Specification files (YAML).")]
TimeLimit = Annotated[float | None, typer.Option(metavar="SECONDS", min=0.0, help="Stop searching after this long.")]


@app.command()
def synth(
    specs: Specs,
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="DIR", help="Default: out/NAME.")] = None,
    time_limit: TimeLimit = None,
    as_json: Json = False,
) -> None:
    """Find the controller of largest bandwidth, prove it, have the proof re-checked, simulate it."""
    from .spec import load_spec, spec_warnings

    loaded = [(path, load_spec(path)) for path in specs]
    folders = _folders([spec for _, spec in loaded], output)
    codes = []
    for (path, spec), folder in zip(loaded, folders, strict=True):
        for warning in spec_warnings(spec):
            print(f"{path}: warning: {warning}", file=sys.stderr)
        codes.append(_synth_one(path, spec, folder, time_limit, as_json))
    _finish(codes)


def _folders(specs: list[Spec], output: Path | None) -> list[Path]:
    names = [spec.name for spec in specs]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"two specifications are named '{twice}' and would write the same folder; rename one")
    if output is not None and len(specs) == 1:
        return [output]
    return [(output or Path("out")) / name for name in names]


def _synth_one(path: Path, spec: Spec, folder: Path, time_limit: float | None, as_json: bool) -> ExitCode:
    from .pipeline import synthesize
    from .storage import write_atomic

    with _located(path), _progress() as progress:
        result = synthesize(spec, progress, time_limit=time_limit)
    write_atomic(folder / "simulation.json", _dumped(_simulation(result)).encode())
    write_atomic(folder / "certificate.json", result.certificate_bytes())
    if as_json:
        print(
            _dumped({"file": str(folder / "certificate.json"), "exit_code": int(result.exit_code), **_summary(result)})
        )
        return result.exit_code
    from .report.terminal import console, show

    show(result, console())
    print(f"certificate: {folder / 'certificate.json'}")
    return result.exit_code


@app.command()
def check(
    certificates: Annotated[list[Path], typer.Argument(metavar="CERT...", help="Certificate files (JSON).")],
    spec: Annotated[
        Path | None, typer.Option(metavar="SPEC", help="Also demand that it is this specification's.")
    ] = None,
    time_limit: Annotated[float, typer.Option(metavar="SECONDS", min=0.01, help="For each certificate.")] = 60.0,
    as_json: Json = False,
) -> None:
    """Re-prove every claim with the independent checker (standard library only)."""
    from .check import check_file

    expected = None if spec is None else _canonical(spec)
    codes = []
    for path in certificates:
        verdict = check_file(str(path), time_limit=time_limit)
        code, message = ExitCode(verdict.exit_code), verdict.message
        if expected is not None and code not in (ExitCode.INPUT, ExitCode.INTERNAL):
            difference = _first_difference(expected, json.loads(path.read_bytes())["spec"])
            if difference is not None:
                code, message = ExitCode.MISMATCH, f"certificate of another specification: {difference}"
        codes.append(code)
        if as_json:
            print(_dumped({"file": str(path), "exit_code": int(code), "message": message}))
        elif code is ExitCode.PROVEN:
            print(f"PROVEN  {path}  {message}")
        else:
            print(f"{path}: {message}", file=sys.stderr)
    _finish(codes)


@app.command()
def simulate(
    certificate: Annotated[Path, typer.Argument(metavar="CERT", help="Certificate file (JSON).")],
    as_json: Json = False,
) -> None:
    """Move the certified joint in the time domain: every corner of the box; agrees or contradicts."""
    from fractions import Fraction

    from .agreement import compare
    from .certificate.claims import certify
    from .check import check_file
    from .pipeline import realizable, setting_of
    from .simulation import verify
    from .spec import from_canonical
    from .spec.model import Polynomials

    checked = check_file(str(certificate))
    if checked.exit_code == ExitCode.INPUT:
        raise InputError(checked.message, Location(str(certificate)))
    content = json.loads(certificate.read_bytes())
    spec = from_canonical(content["spec"], str(certificate))
    written = content["controller"]["Q" if spec.controller.type == "dob" else "C"]
    numerator, denominator = (tuple(map(Fraction, written[part])) for part in ("numerator", "denominator"))
    setting = setting_of(spec)
    C = realizable(setting, Polynomials(numerator=numerator, denominator=denominator))
    compensator = (
        tuple(map(Fraction, content["controller"]["C"]["numerator"])),
        tuple(map(Fraction, content["controller"]["C"]["denominator"])),
    )
    with _progress() as progress:
        trials = verify(spec, compensator, progress=progress)
        agreement = compare(setting, C, certify(setting, C), trials)
    agrees = not agreement.contradictions
    if as_json:
        print(_dumped({"agrees": agrees, "contradictions": agreement.contradictions, **trials.to_json()}))
    elif agrees:
        print(
            f"AGREES  {certificate}  {len(trials.trials)} trials, "
            f"measured Z within {agreement.impedance_error:.1g} of (★)"
        )
    for contradiction in agreement.contradictions:
        print(f"{certificate}: contradicts: {contradiction}", file=sys.stderr)
    _finish([ExitCode.PROVEN if agrees else ExitCode.REFUTED])


@app.command()
def bound(
    spec: Annotated[Path, typer.Argument(metavar="SPEC", help="Specification file (YAML).")],
    terms: Annotated[int, typer.Option(min=4, max=120, help="Functions in the basis of Q̃.")] = 40,
    as_json: Json = False,
) -> None:
    """The bandwidth no controller in the basis can beat, and which constraint sets it, where."""
    from dataclasses import asdict

    from .pipeline import setting_of
    from .solve.bound import bound as convex_bound
    from .solve.infeasible import impossible
    from .spec import load_spec

    with _located(spec), _progress() as progress:
        setting = setting_of(load_spec(spec))
        reason = impossible(setting)
        if reason is not None:
            raise reason.error()
        progress(f"convex program with {terms} terms")
        limit = convex_bound(setting, terms)
    if limit is None:
        print(f"{spec}: no Q̃ in the basis satisfies the constraints, by the solver's word", file=sys.stderr)
        _finish([ExitCode.UNDECIDED])
        return
    if as_json:
        print(_dumped(asdict(limit)))
        return
    from .report.terminal import console, show_bound

    show_bound(limit, console())


@app.command()
def schema() -> None:
    """Print the JSON schema of specification files, for editors."""
    from .spec import json_schema

    print(_dumped(json_schema()))


def _canonical(path: Path) -> dict[str, Any]:
    from .spec import canonical, load_spec

    return canonical(load_spec(path))


def _first_difference(expected: Any, found: Any, key: str = "") -> str | None:
    """The first difference of two canonical specifications, in words: `plant.inertia 1/50 → 21/1000`."""
    if isinstance(expected, dict) and isinstance(found, dict):
        for name in sorted(expected.keys() | found.keys()):
            inner = _first_difference(expected.get(name), found.get(name), f"{key}.{name}" if key else name)
            if inner is not None:
                return inner
        return None
    if expected == found:
        return None
    return f"{key} {_readable(expected)} → {_readable(found)}"


def _readable(value: Any) -> str:
    return "absent" if value is None else json.dumps(value, ensure_ascii=False)


def _summary(result: Result) -> dict[str, Any]:
    return {
        "outcome": result.outcome.value,
        "omega_B": float(result.omega_B),
        "bound": None if result.bound is None else result.bound.omega_B,
        "seconds": result.seconds,
        "claims": [
            {"id": c.id, "form": c.form, "required": c.required, "status": c.status.value} for c in result.claims
        ],
        "simulation": {
            "trials": len(result.trials.trials),
            "impedance_error": result.agreement.impedance_error,
            "lowest_energy": result.agreement.lowest_energy,
        },
        "sampled": result.sampled.to_json(),
    }


def _simulation(result: Result) -> dict[str, Any]:
    return {**result.trials.to_json(), "sampled": result.sampled.to_json()}


def _dumped(value: Any) -> str:
    return json.dumps(value, indent=1, ensure_ascii=False, default=str) + "\n"


@contextmanager
def _located(path: Path) -> Iterator[None]:
    """Errors that do not say which file they are about get its name."""
    try:
        yield
    except InputError as error:
        if error.location is not None:
            raise
        raise InputError(error.message, Location(str(path))) from error
    except RobimpError as error:
        raise type(error)(f"{path}: {error}") from error


@contextmanager
def _progress() -> Iterator[Callable[[str], None]]:
    """A status line while something runs; silent when standard error is not a terminal."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console

    with Console(stderr=True).status("starting") as status:
        yield status.update


def _finish(codes: list[ExitCode]) -> None:
    raise typer.Exit(next((int(code) for code in codes if code), 0))


def main() -> None:
    """Entry point: every error is one line on standard error and an exit code; `--debug` shows the traceback."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(encoding="utf-8", errors="backslashreplace")
    arguments = [argument for argument in sys.argv[1:] if argument != "--debug"]
    debug = len(arguments) < len(sys.argv) - 1
    try:
        sys.exit(app(arguments, prog_name="robimp", standalone_mode=False) or 0)
    except KeyboardInterrupt:
        print("interrupted; nothing was written", file=sys.stderr)
        sys.exit(ExitCode.UNDECIDED)
    except Exception as error:
        if debug:
            raise
        sys.exit(_report(error))


def _report(error: Exception) -> int:
    if isinstance(error, RobimpError):
        print(f"robimp: {error}", file=sys.stderr)
        return int(error.exit_code)
    if hasattr(error, "format_message"):  # the command-line parser's own
        print(f"robimp: {error.format_message() or 'see robimp --help'}", file=sys.stderr)
        return int(ExitCode.INPUT)
    print(f"robimp: internal error: {type(error).__name__}: {error} (--debug shows where)", file=sys.stderr)
    return int(ExitCode.INTERNAL)
