"""Two published actuators, certified: the linear UT-SEA and a leg joint of the quadruped HyQ.

Motor, spring and load are published, torque loops and impedances illustrative. Expected: the natural frequency of the
published motor on the published spring, which a wrong unit would change; and the port's resistance as the simulation
measures it with the load and at the frequency where the certificate says it is least.
"""

from __future__ import annotations

from fractions import Fraction
from math import pi, sqrt
from typing import Any

import numpy as np
from compared import FOLDER, Row, margin, recorded, show, witness

from robimp.synthesis import load
from robimp.synthesis.simulation import Load, assemble, measure_impedance, multisine

PUBLISHED = {"ut-sea": (350e3, 360.0), "hyq-leg": (8077.0, 0.572)}  # spring, motor: N/m, kg; N·m/rad, kg·m²
PASSIVITY = ("eq12", "structured")


def compare() -> list[Row]:
    """Of each actuator: its resonance, and the least Re(Z/jω)."""
    rows: list[Row] = []
    for name, (spring, motor) in PUBLISHED.items():
        certificate = recorded(name)
        drive = certificate["spec"]["actuator"]
        K, J = (float(Fraction(drive[key])) for key in ("spring_stiffness", "motor_inertia"))
        least, seen = margin(certificate, *PASSIVITY), measured(name, certificate)
        rows.append((f"{name}: motor on its spring [Hz]", sqrt(K / J) / (2 * pi), sqrt(spring / motor) / (2 * pi)))
        rows.append((f"{name}: least Re(Z/jω), proven and measured [SI]", least, seen))
    return rows


def measured(name: str, certificate: dict[str, Any]) -> float:
    """Re(Z/jω) of the certificate's witness, from a simulated motion."""
    place, C = witness(certificate, *PASSIVITY), certificate["controller"]["C"]
    omega = float(Fraction(place["omega"]))
    numerator, denominator = ([Fraction(c) for c in C[part]] for part in ("numerator", "denominator"))
    corner = Load(*(Fraction(value) for value in place["load"].values()))
    joint = assemble(load(FOLDER / f"{name}.yaml"), (numerator, denominator), corner)
    return float((measure_impedance(joint, multisine(np.array([omega])))[1].Z[0] / (1j * omega)).real)


if __name__ == "__main__":
    show(compare())
