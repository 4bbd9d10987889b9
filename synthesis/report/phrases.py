"""What the margin of a claim says, by the claim's form."""

from __future__ import annotations

from decimal import ROUND_CEILING, ROUND_FLOOR

UNIT = {
    "hurwitz": "decay ≥ {} /s",
    "winding": "stable",
    "box": "{} × the box is stable",
    "command": "gain ≤ {}",
    "coefficients": "± {} of each",
    "structured": "{} N·m·s/rad to spare",
    "disc": "{} N·m·s/rad to spare",
    "strictly-positive-real": "{} N·m·s/rad to spare",
    "attenuation": "ω_B ≥ {} rad/s",
    "sensitivity": "peak ≤ {}",
    "every-load": "error ≤ {}",
}


def margin_phrase(form: str, motion: str) -> tuple[str, str]:
    """What a margin of this form says, `{}` for its value, and how to round that so that what is said stays proven."""
    phrase = UNIT.get(form, "holds for {} × W")
    if motion == "linear":
        phrase = phrase.replace("N·m·s/rad", "N·s/m")
    return phrase, ROUND_CEILING if "≤" in phrase else ROUND_FLOOR
