"""The paper's own tuning, certified as it is: passive with one of the impedances of its Fig. 12, not with the other.

Expected: Re(Z/jω) and its frequency as a dense grid in floating point sees them.
"""

from __future__ import annotations

from fractions import Fraction

from compared import FOLDER, Row, margin, show, witness

from robimp.synthesis import load, synthesize


def compare() -> list[Row]:
    """Passivity with K_imp = 1.25, B_imp = 0.35 and with K_imp = 3, B_imp = 0.25."""
    soft, stiff = (synthesize(load(FOLDER / f"haninger2016-{name}.yaml")) for name in ("paper", "stiff"))
    active = Fraction(witness(stiff.certificate, "eq12", "structured")["omega"])
    return [
        ("K_imp = 1.25: exit code, proven", soft.exit_code, 0),
        ("  Re(Z/jω) is nowhere below [N·m·s/rad]", margin(soft.certificate, "eq12", "structured"), 0.0997),
        ("K_imp = 3: exit code, refuted", stiff.exit_code, 4),
        ("  Re(Z/jω) < 0 for some load at [rad/s]", float(active), 51.3),
    ]


if __name__ == "__main__":
    show(compare())
