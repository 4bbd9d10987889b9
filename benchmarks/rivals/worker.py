"""One solver on one problem in a process of its own, so that one that hangs can be stopped: prints a row as JSON."""

from __future__ import annotations

import json
import sys
import time
import traceback
from dataclasses import asdict
from pathlib import Path
from typing import Any

import solvers
from task import Task
from verdicts import judge


def row(solver: str, spec_file: Path, order: int, limit: float) -> dict[str, Any]:
    """Run, judge, and describe; a missing package is a skipped row, a failure is a row that says so."""
    task = Task.of(spec_file, order, limit)
    began, busy = time.monotonic(), time.process_time()
    try:
        answer = solvers.solve(solver, task)
    except ImportError as error:
        return {"outcome": "skipped", "why": f"needs the package {error.name or error}: pip install '.[bench]'"}
    except Exception as error:  # whatever a rival dies of is its result
        place = traceback.extract_tb(error.__traceback__)[-1]
        why = f"{type(error).__name__} in {Path(place.filename).name}: {str(error)[:120]}"
        return {"outcome": "failed", "why": why, "seconds": time.monotonic() - began}
    elapsed = {"seconds": time.monotonic() - began, "cpu_seconds": time.process_time() - busy}
    found: dict[str, Any] = {**elapsed, "note": answer.note}
    if answer.candidate is None:
        return {**found, "outcome": "none found"}
    judged = asdict(judge(task, answer.candidate))
    Q = answer.candidate.coefficients
    return {
        **found,
        "claimed": answer.candidate.claimed,
        **{("proof_seconds" if key == "seconds" else key): value for key, value in judged.items()},
        "Q": {key: [str(c) for c in getattr(Q, key)] for key in ("numerator", "denominator")},
    }


if __name__ == "__main__":
    solver, spec_file, order, limit = sys.argv[1:]
    print(json.dumps(row(solver, Path(spec_file), int(order), float(limit))))
