"""A map as its file records it: axes, and what became of every cell."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from ...errors import ExitCode, InputError, Location
from ...spec import from_canonical
from ...spec.model import SeriesElasticActuator
from .words import real, units

if TYPE_CHECKING:
    from ...spec.model import Spec

MAX_BYTES = 100_000_000  # a map of 200 × 200 cells has about 20 MB
STATUSES = ("proven", "refuted", "infeasible", "undecided", "error")
STIFFNESS = "impedance.stiffness"
SYMBOLS = {STIFFNESS: "stiffness K_imp", "impedance.damping": "damping B_imp"}


@dataclass(frozen=True)
class Axis:
    """A key and its values. label: with unit, to show."""

    key: str
    values: tuple[float, ...]
    log: bool
    label: str


@dataclass(frozen=True)
class Cell:
    """omega_B: proven [rad/s], None unless status is `proven`; cause: what cells of one reason share."""

    status: str
    omega_B: Fraction | None
    cause: str
    reason: str


@dataclass(frozen=True)
class RecordedMap:
    """A map; cells by their place along the first and the second axis."""

    file: str
    spec: Spec
    digest: str
    axes: tuple[Axis, Axis]
    cells: dict[tuple[int, int], Cell]

    @classmethod
    def of(cls, file: str, data: bytes) -> RecordedMap:
        """From the bytes of a `map.json`. Raises: InputError for anything else, and for a map with cells missing."""
        try:
            content = json.loads(data)
            spec = from_canonical(content["spec"], file)
            first, second = (_axis(axis, spec) for axis in content["axes"])
            cells = {_index(cell): _cell(cell) for cell in content["cells"]}
            digest = str(content["digest"])
        except (ValueError, KeyError, TypeError, AttributeError, ZeroDivisionError, RecursionError) as error:
            advice = "give the map.json that robimp map wrote"
            raise InputError(f"not a map: {type(error).__name__}: {error}; {advice}", Location(file)) from None
        every = {(i, j) for i in range(len(first.values)) for j in range(len(second.values))}
        if len(content["cells"]) != len(every) or set(cells) != every:
            message = f"expected {len(every)} cells; found {len(content['cells'])}; run the same robimp map again"
            raise InputError(message, Location(file))
        return cls(file, spec, digest, (first, second), cells)

    @property
    def counts(self) -> dict[str, int]:
        """How many cells ended how, those that occur."""
        counted = Counter(cell.status for cell in self.cells.values())
        return {status: counted[status] for status in STATUSES if counted[status]}

    @property
    def best(self) -> tuple[int, int] | None:
        """The cell of largest bandwidth."""
        proven = [index for index, cell in self.cells.items() if cell.omega_B is not None]
        return max(proven, key=lambda index: self.cells[index].omega_B or 0, default=None)

    @property
    def causes(self) -> list[tuple[str, str, list[tuple[int, int]]]]:
        """Status, cause and cells of what is not proven, the most frequent first."""
        found: dict[tuple[str, str], list[tuple[int, int]]] = {}
        for index, cell in self.cells.items():
            if cell.status != "proven":
                found.setdefault((cell.status, cell.cause), []).append(index)
        return sorted(((*kind, cells) for kind, cells in found.items()), key=lambda row: -len(row[2]))

    @property
    def exit_code(self) -> ExitCode:
        """As `robimp map` ended: 0 when every cell has an answer, 1 after an error, 5 if one is undecided."""
        if "error" in self.counts:
            return ExitCode.INTERNAL
        return ExitCode.UNDECIDED if "undecided" in self.counts else ExitCode.PROVEN

    @property
    def spring(self) -> float | None:
        """K_sp, where the stiffness is on an axis and every cell has the same spring."""
        keys = [axis.key for axis in self.axes]
        actuator = self.spec.actuator
        fixed = isinstance(actuator, SeriesElasticActuator) and "actuator.spring_stiffness" not in keys
        return real(actuator.spring_stiffness) if fixed and STIFFNESS in keys else None  # type: ignore[union-attr]

    def at(self, index: tuple[int, int]) -> str:
        """The values a cell sets, in words."""
        return ", ".join(f"{axis.key} {axis.values[k]:.5g}" for axis, k in zip(self.axes, index, strict=True))


def is_map(data: bytes) -> bool:
    """Whether bytes mean to be a map, sound or not."""
    return b'"robimp_map"' in data[:1000]


def _axis(written: dict[str, Any], spec: Spec) -> Axis:
    key, values = str(written["key"]), tuple(real(Fraction(value)) for value in written["values"])
    if len(values) < 2 or any(b <= a for a, b in pairwise(values)):
        raise ValueError(f"the values of {key} do not increase")
    dimension = key.rsplit(".", 1)[-1].removeprefix("spring_").removeprefix("motor_")
    unit = units(spec).get(dimension)
    return Axis(key, values, written["scale"] == "log", SYMBOLS.get(key, key) + (f" [{unit}]" if unit else ""))


def _index(written: dict[str, Any]) -> tuple[int, int]:
    i, j = written["cell"]
    return int(i), int(j)


def _cell(written: dict[str, Any]) -> Cell:
    status, omega_B = written["status"], written["omega_B"]
    if status not in STATUSES or (omega_B is None) == (status == "proven"):
        raise ValueError(f"a cell that is {status!r} with ω_B {omega_B!r}")
    return Cell(status, None if omega_B is None else Fraction(omega_B), str(written["cause"]), str(written["reason"]))
