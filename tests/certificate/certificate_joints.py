"""Specifications for the prover's tests: the reference joint, and random ones whose controllers are often stable."""

from __future__ import annotations

from fractions import Fraction
from random import Random
from typing import Any

from robimp.models.controller import Compensator
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.spec.model import Polynomials, Spec

Json = dict[str, Any]
PAPER_Q = (("2000",), ("1", "283/4", "2500"))  # (23) with α = 0.8, ω = 50
SERIES_ELASTIC: Json = {
    "type": "series-elastic",
    "motor_inertia": "0.01",
    "motor_damping": "0.05",
    "spring_stiffness": "4.8",
    "torque_loop": {"kp": "10", "kd": "0.25", "derivative_corner": "1000", "feedforward": "1"},
}
REFERENCE: Json = {
    "robimp": 1,
    "name": "joint",
    "motion": "rotary",
    "plant": {"inertia": "0.03", "damping": "0.2", "stiffness": "0"},
    "uncertainty": {
        "box": {"inertia": ("0.024", "0.036"), "damping": ("0.12", "0.28"), "stiffness": ("0", "0")},
        "weight": None,
    },
    "actuator": SERIES_ELASTIC,
    "impedance": {"inertia": "0.03", "damping": "0.35", "stiffness": "1.25"},
    "controller": {"type": "dob", "order": 4, "filters": {}},
    "objective": {"maximize": "bandwidth", "attenuation": "0.3", "rendering_error": None},
    "constraints": {
        "eq9": {},
        "eq12": {"form": "structured", "margin": "0"},
        "eq18": {"form": "half-plane", "coupling": "physical"},
        "peak": "2",
        "friction": "report",
    },
}
WORDS = {"type", "form", "coupling", "maximize", "name", "motion", "friction"}


def spec(**changes: Any) -> Spec:
    """The reference specification with keys of its sections replaced; None or another `actuator` replaces the whole."""
    tree: Json = dict(REFERENCE)
    for section, change in changes.items():
        whole = section == "actuator" or not isinstance(change, dict)
        tree[section] = change if whole else {**tree[section], **change}
    return Spec.model_validate(_exact(tree))


def _exact(value: Any, key: str = "") -> Any:
    """Number text as fractions."""
    if isinstance(value, dict):
        return {name: _exact(item, name) for name, item in value.items()}
    if isinstance(value, (tuple, list)):
        return tuple(_exact(item, key) for item in value)
    if isinstance(value, str) and key not in WORDS and value != "none":
        return Fraction(value)
    return value


def rational(numerator: Any, denominator: Any) -> Polynomials:
    """Coefficients in descending powers, from number text, integers or fractions."""
    return Polynomials(numerator=tuple(map(Fraction, numerator)), denominator=tuple(map(Fraction, denominator)))


def subject(spec: Spec, coefficients: Polynomials) -> tuple[Setting, Compensator]:
    """What `certify` takes."""
    setting = Setting.of(spec)
    return setting, setting.compensator(coefficients)


def reference(**changes: Any) -> tuple[Setting, Compensator]:
    """The reference joint with the paper's Q."""
    return subject(spec(**changes), rational(*PAPER_Q))


def random_case(seed: int) -> tuple[Spec, Polynomials]:
    """A joint and a controller for it: any actuator, uncertainty, filters and constraints a specification allows."""
    rng = Random(seed)

    def near(value: float, ratio: float = 3.0) -> str:
        return f"{value * ratio ** rng.uniform(-1, 1):.3g}"

    plant = {"inertia": near(0.03), "damping": near(0.2), "stiffness": rng.choice(["0", "0", near(1)])}
    kind = rng.choice(["box", "weight", "both", "box"])
    box = {name: _around(rng, value) for name, value in plant.items()}
    if plant["stiffness"] == "0" and rng.random() < 0.25:
        box["stiffness"] = ("0", near(0.5))
    weight = {"numerator": (near(0.6), near(4)), "denominator": ("1", near(60))}
    ideal = rng.random() < 0.4
    actuator: Json = {"type": "ideal"}
    if not ideal:
        loop = {
            "kp": near(10),
            "kd": near(0.25, 2),
            "derivative_corner": near(1000),
            "feedforward": rng.choice(["0", "1"]),
        }
        actuator = {
            "type": "series-elastic",
            "motor_inertia": near(0.01),
            "motor_damping": near(0.05),
            "spring_stiffness": near(4.8),
            "torque_loop": loop,
        }
    filters = {
        "force": rng.choice([None, None, near(300)]),
        "position": rng.choice([None, None, "none", near(300)]),
        "derivative": rng.choice([None, None, near(1000)]),
    }
    forms = ["structured"] if kind == "both" else ["structured", "structured", "disc", "paper"]
    eq12: Json = {"form": rng.choice(forms), "margin": rng.choice(["0", "0", "0.01"])}
    if eq12["form"] != "structured" or rng.random() < 0.2:
        eq12["band"] = (rng.choice(["0", near(1)]), near(30))
    type_ = rng.choice(["dob", "dob", "dynamic-feedback"])
    eq18 = {
        "form": rng.choice(["paper", "lumped", "half-plane", "half-plane"]),
        "coupling": rng.choice(["frozen", "physical"]),
    }
    return (
        spec(
            plant=plant,
            uncertainty={"box": None if kind == "weight" else box, "weight": None if kind == "box" else weight},
            actuator=actuator,
            impedance={
                "inertia": rng.choice([plant["inertia"], near(0.03)]),
                "damping": near(0.35),
                "stiffness": near(1.25),
            },
            controller={"type": type_, "filters": filters},
            objective={
                "attenuation": rng.choice(["0.3", "0.5", "0.7"]),
                "rendering_error": rng.choice([None, None, None, "0.5"]),
            },
            constraints={
                "eq9": rng.choice([None, {}]),
                "eq12": rng.choice([None, eq12, eq12]),
                "eq18": rng.choice([None, None, eq18]),
                "peak": rng.choice([None, "2", "3"]),
                "friction": rng.choice(["report", "report", "report", "require"]),
            },
        ),
        _controller(rng, type_),
    )


def _around(rng: Random, value: str) -> tuple[str, str]:
    v, spread = Fraction(value), Fraction(rng.choice([5, 20, 40, 60]), 100)
    return str(v * (1 - spread)), str(v * (1 + spread))


def _controller(rng: Random, kind: str) -> Polynomials:
    corner, damping = Fraction(round(20 * 4 ** rng.uniform(-1, 1))), Fraction(rng.randint(40, 160), 100)
    gain = Fraction(rng.choice([75, 80, 85, 90, 100]), 100)
    if kind == "dynamic-feedback":
        proportional = Fraction(rng.randint(5, 60), 10)
        return rng.choice(
            [rational([proportional], [1]), rational([proportional, proportional * corner / 4], [1, corner / 40])]
        )
    numerator, denominator = [gain * corner**2], [Fraction(1), damping * corner, corner**2]
    if rng.random() < 0.5:  # an order more: a lag and a zero, relative degree 2
        lag, zero = corner * rng.randint(2, 6), corner * rng.randint(1, 4)
        numerator = [numerator[0] * lag / zero, numerator[0] * lag]
        denominator = [a + lag * b for a, b in zip([*denominator, 0], [0, *denominator], strict=True)]
    return rational(numerator, denominator)
