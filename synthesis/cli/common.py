"""What the commands share: printing, reading a certificate, and which of several outcomes decides."""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated, Any, TextIO

import typer

from ..errors import ExitCode, InputError, Location, RobimpError
from ..storage import bounded_bytes as bounded_bytes

Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of text, one object per result.")]

# What is known to be wrong comes before what is not known; anything comes before a proof.
GRAVITY = (
    ExitCode.REFUTED,
    ExitCode.MISMATCH,
    ExitCode.INFEASIBLE,
    ExitCode.INTERNAL,
    ExitCode.INPUT,
    ExitCode.UNDECIDED,
    ExitCode.PROVEN,
)


def finish(codes: list[ExitCode]) -> None:
    """End the command with the gravest outcome. Raises: typer.Exit."""
    raise typer.Exit(int(min(codes, key=GRAVITY.index)))


def say(text: str) -> None:
    """One result on standard output, at once. Raises: InputError when nobody can read it."""
    try:
        print(text, flush=True)
    except OSError as error:
        discard(sys.stdout)
        raise unwritable_output(error) from error


def discard(stream: TextIO) -> None:
    """Send what a broken stream still holds nowhere, so that the interpreter does not fail at it again."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def unwritable_output(error: OSError) -> InputError:
    """The error of a standard output that is closed or full."""
    return InputError(f"cannot be written: {error.strerror or error}", Location("standard output"))


def complain(text: str) -> None:
    """One printable line on standard error, whatever is in a file's name."""
    line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
    with suppress(OSError):  # nobody reads it; the exit code remains
        print(line, file=sys.stderr, flush=True)


def dumped(value: Any) -> str:
    """A large result as JSON."""
    return json.dumps(value, indent=1, ensure_ascii=False, default=str) + "\n"


def certificate_bytes(path: Path) -> bytes:
    """A certificate, read once, so that what is used is what was checked. Raises: InputError."""
    from ..check.reader import MAX_BYTES

    return bounded_bytes(path, MAX_BYTES)


def _place(path: Path, key: str) -> Location:
    from ..spec.load import place_of

    return place_of(path, key)


@contextmanager
def located(path: Path) -> Iterator[None]:
    """An error that does not say where it is gets the file, and the place of the key that its message begins with."""
    try:
        yield
    except InputError as error:
        if error.location is not None:
            raise
        key = re.match(r"[a-z_0-9]+(\.[a-z_0-9]+)+", error.message)
        raise InputError(error.message, _place(path, key[0]) if key else Location(str(path))) from error
    except RobimpError as error:
        raise type(error)(f"{path}: {error}") from error
