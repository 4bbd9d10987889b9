"""Nominal models fitted to measured responses: the load (1), or the torque transfer H of a locked actuator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

import numpy as np
from flint import fmpq_poly
from numpy.typing import NDArray

from ...models.rational import descending, fraction, polynomial
from ..certificate.hurwitz import is_hurwitz
from ..errors import InputError
from ..spec.model import Plant, Polynomials
from ..spec.record import Complex, Model, Record, dynamic_stiffness

DIGITS = 4  # of a fitted number
MOST_ORDER = 6
DAMPING = (0.02, 5.0)  # relative, of a pair of poles
BEYOND = 10.0  # how far outside of the measured band a pole is looked for

Samples = NDArray[np.float64]


@dataclass(frozen=True)
class Load:
    """`Ĝ = 1/(Is² + Bs + K)`."""

    plant: Plant

    @property
    def inverse(self) -> Model:
        """`1/Ĝ(jω)`."""
        return dynamic_stiffness(self.plant.inertia, self.plant.damping, self.plant.stiffness)


@dataclass(frozen=True)
class Transfer:
    """`Ĥ`, stable."""

    polynomials: Polynomials

    @property
    def inverse(self) -> Model:
        """`1/Ĥ(jω)`, exactly."""
        N, D = polynomial(self.polynomials.numerator), polynomial(self.polynomials.denominator)

        def at(omega: Fraction) -> Complex:
            (a, b), (c, d) = (_at(p, omega) for p in (D, N))
            size = c * c + d * d
            if size == 0:
                raise InputError(f"the fitted H vanishes at {float(omega):.6g} rad/s; try fewer zeros")
            return (a * c + b * d) / size, (b * c - a * d) / size

        return at

    @property
    def minimum_phase(self) -> bool:
        """Whether every zero lies to the left."""
        return is_hurwitz(polynomial(self.polynomials.numerator))


def fit_load(records: Sequence[Record]) -> Load:
    """The load with the least sum of `|G/Ĝ − 1|²` over all samples: linear in I, B, K ≥ 0, so the best there is.

    Raises:
        InputError: the responses show no inertia.
    """
    from scipy.optimize import lsq_linear

    omega, G = _samples(records)
    rows = np.column_stack([-(omega**2) * G, 1j * omega * G, G])
    A = np.vstack([rows.real, rows.imag])
    b = np.concatenate([np.ones(len(G)), np.zeros(len(G))])
    size = np.linalg.norm(A, axis=0)
    fit = lsq_linear(A / size, b, bounds=(0, np.inf), method="bvls").x / size
    I, B, K = (_rounded(value) for value in fit)  # noqa: E741
    if I == 0:
        raise InputError("no inertia fits the responses: are they θ/τ_int of a free load, in rad per N·m?")
    return Load(Plant(inertia=I, damping=B, stiffness=K))


def fit_transfer(records: Sequence[Record], order: int, zeros: int) -> Transfer:
    """A stable transfer function of this order, with this many zeros, near all records.

    Poles by nonlinear least squares in log-frequency and log-damping, so that none can leave the left half-plane; for
    given poles the numerator is linear. Errors are relative to the median gain at each frequency. Several fixed starts.
    """
    from scipy.optimize import least_squares

    omega, H = _samples(records)
    gains = {w: np.median(abs(H[omega == w])) for w in set(omega)}
    weight = 1 / np.array([gains[w] or 1.0 for w in omega])
    scale = float(np.sqrt(omega.min() * omega.max()))
    s = 1j * omega / scale

    def numerator(poles: Samples) -> tuple[Samples, NDArray[np.complex128]]:
        basis = np.column_stack([s**k for k in range(zeros + 1)]) / np.polyval(poles, s)[:, None] * weight[:, None]
        A, b = np.vstack([basis.real, basis.imag]), np.concatenate([(H * weight).real, (H * weight).imag])
        fit = np.linalg.lstsq(A, b, rcond=None)[0]
        return fit, basis @ fit - H * weight

    def residual(x: Samples) -> Samples:
        error = numerator(_denominator(x, order))[1]
        return np.concatenate([error.real, error.imag])

    low, high = (np.log(w / scale * f) for w, f in ((omega.min(), 1 / BEYOND), (omega.max(), BEYOND)))
    pair, alone = ((low, *np.log(DAMPING[:1])), (high, *np.log(DAMPING[1:]))), ((low,), (high,))
    limits = [sum(((pair[k],) * (order // 2) + (alone[k],) * (order % 2)), ()) for k in (0, 1)]
    fits = []
    for share, damping in product((0.3, 0.5, 0.7), (0.3, 1.0)):
        centres = low + (high - low) * np.clip(share + 0.1 * np.arange(order // 2), 0, 0.95)
        start = [value for centre in centres for value in (centre, np.log(damping))]
        start += [low + (high - low) * share] * (order % 2)
        fits.append(least_squares(residual, start, bounds=limits, max_nfev=200))
    best = _denominator(min(fits, key=lambda fit: fit.cost).x, order)
    return _transfer(numerator(best)[0][::-1], best, scale)


def _denominator(x: Samples, order: int) -> Samples:
    """Monic coefficients, descending, from the logarithms of frequencies and dampings."""
    found = np.ones(1)
    for k in range(order // 2):
        omega, damping = np.exp(x[2 * k : 2 * k + 2])
        found = np.polymul(found, [1.0, 2 * damping * omega, omega**2])
    return np.polymul(found, [1.0, np.exp(x[-1])]) if order % 2 else found


def _transfer(numerator: Samples, denominator: Samples, scale: float) -> Transfer:
    """Rounded, in rad/s, with `N(0) = gain·D(0)` of a rounded gain, so that 1 − H/H(0) stays short."""
    n, m = len(denominator) - 1, len(numerator) - 1
    D = [_rounded(c * scale**k) for k, c in enumerate(denominator)]
    gain = _rounded(numerator[-1] / denominator[-1])
    shape = [_rounded(c / float(gain) * scale ** (n - m + k)) for k, c in enumerate(numerator[:-1])]
    N = [gain * c for c in (*shape, D[-1])]
    return Transfer(Polynomials(numerator=tuple(N), denominator=tuple(D)))


def output_impedance(H: Polynomials, spring: Fraction) -> Polynomials:
    """`Z_a = K_sp·(1 − H/H(0))`, behind a spring and a proportional torque loop, or with the feedforward λ = 1.

    From `H = K_sp P_m(C_t+λ)/(1+K_sp P_m(1+C_t))`, `Z_a = K_sp/(1+K_sp P_m(1+C_t))` (13)-(15): with a constant C_t,
    or with λ = 1, `H/H(0) = K_sp P_m(1+C_t)/(1+K_sp P_m(1+C_t))`.
    """
    N, D = polynomial(H.numerator), polynomial(H.denominator)
    left = D - N * (D[0] / N[0])
    numerator = tuple(spring * c for c in descending(left))
    return Polynomials(numerator=numerator, denominator=H.denominator)


def _at(p: fmpq_poly, omega: Fraction) -> Complex:
    """`p(jω)`, exactly."""
    powers = [(fraction(c), omega**k, k % 4) for k, c in enumerate(p.coeffs())]
    real, imaginary = (
        sum((c * w * (-1) ** (turn // 2) for c, w, turn in powers if turn % 2 == part), Fraction(0)) for part in (0, 1)
    )
    return real, imaginary


def _samples(records: Sequence[Record]) -> tuple[Samples, NDArray[np.complex128]]:
    """Frequencies [rad/s] and responses of every sample, (n,) each."""
    every = [(float(s.omega), complex(s.re, s.im)) for record in records for s in record.samples]
    return np.array([w for w, _ in every]), np.array([value for _, value in every])


def _rounded(value: float) -> Fraction:
    return Fraction(f"{value:.{DIGITS - 1}e}")
