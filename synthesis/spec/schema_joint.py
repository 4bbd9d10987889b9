"""The JSON Schema of the physical half: plant, uncertainty, actuator, sampling, impedance."""

from __future__ import annotations

from collections.abc import Callable

from .exact import NUMBER
from .schema_terms import (
    TOLERANCE,
    Schema,
    mechanical,
    non_negative,
    pair,
    polynomials,
    positive,
    section,
    tolerance,
    units,
)
from .table import MAX_ROWS
from .units import FREQUENCY, RATE, RATIO, TIME

_KINDS = ("inertia", "damping", "stiffness")


def plant() -> Schema:
    """The nominal load."""
    return section(
        "nominal load, (1): I θ'' + B θ' + K θ = τ_int + τ_act",
        {
            "inertia": positive("nominal I > 0", *mechanical("inertia")),
            "damping": non_negative("nominal B ≥ 0", *mechanical("damping")),
            "stiffness": non_negative("nominal K ≥ 0", *mechanical("stiffness")),
        },
    )


def uncertainty() -> Schema:
    """What is not known of load and actuator."""
    box = section("intervals that hold the true load", {key: _around(key, key) for key in _KINDS})
    motor = {"motor_inertia": "inertia", "motor_damping": "damping", "spring_stiffness": "stiffness"}
    sprung = section("intervals of a series-elastic actuator", {}, {key: _around(key, motor[key]) for key in motor})
    whole = section(
        "how far the true joint may be from the nominal one; none has a default",
        {},
        {
            "box": box,
            "weight": polynomials("|Δ(jω)| ≤ |W(jω)|, on top of the box if there is one"),
            "actuator": {**sprung, "minProperties": 1},
            "table": _table(),
            "measured": _measured(),
        },
    )
    return {**whole, "anyOf": [{"required": [key]} for key in ("box", "weight", "table", "measured")]}


def _around(key: str, kind: str) -> Schema:
    text = f'"±20 %" of the nominal {key}, or [low, high] around it; [v, v] if it is exact'
    return {"anyOf": [tolerance(), pair("", *mechanical(kind))], "description": text}


def _table() -> Schema:
    beyond = {"const": "hold", "description": "outside, the first and the last bound hold; has no default"}
    point: Schema = {
        "type": "array",
        "prefixItems": [non_negative("", FREQUENCY), non_negative("", RATIO)],
        "items": False,
        "minItems": 2,
    }
    whole = f"[frequency, bound], frequencies increasing; {units(FREQUENCY)}"
    points = {"type": "array", "items": point, "minItems": 1, "maxItems": MAX_ROWS, "description": whole}
    text = "CSV file in this folder, two columns, with a heading such as `frequency [Hz],bound`; without one, rad/s"
    file = {"type": "string", "minLength": 1, "description": text}
    given = [
        section("by a file", {"file": file, "beyond": beyond}),
        section("here", {"points": points, "beyond": beyond}, {"measured": _origin()}),
    ]
    return {"oneOf": given, "description": "|Δ(jω)| ≤ W(ω), linear in ω between points; on top of box and weight"}


def _origin() -> Schema:
    digest = section(
        "a file",
        {
            "name": {"type": "string", "description": "in the specification's folder"},
            "sha256": {"type": "string", "pattern": "^[0-9a-f]{64}$", "description": "of its bytes"},
        },
    )
    names = {"type": "array", "items": {"type": "string"}, "description": "records left out"}
    return section(
        "the measured responses these points came from",
        {
            "files": {"type": "array", "items": digest, "minItems": 1, "description": "their files"},
            "records": {"type": ["integer", "string"], "description": "how many were kept"},
            "excluded": names,
        },
        {"amplitude": pair("range of the amplitudes that were kept")},
    )


def _measured() -> Schema:
    name: Schema = {"type": "string", "minLength": 1}
    amplitude = pair("amplitudes of the excitation, in the files' unit; records outside are left out")
    ends: Schema = {"type": "array", "items": non_negative("", RATIO), "minItems": 2, "maxItems": 2}
    text = "outside the measured band: the deviations at its ends, or [below, above]; has no default"
    return section(
        "measured responses of the load; become a table: the largest deviation from the nominal load at each frequency",
        {
            "files": {
                "anyOf": [name, {"type": "array", "items": name, "minItems": 1}],
                "description": "such as frf/*.csv",
            },
            "beyond": {"anyOf": [{"const": "hold"}, ends], "description": text},
        },
        {
            "amplitude": amplitude,
            "exclude": {"anyOf": [name, {"type": "array", "items": name}], "description": "records to leave out"},
        },
    )


def actuator() -> Schema:
    """One of the actuators."""
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
    given = {
        "type": {"const": "two-port"},
        "transfer": polynomials("H, from torque command to torque"),
        "impedance": polynomials("Z_a, what a locked command leaves at the port; [0] if nothing"),
    }
    choices = [
        section("τ_act = τ_d", {"type": {"const": "ideal"}}),
        section("motor behind a spring, (13)-(15)", elastic),
        section("τ_act = H τ_d − Z_a θ", given),
    ]
    return {"oneOf": choices, "description": "the actuator"}


def sampling() -> Schema:
    """Hold and delay."""
    return section(
        "zero-order hold and computation delay between torque command and torque; absent: continuous time",
        {"rate": positive("samples per second", RATE), "delay": non_negative("0 if there is none", TIME)},
    )


def impedance() -> Schema:
    """The desired impedance, or a range of them."""
    nominal = {"type": "string", "pattern": rf"^\s*(nominal|(nominal)?\s*{TOLERANCE})\s*$"}
    return section(
        "what the port should feel like: G_imp = I s² + B s + K; an interval: one controller for the whole range",
        {
            "inertia": _desired("`nominal`: the load's own, also with ±; or I > 0", positive, "inertia", nominal),
            "damping": _desired("B ≥ 0", non_negative, "damping"),
            "stiffness": _desired("K ≥ 0", non_negative, "stiffness"),
        },
    )


def _desired(description: str, side: Callable[..., Schema], key: str, *others: Schema) -> Schema:
    one, both = side("", *mechanical(key)), pair("", *mechanical(key))
    text = f"{description}; or with ±20 % behind it; or [low, high]; {units(*mechanical(key))}"
    return {"anyOf": [*others, one, tolerance(NUMBER + r"[^±]*?"), both], "description": text}
