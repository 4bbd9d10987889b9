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
from collections.abc import Callable
from fractions import Fraction
from importlib.metadata import version
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
ROBIMP = Path(sys.executable).with_name("robimp")
RUNS = 3
POINTS = 100_000
EXAMPLES = ("haninger2016-paper", "haninger2016-eq23", "haninger2016", "haninger2016-sampled", "two-modes")


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
        print(f"\n{proof_and_grid(Path(folder, 'haninger2016', 'certificate.json'))}")
    *bound, printed = timed(ROBIMP, "bound", ROOT / "examples" / "haninger2016.yaml", "--json")
    limit = json.loads(printed)
    print(f"\nbound, {limit['terms']} terms: {limit['omega_B']:.2f} rad/s in {_range(bound)}")
    from scaling import report

    print(f"\n{report()}")
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    print(f"largest memory of any of these processes: {peak:.0f} MB")


def in_process(work: Callable[[], Any]) -> float:
    """Median wall time [s] of a call in this process, after one that warms up."""
    work()
    seconds = []
    for _ in range(2 * RUNS + 1):
        began = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - began)
    return statistics.median(seconds)


def proof_and_grid(file: Path) -> str:
    """Time to prove every claim of a certificate, by either engine, against a look at a grid; BLAS on one thread."""
    from dense_grid import evaluate

    from robimp.synthesis.certificate.claims import certify
    from robimp.synthesis.check import check_file
    from robimp.synthesis.problem.setting import Setting
    from robimp.synthesis.spec import from_canonical
    from robimp.synthesis.spec.model import Polynomials

    certificate = json.loads(file.read_bytes())
    setting = Setting.of(from_canonical(certificate["spec"]))
    given = certificate["controller"]["Q"]
    Q = Polynomials(**{key: tuple(map(Fraction, row)) for key, row in given.items()})
    grid = in_process(lambda: evaluate(certificate, POINTS))
    checked = in_process(lambda: check_file(file))
    searched = in_process(lambda: certify(setting, setting.compensator(Q)))
    return (
        f"{len(certificate['claims'])} claims on a grid of {POINTS} points (numpy): {grid:.3f} s; "
        f"proven at every frequency by the checker in {checked:.3f} s, ratio {checked / grid:.2f}; "
        f"by the prover, searching the margins, in {searched:.3f} s, ratio {searched / grid:.2f}"
    )


def _range(seconds: list[float]) -> str:
    median, least, greatest = seconds
    return f"{median:.2f} ({least:.2f}–{greatest:.2f}) s"


if __name__ == "__main__":
    main()
