"""The search, its loop with the proof, and what is impossible from the start."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from good_joint import setting

from robimp.synthesis.certificate.claims import Counterexample, certify, counterexamples
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.errors import UndecidedError
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.solve.infeasible import impossible
from robimp.synthesis.solve.nlp import Candidate, Program
from robimp.synthesis.solve.places import Grids
from robimp.synthesis.solve.reduction import Response, reduced
from robimp.synthesis.solve.search import REACHED, Found, Optima, Refute, Search
from robimp.synthesis.solve.structure import QFilter, Structure
from robimp.synthesis.spec.model import Polynomials

search_module = import_module("robimp.synthesis.solve.search")
places_module = import_module("robimp.synthesis.solve.places")
compute_bound = import_module("robimp.synthesis.solve.bound").bound


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
TOO_COARSE = {"SPREAD": 3, "DENSE": 3, "BAND": 3}


def searched(
    joint: Setting,
    monkeypatch: pytest.MonkeyPatch,
    refute: Refute,
    progress: Callable[[str], None] = lambda _: None,
    deadline: float | None = None,
) -> Found | None:
    """A search whose grids are far too coarse to be right by themselves."""
    for name, points in TOO_COARSE.items():
        monkeypatch.setattr(places_module, name, points)
    monkeypatch.setattr(search_module, "FINER", 1)
    monkeypatch.setattr(search_module, "DRAWN", 40)
    monkeypatch.setattr(Program, "resonances", lambda self, candidate: np.zeros(0))
    return Search(joint, refute, 15.0, progress, deadline=deadline).run()


def failing(joint: Setting, c: Candidate, omega_B: float) -> Sequence[Counterexample]:
    """The proof, as the search asks for it."""
    return counterexamples(joint, joint.compensator(c.coefficients), omega_B)


def proven(joint: Setting, found: Found) -> bool:
    """Whether the exact proof confirms what the search says, up to the share of ω_B it promises."""
    claims = certify(joint, joint.compensator(found.candidate.coefficients))
    band = next(claim for claim in claims if claim.id == "bandwidth")
    complete = all(claim.status is Outcome.PROVEN for claim in claims if claim.required)
    return complete and band.margin is not None and band.margin >= 0.999 * REACHED * found.candidate.omega_B


def test_counterexamples_repair_what_a_coarse_grid_gets_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    joint = setting(EQ23)
    asked: list[Sequence[Counterexample]] = []

    def refute(c: Candidate, omega_B: float) -> Sequence[Counterexample]:
        asked.append(counterexamples(joint, joint.compensator(c.coefficients), omega_B))
        return asked[-1]

    said: list[str] = []
    found = searched(joint, monkeypatch, refute, said.append)
    assert found is not None and proven(joint, found)
    assert found.rounds > 1 and found.counterexamples >= 1, "the first candidate needs no repair: the grid is too fine"
    assert asked[0] and all(c.omega > 0 for c in asked[0]) and asked[-1] == ()
    assert 12.5 < found.candidate.omega_B < 13.5
    failures = [text for text in said if "fails" in text]
    numbers = [int(text.split()[1]) for text in failures]
    assert numbers[1 - found.rounds :] == list(range(1, found.rounds)), (
        "each candidate's own, the last one's at the end"
    )
    assert f"{asked[0][0].id} at" in failures[0] and "rad/s" in failures[0]


def test_without_counterexamples_the_coarse_candidate_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    joint = setting(EQ23)
    found = searched(joint, monkeypatch, lambda coefficients, omega_B: ())
    assert found is not None and (found.rounds, found.counterexamples) == (1, 0)
    assert not proven(joint, found)
    assert found.candidate.omega_B > 13.5, "it promises more than there is"


def test_a_proof_that_never_comes_ends_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def never(c: Candidate, omega_B: float) -> Sequence[Counterexample]:
        asked.append(omega_B)
        return (Counterexample("eq12", 50.0, False),)

    monkeypatch.setattr(search_module, "ROUNDS", 2)
    monkeypatch.setattr(search_module, "SCALES", (1.0,))
    assert searched(setting(EQ23), monkeypatch, never) is None
    assert len(asked) >= 2


def test_where_nothing_of_an_order_is_proven_the_next_lower_one_is_searched_for_its_own_sake(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    said, tried, genuine = list[str](), list[Structure](), Search._best

    def reluctant(search: Search, program: Program, optima: Optima) -> Found | None:
        tried.append(program.structure)
        return None if len(tried) < 3 else genuine(search, program, optima)

    monkeypatch.setattr(Search, "_best", reluctant)
    found = Search(setting(("order: 4", "order: 3")), lambda c, w: (), 40.0, said.append).run()
    assert found is not None and len(found.candidate.coefficients.denominator) == 3
    assert tried == [QFilter(3), QFilter(2), QFilter(2)]
    assert any("nothing proven; searching" in text and "its own sake" in text for text in said)


def test_a_search_out_of_time_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UndecidedError, match="out of time"):
        searched(setting(EQ23), monkeypatch, lambda c, w: (), deadline=0.0)


def quick(joint: Setting, **options: Any) -> Search:
    """A search whose prover asks for nothing."""
    return Search(joint, lambda coefficients, omega_B: (), 15.0, lambda text: None, **options)


def test_the_same_seed_finds_the_same_digits() -> None:
    one, other = (quick(setting(EQ23), seed=seed).run() for seed in (3, 3))
    assert one is not None and other is not None
    assert one.candidate.coefficients == other.candidate.coefficients


def test_orders_searched_before_are_not_searched_again() -> None:
    known: dict[Any, Any] = {}
    said: list[str] = []
    first = Search(setting(EQ23), lambda c, w: (), 50.0, said.append, known=known).run()
    again = Search(setting(EQ23), lambda c, w: (), 50.0, said.append, known=known).run()
    assert first is not None and again is not None and again.candidate == first.candidate
    assert len(said) == 1 and len(known) == 1


def test_a_given_controller_is_one_start_among_the_others() -> None:
    """A poor one costs nothing but time; what a search without it finds is still found."""
    joint = setting(("order: 4", "order: 3"))
    paper = Polynomials(numerator=(Fraction(2000),), denominator=(Fraction(1), Fraction("70.75"), Fraction(2500)))
    found, said = [], list[str]()
    for starts in ((), ((paper, 8.87),)):
        search = Search(joint, lambda c, w: (), 50.0, said.append, starts=starts)
        optimum = search.run()
        assert optimum is not None
        found.append(optimum.candidate.omega_B)
        grids = Grids.of(joint, 50.0)
        each = [s.omega_B for s in search._starts(Program(joint, QFilter(3), grids, 50.0), Optima((), grids), True)]
        assert sum(omega_B in (0.95 * 8.87, 0.8 * 8.87) for omega_B in each) == 2 * len(starts) < len(each)
    assert found[1] >= 0.999 * found[0] > 13
    assert said == ["searching QFilter(order=2)", "searching QFilter(order=3)"] * 2


def test_a_response_is_reduced_to_the_order_asked_for() -> None:
    """From a controller of the family its own response leads back to it; of a lower order, only near it."""
    joint, omega = setting(), np.geomspace(1, 500, 80)
    target, rng = QFilter(4), np.random.default_rng(1)
    x = target.start(rng)
    ideal = Response.of(joint, target.rounded(x, 50.0), omega)
    program_ = Program(joint, target, Grids.of(joint, 50.0), 50.0)
    back = reduced(program_, ideal, x + 0.05 * rng.normal(size=x.size))
    error = np.abs(Response.of(joint, target.rounded(back, 50.0), omega).Q_tilde - ideal.Q_tilde).max()
    lower = Program(joint, QFilter(2), Grids.of(joint, 50.0), 50.0)
    near = reduced(lower, ideal, QFilter(2).start(rng))
    difference = np.abs(Response.of(joint, QFilter(2).rounded(near, 50.0), omega).Q_tilde - ideal.Q_tilde).max()
    assert error < 1e-3 < difference < 1


CLASSICAL = {"pi": (12.5, 13.5), "lead-lag": (13.2, 14.5), "pi-lead": (21, 23), "lead-lag-filtered": (19, 22)}


@pytest.mark.parametrize("form", CLASSICAL)
def test_classical_feedback_is_found_stable_and_proven(form: str) -> None:
    joint = setting(("type: dob, order: 4", f"type: dynamic-feedback, form: {form}"))
    found = Search(joint, partial(failing, joint), 50.0, lambda text: None).run()
    assert found is not None and proven(joint, found)
    low, high = CLASSICAL[form]
    assert low < found.candidate.omega_B < high
    den = found.candidate.coefficients.denominator
    assert (den[-1] == 0) == form.startswith("pi")


def test_orders_6_and_8_on_the_reference_joint() -> None:
    """In one chain: each order begins from the one below. Proven at these figures, not hoped."""
    known: dict[Any, Any] = {}
    reached = {}
    for order in (6, 8):
        joint = setting(("order: 4", f"order: {order}"))
        found = Search(joint, partial(failing, joint), 52.7, lambda text: None, known=known).run()
        assert found is not None and proven(joint, found)
        assert len(found.candidate.coefficients.denominator) == order + 1
        reached[order] = found.candidate.omega_B
    assert reached[6] >= 48 and reached[8] >= 50.7
    assert reached[8] > reached[6]


# Time


def in_time(monkeypatch: pytest.MonkeyPatch, cut: int, **options: Any) -> tuple[Found | None, list[Structure]]:
    """A search of order 4 whose time is up when the program has been solved so often; and what it tried to prove."""
    clock, asked, solve, genuine = [0.0], list[Structure](), Program.solve, Search._best

    def counted(program: Program, *arguments: Any, **more: Any) -> Any:
        clock[0] += 1.0
        return solve(program, *arguments, **more)

    def proving(search: Search, program: Program, optima: Optima) -> Found | None:
        asked.append(program.structure)
        return genuine(search, program, optima)

    monkeypatch.setattr(Program, "solve", counted)
    monkeypatch.setattr(Search, "_best", proving)
    monkeypatch.setattr(search_module.time, "monotonic", lambda: clock[0])
    joint = setting()
    refute = partial(lambda joint, c, w: counterexamples(joint, joint.compensator(c.coefficients), w), joint)
    found = Search(joint, refute, 50.0, lambda text: None, deadline=cut - 0.5, **options).run()
    return found, asked


@pytest.mark.parametrize(("cut", "order"), [(8, 2), (10**6, 4)])
def test_out_of_time_the_best_that_is_known_is_proven(monkeypatch: pytest.MonkeyPatch, cut: int, order: int) -> None:
    known: dict[Any, Any] = {}
    found, asked = in_time(monkeypatch, cut, known=known)
    assert found is not None and proven(setting(), found)
    assert len(found.candidate.coefficients.denominator) == order + 1 and asked[-1] == QFilter(order)
    assert found.late is (cut < 10**6)
    assert len(known) == (0 if found.late else 2), "what was not searched to its end is not handed on"


def test_out_of_time_before_there_is_anything_is_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UndecidedError, match="out of time"):
        in_time(monkeypatch, 1)


def test_a_filter_costs_nothing_and_a_higher_order_never_ends_lower() -> None:
    """The forms and orders of dynamic-error feedback, each against all it contains."""
    reached: dict[str, float] = {}
    for controller in ("form: pi-lead", "form: pi-lead-filtered", "order: 3", "order: 4"):
        joint = setting(("type: dob, order: 4", f"type: dynamic-feedback, {controller}"))
        refute = partial(lambda joint, c, w: counterexamples(joint, joint.compensator(c.coefficients), w), joint)
        found = Search(joint, refute, 53.5, lambda text: None).run()
        assert found is not None and proven(joint, found)
        reached[controller] = found.candidate.omega_B
    assert reached["form: pi-lead-filtered"] > 0.9999 * reached["form: pi-lead"] > 21.7
    assert reached["order: 4"] >= reached["order: 3"] > 42
