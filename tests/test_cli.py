"""The command line as a contract: exit codes, one line per error, nothing written that is not whole."""

from __future__ import annotations

import copy
import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from command_line import refused, robimp

from robimp.synthesis import pipeline
from robimp.synthesis.check import Verdict, canonical_json
from robimp.synthesis.errors import ExitCode

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples"
PAPER, STIFF, FEEDBACK, EQ23 = (
    EXAMPLES / f"haninger2016-{name}.yaml" for name in ("paper", "stiff", "feedback", "eq23")
)
UNSTABLE = EXAMPLES / "unstable-optimum.yaml"
BAD = sorted((ROOT / "tests" / "data" / "specs" / "bad").glob("*.yaml"))

Json = dict[str, Any]


@pytest.fixture(scope="session")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the results of the examples whose coefficients are given: no search, one second in all."""
    folder = tmp_path_factory.mktemp("results")
    for spec in (PAPER, STIFF, UNSTABLE, FEEDBACK):
        robimp("synth", spec, "-o", folder / spec.stem)
    return folder


@pytest.fixture(scope="session")
def paper(results: Path) -> Path:
    """The certificate of the paper's own Q."""
    return results / PAPER.stem / "certificate.json"


@pytest.fixture
def empty(tmp_path: Path) -> Path:
    """A folder for output, in which nothing may appear."""
    return tmp_path / "out"


def claims(results: Path, spec: Path) -> dict[tuple[str, str], Json]:
    """Claims of a certificate by (id, form)."""
    certificate = json.loads((results / spec.stem / "certificate.json").read_text(encoding="utf-8"))
    return {(claim["id"], claim["form"]): claim for claim in certificate["claims"]}


# Exit codes of the examples


def test_the_papers_filter_is_proven(results: Path, tmp_path: Path) -> None:
    run = robimp("synth", PAPER, "-o", tmp_path)
    assert run.code == ExitCode.PROVEN
    assert run.out.startswith("PROVEN  haninger2016-paper  ω_B ≥ 8.87") and run.err == ""
    assert sorted(file.name for file in tmp_path.iterdir()) == ["certificate.json", "report.html", "simulation.json"]
    assert robimp("check", tmp_path / "certificate.json", "--spec", PAPER).code == ExitCode.PROVEN
    assert "refuted" not in {claim["status"] for claim in claims(results, PAPER).values() if claim["required"]}


def test_the_stiffer_impedance_is_refuted_where_the_port_is_active(results: Path, tmp_path: Path) -> None:
    run = robimp("synth", STIFF, "-o", tmp_path)
    assert run.code == ExitCode.REFUTED
    row = next(line for line in run.out.splitlines() if line.startswith("eq12") and "structured" in line)
    assert "refuted" in row and "51.3" in row
    assert "51.3" in refused(ExitCode.REFUTED, "check", tmp_path / "certificate.json")
    eq12 = claims(results, STIFF)["eq12", "structured"]
    assert eq12["status"] == "refuted" and 51.2 < Fraction(eq12["refuted_at"]["omega"]) < 51.5


def test_the_printed_18_is_impossible_without_stiffness_and_the_line_says_so(tmp_path: Path, empty: Path) -> None:
    spec = edited(tmp_path, PAPER, ("form: half-plane", "form: paper"), ("coefficients: {", "order: 4 # {"))
    for arguments in (("synth", spec, "-o", empty), ("bound", spec)):
        line = refused(ExitCode.INFEASIBLE, *arguments)
        for fact in (str(spec), "(18)", "cannot hold at ω → 0", "|Ω|", "use form: half-plane", "K̂ = 0"):
            assert fact in line
    assert not empty.exists()


def test_with_stiffness_the_printed_18_is_not_impossible_at_zero(tmp_path: Path, empty: Path) -> None:
    spec = edited(
        tmp_path,
        PAPER,
        ("form: half-plane", "form: paper"),
        ("coefficients: {", "order: 4 # {"),
        ("stiffness: 0  ", "stiffness: 9  "),
        ("stiffness: [0, 0]", "stiffness: [9, 9]"),
    )
    assert "cannot hold at ω → 0" not in robimp("synth", spec, "-o", empty, "--time-limit", "0").err


