"""Stability on cells: half-planes that f passes through are counted as roots, and boxes end where f first has one."""

from __future__ import annotations

import cmath
import math
import random
from collections.abc import Sequence
from contextlib import suppress
from fractions import Fraction
from math import inf
from time import monotonic
from typing import Any

import pytest

from robimp.synthesis.check.enclosure import claims
from robimp.synthesis.check.enclosure.cells import Cell
from robimp.synthesis.check.enclosure.claims import CellProver
from robimp.synthesis.check.enclosure.forms import UnresolvedError
from robimp.synthesis.check.enclosure.joint import VariedJoint
from robimp.synthesis.check.outcome import FALSE, UNDECIDED, CheckError
from robimp.synthesis.check.polynomials import ONE, ZERO, Poly

WHOLE = Fraction(0), inf


class Loop(CellProver):
    """f = free + hold·held, whatever joint might have it."""

    def __init__(self, free: Poly, held: Poly = ZERO, rate: int = 1000, delay: Fraction = Fraction(0)) -> None:
        self.only = VariedJoint.__new__(VariedJoint)
        self.only.spec = self.spec = {"sampling": {"rate": Fraction(rate), "delay": delay}}
        self.only.E, self.only.rest, self.only.others = free, held, []
        self.only.load = self.only.carried = self.only.driven = ZERO
        self.certificate, self.deadline = {}, monotonic() + 20

    def joint(self, point: Any, symbols: Any = None) -> VariedJoint:
        return self.only

    def said(self) -> str:
        return self.fault(("stability-locked", "winding"), Fraction(0), WHOLE, True)


def from_roots(*roots: complex | float | Fraction) -> Poly:
    """Of pairs one root is given."""
    p = ONE
    for root in roots:
        r = complex(root)
        whole = (Fraction(r.real) ** 2 + Fraction(r.imag) ** 2, -2 * Fraction(r.real), 1)
        p = p * (Poly.of(*whole) if r.imag else Poly.of(-Fraction(root), 1))  # type: ignore[arg-type]
    return p


def said_of(n: int) -> str:
    return f": {n} roots with Re s > 0" if n else ""


# Roots, and how many are on the right.
WITHOUT_HOLD: dict[str, tuple[Sequence[Any], int]] = {
    "none": ([], 0),
    "one left": ([-3], 0),
    "one right": ([2], 1),
    "one of each": ([2, -3], 1),
    "right and fast left": ([1, -1000, -1000], 1),
    "pair left": ([-1 + 20j], 0),
    "pair right": ([1 + 20j], 2),
    "pair right, three left": ([1 + 20j, -3, -4, -500], 2),
    "three right": ([1 + 20j, 700], 3),
    "two pairs right": ([1 + 2j, 5 + 7j], 4),
    "five right": ([1, 2, 3, 4, 5], 5),
    "slow and fast: arg f goes up and down again": ([Fraction(-1, 1000)] * 2 + [-1000] * 2, 0),
    "very slow and very fast: beyond a full turn up, and down": ([Fraction(-1, 1000)] * 5 + [-1000] * 5, 0),
    "and one pair right": ([Fraction(-1, 1000)] * 3 + [-1000] * 3 + [1 + 1j], 2),
    "quarter turns in the second cell and in the last but one": ([Fraction(-1, 11)] * 8 + [-2889] * 8, 0),
    "a quarter turn and back within the last cell": ([-(2**16)] * 2 + [-(2**10)] * 4, 0),
    "the same from further out": ([-(2**18)] * 2 + [-(2**9)] * 4, 0),
    "one at −1": ([-1], 0),
    "one at 1": ([1], 1),
    "far out": ([-1e6, -2e6, -3e6 + 1e6j], 0),
    "far out, right": ([-1e6, 2e6], 1),
    "close in": ([-1e-5, -2e-5], 0),
    "close in, right": ([1e-5, -2e-5, -1], 1),
}


@pytest.mark.parametrize("name", WITHOUT_HOLD)
@pytest.mark.parametrize("scale", [1, Fraction(-(10**9), 7)])
def test_without_a_hold_it_counts_the_roots_of_a_polynomial(name: str, scale: Fraction) -> None:
    roots, right = WITHOUT_HOLD[name]
    assert Loop(Poly.of(scale) * from_roots(*roots)).said() == said_of(right)


