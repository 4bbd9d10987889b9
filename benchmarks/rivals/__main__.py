"""What people would use instead of robimp, on the same problems in the same run, judged by the same prover.

`make rivals`, or `python benchmarks/rivals --problem haninger2016 --order 4 --limit 20 --solver scipy_slsqp`. Problems
(one file each) × orders of Q × solvers (one file each in `solvers/`); what is measured and what is not:
benchmarks/README.md. Results go to benchmarks/results.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from machine import machine
from rich.console import Console
from rich.progress import Progress
from rich.table import Table
from solvers import NAMES
from task import PROBLEMS, ROOT
from tutorial import compare

from robimp.synthesis.storage import write_atomic

WORKER = Path(__file__).with_name("worker.py")
RESULTS = ROOT / "benchmarks" / "results"
ORDERS = (4, 6)
GRACE = 180.0  # seconds beyond twice the limit before a process is stopped: rivals overrun, and proofs take time


def measured(solver: str, problem: str, order: int, limit: float) -> dict[str, Any]:
    """One row, from a process of its own with BLAS on one thread."""
    command = [sys.executable, str(WORKER), solver, str(PROBLEMS[problem]), str(order), str(limit)]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=2 * limit + GRACE, env=environment)
    except subprocess.TimeoutExpired as error:
        return {"solver": solver, "outcome": "stopped", "why": f"still running after {error.timeout:.0f} s"}
    if done.returncode != 0:
        return {
            "solver": solver,
            "outcome": "failed",
            "why": (done.stderr.strip().splitlines() or ["killed"])[-1][:160],
        }
    return {"solver": solver, **json.loads(done.stdout.splitlines()[-1])}


def table(title: str, rows: list[dict[str, Any]]) -> Table:
    """The rows of one problem and order, the largest proven bandwidth first."""
    shown = Table(title=title, title_justify="left", box=None)
    for heading, justify in (("solver", "left"), ("proven ω_B", "right"), ("claimed", "right"), ("time", "right")):
        shown.add_column(heading, justify=justify)  # type: ignore[arg-type]
    shown.add_column("survives the prover", no_wrap=True)
    shown.add_column("why, remarks")
    for row in sorted(rows, key=lambda row: -(row.get("omega_B") or 0)):
        seconds = row.get("seconds")
        survives = {"proven": "yes", "unstable": "no, unstable", "refuted": "no"}.get(row["outcome"], row["outcome"])
        shown.add_row(
            row["solver"],
            _number(row.get("omega_B")),
            _number(row.get("claimed")),
            "" if seconds is None else f"{seconds:.1f} s",
            survives,
            "; ".join(text for text in (row.get("why"), row.get("note")) if text),
        )
    return shown


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.2f}"


def main() -> None:
    """Run what was asked for, print the tables, write the results."""
    parser = argparse.ArgumentParser(description="Rivals of robimp on the same problems, judged by the same prover.")
    parser.add_argument("--problem", choices=PROBLEMS, action="append", help="default: all")
    parser.add_argument("--order", type=int, choices=(2, 4, 6, 8), action="append", help="default: 4 and 6")
    parser.add_argument("--solver", choices=NAMES, action="append", help="default: all")
    parser.add_argument("--limit", type=float, default=20.0, metavar="SECONDS", help="of search, each; default 20")
    parser.add_argument("--results", type=Path, default=RESULTS, metavar="DIR", help="default: benchmarks/results")
    parser.add_argument("--no-tutorial", action="store_true", help="without dkpy's tutorial against `robimp synth`")
    asked = parser.parse_args()
    problems, orders = asked.problem or list(PROBLEMS), asked.order or list(ORDERS)
    names, console = asked.solver or list(NAMES), Console(width=None if sys.stdout.isatty() else 200)
    with Progress(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as progress:
        everything = progress.add_task("", total=len(problems) * len(orders) * len(names))
        for problem in problems:
            for order in orders:
                rows = []
                for name in names:
                    progress.update(everything, description=f"{problem}, order {order}: {name}", refresh=True)
                    rows.append(measured(name, problem, order, asked.limit))
                    progress.advance(everything)
                title = f"{problem}, Q of order {order}, {asked.limit:g} s each"
                console.print(table(title, rows), "")
                result = {"problem": problem, "order": order, "limit": asked.limit, "machine": machine(), "rows": rows}
                write_atomic(asked.results / f"{problem}-order-{order}.json", _json(result))
    if not asked.no_tutorial:
        result = compare()
        console.print(result["text"])
        write_atomic(asked.results / "tutorial.json", _json({"machine": machine(), **result}))


def _json(value: Any) -> bytes:
    return (json.dumps(value, indent=1, ensure_ascii=False) + "\n").encode()


if __name__ == "__main__":
    main()
