"""Print how long synthesis, bound and check take as whole processes, and what they reach: `make bench`.

Each command runs RUNS times; the median is printed with the lowest and highest. Comparable on one machine, in one run.
"""

from __future__ import annotations

import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path

ROOT = Path(__file__).parents[1]
ROBIMP = Path(sys.executable).with_name("robimp")
RUNS = 3
EXAMPLES = ("haninger2016-paper", "haninger2016-eq23", "haninger2016")


def timed(*command: str | Path) -> tuple[float, float, float, str]:
    """Median, least and greatest wall time [s] of a command, and what it printed."""
    seconds = []
    for _ in range(RUNS):
        began = time.perf_counter()
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=True)
        seconds.append(time.perf_counter() - began)
    return statistics.median(seconds), min(seconds), max(seconds), done.stdout


def main() -> None:
    """Run everything and print one table."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    packages = ("robimp", "numpy", "casadi", "cvxpy", "clarabel", "python-flint")
    print(f"{platform.machine()}, {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}")
    print(", ".join(f"{name} {version(name)}" for name in packages))
    print(f"wall seconds of whole processes: median (least–greatest) of {RUNS} runs\n")
    print(f"{'example':<20}{'synth':>22}{'proven ω_B':>13}{'check':>22}")
    with tempfile.TemporaryDirectory() as folder:
        for name in EXAMPLES:
            spec, out = ROOT / "examples" / f"{name}.yaml", Path(folder) / name
            *synth, printed = timed(ROBIMP, "synth", spec, "-o", out, "--json")
            *check, _ = timed(ROBIMP, "check", out / "certificate.json")
            print(f"{name:<20}{_range(synth):>22}{json.loads(printed)['omega_B']:>13.3f}{_range(check):>22}")
    *bound, printed = timed(ROBIMP, "bound", ROOT / "examples" / "haninger2016.yaml", "--json")
    limit = json.loads(printed)
    print(f"\nbound, {limit['terms']} terms: {limit['omega_B']:.2f} rad/s in {_range(bound)}")
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    print(f"largest memory of any of these processes: {peak:.0f} MB")


def _range(seconds: list[float]) -> str:
    median, least, greatest = seconds
    return f"{median:.2f} ({least:.2f}–{greatest:.2f}) s"


if __name__ == "__main__":
    main()
