"""The paper's Q on a slow computer: 500 Hz, and 2 ms from sample to torque. The proof takes hold and delay exactly.

Expected: floating point at 200,000 frequencies, with `Q̃ = HC/(1+HC)`, H delayed, written out below.
"""

from __future__ import annotations

import numpy as np
from compared import FOLDER, Row, margin, show

from robimp.synthesis import parse, synthesize

RATE, DELAY = 500.0, 2e-3


def compare() -> list[Row]:
    """Bandwidth and peak of what is left of a disturbance."""
    text = (FOLDER / "haninger2016-paper.yaml").read_text(encoding="utf-8")
    result = synthesize(parse(f"{text}sampling: {{rate: {RATE:g} Hz, delay: {DELAY:g} s}}\n"))
    omega = np.geomspace(0.1, 1000, 200_000)
    left = attenuation(omega)
    return [
        ("exit code: passive and stable for every load", result.exit_code, 0),
        ("ω_B [rad/s]", float(result.omega_B), omega[np.argmax(left > 0.3)]),
        ("peak of |1 − Q̃|", margin(result.certificate, "peak", "sensitivity"), left.max()),
    ]


def attenuation(omega: np.ndarray) -> np.ndarray:
    """|1 − Q̃| = |1/(1 + H C)| of the paper's Q, held and delayed. omega: (n,) [rad/s]."""
    s = 1j * omega
    motor, C_t = 1 / (0.01 * s**2 + 0.05 * s), 10 + 0.25 * s / (1 + s / 1000)
    H = 4.8 * motor * (C_t + 1) / (1 + 4.8 * motor * (1 + C_t))
    H = H * np.exp(-s * DELAY) * (1 - np.exp(-s / RATE)) / (s / RATE)
    Q = 2000 / (s**2 + 70.75 * s + 2500)
    return np.abs(1 / (1 + H * Q / (1 - Q)))


if __name__ == "__main__":
    show(compare())
