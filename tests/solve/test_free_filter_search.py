"""A force filter whose corner is searched: one parameter more, and the same loop as with that corner given."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from importlib import import_module

import numpy as np
import pytest
from good_joint import setting

from robimp.synthesis import design
from robimp.synthesis.certificate.claims import Counterexample, counterexamples
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.solve.classical import FARTHEST_CORNER, FORMS, Classical
from robimp.synthesis.solve.corner import Corner
from robimp.synthesis.solve.filtered import Filtered, structure_of
from robimp.synthesis.solve.nlp import Candidate, Program
from robimp.synthesis.solve.places import Grids
from robimp.synthesis.solve.reduction import Response, reduced
from robimp.synthesis.solve.search import Found, Search
from robimp.synthesis.solve.structure import FAR, Feedback, QFilter, Structure
from robimp.synthesis.spec.model import Polynomials

OMEGA_0, CORNER = 40.0, Fraction(70)
CONTROLLERS = {
    "dob": "type: dob, order: 3",
    "feedback": "type: dynamic-feedback, order: 2",
    "classical": "type: dynamic-feedback, form: pi-lead",
}
FAMILIES: list[Structure] = [QFilter(2), QFilter(5), Feedback(0), Feedback(3), *FORMS.values()]


def joint(controller: str, force: str = "free", *pairs: tuple[str, str]) -> Setting:
    return setting(("type: dob, order: 4", f"{controller}, filters: {{force: {force}}}"), *pairs)


def searched(joint: Setting, seed: int = 0, short: bool = False) -> Found:
    def failing(c: Candidate, omega_B: float) -> Sequence[Counterexample]:
        known = joint.resolved(None if c.corner is None else c.corner.omega)
        return counterexamples(known, known.compensator(c.coefficients), omega_B)

    found = Search(joint, failing, 50.0, lambda text: None, seed=seed, short=short).run()
    assert found is not None
    return found


# The parameter


@pytest.mark.parametrize("family", FAMILIES, ids=str)
def test_a_family_behind_a_filter_has_one_parameter_more(family: Structure) -> None:
    behind, rng = Filtered(family), np.random.default_rng(0)
    low, high = behind.bounds
    assert (low[0], high[0]) == (-FAR, FARTHEST_CORNER) and low.size == family.bounds[0].size + 1
    for _ in range(20):
        x = behind.start(rng)
        assert np.all(low <= x) and np.all(x <= high)
        assert behind.rounded(x, OMEGA_0) == family.rounded(x[1:], OMEGA_0), "F is no part of Q or C_imp"
        assert behind.sensor_filter(x) == ([np.exp(x[0])], [1.0, np.exp(x[0])]) and family.sensor_filter(x) is None
    assert family.corner(x, OMEGA_0) is None


def test_a_simpler_family_behind_a_filter_is_extended_with_its_corner() -> None:
    behind, rng = Filtered(QFilter(4)), np.random.default_rng(1)
    assert behind.simpler == (Filtered(QFilter(2)), QFilter(4)) and Filtered(QFilter(2)).simpler == (QFilter(2),)
    assert Filtered(Classical(True, True)).simpler == (Filtered(Classical(True)), Classical(True, True))
    x = Filtered(QFilter(2)).start(rng)
    longer = behind.extended(x, rng, Filtered(QFilter(2)))
    assert longer[0] == x[0] and longer.size == behind.bounds[0].size


def test_without_a_filter_is_with_one_of_the_highest_corner_but_not_of_the_family() -> None:
    behind, rng = Filtered(QFilter(4)), np.random.default_rng(1)
    x = QFilter(4).start(rng)
    assert np.array_equal(behind.extended(x, rng, QFilter(4)), [behind.bounds[1][0], *x])
    assert behind.includes(Filtered(QFilter(2))) and not behind.includes(QFilter(4)) and not behind.includes(QFilter(2))


def test_a_corner_has_six_digits_and_says_where_the_search_ended() -> None:
    of = Filtered(Classical()).corner
    assert of(np.array([0.123456789, 0.0]), 37.0) == Corner(Fraction("41.8618"))
    assert of(np.array([0.123456789, 0.0]), 37.0).note == ""
    high, low = of(np.array([FARTHEST_CORNER, 0.0]), 10.0), of(np.array([-FAR, 0.0]), 10.0)
    assert high == Corner(Fraction(10**6), "highest") and "highest that is searched, 1e+06 rad/s: without" in high.note
    assert low == Corner(Fraction("0.1"), "lowest") and "lowest that is searched" in low.note
    assert of(np.array([0.98 * FARTHEST_CORNER, 0.0]), 10.0).end == "", "near the end is not at it"


def test_only_a_free_corner_is_searched() -> None:
    assert structure_of(joint(CONTROLLERS["dob"]).spec) == Filtered(QFilter(3))
    assert structure_of(joint(CONTROLLERS["dob"], "70").spec) == QFilter(3)
    assert structure_of(joint("type: dynamic-feedback, form: pi-filtered").spec) == Filtered(FORMS["pi-filtered"])


# The program


def slack(joint: Setting, x: np.ndarray) -> np.ndarray:
    """Of every row, constraints and Routh's columns, on one grid."""
    grids = Grids(np.geomspace(1, 1000, 24), np.linspace(0.05, 1, 8))
    program = Program(joint, structure_of(joint.spec), grids, OMEGA_0)
    p, _ = program.placed(grids)
    return np.array(program.slack(np.append(x, np.log(0.3)), p)).ravel()


