"""The loop over joints and ticks, compiled: each thread takes every so-manieth joint, traces are kept on request."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .compiled import compiled, inlined
from .dry import FRICTION, TAU_INT, TOUCHING, Array, Limits, advance, halved, holds, mode, read, wall_missed
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
    """The sampled law in its own arithmetic, encoder, noise and its seeds; `on` false: continuous, the law is empty."""

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
    steps = np.empty((MODES, plant.levels, n, width))
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
    chosen = course.chosen[joint]
    push, disturbance, motion = course.push[chosen], course.disturbance[chosen], course.motion[chosen]
    limits, total = plant.limits, len(push)
    A, B, C, D, delay = digital.A, digital.B, digital.C, digital.D, digital.delay
    encoder, noise = digital.encoder, digital.noise
    xi, xi_next, sensed = np.zeros(len(A), dtype=A.dtype), np.zeros(len(A), dtype=A.dtype), np.zeros(2, dtype=A.dtype)
    line, slot = np.zeros(delay + 1), 0
    turn = np.exp(-1j * look.sines)
    phase = np.exp(-1j * look.sines * look.since)
    if digital.on:
        np.random.seed(digital.seeds[joint])
    walled = limits.wall_place < np.inf
    early = late = low = high = energy = lowest = highest = 0.0
    events = ticks = 0
    for k in range(total):
        w[0], w[1], w[3] = push[k], disturbance[k], motion[k]
        tau = read(rows, mode(switches), TAU_INT, x, w)
        if digital.on:
            sensed[0] = tau + (noise * np.random.standard_normal() if noise > 0 else 0.0)
            sensed[1] = _quantised(x[1], encoder)
            line[slot] = _advanced(A, B, C, D, sensed, xi, xi_next)
            slot = slot + 1 if slot < delay else 0
            w[2] = line[slot]
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
        advance(
            x, w, steps, 0, switches, limits, y
        )  # here, not in a function of its own: that would cost as much again
        good = holds(y, w, rows, switches, limits)
        if good and walled:
            good = not wall_missed(speed, before, y[0], y[1], switches[TOUCHING] != 0, limits, plant.h)
        if good:
            for i in range(len(x)):
                x[i] = y[i]
        else:
            events += halved(x, w, steps, rows, switches, limits, y, plant.h)
        energy += w[0] * (x[1] - before)
        lowest, highest = min(lowest, energy), max(highest, energy)
        ticks += 1
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
    figures[ENERGY], figures[LOWEST], figures[LARGEST] = energy, lowest, max(highest, -lowest)
    figures[EVENTS], figures[TICKS] = events, ticks


@inlined
def _quantised(value: float, step: float) -> float:
    return step * np.floor(value / step + 0.5) if step > 0 else value


@inlined
def _advanced(
    A: NDArray[Any], B: NDArray[Any], C: NDArray[Any], D: NDArray[Any],
    sensed: NDArray[Any], xi: NDArray[Any], xi_next: NDArray[Any],
) -> float:  # fmt: skip
    """The law's output for what is sensed, in the arithmetic of its arrays; its state moves on."""
    out = D[0, 0] * sensed[0] + D[0, 1] * sensed[1]
    for i in range(len(xi)):
        out += C[0, i] * xi[i]
        value = B[i, 0] * sensed[0] + B[i, 1] * sensed[1]
        for j in range(len(xi)):
            value += A[i, j] * xi[j]
        xi_next[i] = value
    for i in range(len(xi)):
        xi[i] = xi_next[i]
    return float(out)
