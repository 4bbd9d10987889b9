"""Cells of frequency and uncertain parameters: the axis [0, ∞] in three parts, each with forms of its own.

middle  z = ω, orders 0;
low     z = ω → 0, high  z = 1/ω → 0: powers of z are counted apart, so that 0 and ∞ are ordinary points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from ....models.rational import to_float
from ....models.sampling import Hold
from ...problem.constraints.inequality import Band
from .form import ROUNDING, TINY, Form
from .wave import Wave

if TYPE_CHECKING:
    from numpy.typing import NDArray


FEW = 64  # cells that cost no more than one


class Part(Enum):
    """Which part of the axis cells lie in."""

    LOW = "low"
    MIDDLE = "middle"
    HIGH = "high"


@dataclass(frozen=True, eq=False)
class Cells:
    """n cells. z: (2, n) from, to; t: (2, m, n) part of [−1, 1] of each of m parameters that a cell is about."""

    part: Part
    z: NDArray[np.float64]
    t: NDArray[np.float64]

    @classmethod
    def whole(cls, part: Part, z: NDArray[np.float64], parameters: int) -> Cells:
        """Cells between z[0] and z[1], (2, n), for the whole range of every parameter."""
        t = np.ones((2, parameters, z.shape[1]))
        t[0] = -1.0
        return cls(part, z, t)

    @classmethod
    def at(cls, omega: NDArray[np.float64] | float, parameters: int) -> Cells:
        """Single frequencies, (n,) [rad/s], for the whole range of every parameter."""
        return cls.whole(Part.MIDDLE, np.vstack([omega, omega]).astype(float), parameters)

    @property
    def size(self) -> int:
        """Number of cells."""
        return int(self.z.shape[1])

    def __getitem__(self, which: Any) -> Cells:
        return Cells(self.part, self.z[:, which], self.t[:, :, which])

    def split_frequency(self) -> Cells:
        """Every cell halved along z, several times while there are few; in decades while one spans a factor 4."""
        low, high = self.z
        middle = np.where(low == 0, high / 4, np.where(high > 4 * low, 2 * low, (low + high) / 2))
        z = np.hstack([np.vstack([low, middle]), np.vstack([middle, high])])
        halves = Cells(self.part, z, np.concatenate([self.t, self.t], axis=2))
        return halves.split_frequency() if 0 < halves.size < FEW else halves

    def split_parameter(self, index: NDArray[np.int_], offset: NDArray[np.float64] | None = None) -> Cells:
        """Every cell halved along its parameter `index`, (n,); in ratio while its ends differ by a factor above 2.

        offset: (m,) for parameters that are proportional to t + offset.
        """
        k = np.arange(self.size)
        low, high = self.t[:, index, k]
        middle = (low + high) / 2
        if offset is not None:
            a, b = low + offset[index], high + offset[index]
            middle = np.where((a > 0) & (b > 2 * a), np.sqrt(np.abs(a * b)) - offset[index], middle)
        below, above = self.t.copy(), self.t.copy()
        below[1, index, k] = middle
        above[0, index, k] = middle
        return Cells(self.part, np.hstack([self.z, self.z]), np.concatenate([below, above], axis=2))

    def at_end(self, index: int, low: NDArray[np.bool_]) -> Cells:
        """The cells at one end of the frequencies (index −1) or of a parameter: the lower where `low`, (n,)."""
        z, t = self.z, self.t.copy()
        if index < 0:
            z = np.where(low, z[0], z[1]) * np.ones((2, 1))
        else:
            t[:, index] = np.where(low, t[0, index], t[1, index])
        return Cells(self.part, z, t)

    def points(self, signs: NDArray[np.float64]) -> Cells:
        """Degenerate cells: the middle in z, each parameter at the end of its range that `signs`, (m, n), names."""
        z = self.z.mean(axis=0)
        t = np.where(signs < 0, self.t[0], np.where(signs > 0, self.t[1], self.t.mean(axis=0)))
        return Cells(self.part, np.vstack([z, z]), np.stack([t, t]))

    def corners(self, which: Sequence[int]) -> list[Cells]:
        """The cells with some parameters, by index, at the ends of their part: the last changes fastest."""
        found = []
        for ends in product((0, 1), repeat=len(which)):
            t = self.t.copy() if which else self.t
            for index, end in zip(which, ends, strict=True):
                t[:, index] = self.t[end, index]
            found.append(Cells(self.part, self.z, t))
        return found

    @classmethod
    def joined(cls, parts: Sequence[Cells]) -> Cells:
        """Cells of one part of the axis, one after the other."""
        z, t = (np.concatenate(arrays, axis=-1) for arrays in zip(*((one.z, one.t) for one in parts), strict=True))
        return cls(parts[0].part, z, t)

    def moving(self, index: int, low: NDArray[np.float64], high: NDArray[np.float64]) -> Form:
        """The form of a quantity that runs from low to high with tᵢ."""
        c = np.zeros((2 + self.t.shape[1], self.size))
        c[0], c[1 + index] = (low + high) / 2, (high - low) / 2
        return Form(c, ROUNDING * (np.abs(low) + np.abs(high)))

    def frequency(self) -> Form:
        """The form of z itself, of order 0."""
        return self.moving(0, *self.z)

    @cached_property
    def s(self) -> Wave:
        """`s = jω`."""
        z = self.frequency()
        if self.part is Part.MIDDLE:
            return Wave(0, z.constant(1), z * z)
        one = Form(z.constant(1).c, z.constant(1).rho, 0, z)
        return Wave(0, one, replace(one, order=2 if self.part is Part.LOW else -2))

    def parameter(self, index: int, low: Any, high: Any) -> Form:
        """An uncertain number in [low, high] (exact rationals), as a form in the cell's share of it."""
        a, b = to_float(low), to_float(high)
        ends = [(a + b) / 2 + (b - a) / 2 * t for t in self.t[:, index]]
        form = self.moving(1 + index, *ends)
        one = self.s.x
        return Form(form.c, form.rho + 8 * ROUNDING * (abs(a) + abs(b)) + TINY, 0, one.z)

    def ball(self, low: float | NDArray[np.float64], high: float | NDArray[np.float64], order: int = 0) -> Form:
        """A quantity of which only a range is known."""
        c = np.zeros((2 + self.t.shape[1], self.size))
        c[0] = (np.asarray(low) + high) / 2
        return Form(c, (np.asarray(high) - low) / 2 + ROUNDING * np.abs(c[0]) + TINY + 0 * c[0], order, self.s.x.z)

    def hold(self, hold: Hold) -> Wave:
        """`e^{−sT_d}(1−e^{−sT})/(sT)`: even and odd parts are entire in ω; towards ∞ only their size is known."""
        T, T_d, x = to_float(hold.period), to_float(hold.delay), self.s.x
        if self.part is Part.HIGH:  # |hold| ≤ 2/(ωT)
            return Wave(self.ball(-2.01 / T, 2.01 / T, 1), self.ball(-2.01 / T, 2.01 / T, 2), x)
        mid, low, high = self.z.mean(axis=0), *self.z
        half = (high - low) / 2
        delay, shape = (
            Wave(self._entire(even, mid, half, time), self._entire(odd, mid, half, time), x)
            for even, odd, time in ((_cosine, _minus_sine, T_d), (_cardinal, _versed, T))
        )
        return delay * shape

    def _entire(self, f: Any, mid: NDArray[np.float64], half: NDArray[np.float64], T: float) -> Form:
        """First-order form of an entire function from its value, slope and bounds of curvature and rounding."""
        value, slope, curvature, size = f(mid, T)
        c = np.zeros((2 + self.t.shape[1], self.size))
        c[0], c[1] = value, slope * half
        error = 64 * ROUNDING * size * (1 + mid * T) + 1e-15 * size * mid * T
        return Form(c, curvature * half**2 / 2 + error + error * half * T, 0, self.s.x.z)


