"""The command line. Heavy libraries load inside the commands that use them."""

from __future__ import annotations

import json
import stat
import sys
import traceback
import warnings
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .errors import ExitCode, InputError, Location, MismatchError, RobimpError, UndecidedError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from .spec.model import Spec

app = typer.Typer(
    name="robimp",
    help="Robust impedance controllers with the largest bandwidth that can be proven.",
    epilog="Exit codes: 0 proven, 1 internal error, 2 bad input, 3 infeasible, 4 refuted, 5 undecided, 6 mismatch.",
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
    from .storage import demand_writable

    loaded = [(path, load_spec(path)) for path in specs]
    folders = _folders([spec for _, spec in loaded], output)
    for folder in folders:
        demand_writable(folder)
    codes = []
    for (path, spec), folder in zip(loaded, folders, strict=True):
        for warning in spec_warnings(spec):
            _complain(f"{path}: warning: {warning}")
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
    from .report.progress import status_line
    from .report.summary import simulation, summary
    from .storage import write_atomic

    try:
        with _located(path), status_line() as progress:
            result = synthesize(spec, progress, time_limit=time_limit)
    except RobimpError:
        if (folder / "certificate.json").exists():
            _complain(f"{path}: note: {folder / 'certificate.json'} is from an earlier run")
        raise
    write_atomic(folder / "simulation.json", _dumped(simulation(result)).encode())
    write_atomic(folder / "certificate.json", result.certificate_bytes())
    if as_json:
        print(_dumped({"file": str(folder / "certificate.json"), **summary(result)}))
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
    expected = None
    if spec is not None:
        from .spec import canonical, load_spec

        expected = canonical(load_spec(spec))
    codes = []
    for path in certificates:
        code, message = _verdict(path, expected, time_limit)
        codes.append(code)
        if as_json:
            print(_dumped({"file": str(path), "exit_code": int(code), "message": message}))
        elif code is ExitCode.PROVEN:
            print(f"PROVEN  {path}  {message}")
        else:
            _complain(f"{path}: {message}")
    _finish(codes)


def _verdict(path: Path, expected: dict[str, Any] | None, time_limit: float) -> tuple[ExitCode, str]:
    """One certificate's code and line; with a specification, whether it is that one's."""
    from .check import check_bytes
    from .report.difference import first_difference

    try:
        data = _certificate_bytes(path)
    except InputError as error:
        return ExitCode.INPUT, error.message
    checked = check_bytes(data, time_limit=time_limit)
    code = ExitCode(checked.exit_code)
    if expected is not None and code is not ExitCode.INPUT:
        difference = first_difference(expected, json.loads(data)["spec"])
        if difference is not None:
            return ExitCode.MISMATCH, f"certificate of another specification: {difference}"
    return code, checked.message


def _certificate_bytes(path: Path) -> bytes:
    """A certificate, read once, so that what is used is what was checked. Raises: InputError."""
    from .check.reader import MAX_BYTES

    try:
        if stat.S_ISFIFO(path.lstat().st_mode):  # a named pipe may have no other end; /dev/stdin is a link to one
            raise InputError("file: a named pipe, not a certificate", Location(str(path)))
        with path.open("rb") as stream:
            return stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(f"file: cannot be read: {error.strerror or error}", Location(str(path))) from error


@app.command()
def simulate(
    certificate: Annotated[Path, typer.Argument(metavar="CERT", help="Certificate file (JSON).")],
    as_json: Json = False,
) -> None:
    """Move the certified joint in the time domain: every corner of the box; agrees or contradicts."""
    from .check import check_bytes
    from .replay import replay
    from .report.progress import status_line

    data = _certificate_bytes(certificate)
    checked = check_bytes(data)
    if checked.exit_code == ExitCode.INPUT:
        raise InputError(checked.message, Location(str(certificate)))
    if checked.exit_code == ExitCode.MISMATCH:
        raise MismatchError(f"{certificate}: {checked.message}")
    with status_line() as progress:
        trials, agreement = replay(json.loads(data), checked, str(certificate), progress)
    agrees = not agreement.contradictions
    if as_json:
        print(_dumped({"agrees": agrees, "contradictions": agreement.contradictions, **trials.to_json()}))
    elif agrees:
        print(f"AGREES  {certificate}  {agreement.summary(len(trials.trials))}")
    for contradiction in agreement.contradictions:
        _complain(f"{certificate}: contradicts: {contradiction}")
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
    from .report.progress import status_line
    from .solve.bound import bound as convex_bound
    from .solve.infeasible import impossible
    from .spec import load_spec

    with _located(spec), status_line() as progress:
        setting = setting_of(load_spec(spec))
        reason = impossible(setting)
        if reason is not None:
            raise reason.error()
        progress(f"convex program with {terms} terms")
        limit = convex_bound(setting, terms)
    if limit is None:
        raise UndecidedError(f"{spec}: no Q̃ in the basis satisfies the constraints, by the solver's word")
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


def _finish(codes: list[ExitCode]) -> None:
    raise typer.Exit(next((int(code) for code in codes if code), 0))


def _complain(text: str) -> None:
    """One printable line on standard error, whatever is in a file's name."""
    print("".join(c if c.isprintable() else ascii(c)[1:-1] for c in text), file=sys.stderr)


def main() -> None:
    """Entry point: every error is one line on standard error and an exit code; `--debug` shows the traceback."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(encoding="utf-8", errors="backslashreplace")
    arguments = [argument for argument in sys.argv[1:] if argument != "--debug"]
    debug = len(arguments) < len(sys.argv) - 1
    if not debug:
        warnings.simplefilter("ignore")  # floating point out of range on the grid: the exact proof decides
    try:
        sys.exit(_run(arguments))
    except KeyboardInterrupt:
        _complain("robimp: interrupted; no partial file was written")
        sys.exit(ExitCode.UNDECIDED)
    except Exception as error:
        if _interrupted(error):
            _complain("robimp: interrupted; no partial file was written")
            sys.exit(ExitCode.UNDECIDED)
        if debug:
            traceback.print_exception(error)
        sys.exit(_report(error))


def _interrupted(error: BaseException | None) -> bool:
    """Whether Ctrl-C is what a library's own error hides."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False


def _run(arguments: list[str]) -> int:
    """Run a command without the parser's own way of ending, which has other exit codes and hides Ctrl-C."""
    command = typer.main.get_command(app)
    try:
        with command.make_context("robimp", arguments) as context:
            command.invoke(context)
    except typer.Exit as end:
        return end.exit_code
    return ExitCode.PROVEN


def _report(error: Exception) -> int:
    if isinstance(error, RobimpError):
        _complain(f"robimp: {error}")
        return int(error.exit_code)
    if hasattr(error, "format_message"):  # the command-line parser's own
        _complain(f"robimp: {error.format_message()} (see robimp --help)")
        return int(ExitCode.INPUT)
    _complain(f"robimp: internal error: {type(error).__name__}: {error} (--debug shows where)")
    return int(ExitCode.INTERNAL)
