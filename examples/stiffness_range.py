"""One Q for every stiffness from 0.2 to 10 N·m/rad, as in the paper's Fig. 10; sampled, delayed, in single precision.

Expected: the stiffnesses the paper rendered with one tuning, 10 being above that of its spring (4.8), and what a change
of stiffness alone does to the bandwidth: nothing, because Q̃ depends neither on the load nor on the impedance.
"""

from __future__ import annotations

from fractions import Fraction

from compared import FOLDER, Row, margin, omega_B, recorded, show

from robimp.synthesis import load, synthesize


def compare() -> list[Row]:
    """The range that is proven, and what it costs."""
    every = recorded("haninger2016-sampled")
    low, high = (float(Fraction(end)) for end in every["spec"]["impedance"]["stiffness"])
    one = synthesize(load(FOLDER / "haninger2016-paper.yaml"))
    return [
        ("lowest stiffness proven [N·m/rad]", low, 0.2),
        ("highest stiffness proven", high, 10),
        ("ω_B at 1 kHz with 1 ms of delay, and without sampling [rad/s]", omega_B(every), float(one.omega_B)),
        ("coefficients may be wrong by, and float32 rounds by", margin(every, "tolerance", "coefficients"), 2**-24),
    ]


if __name__ == "__main__":
    show(compare())