def counted(free: Poly, held: Poly, rate: float, delay: float) -> tuple[int, float]:
    """Roots with Re s > 0 from the argument of f in floats on a grid, and how near to zero f comes there."""
    turned, last, near = 0.0, 0j, inf
    for k in range(1501):
        s = 1j * 10 ** (k / 150 - 4)
        hold = cmath.exp(-s * delay) * (-cmath.exp(-s / rate / 2) * 2 * cmath.sinh(-s / rate / 2)) / (s / rate)
        a, b = (sum(c * s**n for n, c in enumerate(p.c)) / p.d for p in (free, held))
        f = a + hold * b
        turned += cmath.phase(f / last) if last else 0.0
        last, near = f, min(near, abs(f) / (abs(a) + abs(hold * b)))
    return round((len(free.c) - 1) / 2 - turned / math.pi), near


@pytest.mark.parametrize("seed", range(6))
def test_behind_a_hold_it_counts_what_the_argument_in_floats_counts(seed: int) -> None:
    """Of all degrees; the held part has the same degree now and then, and a gain that the hold still lets through."""
    rng, found = random.Random(seed), list[int]()
    while len(found) < 4:
        n, rate, delay = rng.randint(1, 4), rng.choice([500, 1000]), Fraction(rng.choice([0, 1, 4]), 1000)
        places = [-(10 ** rng.uniform(0.5, 2)) * rng.choice([1, 1, 1, -0.3]) for _ in range(n)]
        free = from_roots(*(Fraction(x).limit_denominator(100) for x in places))
        degree = rng.choice([0, 0, 1, n]) if n < 3 else 0
        gains = [rng.uniform(-0.3, 1 if k < n else 0.2) for k in range(degree + 1)]
        held = Poly.of(*(Fraction(gain * c).limit_denominator(99) for gain, c in zip(gains, free.c, strict=False)))
        many, near = counted(free, held, rate, float(delay))
        if near > 0.1 and len(held.c) <= len(free.c) and many < 5:
            assert Loop(free, held, rate, delay).said() == said_of(many)
            found.append(many)
    assert len({*found}) > 1


def test_what_no_turns_can_tell_is_refused() -> None:
    """f(0) = 0, and a hold that decides what f is at infinity; as much of it as of the rest is no obstacle."""
    for free, held in ((ZERO, ONE), (ONE, -ONE), (ZERO, ZERO), (Poly.of(0, 1, 1), ZERO), (Poly.of(1, 1), Poly.of(-1))):
        with pytest.raises(CheckError, match="a root at zero") as zero:
            Loop(free, held).said()
        assert zero.value.code == FALSE
    with pytest.raises(CheckError, match="at infinity depends on the hold") as last:
        Loop(Poly.of(1000, 1), Poly.of(0, 0, Fraction(1, 10**9))).said()
    assert last.value.code == UNDECIDED
    assert Loop(Poly.of(9, 1), Poly.of(1, Fraction(1, 2))).said() == ""


# f without and with the hold; k: it is divided by (s + 2^k)^n, about the size of its roots
REFERENCES = [
    (Poly.of(3, 1), ZERO, 1),
    (Poly.of(-3, 1), ZERO, 1),
    (Poly.of(1000, 1), ZERO, 9),
    (Poly.of(Fraction(1, 1000), 1), ZERO, -9),
    (Poly.of(1000, 1) * Poly.of(1000, 1), ZERO, 9),
    (Poly.of(7, 1) * Poly.of(1000, 1) * Poly.of(3000, 1), ZERO, 8),
    (Poly.of(Fraction(1, 7), 1), ZERO, -2),
    (Poly.of(1, Fraction(1, 7)), ZERO, 2),
    (Poly.of(3, 2), Poly.of(61), 5),
    (Poly.of(5), Poly.of(3), 0),
    (Poly.of(500), Poly.of(3), 0),
]


@pytest.mark.parametrize(("free", "held", "k"), REFERENCES)
def test_f_is_compared_with_one_whose_roots_are_about_as_large(
    free: Poly, held: Poly, k: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Any a > 0 proves the same; with a far off there would be more turns, up and down again, in more cells."""
    cell = Cell(Fraction(1), Fraction(65, 64), False, {})

    def once(_: list[Cell], parts: Any, deadline: float) -> str:
        with suppress(UnresolvedError):
            parts(cell, {})
        raise CheckError(UNDECIDED, "seen")

    monkeypatch.setattr(claims, "cover", once)
    with pytest.raises(CheckError, match="seen"):
        Loop(free, held).said()
    reference = ONE
    for _ in free.c[1:]:
        reference = reference * Poly.of(Fraction(2) ** k, 1)
    assert reference in cell.cache
