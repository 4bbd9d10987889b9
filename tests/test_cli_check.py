"""`robimp check` in continuous integration: many certificates, comparisons by key, JUnit, broken output."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any
from unittest.mock import patch
from xml.etree import ElementTree as ET

import pytest
from command_line import refused, robimp

from robimp.synthesis import judgement
from robimp.synthesis.check import Verdict, canonical_json
from robimp.synthesis.cli.common import GRAVITY
from robimp.synthesis.errors import ExitCode

EXAMPLES = Path(__file__).parents[1] / "examples"
PAPER, STIFF, FEEDBACK = (EXAMPLES / f"haninger2016-{name}.yaml" for name in ("paper", "stiff", "feedback"))
MAIN = [sys.executable, "-c", "from robimp.synthesis.cli import main\nmain()"]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Certificates of three examples: paper is proven, the other two are refuted."""
    folder = tmp_path_factory.mktemp("results")
    for spec in (PAPER, STIFF, FEEDBACK):
        robimp("synth", spec, "-o", folder / spec.stem)
    return folder


@pytest.fixture(scope="module")
def paper(results: Path) -> Path:
    return results / PAPER.stem / "certificate.json"


@pytest.fixture(scope="module")
def stiff(results: Path) -> Path:
    return results / STIFF.stem / "certificate.json"


def write(path: Path, content: Any) -> Path:
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


def edited(folder: Path, *pairs: tuple[str, str]) -> Path:
    text = PAPER.read_text(encoding="utf-8")
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new, 1)
    return write(folder / "edited.yaml", text)


# Which outcome decides


def test_gravity_orders_every_code_and_only_a_proof_is_0() -> None:
    assert sorted(GRAVITY) == sorted(ExitCode) and GRAVITY[-1] is ExitCode.PROVEN


def test_the_gravest_of_many_decides_in_any_order(paper: Path, stiff: Path, tmp_path: Path) -> None:
    bad = write(tmp_path / "bad.json", "{")
    assert robimp("check", paper, paper).code == ExitCode.PROVEN
    for certificates in ((paper, bad, stiff), (stiff, bad, paper), (bad, stiff, paper)):
        run = robimp("check", *certificates)
        assert run.code == ExitCode.REFUTED
        assert run.out.count("\n") == 1 and run.err.count("\n") == 2
    assert robimp("check", bad, paper).code == ExitCode.INPUT
    assert robimp("check", paper, bad, "--spec", STIFF).code == ExitCode.MISMATCH
    with patch.object(judgement, "check_bytes", lambda data, time_limit: Verdict(5, "out of time")):
        assert robimp("check", paper).code == ExitCode.UNDECIDED
        assert robimp("check", paper, "absent.json").code == ExitCode.INPUT


# The specification


def test_every_difference_from_the_specification_is_named(paper: Path, tmp_path: Path) -> None:
    spec = edited(tmp_path, ("damping: 0.2 ", "damping: 0.25 "), ("peak: 2.0", "friction: require"))
    run = robimp("check", paper, "--spec", spec, "--json")
    found = json.loads(run.out)["differences"]["specification"]
    assert run.code == ExitCode.MISMATCH and "plant.damping 0.2 → 0.25" in found
    assert "constraints.peak: only in the certificate" in found
    assert "constraints.friction report → require" in found
    line = refused(ExitCode.MISMATCH, "check", paper, "--spec", spec)
    assert all(difference in line for difference in found)


def test_what_only_follows_from_a_difference_is_not_listed_too(paper: Path, tmp_path: Path) -> None:
    """± 20 % of the nominal inertia, and a nominal apparent inertia, change with it; another share does not."""
    spec = edited(tmp_path, ("inertia: 0.03 ", "inertia: 0.031 "))
    found = json.loads(robimp("check", paper, "--spec", spec, "--json").out)["differences"]["specification"]
    assert found == ["plant.inertia 0.03 → 0.031"]
    spec = edited(tmp_path, ("inertia: 0.03 ", "inertia: 0.031 "), ("inertia: ±20 %", "inertia: ±21 %"))
    found = json.loads(robimp("check", paper, "--spec", spec, "--json").out)["differences"]["specification"]
    assert found[0] == "plant.inertia 0.03 → 0.031" and "uncertainty.box.inertia[0]" in found[1] and len(found) == 3


