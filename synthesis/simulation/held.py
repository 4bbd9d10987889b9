"""A joint whose torque demand passes a hold and a delay: `w(t) = (y(t−T_d) − y(t−T_d−T))/T`, `y' = τ_d`.

In steps of h the joint moves exactly under τ_int and under a w that is cubic within a step, given by w and w' at its
ends. They follow from y and τ_d there: y over a step is cubic as well, so a lag may end anywhere. What this costs is
of fourth order in h, and known by moving the same joint in steps of 2h.

State of a step: (x, w, h·w', mean torque demand of the last steps, τ_d at the last steps).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from ..spec.model import Sampling
from .block import Block, Matrix, connect
from .excitation import Excitation
from .joint import READ, Joint, Poles, resolvent
from .march import March, Samples, power_form, propagator, repeated

FINE = 0.05  # rad of the fastest excitation in a step
FINEST = 1e-3  # rad of it: finer steps differ by rounding
LONGEST_LINE = 64  # steps of memory
GONE = 1e-6  # part of a motion that is left after a step: faster eigenvalues are the delay line's own
ORDER_GAIN = 8  # a step of 2h is at least this many times as wrong as one of h (16 in the limit)
CLEAR = 0.1  # of the worst pole's decay may be in doubt
HERMITE_START = np.array([[1.0, 0], [0, 1], [-6, -4], [12, 6]])  # derivatives in σ = t/h at the start of a step
HERMITE_END = np.array([[0.0, 0], [0, 0], [6, -2], [-12, 6]])  # by the values at its end


@dataclass(frozen=True)
class Lags:
    """Hold of `period` T and delay T_d, in s, and the step h."""

    period: float
    delay: float
    h: float

    @classmethod
    def of(cls, sampling: Sampling, fastest: float) -> Lags:
        """Steps that are fine for `fastest` [rad/s] and for the hold, as far as memory allows."""
        T, T_d = float(1 / sampling.rate), float(sampling.delay)
        parts = max(2, ceil(T * fastest / FINE))
        parts = min(parts, int(LONGEST_LINE * T / (T + T_d)))
        h = T / parts if parts else (T + T_d) / LONGEST_LINE
        return cls(T, T_d, max(h, FINEST / fastest))

    @property
    def memory(self) -> int:
        """Steps remembered."""
        return int((self.period + self.delay) / self.h + 1e-9) + 2

    def taps(self) -> Matrix:
        """w and h·w' by mean torques D and samples τ of the steps so far, newest first, (2, 2·memory)."""
        return (self._integral(self.delay) - self._integral(self.delay + self.period)) * (self.h / self.period)

    def _integral(self, lag: float) -> Matrix:
        """`y/h` and `y'` a time `lag` ago, relative to y now, as `taps`."""
        steps = int(lag / self.h + 1e-9)
        u = min(max(1 - (lag / self.h - steps), 0.0), 1.0)  # where in its step, 1: its end
        D, tau = np.zeros((2, self.memory)), np.zeros((2, self.memory))
        D[0, :steps] = -1
        D[:, steps] = [-(2 * u**3 - 3 * u**2 + 1), 6 * u - 6 * u**2]
        tau[:, steps] = [u**3 - u**2, 3 * u**2 - 2 * u]
        tau[:, steps + 1] = [u**3 - 2 * u**2 + u, 3 * u**2 - 4 * u + 1]
        return np.hstack([D, tau])


