"""Where an inequality fails: an exact frequency and load, and the first frequency at which it does."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import inf, isqrt, log10

from flint import arb, ctx, fmpq, fmpq_poly

from ...models.actuator import SeriesElastic
from ...models.impedance import DynamicStiffness
from ...models.rational import exact, fraction
from ..spec.model import Polynomials
from .bivariate import Bivariate
from .gap import gap, reversed_sides
from .lowering import SumOfRoots, strip
from .outcome import Interval
from .positivity import obligations
from .roots import complex_roots

T_SAMPLES = 16
NEAR = 8.0  # decades from where the grid found a constraint tightest: beyond, ∞ says more


@dataclass(frozen=True)
class Witness:
    """An exact frequency [rad/s] (None: ∞) and the load, if any, at which a claim fails.

    Where these are a range: the impedance and actuator; for a tolerance, the controller (numerator and denominator of Q
    or C_imp) and the claim that fails for it.
    """

    omega: Fraction | None
    load: DynamicStiffness | None
    impedance: DynamicStiffness | None = None
    actuator: SeriesElastic | None = None
    controller: Polynomials | None = None
    claim: tuple[str, str] | None = None


def short(value: float, digits: int = 6, up: bool | None = None) -> Fraction:
    """The decimal with few digits near a float: nearest, or on the side asked for."""
    if value == 0:
        return Fraction(0)
    nearest = Fraction(f"{value:.{digits - 1}e}")
    unit = Fraction(f"1e{int(f'{value:e}'.split('e')[1]) - digits + 1}")
    if up is None or (nearest >= Fraction(value)) == up:
        return nearest
    return nearest + unit if up else nearest - unit


def find_witness(
    inequality: SumOfRoots, interval: Interval, hints: tuple[float, ...], *, strict: bool
) -> Witness | None:
    """A point of the interval where the inequality fails, tried in the order: hints, ends, between exact roots."""
    inequality, strict = strip(inequality), strict or inequality.strict
    for t in _places(inequality):
        for omega in _candidates(inequality, interval, hints, strict):
            if _violated(inequality, omega, t, strict):
                return Witness(omega, _load(inequality, t))
    return None


def fails_at(inequality: SumOfRoots, omega: Fraction, *, strict: bool) -> bool:
    """Whether an inequality fails at one exact frequency, for the first load of its segment."""
    return _violated(strip(inequality), omega, fmpq(0), strict)


def _places(inequality: SumOfRoots) -> list[fmpq]:
    moving = max(len(p) for p in (*inequality.radicands, inequality.right)) > 1
    return [fmpq(k, T_SAMPLES) for k in range(T_SAMPLES + 1)] if moving else [fmpq(0)]


def _load(inequality: SumOfRoots, t: fmpq) -> DynamicStiffness | None:
    if inequality.segment is None:
        return None
    a, b = inequality.segment
    return DynamicStiffness(
        a.inertia + t * (b.inertia - a.inertia),
        a.damping + t * (b.damping - a.damping),
        a.stiffness + t * (b.stiffness - a.stiffness),
    )


def _candidates(
    inequality: SumOfRoots, interval: Interval, hints: tuple[float, ...], strict: bool
) -> Iterator[Fraction | None]:
    """Frequencies in the order they are worth trying; those far from the hints come after ∞."""
    low, high = interval
    for hint in hints:
        omega = short(hint)
        if low <= exact(omega * omega) and (high is None or exact(omega * omega) <= high):
            yield omega
    yield from (_sqrt(end) for end in (low, high) if end is not None)
    inside: list[Fraction] = []
    if len(inequality.radicands) <= 2:
        usual = next((hint for hint in hints if 0 < hint < inf), 1.0)
        for needed in obligations(inequality, strict=strict):
            if len(needed.p) == 1:
                inside += _between_roots(needed.p[0], interval, usual)
        inside.sort(key=lambda omega: _decades(omega, usual))
    near = [omega for omega in inside if _decades(omega, usual) < NEAR]
    yield from (*near, *((None,) if high is None else ()), *inside[len(near) :])


def _decades(omega: Fraction, usual: float) -> float:
    """How many decades a frequency is away from a usual one."""
    return abs(log10(omega.numerator) - log10(omega.denominator) - log10(usual)) if omega > 0 else inf


def _sqrt(x: fmpq) -> Fraction:
    """ω of an interval's end x = ω², which is the square of a rational."""
    return Fraction(isqrt(int(x.p)), isqrt(int(x.q)))


def _between_roots(p: fmpq_poly, interval: Interval, usual: float) -> Iterator[Fraction]:
    """Rational frequencies, one between each two neighbouring real roots of p inside the interval, near a usual one."""
    low, high = (float(fraction(interval[0])), None if interval[1] is None else float(fraction(interval[1])))
    if p.degree() <= 0:
        return
    roots = [low] + [x for x in real_roots(p) if x > low and (high is None or x < high)]
    roots.append(high if high is not None else 4 * (roots[-1] or 1.0))
    for a, b in pairwise(roots):
        if b > a:
            near_a, near_b = Fraction(a) + Fraction(b - a) / 16, Fraction(b) - Fraction(b - a) / 16
            if a > 0 and b > 16 * a:  # between roots far apart, the middle would be at the farther one
                near_a, near_b = 4 * Fraction(a), Fraction(b) / 4
            yield _rational_sqrt_between(Fraction(a), Fraction(b), min(max(Fraction(usual) ** 2, near_a), near_b))


def real_roots(p: fmpq_poly) -> list[float]:
    """Positions of the distinct real roots, increasing: floats to look near, not proofs."""
    return sorted(float(root.real.mid()) for root, _ in complex_roots(p) if root.imag == 0)


def _rational_sqrt_between(a: Fraction, b: Fraction, middle: Fraction) -> Fraction:
    """A rational ω with few digits, a < ω² < b and ω² near `middle`."""
    for digits in range(1, 400, 3):
        scale = 10**digits
        omega = Fraction(isqrt(int(middle * scale * scale)), scale)
        if a < omega * omega < b:
            return omega
    return Fraction(0)


def _violated(inequality: SumOfRoots, omega: Fraction | None, t: fmpq, strict: bool) -> bool:
    """Exact: by squaring up to two roots, beyond by balls of growing precision, which leave equality undecided."""
    sides = reversed_sides(inequality) if omega is None else inequality
    x = fmpq(0) if omega is None else exact(omega * omega)
    if len(sides.radicands) <= 2:
        values = [(_exact_value(needed.p, x, t), needed.strict) for needed in obligations(sides, strict=strict)]
        return any(value < 0 or (value == 0 and must_differ) for value, must_differ in values)
    precision = ctx.prec
    try:
        for ctx.prec in (128, 512, 2048):
            value = gap(sides, arb(x), arb(t))
            if value > 0:
                return False
            if value < 0:
                return True
        return False
    finally:
        ctx.prec = precision


def _exact_value(p: Bivariate, x: fmpq, t: fmpq) -> fmpq:
    return sum((c(x) * t**k for k, c in enumerate(p)), fmpq(0))
