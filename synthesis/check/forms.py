"""Affine forms with integers: real and complex quantities on a cell, whatever is not linear in a rounded-up bound."""

from __future__ import annotations

from math import isqrt
from operator import mul
from typing import TYPE_CHECKING, Any

from .outcome import UNDECIDED, CheckError
from .polynomials import Ring

if TYPE_CHECKING:
    from .cells import Cell

BITS = 64  # of a form's numbers


class UnresolvedError(CheckError):
    """A form whose sign had to be known, and is not on so large a cell."""

    def __init__(self) -> None:
        super().__init__(UNDECIDED, "neither proven nor refuted")


class Form(Ring):
    """`ζ^m 2^e (c + Σ l[i] t_i ± r)` for all |t_i| ≤ 1: t_0 moves along the axis, others are parameters; w = Σ|l|."""

    __slots__ = ("c", "cell", "e", "l", "m", "r", "w")

    def __init__(self, cell: Cell, m: int, e: int, c: int, l: list[int], r: int) -> None:  # noqa: E741
        w = sum(map(abs, l))
        excess = (abs(c) + w + r).bit_length() - BITS
        if excess > 0:  # floors: each coefficient and the bound lose less than one
            c, l, r, e = c >> excess, [v >> excess for v in l], (r >> excess) + len(l) + 2, e + excess  # noqa: E741
            w = sum(map(abs, l))
        self.cell, self.m, self.e, self.c, self.l, self.r, self.w = cell, m, e, c, l, r, w

    def __bool__(self) -> bool:
        return bool(self.c or self.r or self.w)

    def size(self) -> int:
        """Bits of the largest value, about."""
        return self.e + (abs(self.c) + self.w + self.r).bit_length()

    def at(self, m: int) -> Form:
        """The same value with another power of ζ in front; on a cell that has an end at ζ = 0 only with a lower one."""
        same = self * self.cell.power(self.m - m) if self.m != m and self else self
        return Form(self.cell, m, same.e, same.c, same.l, same.r)

    def up(self) -> Form:
        """Times τ² = −χ = 2^b ζ."""
        return Form(self.cell, self.m + 1, self.e + self.cell.b, self.c, self.l, self.r)

    def __add__(self, other: Any) -> Form:
        a, b = self, self.cell.real(other)
        if a and b and a.m != b.m:
            m = a.m if (a.m < b.m if self.cell.ends else a.size() > b.size()) else b.m
            a, b = a.at(m), b.at(m)
        if not (a and b):
            return a or b
        if a.e < b.e:
            a, b = b, a
        up = min(a.e - b.e, BITS)
        down = a.e - b.e - up
        values = [(u << up) + (w >> down) for u, w in zip(a.l, b.l, strict=True)]
        r = (a.r << up) + (b.r >> down) + (len(values) + 2 if down else 0)
        return Form(self.cell, a.m, a.e - up, (a.c << up) + (b.c >> down), values, r)

    def __neg__(self) -> Form:
        return Form(self.cell, self.m, self.e, -self.c, [-v for v in self.l], self.r)

    def __mul__(self, other: Any) -> Form:  # everything doubled, with t_i² in [0, 1] and t_i t_k in [−1, 1]
        a, b = self, self.cell.real(other)
        squares, p, q = list(map(mul, a.l, b.l)), 2 * a.c, 2 * b.c
        r = 2 * (a.w * b.w + (abs(a.c) + a.w) * b.r + (abs(b.c) + b.w) * a.r + a.r * b.r) - sum(map(abs, squares))
        values = [p * y + q * x for x, y in zip(a.l, b.l, strict=True)]
        return Form(self.cell, a.m + b.m, a.e + b.e - 1, p * b.c + sum(squares), values, r)

    def inverse(self) -> Form:
        """1/f: with d = f − c, |d| ≤ D < c, it is 1/c − d/c² + R, 0 ≤ R ≤ D²/(c²(c − D))."""
        if self.c < 0:
            return -(-self).inverse()
        c, D = self.c, self.w + self.r
        if c <= D:
            raise UnresolvedError
        k = c.bit_length() + BITS
        one, rest = (1 << k) // c, (D * D << k) // (c * c * (c - D)) + 1
        r = (rest >> 1) + 2 * len(self.l) + 4 + (self.r << k) // (c * c)
        return Form(self.cell, -self.m, -k - self.e, one + (rest >> 1), [-(v * one // c) for v in self.l], r)

    def root(self) -> Form:
        """√f of a form without power of ζ that means something ≥ 0: √c + d/(2√c) − R, R = (√(c + d) − √c)²/(2√c).

        Where d may reach −c it is anything from 0 to the root of the upper bound."""
        D = self.w + self.r
        n = max(2 * BITS + 8 - (abs(self.c) + D).bit_length(), 0)
        n += (self.e - n) % 2
        c, D, e = self.c << n, D << n, (self.e - n) // 2
        top = isqrt(max(c + D, 0)) + 1
        if c <= D:
            return Form(self.cell, 0, e, top >> 1, [0] * len(self.l), (top >> 1) + 1)
        root = isqrt(c)
        w = max(top - root, root + 1 - isqrt(c - D))
        rest = w * w // (2 * root) + 1
        values = [(v << n) // (2 * root) for v in self.l]
        r = (rest >> 1) + len(values) + 4 + (self.r << n) // (2 * root) + D // (2 * root * root)
        return Form(self.cell, 0, e, root - (rest >> 1), values, r)

    def sign(self, strict: bool = True) -> int:
        """1: > 0 (≥ 0 if not strict) everywhere; −1: not so somewhere, at a corner of the cell; 0: neither is shown."""
        least = (-self.c if self.m % 2 else self.c) - self.w  # ζ < 0
        return 1 if least - self.r > -(not strict) else -(least + self.r < strict)


class Axis(Ring):
    """`p + τ q` on s = jω, p and q real forms: τ = s, or 1/s on a cell that ends at infinity."""

    __slots__ = ("p", "q")

    def __init__(self, p: Form, q: Form) -> None:
        self.p, self.q = p, q

    def __add__(self, other: Any) -> Axis:
        other = self.p.cell.axis(other)
        return Axis(self.p + other.p, self.q + other.q)

    def __neg__(self) -> Axis:
        return Axis(-self.p, -self.q)

    def __mul__(self, other: Any) -> Axis:
        other = self.p.cell.axis(other)
        return Axis(self.p * other.p + (self.q * other.q).up(), self.p * other.q + self.q * other.p)

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

    def bounded(self) -> bool:
        """Whether it stays finite at the end of its cell."""
        return all(f.m >= 0 or not f for f in (self.p, self.q))

    def nonzero(self) -> bool:
        """Whether 0 is shown not to be among the values: some linear functional of (p, q) has one sign."""
        p, q, cell = self.p, self.q, self.p.cell
        if cell.ends:  # at χ = 0 it is p
            return p.m == 0 and abs(p.c) > p.w + p.r
        q = q.at(p.m)
        e = min(p.e, q.e)
        P, Q = ([v << f.e - e for v in (f.c, *f.l, f.r)] for f in (p, q))
        up, down = max(cell.b, 0), max(-cell.b, 0)
        for a, b in [(P[0] << down, Q[0] << up), *((w, -u) for u, w in zip(P[1:-1], Q[1:-1], strict=True))]:
            values = [a * u + b * w for u, w in zip(P[:-1], Q[:-1], strict=True)]
            if abs(values[0]) > sum(map(abs, values[1:])) + abs(a) * P[-1] + abs(b) * Q[-1]:
                return True
        return False