@pytest.mark.parametrize("controller", CONTROLLERS)
@pytest.mark.parametrize("demand", ["peak: 2.0", "peak: 2.0, friction: require, noise: {gain: 30, above: 5}"])
def test_every_row_is_that_of_the_same_corner_given(controller: str, demand: str) -> None:
    """Constraints and stability of the loop with a searched F, beside a program in which F is a number."""
    free, given = (joint(CONTROLLERS[controller], f, ("peak: 2.0", demand)) for f in ("free", str(CORNER)))
    rng = np.random.default_rng(3)
    for _ in range(5):
        x = structure_of(given.spec).start(rng)
        at_corner, elsewhere = (np.array([np.log(float(CORNER) / OMEGA_0 * k), *x]) for k in (1, 1.1))
        np.testing.assert_allclose(slack(free, at_corner), slack(given, x), rtol=1e-7, atol=1e-9)
        assert not np.allclose(slack(free, elsewhere), slack(given, x), rtol=1e-3), "another corner would be seen"


def test_a_program_that_forgets_the_filter_would_be_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    free, given = (joint(CONTROLLERS["dob"], f) for f in ("free", str(CORNER)))
    x = structure_of(given.spec).start(np.random.default_rng(3))
    monkeypatch.setattr(Filtered, "sensor_filter", lambda self, x, exp=np.exp: None)
    forgetful = slack(free, np.array([np.log(float(CORNER) / OMEGA_0), *x]))
    right = slack(given, x)
    assert forgetful.size != right.size or not np.allclose(forgetful, right, rtol=1e-3)


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_what_a_neighbour_does_behind_its_filter_is_a_start(controller: str) -> None:
    """Q̃ of a controller with its filter, of the equivalent one without, and of the start that is made from it."""
    free, rng = joint(CONTROLLERS[controller]), np.random.default_rng(5)
    structure = structure_of(free.spec)
    x = structure.start(rng)
    coefficients, corner = structure.rounded(x, OMEGA_0), structure.corner(x, OMEGA_0)
    assert corner is not None
    behind, omega = free.resolved(corner.omega), np.geomspace(3, 300, 40)
    wanted = behind.loop.Q_tilde(behind.compensator(coefficients)).at(omega)
    same = Response.of(free, behind.unfiltered(coefficients), omega)
    np.testing.assert_allclose(same.Q_tilde, wanted, rtol=1e-9)
    assert not np.allclose(Response.of(free, coefficients, omega).Q_tilde, wanted, rtol=1e-2), "without F it is another"
    program = Program(free, structure, Grids.of(free, OMEGA_0), OMEGA_0)
    start = reduced(program, same, x + 0.02 * rng.normal(size=x.size))
    near = free.resolved(structure.corner(start, OMEGA_0).omega)  # type: ignore[union-attr]
    again = near.loop.Q_tilde(near.compensator(structure.rounded(start, OMEGA_0))).at(omega)
    np.testing.assert_allclose(again, wanted, atol=0.01)


