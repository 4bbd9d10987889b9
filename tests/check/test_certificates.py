"""Damaged, weakened and edited certificates: the right exit code, one line that names the place."""

from __future__ import annotations

import copy
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from certificate_builder import EQ23, canonical, certificate, claim, data, dob, find, seal, spec, text
from claim_floats import Json, num

from robimp.synthesis.check import canonical_json, check_bytes, check_file
from robimp.synthesis.check.__main__ import main

REFERENCE = certificate(spec(), EQ23)
TEXT = data(REFERENCE).decode()


def replaced(old: str, new: str) -> Callable[[], bytes]:
    assert old in TEXT
    return lambda: TEXT.replace(old, new, 1).encode()


def edited(edit: Callable[[Json], object]) -> Callable[[], bytes]:
    def build() -> bytes:
        cert = copy.deepcopy(REFERENCE)
        edit(cert)
        return data(seal(cert))

    return build


def entry(kind: str, **changes: object) -> Callable[[], bytes]:
    return edited(lambda cert: find(cert, kind).update(changes))


def in_spec(*path: str, value: object) -> Callable[[], bytes]:
    def edit(cert: Json) -> None:
        place = cert["spec"]
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = value

    return edited(edit)


UNREADABLE: dict[str, tuple[Callable[[], bytes], str]] = {
    "empty": (lambda: b"", "not JSON"),
    "not UTF-8": (lambda: b"\xff" + TEXT.encode(), "UTF-8"),
    "truncated": (lambda: TEXT.encode()[:-40], "not JSON"),
    "end record missing": (
        lambda: data({k: v for k, v in REFERENCE.items() if k != "end"}),
        "certificate.end: missing",
    ),
    "garbage after": (lambda: TEXT.encode() + b"x", "Extra data"),
    "not an object": (lambda: b"[]", "expected dict"),
    "duplicate key": (replaced('"bound": null', '"bound": null, "bound": null'), "duplicate key 'bound'"),
    "float": (replaced('"bound": null', '"bound": 1.5'), "bare number"),
    "exponent": (replaced('"bound": null', '"bound": 1e3'), "bare number"),
    "NaN": (replaced('"bound": null', '"bound": NaN'), "bare number"),
    "Infinity": (replaced('"bound": null', '"bound": -Infinity'), "bare number"),
    "huge integer": (replaced('"bound": null', '"bound": ' + "9" * 5000), "bare number"),
    "integer": (replaced('"bound": null', '"bound": 7'), "bandwidth.bound: expected str"),
    "true for 1": (replaced('"robimp_certificate": 1', '"robimp_certificate": true'), "robimp_certificate"),
    "other version": (replaced('"robimp_certificate": 1', '"robimp_certificate": 2'), "robimp_certificate"),
    "deep": (lambda: b"[" * 100_000, "nested"),
    "string without end": (lambda: b'"' + rb"\"" * 500_000, "not JSON"),  # looked through once, not once for each quote
    "large": (lambda: b" " * 4_000_001, "more than"),
    "flipped digit": (replaced('"283/4"', '"281/4"'), "digest"),
    "flipped digest": (lambda: data({**REFERENCE, "spec_sha256": "0" * 64}), "digest"),
    "claim count": (lambda: data({**REFERENCE, "end": {**REFERENCE["end"], "claims": 7}}), "end.claims"),
    "unknown field": (edited(lambda c: c.update(note="")), "unknown field 'note'"),
    "unknown claim field": (entry("eq9", proof="trust me"), "unknown field 'proof'"),
    "missing claim field": (edited(lambda c: find(c, "eq9").pop("hints")), "hints: missing"),
    "not lowest": (in_spec("plant", "damping", value="2/10"), "not in lowest terms"),
    "denominator one": (in_spec("plant", "damping", value="1/1"), "not in lowest terms"),
    "zero denominator": (in_spec("plant", "damping", value="1/0"), "not a canonical number"),
    "minus zero": (in_spec("plant", "damping", value="-0"), "not in lowest terms"),
    "plus": (in_spec("plant", "damping", value="+1"), "not a canonical number"),
    "leading zero": (in_spec("plant", "damping", value="01"), "not a canonical number"),
    "space": (in_spec("plant", "damping", value="1 "), "not a canonical number"),
    "newline": (in_spec("plant", "damping", value="1\n"), "not a canonical number"),
    "other digits": (in_spec("plant", "damping", value="١"), "not a canonical number"),
    "decimal": (in_spec("plant", "damping", value="0.2"), "not a canonical number"),
    "many digits": (in_spec("plant", "damping", value="1" * 2001), "more than 2000 digits"),
    "negative inertia": (in_spec("plant", "inertia", value="-1"), "spec.plant.inertia: must be positive"),
    "negative damping": (in_spec("impedance", "damping", value="-1"), "impedance.damping: must not be negative"),
    "box off nominal": (in_spec("uncertainty", "box", "inertia", value=["1", "2"]), "nominal"),
    "box reversed": (in_spec("uncertainty", "box", "inertia", value=["2", "1"]), "[low, high]"),
    "no actuator": (in_spec("actuator", value={"type": "hydraulic"}), "actuator.type"),
    "zero polynomial": (
        edited(lambda c: c["controller"]["C"].update(denominator=["0", "0"])),
        "controller.C.denominator: zero denominator",
    ),
    "no coefficients": (edited(lambda c: c["controller"]["C"].update(denominator=[])), "1 to 101 coefficients"),
    "degree": (edited(lambda c: c["controller"]["C"].update(denominator=["1"] * 102)), "1 to 101 coefficients"),
    "Q = 1": (edited(lambda c: c["controller"]["Q"].update(numerator=["1"], denominator=["1"])), "not 1"),
    "unstable weight": (
        in_spec("uncertainty", "weight", value={"numerator": ["1"], "denominator": ["1", "-1"]}),
        "stable and proper",
    ),
    "improper weight": (
        in_spec("uncertainty", "weight", value={"numerator": ["1", "0"], "denominator": ["1"]}),
        "stable and proper",
    ),
    "unknown claim": (entry("eq9", id="eq99"), "eq99 printed: no such claim"),
    "unknown form": (entry("eq18", form="half-plane/imagined"), "no such claim"),
    "claim twice": (edited(lambda c: c["claims"].append(find(c, "eq9"))), "appears twice"),
    "65 claims": (edited(lambda c: c["claims"].extend([find(c, "eq9")] * 58)), "more than 64"),
    "proven, no margin": (entry("eq9", margin=None), "margin does not fit"),
    "refuted, no witness": (entry("eq9", status="refuted", margin=None), "refuted_at does not fit"),
    "reversed interval": (entry("eq12", interval=["2", "1"]), "[low, high]"),
    "surrogate": (entry("eq9", id="\ud800"), "no such claim"),
}


