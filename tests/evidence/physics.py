"""A joint as its physical equations, solved numerically: what every claim is judged by, with no formula of the project.

One equation for each part, nothing eliminated: `F x' = A x + b u`. Poles are eigenvalues, responses solutions at jω.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigvals

Json = Any
Complex = NDArray[np.complex128]
Real = NDArray[np.float64]
Terms = dict[str, float]
HELD, SENSED = "τ_d held", "τ_int sensed"
FAR = 1e8  # eigenvalues beyond are those at infinity, of the algebraic equations
NEAR_POLE = 600  # frequencies on each side of a pole without the hold


def num(text: str | float) -> float:
    return float(Fraction(text))


def numbers(section: Json) -> tuple[float, ...]:
    return tuple(num(value) for value in section.values())


def descending(texts: Sequence[str] | Sequence[float]) -> list[float]:
    values = [num(t) for t in texts]
    while len(values) > 1 and values[0] == 0:
        values.pop(0)
    return values


def rational_at(section: Json, s: Complex) -> Complex:
    return np.polyval([num(c) for c in section["numerator"]], s) / np.polyval(
        [num(c) for c in section["denominator"]], s
    )


class Equations:
    """Rows `Σ a_i x_i' = Σ b_i x_i + input`, by the names of the unknowns."""

    def __init__(self) -> None:
        self.rows: list[tuple[Terms, Terms, Terms]] = []

    def add(self, rates: Terms, values: Terms, inputs: Terms | None = None) -> None:
        self.rows.append((rates, values, inputs or {}))

    def transfer(self, name: str, source: Terms, section: Json) -> None:
        """`name = n/d · source`, in the controllable form; an improper one the other way round."""
        n, d = descending(section["numerator"]), descending(section["denominator"])
        if len(n) > len(d):
            self.transfer(f"{name} inverse", {name: 1}, {"numerator": d, "denominator": n})
            self.add({}, {f"{name} inverse": -1, **source})
            return
        n = [0.0] * (len(d) - len(n)) + n
        n, d = [c / d[0] for c in n], [c / d[0] for c in d]
        states = [f"{name}.{k}" for k in range(len(d) - 1)]  # the k-th derivative over w^k: of one size
        w = max(abs(c) ** (1 / k) for k, c in enumerate(d) if k) if any(d[1:]) else 1.0
        for low, high in pairwise(states):
            self.add({low: 1}, {high: w})
        if states:
            feedback = {state: -d[-1 - k] * w ** (k + 1 - len(states)) for k, state in enumerate(states)}
            self.add({states[-1]: 1}, {**feedback, **{key: w * value for key, value in source.items()}})
        out = {state: (n[-1 - k] - n[0] * d[-1 - k]) * w ** (k - len(states)) for k, state in enumerate(states)}
        self.add({}, {name: -1, **out, **{key: n[0] * value for key, value in source.items()}})

    def lag(self, name: str, source: Terms, corner: str | None) -> None:
        """`name = source/(1 + s/corner)`, or the source itself."""
        if corner is None:
            self.add({}, {name: -1, **source})
        else:
            w = num(corner)
            self.add({name: 1}, {name: -w, **{key: w * value for key, value in source.items()}})

    def matrices(self) -> tuple[list[str], Real, Real, dict[str, Real]]:
        """Names of the unknowns, F, A, and a column for every input."""
        names = sorted({key for rates, values, _ in self.rows for key in (*rates, *values)})
        inputs = sorted({key for *_, given in self.rows for key in given})
        assert len(names) == len(self.rows), (names, len(self.rows))
        F, A = np.zeros((2, len(names), len(names)))
        b = {key: np.zeros(len(names)) for key in inputs}
        for k, (rates, values, given) in enumerate(self.rows):
            for key, value in rates.items():
                F[k, names.index(key)] += value
            for key, value in values.items():
                A[k, names.index(key)] += value
            for key, value in given.items():
                b[key][k] += value
        return names, F, A, b


@dataclass(frozen=True)
class System:
    """The equations of a joint without its load: the load is the last row, `g θ = τ_int + τ_act + push`."""

    names: list[str]
    F: Real
    A: Real
    inputs: dict[str, Real]
    hold: tuple[float, float] | None = None  # sampling time and delay [s] of the torque command

    def matrix(self, omega: Real, load: Complex | None = None, *, held: bool = True) -> Complex:
        """`sF − A` at every frequency, with the hold on the command, and the load's row by g(jω) θ = …."""
        s = 1j * omega
        M = s[:, None, None] * self.F - self.A
        if self.hold and held:
            T, delay = self.hold
            row = next(k for k, a in enumerate(self.A) if a[self.names.index(HELD)] == -1 and np.count_nonzero(a) == 2)
            M[:, row, self.names.index("τ_d")] *= np.exp(-s * delay) * -np.expm1(-s * T) / (s * T)
        if load is not None:
            M[:, -1, :] = -self.A[-1]
            M[:, -1, self.names.index("θ")] = load
        return M

    def unstable(self, points: int = 20_000) -> int:
        """Modes that do not decay: those without the hold, and how often the determinant turns because of it."""
        without = int(np.sum(self.poles().real >= 0))
        if self.hold is None:
            return without
        near = np.geomspace(1e-9, 0.3, NEAR_POLE)  # a slow root turns within a small part of its frequency
        slow = [abs(p.imag) * (1 + side * near) for p in self.poles() if p.imag > 0 for side in (-1, 1)]
        omega = np.unique(np.concatenate([[1e-6], np.geomspace(1e-3, 300 / self.hold[0], points), *slow]))
        ratio = np.linalg.det(self.matrix(omega)) / np.linalg.det(self.matrix(omega, held=False))
        return without - round((np.unwrap(np.angle(ratio))[-1] - np.angle(ratio)[0]) / np.pi)

    def poles(self) -> Complex:
        """Finite eigenvalues."""
        with np.errstate(all="ignore"):
            found = np.asarray(eigvals(self.A, self.F))
        return found[np.isfinite(found) & (np.abs(found) < FAR)]

    def response(self, omega: Real, given: str, load: Complex | None = None) -> dict[str, Complex]:
        """Every unknown for the input 1 at each frequency; `load` [n] replaces the load's row by g(jω) θ = …."""
        M = self.matrix(omega, load)
        b = np.broadcast_to(self.inputs[given], (len(omega), len(self.names)))[..., None]
        x = np.linalg.solve(M, b)[..., 0]
        return {name: x[:, k] for k, name in enumerate(self.names)}


