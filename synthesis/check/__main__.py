"""Command line: `python -m robimp.synthesis.check CERT…`, or `python -I -S path/to/check CERT…` without the package."""

import argparse
import importlib.util
import json
import math
import os
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TextIO

if not __package__:  # run as a folder: give the relative imports a package to start from
    _spec = importlib.util.spec_from_file_location("robimp_check", Path(__file__).resolve().with_name("__init__.py"))
    assert _spec is not None and _spec.loader is not None
    sys.modules["robimp_check"] = _module = importlib.util.module_from_spec(_spec)
    _spec.loader.exec_module(_module)
    __package__ = "robimp_check"

from .outcome import UNREADABLE
from .verdict import check_file


def main(argv: list[str]) -> int:
    """Check every file; returns 0 only if all are proven and that was said, otherwise the first other code."""
    parser = argparse.ArgumentParser(prog="check", description="Re-prove every claim of a certificate.")
    parser.add_argument("files", nargs="+", metavar="CERT")
    parser.add_argument("--time-limit", type=float, default=60.0, help="seconds for each certificate (default 60)")
    parser.add_argument("--json", action="store_true", help="one JSON object per certificate on stdout")
    arguments = parser.parse_args(argv)
    if not 0 < arguments.time_limit < math.inf:
        parser.error("--time-limit: must be a positive number of seconds")
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    codes = []
    for file in arguments.files:
        name = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in file)  # a line break could forge a line
        verdict = check_file(file, time_limit=arguments.time_limit)
        if arguments.json:
            said = _say(json.dumps({"file": file, **asdict(verdict)}), sys.stdout)
        elif verdict.exit_code == 0:
            said = _say(f"PROVEN  {name}  {verdict.message}", sys.stdout)
        else:
            said = _say(f"{name}: {verdict.message}", sys.stderr)
        if not said and verdict.exit_code == 0:
            _say(f"{name}: standard output cannot be written", sys.stderr)
        codes.append(verdict.exit_code if said else verdict.exit_code or UNREADABLE)
    return next(filter(None, codes), 0)


def _say(text: str, stream: TextIO | None) -> bool:
    """Print one line at once; whether it got out. What a full stream still holds goes nowhere: no second failure."""
    if stream is None:  # closed
        return False
    try:
        print(text, file=stream, flush=True)
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        return False
    return True


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