@pytest.mark.parametrize("name", UNREADABLE)
def test_unusable_input_is_2_and_names_the_place(name: str) -> None:
    build, expected = UNREADABLE[name]
    verdict = check_bytes(build())
    assert verdict.exit_code == 2 and expected in verdict.message and "\n" not in verdict.message


def without(kind: str) -> Callable[[], bytes]:
    return edited(lambda c: c["claims"].remove(find(c, kind)))


COEFFICIENTS = {"numerator": ["2000"], "denominator": ["1", "70", "2500"]}
MISMATCHED: dict[str, tuple[Callable[[], bytes], str]] = {
    **{f"{kind} removed": (without(kind), "missing") for kind in sorted({c["id"] for c in REFERENCE["claims"]})},
    "box removed": (edited(lambda c: c["claims"].remove(find(c, "stability-free", "box"))), "missing"),
    "flag cleared": (entry("eq9", required=False), "`required`"),
    "flag set": (
        edited(lambda c: c["claims"].append(claim("friction", "strictly-positive-real", ["0", "inf"], "1", True))),
        "`required`",
    ),
    "form exchanged": (entry("eq12", form="disc"), "`required`"),
    "interval narrowed": (entry("eq9", interval=["1", "inf"]), "interval"),
    "passivity on a band": (entry("eq12", interval=["0", "100"]), "interval"),
    "factor below 1": (entry("eq9", margin="999/1000"), "short of"),
    "peak above the limit": (entry("peak", margin="3"), "short of"),
    "passivity margin short": (in_spec("constraints", "eq12", "margin", value="1"), "short of"),
    "bandwidth margin": (entry("bandwidth", margin="1"), "bandwidth.proven"),
    "C is not Q/(1-Q)": (edited(lambda c: c["controller"]["C"].update(numerator=["2001"])), "Q/(1-Q)"),
    "C with leading zero": (
        edited(lambda c: c["controller"]["C"].update(denominator=["0", *c["controller"]["C"]["denominator"]])),
        "Q/(1-Q)",
    ),
    "C cancelled": (in_spec("controller", "type", value="dynamic-feedback"), "controller.type"),
    "given controller": (in_spec("controller", "coefficients", value=COEFFICIENTS), "the specification gives"),
    "order": (in_spec("controller", "order", value=1), "order"),
    "undefined form": (in_spec("uncertainty", "weight", value={"numerator": ["1/9"], "denominator": ["1"]}), ""),
}


