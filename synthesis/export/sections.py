"""Second-order sections: Tustin's rule on poles and zeros, paired, ordered, rounded."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from itertools import permutations
from operator import mul
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq, fmpq_poly

from ...models.rational import exact, to_float
from ..certificate.roots import complex_roots

if TYPE_CHECKING:
    from numpy.typing import NDArray

DTYPE: dict[str, Any] = {"double": np.float64, "float": np.float32}
MANTISSA = {"double": 53, "float": 24}
GRID = np.geomspace(1e-5, 1.0, 400) * np.pi  # frequencies [rad/tick] on which intermediate gains are compared
AT_ONE = 1e-14  # a section with |1 + a1 + a2| below this holds the pole at z = 1 of an integrator
MOST_PERMUTED = 6


@dataclass(frozen=True)
class Section:
    """`(b0 + b1 z⁻¹ + b2 z⁻²)/(1 + a1 z⁻¹ + a2 z⁻²)`; every number is exactly what the code holds."""

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float

    @property
    def num(self) -> fmpq_poly:
        """Numerator as an exact polynomial of z⁻¹."""
        return fmpq_poly([exact(b) for b in (self.b0, self.b1, self.b2)])

    @property
    def den(self) -> fmpq_poly:
        """Denominator as an exact polynomial of z⁻¹."""
        return fmpq_poly([fmpq(1), exact(self.a1), exact(self.a2)])


@dataclass(frozen=True)
class Sections:
    """A cascade; without sections it is 1."""

    sections: tuple[Section, ...]

    @property
    def num(self) -> fmpq_poly:
        """Product of the numerators, of z⁻¹."""
        return reduce(mul, (section.num for section in self.sections), fmpq_poly([1]))

    @property
    def den(self) -> fmpq_poly:
        """Product of the denominators, of z⁻¹; nothing is cancelled."""
        return reduce(mul, (section.den for section in self.sections), fmpq_poly([1]))

    @property
    def sos(self) -> NDArray[np.float64]:
        """Rows b0, b1, b2, 1, a1, a2, as SciPy has them: (n, 6)."""
        return np.array([[s.b0, s.b1, s.b2, 1.0, s.a1, s.a2] for s in self.sections]).reshape(-1, 6)


def sections_of(num: fmpq_poly, den: fmpq_poly, c: fmpq, precision: str, means: int = 0) -> Sections:
    """`num/den` of s under `s = c (z−1)/(z+1)`, over `((1 + z⁻¹)/2)^means`; numbers are `double` or `float`."""
    from scipy.signal import zpk2sos

    if num == den:
        return Sections(())
    zeros, poles = _mapped(num, c), _mapped(den, c)
    zeros += [0.0] * means + [-1.0] * (len(poles) - len(zeros) - means)
    gain = to_float(num(c) / den(c)) * 2**means  # z = ∞ is s = c
    if not poles:
        return Sections((_rounded(np.array([gain, 0, 0, 1, 0, 0]), precision),))
    rows = _ordered(list(zpk2sos(zeros, poles, 1.0)), gain)
    return Sections(tuple(_rounded(row, precision) for row in rows))


def _mapped(p: fmpq_poly, c: fmpq) -> list[complex]:
    """`(c+s)/(c−s)` of every root s; one at 0 becomes exactly 1."""
    found = []
    for root, multiplicity in complex_roots(p):
        s = complex(float(root.real.mid()), float(root.imag.mid())) / to_float(c)
        z = (1 + s) / (1 - s)
        found += [complex(z.real, 0.0 if root.imag == 0 else z.imag)] * multiplicity
    return found


def _ordered(rows: list[NDArray[np.float64]], gain: float) -> list[NDArray[np.float64]]:
    """The order with the smallest peak between sections, an integrator last: there a start without a jump is exact."""
    z = np.exp(-1j * np.outer(GRID, np.arange(3)))
    responses = {k: np.abs((z @ row[:3]) / (z @ row[3:])) for k, row in enumerate(rows)}
    integrates = {k: abs(row[3:].sum()) < AT_ONE for k, row in enumerate(rows)}

    def cost(order: tuple[int, ...]) -> tuple[Any, ...]:
        between = np.cumprod([responses[k] for k in order[:-1]], axis=0)
        return [integrates[k] for k in order].index(True) if any(integrates.values()) else 0, between.max(initial=0.0)

    orders = permutations(range(len(rows))) if len(rows) <= MOST_PERMUTED else [tuple(range(len(rows)))]
    best = min(orders, key=lambda order: (-cost(order)[0], cost(order)[1]))
    ordered = [rows[k].copy() for k in best]
    ordered[0][:3] *= gain
    return ordered


def _rounded(row: NDArray[np.float64], precision: str) -> Section:
    """In the arithmetic of the code. An integrator stays one: a2 with a bit to spare, so that a1 = −1 − a2 is exact."""
    to = DTYPE[precision]
    b0, b1, b2, _, a1, a2 = (float(to(value)) for value in row)
    if abs(row[3:].sum()) < AT_ONE:
        unit = 2.0 ** (MANTISSA[precision] - 1)
        a2 = round(a2 * unit) / unit
        a1 = -1.0 - a2
    return Section(b0, b1, b2, a1, a2)
