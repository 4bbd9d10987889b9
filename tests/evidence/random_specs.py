"""Random joints as canonical specifications: any actuator, uncertainty, filters and constraints the format knows."""

from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction
from random import Random
from typing import Any

from robimp.synthesis.certificate.claim import Claim
from robimp.synthesis.certificate.claims import certify
from robimp.synthesis.certificate.document import document
from robimp.synthesis.errors import InputError
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.recheck import recheck
from robimp.synthesis.spec import Spec, canonical, parse_spec
from robimp.synthesis.spec.model import Polynomials

Json = Any


def near(rng: Random, value: float, ratio: float = 3.0) -> str:
    return f"{value * ratio ** rng.uniform(-1, 1):.3g}"


def around(rng: Random, value: str) -> list[str]:
    v, spread = Fraction(value), Fraction(rng.choice([5, 20, 40, 60]), 100)
    return [str(v * (1 - spread)), str(v * (1 + spread))]


def _actuator(rng: Random) -> Json:
    return {"type": "ideal"} if rng.random() < 0.4 else _series_elastic(rng)


def _series_elastic(rng: Random) -> Json:
    return {
        "type": "series-elastic",
        "motor_inertia": near(rng, 0.01),
        "motor_damping": near(rng, 0.05),
        "spring_stiffness": near(rng, 4.8),
        "torque_loop": {
            "kp": near(rng, 10),
            "kd": near(rng, 0.25, 2),
            "derivative_corner": near(rng, 1000),
            "feedforward": rng.choice(["0", "1"]),
        },
    }


def _coefficients(rng: Random, kind: str) -> Json:
    corner, damping = Fraction(round(20 * 4 ** rng.uniform(-1, 1))), Fraction(rng.randint(40, 160), 100)
    gain, p = Fraction(rng.choice([75, 80, 85, 90, 100]), 100), Fraction(rng.randint(5, 60), 10)
    if kind == "dynamic-feedback":
        n, d = rng.choice([([p], [Fraction(1)]), ([p, p * corner / 4], [Fraction(1), corner / 40])])
    else:
        n, d = [gain * corner**2], [Fraction(1), damping * corner, corner**2]
        if rng.random() < 0.5:  # a lag and a zero more
            lag, zero = corner * rng.randint(2, 6), corner * rng.randint(1, 4)
            n = [n[0] * lag / zero, n[0] * lag]
            d = [a + lag * b for a, b in zip([*d, 0], [0, *d], strict=True)]
    return {"numerator": [str(c) for c in n], "denominator": [str(c) for c in d]}


def _constraints(rng: Random, both: bool) -> Json:
    forms = ["structured"] if both else ["structured", "structured", "disc", "paper"]
    eq12: Json = {"form": rng.choice(forms), "margin": rng.choice(["0", "0", "0.01"])}
    if eq12["form"] == "paper":
        del eq12["margin"]
    if eq12["form"] != "structured" or rng.random() < 0.2:
        eq12["band"] = [rng.choice(["0", near(rng, 1)]), near(rng, 30)]
    eq18 = {
        "form": rng.choice(["paper", "lumped", "half-plane", "half-plane"]),
        "coupling": rng.choice(["frozen", "physical"]),
    }
    asked: Json = {
        "eq9": rng.choice([None, {}]),
        "eq12": rng.choice([None, eq12, eq12]),
        "eq18": rng.choice([None, None, eq18]),
        "peak": rng.choice([None, "2", "3"]),
        "friction": rng.choice(["report", "report", "report", "require"]),
    }
    return {key: value for key, value in asked.items() if value is not None}


def random_spec(seed: int) -> Json:
    """A specification as a user would write it, with given coefficients."""
    rng = Random(seed)
    plant = {
        "inertia": near(rng, 0.03),
        "damping": near(rng, 0.2),
        "stiffness": rng.choice(["0", "0", near(rng, 1)]),
    }
    kind = rng.choice(["box", "weight", "both", "box"])
    box = {name: around(rng, value) for name, value in plant.items()}
    if plant["stiffness"] == "0" and rng.random() < 0.25:
        box["stiffness"] = ["0", near(rng, 0.5)]
    weight = {"numerator": [near(rng, 0.6), near(rng, 4)], "denominator": ["1", near(rng, 60)]}
    filters: Json = {
        "force": rng.choice([None, None, near(rng, 300)]),
        "position": rng.choice([None, None, "none", near(rng, 300)]),
        "derivative": rng.choice([None, None, near(rng, 1000)]),
    }
    type_ = rng.choice(["dob", "dob", "dynamic-feedback"])
    controller: Json = {"type": type_, "coefficients": _coefficients(rng, type_)}
    if any(filters.values()):
        controller["filters"] = {key: value for key, value in filters.items() if value is not None}
    error = rng.choice([None, None, None, "0.5"])
    return {
        "robimp": 1,
        "name": f"random-{seed}",
        "motion": "rotary",
        "plant": plant,
        "uncertainty": {
            **({} if kind == "weight" else {"box": box}),
            **({} if kind == "box" else {"weight": weight}),
        },
        "actuator": _actuator(rng),
        "impedance": {
            "inertia": rng.choice(["nominal", near(rng, 0.03)]),
            "damping": near(rng, 0.35),
            "stiffness": near(rng, 1.25),
        },
        "controller": controller,
        "objective": {
            "maximize": "bandwidth",
            "attenuation": rng.choice(["0.3", "0.5", "0.7"]),
            **({} if error is None else {"rendering_error": error}),
        },
        "constraints": _constraints(rng, kind == "both"),
    }


