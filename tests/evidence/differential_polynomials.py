"""Polynomials of known truth: independent checker, python-flint prover and dense floats say what is true."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from random import Random

import numpy as np
from flint import fmpq, fmpq_poly
from random_polynomials import Case, hurwitz, integers, positivity, times
from tally import Tally, command

from robimp.synthesis.certificate.hurwitz import is_hurwitz
from robimp.synthesis.certificate.lowering import SumOfRoots
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.certificate.positivity import holds, positive_univariate
from robimp.synthesis.check.outcome import CheckError
from robimp.synthesis.check.polynomials import Poly, decays_faster
from robimp.synthesis.check.positivity import Inequality, counterexample, failure

TITLE = "polynomials: truth by construction, checker, prover, floats"
FULL, SMALL = 12_000, 200
SECONDS = 20.0


def exact(x: Fraction) -> fmpq:
    return fmpq(x.numerator, x.denominator)


def point(x: Fraction | None) -> tuple[int, int]:
    return (1, 0) if x is None else (x.numerator, x.denominator)


def _floats(case: Case) -> str | None:
    """What float values between and at the roots contradict: the sign is that of `≥`, except for rounding."""
    hi = case.lo + 1000 if case.hi is None else case.hi
    at = sorted({float(case.lo), float(hi), *(r.float() for r in case.inside())})
    xs = [float(x) for a, b in pairwise(at) for x in np.linspace(a, b, 60)[1:-1]]
    if case.hi is None:
        xs += [2 * max(at[-1], 1.0)]
    values = [case.value(x) for x in xs]
    if case.truth(strict=False) and min(values, default=0.0) < 0:
        return "floats are negative where p ≥ 0"
    clear = [len(at) == len(case.inside()) + (1 if case.lo == case.hi else 2)]  # no two are one float
    clear += [b - a > 1e-9 * max(1, abs(b)) for a, b in pairwise(at)]
    if all(clear) and not case.truth(strict=False) and min([*values, case.value(at[0])], default=-1.0) > 0:
        return "floats are positive where p < 0"
    return None


def _positivity(seed: int, found: Tally) -> None:
    case = positivity(seed)
    lo, hi = point(case.lo), point(case.hi)
    for strict in (True, False):
        truth = case.truth(strict)
        at = failure(case.row, lo, hi, strict, time.monotonic() + SECONDS)
        found.expect((at is None) == truth, f"{seed}: checker, strict {strict}: {at}, truth {truth}")
        if at is not None and at[1]:
            inside = case.lo <= Fraction(*at) and (case.hi is None or Fraction(*at) <= case.hi)
            found.expect(inside, f"{seed}: the checker's point {at} is outside")
        ends = exact(case.lo), None if case.hi is None else exact(case.hi)
        said = positive_univariate(fmpq_poly(case.row), ends, strict=strict, D=len(case.row) - 1)
        found.expect(said is (Outcome.PROVEN if truth else Outcome.REFUTED), f"{seed}: prover, strict {strict}: {said}")
        found.count(f"positivity {'>' if strict else '>='} 0, {'true' if truth else 'false'}")
    if any(r.times > 1 for r in case.inside()):
        found.count("  of these with a repeated root inside")
    fault = _floats(case)
    found.expect(fault is None, f"{seed}: {fault}")


def _hurwitz(seed: int, found: Tally) -> None:
    case = hurwitz(seed)
    said = decays_faster(Poly.of(*case.row), case.rate, time.monotonic() + SECONDS)
    found.expect(said == case.truth, f"{seed}: checker: decays {said}, truth {case.truth}")
    proven = is_hurwitz(fmpq_poly(case.row), exact(case.rate))
    found.expect(proven == case.truth, f"{seed}: prover: decays {proven}, truth {case.truth}")
    found.count(f"hurwitz, {'true' if case.truth else 'false'}")
    with np.errstate(all="ignore"):
        roots = np.roots([float(Fraction(c, case.row[-1])) for c in case.row[::-1]])
    distance = abs(float(case.slowest + case.rate))
    if len(case.row) < 6 and distance > 1e-2 * max(1.0, float(np.max(np.abs(roots), initial=0))):
        found.expect((max(roots.real) < -float(case.rate)) == case.truth, f"{seed}: float roots")
        found.count("  of these compared with float roots")


def _roots(seed: int, found: Tally) -> None:
    """`Σ √(u_i²) < √b` with u_i ≥ 0 and `b = (Σ u_i)² + p`: true where p > 0."""
    rng, case = Random(seed), positivity(seed)
    terms = [[Fraction(rng.randint(0, 9), rng.randint(1, 4)) for _ in range(rng.randint(1, 3))] for _ in range(2)]
    terms = [[u[0] + 1, *u[1:]] for u in terms[: rng.randint(1, 2)]]  # no common power of x
    total = [sum((u[k] for u in terms if k < len(u)), Fraction(0)) for k in range(max(map(len, terms)))]
    while total[-1] == 0:
        total.pop()
    square, p = times(total, total), [Fraction(c) for c in case.row[: len(case.row) - case.lost]]
    degree = max(len(square), len(p))
    p, square = p + [Fraction(0)] * (degree - len(p)), square + [Fraction(0)] * (degree - len(square))
    bound = [a + b for a, b in zip(square, p, strict=True)]
    ends = (case.lo, None if case.hi is None else case.hi)
    if not _nonnegative(bound, ends):
        found.count("  sums of roots skipped: the bound is negative somewhere")
        return
    truth = _truth_of_sum(case, degree)
    checker = Inequality([Poly.of(*times(u, u)) for u in terms], Poly.of(*bound), strict=True)
    try:
        at = counterexample(checker, point(ends[0]), point(ends[1]), time.monotonic() + SECONDS)
        found.expect((at is None) == truth, f"{seed}: sum of {len(terms)} roots, checker {at}, truth {truth}")
    except CheckError as error:
        found.fault(f"{seed}: sum of {len(terms)} roots, checker undecided: {error}")
    radicands = tuple((fmpq_poly([exact(c) for c in times(u, u)]),) for u in terms)
    said = holds(
        SumOfRoots(radicands, (fmpq_poly([exact(c) for c in bound]),), True, None),
        (exact(ends[0]), None if ends[1] is None else exact(ends[1])),
        strict=True,
    )
    proven = Outcome.PROVEN if truth else Outcome.REFUTED
    found.expect(said is proven, f"{seed}: sum of {len(terms)} roots, prover {said}, truth {truth}")
    found.count(f"sums of {len(terms)} roots, {'true' if truth else 'false'}")


def _nonnegative(p: list[Fraction], ends: tuple[Fraction, Fraction | None]) -> bool:
    low, high = exact(ends[0]), None if ends[1] is None else exact(ends[1])
    row = integers(p)
    return positive_univariate(fmpq_poly(row), (low, high), strict=False, D=len(row) - 1) is Outcome.PROVEN


def _truth_of_sum(case: Case, degree: int) -> bool:
    """p > 0 on the interval; at infinity beside the leading coefficients of what it is compared with."""
    top = len(case.row) - case.lost
    if case.hi is None and degree > top:
        return False  # p is of lower degree than what it is compared with
    return replace(case, lost=0).truth(strict=True)


def examine(seeds: Sequence[int]) -> Tally:
    found = Tally()
    for seed in seeds:
        began = time.process_time()
        (_positivity, _hurwitz, _roots)[seed % 3](seed, found)
        found.measure("seconds of one case", time.process_time() - began)
        found.count("cases")
    return found


if __name__ == "__main__":
    sys.exit(command(TITLE, examine, FULL))