@pytest.mark.parametrize("name", sorted(MISMATCHED))
def test_what_the_specification_does_not_ask_for_is_6(name: str) -> None:
    build, expected = MISMATCHED[name]
    verdict = check_bytes(build())
    if name == "undefined form":
        assert verdict.exit_code == 4  # structured passivity up to infinity cannot hold with a constant weight
    else:
        assert verdict.exit_code == 6 and expected in verdict.message and "\n" not in verdict.message


def test_the_given_controller_is_recognised_up_to_a_factor() -> None:
    doubled = {"numerator": ["4000"], "denominator": ["2", "283/2", "5000"]}
    assert check_bytes(in_spec("controller", "coefficients", value=doubled)()).exit_code == 0
    assert check_bytes(in_spec("controller", "form", value="eq23")()).exit_code == 0


SHAPES = {  # degree of the numerator at most; of the denominator at least and at most; whether it has a pole at 0
    "p": (0, 0, 0, False),
    "pi": (1, 1, 1, True),
    "lead-lag": (1, 0, 1, False),
    "pi-lead": (2, 1, 2, True),
    "p-filtered": (0, 1, 1, False),
    "pi-filtered": (1, 2, 2, True),
    "lead-lag-filtered": (1, 1, 2, False),
    "pi-lead-filtered": (2, 2, 3, True),
}


def said_of(form: str, type: str, zeros: int, poles: int, at_zero: bool) -> str:
    """The checker's message for a controller with so many zeros and poles, of which one may be 0."""
    given = {"numerator": ["2"] * (zeros + 1), "denominator": ["3"] * poles + ["0" if at_zero and poles else "3"]}
    cert = copy.deepcopy(REFERENCE)
    cert["spec"]["controller"].update(type=type, form=form, coefficients=None)
    cert["controller"] = {"type": type, "C": given} if type != "dob" else dob(given["numerator"], given["denominator"])
    return check_bytes(data(seal(cert))).message


@pytest.mark.parametrize("form", SHAPES)
def test_a_controller_is_of_the_form_the_specification_names(form: str) -> None:
    zeros, least, most, integral = SHAPES[form]
    wrong = f"controller.C: is not of the form {form}"
    for fits in ((zeros, most), (zeros, least)):
        assert wrong not in said_of(form, "dynamic-feedback", *fits, integral)
    for outside in ((zeros + 1, most), (zeros, most + 1), *([(zeros, least - 1)] if least else [])):
        assert wrong in said_of(form, "dynamic-feedback", *outside, integral), outside
    if integral:
        assert wrong in said_of(form, "dynamic-feedback", zeros, most, False)


def test_q_of_form_23_has_two_poles_and_no_zero() -> None:
    wrong = "controller.Q: is not of the form eq23"
    assert wrong not in said_of("eq23", "dob", 0, 2, False)
    assert all(wrong in said_of("eq23", "dob", *shape, False) for shape in ((1, 2), (0, 1), (0, 3)))


def raised(kind: str, factor: float) -> Callable[[], bytes]:
    return entry(kind, margin=text(num(find(REFERENCE, kind)["margin"]) * factor, 9))


def wider_bandwidth(cert: Json) -> None:
    proven = text(num(cert["bandwidth"]["proven"]) * 1.001, 6)
    cert["bandwidth"]["proven"] = proven
    find(cert, "bandwidth").update(margin=proven, interval=["0", proven])


