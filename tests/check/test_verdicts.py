"""From bytes to a verdict and a line of output: what is said, on which stream, with which exit code, and how soon."""

from __future__ import annotations

import io
import json
import math
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import Any

import pytest
from certificate_builder import claim, data, dob, find, seal, spec
from claim_floats import Json

from robimp.synthesis import check
from robimp.synthesis.check import Verdict, check_bytes, check_file
from robimp.synthesis.check.__main__ import main
from robimp.synthesis.check.outcome import CheckError, demand, tick
from robimp.synthesis.check.proofs import Prover
from robimp.synthesis.check.reader import read
from robimp.synthesis.check.verdict import _decision

WHOLE = ["0", "inf"]
OMEGA_B = "1097399/1000000"


def small(*more: Json, **constraints: Any) -> Json:
    """A first-order Q for an ideal actuator: |1 − Q|² = (x + 1)/(x + 25), proven in a few milliseconds."""
    nothing = {"eq9": None, "eq12": None, "eq18": None, "peak": None}
    s = spec(
        plant={"inertia": "1", "damping": "1", "stiffness": "0"},
        uncertainty={"box": None},
        actuator={"type": "ideal"},
        impedance={"inertia": "1", "damping": "1", "stiffness": "1"},
        constraints={**nothing, **constraints},
    )
    claims = [claim(f"stability-{end}", "hurwitz", WHOLE, "1/4", True) for end in ("free", "locked")]
    claims.append(claim("bandwidth", "attenuation", ["0", OMEGA_B], OMEGA_B, True))
    body = {
        "robimp_certificate": 1,
        "spec": s,
        "controller": dob(["4"], ["1", "5"]),
        "bandwidth": {"proven": OMEGA_B, "refuted_at": None, "bound": None},
        "claims": [*claims, *more],
        "assumptions": [],
        "not_claimed": [],
        "producer": {},
    }
    return json.loads(json.dumps(body))


def judged(cert: Json, **options: float) -> Verdict:
    return check_bytes(data(seal(cert)), **options)


def peak(margin: str | None, required: bool = True, /, **more: Any) -> Json:
    return {**claim("peak", "sensitivity", WHOLE, margin, required), **more}


def refuted(value: str, omega: str | None) -> Json:
    return {"status": "refuted", "margin": None, "refuted_at": {"value": value, "omega": omega, "load": None}}


TRUE_PEAK, FALSE_PEAK = peak("1"), peak("99/100", False)  # |1 − Q| grows up to 1 at infinity
UNDECIDED = claim("eq9", "printed", WHOLE, None, True, status="undecided")
BOTH: Json = {  # (12) over discs is for a box or for discs: a mismatch that shows in the proof
    "uncertainty": {
        "box": {"inertia": ["1", "1"], "damping": ["1", "1"], "stiffness": ["0", "0"]},
        "weight": {"numerator": ["1/9"], "denominator": ["1"]},
    }
}
UNDEFINED = claim("eq12", "disc", WHOLE, "0", False)


def test_proven_with_omega_b_rounded_down_and_the_number_of_proofs() -> None:
    optional = claim("eq9", "printed", WHOLE, None, False, status="undecided")
    found = judged(small(peak("1", False), optional))
    assert (found.exit_code, found.omega_b) == (0, "1.09739")
    assert found.message == "ω_B ≥ 1.09739 rad/s  4 claims"
    assert found.claims[2] == ("bandwidth", "attenuation", "proven", "bandwidth attenuation: proven")
    assert found.claims[4] == ("eq9", "printed", "undecided", "eq9 printed: undecided") and len(found.claims) == 5


def test_the_message_of_a_claim_that_is_not_verified() -> None:
    found = judged(small(FALSE_PEAK))
    message = "peak sensitivity: does not hold at ω = inf rad/s"
    assert (found.exit_code, found.message, found.omega_b) == (4, found.claims[3][3], None)
    assert found.claims[3][:3] == ("peak", "sensitivity", "not verified") and found.message.startswith(message[:34])
    assert [status for _, _, status, _ in found.claims[:3]] == ["proven"] * 3


@pytest.mark.parametrize(
    ("more", "code", "first"),
    [
        ([UNDECIDED, FALSE_PEAK], 4, "peak"),
        ([UNDEFINED, FALSE_PEAK], 4, "peak"),
        ([UNDECIDED, UNDEFINED], 6, "eq12"),
        ([UNDEFINED, UNDECIDED], 6, "eq12"),
        ([UNDECIDED], 5, "eq9"),
        ([FALSE_PEAK, claim("noise", "command", WHOLE, "1/1000", False)], 4, "peak"),
        ([claim("noise", "command", WHOLE, "1/1000", False), FALSE_PEAK], 4, "noise"),
    ],
)
def test_the_gravest_fault_is_said_and_of_these_the_first(more: list[Json], code: int, first: str) -> None:
    cert = small(*more, **({"eq9": {}} if UNDECIDED in more else {}))
    cert["spec"]["uncertainty"].update(BOTH["uncertainty"])
    found = judged(cert)
    assert found.exit_code == code and found.message.startswith(f"{first} ")


