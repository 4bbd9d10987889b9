"""Add golden certificates and their tampered twins to the corpus: `python tests/evidence/golden.py`.

golden/: every specification of golden/specs/ whose certificate is proven; must-reject/: the others, and twins.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from tampering import claimed, twins, valid

from robimp.synthesis import load, synthesize
from robimp.synthesis.check import check_bytes

ROOT = Path(__file__).parents[2]
DATA = ROOT / "tests" / "data"
GOLDEN, REJECT = "golden", "must-reject"
SPECS = sorted((DATA / GOLDEN / "specs").glob("*.yaml"))
BASE = "ideal-box"  # the small one that most twins are made of


def main() -> None:
    """Synthesise, tamper, write; the exit codes are those the twins are made for, not those found.

    The corpus only grows: what is there stays as it is, and is what a later version has to read.
    """
    expected: dict[str, dict[str, object]] = json.loads((DATA / "expected.json").read_text(encoding="utf-8"))

    def write(file: str, data: bytes, exit_code: int, why: str) -> None:
        if file not in expected:
            (DATA / file).write_bytes(data)
            expected[file] = {"exit_code": exit_code, "why": why}
            sys.stdout.write(f"{file}\n")

    for path in SPECS:
        if any(f"{folder}/{path.stem}.json" in expected for folder in (GOLDEN, REJECT)):
            continue
        data = synthesize(load(path)).certificate_bytes()
        verdict = check_bytes(data)
        if verdict.exit_code != 0:  # an honest certificate of a refuted claim
            write(f"{REJECT}/{path.stem}.json", data, 4, verdict.message)
            write(f"{REJECT}/{path.stem}--claimed.json", claimed(data), 4, "what is refuted is claimed to be proven")
            continue
        write(f"{GOLDEN}/{path.stem}.json", data, 0, verdict.message)
        for twin in valid(data) if path.stem == BASE else ():
            write(f"{GOLDEN}/{BASE}--{twin.name}.json", twin.data, 0, twin.why)
        for twin in twins(data, every=path.stem == BASE):
            write(f"{REJECT}/{path.stem}--{twin.name}.json", twin.data, twin.exit_code, twin.why)
    (DATA / "expected.json").write_text(json.dumps(expected, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
