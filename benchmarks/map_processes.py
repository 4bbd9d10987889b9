"""A map on one process and on two: `python benchmarks/map_processes.py [N [SPEC]]`, N × N cells.

By default the cells certify a given controller; a specification with an order or a form makes them search for one.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

from robimp.synthesis import map_plane

SPEC = Path(__file__).parents[1] / "examples" / "haninger2016-paper.yaml"


def seconds(n: int, processes: int, spec: Path) -> tuple[float, float]:
    """Wall time of a map, and the share of it that its workers were busy."""
    axes = {"impedance.stiffness": f"0.2:10:{n}", "impedance.damping": f"0.1:0.6:{n}"}
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        found = map_plane(spec, axes, folder, processes=processes)
        wall = time.perf_counter() - began
    return wall, sum(cell.seconds for cell in found.cells.values()) / (processes * wall)


def main() -> None:
    """Print both times and their ratio."""
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    spec = Path(sys.argv[2]) if len(sys.argv) > 2 else SPEC
    (one, busy_one), (two, busy_two) = (seconds(n, processes, spec) for processes in (1, 2))
    print(
        f"{n} × {n} cells: 1 process {one:.1f} s (busy {busy_one:.0%}), 2 processes {two:.1f} s (busy {busy_two:.0%})"
    )
    print(f"ratio {one / two:.2f}")


if __name__ == "__main__":
    main()
