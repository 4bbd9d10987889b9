"""Frequency responses of a joint, simulated: six sweeps of the load, as a laboratory would hand them over.

The load differs from sweep to sweep: it carries something else, it warms up, and at a small amplitude friction damps it
more. One sweep is dead: its sensor was not plugged in. Writes frf/*.csv beside this file; the same numbers every time.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robimp.synthesis import parse
from robimp.synthesis.simulation import Load, assemble, measure_impedance, multisine

HERE = Path(__file__).parent
HERTZ = np.array([0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 4, 6, 8, 11, 15, 20, 28])
NOISE = 2e-4  # of θ per torque [rad/(N·m)], at every frequency
LOADS = {  # amplitude [N·m] of the sweep, and the load it found: inertia, damping, stiffness
    "heavy": (2, (0.033, 0.22, 0.6)),
    "light": (2, (0.028, 0.20, 0.6)),
    "warm": (1, (0.030, 0.17, 0.6)),
    "cold": (1, (0.030, 0.25, 0.6)),
    "small": (0.2, (0.030, 0.60, 0.6)),
}
_FREE = """
robimp: 1
name: bench
motion: rotary
plant: {inertia: 0.03, damping: 0.2, stiffness: 0.6}
uncertainty: {box: {inertia: [0.03, 0.03], damping: [0.2, 0.2], stiffness: [0.6, 0.6]}}
actuator: {type: ideal}
impedance: {inertia: nominal, damping: 0.2, stiffness: 0.6}
controller: {type: dynamic-feedback, order: 0}
objective: {maximize: bandwidth, attenuation: 0.5}
constraints: {}
"""


def response(load: tuple[float, float, float]) -> NDArray[np.complex128]:
    """`θ/τ_int` of a load at HERTZ, from its simulated motion under a multisine; the actuator rests."""
    numbers = Load(*(Fraction(str(value)) for value in load))
    at_rest = ((Fraction(0),), (Fraction(1),))  # C = 0, and the wish is the load: no torque is demanded
    joint = assemble(parse(_FREE), at_rest, numbers)
    return 1 / measure_impedance(joint, multisine(2 * np.pi * HERTZ))[1].Z


def table(G: NDArray[np.complex128], amplitude: float, random: np.random.Generator) -> str:
    """A sweep with sensor noise, and the coherence that goes with it."""
    noise = NOISE / amplitude * (random.normal(size=len(G)) + 1j * random.normal(size=len(G)))
    coherence = abs(G) ** 2 / (abs(G) ** 2 + 2 * (NOISE / amplitude) ** 2)
    rows = zip(HERTZ, G + noise, coherence, strict=True)
    heading = "frequency [Hz],real,imaginary,coherence,amplitude [N·m]\n"
    lines = (f"{hz:g},{g.real:.5g},{g.imag:.5g},{share:.3f},{amplitude:g}\n" for hz, g, share in rows)
    return heading + "".join(lines)


def sweeps() -> dict[str, str]:
    """The files by name."""
    random = np.random.default_rng(1)
    found = {f"{name}.csv": table(response(load), level, random) for name, (level, load) in LOADS.items()}
    return found | {"unplugged.csv": table(np.full(len(HERTZ), 1e-5 + 0j), 1, random)}


if __name__ == "__main__":
    for name, text in sweeps().items():
        (HERE / "frf" / name).write_text(text, encoding="utf-8")
