"""The loop over joints and ticks, compiled: each thread takes every so-manieth joint, traces are kept on request."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .compiled import compiled
from .dry import FRICTION, TAU_INT, Array, Limits, mode, read, tick
from .ladder import ladder

MODES = 16
FIGURES = (
    "energy",
    "lowest_energy",
    "largest_energy",
    "early",
    "late",
    "low",
    "high",
    "reversals",
    "stuck",
    "events",
    "ticks",
)
ENERGY, LOWEST, LARGEST, EARLY, LATE, LOW, HIGH, REVERSALS, STUCK, EVENTS, TICKS = range(len(FIGURES))
TRACED = ("theta", "velocity", "tau_int", "tau_d", "load_friction", "motor_angle")
RUNAWAY = 1e9  # rad: beyond, a joint is no longer moved


class Plant(NamedTuple):
    """`Switched` as the compiled loop takes it, with the start state (loads, n), tick [s] and levels of halving."""

    modes: NDArray[np.int64]
    flows: Array
    rows: Array
    limits: Limits
    start: Array
    h: float
    levels: int


class Course(NamedTuple):
    """Torques and motion of each tick, (courses, ticks), and which course each joint takes."""

    push: Array
    disturbance: Array
    motion: Array
    chosen: NDArray[np.int64]


class Digital(NamedTuple):
    """The sampled law in its own arithmetic (no states and `on` false: continuous), encoder, noise and its seeds."""

    on: bool
    A: NDArray[Any]
    B: NDArray[Any]
    C: NDArray[Any]
    D: NDArray[Any]
    delay: int
    encoder: float
    noise: float
    seeds: NDArray[np.int64]


class Look(NamedTuple):
    """What to keep: sines [rad per tick] fitted from a tick on, and every so-manieth tick of traces (0: none)."""

    sines: Array
    since: int
    every: int


@compiled
def run(
    first: int, stride: int, plant: Plant, course: Course, digital: Digital, look: Look,
    figures: Array, phasors: NDArray[Any], traces: Array,
) -> None:  # fmt: skip
    """Joints `first`, `first + stride`, …: fill their `figures` (loads, FIGURES), `phasors` (loads, sines, θ and τ_int)
    and `traces` (loads, kept, TRACED). Other threads may do the rest: nothing is shared but what is read."""
    n, width = plant.flows.shape[2:]
    steps = np.empty((MODES, plant.levels, width, n))
    rows = np.zeros((MODES, 4, width))
    for joint in range(first, len(figures), stride):
        for i in range(len(plant.modes)):
            ladder(plant.flows[joint, i], plant.h, steps[plant.modes[i]])
            rows[plant.modes[i]] = plant.rows[joint, i]
        _joint(joint, plant, steps, rows, course, digital, look, figures[joint], phasors[joint], traces)


@compiled
def _joint(
    joint: int, plant: Plant, steps: Array, rows: Array, course: Course, digital: Digital, look: Look,
    figures: Array, phasors: NDArray[Any], traces: Array,
) -> None:  # fmt: skip
    """One joint from its start to the end of its course."""
    x, y, w = plant.start[joint].copy(), np.zeros(plant.start.shape[1]), np.zeros(rows.shape[2] - plant.start.shape[1])
    switches = np.zeros(4, dtype=np.int64)
    for contact in range(2):  # moving, it slips
        if plant.limits[contact] == 0:
            switches[contact] = 1
        elif x[2 * contact] != 0:
            switches[contact] = 1 if x[2 * contact] > 0 else -1
    chosen, total = course.chosen[joint], course.push.shape[1]
    xi = np.zeros(len(digital.A), dtype=digital.A.dtype)
    xi_next, sensed = xi.copy(), np.zeros(2, dtype=digital.A.dtype)
    line = np.zeros(digital.delay + 1)
    turn = np.exp(-1j * look.sines)
    phase = np.exp(-1j * look.sines * look.since)
    if digital.on:
        np.random.seed(digital.seeds[joint])
    early = late = low = high = 0.0
    for k in range(total):
        w[0], w[1], w[3] = course.push[chosen, k], course.disturbance[chosen, k], course.motion[chosen, k]
        tau = read(rows[mode(switches)][TAU_INT], x, w)
        if digital.on:
            w[2] = _demanded(tau, x[1], digital, xi, xi_next, sensed, line, k)
        if look.every and k % look.every == 0:
            row = traces[joint, k // look.every]
            row[0], row[1], row[2], row[3], row[4] = x[1], x[0], tau, w[2], w[FRICTION]
            row[5] = x[3] if len(x) > 3 else 0.0
        if k >= look.since:
            for i in range(len(turn)):
                phasors[i, 0] += x[1] * phase[i]
                phasors[i, 1] += tau * phase[i]
                phase[i] *= turn[i]
        before, speed = x[1], x[0]
        figures[EVENTS] += tick(x, w, steps, rows, switches, plant.limits, y)
        figures[ENERGY] += w[0] * (x[1] - before)
        figures[LOWEST] = min(figures[LOWEST], figures[ENERGY])
        figures[LARGEST] = max(figures[LARGEST], abs(figures[ENERGY]))
        figures[TICKS] += 1
        if 4 * k >= total and 2 * k < total:
            early = max(early, abs(x[1]))
        if 4 * k >= 3 * total:
            if late == 0.0 and low == high == 0.0:
                low = high = x[1]
            late, low, high = max(late, abs(x[1])), min(low, x[1]), max(high, x[1])
            figures[REVERSALS] += 1 if x[0] * speed < 0 or (x[0] != 0 and speed == 0) else 0
            figures[STUCK] += 1 if x[0] == 0 else 0
        if not abs(x[1]) < RUNAWAY:
            late = np.inf
            break
    figures[EARLY], figures[LATE], figures[LOW], figures[HIGH] = early, late, low, high


@compiled
def _demanded(
    tau: float, theta: float, digital: Digital, xi: NDArray[Any], xi_next: NDArray[Any], sensed: NDArray[Any],
    line: Array, k: int,
) -> float:  # fmt: skip
    """The torque demand held from tick k on: sensors read, law advanced, output `delay` ticks old."""
    noise = digital.noise * np.random.standard_normal() if digital.noise > 0 else 0.0
    sensed[0] = tau + noise
    sensed[1] = digital.encoder * np.floor(theta / digital.encoder + 0.5) if digital.encoder > 0 else theta
    out = digital.D[0, 0] * sensed[0] + digital.D[0, 1] * sensed[1]
    for i in range(len(xi)):
        out += digital.C[0, i] * xi[i]
        value = digital.B[i, 0] * sensed[0] + digital.B[i, 1] * sensed[1]
        for j in range(len(xi)):
            value += digital.A[i, j] * xi[j]
        xi_next[i] = value
    xi[:] = xi_next
    line[k % len(line)] = out
    return float(line[(k + 1) % len(line)])
