"""The joints that a specification with ranges stands for: the same specification with numbers instead."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

import numpy as np

from ..spec.model import Impedance, Interval, SeriesElasticActuator, Spec
from .equations import Load, desired, loads

WISH = ("inertia", "damping", "stiffness")
DRIVE = ("motor_inertia", "motor_damping", "spring_stiffness")
FREE = 4  # ranges whose ends are combined in every way: 16 members
ALIASES = ((0, 1, 2), (1, 2, 3))  # further ranges follow the parity of these: any two still meet in every way


@dataclass(frozen=True)
class Drive:
    """True parameters of a series-elastic actuator [kg·m², N·m·s/rad, N·m/rad]."""

    motor_inertia: Fraction
    motor_damping: Fraction
    spring_stiffness: Fraction

    def __str__(self) -> str:
        return (
            f"J={float(self.motor_inertia):g} b_m={float(self.motor_damping):g} K_sp={float(self.spring_stiffness):g}"
        )


@dataclass(frozen=True)
class Member:
    """A specification without ranges; the impedance and the drive it has where there were ranges, else None."""

    spec: Spec
    impedance: Load | None = None
    drive: Drive | None = None

    def __str__(self) -> str:
        parts = [f"impedance {self.impedance}"] if self.impedance else []
        parts += [f"actuator {self.drive}"] if self.drive else []
        return "".join(f", {part}" for part in parts)


def members(spec: Spec) -> Iterator[Member]:
    """The middle of the impedances with the nominal drive, then ends of the ranges, 16 times at most."""
    wish, drive = _ranges(spec)
    yield _member(spec, {})
    names = [*wish, *drive]
    intervals = [*wish.values(), *drive.values()]
    for ends in _ends(len(names)):
        yield _member(spec, {name: both[end] for name, both, end in zip(names, intervals, ends, strict=True)})


def drawn_members(spec: Spec, count: int, rng: np.random.Generator) -> list[Member]:
    """Members from anywhere inside the ranges; none where there is no range."""
    wish, drive = _ranges(spec)
    intervals = {**wish, **drive}

    def within(interval: Interval) -> Fraction:
        low, high = interval
        return low + Fraction(rng.random()) * (high - low)

    return [
        _member(spec, {name: within(both) for name, both in intervals.items()})
        for _ in range(count if intervals else 0)
    ]


def with_parameters(spec: Spec, impedance: Load | None, drive: Drive | None) -> Member:
    """One of the joints of a specification with ranges: with this impedance and drive, None: the middle."""
    given = {name: getattr(impedance, name) for name in WISH if impedance} | (vars(drive) if drive else {})
    return _member(spec, given)


def middle_of(spec: Spec) -> Spec:
    """The specification with the middle of the impedances and the nominal drive."""
    return next(members(spec)).spec


def extremes(spec: Spec) -> tuple[Load, ...]:
    """The nominal load, the lightest with most damping and stiffness, the heaviest with least."""
    box = spec.uncertainty.box
    if box is None:
        return loads(spec)
    (low, high), (B_low, B_high), (K_low, K_high) = box.inertia, box.damping, box.stiffness
    return tuple(dict.fromkeys([loads(spec)[0], Load(low, B_high, K_high), Load(high, B_low, K_low)]))


def _ranges(spec: Spec) -> tuple[dict[str, Interval], dict[str, Interval]]:
    """Ranges of the impedance and of the drive by their names."""
    wish = {name: value for name in WISH if isinstance(value := getattr(spec.impedance, name), tuple)}
    box = spec.uncertainty.actuator
    drive = {name: value for name in DRIVE if (value := getattr(box, name, None)) and value[0] < value[1]}
    return wish, drive


def _ends(count: int) -> Iterator[tuple[int, ...]]:
    """Which end of each range: every combination of four, a fraction of 2^count beyond."""
    if not count:
        return
    for ends in product((0, 1), repeat=min(count, FREE)):
        yield ends + tuple(sum(ends[i] for i in alias) % 2 for alias in ALIASES[: max(count - FREE, 0)])


def _member(spec: Spec, values: dict[str, Fraction]) -> Member:
    wish, drive = _ranges(spec)
    impedance, actuator = desired(spec), spec.actuator
    impedance = Load(**{name: values.get(name, getattr(impedance, name)) for name in WISH})
    exact = Impedance(**{name: getattr(impedance, name) for name in WISH})
    certain = spec.uncertainty.model_copy(update={"actuator": None})
    found = None
    if isinstance(actuator, SeriesElasticActuator) and drive:
        found = Drive(**{name: values.get(name, getattr(actuator, name)) for name in DRIVE})
        actuator = actuator.model_copy(update=vars(found))
    one = spec.model_copy(update={"impedance": exact, "actuator": actuator, "uncertainty": certain})
    return Member(one, impedance if wish else None, found)
