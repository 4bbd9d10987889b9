"""The entry point: commands by name, and how every run ends — one line on standard error and an exit code."""

from __future__ import annotations

import errno
import os
import sys
import traceback
import warnings
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer

from ..errors import ExitCode, RobimpError
from ..interruption import Interruption, demand_none, remembered
from .bound import bound
from .check import check
from .common import complain, discard, say, unwritable_output
from .export import export
from .identify import identify
from .init import init
from .map import map_
from .report import report
from .schema import schema
from .simulate import simulate
from .synth import synth

OUTPUT_ERRORS = (errno.EPIPE, errno.ENOSPC, errno.EIO, errno.EBADF)  # a file's own carry its name

app = typer.Typer(
    name="robimp",
    help="Robust impedance controllers with the largest bandwidth that can be proven.",
    epilog="Exit codes: 0 proven, 1 internal error, 2 bad input, 3 infeasible, 4 refuted, 5 undecided, 6 mismatch.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
for command in (synth, check, simulate, bound, identify, report, export, init, schema):
    app.command()(command)
app.command("map")(map_)


def _tell_version(asked: bool) -> None:
    if asked:
        say(f"robimp {version('robimp')}")
        raise typer.Exit


@app.callback()
def _robimp(
    version: Annotated[
        bool, typer.Option("--version", callback=_tell_version, is_eager=True, help="Show the version and exit.")
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Of any command: show the traceback of an error.")] = False,
) -> None:
    pass


def main() -> None:
    """Run the command of `sys.argv`; `--debug` shows the traceback of an error. Raises: SystemExit, always."""
    _prepare_streams()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # matrices are small: threads only wait for each other
    arguments = [argument for argument in sys.argv[1:] if argument != "--debug"]
    debug = len(arguments) < len(sys.argv) - 1
    if not debug:
        warnings.simplefilter("ignore")  # floating point out of range on the grid: the exact proof decides
    with remembered() as interruption:
        code = _flushed(_ended(arguments, interruption, debug))
    sys.exit(code)


def _prepare_streams() -> None:
    closed = sys.stdout is None
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # its number would go to the next file opened, and what libraries print into that file
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115
        elif hasattr(stream, "reconfigure"):
            own = stream.isatty() or "PYTHONIOENCODING" in os.environ  # what a terminal shows, or somebody asked for
            stream.reconfigure(encoding=None if own else "utf-8", errors="backslashreplace")
    if closed:
        complain("robimp: standard output: is closed")
        sys.exit(ExitCode.INPUT)


def _ended(arguments: list[str], interruption: Interruption, debug: bool) -> int:
    """How a command ends: its exit code, after its one line."""
    try:
        code = _run(arguments)
        demand_none()
        return code
    except (KeyboardInterrupt, Exception) as raised:
        error = raised
    if interruption.pressed or _interrupted(error):
        complain("robimp: interrupted; no partial file was written")
        return int(ExitCode.UNDECIDED)
    if debug:
        traceback.print_exception(error)
    return _report(error)


def _run(arguments: list[str]) -> int:
    """Run a command without the parser's own way of ending, which has other exit codes and hides Ctrl-C."""
    command = typer.main.get_command(app)
    try:
        with command.make_context("robimp", arguments) as context:
            command.invoke(context)
    except typer.Exit as end:
        return end.exit_code
    except SystemExit as end:
        if isinstance(end.__context__, BrokenPipeError):  # how rich ends when nobody reads its output
            raise end.__context__ from end
        raise RuntimeError(f"a library ended the program with {end.code}") from end
    return ExitCode.PROVEN


def _interrupted(error: BaseException | None) -> bool:
    """Whether Ctrl-C is what a library's own error hides."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False


def _report(error: BaseException) -> int:
    if isinstance(error, OSError) and error.errno in OUTPUT_ERRORS and error.filename is None:
        discard(sys.stdout)
        error = unwritable_output(error)
    if isinstance(error, RobimpError):
        complain(f"robimp: {error}")
        return int(error.exit_code)
    if hasattr(error, "format_message"):  # the command-line parser's own
        complain(f"robimp: {error.format_message()} (see robimp --help)")
        return int(ExitCode.INPUT)
    complain(f"robimp: internal error: {type(error).__name__}: {error} (--debug shows where, see robimp --help)")
    return int(ExitCode.INTERNAL)


def _flushed(code: int) -> int:
    """The exit code after the last output: what nobody could read is no success."""
    try:
        sys.stdout.flush()
    except OSError as error:
        discard(sys.stdout)
        complain(f"robimp: {unwritable_output(error)}")
        code = code or int(ExitCode.INPUT)
    try:
        sys.stderr.flush()
    except OSError:
        discard(sys.stderr)  # or Python's own flush at the end would change the exit code
    return code
