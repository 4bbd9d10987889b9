"""The files of an export: C99, JSON, a Python module of `control` objects, parameters in the style of ros2_control."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from hashlib import sha256
from importlib.resources import files
from math import inf
from typing import Any

import numpy as np
from flint import fmpq
from jinja2 import Environment, FunctionLoader, StrictUndefined

from ...models.impedance import DynamicStiffness
from ...models.rational import exact, fraction, to_float
from ..errors import InputError
from ..problem.setting import LOAD, Setting
from ..spec import number_text
from .carried import Carried, lost, verdict
from .law import Law
from .motion import Motion
from .naming import identifier, remark
from .sections import DTYPE

LAW = (
    "tau_d = C (F M tau_int - F_theta (I A + B V + K M) theta) + F_d (dI A_d + dB V_d + dK M_d) theta; "
    "dI, dB, dK: nominal minus desired; q = z^-1, r of error (of compensated for M_d, V_d, A_d): M = ((1 + q)/2)^r, "
    "V = velocity (1 - q) times 3 - q, 1, 1 + q for r = 0, 1, 2, A = acceleration (1 - q)^2"
)


@dataclass(frozen=True)
class Subject:
    """What is written, whatever the target. assumed_hold: the certificate is about the continuous controller."""

    setting: Setting
    law: Law
    carried: tuple[Carried, ...]
    certificate: str
    spec_sha256: str
    assumed_hold: bool
    version: str

    @property
    def name(self) -> str:
        """The specification's."""
        return self.setting.spec.name

    @property
    def verdict(self) -> str:
        """First of all in every file: whether every required claim holds, and what is lost."""
        return f"{verdict(self.carried)}, at {float(self.law.rate):g} Hz"

    @property
    def identifier(self) -> str:
        """The same as an identifier of C and of Python."""
        return identifier(self.name)

    @property
    def remark(self) -> str:
        """The same within comments and messages."""
        return remark(self.name)

    @property
    def delay(self) -> Fraction:
        """Computation delay [s] that was proven with."""
        hold = self.setting.loop.actuator.hold
        assert hold is not None
        return fraction(hold.delay)

    @property
    def timing(self) -> str:
        """What is assumed about time, in words."""
        if self.assumed_hold:
            return "assumed, as the specification has no sampling: a hold and no computation delay"
        return f"sampling of the specification: a hold and {float(self.delay):g} s of computation delay"


def demand_rate(target: str, rate: Fraction) -> None:
    """Refuse a rate [Hz] that a target cannot say exactly. Raises: InputError."""
    if target == "c" and (rate * 1000).denominator != 1:
        raise InputError(f"--target c: the rate must be a whole number of mHz; found {float(rate)} Hz")
    if target == "ros2" and rate.denominator != 1:
        raise InputError(f"--target ros2: update_rate is a whole number of Hz; found {float(rate)} Hz")


def files_of(subject: Subject, target: str) -> dict[str, str]:
    """Text of every file by its name."""
    return {**TARGETS[target](subject), "export.json": _json_text(subject)}


def _c(subject: Subject) -> dict[str, str]:
    law, spec, p = subject.law, subject.setting.spec, subject.identifier
    literal, decimal = _literal(law.precision), _decimal(law.precision)
    filters = [
        {"name": name, "sections": [[literal(b) for b in (s.b0, s.b1, s.b2, s.a1, s.a2)] for s in cascade.sections]}
        for name, cascade in law.filters.items()
        if cascade.sections
    ]
    ranges = subject.setting.impedances
    torque, angle = ("N*m", "rad") if spec.motion == "rotary" else ("N", "m")
    words: dict[str, Any] = {
        "name": subject.remark,
        "stamp": sha256(_json_text(subject).encode()).hexdigest()[:8],
        "p": p,
        "P": p.upper(),
        "rate": f"{float(law.rate):.17g}",
        "rate_double": float(law.rate).hex(),
        "error": _motion(law.error, literal),
        "compensated": _motion(law.compensated, literal),
        "means": {law.error.r, law.compensated.r},
        "half": literal(0.5),
        "quarter": literal(0.25),
        "millihertz": int(law.rate * 1000),
        "precision": law.precision,
        "version": subject.version,
        "certificate": subject.certificate,
        "spec_sha256": subject.spec_sha256,
        "prewarp": f"{law.prewarp:.6g}",
        "timing": subject.timing,
        "delay": f"{float(subject.delay):g}" if subject.delay else "",
        "verdict": _ascii(subject.verdict),
        "lost": bool(lost(subject.carried)),
        "claims": [_ascii(each.line).replace("*/", "") for each in subject.carried],
        "filters": filters,
        "has": {name: len(cascade.sections) for name, cascade in law.filters.items()},
        "settles": bool(law.compensator.sections) and len(filters) > 1,
        "nominal": _stiffness(law.nominal, literal),
        "desired": _stiffness(law.desired, literal),
        "back_calculation": literal(to_float(law.back_calculation)),
        "ranges": {name: [decimal(end) for end in inward(*ends[:2], law.precision)] for name, ends in ranges.items()},
        "ranges_text": ", ".join(f"{k} {to_float(v[0]):g} to {to_float(v[1]):g}" for k, v in ranges.items()),
        "fixed": [(k, i) for i, k in enumerate(LOAD) if k not in ranges],
        "torque": torque,
        "angle": angle,
    }
    return {f"{p}.{end}": _rendered(f"controller.{end}.j2", words) for end in ("h", "c")}


