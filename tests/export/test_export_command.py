"""`robimp export` as its users meet it, and the files of every target."""

from __future__ import annotations

import doctest
import json
import re
import runpy
import sys
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import refused, robimp
from export_joints import GOLDEN, in_q
from ruamel.yaml import YAML

from robimp.models.rational import to_float
from robimp.synthesis.errors import ExitCode, InputError, MismatchError, RefutedError
from robimp.synthesis.export import Exported, export
from robimp.synthesis.export.targets import files_of
from robimp.synthesis.notebook import TONES

CONTINUOUS, SAMPLED = GOLDEN / "haninger2016-paper.json", GOLDEN / "sampled-range.json"
TIGHT = GOLDEN / "haninger2016.json"


@pytest.fixture(scope="module")
def exported() -> Exported:
    return export(CONTINUOUS, target="control", rate=1000)


@pytest.fixture(scope="module")
def sampled() -> Iterator[Exported]:
    yield export(SAMPLED, target="c", precision="float")


def test_a_passive_joint_stays_proven_at_its_rate(tmp_path: Path) -> None:
    run = robimp("export", CONTINUOUS, "--target", "c", "--rate", "1 kHz", "-o", tmp_path)
    assert run.code == ExitCode.PROVEN, run
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        "export.json",
        "haninger2016_paper.c",
        "haninger2016_paper.h",
    ]
    header = (tmp_path / "haninger2016_paper.h").read_text(encoding="utf-8")
    certificate = json.loads(CONTINUOUS.read_bytes())
    assert certificate["end"]["body_sha256"] in header
    assert "eq12 structured                 required  proven on [0, 3110.18] rad/s margin" in header
    assert "assumed, as the specification has no sampling: a hold and no computation delay" in header
    assert run.out.startswith("PROVEN  haninger2016-paper  ω_B ≥ 8.86146 rad/s (certificate 8.87572); assumed")
    assert run.err == ""


def test_a_lost_claim_is_exit_4_and_no_file_unless_forced(tmp_path: Path) -> None:
    run = robimp("export", TIGHT, "--target", "c", "--rate", "1000", "-o", tmp_path / "x")
    assert run.code == ExitCode.REFUTED
    assert "not proven: eq12 structured, bandwidth attenuation, ω_B ≥ 18.95" in run.line
    assert "rad/s (certificate 40.2906); give the specification `sampling" in run.line
    assert "bandwidth attenuation           required  lost on [0, 18.95" in run.out
    assert "--precision" not in run.line
    assert re.search(r"stability-free \w+ +required  proven decay ≥ \d+\.\d+ /s$", run.out, re.MULTILINE)
    single = robimp("export", TIGHT, "--target", "c", "--rate", "1000", "--precision", "float", "-o", tmp_path / "x")
    assert "; try --precision double, or give the specification" in single.line
    assert "not written (--force)" in run.line
    assert not (tmp_path / "x").exists()
    forced = robimp("export", TIGHT, "--target", "json", "--rate", "1000", "-o", tmp_path, "--force", "--json")
    assert forced.code == ExitCode.REFUTED
    said = json.loads(forced.out)
    assert said["files"] == [str(tmp_path / "export.json")]
    eq12 = next(c for c in said["claims"] if (c["id"], c["form"]) == ("eq12", "structured"))
    assert (eq12["status"], eq12["margin"]) == ("refuted", None)
    assert 50 < Fraction(eq12["refuted_at_omega"]) < 60
    assert json.loads((tmp_path / "export.json").read_bytes())["claims"] == said["claims"]


