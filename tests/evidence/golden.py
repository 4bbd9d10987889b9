"""Write the golden certificates and their tampered twins again: `python tests/evidence/golden.py`.

golden/: every example of examples/ and golden/specs/ whose certificate is proven; must-reject/: the others, and twins.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from tampering import twins, valid

from robimp.synthesis import load, synthesize
from robimp.synthesis.check import check_bytes

ROOT = Path(__file__).parents[2]
DATA = ROOT / "tests" / "data"
GOLDEN, REJECT = DATA / "golden", DATA / "must-reject"
SPECS = [*sorted((ROOT / "examples").glob("*.yaml")), *sorted((GOLDEN / "specs").glob("*.yaml"))]
BASE = "ideal-box"  # the small one that most twins are made of


def write(path: Path, data: bytes) -> None:
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(data)
    sys.stdout.write(f"{path.relative_to(ROOT)}\n")


def main() -> None:
    """Synthesise, write, tamper, write; the exit codes are those the twins are made for, not those found."""
    for old in [*GOLDEN.glob("*.json"), *REJECT.glob("*.json")]:
        old.unlink()
    expected: dict[str, dict[str, object]] = {}
    proven: dict[str, bytes] = {}
    for path in SPECS:
        data = synthesize(load(path)).certificate_bytes()
        verdict = check_bytes(data)
        if verdict.exit_code == 0:
            proven[path.stem] = data
            write(GOLDEN / f"{path.stem}.json", data)
            expected[f"golden/{path.stem}.json"] = {"exit_code": 0, "why": verdict.message}
        else:  # an honest certificate of a refuted claim
            write(REJECT / f"{path.stem}.json", data)
            expected[f"must-reject/{path.stem}.json"] = {"exit_code": 4, "why": verdict.message}
    for twin in valid(proven[BASE]):
        file = f"golden/{BASE}--{twin.name}.json"
        write(DATA / file, twin.data)
        expected[file] = {"exit_code": 0, "why": twin.why}
    for name, data in proven.items():
        for twin in twins(data, every=name == BASE):
            file = f"must-reject/{name}--{twin.name}.json"
            write(DATA / file, twin.data)
            expected[file] = {"exit_code": twin.exit_code, "why": twin.why}
    write(DATA / "expected.json", (json.dumps(expected, indent=1, ensure_ascii=False) + "\n").encode())


if __name__ == "__main__":
    main()