# The bound


def test_the_bound_is_that_of_any_filter() -> None:
    roll_off = import_module("robimp.synthesis.solve.bound")._roll_off
    feedback, unfiltered = CONTROLLERS["feedback"], ("type: dob, order: 4", CONTROLLERS["feedback"])
    assert roll_off(joint(feedback)) == roll_off(joint(feedback, "50")) == roll_off(joint(feedback, "5000")) == 1
    assert roll_off(setting(unfiltered)) == 0, "without a filter Q̃/H need not roll off"
    assert roll_off(joint(CONTROLLERS["dob"])) == roll_off(setting()) == 2


# The search


def test_a_free_corner_does_at_least_what_given_ones_and_the_filtered_form_do() -> None:
    pi = "type: dynamic-feedback, form: pi"
    found = searched(joint(pi))
    assert found.candidate.corner is not None and 10 < found.candidate.corner.omega < 20
    with_form = searched(setting(("type: dob, order: 4", f"{pi}-filtered")))
    assert found.candidate.omega_B > 0.998 * with_form.candidate.omega_B
    for corner in ("50", "200", "1000"):
        given = searched(joint(pi, corner)).candidate
        assert given.corner is None and found.candidate.omega_B > given.omega_B


def test_an_observer_behind_a_free_filter_does_at_least_what_given_corners_do() -> None:
    found = searched(joint("type: dob, order: 3")).candidate
    assert found.corner is not None
    for corner in ("50", "1000"):
        given = searched(joint("type: dob, order: 3", corner)).candidate
        assert 10 < given.omega_B < found.omega_B, corner


def test_an_optimum_without_a_filter_ends_at_the_highest_corner() -> None:
    found = searched(joint("type: dob, form: eq23")).candidate
    assert found.corner is not None and found.corner.end == "highest"
    assert found.omega_B < searched(joint("type: dob, form: eq23", "null")).candidate.omega_B, "the note is right"


def test_the_same_seed_finds_the_same_digits() -> None:
    one, same = (searched(joint("type: dynamic-feedback, form: p"), seed=7).candidate for _ in range(2))
    assert (one.coefficients, one.corner, one.omega_B) == (same.coefficients, same.corner, same.omega_B)


def test_a_proof_of_one_corner_is_not_taken_for_another(monkeypatch: pytest.MonkeyPatch) -> None:
    """On cells the search's own proof is the certificate's: it is known by its corner, too."""
    sampled = joint(
        "type: dynamic-feedback, form: p", "free", ("peak: 2.0}", "peak: 2.0}\nsampling: {rate: 1 kHz, delay: 0}")
    )
    assert not sampled.polynomial
    asked: list[Fraction | None] = []
    monkeypatch.setattr(design, "counterexamples", lambda setting, C, omega_B: ())
    monkeypatch.setattr(
        design, "certify", lambda setting, C: asked.append(setting.spec.controller.filters.force_corner) or ()
    )
    proofs: design.Proofs = {}
    gain = Polynomials(numerator=(Fraction(9),), denominator=(Fraction(1),))
    for omega in (Fraction(4), Fraction(5)):
        design.refuting(sampled, Candidate(gain, 1.0, np.zeros(2), Corner(omega)), 1.0, proofs)
    assert asked == [4, 5] and len(proofs) == 2


def test_a_short_search_ends_with_a_controller_of_the_family_not_with_one_it_only_begins_from() -> None:
    """What has no filter is simpler, and tried before, but it is not what was asked for."""
    found = searched(joint("type: dob, order: 2"), short=True)
    assert found.candidate.corner is not None
