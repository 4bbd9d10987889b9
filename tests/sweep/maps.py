"""A small map, in this process or in one of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from robimp.synthesis.sweep import run as home
from robimp.synthesis.sweep.axis import Axis
from robimp.synthesis.sweep.cell import Cell, Status, Task, solve_cell
from robimp.synthesis.sweep.journal import NAME
from robimp.synthesis.sweep.plane import Plane

AXES = {"impedance.stiffness": "2:8:2", "impedance.damping": "0.2:0.6:3"}
COMMAND = ("--stiffness", "2:8:2", "--damping", "0.2:0.6:3", "--processes", "2")
MAIN = "import sys\nfrom robimp.synthesis.cli import main\nmain()\n"


class Here:
    """An executor in this process: what each cell was given, and what a test makes of it."""

    def __init__(self, answer: Callable[[Task], Any]) -> None:
        self.answer, self.tasks = answer, []  # type: ignore[var-annotated]

    def submit(self, _: Any, task: Task) -> Future[Any]:
        self.tasks.append(task)
        future: Future[Any] = Future()
        try:
            future.set_result(self.answer(task))
        except Exception as error:
            future.set_exception(error)
        return future


def here(monkeypatch: pytest.MonkeyPatch, answer: Callable[[Task], Any] = solve_cell) -> Here:
    """Solve cells in this process from now on."""
    executor = Here(answer)

    @contextmanager
    def workers(*_: Any) -> Iterator[tuple[Here, int]]:
        yield executor, 1

    monkeypatch.setattr(home, "workers", workers)
    return executor


def proven(task: Task) -> tuple[Cell, None]:
    return Cell(
        task.index, Status.PROVEN, Fraction(10 + sum(task.index)), coefficients=task.spec.controller.coefficients
    ), None


def lines(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / NAME).read_bytes().splitlines()]


def robimp(*arguments: str | Path, **options: Any) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", MAIN, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, **options)


def plane(spec: Path) -> Plane:
    first, second = (Axis.parse(*axis) for axis in AXES.items())
    return Plane.of(spec, (first, second))