def test_another_c_that_only_follows_from_another_q_is_not_listed_too(paper: Path, tmp_path: Path) -> None:
    Q, C = json.loads(paper.read_bytes())["controller"]["Q"], {"numerator": [2001], "denominator": ["1", "70.75", 499]}
    other = write(tmp_path / "other.json", {"Q": {**Q, "numerator": [2001]}, "C": C})
    found = json.loads(robimp("check", paper, "--controller", other, "--json").out)["differences"]["controller"]
    assert found == ["controller.Q.numerator[0] 2000 → 2001"]
    alone = write(tmp_path / "alone.json", {"Q": Q, "C": C})
    assert (
        len(json.loads(robimp("check", paper, "--controller", alone, "--json").out)["differences"]["controller"]) == 2
    )


def test_what_only_the_specification_has_is_said(paper: Path, tmp_path: Path) -> None:
    bare = edited(tmp_path, ("peak: 2.0", "friction: report"))
    assert robimp("synth", bare, "-o", tmp_path / "bare").code == ExitCode.PROVEN
    line = refused(ExitCode.MISMATCH, "check", tmp_path / "bare" / "certificate.json", "--spec", PAPER)
    assert line.endswith("constraints.peak: only in the specification")


def test_a_refuted_certificate_of_another_specification_says_both(stiff: Path) -> None:
    line = refused(ExitCode.MISMATCH, "check", stiff, "--spec", PAPER)
    assert "impedance.stiffness 3 → 1.25" in line and "eq12 structured: required, and refuted" in line


def test_one_specification_for_all_or_one_for_each(paper: Path, stiff: Path) -> None:
    assert robimp("check", paper, paper, "--spec", PAPER).code == ExitCode.PROVEN
    both = ("--spec", PAPER, "--spec", STIFF)
    assert robimp("check", paper, stiff, *both).code == ExitCode.REFUTED
    assert robimp("check", stiff, paper, *both).code == ExitCode.MISMATCH
    assert robimp("check", paper, paper, "--spec", PAPER, "--spec", PAPER).code == ExitCode.PROVEN
    for certificates in ((paper,), (paper, paper, paper)):
        assert "--spec is given 2 times" in refused(ExitCode.INPUT, "check", *certificates, *both)


# The controller

Q = {"numerator": [2000], "denominator": [1, 70.75, 2500]}
CONTROLLERS: dict[str, tuple[Any, str]] = {
    "Q": ({"Q": Q}, ""),
    "C": ({"C": {"numerator": [2000], "denominator": [1, 70.75, 500]}}, ""),
    "Q, not named": (Q, ""),
    "C, not named": ({"numerator": ["2000"], "denominator": ["1", "283/4", "500"]}, ""),
    "both and the type": ({"type": "dob", "Q": Q, "C": {"numerator": [2000], "denominator": [1, 70.75, 500]}}, ""),
    "exact text": ({"Q": {"numerator": ["2e3"], "denominator": ["+1", "70.7500", "5000/2"]}}, ""),
    "leading zeros": ({"Q": {"numerator": [0, 0, 2000], "denominator": [0, 1, 70.75, 2500]}}, ""),
    "a common factor": ({"Q": {"numerator": [4000], "denominator": [2, 141.5, 5000]}}, ""),
    "one coefficient": ({"Q": {**Q, "numerator": [2001]}}, "controller.Q.numerator[0] 2000 → 2001"),
    "one coefficient, not named": ({**Q, "numerator": [2001]}, "controller.Q.numerator[0] 2000 → 2001"),
    "the last digit": (
        '{"Q": {"numerator": [2000], "denominator": [1, 70.750000000000000000001, 2500]}}',
        "controller.Q.denominator[1] 70.75 → 70750000000000000000001/1000000000000000000000",
    ),
    "a degree": ({"Q": {**Q, "numerator": [1, 2000]}}, "controller.Q.numerator: degree 0 → 1"),
    "a sign": ({"Q": {**Q, "numerator": [-2000]}}, "controller.Q.numerator[0] 2000 → -2000"),
    "zero": ({"Q": {**Q, "numerator": [0]}}, "controller.Q.numerator[0] 2000 → 0"),
    "the type": ({"type": "dynamic-feedback", "Q": Q}, "controller.type dob → dynamic-feedback"),
    "Q right, C wrong": ({"Q": Q, "C": Q}, "controller.C.denominator[2] 500 → 2500"),
}


