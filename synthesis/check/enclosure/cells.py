"""Cells of ω: what polynomials, symbols and the hold are on them."""

from __future__ import annotations

from collections.abc import Iterable
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache, reduce
from itertools import pairwise
from math import factorial, inf
from operator import add
from typing import Any

from ..joint import Ranges
from ..polynomials import ONE, Poly, X
from .forms import BITS, Axis, Form, UnresolvedError

Taylor = tuple[int, int, int, int]  # 2^-BITS (c0 + c1 t + c2 t² ± r)
ZERO = Fraction(0)
TERMS = 30  # of the exponential's series


class Cell:
    """χ in [lo, hi], χ = x = ω², or 1/x if far; ζ = −χ/2^b. Every parameter in `ranges` is a symbol."""

    def __init__(self, lo: Fraction, hi: Fraction, far: bool, ranges: Ranges) -> None:
        self.lo, self.hi, self.far, self.ranges, self.ends = lo, hi, far, ranges, lo == 0
        self.key = lo, hi, far, tuple(ranges.items())
        self.b = hi.numerator.bit_length() - hi.denominator.bit_length() if hi else 0
        self.cache: dict[Any, Any] = {}
        c, d = ((hi + sign * lo) / 2 / Fraction(2) ** self.b for sign in (1, -1))
        self.taylor: dict[int, Taylor] = {0: (1 << BITS, 0, 0, 0), 1: (-_fixed(c), -_fixed(d), 0, 2)}
        if lo:  # 1/(c + d t) = 1/c − d t/c² + d² t²/c³ ∓ d³/(c³(c − d))
            rest = _fixed(d**3 / (c**3 * (c - d))) + 4  # four floors
            self.taylor[-1] = -_fixed(1 / c), _fixed(d / c**2), -_fixed(d**2 / c**3), rest

    def halves(self) -> list[Cell]:
        """Two halves, the one at smaller ω first."""
        middle = (self.lo + self.hi) / (2 if self.lo else 4)
        below = (1 / self.hi, 1 / middle) if self.far else (self.lo, middle)
        above = (self.lo, middle) if self.far else (middle, self.hi)
        return [Cell(*below, False, self.ranges), Cell(*above, self.far, self.ranges)]

    def __str__(self) -> str:
        ω = (Decimal(self.lo.numerator) / self.lo.denominator).sqrt()
        return " at ω = inf" if self.far else f" at ω = {ω:.6g} rad/s"

    def form(self, c: Fraction | int = 0, k: int = 0, value: Fraction | int = 0, r: Fraction | int = 0) -> Form:
        """`c + value t_k ± r` from rationals."""
        top = max(abs(Fraction(c)), abs(Fraction(value)), Fraction(r))
        e, values = top.numerator.bit_length() - top.denominator.bit_length() - BITS, [0] * (len(self.ranges) + 1)
        values[k] = _fixed(value, -e)
        return Form(self, 0, e, _fixed(c, -e), values, 0, _fixed(r, -e) + 3 if top else 0)

    def power(self, k: int) -> Form:
        """ζ^k."""
        if k not in self.cache:
            self.cache[k] = self._sum([(k, 1, -k * self.b)], 0)
        return self.cache[k]  # type: ignore[no-any-return]

    def axis(self, value: Any) -> Axis:
        """A polynomial in s on this cell; what is on it already stays."""
        if isinstance(value, Axis):
            return value
        if value not in self.cache:
            terms: tuple[list[tuple[int, int, int]], ...] = ([], [])
            for k, a, e in _mantissas(value):
                terms[k % 2].append((-((k + 1) // 2) if self.far else k // 2, a, e))
            self.cache[value] = Axis(*map(self._sum, terms))
        return self.cache[value]  # type: ignore[no-any-return]

    def spread(self, first: Poly, *others: Poly) -> Axis:
        """The first where symbols are 0, the others where one of them is 1, and linear in each."""
        changes = ((k, other - first) for k, other in enumerate(others, 1))
        found: Axis = reduce(add, (self.axis(change).along(k) for k, change in changes if change), self.axis(first))
        return found

    def real(self, value: Any) -> Form:
        """A polynomial in x on this cell; what is on it already stays."""
        if isinstance(value, Poly) and (value,) not in self.cache:
            terms = [(-k if self.far else k, -a if k % 2 else a, e) for k, a, e in _mantissas(value)]
            self.cache[(value,)] = self._sum(terms)
        return self.cache[(value,)] if isinstance(value, Poly) else value  # type: ignore[no-any-return]

    def _power(self, k: int) -> Taylor:
        step, n = (1, k) if k > 0 else (-1, k)
        while n not in self.taylor:
            n -= step
        while n != k:  # not recursive: k may be large
            (a0, a1, a2, ra), (b0, b1, b2, rb) = self.taylor[n], self.taylor[step]
            r = (abs(a0) + abs(a1) + abs(a2)) * rb + (abs(b0) + abs(b1) + abs(b2) + rb) * ra
            r += abs(a1 * b2) + abs(a2 * b1) + abs(a2 * b2)
            c = a0 * b0, a0 * b1 + a1 * b0, a0 * b2 + a1 * b1 + a2 * b0
            n += step
            self.taylor[n] = c[0] >> BITS, c[1] >> BITS, c[2] >> BITS, (r >> BITS) + 4
        return self.taylor[k] if self.hi or not k else (0, 0, 0, 0)

    def _sum(self, terms: list[tuple[int, int, int]], at: int | None = None) -> Form:
        """`Σ a 2^e z^k`, z = −χ = 2^b ζ, of terms (k, a, e): the second order in t is summed before it is bounded."""
        if not terms:
            return self.form()
        if not self.hi:  # ζ = 0: the first term is all
            terms = [min(terms)]
        sized = [(a.bit_length() + e + k * self.b, k, a, e + k * self.b) for k, a, e in terms]
        top, largest = max(sized)[:2]
        m = at if at is not None else min(k for _, k, _, _ in sized) if self.ends else largest
        low, c0, c1, c2, r = top - BITS - 8, 0, 0, 0, 0
        for _, k, a, e in sized:  # a is off by δ < 1, shifted by n bits by δ/2^n + 1 − 1/2^n < 1
            a = a << e - low if e > low else a >> low - e
            z0, z1, z2, zr = self._power(k - m)
            c0, c1, c2 = c0 + a * z0, c1 + a * z1, c2 + a * z2
            r += abs(a) * zr + abs(z0) + abs(z1) + abs(z2) + zr
        return Form(self, m, low - BITS, c0, [c1] + [0] * len(self.ranges), c2, r)

    def omega(self) -> Form:
        """ω, on a cell that is not far."""
        return self.real(X).at(0).root()

    def hold(self, rate: Fraction, delay: Fraction) -> Axis:
        """`e^{-sd} φ(sT)`, `φ(z) = (1 − e^{-z})/z`: Taylor at z/2^k, then `φ(2z) = φ(z)(1 + e^{-z})/2`, and squares.

        Where a cell is too wide for that, and when far, what is used is |…| ≤ 1 and ≤ 2/(ωT)."""
        if self.far:  # w/(sT), |w| ≤ 2: p = Im(w)/(ωT), q = Re(w)/T
            return Axis(self.form(r=self.hi).root() * self.form(r=2 * rate), self.form(r=2 * rate))
        k = 0
        while max(1 / rate, delay) ** 2 * self.hi > 4 ** (k + 1):
            k += 1
        wait, lag, mean = (self._exponential(a / 2**k, n) for a, n in ((delay, 0), (1 / rate, 0), (1 / rate, 1)))
        for _ in range(k):
            if max(z.p.size() for z in (wait, lag, mean)) > 1:  # it cannot be that large
                return self._bounded_hold(rate)
            wait, lag, mean = wait * wait, lag * lag, mean * (lag + ONE) * Poly.of(Fraction(1, 2))
            wait, lag, mean = (Axis(z.p.at(0), z.q.at(0)) for z in (wait, lag, mean))
        found = wait * mean
        return found if found.p.size() <= 1 else self._bounded_hold(rate)

    def _bounded_hold(self, rate: Fraction) -> Axis:
        """What |hold| ≤ 1 and ≤ 2/(ωT) say."""
        if self.ends:
            raise UnresolvedError
        over = self.form(r=1 / self.lo).root()
        p = self.form(r=2 * rate) * over if self.lo > 4 * rate**2 else self.form(r=1)
        return Axis(p, p * over)

    def _exponential(self, a: Fraction, n: int) -> Axis:
        """`e^{-sa}`, or (n = 1) `(1 − e^{-sa})/(sa)`: Re and Im alternate, errors are below what is omitted."""
        rest = (a * a * self.hi) ** (TERMS // 2) / factorial(TERMS)
        return self.axis(_series(a, n)) + Axis(self.form(r=rest), self.form(r=a * rest))


def _fixed(value: Fraction | int, bits: int = BITS) -> int:
    return (value.numerator << max(bits, 0)) // (value.denominator << max(-bits, 0))


@lru_cache(maxsize=64)
def _series(a: Fraction, n: int) -> Poly:
    return Poly.of(*((-a) ** k / factorial(k + n) for k in range(TERMS)))


@lru_cache(maxsize=4096)
def _mantissas(p: Poly) -> list[tuple[int, int, int]]:
    """Nonzero coefficients as `(k, a, e)`: a 2^e to within 2^e, a of BITS + 8 bits."""
    sized = [(k, a, a.bit_length() - p.d.bit_length() - BITS - 8) for k, a in enumerate(p.c) if a]
    return [(k, (a << max(-e, 0)) // (p.d << max(e, 0)), e) for k, a, e in sized]


def roots(interval: tuple[Fraction, Any], breaks: Iterable[Fraction], ranges: Ranges) -> list[Cell]:
    """Cells that cover the interval of ω: powers of 4 in x = ω², and breaks in ω."""
    lo, hi = (inf if end == inf else Fraction(end) ** 2 for end in interval)
    if lo == hi:
        return [Cell(ZERO, ZERO, True, ranges) if lo == inf else Cell(Fraction(lo), Fraction(lo), False, ranges)]
    inner = {Fraction(4) ** k for k in range(-6, 15)} | {b**2 for b in breaks} | {lo * 2}
    points = [lo, *sorted(x for x in inner if lo < x < hi), *[hi] * (hi != inf)]
    cells = [Cell(Fraction(a), Fraction(b), False, ranges) for a, b in pairwise(points)]
    return [*cells, Cell(ZERO, 1 / Fraction(points[-1]), True, ranges)] if hi == inf else cells
