"""What could mislead the search: a bound nothing sets, starts that agree as they are one, proofs that need room."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from importlib import import_module
from pathlib import Path

import pytest
from good_joint import GOOD, setting

from robimp.synthesis.certificate.claims import Counterexample, counterexamples
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.pipeline import synthesize
from robimp.synthesis.problem.setting import Setting
from robimp.synthesis.solve.nlp import Candidate
from robimp.synthesis.solve.search import Search
from robimp.synthesis.spec import load_spec, parse_spec

search_module = import_module("robimp.synthesis.solve.search")
compute_bound = import_module("robimp.synthesis.solve.bound").bound

ROOT = Path(__file__).parents[2]
EQ23 = ("order: 4", "form: eq23")


def proof(joint: Setting) -> Callable[[Candidate, float], Sequence[Counterexample]]:
    return lambda c, omega_B: counterexamples(joint, joint.compensator(c.coefficients), omega_B)


def test_what_nothing_limits_is_not_given_a_figure() -> None:
    """An ideal actuator with attenuation and a peak alone: any bandwidth can be had. Its twin is limited by noise."""
    series, rest = GOOD[GOOD.index("actuator:") : GOOD.index("impedance:")], "actuator: {type: ideal}\n\n"
    asked = GOOD[GOOD.index("constraints:") : GOOD.index("peak: 2.0}")]
    free = compute_bound(setting((series, rest), (asked, "constraints: {")))
    assert free is not None and not free.limited and free.binding == () and "nothing limits" in free.text
    assert free.omega_B < 1e4, "as far as the joint's frequencies reach, not as far as doubles do"
    noisy = compute_bound(setting((asked, "constraints: {noise: {gain: 2}, ")))
    assert noisy is not None and noisy.limited and "noise" not in noisy.dropped
    assert "noise" in [b.constraint for b in noisy.binding]


def test_an_absurd_expectation_does_not_mislead_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search_module, "FIRST_RANDOM", 8)  # far off they all fail
    joint = setting(EQ23)
    found = Search(joint, proof(joint), 1e8, lambda text: None).run()
    assert found is not None and found.candidate.omega_B == pytest.approx(13.289, rel=1e-3)


def test_starts_from_one_response_have_one_vote() -> None:
    """The UT-SEA: both reductions of the bound's Q̃ end at 21.5 rad/s, random starts at 30.6."""
    joint = Setting.of(load_spec(ROOT / "examples" / "ut-sea.yaml"))
    limit = compute_bound(joint, 40)
    assert limit is not None
    found = Search(
        joint,
        proof(joint),
        limit.omega_B,
        lambda text: None,
        ideal=limit.response,
    ).run()
    assert found is not None and found.candidate.omega_B > 30.5


def test_what_is_active_is_still_proven_on_cells() -> None:
    """With a hold the peak is proven on cells, which resolve a thousandth: the search leaves them room."""
    text = GOOD.replace("order: 4", "form: eq23").replace(
        "peak: 2.0}", "peak: 1.25}\nsampling: {rate: 1 kHz, delay: 1 ms}"
    )
    result = synthesize(parse_spec(text))
    peak = next(claim for claim in result.claims if claim.id == "peak")
    assert result.outcome is Outcome.PROVEN
    assert peak.margin is not None and Fraction("1.22") < peak.margin <= Fraction("1.25"), "it is active"
