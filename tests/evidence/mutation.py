"""Mutation testing of the checker: one small change at a time, run against its own tests; what survives is listed.

    python tests/evidence/mutation.py [--record FILE] [--budget 600] [--module positivity.py] [--slowest 1]

pytest collects the tests once. Each mutant is a fork of that process with its code exchanged; it runs the tests that
enter the changed function until one fails: first those that noticed other changes of it, then the quick ones. With
--record the same command goes on where the budget ended: tried again is everything after a change of the checker, what
was noticed after a change of the test that noticed it, and what survived after a change of any test. Survivors that are
explained in survivors.md (one line each) are not reported; the exit code is 1 if another one survives.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import random
import resource
import signal
import sys
import time
import traceback
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple, TypeVar

import pytest
from _pytest.runner import runtestprotocol
from mutants import PACKAGE, Mutant, mutants, transplant

ROOT = Path(__file__).parents[2]
CHECK = ROOT / "synthesis" / "check"
TESTS = [ROOT / "tests" / "evidence" / "test_evidence_corpus.py", ROOT / "tests" / "check"]
DATA = ROOT / "tests" / "data"
SURVIVORS = Path(__file__).with_name("survivors.md")
SLOWER, GRACE = 8, 3.0  # a test that computes so many times as long, and so many seconds [s] more, has noticed
MEMORY = 4 * 2**30  # bytes that a mutant may fill
WAITING = 10  # and so many times that by the clock, if it waits
SURVIVED, UNLOADED, ENDED = "survived", "does not load", "ends the process"
T = TypeVar("T")


class Reach(NamedTuple):
    """What one test does without any change: its processor time [s], the names of the checker's functions it enters."""

    seconds: float
    places: frozenset[str]


def explained() -> set[str]:
    """Keys of the survivors that have an explanation."""
    lines = SURVIVORS.read_text(encoding="utf-8").splitlines()
    return {line[2:].rsplit(" ⇒ ", 1)[0] for line in lines if line.startswith("- ") and " ⇒ " in line}


def digest(files: Iterable[Path]) -> str:
    """Of the content of files."""
    return hashlib.sha256(b"".join(f.read_bytes() for f in sorted(files))).hexdigest()[:16]


def failed(item: pytest.Item, after: pytest.Item | None) -> bool:
    """Run one test."""
    return any(report.failed for report in runtestprotocol(item, log=False, nextitem=after))


def reach(item: pytest.Item) -> Reach:
    """Run one test, and see which of the checker's functions it enters."""
    places: set[str] = set()

    def enter(frame: FrameType, event: str, _: Any) -> None:
        if event == "call" and frame.f_globals.get("__name__", "").startswith(PACKAGE):
            places.add(frame.f_code.co_name)

    began = sum(os.times()[:4])  # of processor time, children too: on a busy machine no test is slower
    sys.setprofile(enter)
    try:
        wrong = failed(item, None)
    finally:
        sys.setprofile(None)
    if wrong:
        raise RuntimeError("fails without any change")
    return Reach(sum(os.times()[:4]) - began, frozenset(places))


def trial(mutant: Mutant, items: list[pytest.Item], known: dict[str, Reach]) -> str:
    """The first test that notices a mutant; the process ends by a signal if one is not done in its time."""
    try:
        transplant(mutant)
    except (Exception, SystemExit) as fault:
        return f"{UNLOADED}: {type(fault).__name__}"
    for item, after in zip(items, [*items[1:], None], strict=True):
        allowed = SLOWER * known[item.nodeid].seconds + GRACE
        signal.setitimer(signal.ITIMER_PROF, allowed)  # of processor time: a busy machine notices nothing
        signal.setitimer(signal.ITIMER_REAL, WAITING * allowed)
        if failed(item, after):
            return item.nodeid
    return SURVIVED


def in_forks(work: Iterable[T], do: Callable[[T], Any], processes: int, until: float) -> Iterable[tuple[T, Any]]:
    """Each piece of work with its answer, from a process of its own; None if a signal ended that.

    Raises: RuntimeError when the work itself failed, which says nothing about the checker.
    """
    running: dict[int, tuple[T, int]] = {}
    waiting = iter(work)
    while True:
        while len(running) < processes and time.monotonic() < until:
            try:
                piece = next(waiting)
            except StopIteration:
                break
            source, sink = os.pipe()
            if pid := os.fork():
                os.close(sink)
                running[pid] = (piece, source)
                continue
            try:
                os.setsid()  # its own children end with it
                resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
                signal.signal(signal.SIGALRM, signal.SIG_DFL)
                answer = json.dumps(do(piece), default=list).encode()
                os.write(sink, answer)
                os._exit(0)
            except BaseException:
                traceback.print_exc()
                os._exit(1)
        if not running:
            return
        pid, status = os.wait()
        piece, source = running.pop(pid)
        with os.fdopen(source, "rb") as pipe:
            said = pipe.read()
        if not said and not os.WIFSIGNALED(status):
            raise RuntimeError(f"{piece}: not tried, see above")
        yield piece, json.loads(said) if said else None


