"""Thousands of loads drawn from the box, moved by a random torque and let go."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...spec.model import Spec
from ..batch.law import Arithmetic, law_and_compensator
from ..batch.run import LEVELS as FRICTION_LEVELS
from ..batch.run import simulate_batch
from ..batch.switched import Imperfections, switched
from ..equations import Compensator
from ..members import drawn_members, members
from .loop import Array, Loop, free
from .stretched import vertices

INSIDE = 16  # members drawn from inside the ranges
CHUNK = 500  # joints moved at once: bounds memory, and how long Ctrl-C waits
TICK = 2e-3  # s, of a continuous controller: its steps are exact however long, the torque is held
E_FOLDS = 20.0  # of the slowest motion, while it is let go
LONGEST = 100.0  # s
MOST_TICKS = 10_000_000  # of one course, 80 MB
LEVELS = 5  # nothing switches: the ladder only makes the exponential
PATIENCE = 4.0  # the second half of the time is free of torque, and its second half is compared


@dataclass(frozen=True)
class Reality:
    """What a joint has beside what a certificate speaks of: imperfections, a rate of sampling [Hz], an arithmetic."""

    faults: Imperfections = field(default_factory=Imperfections)
    rate: float | None = None
    arithmetic: Arithmetic = "float64"

    def __str__(self) -> str:
        plain = vars(Imperfections())
        parts = [
            f"{name.replace('_', ' ')} {value:g}" for name, value in vars(self.faults).items() if value != plain[name]
        ]
        parts += [f"sampled at {self.rate:g} Hz"] if self.rate else []
        parts += [self.arithmetic] if self.arithmetic != "float64" else []
        return ", ".join(parts)


@dataclass(frozen=True, eq=False)
class Population:
    """What was drawn and what became of it: loads (n, 3), member of the ranges (n,), and figures (n,).

    `lowest_energy` over `largest_energy`: energy drawn from the port, at worst, as part of what passed it.
    `grew`: more motion at the end than while the torque acted. `range` [rad] and `reversals` of θ in the last quarter.
    """

    loads: Array
    member: Array
    lowest_energy: Array
    largest_energy: Array
    largest_angle: Array
    grew: NDArray[np.bool_]
    range: Array
    reversals: Array
    ticks: int
    tick: float

    @property
    def extraction(self) -> float:
        """Energy drawn from a port, at worst, as part of the largest that passed it; never positive."""
        return float((self.lowest_energy / np.maximum(self.largest_energy, 1e-300)).min())


FIGURES = ("loads", "member", "lowest_energy", "largest_energy", "largest_angle", "grew", "range", "reversals")


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
    spec: Spec,
    C: Compensator,
    count: int,
    seconds: float,
    seed: int,
    progress: Callable[[float], None],
    reality: Reality = Reality(),
) -> Population:
    """Move `count` joints for `seconds` [s] at least: half the time a random torque, half none.

    Of ranges of impedances and actuators the middle, every end and some from inside get their share. With `sampling`
    the controller is the sampled one, in double precision. `progress` is told the share done. `reality`: what else
    there is.

    Raises: InputError for an encoder, sensor noise or single precision without a sampled controller.
    """
    if reality.arithmetic != "float64" and spec.sampling is None and reality.rate is None:
        raise InputError("single precision is that of a sampled controller: give a rate")
    rng = np.random.default_rng(seed)
    every = [*members(spec), *drawn_members(spec, INSIDE, rng)]
    share = ceil(count / len(every))
    tables = [drawn(member.spec, share, rng) for member in every]  # first: the same joints at every rate
    parts: list[tuple[Any, ...]] = []
    ticks, tick = 0, TICK
    for index, (member, loads) in enumerate(zip(every, tables, strict=True)):
        one = member.spec
        law, continuous = law_and_compensator(one, C, reality.rate, reality.arithmetic)
        tick = law.tick if law else TICK
        duration = max(seconds, min(_settling(free(one, C, loads[0])), LONGEST))
        ticks = ceil(duration / tick)
        if ticks > MOST_TICKS:
            raise InputError(
                f"{duration:g} s at {1 / tick:g} Hz are {ticks} ticks, at most {MOST_TICKS}: sample slower"
            )
        push = _course(ticks, tick, rng)
        for first in range(0, share, CHUNK):
            part = loads[first : first + CHUNK]
            joints = switched(one, continuous, part, reality.faults)
            levels = LEVELS if reality.faults.linear else FRICTION_LEVELS
            run = simulate_batch(joints, tick, push, law=law, seed=seed + first, levels=levels)
            reached, range_ = np.maximum(run.early, run.late), run.high - run.low
            energies = run.lowest_energy, run.largest_energy
            parts.append((part, np.full(len(part), index), *energies, reached, run.grew, range_, run.reversals))
            progress((index + min(first + CHUNK, share) / share) / len(every))
    columns: dict[str, Any] = dict(zip(FIGURES, map(np.concatenate, zip(*parts, strict=True)), strict=True))
    return Population(**columns, ticks=ticks, tick=tick)


def _settling(loop: Loop) -> float:
    return PATIENCE * E_FOLDS / loop.poles.decay if loop.poles.stable else LONGEST


def _course(ticks: int, tick: float, rng: np.random.Generator) -> Array:
    """A torque about 1 N·m: steps held for random times, white noise on them; nothing in the second half."""
    half = ticks // 2
    held = np.repeat(rng.standard_normal(half), rng.geometric(min(tick / 0.05, 1.0), size=half))[:half]
    return np.concatenate([held + 0.3 * rng.standard_normal(half), np.zeros(ticks - half)])