STATUSES: dict[str, tuple[Json, int, str]] = {
    "proven": (small(TRUE_PEAK, peak="1"), 0, "proven"),
    "not required and undecided": (small(peak(None, False, status="undecided")), 0, "undecided"),
    "required and undecided": (small(peak(None, status="undecided"), peak="1"), 5, "required, and undecided"),
    "not required and refuted": (small(peak(None, False, **refuted("1/2", "3"))), 0, "refuted"),
    "required and refuted": (
        small(peak(None, **refuted("1/2", "3")), peak="1/2"),
        4,
        "required, and refuted at ω = 3 rad/s",
    ),
    "refuted where it holds": (
        small(peak(None, False, **refuted("1/2", "1"))),
        4,
        "its witness of refutation is false: it holds there",
    ),
    "tight where it fails": (
        small({**peak("1", False), "refuted_at": {"value": "1/2", "omega": "3", "load": None}}),
        0,
        "proven",
    ),
    "tight where it holds": (
        small({**peak("1", False), "refuted_at": {"value": "1/2", "omega": "1", "load": None}}),
        4,
        "its witness of tightness is false: it holds there",
    ),
    "false, with a true witness": (
        small({**peak("1/2", False), "refuted_at": {"value": "1/2", "omega": "3", "load": None}}),
        4,
        "does not hold",
    ),
}


@pytest.mark.parametrize("name", STATUSES)
def test_a_claim_is_judged_by_its_status_and_whether_it_is_required(name: str) -> None:
    cert, code, text = STATUSES[name]
    found = judged(cert)
    assert found.exit_code == code and text in found.claims[-1][3]


def test_roots_are_refuted_at_no_frequency() -> None:
    for value, code in (("2", 0), ("1/4", 4)):
        cert = small()
        find(cert, "stability-free")["refuted_at"] = {"value": value, "omega": None, "load": None}
        assert judged(cert).exit_code == code


@pytest.mark.parametrize(
    ("interval", "status"), [(WHOLE, "not verified"), (["0", "9"], "proven"), (["1", "inf"], "proven")]
)
def test_only_on_the_whole_axis_the_port_has_to_be_passive_at_its_ends(interval: list[str], status: str) -> None:
    """At ω = ∞ the lightest load feels like its own inertia and the desired one less the nominal one: −1/4."""
    cert = small(claim("eq12", "structured", interval, "-9", False))
    cert["spec"]["impedance"]["inertia"] = "1/4"
    cert["spec"]["uncertainty"]["box"] = {"inertia": ["1/2", "3/2"], "damping": ["1", "1"], "stiffness": ["0", "0"]}
    cert["claims"].append({**claim("stability-free", "box", WHOLE, None, True), "status": "undecided"})
    found = judged(cert)
    assert found.claims[3][:3] == ("eq12", "structured", status), found
    assert status == "proven" or found.claims[3][3].endswith("Z at infinity is not finite and >= 0")


def test_what_does_not_fit_the_specification_is_not_even_tried() -> None:
    cert = small()
    cert["spec"]["controller"]["order"] = 0
    assert judged(cert) == Verdict(6, "controller.Q: is above the specification's order")


def on_cells(margin: str) -> Json:
    """A range of the desired damping: (9) takes cells, and the box of impedances stays undecided here."""
    cert = small(claim("eq9", "printed", WHOLE, margin, False))
    cert["spec"]["impedance"]["damping"] = ["9/10", "11/10"]
    cert["spec"]["uncertainty"]["weight"] = {"numerator": ["1/9"], "denominator": ["1"]}
    cert["claims"].append({**claim("stability-free", "box", WHOLE, None, True), "status": "undecided"})
    return cert


@pytest.mark.parametrize(("margin", "status"), [("1/9", "proven"), ("99", "not verified")])
def test_what_polynomials_do_not_decide_is_decided_on_cells(margin: str, status: str) -> None:
    first, *_, last = judged(on_cells(margin)).claims[2:-1]
    assert (first[2], last[:3]) == ("proven", ("eq9", "printed", status))


def test_without_the_second_tier_polynomials_still_decide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "robimp.synthesis.check.enclosure.claims", None)
    assert judged(small(TRUE_PEAK, peak="1")).exit_code == 0
    assert judged(on_cells("1")).claims[3][2:] == ("not verified", "eq9 printed: needs `enclosure`, which is absent")
    assert judged(on_cells("1")).exit_code == 5


