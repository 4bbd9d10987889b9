"""Every claim of a certificate on a dense frequency grid in numpy: what a check without proofs would cost.

The formulas are those of the checker's README, in closed form, one array operation each: the fastest fair rival.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

Json = Any
Array = NDArray[Any]


def _number(text: str) -> float:
    return float(Fraction(text))


def _rational(section: Json, s: Array) -> Array:
    n, d = ([_number(c) for c in section[key]] for key in ("numerator", "denominator"))
    return np.polyval(n, s) / np.polyval(d, s)


def _stiffness(load: Any, s: Array) -> Array:
    return np.polyval([float(c) for c in load], s)


class Grid:
    """The closed loop of a certificate at every frequency of a grid."""

    def __init__(self, certificate: Json, omega: Array) -> None:
        spec, s = certificate["spec"], 1j * omega
        self.s, self.spec, self.omega = s, spec, omega
        self.nominal, self.m = (
            _stiffness([_number(v) for v in spec[key].values()], s) for key in ("plant", "impedance")
        )
        H, Z_a = self._actuator(spec["actuator"])
        filters = spec["controller"]["filters"] or {}
        force, position, derivative = (filters.get(key) for key in ("force", "position", "derivative"))
        F, F_d = self._lag(force), self._lag(derivative)
        F_theta = F if position is None else self._lag(None if position == "none" else position)
        C = _rational(certificate["controller"]["C"], s)
        self.L, self.R = H * C * F, F_theta / F
        self.S, self.S_i = 1 / (1 + self.L), 1 / (1 + C * F)
        self.U = (1 - self.S_i) * self.R * self.m - self.S_i * F_d * (self.nominal - self.m)
        self.H, self.Z_a, self.rest = H, Z_a, Z_a - H * F_d * (self.nominal - self.m)
        weight = spec["uncertainty"]["weight"]
        self.weight = np.abs(_rational(weight, s)) if weight else np.zeros_like(omega)
        box = spec["uncertainty"]["box"]
        corners = product(*([_number(v) for v in ends] for ends in box.values())) if box else ()
        self.loads = [_stiffness(load, s) for load in dict.fromkeys(corners)] or [self.nominal]
        W = np.maximum.reduce([np.abs(self.nominal / g - 1) for g in self.loads])
        self.radius = W + self.weight + W * self.weight

    def _lag(self, corner: str | None) -> Any:
        return 1.0 if corner is None else 1 / (1 + self.s / _number(corner))

    def _actuator(self, a: Json) -> tuple[Any, Any]:
        if a["type"] == "ideal":
            return 1.0, 0.0
        loop, s = a["torque_loop"], self.s
        C_t = _number(loop["kp"]) + _number(loop["kd"]) * s * self._lag(loop["derivative_corner"])
        P = 1 / (_number(a["motor_inertia"]) * s**2 + _number(a["motor_damping"]) * s)
        k = _number(a["spring_stiffness"])
        below = 1 + k * P * (1 + C_t)
        return k * P * (C_t + _number(loop["feedforward"])) / below, k / below

    def _port(self, g: Array) -> Array:
        return (1 - self.S) * self.R * self.m + self.S * (g + self.rest)

    def _disc(self, V: Array) -> tuple[Array, Array]:
        return -(V**2) / (1 - V**2), V / (1 - V**2)

    def _passive(self, Z: Array, rest: Array, V: Array) -> Array:
        c, rho = self._disc(V)
        return (Z / self.s).real - rho * np.abs(rest / self.s) - (c * rest / self.s).real

    def worst(self, id: str, form: str, interval: list[str]) -> float:
        """The margin of a claim on the part of the grid that lies in its interval."""
        lo, hi = (np.inf if end == "inf" else _number(end) for end in interval)
        inside = (self.omega >= lo) & (self.omega <= hi)
        rules: dict[str, Callable[[str], Array]] = {
            "bandwidth": lambda form: -np.abs(self.S),
            "peak": lambda form: -np.abs(self.S),
            "eq9": lambda form: np.abs(self.S_i * self.nominal + self.U) / (self.radius * np.abs(self.U)),
            "eq12": self._eq12,
            "eq18": self._eq18,
            "rendering": self._rendering,
            "friction": self._friction,
        }
        with np.errstate(all="ignore"):
            return float(np.min(rules[id](form)[inside], initial=np.inf))

    def _eq12(self, form: str) -> Array:
        if form == "paper":
            room = (np.abs(self.s + self.m) - np.abs(self.s - self.m)) / (2 * np.abs(self.S_i * self.nominal))
            return room / (1 + room) / self.radius
        if form == "disc":
            return self._passive(self._port(self.nominal), self.S * self.nominal, self.radius)
        return np.minimum.reduce([self._passive(self._port(g), self.S * g, self.weight) for g in self.loads])

    def _eq18(self, form: str) -> Array:
        test, coupling = form.split("/")
        physical = self.S_i * self.Z_a / self.nominal + self.H * self.U / self.nominal
        T = self.H * self.U / (self.nominal + self.Z_a) if coupling == "frozen" else physical
        D0, M = self.S_i + T, self.m / self.nominal
        room = {
            "paper": lambda: 1 - np.abs(D0 - 1),
            "lumped": lambda: np.abs(M) - np.abs(D0 - M),
            "half-plane": lambda: np.abs(D0),
        }[test]()
        return room / (self.radius * np.abs(T))

    def _rendering(self, form: str) -> Array:
        c, rho = self._disc(self.weight)
        errors = [
            (np.abs(self._port(g) - self.m - c * self.S * g) + rho * np.abs(self.S * g)) / np.abs(self.m)
            for g in self.loads
        ]
        return -np.maximum.reduce(errors)

    def _friction(self, form: str) -> Array:
        port = self.L * self.R * self.m + self.rest
        return np.minimum.reduce([self._passive(port + g, g, self.weight) for g in self.loads])


def evaluate(certificate: Json, points: int) -> dict[tuple[str, str], float]:
    """Every claim with a frequency in it, on a grid over its interval."""
    grid = Grid(certificate, np.geomspace(1e-2, 1e5, points))
    return {
        (c["id"], c["form"]): grid.worst(c["id"], c["form"], c["interval"])
        for c in certificate["claims"]
        if not c["id"].startswith("stability")
    }