FALSE: dict[str, Callable[[], bytes]] = {
    **{f"{kind} raised": raised(kind, 1.01) for kind in ("eq9", "eq12", "eq18")},
    "stability-free raised": raised("stability-free", 100),
    "stability-locked raised": raised("stability-locked", 100),
    "peak lowered": raised("peak", 0.99),
    "bandwidth raised": edited(wider_bandwidth),
    "controller digit": edited(lambda c: c.update(controller=dob(["2900"], ["1", "283/4", "2500"]))),
    "negative peak": entry("peak", margin="-2"),
    "negative factor": edited(lambda c: c["claims"].append(claim("eq12", "paper", ["1", "2"], "-9", False))),
    "friction at zero": edited(
        lambda c: c["claims"].append(claim("friction", "strictly-positive-real", ["0", "inf"], "0", False))
    ),
    "bandwidth twin": edited(lambda c: c["bandwidth"].update(refuted_at="9")),
    "wider box": in_spec("uncertainty", "box", "damping", value=["1/100", "1"]),
}


@pytest.mark.parametrize("name", sorted(FALSE))
def test_a_false_claim_is_4_and_named(name: str) -> None:
    verdict = check_bytes(FALSE[name]())
    assert verdict.exit_code == 4 and verdict.omega_b is None and "\n" not in verdict.message


def twin(kind: str, value: str, omega: str | None, load: Json = None, **more: object) -> Callable[[], bytes]:
    return entry(kind, refuted_at={"value": value, "omega": omega, "load": load}, **more)


HEAVY = {"inertia": "9/250", "damping": "3/25", "stiffness": "0"}
TWINS: list[tuple[str, Callable[[], bytes], int]] = [
    ("hurwitz", twin("stability-free", "100", None), 0),
    ("hurwitz false", twin("stability-free", "1", None), 4),
    ("hurwitz with omega", twin("stability-free", "100", "1"), 4),
    ("at zero", twin("eq9", "3/2", "0"), 0),
    ("at zero, one load", twin("eq9", "3/2", "0", HEAVY), 0),
    ("at zero, false", twin("eq9", "7/5", "0"), 4),
    ("at infinity", twin("peak", "1", "inf", margin="8/5"), 4),
    ("at infinity, fails", twin("peak", "99/100", "inf", margin="8/5"), 0),
    ("load outside", twin("eq9", "3/2", "0", {**HEAVY, "damping": "1/10"}), 4),
    ("negative value", twin("eq9", "-1", "0"), 4),
    ("outside the interval", twin("eq12", "1", "inf"), 0),
    ("no witness frequency", twin("eq12", "1", None), 4),
]


@pytest.mark.parametrize(("name", "build", "code"), TWINS, ids=[t[0] for t in TWINS])
def test_a_witness_is_evaluated_not_believed(name: str, build: Callable[[], bytes], code: int) -> None:
    assert check_bytes(build()).exit_code == code


def test_bandwidth_twin_is_the_witness_itself() -> None:
    def build(omega: str) -> int:
        cert = copy.deepcopy(REFERENCE)
        cert["bandwidth"]["refuted_at"] = "9"
        find(cert, "bandwidth")["refuted_at"] = {"value": "9", "omega": omega, "load": None}
        return check_bytes(data(seal(cert))).exit_code

    assert build("9") == 0 and build("10") == 4


def test_required_and_refuted_is_4_not_required_and_refuted_is_0() -> None:
    tight = spec(constraints={"peak": "3/2"})  # the true peak is 1.52 near 61 rad/s
    cert = copy.deepcopy(REFERENCE)
    cert["spec"] = tight
    witness = {"value": "3/2", "omega": "60", "load": None}
    find(cert, "peak").update(status="refuted", margin=None, refuted_at=witness)
    verdict = check_bytes(data(seal(cert)))
    assert verdict.exit_code == 4 and "required, and refuted at ω = 60" in verdict.message
    cert["spec"]["constraints"]["peak"] = None
    find(cert, "peak")["required"] = False
    assert check_bytes(data(seal(cert))).exit_code == 0
    find(cert, "peak")["refuted_at"]["omega"] = "1"
    assert check_bytes(data(seal(cert))).exit_code == 4


