"""Draw the README's picture: disturbance attenuation and passivity of three controllers for the paper's joint."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from robimp.synthesis import Result, load, synthesize
from robimp.synthesis.problem.setting import Setting

FOLDER = Path(__file__).parent
CONTROLLERS = (
    ("haninger2016-paper.yaml", "the paper's Q, by hand", "0.55"),
    ("haninger2016-eq23.yaml", "the same form (23), optimised", "tab:orange"),
    ("haninger2016.yaml", "order 4", "tab:blue"),
)


def curves(result: Result, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """|1 − Q̃| and the least Re(Z/jω) [N·m·s/rad] over the box of loads. omega: (n,) [rad/s]. Returns two (n,)."""
    setting = Setting.of(result.spec)
    C = setting.compensator(result.coefficients)
    left = np.abs(1 - setting.loop.Q_tilde(C).at(omega))
    resistances = [(setting.loop.Z(C, g).at(omega) / (1j * omega)).real for g in setting.uncertainty.corners()]
    return left, np.min(resistances, axis=0)


def main() -> None:
    """Synthesise the three controllers and write haninger2016.svg beside this file."""
    plt.rcParams.update({"font.size": 9, "svg.hashsalt": "robimp", "svg.fonttype": "none", "axes.grid": True})
    omega = np.geomspace(1, 400, 700)
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(7.2, 4.6), sharex=True, constrained_layout=True)
    for file, label, colour in CONTROLLERS:
        result = synthesize(load(FOLDER / file))
        left, resistance = curves(result, omega)
        omega_B = float(result.omega_B)
        upper.plot(omega, left, color=colour, label=f"{label}: proven to {omega_B:.1f} rad/s")
        upper.plot(omega_B, 0.3, "o", color=colour)
        lower.plot(omega, resistance, color=colour)
        if result.bound is not None:
            upper.axvline(result.bound.omega_B, color="0.3", linestyle=":")
    upper.axhline(0.3, color="0.3", linewidth=0.8)
    upper.text(1.05, 0.33, "attenuation 0.3", color="0.3")
    upper.text(50, 0.06, "bound", color="0.3")
    upper.set(xscale="log", ylim=(0, 1.7), ylabel="|1 − Q̃|, what is left\nof a disturbance")
    upper.legend(loc="upper left")
    lower.axhline(0, color="0.3", linewidth=0.8)
    lower.set(
        ylim=(-0.05, 0.4), xlabel="ω [rad/s]", ylabel="least Re(Z/jω) over all loads\n[N·m·s/rad], passive if ≥ 0"
    )
    figure.savefig(FOLDER / "haninger2016.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