def _two_port(rng: Random, spec: Json) -> None:
    """A torque source with a resonance, and what a light motor adds to the port."""
    w = Fraction(rng.randint(200, 900))
    below = ["1", str(w / 2), str(w**2)]
    spec["uncertainty"].pop("actuator", None)
    spec["actuator"] = {
        "type": "two-port",
        "transfer": {"numerator": [str(w**2)], "denominator": below},
        "impedance": {"numerator": [near(rng, 0.5), "0"], "denominator": below},
    }


def _motor(rng: Random, spec: Json) -> None:
    if spec["actuator"]["type"] == "series-elastic":
        keys = rng.sample(["motor_inertia", "motor_damping", "spring_stiffness"], rng.randint(1, 3))
        spec["uncertainty"]["actuator"] = {key: around(rng, spec["actuator"][key]) for key in keys}


def _table(rng: Random, spec: Json) -> None:
    both = "box" in spec["uncertainty"]
    points = [[str(k * 10), near(rng, 0.05)] for k in range(rng.randint(1, 4))]
    if not both or spec["constraints"].get("eq12", {}).get("form", "structured") == "structured":
        spec["uncertainty"]["table"] = {"points": points, "beyond": "hold"}


def _impedances(rng: Random, spec: Json) -> None:
    for key in rng.sample(["damping", "stiffness"], rng.randint(1, 2)):
        value = Fraction(spec["impedance"][key])
        spec["impedance"][key] = [str(value * Fraction(9, 10)), str(value * Fraction(rng.randint(11, 20), 10))]


FEATURES: dict[str, Callable[[Random, Json], None]] = {
    "sampling": lambda rng, spec: spec.update(sampling={"rate": f"{rng.randint(1, 8) * 500} Hz", "delay": "0 s"}),
    "impedance ranges": _impedances,
    "uncertain actuator": _motor,
    "table": _table,
    "two-port": _two_port,
    "noise": lambda rng, spec: spec["constraints"].update(noise={"gain": near(rng, 20), "above": "200 rad/s"}),
    "tolerance": lambda rng, spec: spec["constraints"].update(tolerance="float32"),
}


def accepted() -> list[str]:
    """The features this version reads: those it does not are left out, not counted as faults."""
    found = []
    for name, add in FEATURES.items():
        spec = random_spec(2)
        spec["actuator"] = _series_elastic(Random(0))
        spec["constraints"].pop("eq12", None)
        add(Random(0), spec)
        try:
            parsed(spec)
        except InputError:
            continue
        found.append(name)
    return found


def extended_spec(seed: int, features: list[str]) -> Json:
    """A random joint with one or two of the features added."""
    rng, spec = Random(seed), random_spec(seed)
    for name in rng.sample(features, min(len(features), rng.randint(1, 2))):
        FEATURES[name](rng, spec)
    return spec


def parsed(spec: Json) -> Spec:
    """A specification in Python's own types, read as the text it would be written as (JSON is YAML)."""
    return parse_spec(json.dumps(spec).replace('"', ""))


def certified(spec: Spec) -> Json:
    """The certificate of a specification that gives its coefficients."""
    setting, coefficients = Setting.of(spec), spec.controller.coefficients
    assert coefficients is not None
    written = _written(setting, coefficients, certify(setting, setting.compensator(coefficients)))
    assert written["spec"] == canonical(spec)
    return json.loads(json.dumps(written))


def shipped(spec: Spec) -> Json:
    """The same with the margins that the checker could not confirm conceded, as `certify` ships it."""
    setting, coefficients = Setting.of(spec), spec.controller.coefficients
    assert coefficients is not None
    claims = certify(setting, setting.compensator(coefficients))
    _, written, *_ = recheck(setting, claims, lambda said: _written(setting, coefficients, said))
    return json.loads(json.dumps(written))


def _written(setting: Setting, coefficients: Polynomials, claims: tuple[Claim, ...]) -> Json:
    return document(setting, coefficients, claims, bound=None, producer={"robimp": "evidence"})
