"""Reduce a frequency response of Q̃ to a structure's order: least squares over the structure's own parameters.

Whatever the structure, what comes out is one of its members, with the poles its bounds allow. A start, nothing more.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..problem.setting import Setting
    from ..spec.model import Polynomials
    from .nlp import Program

EVALUATIONS = 60
NO_FILTER = [1.0], [1.0]


@dataclass(frozen=True, eq=False)
class Response:
    """Q̃(jω) at frequencies. omega: (n,) [rad/s]; Q_tilde: (n,) complex."""

    omega: NDArray[np.float64]
    Q_tilde: NDArray[np.complex128]

    @classmethod
    def of(cls, setting: Setting, coefficients: Polynomials, omega: NDArray[np.float64]) -> Response:
        """That of a given controller."""
        return cls(omega, setting.loop.Q_tilde(setting.compensator(coefficients)).at(omega))


def reduced(program: Program, ideal: Response, x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Parameters from x on, so that Q̃ comes closest to the given one. Returns x itself where no step helps."""
    from scipy.optimize import least_squares

    structure, loop, p = program.structure, program.setting.loop, 1j * ideal.omega / program.omega_0
    forward = loop.actuator.H.at(ideal.omega) * loop.filters.force.at(ideal.omega)
    observer = program.setting.spec.controller.type == "dob"

    def error(x: NDArray[np.float64]) -> NDArray[np.float64]:
        polynomials = (*structure.polynomials(x), *(structure.sensor_filter(x) or NO_FILTER))
        num, den, F_num, F_den = (np.polyval(np.array(c, dtype=float), p) for c in polynomials)
        through = forward * num * F_num
        difference = through / ((den - num if observer else den) * F_den + through) - ideal.Q_tilde
        both = np.concatenate([difference.real, difference.imag])
        return np.asarray(np.nan_to_num(both, posinf=1e3, neginf=-1e3))

    low, high = structure.bounds
    inside = np.clip(x, low + 1e-9, high - 1e-9)
    with np.errstate(all="ignore"):
        found: NDArray[np.float64] = least_squares(error, inside, bounds=(low, high), max_nfev=EVALUATIONS).x
    return found
