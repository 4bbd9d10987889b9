"""Real polynomials with integer coefficients over one common denominator, and their values on s = jω."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm

from .outcome import UndecidedError

WORK_LIMIT = 10**12  # bit products in one step that the clock cannot interrupt: about a second
PRIME = 2**61 - 1


@dataclass(frozen=True, slots=True)
class Poly:
    """`Σ c[k] z^k / d` in lowest terms: c ascending without zeros at the top, d > 0."""

    c: tuple[int, ...]
    d: int = 1

    @staticmethod
    def of(*ascending: Fraction | int) -> Poly:
        """Polynomial from rational coefficients, constant first."""
        d = lcm(*(Fraction(a).denominator for a in ascending))
        return _lowest([int(a * d) for a in ascending], d)

    @property
    def degree(self) -> int:
        """Degree; −1 for the zero polynomial."""
        return len(self.c) - 1

    def __add__(self, other: Poly) -> Poly:
        d = lcm(self.d, other.d)
        long, short = (self, other) if len(self.c) >= len(other.c) else (other, self)
        c = [a * (d // long.d) for a in long.c]
        for k, a in enumerate(short.c):
            c[k] += a * (d // short.d)
        return _lowest(c, d)

    def __neg__(self) -> Poly:
        return Poly(tuple(-a for a in self.c), self.d)

    def __sub__(self, other: Poly) -> Poly:
        return self + -other

    def __mul__(self, other: Poly) -> Poly:
        return _lowest(product(self.c, other.c), self.d * other.d)


ZERO, ONE, X = Poly(()), Poly((1,)), Poly((0, 1))


def _lowest(c: list[int], d: int) -> Poly:
    while c and c[-1] == 0:
        c.pop()
    g = gcd(d, *c)
    return Poly(tuple(a // g for a in c), d // g) if g > 1 else Poly(tuple(c), d)


def product(a: Sequence[int], b: Sequence[int]) -> list[int]:
    """Coefficients of the product; refuses work that the clock could not interrupt."""
    if not a or not b:
        return []
    if len(a) * len(b) * size(a) * size(b) > WORK_LIMIT:
        raise UndecidedError("the polynomials are too large")
    out = [0] * (len(a) + len(b) - 1)
    for i, p in enumerate(a):
        if p:
            for j, q in enumerate(b, i):
                out[j] += p * q
    return out


def size(a: Iterable[int]) -> int:
    """Bits of the largest coefficient."""
    return max((p.bit_length() for p in a), default=0)


@dataclass(frozen=True, slots=True)
class OnAxis:
    """`p(jω) = re(x) + jω·im(x)` with x = ω²."""

    re: Poly
    im: Poly

    @staticmethod
    def of(p: Poly) -> OnAxis:
        """Split p(s) at s = jω into its real part and its imaginary part over ω."""
        signed = [a if k % 4 < 2 else -a for k, a in enumerate(p.c)]
        return OnAxis(_lowest(signed[0::2], p.d), _lowest(signed[1::2], p.d))

    def dot(self, other: OnAxis) -> Poly:
        """`Re[p(jω) conj q(jω)]`, a polynomial in x."""
        return self.re * other.re + X * (self.im * other.im)

    def cross(self, other: OnAxis) -> Poly:
        """`Im[p(jω) conj q(jω)]/ω = Re[p conj q / (jω)]`, a polynomial in x."""
        return self.im * other.re - self.re * other.im

    def norm2(self) -> Poly:
        """`|p(jω)|²`, a polynomial in x."""
        return self.dot(self)


def norm2(p: Poly) -> Poly:
    """`|p(jω)|²` as a polynomial in x = ω²."""
    return OnAxis.of(p).norm2()


def mobius(p: Sequence[int], a: int, b: int, c: int, d: int) -> list[int]:
    """Coefficients in z of `(b + d z)^n p((a + c z)/(b + d z))`, n = len(p) − 1 (a formal degree)."""
    step = size((a, b, c, d))
    if len(p) ** 2 * (size(p) + len(p) * step) * step > WORK_LIMIT:
        raise UndecidedError("the polynomials are too large")
    out, weight = [p[-1]], [1]
    for coefficient in reversed(p[:-1]):
        weight = _times_linear(weight, b, d)
        out = [u + coefficient * w for u, w in zip(_times_linear(out, a, c), weight, strict=True)]
    return out


def _times_linear(p: list[int], a: int, c: int) -> list[int]:
    return [a * u + c * w for u, w in zip([*p, 0], [0, *p], strict=True)]


def primitive(p: Sequence[int]) -> list[int]:
    """p over the gcd of its coefficients, zeros at the top removed; the sign stays."""
    top = len(p)
    while top and p[top - 1] == 0:
        top -= 1
    g = gcd(*p)
    return [a // g for a in p[:top]]


def derivative(p: Sequence[int]) -> list[int]:
    """Coefficients of p'."""
    return [k * a for k, a in enumerate(p)][1:]


def common_divisor(p: Sequence[int], q: Sequence[int]) -> list[int]:
    """Greatest common divisor over the rationals, primitive: [±1] when p and q are coprime."""
    if p and q and p[-1] % PRIME and q[-1] % PRIME and _coprime_modulo(p, q):
        return [1]
    a, b = primitive(p), primitive(q)
    while b:
        if size(a) * size(b) * len(a) * len(b) > WORK_LIMIT:
            raise UndecidedError("a common divisor is too large")
        while len(a) >= len(b):
            shift, lead, pivot = len(a) - len(b), a[-1], b[-1]
            a = primitive([pivot * u - (lead * b[k - shift] if k >= shift else 0) for k, u in enumerate(a)])
        a, b = b, a
    return a


def _coprime_modulo(p: Sequence[int], q: Sequence[int]) -> bool:
    """Whether the gcd is constant modulo a prime that divides neither leading coefficient: then it is constant."""
    a, b = [u % PRIME for u in p], [u % PRIME for u in q]
    while len(b) > 1:
        inverse = pow(b[-1], -1, PRIME)
        while len(a) >= len(b):
            factor, shift = a[-1] * inverse % PRIME, len(a) - len(b)
            a = [(u - factor * b[k - shift]) % PRIME if k >= shift else u for k, u in enumerate(a)][:-1]
            while a and a[-1] == 0:
                a.pop()
        a, b = b, a
    return bool(b)


def quotient(p: Sequence[int], q: Sequence[int]) -> list[int]:
    """Exact quotient p/q of primitive polynomials."""
    rest, out = list(p), [0] * (len(p) - len(q) + 1)
    for k in reversed(range(len(out))):
        out[k] = rest[k + len(q) - 1] // q[-1]
        for j, b in enumerate(q):
            rest[k + j] -= out[k] * b
    return out
