"""Batches of joints through their courses: arrays in, figures of every joint out."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from .law import SampledLaw
from .loop import FIGURES, TRACED, Course, Digital, Look, Plant, run
from .switched import Switched

Array = NDArray[np.float64]

LEVELS = 13  # a tick is halved twelve times where friction changes: 0.24 µs at 1 kHz


@dataclass(frozen=True, eq=False)
class Runs:
    """What every joint did, (loads,) each; energies [J] the push put in, angles [rad].

    `lowest_energy`, `largest_energy`: of all times, from rest. `early`, `late`: largest |θ| in the second and the last
    quarter; `low`, `high`: range of θ in the last; `reversals`, `stuck`: how often the motion there turned or started,
    and the ticks it stood still. `events`: implicit steps; `ticks`: fewer than asked if it ran away.
    `phasors` (loads, sines, 2): of θ and τ_int, complex amplitudes. `traces` (loads, kept, TRACED).
    """

    energy: Array
    lowest_energy: Array
    largest_energy: Array
    early: Array
    late: Array
    low: Array
    high: Array
    reversals: Array
    stuck: Array
    events: Array
    ticks: Array
    phasors: NDArray[np.complex128]
    traces: Array

    def trace(self, signal: str, joint: int = 0) -> Array:
        """The kept samples of one signal of one joint."""
        return np.asarray(self.traces[joint, :, TRACED.index(signal)])

    @property
    def grew(self) -> NDArray[np.bool_]:
        """Joints that moved more in the last quarter than in the second: for a course that has ended, unstable."""
        return np.asarray(self.late > self.early)


def simulate_batch(
    joints: Switched,
    tick: float,
    push: Array,
    *,
    disturbance: Array | None = None,
    motion: Array | None = None,
    chosen: NDArray[np.int64] | None = None,
    law: SampledLaw | None = None,
    start: Array | None = None,
    sines: Array | None = None,
    since: int = 0,
    every: int = 0,
    seed: int = 0,
    levels: int = LEVELS,
    threads: int | None = None,
) -> Runs:
    """Move every joint through its course, held over each `tick` [s], from `start` (n,) or (loads, n) or from rest.

    Args: `push`, `disturbance` [N·m]: (ticks,) or (courses, ticks), the second not felt by the torque sensor;
    `motion` [rad/s²]; `chosen`: (loads,) each joint's course. `law`: of a joint built without compensator.
    `threads`: by default one per core.
    `sines` [rad/s] whose phasors are summed from tick `since` on; `every`: keep every so-manieth tick (0: none).

    Raises: InputError for an encoder or noise without a sampled law.
    """
    count, faults = len(joints.flows), joints.faults
    if law is None and (faults.encoder or faults.torque_noise):
        raise InputError("encoder steps and sensor noise act on a sampled controller: give a rate")
    pushes = np.atleast_2d(np.asarray(push, dtype=float))
    rest = np.zeros_like(pushes)
    course = Course(
        pushes,
        rest if disturbance is None else np.atleast_2d(disturbance),
        rest if motion is None else np.atleast_2d(motion),
        np.zeros(count, dtype=np.int64) if chosen is None else chosen,
    )
    begun = np.zeros(joints.states) if start is None else start
    plant = Plant(
        np.array(joints.modes, dtype=np.int64), joints.flows, joints.rows, joints.limits,
        np.ascontiguousarray(np.broadcast_to(begun, (count, joints.states))), tick, levels,
    )  # fmt: skip
    frequencies = np.zeros(0) if sines is None else np.asarray(sines, dtype=float)
    ticks = pushes.shape[1]
    figures = np.zeros((count, len(FIGURES)))
    phasors = np.zeros((count, len(frequencies), 2), dtype=complex)
    traces = np.zeros((count if every else 0, -(-ticks // every) if every else 0, len(TRACED)))
    given = (plant, course, _digital(law, joints, count, seed), Look(frequencies * tick, since, every))
    threads = max(min(threads or os.cpu_count() or 1, count), 1)
    with ThreadPoolExecutor(threads) as pool:
        work = [pool.submit(run, i, threads, *given, figures, phasors, traces) for i in range(threads)]
        for part in work:
            part.result()
    kept: dict[str, Array] = dict(zip(FIGURES, figures.T, strict=True))
    return Runs(**kept, phasors=phasors * 2 / max(ticks - since, 1), traces=traces)


def _digital(law: SampledLaw | None, joints: Switched, count: int, seed: int) -> Digital:
    seeds = np.random.SeedSequence(seed).generate_state(count).astype(np.int64)
    none = np.zeros((0, 0))
    A, B, C, D, delay = (law.A, law.B, law.C, law.D, law.delay) if law else (none, none, none, none, 0)
    return Digital(law is not None, A, B, C, D, delay, joints.faults.encoder, joints.faults.torque_noise, seeds)