@pytest.mark.parametrize(("content", "says"), CONTROLLERS.values(), ids=CONTROLLERS)
def test_a_controller_is_compared_exactly(content: Any, says: str, paper: Path, tmp_path: Path) -> None:
    file = write(tmp_path / "controller.json", content)
    if not says:
        run = robimp("check", paper, "--controller", file)
        assert (run.code, run.err) == (0, "") and run.out.endswith("of this controller\n")
    else:
        line = refused(ExitCode.MISMATCH, "check", paper, "--controller", file)
        assert line == f"{paper}: of another controller (certificate → controller): {says}"


def test_the_controller_may_be_a_certificate(paper: Path, stiff: Path, results: Path) -> None:
    assert robimp("check", paper, "--controller", paper, "--spec", PAPER).out.endswith(
        "of this specification and controller\n"
    )
    feedback = results / FEEDBACK.stem / "certificate.json"
    line = refused(ExitCode.MISMATCH, "check", feedback, "--controller", paper)
    assert "controller.type dynamic-feedback → dob" in line and "controller.Q: only in the controller file" in line
    assert "controller.C." in line, "without a Q of its own, its C follows nothing"


UNUSABLE = {
    "no JSON": "{",
    "a list": "[1]",
    "neither Q nor C": {"K": Q},
    "an unknown key": {"Q": Q, "gain": 2},
    "no denominator": {"numerator": [1]},
    "a zero denominator": {"numerator": [1], "denominator": [0, 0]},
    "a quotient by zero": {"numerator": ["1/0"], "denominator": [1]},
    "no coefficients": {"numerator": [], "denominator": [1]},
    "NaN": '{"numerator": [NaN], "denominator": [1]}',
    "Infinity": '{"numerator": [1], "denominator": [-Infinity]}',
    "an exponent without end": '{"numerator": [1e999999999], "denominator": [1]}',
    "an exponent without end, as text": {"numerator": ["1e999999999"], "denominator": [1]},
    "100,000 digits": {"numerator": ["9" * 100_000], "denominator": [1]},
    "true": {"numerator": [True], "denominator": [1]},
    "words": {"numerator": ["two"], "denominator": [1]},
    "a duplicate key": '{"numerator": [1], "numerator": [2000], "denominator": [1, 70.75, 2500]}',
    "deeply nested": "[" * 100_000,
    "a certificate without a controller": {"robimp_certificate": 1},
}


@pytest.mark.parametrize("content", UNUSABLE.values(), ids=UNUSABLE)
def test_a_controller_file_that_cannot_be_used_is_one_line(content: Any, paper: Path, tmp_path: Path) -> None:
    file = write(tmp_path / "controller.json", content)
    assert refused(ExitCode.INPUT, "check", paper, "--controller", file).startswith(f"robimp: {file}: not a controller")


def test_a_controller_file_that_is_not_there_is_one_line(paper: Path, tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "absent.json"):
        assert str(path) in refused(ExitCode.INPUT, "check", paper, "--controller", path)


# JUnit


def suites(path: Path) -> list[ET.Element]:
    root = ET.fromstring(path.read_bytes())
    assert root.tag == "testsuites" and all(suite.tag == "testsuite" for suite in root)
    for element in (root, *root):
        assert int(element.attrib["tests"]) == len(list(element.iter("testcase")))
        assert int(element.attrib["failures"]) == len(list(element.iter("failure")))
        assert int(element.attrib["errors"]) == len(list(element.iter("error")))
        assert float(element.attrib["time"]) >= 0
    assert all(float(case.attrib["time"]) >= 0 for case in root.iter("testcase"))
    return list(root)


def red(suite: ET.Element) -> dict[str, str]:
    """Name of every failing or erring case, and the message."""
    found = {}
    for case in suite:
        for kind in ("failure", "error"):
            if (element := case.find(kind)) is not None:
                found[case.attrib["name"]] = f"{kind}: {element.attrib['message']}"
    return found