@dataclass(frozen=True, eq=False)
class Steps:
    """`system` (input `held`, outputs with τ_d) in steps of `lags`: `s⁺ = Φ s`."""

    system: Block
    lags: Lags

    @cached_property
    def _within(self) -> tuple[Matrix, Matrix]:
        """`e^{Ah}` of (x, mean τ_d so far, w and its derivatives), and the flow that it is of."""
        n, h = len(self.system.A), self.lags.h
        flow = np.zeros((n + 5, n + 5))
        flow[:n, :n] = self.system.A
        flow[:n, n + 1] = self.system.B[:, -1]
        flow[n, :n] = self.system.row("tau_d") / h
        flow[n, n + 1] = self.through / h
        flow[n + 1 :, n + 1 :] = np.eye(4, k=1) / h
        return np.asarray(expm(flow * h)), flow

    @property
    def through(self) -> float:
        """What w adds to τ_d at once."""
        return float(self.system.D[self.system.outputs.index("tau_d"), -1])

    @cached_property
    def ends(self) -> tuple[Matrix, Matrix]:
        """What x and the mean τ_d at the end of a step owe to w, h·w' at its start, and at its end, (n+1, 2) each."""
        n = len(self.system.A)
        push = self._within[0][: n + 1, n + 1 :]
        return push @ HERMITE_START, push @ HERMITE_END

    @cached_property
    def transition(self) -> Matrix:
        """Φ: where the newest torque counts at once, w and h·w' solve two linear equations."""
        n, m, tau_d = len(self.system.A), self.lags.memory, self.system.row("tau_d")
        motion, (first, last) = self._within[0][: n + 1, :n], self.ends
        size = n + 2 + 2 * m
        known = np.zeros((size, size))
        known[:n, : n + 2] = np.hstack([motion[:n], first[:n]])
        known[n + 2, : n + 2] = np.concatenate([motion[n], first[n]])
        known[n + 2 + m] = tau_d @ known[:n]
        for line in (n + 2, n + 2 + m):
            known[line + 1 : line + m, line : line + m - 1] = np.eye(m - 1)
        sought = np.zeros((size, 2))
        sought[:n], sought[n : n + 2], sought[n + 2] = last[:n], np.eye(2), last[n]
        sought[n + 2 + m] = tau_d @ last[:n] + [self.through, 0]
        read = np.hstack([np.zeros((2, n + 2)), self.lags.taps()])
        return known + sought @ np.linalg.solve(np.eye(2) - read @ sought, read @ known)

    @cached_property
    def poles(self) -> NDArray[np.complex128]:
        """Logarithms of Φ's eigenvalues over h, [rad/s], without those of the delay line alone."""
        values = np.linalg.eigvals(self.transition).astype(complex)
        return np.asarray(np.log(values[abs(values) > GONE]) / self.lags.h)

    def work(self, power: Matrix) -> Matrix:
        """`∫ xᵀ M x dt` over a step as a quadratic form of its state."""
        n, (_, flow) = len(self.system.A), self._within
        M = np.zeros_like(flow)
        M[:n, :n] = power
        W = propagator(flow, M, self.lags.h)[1]
        start = np.zeros((n + 5, len(self.transition)))
        start[:n, :n] = np.eye(n)
        start[n + 1 :, n : n + 2] = HERMITE_START
        start[n + 1 :] += HERMITE_END @ self.transition[n : n + 2]
        return np.asarray(start.T @ W @ start)

    def start(self, x: Samples) -> Samples:
        """Everything at rest but x; a demand that jumps reaches w' at once without a delay."""
        n, m, now = len(x), self.lags.memory, float(self.system.row("tau_d") @ x)
        state = np.concatenate([x, np.zeros(2 + 2 * m)])
        state[n + 2 + m] = now
        state[n + 1] = 0.0 if self.lags.delay else now * self.lags.h / self.lags.period
        return state

    def compliance(self, omega: Samples) -> NDArray[np.complex128]:
        """Steady `θ/τ_int`: the exact motion without w, and that of the steps under it."""
        n, h, m = len(self.system.A), self.lags.h, self.lags.memory
        s, z = 1j * omega, np.exp(1j * omega * h)
        theta, tau_d = self.system.row("theta"), self.system.row("tau_d")
        x = resolvent(self.system.A, self.system.B[:, :1], s)[:, :, 0]
        demand = x @ tau_d + self.system.D[self.system.outputs.index("tau_d"), 0]
        lags = z[:, None] ** -np.arange(m)
        taps = self.lags.taps()
        by_mean, by_sample = lags @ taps[:, :m].T, lags @ taps[:, m:].T
        alone = demand[:, None] * (by_mean * ((1 - 1 / z) / (s * h))[:, None] + by_sample)
        motion, (first, last) = self._within[0][: n + 1, :n], self.ends
        push = first + z[:, None, None] * last
        pushed = np.linalg.solve(z[:, None, None] * np.eye(n) - motion[:n], push[:, :n])
        mean = (motion[n] @ pushed + push[:, n]) / z[:, None]
        sample = tau_d @ pushed + [self.through, 0]
        loop = by_mean[:, :, None] * mean[:, None, :] + by_sample[:, :, None] * sample[:, None, :]
        w = np.linalg.solve(np.eye(2) - loop, alone[:, :, None])[:, :, 0]
        return np.asarray(x @ theta + np.einsum("fi,fi->f", theta @ pushed, w))


