"""Two engines and dense floats agree on polynomials of known truth and on random joints."""

from __future__ import annotations

import json
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import differential_joints
import differential_polynomials
from judge import judge
from physics import Json, num, numbers, system
from random_polynomials import positivity
from random_specs import accepted, certified, extended_spec, parsed, random_spec

from robimp.models.rational import descending
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.spec import canonical

ROOT = Path(__file__).parents[2]
GOLDEN = ROOT / "tests" / "data" / "golden"


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


def test_joints_on_cells_whose_witness_is_at_a_corner() -> None:
    """(12) over the disc that covers a box: its witness is a load of the box, never the nominal one."""
    found = differential_joints.examine([203, 323])
    assert found.faults == [] and found.counts["joints"] == 2
    for seed in (203, 323):
        content = certified(parsed(extended_spec(seed, accepted())))
        (claim,) = (c for c in content["claims"] if c["id"] == "eq12")
        ends = content["spec"]["uncertainty"]["box"]
        assert claim["form"] == "disc" and claim["status"] == "refuted"
        assert all(value in ends[name] for name, value in claim["refuted_at"]["load"].items())


def test_a_margin_the_checker_cannot_confirm_is_conceded() -> None:
    found = differential_joints.examine([374])
    assert found.faults == [] and found.counts["joints with a margin that the checker cannot confirm, conceded"] == 1


def test_a_slow_root_is_counted() -> None:
    """Seed 461's box reaches a joint whose unstable roots turn within a thousandth of their frequency."""
    spec = parsed(extended_spec(461, accepted()))
    C = Setting.of(spec).compensator(spec.controller.coefficients)
    controller = {"C": {"numerator": [*map(str, descending(C.num))], "denominator": [*map(str, descending(C.den))]}}
    load = [171584223 / 2500000000, 158887767959948349 / 500000000000000000, -1310701 / 5000000]
    assert system(canonical(spec), controller, load).unstable() == 2
    assert system(canonical(spec), controller, [0.99 * load[0], *load[1:]]).unstable() == 0


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
                contradicted |= {
                    fault.split()[0] for fault in judge({**certificate, "claims": [claim]}, seed, points=300)[1]
                }
    assert contradicted >= {"bandwidth", "peak", "eq9", "eq12", "eq18", "stability-free", "stability-locked"}


def test_the_grid_of_the_benchmark_computes_the_same_claims() -> None:
    """The rival in `make bench` is a fair one: on a grid it finds every proven margin."""
    found = spec_from_file_location("dense_grid", ROOT / "benchmarks" / "dense_grid.py")
    assert found is not None and found.loader is not None
    module = module_from_spec(found)
    found.loader.exec_module(module)
    certificate = json.loads((GOLDEN / "haninger2016.json").read_bytes())
    margins = module.evaluate(certificate, 20_000)
    compared = 0
    for claim in certificate["claims"]:
        if claim["id"] in ("eq9", "eq18", "peak", "rendering") and claim["status"] == "proven":
            value = abs(margins[claim["id"], claim["form"]])
            assert abs(value / num(claim["margin"]) - 1) < 1e-4, claim["id"]
            compared += 1
    assert compared == 4


def growing(spec: Json, controller: Json, wall: bool) -> int:
    return system(spec, controller, numbers(spec["plant"]), wall=wall).unstable()


def test_the_physics_knows_when_sampling_is_too_slow() -> None:
    """Control of the floats: the paper's joint is unstable in free motion when sampled every 100 ms."""
    certificate = json.loads((GOLDEN / "haninger2016-paper.json").read_bytes())
    for rate, expected in ((None, 0), ("1000", 0), ("100/3", 0), ("10", 2)):
        spec = {**certificate["spec"], "sampling": rate and {"rate": rate, "delay": "0"}}
        assert growing(spec, certificate["controller"], wall=False) == expected
        assert growing(spec, certificate["controller"], wall=True) == 0
