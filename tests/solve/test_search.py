"""The bound from above by convexity, the search from below by proof, and the loop that joins them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from robimp.synthesis.certificate.claims import Counterexample, certify, counterexamples
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.errors import UndecidedError
from robimp.synthesis.problem.grid import grid
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.solve.bound import Bound, _Program, laguerre
from robimp.synthesis.solve.infeasible import impossible
from robimp.synthesis.solve.search import REACHED, Found, Refute, Search
from robimp.synthesis.spec import parse_spec
from robimp.synthesis.spec.model import Polynomials

search_module = import_module("robimp.synthesis.solve.search")
compute_bound = import_module("robimp.synthesis.solve.bound").bound

GOOD = (Path(__file__).parents[1] / "data" / "specs" / "good.yaml").read_text(encoding="utf-8")


def setting(*pairs: tuple[str, str]) -> Setting:
    text = GOOD
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return Setting.of(parse_spec(text))


# The bound


@pytest.fixture(scope="module")
def bounds() -> dict[int, Bound]:
    return {terms: compute_bound(setting(), terms) for terms in (12, 24)}


def test_a_larger_basis_never_lowers_the_bound(bounds: dict[int, Bound]) -> None:
    assert bounds[12].omega_B < bounds[24].omega_B < 55
    assert bounds[12].omega_B > 35
    assert bounds[24].terms == 24 and bounds[24].dropped == ("eq9", "eq18")


def test_the_bound_says_what_binds_and_where(bounds: dict[int, Bound]) -> None:
    binding = dict(bounds[24].binding)
    assert "eq12" in binding, "passivity limits this joint"
    assert 0.9 * bounds[24].omega_B < binding["bandwidth"] <= bounds[24].omega_B, "attenuation binds at the band's end"


def test_without_passivity_the_bound_is_far_higher(bounds: dict[int, Bound]) -> None:
    without = compute_bound(setting(("eq12: {form: structured}, ", "")), 12)
    assert without is not None and without.omega_B > 1.5 * bounds[12].omega_B


def program(joint: Setting) -> _Program:
    return _Program(joint, grid(joint, around=40.0, spread=60, dense=60), 12, pole=80.0)


def slacks(found: _Program, k: int) -> dict[str, float]:
    """Least relative slack of every constraint that was kept, by NumPy, at the solver's own X."""
    X, evaluator = found.X.re.value + 1j * found.X.im.value, found.evaluator
    worst: dict[str, float] = {}
    for constraint in found.kept:
        inside = evaluator.inside(constraint)
        if constraint.on_band:
            inside = inside & (np.arange(found.omega.size) <= k)
        for inequality in constraint.inequalities:
            W = evaluator.radius(inequality.source)
            left, right = inequality.sides(float(constraint.level or 0), W, X, lambda r: r.at(found.omega))
            slack = ((right - left) / np.abs(inequality.right.constant.at(found.omega)))[inside]
            worst[constraint.id] = min(worst.get(constraint.id, np.inf), float(slack.min()))
    return worst


def test_the_bounds_optimum_satisfies_its_constraints() -> None:
    found = program(setting())
    k = found.largest_band()
    assert k is not None and 20 < found.omega[k] < 60
    least = slacks(found, k)
    assert set(least) == {"eq12", "bandwidth", "peak"}
    assert min(least.values()) > -1e-4
    assert slacks(found, k + 8)["bandwidth"] < -1e-3, "beyond its band the attenuation fails"


def test_a_band_beyond_the_largest_is_infeasible() -> None:
    found = program(setting())
    k = found.largest_band()
    assert k is not None
    assert found.feasible(k) and not found.feasible(k + 1)


def test_the_basis_is_rational_stable_and_of_the_relative_degree() -> None:
    s = 1j * np.array([1e6, 1e7])
    basis = laguerre(s, 50.0, 5, 2)
    assert basis.shape == (2, 5)
    falls = np.abs(basis[0] / basis[1])
    np.testing.assert_allclose(falls, 100.0, rtol=1e-3)
    np.testing.assert_allclose(laguerre(np.array([0j]), 50.0, 5, 2), 1.0)
    assert not np.allclose(np.abs(laguerre(s, 50.0, 5, 1)[0] / laguerre(s, 50.0, 5, 1)[1]), 100.0)