def system(spec: Json, controller: Json, load: Sequence[float] | None, *, wall: bool = False) -> System:
    """The equations of (1), (13), the filters and the control law; load None: the row is left to `response`."""
    q, (I0, B0, K0) = Equations(), numbers(spec["plant"])
    Im, Bm, Km = numbers(spec["impedance"])
    filters = spec["controller"]["filters"] or {}
    force, position, derivative = (filters.get(key) for key in ("force", "position", "derivative"))
    q.add({"θ": 1}, {"v": 1})
    q.add({"v": 1}, {"a": 1})
    q.add({}, {SENSED: -1, "τ_int": 1}, {"noise": 1})
    m_theta = {"a": Im, "v": Bm, "θ": Km}
    if position is None:  # one filter on the dynamic error
        q.lag("e", {SENSED: 1, **{key: -value for key, value in m_theta.items()}}, force)
    else:
        q.lag("F τ_int", {SENSED: 1}, force)
        q.lag("F_θ m θ", m_theta, None if position == "none" else position)
        q.add({}, {"e": -1, "F τ_int": 1, "F_θ m θ": -1})
    q.lag("F_d (ĝ−m) θ", {"a": I0 - Im, "v": B0 - Bm, "θ": K0 - Km}, derivative)
    q.transfer("C e", {"e": 1}, controller["C"])
    q.add({}, {"τ_d": -1, "C e": 1, "F_d (ĝ−m) θ": 1}, {"command": 1})
    q.add({}, {HELD: -1, "τ_d": 1})  # times the hold, in `response`
    _actuator(q, spec["actuator"])
    if wall:  # the load does not move: the environment takes up whatever the actuator does
        q.add({}, {"θ": 1})
        q.add({}, {"τ_int": 1, "τ_act": 1}, {"push": 1})
    else:
        q.add({}, {"τ_int": -1}, {"touch": 1})
        I, B, K = load or (1.0, 0.0, 0.0)  # noqa: E741
        q.add({}, {"a": -I, "v": -B, "θ": -K, "τ_int": 1, "τ_act": 1}, {"push": 1})
        if load is None:
            rates, values, inputs = q.rows.pop()
            q.rows.append((rates, {key: value for key, value in values.items() if key not in "avθ"}, inputs))
    sampling = spec.get("sampling")
    return System(*q.matrices(), (1 / num(sampling["rate"]), num(sampling["delay"])) if sampling else None)


def _actuator(q: Equations, section: Json) -> None:
    if section["type"] == "ideal":
        q.add({}, {"τ_act": -1, HELD: 1})
        return
    if section["type"] == "two-port":
        q.transfer("H τ_d", {HELD: 1}, section["transfer"])
        q.transfer("Z_a θ", {"θ": 1}, section["impedance"])
        q.add({}, {"τ_act": -1, "H τ_d": 1, "Z_a θ": -1})
        return
    loop, corner = section["torque_loop"], num(section["torque_loop"]["derivative_corner"])
    J, b, k = (num(section[key]) for key in ("motor_inertia", "motor_damping", "spring_stiffness"))
    kp, kd, feedforward = (num(loop[key]) for key in ("kp", "kd", "feedforward"))
    q.add({"θ_m": 1}, {"v_m": 1})
    q.add({"v_m": J}, {"v_m": -b, "τ_m": 1, "τ_act": -1})
    q.add({}, {"τ_act": -1, "θ_m": k, "θ": -k})
    q.add({}, {"e_t": -1, HELD: 1, "τ_act": -1})
    q.add({"lagged": 1}, {"lagged": -corner, "e_t": corner})  # kd s/(1 + s/c) e = kd c (e − e/(1 + s/c))
    q.add({}, {"τ_m": -1, HELD: feedforward, "e_t": kp + kd * corner, "lagged": -kd * corner})
