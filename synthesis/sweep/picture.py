"""The map on a terminal: one character for each cell, the first axis upwards."""

from __future__ import annotations

from collections.abc import Iterator

from .cell import Cell, Status
from .result import Map

LETTERS = "abcdefghijklmnopqrstuvwxyz"


def picture(plane_map: Map) -> Iterator[str]:
    """Lines: digits are tenths of the largest proven bandwidth (9: from 90 % up), letters the causes below."""
    first, second = plane_map.plane.axes
    best = plane_map.best
    top = float(best.omega_B or 0) if best is not None else 0.0
    letter = {cause: LETTERS[min(k, len(LETTERS) - 1)] for k, cause in enumerate(plane_map.causes)}

    def sign(cell: Cell) -> str:
        if cell.status is not Status.PROVEN:
            return letter[cell.cause]
        return str(min(int(10 * float(cell.omega_B or 0) / top), 9)) if top else "0"

    labels = [f"{value:.4g}" for value in first.floats]
    width = max(map(len, labels))
    yield first.key
    for i in reversed(range(len(first.values))):
        row = " ".join(sign(plane_map.cells[i, j]) for j in range(len(second.values)))
        mark = "  ← K_sp" if _first_above_spring(plane_map, i) else ""
        yield f"{labels[i]:>{width}} │ {row}{mark}"
    low, high = (f"{second.floats[k]:.4g}" for k in (0, -1))
    line = 2 * len(second.values) - 1
    yield f"{'':>{width}} └{'─' * (line + 1)}"
    yield f"{'':>{width}}   {low}{high:>{max(line - len(low), len(high) + 1)}}  {second.key}"
    if best is not None:
        at = ", ".join(f"{key} {float(value):.4g}" for key, value in _decimals(plane_map, best))
        yield f"digits: tenths of the largest proven ω_B, {top:.4g} rad/s, at {at}"
    for cause, cell in plane_map.causes.items():
        n = sum(c.cause == cause and c.status is not Status.PROVEN for c in plane_map.cells.values())
        at = ", ".join(f"{key} {value:.4g}" for key, value in _decimals(plane_map, cell))
        yield f"{letter[cause]}: {n} cell{'s' if n > 1 else ''} {cell.status.value}, such as {at}: {cell.reason}"


def _decimals(plane_map: Map, cell: Cell) -> list[tuple[str, float]]:
    axes = plane_map.plane.axes
    return [(axis.key, axis.floats[k]) for axis, k in zip(axes, cell.index, strict=True)]


def _first_above_spring(plane_map: Map, i: int) -> bool:
    """Whether a row is the first whose stiffness exceeds the spring's."""
    axis, spring = plane_map.plane.axes[0], plane_map.spring
    if spring is None or axis.key != "impedance.stiffness":
        return False
    return axis.floats[i] > float(spring) and (i == 0 or axis.floats[i - 1] <= float(spring))