class Mutation:
    """The pytest plugin that runs mutants in place of tests."""

    def __init__(self, given: argparse.Namespace) -> None:
        self.given, self.counts, self.survivors = given, Counter[str](), list[Mutant]()
        self.tests = sorted(file for path in given.tests for file in (path.rglob("*.py") if path.is_dir() else [path]))
        self.checker = digest([*CHECK.rglob("*.py"), *DATA.rglob("*.json")])
        self.noticing = defaultdict[str, Counter[str]](Counter)  # of each function: how often a test noticed a change

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        processes, known = self.given.processes, self.reached(session.items)
        tried = self.recorded()
        until = time.monotonic() + self.given.budget
        todo = (m for m in self.todo() if m.key not in tried)
        look = lambda m: trial(m, self.asked(m.place, session.items, known), known)  # noqa: E731
        for mutant, by in in_forks(todo, look, processes, until):
            tried[mutant.key] = by or ENDED
            self.noticing[mutant.place][by] += 1
            self.note(mutant, tried[mutant.key])
        for mutant in self.todo():
            self.count(mutant, tried.get(mutant.key))
        return True

    def reached(self, items: list[pytest.Item]) -> dict[str, Reach]:
        """What every test does, from beside the record if these tests were run on this checker before."""
        named, wanted = {item.nodeid: item for item in items}, f"{self.checker} {digest(self.tests)}"
        kept = self.given.record and self.given.record.with_suffix(".reach.json")
        found = json.loads(kept.read_text(encoding="utf-8")) if kept and kept.exists() else {}
        if found.get("digest") != wanted:
            answers = in_forks(named, lambda n: reach(named[n]), self.given.processes, float("inf"))
            found = {"digest": wanted, "tests": dict(answers)}
            if kept:
                kept.write_text(json.dumps(found, default=list), encoding="utf-8")
        return {name: Reach(seconds, frozenset(places)) for name, (seconds, places) in found["tests"].items()}

    def asked(self, place: str, items: list[pytest.Item], known: dict[str, Reach]) -> list[pytest.Item]:
        """The tests that enter a function, or all if none does; slow ones only if no quick one does."""
        before = self.noticing[place]
        entering = [i for i in items if place in known[i.nodeid].places] or items
        quick = [i for i in entering if known[i.nodeid].seconds <= self.given.slowest]
        return sorted(quick or entering, key=lambda i: (-before[i.nodeid], known[i.nodeid].seconds))

    def todo(self) -> list[Mutant]:
        """All mutants that were asked for, in an order that makes the first ones a fair sample."""
        files = {file.relative_to(CHECK).as_posix(): file for file in sorted(CHECK.rglob("*.py"))}
        wanted = [file for name, file in files.items() if name in (self.given.module or files)]
        found = [m for file in wanted for m in mutants(file, CHECK)]
        random.Random(self.given.seed).shuffle(found)
        return found

    def recorded(self) -> dict[str, str]:
        """What the record says that still holds."""
        if self.given.record is None or not self.given.record.exists():
            return {}
        lines = [json.loads(line) for line in self.given.record.read_text(encoding="utf-8").splitlines()]
        return {key: by for checker, tests, key, by in lines if (checker, tests) == (self.checker, self.judges(by))}

    def note(self, mutant: Mutant, by: str) -> None:
        """Add a line to the record."""
        if self.given.record:
            with self.given.record.open("a", encoding="utf-8") as file:
                file.write(json.dumps([self.checker, self.judges(by), mutant.key, by]) + "\n")

    def judges(self, by: str) -> str:
        """Digest of the file of the test that noticed and what it uses; if none did, of all, and which were asked."""
        one = [file for file in self.tests if "::" in by and file.name == Path(by.split("::")[0]).name]
        used = [file for file in self.tests if not file.name.startswith("test_")]
        return digest([*one, *used]) if one else f"{digest(self.tests)} {self.given.slowest}"

    def count(self, mutant: Mutant, by: str | None) -> None:
        how = "not tried" if by is None else "noticed" if by != SURVIVED else "survived, explained"
        how = by if by and by.startswith(UNLOADED) else how
        if by == SURVIVED and mutant.key not in explained():
            how = SURVIVED
            self.survivors.append(mutant)
        self.counts[how] += 1


def main() -> int:
    """Try mutants within the budget, and print what survived and the counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--budget", type=float, default=600, help="seconds of trying (default 600)")
    parser.add_argument("--module", action="append", help="file, as enclosure/cells.py (default all)")
    parser.add_argument("--record", type=Path, help="file of what was tried, to go on later")
    parser.add_argument("--tests", nargs="+", type=Path, default=TESTS)
    parser.add_argument("--slowest", type=float, default=float("inf"), help="seconds; a slower test is the last resort")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    mutation = Mutation(given)
    options = ["-qq", "-p", "no:cacheprovider", "-p", "no:xdist", "-o", "addopts="]
    code = pytest.main([*options, "--hypothesis-seed=0", *map(str, given.tests)], plugins=[mutation])
    for mutant in sorted(mutation.survivors, key=lambda m: (m.file, m.line)):
        sys.stdout.write(f"{mutant.file}:{mutant.line}\n- {mutant.key} ⇒ \n")
    sys.stdout.write(", ".join(f"{n} {how}" for how, n in mutation.counts.items()) + "\n")
    return 1 if mutation.survivors or code else 0


if __name__ == "__main__":
    sys.exit(main())