@dataclass(frozen=True, eq=False)
class HeldJoint(Joint):
    """A joint with a hold: inputs τ_int and the held torque demand, moved in steps."""

    lags: Lags

    @cached_property
    def pair(self) -> tuple[Steps, Steps]:
        """In steps of h, and of 2h to know the error."""
        return pair(self.system, self.lags)

    @cached_property
    def poles(self) -> Poles:
        """Poles in free motion."""
        return held_poles(self.pair)

    def march(self, excitation: Excitation, dt: float) -> March:
        """The joint at rest and its excitation, every dt [s] rounded down to steps (one at least)."""
        driven = Steps(connect([excitation.generator, self.system], inputs=["held"]), self.pair[0].lags)
        rows = {signal: driven.system.row(signal) for signal in READ}
        count = max(int(dt / driven.lags.h + 1e-9), 1)
        work = driven.work(power_form(rows["tau_int"], rows["velocity"]))
        start = driven.start(np.concatenate([excitation.start, np.zeros(len(self.A))]))
        rest = np.zeros(len(start) - len(driven.system.A))
        through = np.concatenate([np.array([driven.through]), rest[1:]])
        whole = {name: np.concatenate([row, through if name == "tau_d" else rest]) for name, row in rows.items()}
        return March(count * driven.lags.h, *repeated(driven.transition, work, count), start, whole)

    def compliance(self, omega: Samples) -> NDArray[np.complex128]:
        """Steady motion `θ/τ_int` at frequencies (n,) [rad/s]."""
        return self.pair[0].compliance(omega)

    def step_error(self, omega: Samples) -> Samples:
        """Relative error of θ/τ_int that the steps make at frequencies (n,) [rad/s]."""
        fine, coarse = (steps.compliance(omega) for steps in self.pair)
        return np.asarray(abs(fine / coarse - 1) / ORDER_GAIN)


def pair(system: Block, lags: Lags) -> tuple[Steps, Steps]:
    """The system in steps of h and of 2h, h halved until the worst pole's side of the axis is clear."""
    fine, coarse = Steps(system, lags), Steps(system, Lags(lags.period, lags.delay, 2 * lags.h))
    while 2 * fine.lags.memory <= LONGEST_LINE:
        poles = held_poles((fine, coarse))
        if poles.worst is None or poles.error <= CLEAR * abs(poles.worst.real):
            break
        fine, coarse = Steps(system, Lags(lags.period, lags.delay, fine.lags.h / 2)), fine
    return fine, coarse


def held_poles(steps: tuple[Steps, Steps]) -> Poles:
    """Poles of the finer steps; the error of the worst by the coarser ones."""
    fine, coarse = (Poles(each.poles) for each in steps)
    if fine.worst is None or coarse.worst is None:
        return fine
    return Poles(fine.values, abs(fine.worst.real - coarse.worst.real) / ORDER_GAIN)
