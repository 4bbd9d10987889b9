"""The golden certificates pass for ever, the must-reject corpus never does, each with its exit code."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from robimp.synthesis.check import check_file

DATA = Path(__file__).parents[1] / "data"
EXPECTED = json.loads((DATA / "expected.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", EXPECTED)
def test_a_file_gets_its_exit_code(name: str) -> None:
    verdict = check_file(DATA / name)
    assert verdict.exit_code == EXPECTED[name]["exit_code"], verdict.message
    assert "\n" not in verdict.message and len(verdict.message) < 300


def test_every_file_is_listed_and_only_golden_ones_pass() -> None:
    files = {f"{folder}/{path.name}" for folder in ("golden", "must-reject") for path in (DATA / folder).glob("*.json")}
    assert files == set(EXPECTED)
    assert all((name.startswith("golden/")) == (entry["exit_code"] == 0) for name, entry in EXPECTED.items())
    assert {entry["exit_code"] for entry in EXPECTED.values()} == {0, 2, 4, 5, 6}


def test_every_golden_certificate_has_a_tampered_twin() -> None:
    golden = [Path(name).stem for name in EXPECTED if name.startswith("golden/") and "--" not in name]
    assert len(golden) >= 6
    for name in golden:
        assert sum(other.startswith(f"must-reject/{name}--") for other in EXPECTED) >= 2
