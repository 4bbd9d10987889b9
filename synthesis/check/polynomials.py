"""Real polynomials with integer coefficients: arithmetic, values on s = jω, common factors, Routh's test."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import zip_longest
from math import gcd, lcm
from typing import Any

from .outcome import UNDECIDED, demand, tick

Row = Sequence[int]  # integer coefficients, constant first; zeros at the top are a formal degree
WORK_LIMIT = 10**12  # bit products in one step that the clock cannot interrupt: about a second
PRIME = 2**61 - 1
TOO_LARGE = "the polynomials are too large", UNDECIDED


class Ring:
    """Differences, and a polynomial on the left of a quantity on a cell, from sum, product and negative."""

    __slots__ = ()

    def __sub__(self: Any, other: Any) -> Any:
        return self + -other

    def __radd__(self: Any, other: Any) -> Any:
        return self + other

    def __rmul__(self: Any, other: Any) -> Any:
        return self * other


@dataclass(frozen=True, slots=True)
class Poly(Ring):
    """`Σ c[k] z^k / d` in lowest terms: c ascending without zeros at the top, d > 0."""

    c: tuple[int, ...]
    d: int = 1

    @staticmethod
    @lru_cache(maxsize=4096)
    def of(*ascending: Fraction | int) -> Poly:
        """Polynomial from rational coefficients, constant first."""
        d = lcm(*(Fraction(a).denominator for a in ascending))
        return _lowest([int(a * d) for a in ascending], d)

    def __bool__(self) -> bool:
        return bool(self.c)

    def __add__(self, other: Any) -> Any:
        return _sum(self, other) if isinstance(other, Poly) else NotImplemented

    def __neg__(self) -> Poly:
        return Poly(tuple(-a for a in self.c), self.d)

    def __mul__(self, other: Any) -> Any:
        return _product(self, other) if isinstance(other, Poly) else NotImplemented

    def conj(self) -> Poly:
        """`conj p(jω) = p(−jω)`."""
        return Poly(tuple(-a if k % 2 else a for k, a in enumerate(self.c)), self.d)

    def norm2(self) -> Poly:
        """`|p(jω)|²`, a polynomial in x = ω²."""
        return (self * self.conj()).parts()[0]  # type: ignore[no-any-return]

    def parts(self) -> tuple[Poly, Poly]:
        """`Re p(jω)` and `Im p(jω)/ω`, polynomials in x = ω²."""
        signed = [a if k % 4 < 2 else -a for k, a in enumerate(self.c)]
        return _lowest(signed[0::2], self.d), _lowest(signed[1::2], self.d)


@lru_cache(maxsize=4096)  # every cell asks for the same sums and products
def _sum(p: Poly, q: Poly) -> Poly:
    d = lcm(p.d, q.d)
    return _lowest([a * (d // p.d) + b * (d // q.d) for a, b in zip_longest(p.c, q.c, fillvalue=0)], d)


@lru_cache(maxsize=4096)
def _product(p: Poly, q: Poly) -> Poly:
    return _lowest(product(p.c, q.c), p.d * q.d)


def _lowest(c: list[int], d: int) -> Poly:
    g = gcd(d, *c)
    return Poly(tuple(a // g for a in _trimmed(c)), d // g)


def _trimmed(c: list[int]) -> list[int]:
    while c and c[-1] == 0:
        c.pop()
    return c


ZERO, ONE, X = Poly(()), Poly((1,)), Poly((0, 1))


def on_axis(p: Any, q: Any) -> tuple[Any, Any]:
    """`Re[p(jω) conj q(jω)]` and `Im[…]/ω`: polynomials in x = ω², or forms on a cell."""
    return (p * q.conj()).parts()  # type: ignore[no-any-return]


def norm2(p: Any) -> Any:
    """`|p(jω)|²`: a polynomial in x = ω², or a form on a cell."""
    return p.norm2()


def limit(p: Poly, q: Poly, far: bool) -> Poly | None:
    """The limit of p/q at zero, or at infinity; None if it is not finite."""
    if not (p and q):
        return ZERO if q else None
    a, b = (t.c[::-1] if far else t.c for t in (p, q))
    k, n = (next(i for i, coefficient in enumerate(c) if coefficient) for c in (a, b))
    order = len(q.c) - len(p.c) if far else k - n
    return None if order < 0 else ZERO if order > 0 else Poly.of(Fraction(a[k] * q.d, b[n] * p.d))


def size(a: Iterable[int]) -> int:
    """Bits of the largest coefficient."""
    return max((p.bit_length() for p in a), default=0)


def product(a: Row, b: Row) -> list[int]:
    """Coefficients of the product."""
    demand(len(a) * len(b) * size(a) * size(b) <= WORK_LIMIT, *TOO_LARGE)
    out = [0] * (len(a) + len(b) - 1 if a and b else 0)
    for i, p in enumerate(a):
        for j, q in enumerate(b, i):
            out[j] += p * q
    return out


def mobius(p: Row, a: int, b: int, c: int, d: int) -> list[int]:
    """Coefficients in z of `(b + d z)^n p((a + c z)/(b + d z))`, n = len(p) − 1 (a formal degree)."""
    step = size((a, b, c, d))
    demand(len(p) ** 2 * (size(p) + len(p) * step) * step <= WORK_LIMIT, *TOO_LARGE)
    out, weight = [p[-1]], [1]
    for coefficient in reversed(p[:-1]):
        weight = [b * u + d * w for u, w in zip([*weight, 0], [0, *weight], strict=True)]
        out = [a * u + c * w + coefficient * v for u, w, v in zip([*out, 0], [0, *out], weight, strict=True)]
    return out


def primitive(p: Row, prime: int = 0) -> list[int]:
    """p over the gcd of its coefficients, zeros at the top removed, the sign stays; or p modulo a prime."""
    g = gcd(*p) or 1
    return _trimmed([a % prime if prime else a // g for a in p])


def common_divisor(p: Row, q: Row, deadline: float, prime: int = 0) -> list[int]:
    """Greatest common divisor over the rationals, primitive, or up to a factor modulo a prime: constant if coprime."""
    a, b = primitive(p, prime), primitive(q, prime)
    while b:
        tick(deadline)
        demand(len(a) * len(b) * size(a) * size(b) <= WORK_LIMIT, *TOO_LARGE)
        while len(a) >= len(b):
            aligned = [0] * (len(a) - len(b)) + b
            a = primitive([b[-1] * u - a[-1] * w for u, w in zip(a, aligned, strict=True)], prime)
        a, b = b, a
    return a


def quotient(p: Row, q: Row) -> list[int]:
    """Exact quotient p/q of primitive polynomials."""
    rest, out = list(p), [0] * (len(p) - len(q) + 1)
    for k in reversed(range(len(out))):
        out[k] = rest[k + len(q) - 1] // q[-1]
        for j, b in enumerate(q, k):
            rest[j] -= out[k] * b
    return out


def decays_faster(p: Poly, rate: Fraction, deadline: float) -> bool:
    """Whether every root of p has Re s < −rate [1/s]: p(s − rate) has a strictly positive first Routh column."""
    if not p:
        return False
    shifted = mobius(p.c, -rate.numerator, rate.denominator, rate.denominator, 0)[::-1]
    upper, lower = ([a if shifted[0] > 0 else -a for a in shifted[k::2]] for k in (0, 1))
    while lower:
        tick(deadline)
        if lower[0] <= 0:
            return False
        following = [lower[0] * u - upper[0] * w for u, w in zip_longest(upper[1:], lower[1:], fillvalue=0)]
        common = gcd(*following) or 1  # positive: signs stay, growth is held
        upper, lower = lower, [entry // common for entry in following]
    return True
