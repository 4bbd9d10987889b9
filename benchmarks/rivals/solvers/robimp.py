"""robimp itself, the whole pipeline: bound, search with the proof in the loop, proof, re-check, simulation."""

from __future__ import annotations

from task import Answer, Candidate, Task

from robimp.synthesis import RobimpError, synthesize


def solve(task: Task) -> Answer:
    """`synthesize` within the time limit (which bounds the search alone)."""
    try:
        result = synthesize(task.setting.spec, time_limit=task.limit)
    except RobimpError as error:
        return Answer(None, str(error))
    bound = "" if result.bound is None else f"bound {result.bound.omega_B:.4g}"
    return Answer(Candidate(result.coefficients, float(result.omega_B)), bound)