def test_junit_has_a_suite_for_each_certificate_and_a_case_for_each_claim(
    paper: Path, stiff: Path, tmp_path: Path
) -> None:
    file = tmp_path / "deep" / "junit.xml"
    assert robimp("check", paper, stiff, "absent.json", "--spec", PAPER, "--junit", file).code == ExitCode.MISMATCH
    proven, refuted, absent = suites(file)
    names = [case.attrib["name"] for case in proven]
    assert names[:2] == ["certificate", "specification"] and "eq12 structured" in names and len(names) == 13
    assert {case.attrib["classname"] for case in proven} == {str(paper)} and red(proven) == {}
    skipped = [case.attrib["name"] for case in proven if case.find("skipped") is not None]
    assert skipped == ["friction strictly-positive-real"], "refuted, but only reported: nobody should see it green"
    assert set(red(refuted)) == {"certificate", "specification", "eq12 structured"}
    assert "impedance.stiffness 3 → 1.25" in red(refuted)["specification"]
    assert red(refuted)["eq12 structured"].startswith("failure: eq12 structured: required, and refuted")
    assert list(red(absent)) == ["certificate"] and red(absent)["certificate"].startswith("error: file: cannot be read")


def test_junit_is_red_exactly_when_the_exit_code_is_not_0(paper: Path, tmp_path: Path) -> None:
    file, certificate = tmp_path / "junit.xml", json.loads(paper.read_bytes())
    certificate["spec"]["constraints"]["friction"] = "require"
    certificate["spec_sha256"] = sha256(canonical_json(certificate["spec"])).hexdigest()
    body = {key: part for key, part in certificate.items() if key != "end"}
    digest = sha256(canonical_json(body)).hexdigest()
    certificate["end"] = {"claims": len(certificate["claims"]), "body_sha256": digest}
    stale = write(tmp_path / "stale.json", {**Q, "numerator": [2001]})
    for arguments in (
        (paper,),
        (paper, "--controller", stale),
        (write(tmp_path / "mismatch.json", certificate),),
        (write(tmp_path / "empty.json", ""),),
        (paper, "--spec", tmp_path / "absent.yaml"),
        (paper, "--spec", PAPER, "--spec", PAPER),
    ):
        code = robimp("check", *arguments, "--junit", file).code
        (suite,) = suites(file)
        assert bool(red(suite)) == (code != ExitCode.PROVEN), arguments


def test_a_check_out_of_time_is_an_error_not_a_failure(paper: Path, tmp_path: Path) -> None:
    with patch("time.monotonic", side_effect=iter(range(0, 10**6, 100)).__next__):
        assert robimp("check", paper, "--junit", tmp_path / "junit.xml").code == ExitCode.UNDECIDED
    (suite,) = suites(tmp_path / "junit.xml")
    assert red(suite) and all(message.startswith("error") for message in red(suite).values())


@pytest.mark.parametrize(
    "name", ["a&b<c>\"'.json", "bell\a.json", "line\nbreak.json", "\udcff.json", "ω_B \U0001f916.json"]
)
def test_junit_is_well_formed_for_any_file_name(name: str, paper: Path, tmp_path: Path) -> None:
    certificate = tmp_path / name
    certificate.write_bytes(paper.read_bytes())
    assert robimp("check", certificate, "--junit", tmp_path / "junit.xml").code == ExitCode.PROVEN
    (suite,) = suites(tmp_path / "junit.xml")
    assert suite.attrib["name"].endswith(".json") and red(suite) == {}


