"""The JSON Schema of the other half: controller, objective, constraints."""

from __future__ import annotations

from .model import FORMS, FREE
from .schema_terms import (
    Schema,
    mechanical,
    non_negative,
    number,
    pair,
    polynomials,
    positive,
    section,
    units,
    words,
)
from .units import FREQUENCY, RATIO


def controller() -> Schema:
    """The controller."""
    corner = positive("", FREQUENCY)
    filters = section(
        "first-order sensor filters 1/(1 + s/corner); absent: unfiltered",
        {},
        {
            "force": {
                "anyOf": [{"const": FREE}, corner],
                "description": f"corner of F on τ_int; free: found with the controller; {units(FREQUENCY)}",
            },
            "position": {"anyOf": [{"const": "none"}, corner], "description": "F on θ; absent: the same as force"},
            "derivative": {**corner, "description": f"corner of F_d, (20); {units(FREQUENCY)}"},
        },
    )
    choices: Schema = {
        "order": {"type": "integer", "minimum": 0, "maximum": 8, "description": "of Q (2 to 8) or C_imp (0 to 8)"},
        "form": words(
            "type dob: the paper's (23); dynamic-feedback: k, k(1+ω_i/s), k(1+s/ω_z)/(1+s/ω_p), "
            "k(1+ω_i/s)(1+s/ω_z)/(1+s/ω_p), and each times 1/(1+s/ω_f), a sensor filter with a free corner",
            *(form for forms in FORMS.values() for form in forms),
        ),
        "coefficients": polynomials("a given Q or C_imp to certify"),
    }
    whole = section(
        "the controller; exactly one of order, form, coefficients",
        {"type": words("disturbance observer, or feedback of the dynamic error", "dob", "dynamic-feedback")},
        {**choices, "filters": filters},
    )
    return {**whole, "oneOf": [{"required": [key]} for key in choices]}


def objective() -> Schema:
    """What is maximised."""
    attenuation = {**positive("|1 − Q̃| ≤ attenuation on [0, ω_B]", RATIO), "exclusiveMaximum": 1}
    return section(
        "largest ω_B",
        {"maximize": {"const": "bandwidth", "description": "the bandwidth ω_B"}, "attenuation": attenuation},
        {"rendering_error": positive("|Z − G_imp| ≤ this·|G_imp| on [0, ω_B] for every load", RATIO)},
    )


def constraints() -> Schema:
    """What must be proven."""
    margin = non_negative("least damping left, at every ω", *mechanical("damping"))
    band = pair("[low, high]; absent: the whole axis", FREQUENCY)
    form12 = words("corrected (12), exact over the disc, or the box's vertices", "paper", "disc", "structured")
    form18 = words("as printed, scaled, or exact over the disc", "paper", "lumped", "half-plane")
    part = {**positive("", RATIO), "exclusiveMaximum": 1}
    text = "all still holds if each coefficient is wrong by this part of itself; float32: by rounding to it, 2^-24"
    coupling = words("A_cl with the nominal load, as printed, or with the true one", "frozen", "physical")
    return section(
        "what must be proven besides nominal stability and the bandwidth",
        {},
        {
            "eq9": section("robust stability (9)", {}),
            "eq12": section("passivity (12)", {"form": form12}, {"band": band, "margin": margin}),
            "eq18": section("robust stability with actuator dynamics (18)", {"form": form18, "coupling": coupling}),
            "peak": {**number("|1 − Q̃| ≤ peak, at every ω", RATIO), "exclusiveMinimum": 1},
            "noise": section(
                "torque command per torque-sensor noise, output locked",
                {"gain": positive("|C F/(1 + H C F)| ≤ gain", RATIO)},
                {"above": non_negative("at every ω from here on; absent: from 0", FREQUENCY)},
            ),
            "tolerance": {"anyOf": [{"const": "float32"}, part], "description": text},
            "friction": words("no limit cycle from Coulomb friction; absent: report", "report", "require"),
        },
    )
