"""Two engines and dense floats agree on polynomials of known truth and on random joints."""

from __future__ import annotations

import differential_joints
import differential_polynomials
from judge import judge
from physics import num
from random_polynomials import positivity
from random_specs import certified, parsed, random_spec


def test_polynomials_of_known_truth() -> None:
    found = differential_polynomials.examine(range(differential_polynomials.SMALL))
    assert found.faults == []
    for kind in ("positivity > 0", "positivity >= 0", "hurwitz", "sums of 1 roots", "sums of 2 roots"):
        assert found.counts[f"{kind}, true"] > 5 and found.counts[f"{kind}, false"] > 5


def test_the_polynomials_hold_what_is_hard() -> None:
    cases = [positivity(seed) for seed in range(300)]
    assert any(case.truth(strict=False) and any(r.times == 2 for r in case.inside()) for case in cases)
    assert any(r.b > 0 for case in cases for r in case.inside()), "irrational roots"
    assert any(r.above(case.lo) == 0 for case in cases for r in case.roots), "a root at an end"
    assert any(case.lost and case.hi is None for case in cases), "a root at infinity"


def test_random_joints() -> None:
    found = differential_joints.examine(range(differential_joints.SMALL))
    assert found.faults == []
    assert found.counts["claims proven"] > 20 and found.counts["claims refuted"] > 5


def test_the_floats_contradict_a_margin_that_is_too_good() -> None:
    """Control: every claim's margin moved beyond the level at which it was refuted."""
    contradicted = set()
    for seed in range(12):
        certificate = certified(parsed(random_spec(seed)))
        for claim in certificate["claims"]:
            twin = claim["refuted_at"]
            if claim["status"] == "proven" and twin is not None and twin["omega"] not in ("0", "inf"):
                harder = 1.01 if claim["id"] not in ("peak", "rendering") else 0.99
                claim["margin"] = str(num(twin["value"]) * harder)
                if claim["id"] == "bandwidth":
                    claim["interval"][1] = claim["margin"]
                contradicted |= {fault.split()[0] for fault in judge(certificate, seed)[1]}
    assert contradicted >= {"bandwidth", "peak", "eq9", "eq12", "eq18", "stability-free", "stability-locked"}
