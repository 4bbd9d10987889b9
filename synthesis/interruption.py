"""Ctrl-C that cannot get lost: a press is remembered, whoever swallows the exception it raises.

A KeyboardInterrupt raised inside a `__del__`, a weak reference's callback or a C++ library's callback into Python ends
there, and the program runs on. So the handler remembers the press, and long work asks for it: `demand_none`.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


class Interruption:
    """A handler of SIGINT: raises KeyboardInterrupt as Python's own does, and remembers."""

    def __init__(self) -> None:
        self.pressed = False

    def __call__(self, number: int, frame: object) -> None:
        """What Python calls when SIGINT arrives."""
        self.pressed = True
        raise KeyboardInterrupt


@contextmanager
def remembered() -> Iterator[Interruption]:
    """Remember Ctrl-C while something runs; where Python's own handler is not in place, leave what is.

    Another handler is its owner's wish (a shell's background job ignores SIGINT), and only the main thread may set one.
    """
    interruption = Interruption()
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield interruption
        return
    try:
        signal.signal(signal.SIGINT, interruption)
    except ValueError:  # not the main thread
        yield interruption
        return
    report = sys.unraisablehook
    sys.unraisablehook = lambda lost: _report_unless_interruption(lost, report)
    try:
        yield interruption
    finally:
        sys.unraisablehook = report
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _report_unless_interruption(lost: Any, report: Callable[[Any], object]) -> None:
    if not issubclass(lost.exc_type, KeyboardInterrupt):  # that one is not lost
        report(lost)


def demand_none() -> None:
    """Raise KeyboardInterrupt if Ctrl-C was pressed, also if somebody swallowed it. For any thread."""
    handler = signal.getsignal(signal.SIGINT)  # no global of ours: the process has one handler anyway
    if isinstance(handler, Interruption) and handler.pressed:
        raise KeyboardInterrupt


def demanding(progress: Callable[[str], None]) -> Callable[[str], None]:
    """The same progress, each step of which first looks for a Ctrl-C."""

    def step(text: str) -> None:
        demand_none()
        progress(text)

    return step