def test_an_internal_error_leaves_a_red_report(paper: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    genuine = judgement.check_bytes
    calls: list[int] = []

    def broken(data: bytes, time_limit: float) -> Verdict:
        calls.append(1)
        if len(calls) == 2:
            raise KeyError("unforeseen")
        return genuine(data, time_limit=time_limit)

    monkeypatch.setattr(judgement, "check_bytes", broken)
    assert robimp("check", paper, paper, "--junit", tmp_path / "junit.xml").code == ExitCode.INTERNAL
    first, second = suites(tmp_path / "junit.xml")
    assert red(first) == {} and "unforeseen" in red(second)["certificate"]


def test_a_killed_check_does_not_leave_an_earlier_green_report(paper: Path, tmp_path: Path) -> None:
    file = tmp_path / "junit.xml"
    assert robimp("check", paper, "--junit", file).code == 0 and red(suites(file)[0]) == {}
    script = (
        "import time\nfrom robimp.synthesis import judgement\n"
        "def hang(*a, **k):\n    print('checking', flush=True)\n    time.sleep(60)\n"
        "judgement.check_bytes = hang\n"
    )
    command = [*MAIN[:2], script + MAIN[2], "check", str(paper), "--junit", str(file)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stdout.readline() == "checking\n"
        process.send_signal(signal.SIGKILL)
    assert red(suites(file)[0]) == {"certificate": "error: the check did not finish"}


def test_ctrl_c_leaves_a_red_report(paper: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def pressed(*_: object, **__: object) -> Verdict:
        raise KeyboardInterrupt

    monkeypatch.setattr(judgement, "check_bytes", pressed)
    line = refused(ExitCode.UNDECIDED, "check", paper, "--junit", tmp_path / "junit.xml")
    assert "interrupted" in line
    assert red(suites(tmp_path / "junit.xml")[0]) == {"certificate": "error: the check did not finish"}


def test_a_report_that_cannot_be_written_is_refused_before_the_work(
    paper: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[object] = []
    monkeypatch.setattr(judgement, "check_bytes", asked.append)
    copy = tmp_path / "copy.json"
    copy.symlink_to(paper)
    before = paper.read_bytes()
    for file in (tmp_path, Path(os.devnull), paper / "below", copy, paper, PAPER):
        line = refused(ExitCode.INPUT, "check", paper, "--spec", PAPER, "--junit", file)
        assert str(file.parent) in line and ("cannot be written" in line or "overwrite" in line)
    assert asked == [] and paper.read_bytes() == before


# Output that nobody reads


def closed_pipe() -> int:
    reader, writer = os.pipe()
    os.close(reader)
    return writer


OUTPUTS: dict[str, Callable[[], int]] = {"closed pipe": closed_pipe, "full": lambda: os.open("/dev/full", os.O_WRONLY)}
COMMANDS = {
    "check": lambda paper: ("check", paper),
    "check --json": lambda paper: ("check", paper, "--json"),
    "--help": lambda paper: ("--help",),
    "schema": lambda paper: ("schema",),
    "synth": lambda paper: ("synth", PAPER, "-o", paper.parent / "again"),
}


@pytest.mark.parametrize("output", OUTPUTS)
@pytest.mark.parametrize("command", COMMANDS)
def test_output_that_cannot_be_written_is_one_line(command: str, output: str, paper: Path) -> None:
    stdout = OUTPUTS[output]()
    arguments = [*MAIN, *map(str, COMMANDS[command](paper))]
    try:
        done = subprocess.run(arguments, stdout=stdout, stderr=subprocess.PIPE, text=True, timeout=60)
    finally:
        os.close(stdout)
    assert done.returncode == ExitCode.INPUT
    assert done.stderr.startswith("robimp: standard output: cannot be written: ") and done.stderr.count("\n") == 1


def test_a_library_that_ends_the_program_is_an_internal_error(paper: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def leave(*_: object, **__: object) -> Verdict:
        raise SystemExit(0)

    monkeypatch.setattr(judgement, "check_bytes", leave)
    assert "a library ended the program" in refused(ExitCode.INTERNAL, "check", paper)


def test_a_report_is_red_when_the_verdict_could_not_be_said(paper: Path, tmp_path: Path) -> None:
    stdout = closed_pipe()
    file = tmp_path / "junit.xml"
    done = subprocess.run([*MAIN, "check", paper, paper, "--junit", file], stdout=stdout, stderr=subprocess.PIPE)
    os.close(stdout)
    assert done.returncode == ExitCode.INPUT
    first, second = suites(file)
    assert red(first) == {} and "standard output" in red(second)["certificate"]


@pytest.mark.parametrize(("redirection", "code"), [(">&-", 2), ("2>&-", 4), ("2>/dev/full", 4)])
def test_streams_that_are_closed_or_full_keep_the_exit_code(redirection: str, code: int, stiff: Path) -> None:
    command = ["sh", "-c", f'"$@" {redirection}', "sh", *MAIN, "check", str(stiff)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == code and "Traceback" not in done.stderr + done.stdout
    assert (done.stderr == "robimp: standard output: is closed\n") == (code == 2)
