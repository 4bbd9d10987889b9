"""A finished map: its cells, what they amount to, and its file."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from ..errors import ExitCode
from ..spec.model import SeriesElasticActuator
from .cell import Cell, Status
from .plane import Index, Plane

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

STIFFNESS = "impedance.stiffness"


@dataclass(frozen=True)
class Map:
    """Proven bandwidth over a plane. certificates: whether one file for each proven cell was written."""

    plane: Plane
    cells: dict[Index, Cell]
    certificates: bool = False

    def __repr__(self) -> str:
        said = ", ".join(f"{n} {status.value}" for status, n in self.counts.items() if n)
        return f"<Map {self.plane.spec.name}: {len(self.cells)} cells, {said}>"

    def _repr_html_(self) -> str:
        from ..report.cards import map_card

        return map_card(self)

    @property
    def counts(self) -> dict[Status, int]:
        """How many cells ended how."""
        counted = Counter(cell.status for cell in self.cells.values())
        return {status: counted[status] for status in Status}

    @property
    def best(self) -> Cell | None:
        """The cell of largest proven bandwidth."""
        proven = [cell for cell in self.cells.values() if cell.omega_B is not None]
        return max(proven, key=lambda cell: cell.omega_B or 0, default=None)

    @property
    def causes(self) -> dict[str, Cell]:
        """Why cells are not proven: every cause with its first cell, the most frequent first."""
        without = [cell for cell in self.cells.values() if cell.status is not Status.PROVEN]
        often = Counter(cell.cause for cell in without)
        return {cause: next(cell for cell in without if cell.cause == cause) for cause, _ in often.most_common()}

    @property
    def exit_code(self) -> ExitCode:
        """0 when every cell has an answer, infeasible and refuted ones included; 1 after an error, 5 if undecided."""
        if self.counts[Status.ERROR]:
            return ExitCode.INTERNAL
        return ExitCode.UNDECIDED if self.counts[Status.UNDECIDED] else ExitCode.PROVEN

    @property
    def spring(self) -> Fraction | None:
        """K_sp, where the stiffness is on an axis and every cell has the same spring."""
        actuator, keys = self.plane.spec.actuator, [axis.key for axis in self.plane.axes]
        if not isinstance(actuator, SeriesElasticActuator) or "actuator.spring_stiffness" in keys:
            return None
        return actuator.spring_stiffness if STIFFNESS in keys else None

    def bandwidth(self) -> NDArray[np.float64]:
        """Proven ω_B [rad/s], nan where nothing is proven. Returns (n first axis, n second axis)."""
        import numpy as np

        values = np.full([len(axis.values) for axis in self.plane.axes], np.nan)
        for index, cell in self.cells.items():
            if cell.omega_B is not None:
                values[index] = float(cell.omega_B)
        return values

    def to_json(self) -> dict[str, Any]:
        """The map's file: what it is of, counts, and every cell with the values it sets."""
        return {
            "robimp_map": 1,
            "exit_code": int(self.exit_code),
            **self.plane.to_json(),
            "counts": {status.value: n for status, n in self.counts.items()},
            "cells": [self._cell(index) for index in self.plane],
        }

    def _cell(self, index: Index) -> dict[str, Any]:
        cell = self.cells[index]
        line = {**cell.to_json(), "values": self.plane.values(index)}
        if self.certificates and cell.status is Status.PROVEN:
            line["certificate"] = certificate_name(index)
        return line


def certificate_name(index: Index) -> str:
    """Of a cell's certificate, from the map's folder."""
    return f"certificates/cell-{index[0]}-{index[1]}.json"
