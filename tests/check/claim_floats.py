"""Every claim's margin at one frequency in floats, from the loop's transfer functions: the tests' second opinion."""

from __future__ import annotations

import cmath
import math
from fractions import Fraction
from itertools import product
from typing import Any

import numpy

Json = Any
Load = tuple[float, float, float]


def num(text: str) -> float:
    return float(Fraction(text))


def at(rational: Json, s: complex) -> complex:
    def horner(coefficients: list[str]) -> complex:
        out = 0j
        for c in coefficients:
            out = out * s + num(c)
        return out

    return horner(rational["numerator"]) / horner(rational["denominator"])


class Joint:
    """Transfer functions of a specification and a controller at s = jω."""

    def __init__(self, spec: Json, controller: Json, omega: float, point: Json = None) -> None:
        """`point`: impedance and actuator parameters that are not at their nominal values."""
        s = self.s = 1j * omega
        self.spec, self.point, self.omega = spec, point or {}, omega
        I, B, K = (num(v) for v in spec["plant"].values())  # noqa: E741
        self.nominal = (I, B, K)
        self.g_hat = self.g(self.nominal)
        m = {key: num(v) if isinstance(v, str) else sum(map(num, v)) / 2 for key, v in spec["impedance"].items()}
        self.m = self.g(tuple({**m, **self.point.get("impedance", {})}.values()))  # type: ignore[arg-type]
        self.H, self.Za = self._actuator()
        if spec.get("sampling"):
            T, delay = 1 / num(spec["sampling"]["rate"]), num(spec["sampling"]["delay"])
            self.H *= cmath.exp(-s * delay) * (1 - cmath.exp(-s * T)) / (s * T)
        f = spec["controller"].get("filters") or {}

        def lag(corner: str | None) -> complex:
            return 1 / (1 + s / num(corner)) if corner else 1

        self.F, self.Fd = lag(f.get("force")), lag(f.get("derivative"))
        position = f.get("position")
        F_theta = self.F if position is None else 1 if position == "none" else lag(position)
        self.R = F_theta / self.F
        C = at(controller["C"], s)
        L = self.H * C * self.F
        self.L, self.Q = L, L / (1 + L)
        self.Qi = C * self.F / (1 + C * self.F)
        self.U = self.Qi * self.R * self.m - (1 - self.Qi) * self.Fd * (self.g_hat - self.m)

    def g(self, load: Load) -> complex:
        I, B, K = load  # noqa: E741
        return I * self.s**2 + B * self.s + K

    def _actuator(self) -> tuple[complex, complex]:
        a, s = self.spec["actuator"], self.s
        if a["type"] == "ideal":
            return 1, 0
        if a["type"] == "two-port":
            return at(a["transfer"], s), at(a["impedance"], s)
        t = a["torque_loop"]
        a = {
            **{key: num(v) for key, v in a.items() if isinstance(v, str) and key != "type"},
            **self.point.get("actuator", {}),
        }
        Ct = num(t["kp"]) + num(t["kd"]) * s / (1 + s / num(t["derivative_corner"]))
        P = 1 / (a["motor_inertia"] * s**2 + a["motor_damping"] * s)
        k = a["spring_stiffness"]
        below = 1 + k * P * (1 + Ct)
        return k * P * (Ct + num(t["feedforward"])) / below, k / below

    def Z0(self, load: Load) -> complex:
        return self.g(load) + self.Za - self.H * self.Fd * (self.g_hat - self.m)

    def Z(self, load: Load) -> complex:
        return self.Q * self.R * self.m + (1 - self.Q) * self.Z0(load)

    @property
    def weight(self) -> float:
        w, table = self.spec["uncertainty"].get("weight"), self.spec["uncertainty"].get("table")
        W_w, W_t = abs(at(w, self.s)) if w else 0.0, 0.0
        if table:
            points = [[num(v) for v in point] for point in table["points"]]
            W_t = float(numpy.interp(self.omega, *zip(*points, strict=True)))
        return W_w + W_t + W_w * W_t

    def loads(self, steps: int = 2) -> list[Load]:
        box = self.spec["uncertainty"].get("box")
        if not box:
            return [self.nominal]
        ends = [[num(v) for v in box[key]] for key in ("inertia", "damping", "stiffness")]
        return list(product(*([lo + (hi - lo) * k / (steps - 1) for k in range(steps)] for lo, hi in ends)))  # type: ignore[arg-type]

    def lumped(self, load: Load | None = None, steps: int = 2) -> float:
        box = self.spec["uncertainty"].get("box")
        loads = [load] if load else self.loads(steps)
        W = max(abs(self.g_hat / self.g(one) - 1) for one in loads) if box else 0.0
        return W + self.weight + W * self.weight

    def _disc(self, V: float) -> tuple[float, float]:
        return -(V**2) / (1 - V**2), V / (1 - V**2)

    def margin(self, kind: str, form: str, steps: int = 2, load: Load | None = None) -> float:
        """Largest (≥-claims, factors) or smallest (peak, rendering) value at which the statement holds here."""
        s, m, g_hat = self.s, self.m, self.g_hat
        loads = [load] if load else self.loads(steps)
        W = self.lumped(load, steps) or 1e-99  # the nominal load alone
        if kind == "eq9":
            return abs((1 - self.Qi) * g_hat + self.U) / (W * abs(self.U))
        if kind == "eq12" and form == "paper":
            room = (abs(s + m) - abs(s - m)) / (2 * abs((1 - self.Qi) * g_hat))
            return room / (1 + room) / W if room > 0 else 0.0
        if kind == "eq12" and form == "disc":
            if W >= 1:
                return -math.inf
            c, rho = self._disc(W)
            x = (1 - self.Q) * g_hat / s
            return (self.Z(self.nominal) / s).real - rho * abs(x) - (c * x).real
        if kind in ("eq12", "friction"):
            c, rho = self._disc(self.weight)
            values = []
            for one in loads:
                x = (1 if kind == "friction" else 1 - self.Q) * self.g(one) / s
                port = self.L * self.R * m + self.Z0(one) if kind == "friction" else self.Z(one)
                values.append((port / s).real - rho * abs(x) - (c * x).real)
            return min(values)
        if kind == "eq18":
            test, coupling = form.split("/")
            if coupling == "frozen":
                T = self.H * self.U / (g_hat + self.Za)
            else:
                T = (1 - self.Qi) * self.Za / g_hat + self.H * self.U / g_hat
            D0, M = 1 - self.Qi + T, m / g_hat
            room = {"paper": 1 - abs(D0 - 1), "lumped": abs(M) - abs(D0 - M), "half-plane": abs(D0)}[test]
            return room / (W * abs(T))
        if kind == "rendering":
            c, rho = self._disc(self.weight)
            errors = []
            for one in loads:
                x = (1 - self.Q) * self.g(one)
                errors.append((abs(self.Z(one) - m - c * x) + rho * abs(x)) / abs(m))
            return max(errors)
        if kind == "noise":
            return abs(self.L / self.H / (1 + self.L))
        assert kind in ("peak", "bandwidth")
        return abs(1 - self.Q)
