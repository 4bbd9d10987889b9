"""Polynomials and sums of roots whose truth is known because their roots were chosen."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from random import Random

Row = list[int]  # integer coefficients, constant first


@dataclass(frozen=True)
class Root:
    """`a + sign √b`, real for b ≥ 0 (rational if b = 0), a pair `a ± j√−b` for b < 0; with its multiplicity."""

    a: Fraction
    b: Fraction
    sign: int
    times: int

    def above(self, x: Fraction) -> int:
        """Sign of root − x, exact."""
        gap = self.a - x
        if self.b == 0:
            return (gap > 0) - (gap < 0)
        reach = self.b - gap * gap
        if reach == 0:
            return 0 if (gap < 0) == (self.sign > 0) else (1 if gap > 0 else -1)
        return self.sign if reach > 0 else (1 if gap > 0 else -1)

    def float(self) -> float:
        return float(self.a) + self.sign * float(self.b) ** 0.5


@dataclass(frozen=True)
class Case:
    """A polynomial with its chosen roots; `lost` degrees are roots at infinity; hi None is infinity."""

    row: Row
    roots: tuple[Root, ...]  # the real ones
    pairs: tuple[Root, ...]
    lead: int
    lost: int
    lo: Fraction
    hi: Fraction | None

    def sign(self, x: Fraction) -> int:
        out = self.lead
        for root in self.roots:
            out *= (-root.above(x)) ** root.times
        return out

    def value(self, x: float) -> float:
        """In floats, from the roots: no cancellation."""
        out = float(self.lead)
        for root in self.roots:
            out *= (x - root.float()) ** root.times
        for pair in self.pairs:
            out *= ((x - float(pair.a)) ** 2 - float(pair.b)) ** pair.times
        return out

    def inside(self) -> list[Root]:
        """Real roots in the open interval."""
        return [r for r in self.roots if r.above(self.lo) > 0 and (self.hi is None or r.above(self.hi) < 0)]

    def truth(self, strict: bool) -> bool:
        """Whether p > 0 (or ≥ 0) on [lo, hi], infinity compared by its formal degree."""
        top = (0 if self.lost else self.lead) if self.hi is None else self.sign(self.hi)
        if strict:
            return self.sign(self.lo) > 0 and top > 0 and not self.inside()
        if self.sign(self.lo) < 0 or top < 0 or any(r.times % 2 for r in self.inside()):
            return False
        inner = self.roots if self.lo != self.hi else ()
        flips = sum(r.times for r in inner if r.above(self.lo) > 0)
        return self.lo == self.hi or self.lead * (-1) ** flips > 0


def times(p: list[Fraction], q: list[Fraction]) -> list[Fraction]:
    out = [Fraction(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            out[i + j] += a * b
    return out


def integers(p: list[Fraction]) -> Row:
    """The same polynomial times a positive number."""
    scale = lcm(*(c.denominator for c in p))
    return [int(c * scale) for c in p]


def positivity(seed: int) -> Case:
    """A polynomial in x with single, double, triple, irrational and nearly real roots, near and on the ends."""
    rng = Random(seed)
    lo = rng.choice([Fraction(0), Fraction(0), Fraction(rng.randint(0, 30), rng.randint(1, 9))])
    wide = lo + Fraction(rng.randint(1, 60), rng.randint(1, 9))
    hi = rng.choice([None, None, wide, wide, lo])
    end = wide if hi is None else hi
    chosen: dict[tuple[Fraction, Fraction, int], int] = {}
    pairs = []

    def place() -> Fraction:
        kind = rng.random()
        if kind < 0.12:
            return lo
        if kind < 0.24:
            return end
        if kind < 0.34:
            return rng.choice([lo, end]) + rng.choice([-1, 1]) * Fraction(1, 10 ** rng.randint(3, 25))
        if kind < 0.7:
            return -Fraction(rng.randint(0, 400), rng.randint(1, 20))
        return lo + (end - lo + 1) * Fraction(rng.randint(0, 200), rng.randint(1, 150))

    for _ in range(rng.randint(0, 4)):
        kind, a, often = rng.random(), place(), rng.choice([1, 1, 2, 2, 2, 3, 4])
        if kind < 0.5:
            chosen[a, Fraction(0), 1] = often
        elif kind < 0.7:  # both √ have the same multiplicity: the coefficients stay rational
            b = Fraction(rng.choice([2, 3, 5, 7, 11]), rng.choice([1, 1, 10**6, 10**20])) * rng.randint(1, 9) ** 2
            chosen[a, b, 1] = chosen[a, b, -1] = often
        else:
            pairs.append(Root(a, -Fraction(1, 10 ** rng.choice([0, 1, 3, 9, 15, 30])) * rng.randint(1, 9), 1, often))
    roots = tuple(Root(*key, often) for key, often in chosen.items())
    lead, lost = rng.choice([1, 1, 1, 1, -1]), rng.choice([0, 0, 0, 1, 2])
    p = [Fraction(lead)]
    for root in [r for r in (*roots, *pairs) if r.sign > 0]:
        factor = [-root.a, Fraction(1)] if root.b == 0 else [root.a**2 - root.b, -2 * root.a, Fraction(1)]
        for _ in range(root.times):
            p = times(p, factor)
    return Case(integers(p) + [0] * lost, roots, tuple(pairs), lead, lost, lo, hi)


@dataclass(frozen=True)
class Stable:
    """A polynomial in s by its roots; all of them have Re s < −rate, or not."""

    row: Row
    rate: Fraction
    slowest: Fraction

    @property
    def truth(self) -> bool:
        return self.slowest < -self.rate


def hurwitz(seed: int) -> Stable:
    """Roots far, near and on the line Re s = −rate, repeated, over many decades."""
    rng = Random(seed)
    rate = rng.choice([Fraction(0), Fraction(0), Fraction(rng.randint(1, 40), rng.randint(1, 9))])
    p, slowest = [Fraction(rng.choice([1, -1, 3]))], None
    for _ in range(rng.randint(1, 7)):
        kind = rng.random()
        gap = Fraction(rng.randint(1, 99), 10 ** rng.choice([0, 0, 0, 1, 6, 12, 25]))
        real = -rate + (gap / 10 if kind < 0.05 else 0 if kind < 0.1 else -gap)
        imaginary = rng.choice(
            [0, Fraction(rng.randint(1, 999), rng.randint(1, 99)) * Fraction(10) ** rng.randint(-3, 4)]
        )
        factor = [real**2 + imaginary**2, -2 * real, Fraction(1)] if imaginary else [-real, Fraction(1)]
        for _ in range(rng.choice([1, 1, 1, 2, 6])):
            p = times(p, factor)
        slowest = real if slowest is None else max(slowest, real)
    assert slowest is not None
    return Stable(integers(p), rate, slowest)