# Each: value, slope, a bound on the second derivative, and the size that rounding is relative to.


def _cosine(w: NDArray[np.float64], T: float) -> tuple[Any, ...]:
    return np.cos(w * T), -T * np.sin(w * T), T * T, 1.0


def _minus_sine(w: NDArray[np.float64], T: float) -> tuple[Any, ...]:
    """`−sin(ωT)/ω = −T·sinc(ωT)`."""
    value, slope, curvature, _ = _cardinal(w, T)
    return -T * value, -T * slope, T * curvature, T


def _cardinal(w: NDArray[np.float64], T: float) -> tuple[Any, ...]:
    """`sin(ωT)/(ωT)`; its second derivative is at most T²/3."""
    u = w * T
    small = u < 0.1
    v = np.where(small, 1.0, u)
    value = np.where(small, 1 - u**2 / 6 + u**4 / 120 - u**6 / 5040 + u**8 / 362880, np.sin(v) / v)
    slope = np.where(small, -u / 3 + u**3 / 30 - u**5 / 840 + u**7 / 45360, (v * np.cos(v) - np.sin(v)) / v**2)
    return value, T * slope, T * T / 3, 1.0


def _versed(w: NDArray[np.float64], T: float) -> tuple[Any, ...]:
    """`−(1−cos ωT)/(ω²T) = −(T/2)·sinc²(ωT/2)`; sinc² has second derivatives of at most 2/3."""
    value, slope, _, _ = _cardinal(w, T / 2)
    return -T / 2 * value**2, -T * value * slope, T / 2 * (2 / 3) * (T / 2) ** 2, T / 2


def axis(low: float, high: float, parameters: int, middle: int, band: Band) -> tuple[Cells, ...]:
    """Cells that cover a band: the joint's own frequencies [low, high] in `middle` cells, and the ends beyond.

    low, high, band in rad/s; the band may lie anywhere about them, and its two ends are covered, too.
    """
    first, last = float(band[0]), np.inf if band[1] is None else float(band[1]) * (1 + 1e-15)
    first *= 1 - 1e-15
    found = []

    def cells(part: Part, edges: Any) -> None:
        edges = np.asarray(edges, dtype=float)
        found.append(Cells.whole(part, np.vstack([edges[:-1], edges[1:]]), parameters))

    if first < low:
        cells(Part.LOW, [first, min(low, last)])
    a, b = max(first, low), min(last, high)
    if a < b:
        inner = np.geomspace(a, b, middle + 1)
        inner[0], inner[-1] = a, b
        cells(Part.MIDDLE, inner)
    if last > high:
        start = max(high, first)
        cells(Part.HIGH, [0.0 if np.isinf(last) else 1 / last * (1 - 1e-15), 1 / start * (1 + 1e-15)])
    return tuple(found)
