"""Reading a specification costs no heavy import."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

HEAVY = {"numpy", "scipy", "flint", "casadi", "cvxpy", "clarabel", "control", "matplotlib"}
GOOD = Path(__file__).parents[1] / "data" / "specs" / "good.yaml"


def imported(code: str) -> set[str]:
    command = [sys.executable, "-c", f"import sys\n{code}\nprint(*sys.modules)"]
    return set(subprocess.run(command, capture_output=True, text=True, check=True).stdout.split())


def test_reading_a_specification_imports_nothing_heavy() -> None:
    load = f"from pathlib import Path\nfrom robimp.synthesis.spec import load_spec\nload_spec(Path({str(GOOD)!r}))"
    modules = imported(load)
    assert "robimp.synthesis.spec.load" in modules
    assert not HEAVY & modules
    assert HEAVY & imported(load + "\nimport numpy")
