"""Affine forms with integers: real and complex quantities on a cell, whatever is not linear in a rounded-up bound."""

from __future__ import annotations

from math import isqrt
from operator import mul
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .cells import Cell

BITS = 64  # of a form's numbers


class UnresolvedError(Exception):
    """A form whose sign had to be known, and is not on so large a cell."""

    def __init__(self, *forms: Form) -> None:
        self.forms = forms


class Form:
    """`ζ^m 2^e (c + Σ l[i] t_i ± r)` for all |t_i| ≤ 1: t_0 moves along the cell's axis, the others are parameters."""

    __slots__ = ("c", "cell", "e", "l", "m", "r")

    def __init__(self, cell: Cell, m: int, e: int, c: int, l: list[int], r: int) -> None:  # noqa: E741
        excess = (abs(c) + r + max(map(abs, l))).bit_length() - BITS
        if excess > 0:  # floors: each coefficient and the bound lose less than one
            c, l, r, e = c >> excess, [v >> excess for v in l], (r >> excess) + len(l) + 2, e + excess  # noqa: E741
        self.cell, self.m, self.e, self.c, self.l, self.r = cell, m, e, c, l, r

    def zero(self) -> bool:
        """Whether it is exactly zero."""
        return not (self.c or self.r or any(self.l))

    def size(self) -> int:
        """Bits of the largest value, about."""
        return self.e + (abs(self.c) + sum(map(abs, self.l)) + self.r).bit_length()

    def at(self, m: int) -> Form:
        """The same value with another power of ζ in front; on a cell that has an end at ζ = 0 only with a lower one."""
        if m == self.m or self.zero():
            return Form(self.cell, m, self.e, self.c, self.l, self.r)
        product = self * self.cell.power(self.m - m)
        product.m = m
        return product

    def up(self) -> Form:
        """Times τ² = −χ = 2^b ζ."""
        return Form(self.cell, self.m + 1, self.e + self.cell.b, self.c, self.l, self.r)

    def __add__(self, other: Any) -> Form:
        a, b = self, self.cell.real(other)
        if b.zero() or a.zero():
            return a if b.zero() else b
        if a.m != b.m:
            m = a.m if (a.m < b.m if self.cell.ends else a.size() > b.size()) else b.m
            a, b = a.at(m), b.at(m)
        if a.e < b.e:
            a, b = b, a
        up = min(a.e - b.e, BITS)
        down = a.e - b.e - up
        values = [(u << up) + (w >> down) for u, w in zip(a.l, b.l, strict=True)]
        r = (a.r << up) + (b.r >> down) + (len(values) + 2 if down else 0)
        return Form(self.cell, a.m, a.e - up, (a.c << up) + (b.c >> down), values, r)

    def __neg__(self) -> Form:
        return Form(self.cell, self.m, self.e, -self.c, [-v for v in self.l], self.r)

    def __sub__(self, other: Any) -> Form:
        return self + -other

    def __rsub__(self, other: Any) -> Form:
        return -self + other

    def __mul__(self, other: Any) -> Form:
        """With t_i² in [0, 1], t_i t_k in [−1, 1]; everything doubled."""
        a, b = self, self.cell.real(other)
        u, w, squares = sum(map(abs, a.l)), sum(map(abs, b.l)), list(map(mul, a.l, b.l))
        c, (p, q) = 2 * a.c * b.c + sum(squares), (2 * a.c, 2 * b.c)
        r = 2 * (u * w + (abs(a.c) + u) * b.r + (abs(b.c) + w) * a.r + a.r * b.r) - sum(map(abs, squares))
        values = [p * y + q * x for x, y in zip(a.l, b.l, strict=True)]
        return Form(self.cell, a.m + b.m, a.e + b.e - 1, c, values, r)

    __radd__, __rmul__ = __add__, __mul__

    def inverse(self) -> Form:
        """1/f: with d = f − c, |d| ≤ D < c, it is 1/c − d/c² + R, 0 ≤ R ≤ D²/(c²(c − D))."""
        if self.c < 0:
            return -(-self).inverse()
        c, D = self.c, sum(map(abs, self.l)) + self.r
        if D >= c:
            raise UnresolvedError(self)
        k = c.bit_length() + BITS
        one = (1 << k) // c
        rest = (D * D << k) // (c * c * (c - D)) + 1
        values = [-(v * one // c) for v in self.l]
        r = (rest >> 1) + 2 * len(values) + 4 + (self.r << k) // (c * c)
        return Form(self.cell, -self.m, -k - self.e, one + (rest >> 1), values, r)

    def root(self) -> Form:
        """√f of a form without power of ζ that means something ≥ 0.

        √(c + d) = √c + d/(2√c) − R with R = (√(c + d) − √c)²/(2√c) ≥ 0; or anything from 0 to its upper bound."""
        D = sum(map(abs, self.l)) + self.r
        n = max(2 * BITS + 8 - (abs(self.c) + D).bit_length(), 0)
        n += (self.e - n) % 2
        c, D, e = self.c << n, D << n, (self.e - n) // 2
        top = isqrt(max(c + D, 0)) + 1
        if D >= c:
            return Form(self.cell, 0, e, top >> 1, [0] * len(self.l), (top >> 1) + 1)
        root = isqrt(c)
        w = max(top - root, root + 1 - isqrt(c - D))
        rest = w * w // (2 * root) + 1
        values = [(v << n) // (2 * root) for v in self.l]
        r = (rest >> 1) + len(values) + 4 + (self.r << n) // (2 * root) + D // (2 * root * root)
        return Form(self.cell, 0, e, root - (rest >> 1), values, r)

    def sign(self, strict: bool = True) -> int:
        """1: > 0 (≥ 0 if not strict) everywhere; −1: not so somewhere, at a corner of the cell; 0: neither is shown."""
        least = (-self.c if self.m % 2 else self.c) - sum(map(abs, self.l))  # ζ < 0
        if least - self.r > -(not strict):
            return 1
        return -1 if least + self.r < strict else 0


class Axis:
    """`p + τ q` on s = jω, p and q real forms: τ = s, or 1/s on a cell that ends at infinity."""

    __slots__ = ("p", "q")

    def __init__(self, p: Form, q: Form) -> None:
        self.p, self.q = p, q

    def __add__(self, other: Any) -> Axis:
        other = self.p.cell.axis(other)
        return Axis(self.p + other.p, self.q + other.q)

    def __neg__(self) -> Axis:
        return Axis(-self.p, -self.q)

    def __sub__(self, other: Any) -> Axis:
        return self + -other

    def __rsub__(self, other: Any) -> Axis:
        return -self + other

    def __mul__(self, other: Any) -> Axis:
        other = self.p.cell.axis(other)
        return Axis(self.p * other.p + (self.q * other.q).up(), self.p * other.q + self.q * other.p)

    __radd__, __rmul__ = __add__, __mul__

    def conj(self) -> Axis:
        """Complex conjugate: τ is imaginary."""
        return Axis(self.p, -self.q)

    def parts(self) -> tuple[Form, Form]:
        """Re, and Im/ω: q, or −χ q because τ = −jω/ω² at infinity."""
        return self.p, self.q.up() if self.p.cell.far else self.q

    def inverse(self) -> Axis:
        """`1/z = conj z/|z|²`."""
        n = (self.p * self.p - (self.q * self.q).up()).inverse()
        return Axis(self.p * n, -(self.q * n))
