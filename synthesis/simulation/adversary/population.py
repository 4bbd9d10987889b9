"""Thousands of loads drawn from the box, moved by a random torque and let go."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...spec.model import Spec
from ..batch.law import law_and_compensator
from ..batch.run import simulate_batch
from ..batch.switched import switched
from ..equations import Compensator
from ..members import members
from .loop import Array, Loop, free
from .stretched import vertices

CHUNK = 500  # joints moved at once: bounds memory, and how long Ctrl-C waits
TICK = 2e-3  # s, of a continuous controller: its steps are exact however long, the torque is held
E_FOLDS = 20.0  # of the slowest motion, while it is let go
LONGEST = 100.0  # s
LEVELS = 5  # nothing switches: the ladder only makes the exponential
PATIENCE = 4.0  # the second half of the time is free of torque, and its second half is compared


@dataclass(frozen=True, eq=False)
class Population:
    """What was drawn and what became of it: loads (n, 3), member of the ranges (n,), and figures (n,).

    `lowest_energy` over `largest_energy`: energy drawn from the port, at worst, as part of what passed it.
    `grew`: more motion at the end than while the torque acted.
    """

    loads: Array
    member: Array
    lowest_energy: Array
    largest_energy: Array
    largest_angle: Array
    grew: NDArray[np.bool_]
    ticks: int
    tick: float

    @property
    def extraction(self) -> float:
        """Energy drawn from a port, at worst, as part of the largest that passed it; never positive."""
        return float((self.lowest_energy / np.maximum(self.largest_energy, 1e-300)).min())


def drawn(spec: Spec, count: int, rng: np.random.Generator) -> Array:
    """Loads (count, 3): the corners of the box, then points on its edges, then in its inside."""
    corners = vertices(spec)
    low, high = corners.min(axis=0), corners.max(axis=0)
    points = rng.random((count, 3))
    edges = slice(len(corners), count // 4)
    free = rng.integers(3, size=count)[edges, None] == np.arange(3)
    points[edges] = np.where(free, points[edges], np.round(points[edges]))
    loads = low + points * (high - low)
    loads[: len(corners)] = corners[:count]
    return np.asarray(loads)


def population(
    spec: Spec, C: Compensator, count: int, seconds: float, seed: int, progress: Callable[[float], None]
) -> Population:
    """Move `count` joints for `seconds` [s] at least: half the time a random torque, half none.

    Of ranges of impedances and actuators every member gets its share. With `sampling` the controller is the sampled
    one, in double precision. `progress` is told the share done.
    """
    rng = np.random.default_rng(seed)
    every = list(members(spec))
    share = ceil(count / len(every))
    parts: list[tuple[Any, ...]] = []
    ticks, tick = 0, TICK
    for index, member in enumerate(every):
        one = member.spec
        loads = drawn(one, share, rng)
        law, continuous = law_and_compensator(one, C)
        tick = law.tick if law else TICK
        duration = max(seconds, min(_settling(free(one, C, loads[0])), LONGEST))
        ticks = ceil(duration / tick)
        push = _course(ticks, tick, rng)
        for first in range(0, share, CHUNK):
            part = loads[first : first + CHUNK]
            joints = switched(one, continuous, part)
            run = simulate_batch(joints, tick, push, law=law, seed=seed, levels=LEVELS)
            reached = np.maximum(run.early, run.late)
            parts.append((part, np.full(len(part), index), run.lowest_energy, run.largest_energy, reached, run.grew))
            progress((index + min(first + CHUNK, share) / share) / len(every))
    table, which, lowest, largest, angle, grew = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Population(table, which, lowest, largest, angle, grew, ticks, tick)


def _settling(loop: Loop) -> float:
    return PATIENCE * E_FOLDS / loop.poles.decay if loop.poles.stable else LONGEST


def _course(ticks: int, tick: float, rng: np.random.Generator) -> Array:
    """A torque about 1 N·m: steps held for random times, white noise on them; nothing in the second half."""
    half = ticks // 2
    held = np.repeat(rng.standard_normal(half), rng.geometric(min(tick / 0.05, 1.0), size=half))[:half]
    return np.concatenate([held + 0.3 * rng.standard_normal(half), np.zeros(ticks - half)])
