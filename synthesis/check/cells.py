"""Cells of ω: what polynomials, symbols and the hold are on them."""

from __future__ import annotations

from collections.abc import Iterable
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache, reduce
from itertools import pairwise
from math import factorial, inf
from operator import add, mul
from typing import Any

from .forms import BITS, Axis, Form
from .polynomials import ONE, Family, Poly, X

Ranges = dict[tuple[str, Any], tuple[Fraction, Fraction]]  # parameters that vary
Point = dict[tuple[str, Any], Any]  # parameters at values: rational, or symbols of a cell
Taylor = tuple[int, int, int, int]  # 2^-BITS (c0 + c1 t + c2 t² ± r)
ZERO = Fraction(0)


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
            rest = _fixed(d**3 / (c**3 * (c - d))) + 20
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
        values[k] = _fixed(value, -e) if value else 0
        return Form(self, 0, e, _fixed(c, -e), values, 0, _fixed(r, -e) + 3 if top else 0)

    def symbol(self, key: tuple[str, Any]) -> Axis:
        """A parameter, anywhere in its range."""
        if key not in self.cache:
            lo, hi = self.ranges[key]
            self.cache[key] = Axis(self.form((lo + hi) / 2, [*self.ranges].index(key) + 1, (hi - lo) / 2), self.form())
        return self.cache[key]  # type: ignore[no-any-return]

    def power(self, k: int) -> Form:
        """ζ^k."""
        return self._sum([(k, 1, -k * self.b)], 0)

    def axis(self, value: Any) -> Axis:
        """A polynomial in s on this cell, or a family of them; what is on it already stays."""
        if isinstance(value, Axis):
            return value
        if value not in self.cache:
            if isinstance(value, Family):
                products = (reduce(mul, map(self.symbol, keys), self.axis(p)) for keys, p in value.terms)
                self.cache[value] = reduce(add, products, self.axis(Poly(())))
            else:
                terms: tuple[list[tuple[int, int, int]], ...] = ([], [])
                for k, a, e in _mantissas(value):
                    terms[k % 2].append((-((k + 1) // 2) if self.far else k // 2, a, e))
                self.cache[value] = Axis(*map(self._sum, terms))
        return self.cache[value]  # type: ignore[no-any-return]

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
        for _, k, a, e in sized:  # a is off by less than one, and by less than one more after the floor
            a = a << e - low if e > low else a >> low - e
            z0, z1, z2, zr = self._power(k - m)
            c0, c1, c2 = c0 + a * z0, c1 + a * z1, c2 + a * z2
            r += abs(a) * zr + 2 * (abs(z0) + abs(z1) + abs(z2) + zr)
        return Form(self, m, low - BITS, c0, [c1] + [0] * len(self.ranges), c2, r)

    def omega(self) -> Form:
        """ω, on a cell that is not far."""
        return self.real(X).at(0).root()

    def hold(self, rate: Fraction, delay: Fraction) -> Axis:
        """`e^{-sd}(1 − e^{-sT})/(sT)` = sin(ωT/2)/(ωT/2) e^{-sa}, a = d + T/2; when far, only |…| ≤ 2/(ωT) is used."""
        if self.far:  # w/(sT), |w| ≤ 2: p = Im(w)/(ωT), q = Re(w)/T
            return Axis(self.form(r=self.hi).root() * self.form(r=2 * rate), self.form(r=2 * rate))
        (cos, sin), (_, half) = self._trig(delay + 1 / rate / 2), self._trig(1 / rate / 2)
        return Axis(half * cos, -(half * sin)) * Poly.of(2 * rate)

    def _trig(self, a: Fraction) -> tuple[Form, Form]:
        """cos(aω) and sin(aω)/ω."""
        square = a * a * self.hi
        if self.ends or square < 16:  # at any θ the series' error is below its first omitted term
            tail = square**12 / factorial(24)
            cos, sin = map(self.real, _series(a))
            return cos + self.form(r=tail), sin + self.form(r=a * tail)
        θ, over = self.omega() * Poly.of(a), self.omega().inverse()
        D, none = θ.w + θ.r, [0] * len(θ.l)
        if θ.size() > 200 or D.bit_length() + θ.e > 1:
            return self.form(r=1), self.form(r=1) * over
        cos, sin = (Form(self, 0, -BITS, v, none, 0, 2) for v in unit(θ.c, θ.e))
        δ, rest = Form(self, 0, θ.e, 0, θ.l, θ.q, θ.r), Form(self, 0, 3 * θ.e, 0, none, 0, D**3 // 3 + 1)
        bent = ONE - δ * δ * Poly.of(Fraction(1, 2))  # and sin δ = δ, |δ| < 2: errors |δ|⁴/24, |δ|³/6
        return cos * bent - sin * δ + rest, (sin * bent + cos * δ + rest) * over


def _fixed(value: Fraction | int, bits: int = BITS) -> int:
    return (value.numerator << max(bits, 0)) // (value.denominator << max(-bits, 0))


@lru_cache(maxsize=16)
def _series(a: Fraction) -> list[Poly]:
    rows = ([a**n * (-a * a) ** k / factorial(2 * k + n) for k in range(12)] for n in (0, 1))
    return [Poly.of(*row) for row in rows]


@lru_cache(maxsize=4096)
def _mantissas(p: Poly) -> list[tuple[int, int, int]]:
    """Nonzero coefficients as `(k, a, e)`: a 2^e to within 2^e, a of BITS + 8 bits."""
    sized = [(k, a, a.bit_length() - p.d.bit_length() - BITS - 8) for k, a in enumerate(p.c) if a]
    return [(k, (a << max(-e, 0)) // (p.d << max(e, 0)), e) for k, a, e in sized]


def unit(c: int, e: int) -> tuple[int, int]:
    """cos and sin of c 2^e > 0 to within 2^-BITS: a series at the angle over 2^k, then k squarings."""
    k = max(c.bit_length() + e + 4, 0)
    w = BITS + 64 + 2 * k
    angle = c << e + w - k if e + w > k else c >> k - e - w
    parts, term, n = [0, 0], 1 << w, 0
    while term:
        parts[n % 2] += -term if n % 4 > 1 else term
        n += 1
        term = (term * angle >> w) // n
    x, y = parts
    for _ in range(k):
        x, y = (x * x - y * y) >> w, x * y >> w - 1
    return x >> w - BITS, y >> w - BITS


def roots(interval: tuple[Fraction, Any], breaks: Iterable[Fraction], ranges: Ranges) -> list[Cell]:
    """Cells that cover the interval of ω: powers of 4 in x = ω², and breaks in ω."""
    lo, hi = (inf if end == inf else Fraction(end) ** 2 for end in interval)
    if lo == hi:
        return [Cell(ZERO, ZERO, True, ranges) if lo == inf else Cell(Fraction(lo), Fraction(lo), False, ranges)]
    inner = {Fraction(4) ** k for k in range(-6, 15)} | {b**2 for b in breaks} | {lo * 2}
    points = [lo, *sorted(x for x in inner if lo < x < hi), *[hi] * (hi != inf)]
    cells = [Cell(Fraction(a), Fraction(b), False, ranges) for a, b in pairwise(points)]
    return [*cells, Cell(ZERO, 1 / Fraction(points[-1]), True, ranges)] if hi == inf else cells
