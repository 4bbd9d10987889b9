"""The full sizes of all evidence, one table of counts after the other: `make evidence`."""

from __future__ import annotations

import argparse
import os
import sys
import time
from types import ModuleType

import differential_joints
import differential_polynomials
import fuzzing
import metamorphic
import resealed
from tally import gather

HARNESSES: list[ModuleType] = [differential_polynomials, differential_joints, resealed, metamorphic, fuzzing]


def main() -> int:
    """Run every harness; 1 if one finds a fault."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--share", type=float, default=1.0, help="of the full sizes (default 1)")
    given, faults = parser.parse_args(), 0
    for harness in HARNESSES:
        began = time.monotonic()
        found = gather(harness.examine, range(int(harness.FULL * given.share)), given.processes)
        sys.stdout.write(found.table(harness.TITLE, time.monotonic() - began) + "\n\n")
        sys.stdout.flush()
        faults += len(found.faults)
    sys.stdout.write(f"faults in all: {faults}\n")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
