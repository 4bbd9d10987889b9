"""`robimp --help` and `robimp check` begin at once: 0.3 s of the processor, the Python process itself included."""

from __future__ import annotations

import os
import resource
import subprocess
import sys

import pytest

MOST = 0.3  # s
MAIN = "from robimp.synthesis.cli import main\nmain()"


def seconds(*command: str, times: int = 3) -> float:
    """Processor time of a fresh interpreter, the least of a few: the first may have to compile."""

    def once() -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", *command], capture_output=True, timeout=60, env=os.environ)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    return min(once() for _ in range(times))


@pytest.mark.parametrize("arguments", [("--help",), ("check", "--help"), ("check", "absent.json")])
def test_a_command_starts_in_time(arguments: tuple[str, ...]) -> None:
    assert seconds(MAIN, *arguments) <= MOST


def test_a_slow_start_would_be_seen() -> None:
    assert seconds(f"import cvxpy, control, matplotlib.pyplot\n{MAIN}", "--help", times=1) > MOST