def _ascii(text: str) -> str:
    """For compilers and consoles that read no more."""
    return text.replace("ω", "omega").replace("≥", ">=")


def _stiffness(g: DynamicStiffness, literal: Callable[[float], str]) -> list[str]:
    return [literal(to_float(getattr(g, name))) for name in LOAD]


def _motion(motion: Motion, literal: Callable[[float], str]) -> dict[str, Any]:
    values = {name: literal(to_float(getattr(motion, name))) for name in ("velocity", "acceleration")}
    return {"r": motion.r, **values}


def _literal(precision: str) -> Callable[[float], str]:
    """A number of C to the last bit."""
    suffix = "f" if precision == "float" else ""
    return lambda value: float(DTYPE[precision](value)).hex() + suffix


def _decimal(precision: str) -> Callable[[float], str]:
    """The same where C++ reads it, too, in as many digits as tell it from its neighbours."""
    digits, suffix = (8, "f") if precision == "float" else (16, "")
    return lambda value: f"{value:.{digits}e}{suffix}"


def inward(low: fmpq, high: fmpq, precision: str) -> tuple[float, float]:
    """The smallest and the largest number of the code's arithmetic within a certified range."""
    to = DTYPE[precision]
    least, most = to(to_float(low)), to(to_float(high))
    least = least if exact(float(least)) >= low else np.nextafter(least, to(inf))
    most = most if exact(float(most)) <= high else np.nextafter(most, to(-inf))
    return float(least), float(most)


def _rendered(template: str, words: dict[str, Any]) -> str:
    def source(name: str) -> str:
        return files(__package__).joinpath(name).read_text(encoding="utf-8")

    environment = Environment(
        loader=FunctionLoader(source),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    return environment.get_template(template).render(words)


def _json_text(subject: Subject) -> str:
    return json.dumps(document(subject), indent=1, ensure_ascii=False) + "\n"


def document(subject: Subject) -> dict[str, Any]:
    """`export.json`: the law, every number as the text that stands for it exactly, and the claims."""
    law = subject.law
    return {
        "verdict": subject.verdict,
        "robimp_export": 1,
        "name": subject.name,
        "certificate": subject.certificate,
        "spec_sha256": subject.spec_sha256,
        "robimp": subject.version,
        "rate": number_text(law.rate),
        "delay": number_text(subject.delay),
        "timing": subject.timing,
        "precision": law.precision,
        "form": "direct form II transposed; b0, b1, b2, a1, a2 of each section; doubles of 17 digits",
        "law": LAW,
        "error": _motion(law.error, repr),
        "compensated": _motion(law.compensated, repr),
        "filters": {name: [_texts(s) for s in cascade.sections] for name, cascade in law.filters.items()},
        "nominal": {name: repr(to_float(getattr(law.nominal, name))) for name in LOAD},
        "desired": {name: repr(to_float(getattr(law.desired, name))) for name in LOAD},
        "back_calculation": repr(to_float(law.back_calculation)),
        "claims": [each.to_json() for each in subject.carried],
    }


def _texts(section: Any) -> list[str]:
    return [repr(value) for value in (section.b0, section.b1, section.b2, section.a1, section.a2)]


def _only_json(subject: Subject) -> dict[str, str]:
    return {}


def _control(subject: Subject) -> dict[str, str]:
    law = subject.law
    words = {
        "subject": subject,
        "lines": [each.line for each in subject.carried],
        "period": repr(float(1 / law.rate)),
        "motions": {name: _motion(getattr(law, name), repr) for name in ("error", "compensated")},
        "rate": f"{float(law.rate):.17g}",
        "filters": {name: [_texts(s) for s in cascade.sections] for name, cascade in law.filters.items()},
        "nominal": _stiffness(law.nominal, repr),
        "desired": _stiffness(law.desired, repr),
    }
    return {f"{subject.identifier}.py": _rendered("controller.py.j2", words)}


def _ros2(subject: Subject) -> dict[str, str]:
    law = subject.law
    words = {
        "subject": subject,
        "lines": [each.line for each in subject.carried],
        "rate": int(law.rate),
        "motions": {name: _motion(getattr(law, name), repr) for name in ("error", "compensated")},
        "filters": {
            name: [text for s in cascade.sections for text in _texts(s)] for name, cascade in law.filters.items()
        },
        "nominal": {name: repr(to_float(getattr(law.nominal, name))) for name in LOAD},
        "desired": {name: repr(to_float(getattr(law.desired, name))) for name in LOAD},
        "back_calculation": repr(to_float(law.back_calculation)),
    }
    return {f"{subject.identifier}.yaml": _rendered("controller.yaml.j2", words)}


TARGETS: dict[str, Callable[[Subject], dict[str, str]]] = {
    "c": _c,
    "json": _only_json,
    "control": _control,
    "ros2": _ros2,
}