@pytest.mark.parametrize(("limit", "said"), [(math.nan, "not a number"), (-1.0, "reached"), (0.0, "reached")])
def test_no_time_is_no_proof(limit: float, said: str) -> None:
    found = judged(small(), time_limit=limit)
    assert found.exit_code == 5 and "time limit" in found.message and found.message.endswith(said)


def test_after_the_limit_no_claim_is_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each would make its polynomials, which may take a second, before it looks at the clock itself."""
    begun: list[Any] = []
    monkeypatch.setattr(Prover, "fault", lambda _, *asked: begun.append(asked) or "")
    certificate = read(data(seal(small())))
    assert _decision(certificate, monotonic() + 30)("the first") == "" and begun == [("the first",)]
    with pytest.raises(CheckError, match="time limit reached"):
        _decision(certificate, monotonic() - 1)("the second")
    assert len(begun) == 1


def test_a_limit_in_seconds_from_now() -> None:
    assert judged(small(), time_limit=30).exit_code == 0 == judged(small(), time_limit=math.inf).exit_code
    tick(monotonic() + 1)
    with pytest.raises(CheckError, match="time limit reached") as stop:
        tick(monotonic() - 1e-3)
    assert stop.value.code == 5


def test_what_is_demanded_and_not_so_stops_with_a_code() -> None:
    demand(True, "said of nothing", 4)
    for code in (2, 4, 6):
        with pytest.raises(CheckError, match="why") as stop:
            demand(False, "why", code)
        assert stop.value.code == code and str(stop.value) == "why"
    with pytest.raises(CheckError) as stop:
        demand(False, "input")
    assert stop.value.code == 2


@pytest.mark.parametrize(
    ("given", "shown"),
    [
        (Verdict(0, "ω_B ≥ 1 rad/s  3 claims", "1"), "<Verdict PROVEN, ω_B ≥ 1 rad/s, 3 claims>"),
        (Verdict(2, "file: absent"), "<Verdict INPUT, file: absent>"),
        (Verdict(4, "no"), "<Verdict REFUTED, no>"),
        (Verdict(5, "late"), "<Verdict UNDECIDED, late>"),
        (Verdict(6, "other"), "<Verdict MISMATCH, other>"),
        (Verdict(1, "odd"), "<Verdict exit code 1, odd>"),
    ],
)
def test_a_verdict_shows_itself(given: Verdict, shown: str) -> None:
    assert repr(given) == shown
    escaped = shown[1:-1].replace("&", "&amp;")
    assert given._repr_html_() == f"<div><b>{escaped}</b></div>"


def test_a_verdict_shows_its_claims_in_a_notebook() -> None:
    found = Verdict(4, "<no>", None, (("a", "b", "proven", "long"), ("c", "<d>", "not verified", "longer")))
    table = "<tr><td>a</td><td>b</td><td>proven</td></tr><tr><td>c</td><td>&lt;d&gt;</td><td>not verified</td></tr>"
    assert found._repr_html_() == f"<div><b>Verdict REFUTED, &lt;no&gt;</b></div><table>{table}</table>"


@pytest.fixture
def files(tmp_path: Path) -> dict[str, str]:
    """One file for each exit code."""
    named = {
        "good": small(),
        "false": small(FALSE_PEAK),
        "undecided": small(UNDECIDED, eq9={}),
        "short": small(TRUE_PEAK, peak="1/2"),
    }
    for name, cert in named.items():
        (tmp_path / name).write_bytes(data(seal(cert)))
    return {name: str(tmp_path / name) for name in named}


def test_a_file_of_four_million_bytes_and_one_more(tmp_path: Path) -> None:
    file = tmp_path / "large"
    for size, code in ((4_000_000, 0), (4_000_001, 2), (4_000_002, 2)):
        file.write_bytes(data(seal(small())).ljust(size))
        assert check_file(file).exit_code == code


def test_what_is_no_file_is_2(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("pipe")
    for place in ("pipe", "link"):  # opening one waits for somebody who writes
        assert check_file(tmp_path / place) == Verdict(2, "file: a named pipe, not a file")
    assert check_file(tmp_path / "none") == Verdict(2, "file: cannot be read: No such file or directory")
    assert check_file(tmp_path) == Verdict(2, "file: cannot be read: Is a directory")
    assert check_file("a\0b").message.startswith("file: cannot be read: ")


def test_a_pipe_of_the_shell_is_read(files: dict[str, str]) -> None:
    reading, writing = os.pipe()
    os.write(writing, Path(files["good"]).read_bytes())
    os.close(writing)
    assert check_file(f"/dev/fd/{reading}").exit_code == 0
    os.close(reading)


def test_the_time_of_a_file_is_limited_too(files: dict[str, str]) -> None:
    assert check_file(files["good"]).exit_code == 0 and check_file(files["good"], time_limit=-1).exit_code == 5
    assert check(files["good"]).exit_code == 0 and check(files["good"], time_limit=-1).exit_code == 5


def run(*arguments: str, capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    code = main([*arguments])
    return (code, *capsys.readouterr())


def test_one_line_for_each_file(files: dict[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    good, false, short = files["good"], files["false"], files["short"]
    line = f"PROVEN  {good}  ω_B ≥ 1.09739 rad/s  3 claims\n"
    assert run(good, good, capsys=capsys) == (0, 2 * line, "")
    code, out, err = run(good, false, good, capsys=capsys)
    assert (code, out, err.count("\n")) == (4, 2 * line, 1)
    assert err.startswith(f"{false}: peak sensitivity: does not hold at ω = ")
    code, out, err = run(short, capsys=capsys)
    assert (code, out) == (6, "") and err.startswith(f"{short}: peak sensitivity: its margin is short of")


def test_the_exit_code_is_the_first_that_is_not_0(files: dict[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    codes = {"good": 0, "false": 4, "undecided": 5, "short": 6}
    for order in (("good", "short", "false"), ("false", "good", "short"), ("good", "undecided", "false"), ("good",)):
        expected = next((codes[name] for name in order if codes[name]), 0)
        assert run(*(files[name] for name in order), capsys=capsys)[0] == expected


def test_json_says_the_same_for_programs(files: dict[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run("--json", files["good"], files["false"], capsys=capsys)
    first, second = map(json.loads, out.splitlines())
    assert code == 4 and err == "" and list(first) == ["file", "exit_code", "message", "omega_b", "claims"]
    assert (first["file"], first["exit_code"], first["omega_b"]) == (files["good"], 0, "1.09739")
    assert (second["file"], second["exit_code"], len(second["claims"])) == (files["false"], 4, 4)


def test_a_name_cannot_forge_a_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a\nPROVEN  ü\t\u2028b"
    file.write_bytes(data(seal(small())))
    code, out, _ = run(str(file), capsys=capsys)
    assert code == 0 and out.startswith(f"PROVEN  {tmp_path}/a\\nPROVEN  ü\\t\\u2028b  ω_B") and out.count("\n") == 1
    file.write_bytes(b"")
    _, out, err = run(str(file), capsys=capsys)
    assert out == "" and err.startswith(f"{tmp_path}/a\\nPROVEN  ü\\t\\u2028b: file: not JSON")


@pytest.mark.parametrize("limit", ["0", "-1", "-0.5", "inf", "nan", "soon"])
def test_a_time_limit_is_a_positive_number(limit: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main([f"--time-limit={limit}", "file"])
    assert stop.value.code == 2 and "--time-limit: " in capsys.readouterr().err


def test_a_time_limit_is_obeyed(files: dict[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--time-limit=1e-9", files["good"], capsys=capsys)[0] == 5
    for limit in ("0.5", "1", "2"):
        assert run(f"--time-limit={limit}", "none", capsys=capsys)[2] == (
            "none: file: cannot be read: No such file or directory\n"
        )
    with pytest.raises(SystemExit):
        main([])


@contextmanager
def printing_to(out: Any, err: Any) -> Iterator[None]:
    """Other streams for a while; None is a closed one."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = out, err
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def test_a_stream_that_knows_ascii_only_is_written_too(files: dict[str, str]) -> None:
    out, err = io.BytesIO(), io.BytesIO()
    with printing_to(*(io.TextIOWrapper(file, encoding="ascii") for file in (out, err))):
        assert main([files["good"], files["false"]]) == 4
        assert rb"\u03c9_B \u2265 1.09739" in out.getvalue() and rb"at \u03c9 = " in err.getvalue()


@pytest.mark.parametrize("arguments", [[], ["--json"]])
def test_a_proof_that_is_not_said_is_not_0(arguments: list[str], files: dict[str, str]) -> None:
    unsaid = f"{files['good']}: standard output cannot be written\n"
    with Path("/dev/full").open("w") as full:  # what it still holds when it is closed goes nowhere
        with printing_to(full, said := io.StringIO()):
            assert main([*arguments, files["good"]]) == 2
        assert said.getvalue() == unsaid
    with printing_to(None, said := io.StringIO()):
        assert main([*arguments, files["good"]]) == 2
    assert said.getvalue() == unsaid


def test_a_fault_that_is_not_said_keeps_its_code(files: dict[str, str]) -> None:
    with printing_to(None, said := io.StringIO()):
        assert main(["--json", files["false"]]) == 4
    assert said.getvalue() == ""
    with printing_to(None, None):
        assert main([files["false"]]) == 4 and main([files["good"]]) == 2
    with printing_to(said := io.StringIO(), None):
        assert main([files["false"]]) == 4
    assert said.getvalue() == ""