def test_an_unstable_loop_is_refuted_although_every_inequality_is_proven(results: Path) -> None:
    found = claims(results, UNSTABLE)
    for id in ("stability-free", "stability-locked"):
        assert found[id, "hurwitz"]["status"] == "refuted"
    for kind in (("eq9", "printed"), ("eq12", "structured"), ("eq18", "half-plane/physical"), ("peak", "sensitivity")):
        assert found[kind]["status"] == "proven", kind
    assert "stability-free" in refused(ExitCode.REFUTED, "check", results / UNSTABLE.stem / "certificate.json")


def test_dynamic_error_feedback_claim_by_claim(results: Path) -> None:
    found = claims(results, FEEDBACK)
    status = {kind: claim["status"] for kind, claim in found.items()}
    assert status == {
        ("stability-free", "hurwitz"): "proven",
        ("stability-locked", "hurwitz"): "proven",
        ("stability-free", "box"): "proven",
        ("eq9", "printed"): "proven",
        ("eq12", "structured"): "refuted",
        ("eq12", "paper"): "proven",
        ("eq18", "half-plane/physical"): "proven",
        ("bandwidth", "attenuation"): "proven",
        ("rendering", "every-load"): "proven",
        ("peak", "sensitivity"): "proven",
        ("friction", "strictly-positive-real"): "proven",
    }
    assert 155 < Fraction(found["eq12", "structured"]["refuted_at"]["omega"]) < 156
    assert Fraction("55.08") < Fraction(found["bandwidth", "attenuation"]["margin"]) < Fraction("55.09")
    assert 235 < Fraction(found["peak", "sensitivity"]["refuted_at"]["omega"]) < 237
    assert "155." in refused(ExitCode.REFUTED, "check", results / FEEDBACK.stem / "certificate.json")


def test_different_sensor_filters_are_warned_about(tmp_path: Path) -> None:
    assert "warning: controller.filters.position" in robimp("synth", FEEDBACK, "-o", tmp_path).line


def test_an_edited_specification_does_not_belong_to_the_certificate(paper: Path, tmp_path: Path) -> None:
    spec = edited(tmp_path, PAPER, ("inertia: 0.03 ", "inertia: 0.031 "))
    line = refused(ExitCode.MISMATCH, "check", paper, "--spec", spec)
    assert "plant.inertia 0.03 → 0.031" in line
    named = edited(tmp_path, PAPER, ("peak: 2.0", "friction: report"))
    assert "constraints.peak: only in the certificate" in refused(ExitCode.MISMATCH, "check", paper, "--spec", named)
    assert robimp("check", paper, "--spec", PAPER).code == ExitCode.PROVEN


def test_a_reformatted_specification_still_belongs(paper: Path, tmp_path: Path) -> None:
    spec = edited(tmp_path, PAPER, ("inertia: 0.03 ", "inertia: 30.0e-3 "), ("peak: 2.0", "peak: 2"))
    assert robimp("check", paper, "--spec", spec).code == ExitCode.PROVEN


def test_the_gravest_certificate_decides(results: Path, paper: Path) -> None:
    stiff = results / STIFF.stem / "certificate.json"
    run = robimp("check", paper, stiff, "absent.json")
    assert run.code == ExitCode.REFUTED
    assert run.out.startswith(f"PROVEN  {paper}") and run.err.startswith(f"{stiff}: ") and "absent.json" in run.err
    assert robimp("check", paper, "absent.json", stiff).code == ExitCode.REFUTED
    assert robimp("check", paper, "absent.json").code == ExitCode.INPUT


