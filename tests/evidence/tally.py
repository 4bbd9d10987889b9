"""What a harness counts: cases by kind and outcome, and the faults; in one process or several."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from multiprocessing import get_context

CHUNKS_PER_PROCESS = 8


@dataclass
class Tally:
    """Counts by name, the largest of some figures, and one line for every fault."""

    counts: Counter[str] = field(default_factory=Counter)
    largest: dict[str, float] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)

    def count(self, name: str, number: int = 1) -> None:
        self.counts[name] += number

    def fault(self, text: str) -> None:
        self.faults.append(text)

    def expect(self, holds: bool, text: str) -> None:
        if not holds:
            self.fault(text)

    def measure(self, name: str, value: float) -> None:
        self.largest[name] = max(value, self.largest.get(name, value))

    def merge(self, other: Tally) -> None:
        self.counts += other.counts
        for name, value in other.largest.items():
            self.measure(name, value)
        self.faults += other.faults

    def table(self, title: str, seconds: float) -> str:
        lines = [f"{title}  ({seconds:.0f} s)"]
        lines += [f"  {name:<58}{number:>9}" for name, number in sorted(self.counts.items())]
        lines += [f"  {'largest ' + name:<58}{value:>9.3g}" for name, value in sorted(self.largest.items())]
        lines += [f"  {'faults':<58}{len(self.faults):>9}"]
        return "\n".join(lines + [f"  FAULT {text}" for text in self.faults[:20]])


Examine = Callable[[Sequence[int]], Tally]


def gather(examine: Examine, seeds: Iterable[int], processes: int = 1) -> Tally:
    """The tally of all seeds, split over processes; the split changes nothing but the time."""
    todo, whole = list(seeds), Tally()
    if processes == 1:
        return examine(todo)
    step = processes * CHUNKS_PER_PROCESS
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        for part in pool.map(examine, [todo[k::step] for k in range(step)]):
            whole.merge(part)
    return whole


def command(title: str, examine: Examine, full: int) -> int:
    """Command line of one harness: prints its table; 1 if there is a fault."""
    parser = argparse.ArgumentParser(description=title)
    parser.add_argument("--size", type=int, default=full, help=f"number of cases (default {full})")
    parser.add_argument("--seed", type=int, default=0, help="the first case")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    began = time.monotonic()
    found = gather(examine, range(given.seed, given.seed + given.size), given.processes)
    sys.stdout.write(found.table(title, time.monotonic() - began) + "\n")
    return 1 if found.faults else 0
