"""What a grid of a million points does not see, prover and checker do: both ways, and where equality is enough."""

from __future__ import annotations

import json

import numpy as np
import pytest
from needles import HIGH, LOW, Needle, needles
from random_specs import Json, certified, parsed
from tampering import sealed, written

from robimp.synthesis.check import check_bytes

POINTS = 1_000_000
ROUNDING = 1e-12  # what whoever compares floats has to forgive
ALL = needles(POINTS)


def claim(certificate: Json, id: str) -> Json:
    return next(c for c in certificate["claims"] if c["id"] == id)


@pytest.mark.parametrize("needle", ALL, ids=lambda needle: needle.name)
def test_prover_and_checker_know_the_truth(needle: Needle) -> None:
    certificate = certified(parsed(needle.spec))
    false = ("undecided", 5) if "touching where <" in needle.name else ("refuted", 4)
    status, code = ("proven", 0) if needle.truth else false
    assert claim(certificate, needle.id)["status"] == status
    verdict = check_bytes(json.dumps(certificate).encode())
    assert verdict.exit_code == code, verdict.message
    assert needle.truth or needle.id in verdict.message


@pytest.mark.parametrize("needle", [n for n in ALL if not n.truth], ids=lambda needle: needle.name)
def test_a_grid_of_a_million_points_misses_every_false_one(needle: Needle) -> None:
    grid = np.geomspace(LOW, HIGH, POINTS)
    assert np.all(needle.slack(grid) >= -ROUNDING), "the grid sees it: no needle"


@pytest.mark.parametrize("needle", [n for n in ALL if not n.truth], ids=lambda needle: needle.name)
def test_the_checker_refuses_a_forged_claim(needle: Needle) -> None:
    """The false claim written as proven: the checker says where by itself."""
    certificate = certified(parsed(needle.spec))
    forged = claim(certificate, needle.id)
    value = forged["refuted_at"]["value"] if forged["refuted_at"] else "1"
    forged.update(status="proven", margin=value, refuted_at=None)
    verdict = check_bytes(written(sealed(certificate)))
    assert verdict.exit_code in (4, 5) and f"{needle.id} " in verdict.message
    assert verdict.exit_code == 4 or "touching where <" in needle.name
