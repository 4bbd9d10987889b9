"""The command as tests run it: in this process, with everything it said."""

from __future__ import annotations

import io
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

import pytest

from robimp.synthesis import cli
from robimp.synthesis.errors import ExitCode


@dataclass(frozen=True)
class Run:
    """What a command said and how it ended."""

    code: int
    out: str
    err: str

    @property
    def line(self) -> str:
        """The one line on standard error."""
        assert self.err.endswith("\n") and self.err.count("\n") == 1, f"expected one line, got {self.err!r}"
        assert len(self.err) > 10 and self.err[:-1].isprintable()
        return self.err[:-1]


def robimp(*arguments: str | Path) -> Run:
    """The command, in this process."""
    out, err = io.StringIO(), io.StringIO()
    argv = ["robimp", *map(str, arguments)]
    with patch.object(sys, "argv", argv), redirect_stdout(out), redirect_stderr(err), pytest.raises(SystemExit) as end:
        cli.main()
    return Run(int(end.value.code or 0), out.getvalue(), err.getvalue())


def refused(code: ExitCode, *arguments: str | Path) -> str:
    """The one line of a command that ends with this code and says nothing else."""
    run = robimp(*arguments)
    assert (run.code, run.out) == (code, ""), run
    assert "Traceback" not in run.err
    return run.line
