"""The last digits: steps of quadratic programming, optima beside each other, and poles farther out."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from robimp.synthesis.certificate.claims import Counterexample, certify, counterexamples
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.solve.nearby import best_nearby
from robimp.synthesis.solve.nlp import Candidate, Program
from robimp.synthesis.solve.optima import Found, Optima
from robimp.synthesis.solve.places import Grids
from robimp.synthesis.solve.polish import Polisher
from robimp.synthesis.solve.quadratic import quadratic
from robimp.synthesis.solve.search import Search
from robimp.synthesis.solve.structure import FAR, FARTHEST, Feedback, QFilter
from robimp.synthesis.spec import parse_spec

search_module = import_module("robimp.synthesis.solve.search")

ROOT = Path(__file__).parents[2]
GOOD = (ROOT / "tests" / "data" / "specs" / "good.yaml").read_text(encoding="utf-8")
OMEGA_0 = 50.0
ORDER = 4


@cache
def joint() -> Setting:
    return Setting.of(parse_spec(GOOD))


@cache
def rough() -> Candidate:
    """What IPOPT finds on a coarse grid."""
    grids = Grids.of(joint(), OMEGA_0)
    program, rng = Program(joint(), QFilter(ORDER), grids, OMEGA_0), np.random.default_rng(0)
    found = [program.solve(program.structure.start(rng), 0.1 * OMEGA_0, grids) for _ in range(8)]
    return max((c for c in found if c is not None), key=lambda c: c.omega_B)


@cache
def polisher() -> Polisher:
    return Polisher.of(joint(), QFilter(ORDER), OMEGA_0)


# One step


def test_a_quadratic_program_with_a_known_solution() -> None:
    # minimise (d₁² + d₂²)/2 − d₂ with d₁ − d₂ ≥ 1/4: d = (λ, 1 − λ), so λ = 5/8
    solved = quadratic(np.eye(2), np.array([[1.0, -1.0]]), np.array([-0.25]), -np.ones(2), np.ones(2))
    assert solved is not None
    d, short, weights = solved
    assert d == pytest.approx([0.625, 0.375], abs=1e-5) and short == pytest.approx(0, abs=1e-5)
    assert weights == pytest.approx([0.625], abs=1e-4)
    free = quadratic(np.eye(2), np.array([[1.0, -1.0]]), np.array([9.0]), np.full(2, -5.0), np.full(2, 5.0))
    assert free is not None and free[0] == pytest.approx([0, 1], abs=1e-4), "without the row it is elsewhere"


def test_what_a_step_cannot_satisfy_it_falls_short_of_by_the_least() -> None:
    solved = quadratic(
        np.zeros((1, 1)), np.array([[1.0], [-1.0]]), np.array([-3.0, 1.0]), np.full(1, -5.0), np.full(1, 5.0)
    )
    assert solved is not None and solved[0] == pytest.approx([2], abs=1e-4) and solved[1] == pytest.approx(1, abs=1e-4)
    held = quadratic(np.zeros((1, 1)), np.array([[0.0]]), np.array([1.0]), np.full(1, -5.0), np.full(1, 5.0))
    assert held is not None and held[1] == pytest.approx(0, abs=1e-5), "nothing is short where all can be had"


# One optimum


def test_what_is_refined_holds_where_a_rough_optimum_falls_short() -> None:
    at_peaks, at_band = polisher().program.violated(rough(), polisher().finest)
    assert at_peaks or at_band, "the coarse grid is fine enough: nothing to refine"
    again = polisher().again(rough(), polisher().grids)
    assert again is not None
    refined, grids = again
    assert polisher().program.violated(refined, polisher().finest) == ([], [])
    assert grids.omega.size > polisher().grids.omega.size or grids.added
    assert refined.omega_B > 40.2, "the known optimum of this order"


def test_refined_again_it_is_the_same() -> None:
    once = polisher().refined(rough().x, rough().omega_B)
    assert once is not None
    twice = polisher().refined(once.x, once.omega_B)
    assert twice is not None and twice.omega_B == pytest.approx(once.omega_B, rel=1e-6)
    assert abs(rough().omega_B / once.omega_B - 1) > 1e-5, "the start was the optimum already"


def test_a_point_that_no_step_makes_feasible_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    once = polisher().refined(rough().x, rough().omega_B)
    monkeypatch.setattr(import_module("robimp.synthesis.solve.polish"), "STEPS", 0)
    assert polisher().refined(rough().x, 2 * rough().omega_B) is None
    assert once is not None and polisher().refined(once.x, once.omega_B) is not None, "a feasible one is kept"


# Those beside it


def test_random_steps_find_the_same_for_the_same_seed_and_nothing_from_nothing() -> None:
    found = [best_nearby(polisher(), [rough()], None, seed, lambda: False) for seed in (3, 3)]
    one, other = (pair[0] for pair in found if pair is not None)
    assert one.coefficients == other.coefficients
    assert one.omega_B > 40.2
    assert best_nearby(polisher(), [], None, 0, lambda: False) is None
    assert best_nearby(polisher(), [rough()], None, 3, lambda: True) is None, "time is up"


def test_far_poles_are_for_high_orders_and_bounds_say_how_far() -> None:
    assert QFilter(7).wider is None and Feedback(8).wider is None, "this one need not roll off"
    wider = QFilter(8).wider
    assert wider is not None and wider.wider is None and wider != QFilter(8)
    (low, high), (wide_low, wide_high) = QFilter(8).bounds, wider.bounds
    assert np.all(wide_low == low)
    assert np.all(high[:4] == FAR) and np.all(wide_high[:4] == FARTHEST)
    assert wide_high[4] == 1 < high[4] < wide_high[5], "the roll-off, and others that may be real"


def test_what_is_proven_is_kept_when_time_runs_out_or_nothing_better_is_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    proven = Found(Candidate(rough().coefficients, 50.0, np.zeros(16)), 1, 0)
    better, worse = (Candidate(rough().coefficients, omega_B, np.zeros(16)) for omega_B in (51.0, 49.0))
    search = Search(joint(), lambda coefficients, omega_B: (), OMEGA_0, lambda _: None)
    optima = Optima((proven.candidate,), Grids.of(joint(), OMEGA_0))

    def farther(found: Candidate | None) -> Found:
        def stub(polisher: Polisher, *_: object) -> tuple[Candidate, Grids] | None:
            return None if found is None else (found, polisher.grids)

        monkeypatch.setattr(search_module, "best_nearby", stub)
        return search._farther(QFilter(8), proven, optima)

    assert farther(None) is proven
    assert farther(worse) is proven
    assert farther(better).candidate is better
    assert search._farther(QFilter(4), proven, optima) is proven, "no far poles for it: not even looked for"


def test_order_8_comes_within_4_percent_of_the_bound_by_poles_farther_out(monkeypatch: pytest.MonkeyPatch) -> None:
    from robimp.synthesis.solve.bound import bound

    setting = Setting.of(parse_spec(GOOD.replace("order: 4", "order: 8")))
    limit = bound(setting)
    assert limit is not None
    near: list[float] = []
    farther = Search._farther

    def watched(search: Search, structure: QFilter, proven: Found, optima: Optima) -> Found:
        near.append(proven.candidate.omega_B)
        return farther(search, structure, proven, optima)

    monkeypatch.setattr(Search, "_farther", watched)

    def refute(c: Candidate, omega_B: float) -> Sequence[Counterexample]:
        return counterexamples(setting, setting.compensator(c.coefficients), omega_B)

    found = Search(setting, refute, limit.omega_B, lambda _: None, ideal=limit.response).run()
    assert found is not None
    claims = certify(setting, setting.compensator(found.candidate.coefficients))
    assert all(claim.status is Outcome.PROVEN for claim in claims if claim.required)
    proven = next(claim.margin for claim in claims if claim.id == "bandwidth")
    assert proven is not None and float(proven) >= 0.96 * limit.omega_B
    assert near[0] < 0.96 * limit.omega_B, "near poles are enough: nothing is won"
