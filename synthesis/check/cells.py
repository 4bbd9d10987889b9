"""Cells of ω and of parameters: what polynomials, the hold and a table are on them, and the search by halving."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from functools import lru_cache
from math import factorial, inf
from typing import Any

from .forms import BITS, Axis, Form, UnresolvedError
from .outcome import UNDECIDED, CheckError, tick
from .polynomials import Poly, X
from .positivity import Inequality

Ranges = dict[tuple[str, Any], tuple[Fraction, Fraction]]  # the parameters that vary
Taylor = tuple[int, int, int, int]  # 2^-BITS (c0 + c1 t + c2 t² ± r)
CELLS, DEPTH, PARAMETERS = 40_000, 60, ("impedance", "actuator", "edge")


class Cell:
    """χ in [lo, hi], χ = x = ω², or 1/x if far; ζ = −χ/2^b. Every parameter in its range is one symbol."""

    def __init__(self, lo: Fraction, hi: Fraction, far: bool, ranges: Ranges, depth: int = 0) -> None:
        self.lo, self.hi, self.far, self.ranges, self.depth, self.ends = lo, hi, far, ranges, depth, lo == 0
        self.b = hi.numerator.bit_length() - hi.denominator.bit_length() if hi else 0
        self.cache: dict[Any, Any] = {}
        middle, half = (lo + hi) / 2 / Fraction(2) ** self.b, (hi - lo) / 2 / Fraction(2) ** self.b
        self.taylor: dict[int, Taylor] = {0: (1 << BITS, 0, 0, 0), 1: (-_fixed(middle), -_fixed(half), 0, 2)}
        if lo:  # 1/(c + d t) = 1/c − d t/c² + d² t²/c³ ∓ |d|³/(c³(c − d))
            i, ratio = 1 / middle, half / middle
            rest = _fixed(i * ratio**3 / (1 - ratio)) + 20
            self.taylor[-1] = -_fixed(i), _fixed(i * ratio), -_fixed(i * ratio**2), rest

    def key(self) -> tuple[Any, ...]:
        """Equal for cells on which everything is equal."""
        return self.lo, self.hi, self.far, tuple(self.ranges.items())

    def split(self, forms: Iterable[Form], names: Sequence[str]) -> list[Cell]:
        """Two halves, the one at smaller ω first, along the symbol that these forms depend on most."""
        tick_depth = self.depth + 1
        if tick_depth > DEPTH or (self.lo == self.hi and all(lo == hi for lo, hi in self.ranges.values())):
            raise CheckError(UNDECIDED, f"neither proven nor refuted{self}")
        live = [f for f in forms if not f.zero()]
        low = min(f.e for f in live)
        score = [sum(abs(f.l[i]) << min(f.e - low, 4 * BITS) for f in live) for i in range(len(self.ranges) + 1)]
        fixed = {0} if self.lo == self.hi else set()
        keys = list(self.ranges)
        fixed |= {i for i, (name, _) in enumerate(keys, 1) if name not in names}
        free = [i for i in range(len(score)) if i not in fixed]
        if not free:
            raise CheckError(UNDECIDED, f"neither proven nor refuted{self}")
        best = max(free, key=lambda i: score[i])
        if best:
            lo, hi = self.ranges[keys[best - 1]]
            halves = ((lo, (lo + hi) / 2), ((lo + hi) / 2, hi))
            return [
                Cell(self.lo, self.hi, self.far, {**self.ranges, keys[best - 1]: half}, tick_depth) for half in halves
            ]
        middle = (self.lo + self.hi) / (2 if self.lo else 4)
        if self.far:
            return [
                Cell(1 / self.hi, 1 / middle, False, self.ranges, tick_depth),
                Cell(self.lo, middle, True, self.ranges, tick_depth),
            ]
        ends = ((self.lo, middle), (middle, self.hi))
        return [Cell(lo, hi, False, self.ranges, tick_depth) for lo, hi in ends]

    def __str__(self) -> str:
        x = self.hi if self.lo else self.lo
        if self.far:
            return " at ω = inf"
        return f" at ω = {float(x) ** 0.5:.6g} rad/s"

    def form(self, c: Fraction | int, l: int = -1, value: Fraction | int = 0, r: Fraction | int = 0) -> Form:  # noqa: E741
        """`c + value t_l ± r` from rationals."""
        top = max(abs(c), abs(value), r)
        e = (Fraction(top).numerator.bit_length() - Fraction(top).denominator.bit_length()) - BITS if top else 0
        scale = Fraction(2) ** -e
        values = [0] * (len(self.ranges) + 1)
        if value:
            values[l] = int(value * scale)
        return Form(self, 0, e, int(c * scale), values, int(r * scale) + 3 if top else 0)

    def symbol(self, key: tuple[str, Any]) -> Axis:
        """A parameter, anywhere in its range."""
        lo, hi = self.ranges[key]
        return Axis(self.form((lo + hi) / 2, list(self.ranges).index(key) + 1, (hi - lo) / 2), self.form(0))

    def power(self, k: int) -> Form:
        """ζ^k."""
        return self._sum([(k, 1, -k * self.b)], at=0)

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

    def real(self, value: Any) -> Form:
        """A polynomial in x on this cell; what is on it already stays."""
        if isinstance(value, Form):
            return value
        if (value,) not in self.cache:
            terms = [(-k if self.far else k, -a if k % 2 else a, e) for k, a, e in _mantissas(value)]
            self.cache[(value,)] = self._sum(terms)
        return self.cache[(value,)]  # type: ignore[no-any-return]

    def _power(self, k: int) -> Taylor:
        if k and not self.hi:
            return 0, 0, 0, 0
        if k not in self.taylor:
            step = 1 if k > 0 else -1
            a0, a1, a2, ra = self._power(k - step)
            b0, b1, b2, rb = self.taylor[step]
            a, b = abs(a0) + abs(a1) + abs(a2), abs(b0) + abs(b1) + abs(b2)
            r = abs(a1 * b2) + abs(a2 * b1) + abs(a2 * b2) + a * rb + b * ra + ra * rb
            c = a0 * b0, a0 * b1 + a1 * b0, a0 * b2 + a1 * b1 + a2 * b0
            self.taylor[k] = c[0] >> BITS, c[1] >> BITS, c[2] >> BITS, (r >> BITS) + 4
        return self.taylor[k]

    def _sum(self, terms: list[tuple[int, int, int]], at: int | None = None) -> Form:
        """`Σ a 2^e z^k`, z = −χ = 2^b ζ, of terms (k, a, e): the second order in t is summed before it is bounded."""
        if not terms:
            return self.form(0)
        sized = [(a.bit_length() + e + k * self.b, k, a, e + k * self.b) for k, a, e in terms]
        top, m = max(sized)[:2]
        if self.ends:
            m = min(k for _, k, _, _ in sized)
        m = m if at is None else at
        low, c0, c1, c2, r = top - BITS - 8, 0, 0, 0, 0
        for _, k, a, e in sized:
            a = a << e - low if e > low else a >> low - e
            z0, z1, z2, zr = self._power(k - m)
            c0, c1, c2 = c0 + a * z0, c1 + a * z1, c2 + a * z2
            r += abs(a) * zr + 2 * (abs(z0) + abs(z1) + abs(z2) + zr)
        values = [2 * c1] + [0] * len(self.ranges)
        return Form(self, m, low - BITS - 1, 2 * c0 + c2, values, 2 * r + abs(c2))

    def omega(self) -> Form:
        """ω."""
        return self.real(X).at(0).root() if not self.far else self.real(X).at(-1)

    def hold(self, rate: Fraction, delay: Fraction) -> Axis:
        """`e^{-sd}(1 − e^{-sT})/(sT)` = sin(ωT/2)/(ωT/2) e^{-sa}, a = d + T/2; when far, only |…| ≤ 2/(ωT) is used."""
        T = 1 / rate
        if self.far:  # w/(sT), |w| ≤ 2: p = Im(w)/(ωT), q = Re(w)/T
            return Axis(self.form(0, r=self.hi).root() * self.form(0, r=2 / T), self.form(0, r=2 / T))
        sinc = self._trig(T / 2)[1] * Poly.of(2 / T)
        c, s = self._trig(delay + T / 2)
        return Axis(sinc * c, -(sinc * s))

    def _trig(self, a: Fraction) -> tuple[Form, Form]:
        """cos(aω) and sin(aω)/ω."""
        square = a * a * self.hi
        if self.ends or square < 16:  # at any θ the series' error is below its first omitted term
            c, s = (self.real(Poly.of(*(a**n * (-a * a) ** k / factorial(2 * k + n) for k in range(12)))) for n in (0, 1))
            rest = square**12 / factorial(24)
            return c + self.form(0, r=rest), s + self.form(0, r=a * rest)
        ω = self.omega()
        θ = ω * Poly.of(a)
        n = len(θ.l)
        D = sum(map(abs, θ.l)) + θ.r
        if θ.size() > 200 or D.bit_length() + θ.e > 1:
            ball = Form(self, 0, 0, 0, [0] * n, 1)
            return ball, ball * ω.inverse()
        cos, sin = (Form(self, 0, -BITS, v, [0] * n, 2) for v in unit(θ.c, θ.e))
        d = Form(self, 0, θ.e, 0, θ.l, θ.r)
        rest = Form(self, 0, 2 * θ.e - 1, 0, [0] * n, D * D)  # |cos θ − cos c + d sin c| ≤ d²/2, and so for sin
        return cos - sin * d + rest, (sin + cos * d + rest) * ω.inverse()


def _fixed(value: Fraction) -> int:
    return (value.numerator << BITS) // value.denominator


@lru_cache(maxsize=4096)
def _mantissas(p: Poly) -> list[tuple[int, int, int]]:
    """Nonzero coefficients as `(k, a, e)`: a 2^e to within 2^e, a of BITS + 8 bits."""
    found = []
    for k, a in enumerate(p.c):
        e = a.bit_length() - p.d.bit_length() - BITS - 8
        if a:
            found.append((k, (a << max(-e, 0)) // (p.d << max(e, 0)), e))
    return found


def unit(c: int, e: int) -> tuple[int, int]:
    """cos and sin of c 2^e to within 2^-BITS: a series at the angle over 2^k, then k squarings."""
    k = max(c.bit_length() + e + 4, 0)
    w = BITS + 64 + 2 * k
    shift = e + w - k
    angle = c << shift if shift > 0 else c >> -shift
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
        return [Cell(Fraction(0), Fraction(0), True, ranges) if lo == inf else Cell(lo, lo, False, ranges)]
    inner = {Fraction(4) ** k for k in range(-6, 15)} | {Fraction(b) ** 2 for b in breaks}
    points = [lo, *sorted(x for x in inner if lo < x < hi), hi]
    finite = [Cell(a, b, False, ranges) for a, b in zip(points, points[1:], strict=False) if b != inf]
    return [*finite, Cell(Fraction(0), 1 / (points[-2] or Fraction(1)), True, ranges)] if hi == inf else finite


def compare(cell: Cell, part: Inequality) -> tuple[int, list[Form]]:
    """Whether `Σ √terms < √bound` on the cell: 1, −1 at a corner of it, 0 not known; and the forms that decide."""
    forms = [cell.real(value) for value in (*part.terms, part.bound)]
    live = [f for f in forms if not f.zero()]
    if not live:
        return -1 if part.strict else 1, forms
    over = cell.real(part.over)
    if cell.ends and part.strict and not over.zero() and forms[-1].m > over.m:  # zero in the limit
        return -1 if 1 in (over.sign(), (-over).sign()) else 0, [over]
    m = min(f.m for f in live) if cell.ends else max(live, key=Form.size).m
    *terms, bound = (Form(cell, 0, f.e, f.c, f.l, f.r) for f in (-f.at(m) if m % 2 else f.at(m) for f in forms))
    terms = [f for f in terms if not f.zero()]
    if len(terms) > 1:
        bound, terms = bound.root(), [f.root() for f in terms]
    for f in terms:
        bound = bound - f
    return bound.sign(part.strict), live


def bounded(z: Axis) -> bool:
    """Whether z stays finite at the end of its cell."""
    return all(f.zero() or f.m >= 0 for f in (z.p, z.q))


def nonzero(z: Axis) -> bool:
    """Whether 0 is shown not to be among the values: some linear functional of (p, q) has one sign."""
    p, cell = z.p, z.p.cell
    if cell.ends:  # at χ = 0 it is p
        return p.m <= 0 and abs(p.c) > sum(map(abs, p.l)) + p.r
    both = p + z.q if not p.zero() and not z.q.zero() else p
    p, q = p.at(both.m), z.q.at(both.m)
    shift = max(p.e - q.e, 0), max(q.e - p.e, 0)
    P, Q = [v << shift[0] for v in (p.c, *p.l, p.r)], [v << shift[1] for v in (q.c, *q.l, q.r)]
    up, down = max(cell.b, 0), max(-cell.b, 0)
    for a, b in [(P[0] << down, Q[0] << up), *((w, -u) for u, w in zip(P[1:-1], Q[1:-1], strict=True))]:
        radius = sum(abs(a * u + b * w) for u, w in zip(P[1:-1], Q[1:-1], strict=True)) + abs(a) * P[-1] + abs(b) * Q[-1]
        if abs(a * P[0] + b * Q[0]) > radius:
            return True
    return False


def cover(
    cells: list[Cell], parts: Callable[[Cell], Iterator[Any]], deadline: float, halved: Sequence[str] = PARAMETERS
) -> str:
    """Text of a place where a part fails; empty if all are proven on all cells; or CheckError. In the order of ω."""
    stack = cells[::-1]
    for _ in range(CELLS):
        if not stack:
            return ""
        tick(deadline)
        cell = stack.pop()
        open_: list[Form] = []
        try:
            for part in parts(cell):
                if isinstance(part, str):
                    return f": {part}"
                if isinstance(part, Axis):
                    if not nonzero(part):
                        open_ = open_ or [part.p, part.q]
                    continue
                said, forms = compare(cell, part)
                if said < 0:
                    return str(cell)
                if said == 0:
                    open_ = open_ or forms
        except UnresolvedError as stop:
            open_ = list(stop.forms)
        if open_:
            stack += cell.split(open_, halved)[::-1]
    raise CheckError(UNDECIDED, "neither proven nor refuted")