def test_undecided_is_5_if_required_and_said_if_not() -> None:
    assert check_bytes(entry("eq9", status="undecided", margin=None)()).exit_code == 5
    optional = claim("eq12", "disc", ["1", "2"], None, False, status="undecided")
    verdict = check_bytes(edited(lambda c: c["claims"].append(optional))())
    assert verdict.exit_code == 0 and "8 claims" in verdict.message and verdict.claims[-1][2] == "undecided"


def test_the_interpreters_own_digit_limit_is_respected() -> None:
    long = in_spec("constraints", "peak", value="2" + "0" * 999)()
    assert check_bytes(long).exit_code == 0
    before = sys.get_int_max_str_digits()
    sys.set_int_max_str_digits(640)
    try:
        verdict = check_bytes(long)
    finally:
        sys.set_int_max_str_digits(before)
    assert verdict.exit_code == 2 and "more digits than this Python accepts" in verdict.message


def test_a_time_limit_is_5() -> None:
    verdict = check_bytes(data(REFERENCE), time_limit=1e-9)
    assert verdict.exit_code == 5 and "time limit" in verdict.message


def test_one_way_to_say_success(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    good.write_bytes(data(REFERENCE))
    bad.write_bytes(raised("eq9", 1.01)())
    assert main([str(good)]) == 0
    out, err = capsys.readouterr()
    assert out == f"PROVEN  {good}  ω_B ≥ {check_file(good).omega_b} rad/s  8 claims\n" and err == ""
    assert main([str(good), str(bad)]) == 4
    out, err = capsys.readouterr()
    assert out.count("PROVEN") == 1 and err.startswith(f"{bad}: eq9 printed: ") and err.count("\n") == 1
    assert main(["--json", str(bad)]) == 4
    assert json.loads(capsys.readouterr().out)["exit_code"] == 4
    assert main([str(tmp_path / "none.json")]) == 2 and main([str(tmp_path)]) == 2
    assert capsys.readouterr().out == ""


def test_the_package_is_its_own_main_function_and_its_modules_can_be_imported(tmp_path: Path) -> None:
    import robimp.synthesis.check.reader as reader
    from robimp.synthesis import check

    file = tmp_path / "certificate.json"
    file.write_bytes(data(REFERENCE))
    assert check(file) == check_file(file) and check(file, time_limit=1e-9).exit_code == 5
    assert reader.canonical_json is canonical_json and sys.modules["robimp.synthesis.check"] is check


@pytest.mark.parametrize("arguments", [(), ("--json",)])
def test_a_proof_that_cannot_be_said_is_not_0(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    folder = Path(__file__).parents[2] / "synthesis" / "check"
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    good.write_bytes(data(REFERENCE))
    bad.write_bytes(raised("eq9", 1.01)())
    command = [sys.executable, "-I", "-S", folder, *arguments]
    with Path("/dev/full").open("w") as full:
        run = subprocess.run([*command, good], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        assert run.returncode == 2 and run.stderr == f"{good}: standard output cannot be written\n"
        assert subprocess.run([*command, good], stdout=full, stderr=full, check=False).returncode == 2
        assert subprocess.run([*command, bad], stdout=full, stderr=full, check=False).returncode == 4


def test_it_runs_alone_with_the_standard_library_only(tmp_path: Path) -> None:
    folder = Path(__file__).parents[2] / "synthesis" / "check"
    file = tmp_path / "certificate.json"
    file.write_bytes(data(REFERENCE))
    run = subprocess.run([sys.executable, "-I", "-S", folder, file], capture_output=True, text=True, check=False)
    assert run.returncode == 0 and run.stdout.startswith("PROVEN  ") and run.stderr == ""
    for module in folder.rglob("*.py"):
        for line in module.read_text().splitlines():
            if line.startswith(("import ", "from ")) and not line.startswith("from ."):
                name = line.split()[1].split(".")[0]
                assert name in sys.stdlib_module_names


def test_canonical_json_is_the_bytes_of_the_digest() -> None:
    assert canonical_json({"b": "é", "a": [1, None, True]}) == b'{"a":[1,null,true],"b":"\\u00e9"}'
    assert canonical_json(REFERENCE) == canonical(REFERENCE)
