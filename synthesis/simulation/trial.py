"""What one experiment on one joint found, and what all of them did."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from .equations import Load
from .members import DRIVE, WISH, Drive

Kind = Literal["step", "multisine", "tone"]
KINDS: tuple[Kind, ...] = ("step", "multisine", "tone")


@dataclass(frozen=True)
class Trial:
    """One experiment on one load; an unstable joint is not moved, and what was not measured is None or empty.

    Energies [J] that entered through the port since rest: the lowest reached, and the largest in either direction.
    Frequencies [rad/s], measured `Z = τ_int/θ` [N·m/rad] and its estimated relative error, for multisine and tone.
    `impedance` and `actuator`: which of a range they are; None where there is no range. `energy_error`: of the largest
    energy, what the steps of a held joint may be wrong by.
    """

    load: Load
    kind: Kind
    stable: bool
    worst_pole: complex | None
    duration: float | None = None
    min_energy: float | None = None
    energy_scale: float | None = None
    frequencies: tuple[float, ...] = ()
    Z_measured: tuple[complex, ...] = ()
    accuracy: tuple[float, ...] = ()
    impedance: Load | None = None
    actuator: Drive | None = None
    energy_error: float = 0.0

    def to_json(self) -> dict[str, Any]:
        """Plain numbers; complex ones as [real, imaginary]."""
        return {
            **vars(self),
            "load": _numbers(self.load, WISH),
            "impedance": _numbers(self.impedance, WISH),
            "actuator": _numbers(self.actuator, DRIVE),
            "worst_pole": _pair(self.worst_pole),
            "frequencies": list(self.frequencies),
            "Z_measured": [_pair(Z) for Z in self.Z_measured],
            "accuracy": list(self.accuracy),
        }


@dataclass(frozen=True)
class Wall:
    """Stability of one of the range of actuators against a rigid wall; worst pole in rad/s."""

    actuator: Drive
    stable: bool
    worst_pole: complex | None

    def to_json(self) -> dict[str, Any]:
        """Plain numbers; complex ones as [real, imaginary]."""
        return {
            "actuator": _numbers(self.actuator, DRIVE),
            "stable": self.stable,
            "worst_pole": _pair(self.worst_pole),
        }


@dataclass(frozen=True)
class Trials:
    """All trials of one controller, and its poles against a rigid wall [rad/s]: nominal actuator, then its range."""

    trials: tuple[Trial, ...]
    wall_stable: bool
    wall_worst_pole: complex | None
    other_walls: tuple[Wall, ...] = ()

    @property
    def stable(self) -> bool:
        """Stable in free motion with every load, and against the wall, in every member of the ranges."""
        return (
            self.wall_stable
            and all(trial.stable for trial in self.trials)
            and all(wall.stable for wall in self.other_walls)
        )

    def to_json(self) -> dict[str, Any]:
        """Plain numbers; complex ones as [real, imaginary]."""
        wall = {"stable": self.wall_stable, "worst_pole": _pair(self.wall_worst_pole)}
        others = {"actuators": [other.to_json() for other in self.other_walls]} if self.other_walls else {}
        return {"trials": [trial.to_json() for trial in self.trials], "wall": wall | others}


def _numbers(values: object, names: tuple[str, ...]) -> dict[str, float] | None:
    return None if values is None else {name: float(getattr(values, name)) for name in names}


def _pair(value: complex | None) -> list[float] | None:
    return None if value is None else [value.real, value.imag]