def test_what_no_controller_can_meet_is_named() -> None:
    paper = impossible(setting(("half-plane", "paper")))
    assert paper is not None and paper.omega == 0 and "(18) paper/physical" in str(paper)
    wide, disc = ("damping: ±40 %", "damping: ±60 %"), ("{form: structured}", "{form: disc}")
    unbounded = impossible(setting(wide, disc, ("eq9: {}, ", "")))
    assert unbounded is not None and "(12) disc" in str(unbounded) and "form: structured" in str(unbounded)
    small_gain = impossible(setting(wide))
    assert small_gain is not None and "(9) printed" in str(small_gain), "(9) needs W < 1 where Q cannot act"
    everywhere = impossible(setting(disc))
    assert everywhere is not None and everywhere.omega == np.inf, "the disc outlasts its budget as ω → ∞"
    assert impossible(setting(("{form: structured}", "{form: disc, band: [0, 30]}"))) is None
    assert impossible(setting()) is None


# The loop with the proof

EQ23 = ("order: 4", "form: eq23")
TOO_COARSE = {"spread": 3, "dense": 3, "band": 3}


def searched(
    joint: Setting,
    monkeypatch: pytest.MonkeyPatch,
    refute: Refute,
    progress: Callable[[str], None] = lambda _: None,
    deadline: float | None = None,
) -> Found | None:
    """A search whose grids are far too coarse to be right by themselves."""
    monkeypatch.setattr(search_module, "FINE", TOO_COARSE)
    monkeypatch.setattr(search_module, "DRAWN", 40)
    return Search(joint, refute, 15.0, progress, deadline=deadline).run()


def proven(joint: Setting, found: Found) -> bool:
    """Whether the exact proof confirms what the search says, up to the share of ω_B it promises."""
    claims = certify(joint, joint.compensator(found.candidate.coefficients))
    band = next(claim for claim in claims if claim.id == "bandwidth")
    complete = all(claim.status is Outcome.PROVEN for claim in claims if claim.required)
    return complete and band.margin is not None and band.margin >= 0.999 * REACHED * found.candidate.omega_B


def test_counterexamples_repair_what_a_coarse_grid_gets_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    joint = setting(EQ23)
    asked: list[Sequence[Counterexample]] = []

    def refute(coefficients: Polynomials, omega_B: float) -> Sequence[Counterexample]:
        asked.append(counterexamples(joint, joint.compensator(coefficients), omega_B))
        return asked[-1]

    said: list[str] = []
    found = searched(joint, monkeypatch, refute, said.append)
    assert found is not None and proven(joint, found)
    assert found.rounds > 1 and found.counterexamples >= 1, "the first candidate needs no repair: the grid is too fine"
    assert asked[0] and all(c.omega > 0 for c in asked[0]) and asked[-1] == ()
    assert 12.5 < found.candidate.omega_B < 13.5
    failures = [text for text in said if "fails" in text]
    assert len(failures) == found.rounds - 1 and f"{asked[0][0].id} at" in failures[0] and "rad/s" in failures[0]


def test_without_counterexamples_the_coarse_candidate_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    joint = setting(EQ23)
    found = searched(joint, monkeypatch, lambda coefficients, omega_B: ())
    assert found is not None and (found.rounds, found.counterexamples) == (1, 0)
    assert not proven(joint, found)
    assert found.candidate.omega_B > 13.5, "it promises more than there is"


def test_a_proof_that_never_comes_ends_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def never(coefficients: Polynomials, omega_B: float) -> Sequence[Counterexample]:
        asked.append(omega_B)
        return (Counterexample("eq12", 50.0, False),)

    monkeypatch.setattr(search_module, "ROUNDS", 2)
    monkeypatch.setattr(search_module, "SCALES", (1.0,))
    assert searched(setting(EQ23), monkeypatch, never) is None
    assert len(asked) >= 2


def test_a_search_out_of_time_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UndecidedError, match="out of time"):
        searched(setting(EQ23), monkeypatch, lambda c, w: (), deadline=0.0)
