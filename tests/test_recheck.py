"""Where prover and checker differ: a contradiction ends everything, a doubt makes the claim smaller."""

from __future__ import annotations

import json
import shlex
import sys
from dataclasses import replace
from fractions import Fraction
from inspect import signature
from itertools import count
from pathlib import Path
from typing import Any

import pytest

from robimp.synthesis import recheck
from robimp.synthesis.certificate.claim import Claim
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.check import Verdict, check_bytes
from robimp.synthesis.check.reader import read
from robimp.synthesis.cli.check import check as check_command
from robimp.synthesis.errors import ExitCode, RobimpError, UndecidedError
from robimp.synthesis.pipeline import Result, setting_of, synthesize
from robimp.synthesis.spec import load_spec

sys.path.insert(0, str(Path(__file__).parent))
from command_line import robimp

EXAMPLES = Path(__file__).parents[1] / "examples"
SPEC, STIFF = (load_spec(EXAMPLES / f"haninger2016-{name}.yaml") for name in ("paper", "stiff"))


@pytest.fixture(scope="module")
def paper() -> Result:
    return synthesize(SPEC)


def unsure_above(kind: tuple[str, str], level: Fraction, code: int = ExitCode.UNDECIDED, said: str = "hm") -> Any:
    """A checker that confirms one claim only up to a level."""

    def doubting(data: bytes, **_: Any) -> Verdict:
        genuine = check_bytes(data)
        claim = next(c for c in read(data)["claims"] if (c["id"], c["form"]) == kind)
        if claim["status"] != "proven" or claim["margin"] <= level:
            return genuine
        claims = tuple((*c[:2], "not verified", said) if c[:2] == kind else c for c in genuine.claims)
        return Verdict(code, said, None, claims)

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


def test_a_doubt_beside_a_refutation_is_no_contradiction(monkeypatch: pytest.MonkeyPatch) -> None:
    kind, doubt = ("eq9", "printed"), "eq9 printed: neither proven nor refuted"
    monkeypatch.setattr(recheck, "check_bytes", unsure_above(kind, Fraction(6, 5), ExitCode.REFUTED, doubt))
    result = synthesize(STIFF)
    margin = of(result.claims, kind).margin
    assert result.exit_code is ExitCode.REFUTED and margin is not None and 1 <= margin <= Fraction(6, 5)
    false = "eq9 printed: does not hold at ω = 1 rad/s"
    monkeypatch.setattr(recheck, "check_bytes", unsure_above(kind, Fraction(6, 5), ExitCode.REFUTED, false))
    with pytest.raises(RobimpError, match="does not hold"):
        synthesize(STIFF)


def in_no_time(data: bytes, *, time_limit: float) -> Verdict:
    """A checker that gets no further than the nominal stability in 60 s."""
    genuine = check_bytes(data)
    if time_limit > recheck.SECONDS:
        return genuine
    late = [c for c in genuine.claims if c[1] != "hurwitz"]
    said = {c[:2]: (*c[:2], "not verified", f"{c[0]} {c[1]}: time limit reached") for c in late}
    return Verdict(
        ExitCode.UNDECIDED, next(iter(said.values()))[3], None, tuple(said.get(c[:2], c) for c in genuine.claims)
    )


def test_in_the_end_the_checker_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[float] = []

    def recorded(data: bytes, *, time_limit: float) -> Verdict:
        asked.append(time_limit)
        return in_no_time(data, time_limit=time_limit)

    monkeypatch.setattr(recheck, "check_bytes", recorded)
    assert synthesize(SPEC).outcome is Outcome.PROVEN
    assert asked == [recheck.SECONDS] * (recheck.ROUNDS - 1) + [recheck.PATIENCE]
    monkeypatch.setattr(recheck, "PATIENCE", recheck.SECONDS)
    with pytest.raises(UndecidedError, match="time limit reached"):
        synthesize(SPEC)


def test_the_limit_that_is_spoken_of_is_the_one_that_is_used() -> None:
    for function in (check_bytes, check_command):
        assert signature(function).parameters["time_limit"].default == recheck.SECONDS


@pytest.mark.parametrize(
    ("seconds", "limit", "says"),
    [(5.0, 60, None), (25.0, 120, "may not be enough on a slower machine"), (87.0, 300, "is not enough")],
)
def test_a_long_check_is_announced_with_the_command_that_allows_it(
    seconds: float, limit: int, says: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = count(0.0, seconds)
    monkeypatch.setattr(recheck, "monotonic", lambda: next(clock))
    folder = tmp_path / "my joint"
    run = robimp("synth", EXAMPLES / "haninger2016-paper.yaml", "-o", folder)
    notes = [line for line in run.out.splitlines() if line.startswith("note: checking")]
    assert run.code == ExitCode.PROVEN and len(notes) == (says is not None), run.out
    for note in notes:
        assert says is not None and says in note and f"took {seconds:.0f} s" in note
        _, *command = shlex.split(note.split("use: ")[1])
        assert command == ["check", str(folder / "certificate.json"), "--time-limit", str(limit)]
        assert robimp(*command).code == ExitCode.PROVEN
        assert robimp(*command[:-1], "0.01").code == ExitCode.UNDECIDED, "the limit it names is what counts"
    written = json.loads(robimp("synth", EXAMPLES / "haninger2016-paper.yaml", "-o", folder, "--json").out)
    assert written["check"] == {"seconds": seconds, "time_limit": limit}


def test_every_order_names_its_own_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    result = replace(synthesize(SPEC), check_seconds=40.0)
    monkeypatch.setattr("robimp.synthesis.pipeline.synthesize", lambda *_, **__: result)
    asked = ("synth", EXAMPLES / "haninger2016-eq23.yaml", "-o", tmp_path, "--orders", "2:3")
    notes = [line for line in robimp(*asked).out.splitlines() if line.startswith("note: checking")]
    assert [note.count(f"order-{n}/certificate.json --time-limit 120") for n, note in enumerate(notes, 2)] == [1, 1]
    assert [row["check_limit"] for row in json.loads(robimp(*asked, "--json").out)["orders"]] == [120, 120]
