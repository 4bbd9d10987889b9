"""Dynamic-error feedback (20) as the paper ran it, C_imp = 2.5 with a filter on τ_int only, and with the same on θ.

With one filter the two channels disagree: the port renders the wish badly, and it is not passive. Expected:
|Z/G_imp − 1| as the simulation measures it, which integrates the physics and knows no transfer function.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from compared import FOLDER, Row, margin, show, witness

from robimp.synthesis import Result, load, parse, synthesize
from robimp.synthesis.simulation import assemble, loads, measure_impedance, multisine

RENDERING = ("rendering", "every-load")


def compare() -> list[Row]:
    """The exit code, and the rendering error each certificate claims, beside a measurement."""
    path = FOLDER / "haninger2016-feedback.yaml"
    unequal = synthesize(load(path))
    equal = synthesize(parse(path.read_text(encoding="utf-8").replace("    position: none ", "    position: 100  ")))
    return [
        ("filter on τ_int only: exit code, not passive", unequal.exit_code, 4),
        ("  |Z/G_imp − 1| up to ω_B, proven and measured", margin(unequal.certificate, *RENDERING), measured(unequal)),
        (
            "same filter on θ: |Z/G_imp − 1|, proven and measured",
            margin(equal.certificate, *RENDERING),
            measured(equal),
        ),
    ]


def measured(result: Result) -> float:
    """The largest |Z/G_imp − 1| over the loads, at the frequency where the certificate says it is largest."""
    spec, omega = result.spec, float(Fraction(witness(result.certificate, *RENDERING)["omega"]))
    C, wish, s = result.coefficients, spec.impedance, 1j * omega
    G_imp = float(wish.inertia) * s**2 + float(wish.damping) * s + float(wish.stiffness)  # type: ignore[arg-type]
    joints = (assemble(spec, (C.numerator, C.denominator), corner) for corner in loads(spec))
    found = (measure_impedance(joint, multisine(np.array([omega])))[1].Z[0] for joint in joints)
    return float(max(abs(Z / G_imp - 1) for Z in found))


if __name__ == "__main__":
    show(compare())
