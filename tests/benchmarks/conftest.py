from __future__ import annotations

import sys
from pathlib import Path

RIVALS = Path(__file__).parents[2] / "benchmarks" / "rivals"
sys.path.insert(0, str(RIVALS))  # as `python benchmarks/rivals` has it
