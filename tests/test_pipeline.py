"""The stations in order: what each hands on, and that none is skipped."""

from __future__ import annotations

import json
import os
import shutil
import signal
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robimp.synthesis import InputError, Result, RobimpError, pipeline
from robimp.synthesis.agreement import compare
from robimp.synthesis.certificate.claims import Claim, certify
from robimp.synthesis.certificate.outcome import Outcome
from robimp.synthesis.check import check_bytes
from robimp.synthesis.cli.synth import _synth_one
from robimp.synthesis.errors import ExitCode
from robimp.synthesis.pipeline import realizable, setting_of, synthesize
from robimp.synthesis.spec import load_spec, parse_spec, spec_sha256
from robimp.synthesis.spec.model import Polynomials

ROOT = Path(__file__).parents[1]
GOOD = (ROOT / "tests" / "data" / "specs" / "good.yaml").read_text(encoding="utf-8")
PAPER = "{type: dob, coefficients: {numerator: [2000], denominator: [1, 70.75, 2500]}}"


def spec_text(*pairs: tuple[str, str]) -> str:
    text = GOOD.replace("{type: dob, order: 4}", PAPER)
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return text


@pytest.fixture(scope="module")
def paper() -> Result:
    return synthesize(parse_spec(spec_text()))


def test_the_stations_report_in_order() -> None:
    said: list[str] = []
    synthesize(parse_spec(spec_text()), said.append)
    assert [text.split()[0] for text in said] == ["proving", "re-checking", "simulating"]


def test_the_result_holds_what_the_certificate_says(paper: Result) -> None:
    certificate = paper.certificate
    assert json.loads(paper.certificate_bytes()) == certificate
    assert certificate["spec_sha256"] == spec_sha256(paper.spec)
    assert Fraction(certificate["bandwidth"]["proven"]) == paper.omega_B
    assert [claim["status"] for claim in certificate["claims"]] == [claim.status.value for claim in paper.claims]
    assert certificate["end"]["claims"] == len(paper.claims)
    assert certificate["controller"]["Q"] == {"numerator": ["2000"], "denominator": ["1", "283/4", "2500"]}
    assert (paper.outcome, paper.exit_code, paper.bound) == (Outcome.PROVEN, ExitCode.PROVEN, None)
    assert check_bytes(paper.certificate_bytes()).exit_code == ExitCode.PROVEN
    assert check_bytes(paper.certificate_bytes()[:-2]).exit_code == ExitCode.INPUT


@pytest.mark.parametrize(
    ("status", "required", "outcome", "code"),
    [
        (Outcome.PROVEN, True, Outcome.PROVEN, ExitCode.PROVEN),
        (Outcome.REFUTED, True, Outcome.REFUTED, ExitCode.REFUTED),
        (Outcome.UNDECIDED, True, Outcome.UNDECIDED, ExitCode.UNDECIDED),
        (Outcome.REFUTED, False, Outcome.PROVEN, ExitCode.PROVEN),
        (Outcome.UNDECIDED, False, Outcome.PROVEN, ExitCode.PROVEN),
    ],
)
def test_the_outcome_is_that_of_the_required_claims(
    paper: Result, status: Outcome, required: bool, outcome: Outcome, code: ExitCode
) -> None:
    one = next(index for index, claim in enumerate(paper.claims) if claim.id == "peak")
    claims = list(paper.claims)
    claims[one] = replace(claims[one], status=status, required=required)
    changed = replace(paper, claims=tuple(claims))
    assert (changed.outcome, changed.exit_code) == (outcome, code)


def test_refuted_weighs_more_than_undecided(paper: Result) -> None:
    claims = [replace(claim, required=True, status=Outcome.UNDECIDED) for claim in paper.claims]
    assert replace(paper, claims=tuple(claims)).exit_code is ExitCode.UNDECIDED
    claims[-1] = replace(claims[-1], status=Outcome.REFUTED)
    assert replace(paper, claims=tuple(claims)).exit_code is ExitCode.REFUTED


def test_the_producer_names_versions(paper: Result) -> None:
    assert {"robimp", "python", "python-flint", "casadi", "clarabel", "numpy"} == set(paper.certificate["producer"])