@pytest.mark.parametrize("target", ["c", "json", "control", "ros2"])
def test_every_file_says_first_whether_it_is_proven(exported: Exported, target: str) -> None:
    """What is written with --force is a file like any other, and goes from hand to hand."""
    subject = exported.subject
    lost = tuple(replace(each, claim=None) if each.id == "eq12" else each for each in subject.carried)
    for claims, begin in ((subject.carried, "PROVEN: "), (lost, "NOT PROVEN: eq12 structured not re-proven; ")):
        for name, text in files_of(replace(subject, carried=claims), target).items():
            first = text.splitlines()[1 if name.endswith("json") else 0]
            assert first.lstrip(' "').removeprefix('verdict": "').lstrip("/*# ").startswith(begin), name
            assert "What is proven" not in text
            assert ("NOT PROVEN" in text or "_NOT_PROVEN 1" in text) is (claims is lost)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([CONTINUOUS, "--target", "c"], "--rate: the specification has no `sampling`"),
        ([CONTINUOUS, "--target", "c", "--rate", "1 kg"], "--rate: 'kg' is not a unit of a sampling rate"),
        ([CONTINUOUS, "--target", "c", "--rate=-5"], "--rate: expected samples per second, above 0"),
        ([CONTINUOUS, "--target", "c", "--rate", "4"], "is too low for a bandwidth of 8.876 rad/s"),
        ([CONTINUOUS, "--target", "c", "--rate", "1000/3"], "whole number of mHz"),
        ([CONTINUOUS, "--target", "ros2", "--rate", "1000.5"], "whole number of Hz"),
        ([CONTINUOUS, "--target", "rust", "--rate", "1000"], "--target: expected c, json, control, ros2; found rust"),
        ([CONTINUOUS, "--rate", "1000"], "Missing option '--target'"),
        ([CONTINUOUS, "--target", "c", "--rate", "1000", "--precision", "half"], "--precision: expected double, float"),
        ([SAMPLED, "--target", "c", "--rate", "500"], "the certificate is for 1000 Hz (sampling.rate)"),
        (["nowhere.json", "--target", "c"], "nowhere.json: file: cannot be read"),
    ],
)
def test_what_cannot_be_used_is_one_clear_line(arguments: list[str | Path], expected: str, tmp_path: Path) -> None:
    assert expected in refused(ExitCode.INPUT, "export", *arguments, "-o", tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("rate", ["5 Hz", "5", 5, 5.0, Fraction(5)])
def test_a_rate_is_a_number_or_a_text(rate: str | float | Fraction) -> None:
    with pytest.raises(InputError, match="--rate 5 Hz is too low for a bandwidth"):
        export(CONTINUOUS, rate=rate)


@pytest.mark.parametrize("rate", ["1 kg", "often", float("nan"), float("inf"), [1000], 0, "-5"])
def test_a_rate_that_is_none_is_an_input_error(rate: Any) -> None:
    with pytest.raises(InputError, match="--rate: "):
        export(CONTINUOUS, rate=rate)


def test_a_certificate_that_does_not_check_is_not_exported(tmp_path: Path) -> None:
    text = CONTINUOUS.read_text(encoding="utf-8")
    content = json.loads(text)
    broken = tmp_path / "broken.json"
    broken.write_text(text.replace('"2000"', '"2001"', 1), encoding="utf-8")
    assert "does not check" in refused(ExitCode.INPUT, "export", broken, "--target", "c", "--rate", "1000")
    with pytest.raises(InputError, match="does not check"):
        export(b"{}", rate=1000)
    claim = next(c for c in content["claims"] if c["id"] == "peak")
    claim["margin"] = "11/10"
    with pytest.raises(RefutedError, match="peak sensitivity"):
        export(resealed(content), rate=1000)
    content = json.loads(text)
    content["claims"] = [c for c in content["claims"] if c["id"] != "peak"]
    with pytest.raises(MismatchError, match="peak"):
        export(resealed(content), rate=1000)


def resealed(content: dict[str, object]) -> bytes:
    """With a digest that fits what it says."""
    from hashlib import sha256

    from robimp.synthesis.spec import canonical_json

    body = {key: value for key, value in content.items() if key != "end"}
    claims = content["claims"]
    assert isinstance(claims, list)
    content["end"] = {"claims": len(claims), "body_sha256": sha256(canonical_json(body)).hexdigest()}
    return json.dumps(content).encode()


def test_every_required_claim_of_a_sampled_range_carries_over_in_single_precision(sampled: Exported) -> None:
    assert sampled.exit_code is ExitCode.PROVEN
    required = {(c.id, c.form): c.status for c in sampled.claims if c.required}
    certificate = json.loads(SAMPLED.read_bytes())
    asked = {(c["id"], c["form"]) for c in certificate["claims"] if c["required"]}
    assert required == {**dict.fromkeys(asked, "proven"), ("tolerance", "coefficients"): "not needed"}
    assert "a hold and 0.001 s of computation delay" in sampled.files[f"{sampled.subject.identifier}.h"]


def test_in_a_notebook_it_is_a_card(exported: Exported) -> None:
    proven = exported._repr_html_()
    for text in (">PROVEN<", "ω_B ≥ 8.86146 rad/s (certificate 8.87572)", "eq12", "1000 Hz, double", TONES["good"]):
        assert text in proven
    none = tuple(replace(each, claim=None, note="<b>") for each in exported.claims)
    lost = replace(exported, subject=replace(exported.subject, carried=none))._repr_html_()
    assert ">NOT PROVEN<" in lost
    assert TONES["open"] in lost
    assert "not re-proven: &lt;b&gt;" in lost
    assert "ω_B ≥" not in lost


def test_control_objects_are_the_law(exported: Exported, tmp_path: Path) -> None:
    (path,) = (p for p in exported.write(tmp_path) if p.suffix == ".py")
    module = runpy.run_path(str(path))
    law, omega = exported.law, np.array([1.0, 30.0, 900.0])
    q = np.exp(-1j * omega / 1000)
    own = exported.to_control()
    assert own["compensator"].dt == module["C"].dt == 1e-3
    C = in_q(law.compensator.num, q) / in_q(law.compensator.den, q)
    np.testing.assert_allclose(own["compensator"](1 / q), C, rtol=1e-9)
    np.testing.assert_allclose(module["from_torque"](1 / q), C * in_q(law.error.M, q), rtol=1e-9)
    wish, inner = (in_q(p, q) for p in (law.error.stiffness(law.desired), law.compensated.stiffness(law.nominal)))
    inner = inner - in_q(law.compensated.stiffness(law.desired), q)
    np.testing.assert_allclose(module["from_angle"](1 / q), inner - C * wish, rtol=1e-7)


def test_parameters_of_ros2_are_the_law(tmp_path: Path) -> None:
    done = export(CONTINUOUS, target="ros2", rate=1000)
    (name,) = (file for file in done.files if file.endswith(".yaml"))
    read = YAML(typ="safe").load(done.files[name])
    assert read["controller_manager"]["ros__parameters"]["update_rate"] == 1000
    parameters = read[done.subject.identifier]["ros__parameters"]
    rows = np.array(parameters["compensator"]).reshape(-1, 5)
    assert (rows == done.law.compensator.sos[:, [0, 1, 2, 4, 5]]).all()
    assert parameters["desired"]["stiffness"] == to_float(done.law.desired.stiffness)
    assert parameters["error"]["acceleration"] == to_float(done.law.error.acceleration)
    assert "eq12 structured" in done.files[name]


def test_json_says_every_number_exactly(exported: Exported) -> None:
    said = exported.to_json()
    assert [[float(t) for t in row] for row in said["filters"]["compensator"]] == [
        [s.b0, s.b1, s.b2, s.a1, s.a2] for s in exported.law.compensator.sections
    ]
    assert (said["rate"], said["delay"], said["precision"]) == ("1000", "0", "double")
    assert said["certificate"] == json.loads(CONTINUOUS.read_bytes())["end"]["body_sha256"]


def test_a_file_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("in the way", encoding="utf-8")
    assert "is not a folder" in refused(
        ExitCode.INPUT, "export", CONTINUOUS, "--target", "c", "--rate", "1000", "-o", blocked
    )


def test_the_example_in_the_docstring_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "certificate.json").write_bytes(CONTINUOUS.read_bytes())
    monkeypatch.chdir(tmp_path)
    module = sys.modules[export.__module__]
    failed, tried = doctest.testmod(module)
    assert (failed, tried) == (0, 5)


def test_the_package_is_its_own_function() -> None:
    package = sys.modules["robimp.synthesis.export"]
    with pytest.raises(InputError, match="expected c, json, control, ros2; found rust"):
        package(CONTINUOUS, target="rust", rate=1000)  # type: ignore[operator]
