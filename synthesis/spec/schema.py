"""The specification format as a JSON Schema, for editors: names, ranges, units; `load_spec` has the last word."""

from __future__ import annotations

from typing import Any, TypeAlias

from .exact import NUMBER
from .fields import MAX_DEGREE
from .units import FREQUENCY, MECHANICS, RATIO, TIME, Dimension

Schema: TypeAlias = dict[str, Any]

_QUANTITY = rf"^\s*{NUMBER}\s*([^\s0-9.+-].*)?$"


def json_schema() -> Schema:
    """JSON Schema (2020-12) of a specification file, format version 1."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "robimp specification, format 1",
        **_section(
            "One robot joint, its uncertainty, the impedance it should render, and what must be proven.",
            {
                "robimp": {"const": 1, "description": "format version"},
                "name": {
                    "type": ["string", "integer"],
                    "pattern": "^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$",
                    "description": "names the output folder",
                },
                "motion": _words("a rotary joint (N·m, rad) or a linear one (N, m)", "rotary", "linear"),
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
    return _section(
        "nominal load, (1): I θ'' + B θ' + K θ = τ_int + τ_act",
        {
            "inertia": _positive("nominal I > 0", *_mechanical("inertia")),
            "damping": _non_negative("nominal B ≥ 0", *_mechanical("damping")),
            "stiffness": _non_negative("nominal K ≥ 0", *_mechanical("stiffness")),
        },
    )


def _uncertainty() -> Schema:
    def side(key: str) -> Schema:
        tolerance = {"type": "string", "pattern": r"^\s*(±|\+-|\+/-).*%\s*$"}
        both = _pair("", *_mechanical(key))
        text = f'"±20 %" of the nominal {key}, or [low, high] around it; [v, v] if it is exact'
        return {"anyOf": [tolerance, both], "description": text}

    box = _section("intervals that hold the true load", {key: side(key) for key in ("inertia", "damping", "stiffness")})
    section = _section(
        "how far the true load may be from the nominal one; none has a default",
        {},
        {"box": box, "weight": _polynomials("|Δ(jω)| ≤ |W(jω)|, on top of the box if there is one")},
    )
    return {**section, "minProperties": 1}


def _actuator() -> Schema:
    loop = _section(
        "τ_m = λ τ_d + C_t (τ_d − τ_sea), C_t = kp + kd s/(1 + s/derivative_corner)",
        {
            "kp": _non_negative("proportional gain"),
            "kd": _non_negative("derivative gain", TIME),
            "derivative_corner": _positive("corner of the derivative's filter", FREQUENCY),
            "feedforward": _non_negative("λ"),
        },
    )
    elastic = {
        "type": {"const": "series-elastic"},
        "motor_inertia": _positive("J > 0, seen from the output", *_mechanical("inertia")),
        "motor_damping": _non_negative("b_m ≥ 0", *_mechanical("damping")),
        "spring_stiffness": _positive("K_sp > 0", *_mechanical("stiffness")),
        "torque_loop": loop,
    }
    ideal = _section("τ_act = τ_d", {"type": {"const": "ideal"}})
    return {"oneOf": [ideal, _section("motor behind a spring, (13)-(15)", elastic)], "description": "the actuator"}


def _impedance() -> Schema:
    inertia = _positive("", *_mechanical("inertia"))
    return _section(
        "what the port should feel like: G_imp = I s² + B s + K",
        {
            "inertia": {"anyOf": [{"const": "nominal"}, inertia], "description": "`nominal`: the load's own; or I > 0"},
            "damping": _non_negative("B ≥ 0", *_mechanical("damping")),
            "stiffness": _non_negative("K ≥ 0", *_mechanical("stiffness")),
        },
    )


def _controller() -> Schema:
    corner = _positive("", FREQUENCY)
    filters = _section(
        "first-order sensor filters 1/(1 + s/corner); absent: unfiltered",
        {},
        {
            "force": {**corner, "description": f"corner of F on τ_int; {_units(FREQUENCY)}"},
            "position": {"anyOf": [{"const": "none"}, corner], "description": "F on θ; absent: the same as force"},
            "derivative": {**corner, "description": f"corner of F_d, (20); {_units(FREQUENCY)}"},
        },
    )
    choices: Schema = {
        "order": {"type": "integer", "minimum": 0, "maximum": 8, "description": "of Q (2 to 8) or C_imp (0 or 1)"},
        "form": _words("the paper's (23), for type: dob", "eq23"),
        "coefficients": _polynomials("a given Q or C_imp to certify"),
    }
    section = _section(
        "the controller; exactly one of order, form, coefficients",
        {"type": _words("disturbance observer, or feedback of the dynamic error", "dob", "dynamic-feedback")},
        {**choices, "filters": filters},
    )
    return {**section, "oneOf": [{"required": [key]} for key in choices]}


def _objective() -> Schema:
    attenuation = {**_positive("|1 − Q̃| ≤ attenuation on [0, ω_B]", RATIO), "exclusiveMaximum": 1}
    return _section(
        "largest ω_B",
        {"maximize": {"const": "bandwidth", "description": "the bandwidth ω_B"}, "attenuation": attenuation},
        {"rendering_error": _positive("|Z − G_imp| ≤ this·|G_imp| on [0, ω_B] for every load", RATIO)},
    )


def _constraints() -> Schema:
    margin = _non_negative("least damping left, at every ω", *_mechanical("damping"))
    band = _pair("[low, high]; absent: the whole axis", FREQUENCY)
    form12 = _words("corrected (12), exact over the disc, or the box's vertices", "paper", "disc", "structured")
    form18 = _words("as printed, scaled, or exact over the disc", "paper", "lumped", "half-plane")
    coupling = _words("A_cl with the nominal load, as printed, or with the true one", "frozen", "physical")
    return _section(
        "what must be proven besides nominal stability and the bandwidth",
        {},
        {
            "eq9": _section("robust stability (9)", {}),
            "eq12": _section("passivity (12)", {"form": form12}, {"band": band, "margin": margin}),
            "eq18": _section("robust stability with actuator dynamics (18)", {"form": form18, "coupling": coupling}),
            "peak": {**_number("|1 − Q̃| ≤ peak, at every ω", RATIO), "exclusiveMinimum": 1},
            "friction": _words("no limit cycle from Coulomb friction; absent: report", "report", "require"),
        },
    )


def _section(description: str, required: Schema, optional: Schema | None = None) -> Schema:
    return {
        "type": "object",
        "description": description,
        "properties": {**required, **(optional or {})},
        "required": list(required),
        "additionalProperties": False,
    }


def _words(description: str, *words: str) -> Schema:
    return {"enum": list(words), "description": description}


def _mechanical(key: str) -> tuple[Dimension, ...]:
    return tuple(getattr(mechanics, key) for mechanics in MECHANICS.values())


def _units(*dimensions: Dimension) -> str:
    return "a bare number is SI, or with a unit: " + " | ".join(dimension.accepted for dimension in dimensions)


def _number(description: str, *dimensions: Dimension) -> Schema:
    text = "; ".join(part for part in (description, _units(*dimensions) if dimensions else "") if part)
    return {"type": ["number", "string"], "pattern": _QUANTITY, "description": text}


def _positive(description: str, *dimensions: Dimension) -> Schema:
    return {**_number(description, *dimensions), "exclusiveMinimum": 0}


def _non_negative(description: str, *dimensions: Dimension) -> Schema:
    return {**_number(description, *dimensions), "minimum": 0}


def _pair(description: str, *dimensions: Dimension) -> Schema:
    item = _non_negative("", *dimensions)
    return {"type": "array", "items": item, "minItems": 2, "maxItems": 2, "description": description}


def _polynomials(description: str) -> Schema:
    powers = "coefficients in descending powers of s (rad/s)"
    both = {"type": "array", "items": _number(""), "minItems": 1, "maxItems": MAX_DEGREE + 1, "description": powers}
    return _section(description, {"numerator": both, "denominator": both})