@pytest.mark.parametrize("place", ["peak", "eq9", "bandwidth"])
def test_a_prover_that_claims_too_much_is_stopped(place: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the claim is changed: the controller is right, the words about it are not."""
    better = {"peak": Fraction(1), "eq9": Fraction(50), "bandwidth": Fraction(9)}[place]

    def boastful(*arguments: Any) -> Any:
        for claim in certify(*arguments):
            if claim.id == place:
                claim = replace(claim, margin=better, refuted_at=None)
            if place == "bandwidth" and claim.id in ("bandwidth", "rendering"):
                claim = replace(claim, interval=(Fraction(0), better), refuted_at=None)
            yield claim

    monkeypatch.setattr(pipeline, "certify", lambda *a: tuple(boastful(*a)))
    with pytest.raises(RobimpError, match=f"prover says proven, the independent checker says: {place}"):
        synthesize(parse_spec(spec_text()))


def test_a_false_refutation_is_stopped_even_where_another_claim_is_rightly_refuted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Both verdicts are `refuted`: only the comparison claim by claim tells them apart."""
    stiff = parse_spec(spec_text(("damping: 0.35, stiffness: 1.25", "damping: 0.25, stiffness: 3")))
    assert synthesize(stiff).exit_code is ExitCode.REFUTED

    def gloomy(claim: Claim) -> Claim:
        if claim.id != "rendering" or claim.refuted_at is None:
            return claim
        nowhere = replace(claim.refuted_at, value=Fraction(1))
        return replace(claim, status=Outcome.REFUTED, margin=None, refuted_at=nowhere)

    monkeypatch.setattr(pipeline, "certify", lambda *a: tuple(map(gloomy, certify(*a))))
    with pytest.raises(RobimpError, match="prover says refuted, the independent checker says: rendering"):
        synthesize(stiff)


def test_physics_that_contradict_each_other_are_input_errors() -> None:
    unstable = ("stiffness: [0, 0]}}", "stiffness: [0, 0]}, weight: {numerator: [0.2, 0], denominator: [1, -800]}}")
    with pytest.raises(InputError, match=r"uncertainty\.weight must be stable"):
        setting_of(parse_spec(spec_text(unstable)))
    stable = (unstable[0], unstable[1].replace("-800", "800"))
    assert setting_of(parse_spec(spec_text(stable))).uncertainty.weight is not None


def test_an_algebraic_loop_is_an_input_error() -> None:
    ideal = GOOD[: GOOD.index("actuator:")] + "actuator: {type: ideal}\n" + GOOD[GOOD.index("impedance:") :]
    setting = setting_of(parse_spec(ideal.replace("{type: dob, order: 4}", "{type: dynamic-feedback, order: 1}")))

    def led_by(gain: Fraction) -> Polynomials:
        return Polynomials(numerator=(gain, Fraction(3)), denominator=(Fraction(1), Fraction(2)))

    for gain in (Fraction(-1), Fraction(-101, 100), Fraction(-2)):  # 1 + HCF is 0 at infinity, and below
        with pytest.raises(InputError, match=r"algebraic loop, 1 \+ HCF is not positive"):
            realizable(setting, led_by(gain))
    realizable(setting, led_by(Fraction(-99, 100)))
    port = (
        "{type: two-port, transfer: {numerator: [2], denominator: [1]}, impedance: {numerator: [0], denominator: [1]}}"
    )
    strong = setting_of(parse_spec(ideal.replace("{type: ideal}", port).replace("inertia: nominal", "inertia: 0.001")))
    with pytest.raises(InputError, match=r"algebraic loop, in free motion 1 \+ HA/.*F_d, decay"):
        realizable(strong, Polynomials(numerator=(Fraction(5),), denominator=(Fraction(1), Fraction(10))))
    with pytest.raises(InputError, match=r"controller\.coefficients"):
        realizable(setting, Polynomials(numerator=(Fraction(-1),), denominator=(Fraction(1),)))


@pytest.mark.parametrize("box", ["", ", box: {inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}"])
def test_an_unstable_controller_has_no_tolerance_and_prover_and_checker_agree(box: str) -> None:
    weight = "{numerator: [0.01], denominator: [1]}"
    text = spec_text(
        ("70.75", "-0.75"),
        ("{box: {inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}}", f"{{weight: {weight}{box}}}"),
        ("eq9: {}, ", ""),
        ("eq12: {form: structured}, ", ""),
        ("peak: 2.0", "peak: 200, tolerance: float32"),
    )
    result = synthesize(parse_spec(text))
    statuses = {(claim.id, claim.form): claim.status for claim in result.claims}
    assert result.checked.exit_code == result.exit_code == ExitCode.REFUTED
    assert statuses["stability-free", "hurwitz"] is Outcome.REFUTED
    assert statuses["tolerance", "coefficients"] is not Outcome.PROVEN


@pytest.mark.parametrize("half", [["1"], ["1", "1"]])
def test_a_loop_of_nothing_but_zero_is_an_input_error(half: list[str]) -> None:
    """C = −1 behind an ideal actuator, or behind half the torque, where only 1 + CF is 0."""
    ideal = GOOD[: GOOD.index("actuator:")] + "actuator: {type: ideal}\n" + GOOD[GOOD.index("impedance:") :]
    port = (
        "{type: two-port, transfer: {numerator: [1], denominator: [2]}, impedance: {numerator: [0], denominator: [1]}}"
    )
    for actuator in ("{type: ideal}", port):
        text = ideal.replace("{type: ideal}", actuator)
        setting = setting_of(parse_spec(text.replace("{type: dob, order: 4}", "{type: dynamic-feedback, order: 1}")))
        given = tuple(map(Fraction, half))
        with pytest.raises(InputError, match=r"1 \+ HCF, or 1 \+ CF, is 0 at every frequency"):
            realizable(setting, Polynomials(numerator=tuple(-c for c in given), denominator=given))


def test_simulation_and_proof_agree_on_the_papers_filter(paper: Result) -> None:
    setting = setting_of(paper.spec)
    C = realizable(setting, paper.coefficients)
    found = compare(setting, C, paper.claims, paper.trials)
    assert found.contradictions == () and found.impedance_error < 1e-9 and found.lowest_energy > -1e-9


def contradictions(result: Result, wall_stable: bool = True, **changes: Any) -> tuple[str, ...]:
    """What is said when some facts of the trial with a measured impedance are others."""
    setting = setting_of(result.spec)
    C = realizable(setting, result.coefficients)
    measured = next(trial for trial in result.trials.trials if trial.frequencies)
    trials = tuple(replace(t, **changes) if t is measured else t for t in result.trials.trials)
    claimed = replace(result.trials, trials=trials, wall_stable=wall_stable)
    return compare(setting, C, result.claims, claimed).contradictions


def test_every_kind_of_disagreement_is_seen(paper: Result) -> None:
    Z = next(np.array(trial.Z_measured) for trial in paper.trials.trials if trial.frequencies)
    assert contradictions(paper) == ()
    assert "unstable" in contradictions(paper, stable=False)[0]
    assert "energy extracted" in contradictions(paper, min_energy=-0.01, energy_scale=1.0)[0]
    assert "rigid wall" in contradictions(paper, wall_stable=False)[0]
    assert "differs from (★) by 0.0001" in contradictions(paper, Z_measured=tuple(Z * (1 + 1e-4)))[0]
    assert contradictions(paper, Z_measured=tuple(Z * (1 + 1e-8))) == (), "within the measurement's own accuracy"


def test_energy_is_only_a_contradiction_where_passivity_is_proven() -> None:
    """The stiffer impedance gives energy away, as its refuted (12) says it does."""
    stiff = synthesize(load_spec(ROOT / "examples" / "haninger2016-stiff.yaml"))
    assert stiff.exit_code is ExitCode.REFUTED
    assert stiff.agreement.lowest_energy < -0.5 and stiff.agreement.contradictions == ()


def test_a_result_is_frozen(paper: Result) -> None:
    with pytest.raises(AttributeError):
        paper.seconds = 0.0  # type: ignore[misc]


# ---- files of two runs in one folder


def written_by(result: Result, folder: Path, monkeypatch: pytest.MonkeyPatch, killed_at: int | None = None) -> int:
    """Write a result as `synth` does, in a process that kills itself before its killed_at-th change; its changes."""
    with monkeypatch.context() as patched:
        patched.setattr(pipeline, "synthesize", lambda *_, **__: result)
        changes = folder.parent / "changes"
        changes.write_text("0", encoding="utf-8")
        child = os.fork()
        if child == 0:
            for name in ("replace", "unlink"):
                change = getattr(Path, name)

                def counted(self: Path, *a: Any, _change: Any = change, **k: Any) -> Any:
                    if self.parent == folder and not (self.name.endswith(".part") and _change.__name__ == "unlink"):
                        number = int(changes.read_text(encoding="utf-8"))
                        if number == killed_at:
                            os.kill(os.getpid(), signal.SIGKILL)
                        changes.write_text(str(number + 1), encoding="utf-8")
                    return _change(self, *a, **k)

                setattr(Path, name, counted)
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            try:
                _synth_one(Path("spec.yaml"), result.spec, folder, None, 0, True)
            finally:
                os._exit(0)
        os.waitpid(child, 0)
    return int(changes.read_text(encoding="utf-8"))


def contents(folder: Path) -> dict[str, bytes]:
    return {entry.name: entry.read_bytes() for entry in folder.iterdir() if not entry.name.endswith(".part")}


def test_a_kill_at_any_change_leaves_files_of_one_run(
    paper: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = synthesize(parse_spec(spec_text(("damping: 0.35", "damping: 0.36"))))
    for name, result in (("old", paper), ("new", other)):
        changes = written_by(result, tmp_path / name, monkeypatch)
    old, new = contents(tmp_path / "old"), contents(tmp_path / "new")
    assert set(old) == set(new) == {"certificate.json", "simulation.json", "report.html"}
    assert all(old[name] != new[name] for name in old), "control: a mixture would be seen"
    assert changes >= 6, "three removals, three files"
    seen = set()
    for step in range(changes + 1):
        folder = tmp_path / f"killed-{step}"
        shutil.copytree(tmp_path / "old", folder)
        written_by(other, folder, monkeypatch, step)
        found = contents(folder)
        assert found.items() <= old.items() or found.items() <= new.items(), (step, sorted(found))
        assert "certificate.json" in found
        seen.add(found["certificate.json"] == new["certificate.json"])
    assert seen == {False, True} and contents(folder) == new