def test_a_certificate_may_come_from_a_pipe(paper: Path) -> None:
    script = "import sys\nfrom robimp.synthesis.cli import main\nmain()"
    command = [sys.executable, "-c", script, "check", "/dev/stdin", "--spec", str(PAPER)]
    done = subprocess.run(command, input=paper.read_bytes(), capture_output=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize("spec", [PAPER, STIFF, UNSTABLE, FEEDBACK], ids=lambda spec: spec.stem)
def test_the_simulation_agrees_with_every_verdict(results: Path, spec: Path) -> None:
    run = robimp("simulate", results / spec.stem / "certificate.json", "--loads", "100")
    assert (run.code, run.err) == (0, "") and run.out.startswith("AGREES")


# Input that cannot be used


@pytest.mark.parametrize("spec", BAD, ids=lambda spec: spec.stem)
def test_a_bad_specification_is_one_line_and_writes_nothing(spec: Path, empty: Path) -> None:
    assert refused(ExitCode.INPUT, "synth", spec, "-o", empty).startswith(f"robimp: {spec}")
    assert not empty.exists()


def test_the_same_run_with_a_good_specification_writes(empty: Path) -> None:
    assert robimp("synth", PAPER, "-o", empty).code == 0 and len(list(empty.iterdir())) == 3


def test_a_bad_specification_is_refused_by_every_command_that_takes_one(paper: Path) -> None:
    bad = BAD[0]
    assert str(bad) in refused(ExitCode.INPUT, "bound", bad)
    assert str(bad) in refused(ExitCode.INPUT, "check", paper, "--spec", bad)


def test_one_bad_specification_among_good_ones_starts_nothing(empty: Path) -> None:
    refused(ExitCode.INPUT, "synth", PAPER, BAD[0], "-o", empty)
    assert not empty.exists()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((), "Missing command"),
        (("synth",), "SPEC"),
        (("check",), "CERT"),
        (("sinth",), "sinth"),
        (("--unknown",), "--unknown"),
        (("synth", "--unknown", str(PAPER)), "--unknown"),
        (("synth", str(PAPER), "--time-limit", "-1"), "--time-limit"),
        (("synth", str(PAPER), "--time-limit", "nan"), "--time-limit"),
        (("synth", str(PAPER), "--time-limit", "soon"), "--time-limit"),
        (("check", "x.json", "--time-limit", "nan"), "--time-limit"),
        (("bound", str(PAPER), "--terms", "3"), "--terms"),
        (("synth", "absent.yaml"), "absent.yaml"),
        (("synth", str(ROOT)), str(ROOT)),
        (("synth", str(PAPER), str(PAPER)), "two specifications are named 'haninger2016-paper'"),
        (("simulate", "absent.json"), "absent.json"),
        (("check", "line\nbreak.json"), r"line\nbreak.json"),
        (("synth", "bell\a.yaml"), r"bell\x07.yaml"),
    ],
    ids=lambda value: " ".join(value) or "nothing" if isinstance(value, tuple) else None,
)
def test_wrong_usage_is_one_line(arguments: tuple[str, ...], says: str) -> None:
    assert says in refused(ExitCode.INPUT, *arguments)


def test_output_that_cannot_be_written_is_refused_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "file"
    file.write_bytes(b"mine")
    asked = []
    monkeypatch.setattr(pipeline, "synthesize", lambda *a, **k: asked.append(a))
    for output in (file, file / "below"):
        assert "cannot be written" in refused(ExitCode.INPUT, "synth", EQ23, "-o", output)
    assert asked == [] and file.read_bytes() == b"mine"


def test_a_folder_that_turns_unwritable_meanwhile_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "out"
    genuine = pipeline.synthesize

    def in_the_meantime(*arguments: Any, **options: Any) -> pipeline.Result:
        folder.write_bytes(b"a file now")
        return genuine(*arguments, **options)

    monkeypatch.setattr(pipeline, "synthesize", in_the_meantime)
    assert "cannot be written" in refused(ExitCode.INPUT, "synth", PAPER, "-o", folder)
    assert folder.read_bytes() == b"a file now"


def edited(folder: Path, original: Path, *pairs: tuple[str, str]) -> Path:
    """A copy of a specification with pieces of its text replaced, each where it first stands."""
    text = original.read_text(encoding="utf-8")
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new, 1)
    path = folder / "edited.yaml"
    path.write_text(text, encoding="utf-8")
    return path


# Damaged certificates

Damage = Callable[[Json], Json | bytes]


def reseal(certificate: Json) -> Json:
    """With digests that match the content again."""
    certificate["spec_sha256"] = sha256(canonical_json(certificate["spec"])).hexdigest()
    body = {key: part for key, part in certificate.items() if key != "end"}
    return {
        **body,
        "end": {"claims": len(certificate["claims"]), "body_sha256": sha256(canonical_json(body)).hexdigest()},
    }


def text_of(certificate: Json) -> bytes:
    return (json.dumps(certificate, indent=1, ensure_ascii=False) + "\n").encode()


