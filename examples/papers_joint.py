"""The paper's joint: how much bandwidth its own Q leaves on the table, and how much the form of Q does.

Expected: the optimum of a program written before this one, on 440 frequencies, in floating point, proving nothing.
"""

from __future__ import annotations

from compared import FOLDER, Row, omega_B, recorded, show

from robimp.synthesis import load, synthesize


def compare() -> list[Row]:
    """ω_B [rad/s] of three controllers: the paper's, the best of its form, the best of order 4."""
    paper = synthesize(load(FOLDER / "haninger2016-paper.yaml"))
    return [
        ("ω_B of the paper's Q, tuned by hand [rad/s]", float(paper.omega_B), 8.9),
        ("ω_B of the same form (23), optimised", omega_B(recorded("haninger2016-eq23")), 13.3),
        ("ω_B of order 4", omega_B(recorded("haninger2016")), 40.3),
    ]


if __name__ == "__main__":
    show(compare())
