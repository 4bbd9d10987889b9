"""dkpy's own tutorial, D–K iteration on its distillation column, against `robimp synth`: whole processes.

The two solve different problems; what is compared is the time a user waits for the example each project shows first.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from task import ROOT

RUNS = 3
TUTORIAL = """
import dkpy, numpy as np
column = dkpy.example_skogestad2006_p325()
iteration = dkpy.DkIterFixedOrder(
    controller_synthesis=dkpy.HinfSynSlicot(), structured_singular_value=dkpy.SsvLmiBisection(),
    d_scale_fit=dkpy.DScaleFitSlicot(), n_iterations=3, fit_order=4)
blocks = [dkpy.ComplexFullBlock(n, n) for n in (1, 1, 2)]
iteration.synthesize(column["P"], column["n_y"], column["n_u"], np.logspace(-3, 3, 61), blocks)
"""


def compare(runs: int = RUNS) -> dict[str, Any]:
    """Seconds of both, alternating, on the clock and of the processor; median ratios."""
    if find_spec("dkpy") is None:
        return {"text": "dkpy's tutorial: skipped, needs the package dkpy: pip install '.[bench]'"}
    _synth()  # writes the bytecode that an installed package has
    pairs = [(_synth(), _seconds([sys.executable, "-c", TUTORIAL])) for _ in range(runs)]
    clock, processor = ([(ours[kind], theirs[kind]) for ours, theirs in pairs] for kind in (0, 1))
    ratio, cpu_ratio = (statistics.median(ours / theirs for ours, theirs in each) for each in (clock, processor))
    ours, theirs = (statistics.median(times) for times in zip(*clock, strict=True))
    text = (
        f"robimp synth examples/haninger2016.yaml {ours:.1f} s, dkpy's tutorial {theirs:.1f} s: ratio {ratio:.2f}, "
        f"of processor seconds {cpu_ratio:.2f} (medians of {runs} alternating runs)"
    )
    return {"text": text, "seconds": clock, "ratio": ratio, "cpu_seconds": processor, "cpu_ratio": cpu_ratio}


def _synth() -> tuple[float, float]:
    with tempfile.TemporaryDirectory() as folder:
        robimp = Path(sys.executable).with_name("robimp")
        return _seconds([str(robimp), "synth", str(ROOT / "examples" / "haninger2016.yaml"), "-o", folder])


def _seconds(command: list[str]) -> tuple[float, float]:
    """Of a whole process, on the clock and of the processor."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    began, spent = time.monotonic(), _spent()
    subprocess.run(command, capture_output=True, check=True, env=environment)
    return time.monotonic() - began, _spent() - spent


def _spent() -> float:
    children = os.times()
    return children.children_user + children.children_system