def swapped(old: str, new: str) -> Damage:
    def damage(certificate: Json) -> bytes:
        text = text_of(certificate).decode()
        assert old in text
        return text.replace(old, new, 1).encode()

    return damage


def changed(edit: Callable[[Json], object]) -> Damage:
    """Edited and sealed again."""

    def damage(certificate: Json) -> Json:
        edit(certificate)
        return reseal(certificate)

    return damage


def claim(certificate: Json, id: str) -> Json:
    return next(claim for claim in certificate["claims"] if claim["id"] == id)


DAMAGED: dict[str, tuple[int, Damage]] = {
    "empty": (2, lambda c: b""),
    "truncated at the end": (2, lambda c: text_of(c)[:-3]),
    "truncated in the middle": (2, lambda c: text_of(c)[: len(text_of(c)) // 2]),
    "garbage appended": (2, lambda c: text_of(c) + b"x"),
    "a second object appended": (2, lambda c: text_of(c) * 2),
    "not UTF-8": (2, lambda c: b"\xff\xfe" + text_of(c)),
    "a list": (2, lambda c: b"[]"),
    "a digit flipped": (2, swapped('"2000"', '"2001"')),
    "a duplicate key": (2, swapped('"bound": null', '"bound": null, "bound": null')),
    "a float": (2, swapped('"2000"', "2000.0")),
    "a float in text": (2, changed(lambda c: c["bandwidth"].update(bound="40.5"))),
    "NaN": (2, swapped('"bound": null', '"bound": NaN')),
    "Infinity": (2, swapped('"bound": null', '"bound": -Infinity')),
    "another version": (2, changed(lambda c: c.update(robimp_certificate=2))),
    "version true": (2, changed(lambda c: c.update(robimp_certificate=True))),
    "no version": (2, changed(lambda c: c.pop("robimp_certificate"))),
    "an unknown field": (2, changed(lambda c: claim(c, "eq9").update(trust="me"))),
    "a claim unknown": (2, changed(lambda c: claim(c, "eq9").update(id="eq99"))),
    "a claim twice": (2, changed(lambda c: c["claims"].append(copy.deepcopy(c["claims"][0])))),
    "a claim dropped, not resealed": (2, lambda c: {**c, "claims": c["claims"][1:]}),
    "a zero denominator": (2, changed(lambda c: c["controller"]["Q"].update(numerator=["2000/0"]))),
    "zero for a denominator": (2, changed(lambda c: c["controller"]["Q"].update(denominator=["0", "0", "0"]))),
    "100,000 digits": (2, changed(lambda c: c["controller"]["Q"].update(numerator=["9" * 100_000]))),
    "not in lowest terms": (2, changed(lambda c: c["controller"]["Q"].update(numerator=["4000/2"]))),
    "deeply nested": (2, lambda c: b'{"a":' * 100_000),
    "the wrong digest": (2, lambda c: {**c, "spec_sha256": "0" * 64}),
    "the end missing": (2, lambda c: {key: part for key, part in c.items() if key != "end"}),
    "status of another word": (2, changed(lambda c: claim(c, "eq9").update(status="true"))),
    "Q without its C": (6, changed(lambda c: c["controller"]["Q"].update(numerator=["2001"]))),
    "a required claim removed": (6, changed(lambda c: c["claims"].remove(claim(c, "stability-free")))),
    "a required claim declared optional": (6, changed(lambda c: claim(c, "peak").update(required=False))),
    "a shorter interval": (6, changed(lambda c: claim(c, "peak").update(interval=["0", "1"]))),
    "a requirement dropped from the spec alone": (6, changed(lambda c: c["spec"]["constraints"].update(peak=None))),
    "a feedback controller for a dob": (
        6,
        changed(lambda c: c.update(controller={"type": "dynamic-feedback", "C": c["controller"]["C"]})),
    ),
    "a margin too good": (4, changed(lambda c: claim(c, "eq9").update(margin="100", refuted_at=None))),
    "a peak too low": (4, changed(lambda c: claim(c, "peak").update(margin="1"))),
    "another plant": (4, changed(lambda c: c["spec"]["plant"].update(damping="1/8"))),
    "a witness that is none": (4, changed(lambda c: claim(c, "eq9")["refuted_at"].update(omega="1"))),
    "refuted declared proven": (
        4,
        changed(lambda c: claim(c, "friction").update(status="proven", margin="1/1000", refuted_at=None)),
    ),
    "proven declared refuted": (4, changed(lambda c: claim(c, "peak").update(status="refuted", margin=None))),
}


@pytest.mark.parametrize(("code", "damage"), DAMAGED.values(), ids=DAMAGED)
def test_a_damaged_certificate_is_never_proven(code: int, damage: Damage, paper: Path, tmp_path: Path) -> None:
    content = damage(json.loads(paper.read_text(encoding="utf-8")))
    path = tmp_path / "damaged.json"
    path.write_bytes(content if isinstance(content, bytes) else text_of(content))
    assert refused(ExitCode(code), "check", path).startswith(f"{path}: ")
    simulated = robimp("simulate", path, "--loads", "0").code  # a false claim is not what the prover finds: 6
    assert simulated in ((4, 6) if code == ExitCode.REFUTED else (code,))


def test_an_undamaged_copy_is_proven(paper: Path, tmp_path: Path) -> None:
    path = tmp_path / "copy.json"
    path.write_bytes(text_of(reseal(json.loads(paper.read_text(encoding="utf-8")))))
    assert robimp("check", path).code == ExitCode.PROVEN


def test_a_certificate_that_is_no_file_is_refused(tmp_path: Path) -> None:
    for path, reason in ((tmp_path, "directory"), (tmp_path / "absent.json", "No such file")):
        assert reason in refused(ExitCode.INPUT, "check", path)
        assert reason in refused(ExitCode.INPUT, "simulate", path)


def test_a_check_out_of_time_is_undecided(paper: Path) -> None:
    with patch("time.monotonic", side_effect=iter(range(0, 10**6, 100)).__next__):
        assert "time" in refused(ExitCode.UNDECIDED, "check", paper)


# JSON and debugging


@pytest.mark.parametrize("command", ["synth", "check", "simulate", "bound", "schema", "check refuted"])
def test_json_is_one_object(command: str, results: Path, paper: Path, tmp_path: Path) -> None:
    stiff = results / STIFF.stem / "certificate.json"
    arguments: dict[str, tuple[str | Path, ...]] = {
        "synth": ("synth", PAPER, "-o", tmp_path, "--json"),
        "check": ("check", paper, "--json"),
        "simulate": ("simulate", paper, "--json", "--loads", "100"),
        "bound": ("bound", EQ23, "--terms", "16", "--json"),
        "schema": ("schema",),
        "check refuted": ("check", stiff, "--json"),
    }
    run = robimp(*arguments[command])
    content = json.loads(run.out)
    assert run.err == ""
    assert {
        "synth": lambda: content["exit_code"] == 0 and 8.87 < content["omega_B"] < 8.88,
        "check": lambda: content["exit_code"] == 0 and content["file"] == str(paper),
        "simulate": lambda: content["agrees"] is True and len(content["trials"]) > 5,
        "bound": lambda: content["terms"] == 16 and 10 < content["omega_B"] < 60,
        "schema": lambda: "plant" in content["properties"],
        "check refuted": lambda: content["exit_code"] == run.code == 4 and "51.3" in content["message"],
    }[command]()
    json.loads(run.out, parse_constant=pytest.fail)


def test_debug_shows_where_and_keeps_the_code() -> None:
    for position in (("--debug", "synth", "absent.yaml"), ("synth", "absent.yaml", "--debug")):
        run = robimp(*position)
        assert run.code == ExitCode.INPUT and "Traceback" in run.err and run.err.splitlines()[-1].startswith("robimp:")
    assert "Traceback" not in robimp("synth", "absent.yaml").err


def test_an_unforeseen_error_is_internal_and_one_line(monkeypatch: pytest.MonkeyPatch, empty: Path) -> None:
    def broken(*_: object, **__: object) -> None:
        raise KeyError("unforeseen\nof two lines")

    monkeypatch.setattr(pipeline, "certify", broken)
    line = refused(ExitCode.INTERNAL, "synth", PAPER, "-o", empty)
    assert "KeyError" in line and "--debug" in line
    assert not empty.exists()
    assert "Traceback" in robimp("synth", PAPER, "-o", empty, "--debug").err


@pytest.mark.parametrize("arguments", [("--help",), ("synth", "--help")])
def test_help_goes_to_standard_output(arguments: tuple[str, ...]) -> None:
    run = robimp(*arguments)
    assert run.code == 0 and run.err == "" and "Usage: robimp" in run.out


# Interruption


@pytest.mark.parametrize("station", ["synthesize", "certify", "check_bytes", "verify"])
def test_ctrl_c_leaves_no_traceback_and_no_file(station: str, empty: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def pressed(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(pipeline, station, pressed)
    assert "interrupted" in refused(ExitCode.UNDECIDED, "synth", PAPER, "-o", empty)
    assert not empty.exists()


@pytest.mark.parametrize("delay", [0.05, 0.7])
def test_ctrl_c_during_a_real_search(tmp_path: Path, delay: float) -> None:
    script = """
from robimp.synthesis.cli import main
from robimp.synthesis.solve.search import Search
genuine = Search._optima
def announced(*arguments):
    print("searching", flush=True)
    return genuine(*arguments)
Search._optima = announced
main()
"""
    command = [sys.executable, "-c", script, "synth", str(EXAMPLES / "haninger2016.yaml"), "-o", str(tmp_path / "out")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stdout.readline() == "searching\n"
        time.sleep(delay)
        assert process.poll() is None, "the search ended before it could be interrupted"
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=20)
    assert process.returncode == ExitCode.UNDECIDED
    assert "interrupted" in err and "Traceback" not in err
    assert not (tmp_path / "out").exists()


# Solvers that fail or lie, and stations that disagree


class Liar:
    """An IPOPT that calls anything a success."""

    def __init__(self, answer: Callable[[Any], Any]) -> None:
        self.answer = answer

    def __call__(self, *, x0: Any, **_: object) -> dict[str, Any]:
        return {"x": self.answer(np.array(x0).ravel())}

    def stats(self) -> dict[str, object]:
        return {"success": True, "return_status": "Solve_Succeeded"}


def lying(monkeypatch: pytest.MonkeyPatch, answer: Callable[[Any], Any]) -> None:
    """Replace both solvers: no bound, and an NLP solver that answers as told."""
    nlp, search = (import_module(f"robimp.synthesis.solve.{name}") for name in ("nlp", "search"))
    monkeypatch.setattr(import_module("robimp.synthesis.solve.bound"), "bound", lambda *a, **k: None)
    monkeypatch.setattr(nlp.ca, "nlpsol", lambda *a, **k: Liar(answer))
    for name, value in (("DRAWN", 4), ("FIRST_RANDOM", 2), ("ROUNDS", 2), ("AGREE", 2)):
        monkeypatch.setattr(search, name, value)


@pytest.mark.parametrize(
    "answer",
    [lambda x: np.full_like(x, np.nan), lambda x: np.full_like(x, np.inf), lambda x: x],
    ids=["nan", "inf", "the start, called a solution"],
)
def test_a_lying_solver_ends_undecided(
    answer: Callable[[Any], Any], empty: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lying(monkeypatch, answer)
    line = refused(ExitCode.UNDECIDED, "synth", EQ23, "-o", empty)
    assert (
        str(EQ23) in line and "no controller of this structure" in line and "even the convex bound finds none" in line
    )
    assert not empty.exists()


def test_a_solver_that_happens_to_answer_a_good_filter_is_believed_after_the_proof(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    paper_over_omega_0 = {}

    def answer(x: Any) -> Any:
        omega_0 = paper_over_omega_0["omega_0"]
        return np.array([np.log(50 / omega_0), 0.7075, 0.8, np.log(8.87 / omega_0)])

    search = import_module("robimp.synthesis.solve.search")
    genuine = search.Search.run

    def run(self: Any) -> Any:
        paper_over_omega_0["omega_0"] = self.omega_0
        return genuine(self)

    monkeypatch.setattr(search.Search, "run", run)
    lying(monkeypatch, answer)
    result = robimp("synth", EQ23, "-o", tmp_path)
    assert result.code == ExitCode.PROVEN and "ω_B ≥ 8.87" in result.out


def test_without_a_bound_the_line_says_what_to_try(empty: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    search = import_module("robimp.synthesis.solve.search")
    monkeypatch.setattr(search.Search, "run", lambda self: None)
    monkeypatch.setattr(import_module("robimp.synthesis.solve.bound"), "bound", lambda *a, **k: None)
    assert "try another order" in refused(ExitCode.UNDECIDED, "synth", EQ23, "-o", empty)
    assert "by the solver's word" in refused(ExitCode.UNDECIDED, "bound", EQ23)
    assert not empty.exists()


def test_out_of_time_is_undecided_and_writes_nothing(empty: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(import_module("robimp.synthesis.solve.bound"), "bound", lambda *a, **k: None)
    assert "out of time" in refused(ExitCode.UNDECIDED, "synth", EQ23, "-o", empty, "--time-limit", "0")
    assert not empty.exists()


@pytest.mark.parametrize("code", [2, 4, 5, 6])
def test_a_checker_that_disagrees_stops_everything(code: int, empty: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipeline, "check_bytes", lambda data, **_: Verdict(code, "eq9 printed: no"))
    line = refused(ExitCode.INTERNAL, "synth", PAPER, "-o", empty)
    assert "prover says proven" in line and "eq9 printed: no" in line
    assert not empty.exists()


def test_a_false_claim_is_caught_even_where_another_is_refuted_anyway(
    empty: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    genuine = pipeline.certify

    def wrong(*arguments: Any) -> Any:
        claims = genuine(*arguments)
        return tuple(replace(c, margin=Fraction(1), refuted_at=None) if c.id == "peak" else c for c in claims)

    monkeypatch.setattr(pipeline, "certify", wrong)
    assert "peak sensitivity: does not hold" in refused(ExitCode.INTERNAL, "synth", STIFF, "-o", empty)
    assert not empty.exists()


def test_a_simulation_that_disagrees_stops_everything(empty: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    genuine = pipeline.verify

    def flipped(*arguments: Any, **options: Any) -> Any:
        trials = genuine(*arguments, **options)
        return replace(trials, wall_stable=not trials.wall_stable)

    def scaled(*arguments: Any, **options: Any) -> Any:
        trials = genuine(*arguments, **options)
        off = tuple(replace(t, Z_measured=tuple(Z * 1.001 for Z in t.Z_measured)) for t in trials.trials)
        return replace(trials, trials=off)

    for disagreeing, says in ((flipped, "rigid wall"), (scaled, "measured Z differs")):
        monkeypatch.setattr(pipeline, "verify", disagreeing)
        assert says in refused(ExitCode.INTERNAL, "synth", PAPER, "-o", empty)
        assert not empty.exists()


def test_simulate_reports_a_contradiction(paper: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    replay = import_module("robimp.synthesis.replay")
    genuine = replay.verify

    def flipped(*arguments: Any, **options: Any) -> Any:
        trials = genuine(*arguments, **options)
        return replace(trials, wall_stable=not trials.wall_stable)

    monkeypatch.setattr(replay, "verify", flipped)
    assert "contradicts: rigid wall" in refused(ExitCode.REFUTED, "simulate", paper, "--loads", "0")
    content = json.loads(robimp("simulate", paper, "--json", "--loads", "0").out)
    assert content["agrees"] is False


def test_simulate_refuses_a_status_that_is_not_so(paper: Path, tmp_path: Path) -> None:
    content = json.loads(paper.read_bytes())
    claim = next(c for c in content["claims"] if c["id"] == "friction")
    assert claim["status"] == "refuted"
    claim.update(status="undecided", refuted_at=None)
    edited = tmp_path / "edited.json"
    edited.write_text(json.dumps(reseal(content)))
    assert "friction strictly-positive-real is written as undecided" in refused(ExitCode.MISMATCH, "simulate", edited)


@pytest.mark.parametrize("key", ["statement", "equation", "uncertainty", "assumptions", "not_claimed"])
def test_simulate_refuses_words_that_were_not_proven(key: str, paper: Path, tmp_path: Path) -> None:
    content = json.loads(paper.read_bytes())
    if key in content:
        content[key] = content[key][:-1]
    else:
        claim(content, "peak")[key] = "safe for\neverybody"
    edited = tmp_path / "edited.json"
    edited.write_text(json.dumps(reseal(content)))
    assert key in refused(ExitCode.MISMATCH, "simulate", edited)
    content["producer"]["robimp"] = "0.0.1"  # its words are not known here
    edited.write_text(json.dumps(reseal(content)))
    assert robimp("simulate", edited, "--loads", "0").code == ExitCode.PROVEN
