"""The specification format as a JSON Schema, for editors: names, ranges, units; `load_spec` has the last word."""

from __future__ import annotations

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
from .units import FREQUENCY, RATIO, TIME


def json_schema() -> Schema:
    """JSON Schema (2020-12) of a specification file, format version 1."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "robimp specification, format 1",
        **section(
            "One robot joint, its uncertainty, the impedance it should render, and what must be proven.",
            {
                "robimp": {"const": 1, "description": "format version"},
                "name": {
                    "type": ["string", "integer"],
                    "pattern": "^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$",
                    "description": "names the output folder",
                },
                "motion": words("a rotary joint (N·m, rad) or a linear one (N, m)", "rotary", "linear"),
                "plant": _plant(),
                "uncertainty": _uncertainty(),
                "actuator": _actuator(),
                "impedance": _impedance(),
                "controller": _controller(),
                "objective": _objective(),
                "constraints": _constraints(),
            },
        ),
    }


def _plant() -> Schema:
    return section(
        "nominal load, (1): I θ'' + B θ' + K θ = τ_int + τ_act",
        {
            "inertia": positive("nominal I > 0", *mechanical("inertia")),
            "damping": non_negative("nominal B ≥ 0", *mechanical("damping")),
            "stiffness": non_negative("nominal K ≥ 0", *mechanical("stiffness")),
        },
    )


def _uncertainty() -> Schema:
    def side(key: str) -> Schema:
        tolerance = {"type": "string", "pattern": r"^\s*(±|\+-|\+/-).*%\s*$"}
        both = pair("", *mechanical(key))
        text = f'"±20 %" of the nominal {key}, or [low, high] around it; [v, v] if it is exact'
        return {"anyOf": [tolerance, both], "description": text}

    box = section("intervals that hold the true load", {key: side(key) for key in ("inertia", "damping", "stiffness")})
    whole = section(
        "how far the true load may be from the nominal one; none has a default",
        {},
        {"box": box, "weight": polynomials("|Δ(jω)| ≤ |W(jω)|, on top of the box if there is one")},
    )
    return {**whole, "minProperties": 1}


def _actuator() -> Schema:
    loop = section(
        "τ_m = λ τ_d + C_t (τ_d − τ_sea), C_t = kp + kd s/(1 + s/derivative_corner)",
        {
            "kp": non_negative("proportional gain"),
            "kd": non_negative("derivative gain", TIME),
            "derivative_corner": positive("corner of the derivative's filter", FREQUENCY),
            "feedforward": non_negative("λ"),
        },
    )
    elastic = {
        "type": {"const": "series-elastic"},
        "motor_inertia": positive("J > 0, seen from the output", *mechanical("inertia")),
        "motor_damping": non_negative("b_m ≥ 0", *mechanical("damping")),
        "spring_stiffness": positive("K_sp > 0", *mechanical("stiffness")),
        "torque_loop": loop,
    }
    ideal = section("τ_act = τ_d", {"type": {"const": "ideal"}})
    return {"oneOf": [ideal, section("motor behind a spring, (13)-(15)", elastic)], "description": "the actuator"}


def _impedance() -> Schema:
    inertia = positive("", *mechanical("inertia"))
    return section(
        "what the port should feel like: G_imp = I s² + B s + K",
        {
            "inertia": {"anyOf": [{"const": "nominal"}, inertia], "description": "`nominal`: the load's own; or I > 0"},
            "damping": non_negative("B ≥ 0", *mechanical("damping")),
            "stiffness": non_negative("K ≥ 0", *mechanical("stiffness")),
        },
    )


def _controller() -> Schema:
    corner = positive("", FREQUENCY)
    filters = section(
        "first-order sensor filters 1/(1 + s/corner); absent: unfiltered",
        {},
        {
            "force": {**corner, "description": f"corner of F on τ_int; {units(FREQUENCY)}"},
            "position": {"anyOf": [{"const": "none"}, corner], "description": "F on θ; absent: the same as force"},
            "derivative": {**corner, "description": f"corner of F_d, (20); {units(FREQUENCY)}"},
        },
    )
    choices: Schema = {
        "order": {"type": "integer", "minimum": 0, "maximum": 8, "description": "of Q (2 to 8) or C_imp (0 or 1)"},
        "form": words("the paper's (23), for type: dob", "eq23"),
        "coefficients": polynomials("a given Q or C_imp to certify"),
    }
    whole = section(
        "the controller; exactly one of order, form, coefficients",
        {"type": words("disturbance observer, or feedback of the dynamic error", "dob", "dynamic-feedback")},
        {**choices, "filters": filters},
    )
    return {**whole, "oneOf": [{"required": [key]} for key in choices]}


def _objective() -> Schema:
    attenuation = {**positive("|1 − Q̃| ≤ attenuation on [0, ω_B]", RATIO), "exclusiveMaximum": 1}
    return section(
        "largest ω_B",
        {"maximize": {"const": "bandwidth", "description": "the bandwidth ω_B"}, "attenuation": attenuation},
        {"rendering_error": positive("|Z − G_imp| ≤ this·|G_imp| on [0, ω_B] for every load", RATIO)},
    )


def _constraints() -> Schema:
    margin = non_negative("least damping left, at every ω", *mechanical("damping"))
    band = pair("[low, high]; absent: the whole axis", FREQUENCY)
    form12 = words("corrected (12), exact over the disc, or the box's vertices", "paper", "disc", "structured")
    form18 = words("as printed, scaled, or exact over the disc", "paper", "lumped", "half-plane")
    coupling = words("A_cl with the nominal load, as printed, or with the true one", "frozen", "physical")
    return section(
        "what must be proven besides nominal stability and the bandwidth",
        {},
        {
            "eq9": section("robust stability (9)", {}),
            "eq12": section("passivity (12)", {"form": form12}, {"band": band, "margin": margin}),
            "eq18": section("robust stability with actuator dynamics (18)", {"form": form18, "coupling": coupling}),
            "peak": {**number("|1 − Q̃| ≤ peak, at every ω", RATIO), "exclusiveMinimum": 1},
            "friction": words("no limit cycle from Coulomb friction; absent: report", "report", "require"),
        },
    )
