"""Affine forms with integers: real and complex quantities on a cell, whatever is not linear in a rounded-up bound."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import reduce
from math import isqrt, ldexp
from operator import add, itemgetter, mul
from typing import TYPE_CHECKING, Any

from ..outcome import UNDECIDED, CheckError
from ..polynomials import Ring

if TYPE_CHECKING:
    from .cells import Cell

BITS = 64  # of a form's numbers


class UnresolvedError(CheckError):
    """A form whose sign had to be known, and is not on so large a cell."""

    def __init__(self) -> None:
        super().__init__(UNDECIDED, "neither proven nor refuted")


class Form(Ring):
    """`ζ^m 2^e (c + Σ l[i] t_i + q t_0² ± r)` for all |t_i| ≤ 1: t_0 moves along the axis, others are parameters."""

    __slots__ = ("c", "cell", "e", "l", "m", "q", "r", "w")

    def __init__(self, cell: Cell, m: int, e: int, c: int, l: list[int], q: int, r: int) -> None:  # noqa: E741
        w = abs(q) + sum(map(abs, l))
        excess = (abs(c) + w + r).bit_length() - BITS
        if excess > 0:  # floors: each coefficient and the bound lose less than one
            c, l, q, r = c >> excess, [v >> excess for v in l], q >> excess, (r >> excess) + len(l) + 3  # noqa: E741
            w, e = (w >> excess) + len(l) + 1, e + excess
        self.cell, self.m, self.e, self.c, self.l, self.q, self.r = cell, m, e, c, l, q, r
        self.w = w  # at least |l| and |q| together

    def __bool__(self) -> bool:
        return bool(self.c or self.r or self.w)

    def size(self) -> int:
        """Bits of the largest value, about."""
        return self.e + (abs(self.c) + self.w + self.r).bit_length()

    def middle(self) -> Fraction:
        """The value at the centre of the cell, without the power of ζ."""
        return self.c * Fraction(2) ** self.e

    def width(self) -> Fraction:
        """How far below it may be elsewhere."""
        return (self.w + self.r) * Fraction(2) ** self.e

    def at(self, m: int) -> Form:
        """The same value with another power of ζ in front; on a cell that has an end at ζ = 0 only with a lower one."""
        if m == self.m:
            return self
        if m > self.m and self.cell.ends and self:
            raise UnresolvedError
        same = self * self.cell.power(self.m - m) if self else self.cell.form()
        same.m = m
        return same

    def up(self) -> Form:
        """Times τ² = −χ = 2^b ζ."""
        return Form(self.cell, self.m + 1, self.e + self.cell.b, self.c, self.l, self.q, self.r)

    def along(self, k: int) -> Form:
        """Times the symbol t_k."""
        values = [0] * len(self.l)
        values[k] = self.c
        return Form(self.cell, self.m, self.e, 0, values, 0, self.w + self.r)

    def __add__(self, other: Any) -> Form:
        a, b = self, other if isinstance(other, Form) else self.cell.real(other)
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
        r = (a.r << up) + (b.r >> down) + (len(values) + 3 if down else 0)
        return Form(self.cell, a.m, a.e - up, (a.c << up) + (b.c >> down), values, (a.q << up) + (b.q >> down), r)

    def __neg__(self) -> Form:
        return Form(self.cell, self.m, self.e, -self.c, [-v for v in self.l], -self.q, self.r)

    def __mul__(self, other: Any) -> Form:  # everything doubled: t_i² in [0, 1], all other products in [−1, 1]
        a, b = self, other if isinstance(other, Form) else self.cell.real(other)
        first, *squares = map(mul, a.l, b.l)
        p, q = 2 * a.c, 2 * b.c
        r = 2 * (a.w * b.w - abs(first) + (abs(a.c) + a.w) * b.r + (abs(b.c) + b.w) * a.r + a.r * b.r)
        values, bend = [p * y + q * x for x, y in zip(a.l, b.l, strict=True)], p * b.q + q * a.q + 2 * first
        e, r = a.e + b.e - 1, r - sum(map(abs, squares))
        return Form(self.cell, a.m + b.m, e, p * b.c + sum(squares), values, bend, r)

    def scaled(self, k: int) -> Form:
        """Times an integer."""
        return Form(self.cell, self.m, self.e, self.c * k, [v * k for v in self.l], self.q * k, self.r * abs(k))

    def inverse(self) -> Form:
        """1/f: d = f − c, |d| ≤ D < c: it is 1/c − d/c² + d²/c³ ± D³/(c³(c − D)), and d² = l_0² t_0² ± (D² − l_0²)."""
        if self.c < 0:
            return -(-self).inverse()
        c, D, square = self.c, self.w + self.r, self.l[0] ** 2
        if c <= D:
            raise UnresolvedError
        k = c.bit_length() + BITS
        one, rest = (1 << k) // c, ((D * D - square) * (c - D) + D**3 << k) // (c**3 * (c - D)) + 1
        r = rest + 2 * len(self.l) + 8 + (self.r << k) // (c * c)
        values, bend = [-(v * one // c) for v in self.l], (square * one // c - self.q * one) // c
        return Form(self.cell, -self.m, -k - self.e, one, values, bend, r)

    def root(self) -> Form:
        """√f of a form without power of ζ that means something ≥ 0: √c + d/(2√c) − R, R = (√(c + d) − √c)²/(2√c).

        Where d may reach −c it is anything from 0 to the root of the upper bound."""
        D = self.w + self.r
        n = 2 * BITS + 8 - (abs(self.c) + D).bit_length()  # at least 71
        n += (self.e - n) % 2
        c, D, e = self.c << n, D << n, (self.e - n) // 2
        if c <= D:
            half = isqrt(max(c + D, 0)) + 1 >> 1
            return Form(self.cell, 0, e, half, [0] * len(self.l), 0, half + 1)
        root = isqrt(c)
        rest = (root + 1 - isqrt(c - D)) ** 2 // (2 * root) + 1  # towards c + D it is less
        values = [(v << n) // (2 * root) for v in self.l]
        r = (rest >> 1) + len(values) + 5 + (self.r << n) // (2 * root)
        return Form(self.cell, 0, e, root - (rest >> 1), values, (self.q << n) // (2 * root), r)

    def sign(self, strict: bool = True) -> int:
        """1: > 0 (≥ 0 if not strict) everywhere; −1: not so somewhere, at a corner of the cell; 0: neither is shown."""
        f = -self if self.m % 2 else self  # ζ < 0
        least = f.c + dip(f.l[0], f.q) - sum(map(abs, f.l[1:]))
        return 1 if least - f.r > -(not strict) else -(least + 1 + f.r < strict)


def dip(l: int, q: int) -> int:  # noqa: E741
    """The least value of `l t + q t²` for |t| ≤ 1, less than one too low."""
    return -l * l // (4 * q) if abs(l) < 2 * q else q - abs(l)


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
        if not other.q:
            return Axis(self.p * other.p, self.q * other.p)
        return Axis(self.p * other.p + (self.q * other.q).up(), self.p * other.q + self.q * other.p)

    def along(self, k: int) -> Axis:
        """Times the symbol t_k."""
        return Axis(self.p.along(k), self.q.along(k))

    def conj(self) -> Axis:
        """Complex conjugate: τ is imaginary."""
        return Axis(self.p, -self.q)

    def parts(self) -> tuple[Form, Form]:
        """Re, and Im/ω: q, or −χ q because τ = −jω/ω² at infinity."""
        return self.p, self.q.up() if self.p.cell.far else self.q

    def norm2(self) -> Form:
        """`|z|²`."""
        return self.p * self.p + -(self.q * self.q).up()

    def inverse(self) -> Axis:
        """`1/z = conj z/|z|²`."""
        n = self.norm2().inverse()
        return Axis(self.p * n, -(self.q * n))

    def bounded(self) -> bool:
        """Whether it stays finite at the end of its cell."""
        return all(f.m >= 0 or not f for f in (self.p, self.q))


Plane = tuple[Form, Form]  # (p, q), aligned
TRIED = 3  # directions


def excludes_zero(zonotopes: Sequence[Sequence[Axis]]) -> tuple[bool, bool]:
    """Whether 0 is shown to be outside the hull of zonotopes `f[0] + Σ u_k f[k]`, |u_k| ≤ 1; about, in the middle.

    A linear functional of (p, q) has one sign on all of them: the normal of an edge f[k], which turns with ω as the
    edge does, or one through the centre. Floating point chooses it; what it is worth is decided by forms."""
    cell = zonotopes[0][0].p.cell
    if cell.ends and not all(f.bounded() for z in zonotopes for f in z):
        return False, False
    m = 0 if cell.ends else zonotopes[0][0].p.m
    plane = [[(f.p.at(m), f.q.at(m)) for f in z] for z in zonotopes]
    e, d = (max((pair[k].size() for z in plane for pair in z if pair[k]), default=0) for k in (0, 1))
    near = [[(ldexp(p.c, p.e - e), ldexp(q.c, q.e - d)) for p, q in z] for z in plane]
    tried: list[tuple[float, Form, Form, Plane | None]] = []
    if cell.ends:  # at χ = 0 it is p
        tried = [(_clearance(1, 0, near), cell.form(1), cell.form(), None)]
    else:
        p, q = (reduce(add, [z[0][k] for z in plane]) for k in (0, 1))
        a, b = (Form(cell, 0, f.e - 2 * k, f.c, [0] * len(f.l), 0, 0) for f, k in ((p, e), (q, d)))
        tried = [(_clearance(ldexp(p.c, p.e - e), ldexp(q.c, q.e - d), near), a, b, None)]
        for z, there in zip(plane, near, strict=True):
            pairs = list(zip(z, there, strict=True))[1:]
            tried += [(_clearance(-y, x, near), -own[1], own[0], own) for own, (x, y) in pairs]
    tried = sorted((entry for entry in tried if entry[0] > 0), key=itemgetter(0), reverse=True)
    return any(_separates(a, b, plane, own) for _, a, b, own in tried[:TRIED]), bool(tried)


def _clearance(a: float, b: float, zonotopes: Sequence[Sequence[tuple[float, float]]]) -> float:
    """How far `a p + b q` stays from 0 on all of them, as a share of its value at their centres; or negative."""
    values = [[a * p + b * q for p, q in z] for z in zonotopes]
    if not (all(v[0] > 0 for v in values) or all(v[0] < 0 for v in values)):
        return -1.0
    return min(1 - sum(map(abs, v[1:])) / abs(v[0]) for v in values)


def _separates(a: Form, b: Form, zonotopes: Sequence[Sequence[Plane]], own: Plane | None) -> bool:
    """Whether `a p + b q` has one sign on all of them; it is 0 on the edge that it belongs to."""
    sides = set()
    for z in zonotopes:
        centre, *others = (a * pair[0] + b * pair[1] for pair in z if pair is not own)
        side = (centre.sign() == 1) - ((-centre).sign() == 1)
        sides.add(side)
        if side == 0 or reduce(add, map(_below, others), centre if side > 0 else -centre).sign() != 1:
            return False
    return len(sides) == 1


def _below(f: Form) -> Form:
    """−|f|, or what encloses it where f changes its sign."""
    if f.sign() == 1:
        return -f
    return f if (-f).sign() == 1 else Form(f.cell, f.m, f.e, 0, [0] * len(f.l), 0, abs(f.c) + f.w + f.r)
