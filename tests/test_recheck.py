"""Where prover and checker differ: a contradiction ends everything, a doubt makes the claim smaller."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from robimp.synthesis import recheck
from robimp.synthesis.certificate.claim import Claim
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.check import Verdict, check_bytes
from robimp.synthesis.check.reader import read
from robimp.synthesis.errors import ExitCode, RobimpError, UndecidedError
from robimp.synthesis.pipeline import Result, setting_of, synthesize
from robimp.synthesis.spec import load_spec

SPEC = load_spec(Path(__file__).parents[1] / "examples" / "haninger2016-paper.yaml")


@pytest.fixture(scope="module")
def paper() -> Result:
    return synthesize(SPEC)


def unsure_above(kind: tuple[str, str], level: Fraction, code: int = ExitCode.UNDECIDED) -> Any:
    """A checker that confirms one claim only up to a level."""

    def doubting(data: bytes, **_: Any) -> Verdict:
        genuine = check_bytes(data)
        claim = next(c for c in read(data)["claims"] if (c["id"], c["form"]) == kind)
        if claim["status"] != "proven" or claim["margin"] <= level:
            return genuine
        said = tuple((*c[:2], "not verified", "hm") if c[:2] == kind else c for c in genuine.claims)
        return Verdict(code, "hm", None, said)

    return doubting


def of(claims: tuple[Claim, ...], kind: tuple[str, str]) -> Claim:
    return next(c for c in claims if (c.id, c.form) == kind)


@pytest.mark.parametrize("kind", [("eq9", "printed"), ("stability-free", "box"), ("eq12", "structured")])
def test_a_margin_the_checker_doubts_comes_nearer_to_what_is_required(
    paper: Result, kind: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    required = Fraction(kind[0] != "eq12")
    before = of(paper.claims, kind)
    assert before.margin is not None and before.margin > required
    level = required + (before.margin - required) / 3
    monkeypatch.setattr(recheck, "check_bytes", unsure_above(kind, level))
    after = synthesize(SPEC)
    margin = of(after.claims, kind).margin
    assert margin is not None and required <= margin <= level
    assert of(after.claims, kind) == replace(before, margin=margin), "its witness stays"
    assert after.outcome is Outcome.PROVEN and check_bytes(after.certificate_bytes()).exit_code == 0


def test_what_is_required_is_never_conceded(paper: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recheck, "check_bytes", unsure_above(("eq9", "printed"), Fraction(1, 2)))
    with pytest.raises(UndecidedError, match="the independent checker cannot confirm it: hm"):
        synthesize(SPEC)
    claim = replace(of(paper.claims, ("eq9", "printed")), margin=Fraction(1))
    assert recheck.conceded(setting_of(SPEC), claim) is None
    reported = recheck.conceded(setting_of(SPEC), replace(claim, required=False))
    assert reported is not None and reported.status is Outcome.UNDECIDED


def test_the_bandwidth_is_never_conceded_because_other_claims_end_there(
    paper: Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert recheck.conceded(setting_of(SPEC), of(paper.claims, ("bandwidth", "attenuation"))) is None
    monkeypatch.setattr(recheck, "check_bytes", unsure_above(("bandwidth", "attenuation"), Fraction(1)))
    with pytest.raises(UndecidedError, match="cannot confirm it: hm"):
        synthesize(SPEC)


def test_the_tolerance_is_conceded_down_to_the_one_asked_for(paper: Result) -> None:
    asked = Fraction(1, 10**6)
    constraints = SPEC.constraints.model_copy(update={"tolerance": asked})
    setting = setting_of(SPEC.model_copy(update={"constraints": constraints}))
    claim = replace(of(paper.claims, ("eq9", "printed")), id="tolerance", form="coefficients", margin=3 * asked)
    weaker = recheck.conceded(setting, claim)
    assert weaker is not None and weaker.margin is not None and asked < weaker.margin <= 2 * asked
    assert recheck.conceded(setting, replace(claim, margin=asked)) is None


def test_a_contradiction_is_no_doubt(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recheck, "check_bytes", unsure_above(("eq9", "printed"), Fraction(1), ExitCode.REFUTED))
    with pytest.raises(RobimpError, match="prover says proven, the independent checker says: hm"):
        synthesize(SPEC)
