"""`filters: {force: free}` as its user meets it: said, certified, compared, refused where it is another."""

from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
from command_line import refused, robimp

from robimp.synthesis import InputError, load, pipeline, synthesize
from robimp.synthesis.check import canonical_json
from robimp.synthesis.errors import ExitCode
from robimp.synthesis.judgement import judge
from robimp.synthesis.spec import canonical, parse_spec
from robimp.synthesis.spec import free_corner as comparison
from robimp.synthesis.spec.model import Spec
from robimp.synthesis.sweep.cell import Cell, Status, Task, solve_cell

GOOD = (Path(__file__).parent / "data" / "specs" / "good.yaml").read_text(encoding="utf-8")
Json = dict[str, Any]


def text(filters: str, controller: str = "type: dynamic-feedback, form: pi") -> str:
    return GOOD.replace("type: dob, order: 4", f"{controller}, filters: {filters}")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The specification with a free filter, others like it, and what `synth` made of the first."""
    folder = tmp_path_factory.mktemp("free")
    for name, filters in {
        "free": "{force: free}",
        "given": "{force: 50}",
        "derivative": "{force: free, derivative: 900}",
    }.items():
        (folder / f"{name}.yaml").write_text(text(filters), encoding="utf-8")
    run = robimp("synth", folder / "free.yaml", "-o", folder / "out")
    assert run.code == ExitCode.PROVEN, run
    (folder / "said.txt").write_text(run.out, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def certificate(folder: Path) -> Path:
    return folder / "out" / "certificate.json"


def corner(certificate: Path) -> str:
    found: str = json.loads(certificate.read_bytes())["spec"]["controller"]["filters"]["force"]
    return found


# What is said


def test_the_corner_that_was_found_is_said_and_certified(folder: Path, certificate: Path) -> None:
    decimal = f"{float(Fraction(corner(certificate))):.6g}"
    assert f"force filter {decimal} rad/s, found with it" in (folder / "said.txt").read_text(encoding="utf-8")
    assert f"force filter at {decimal} rad/s" in (folder / "out" / "report.html").read_text(encoding="utf-8")
    digits = str(Fraction(corner(certificate)) * 10**6).rstrip("0")
    assert 1 <= len(digits) <= 6, "a number of six digits"


def test_everything_after_the_search_takes_it(folder: Path, certificate: Path) -> None:
    assert robimp("check", certificate).code == ExitCode.PROVEN
    assert robimp("simulate", certificate, "--loads", "0").code == ExitCode.PROVEN
    assert robimp("report", certificate, "-o", folder / "again.html").code == ExitCode.PROVEN
    run = robimp("bound", folder / "free.yaml", "--terms", "16", "--json")
    assert run.code == ExitCode.PROVEN and json.loads(run.out)["limited"]


# Which certificate is whose


def test_it_is_the_certificate_of_the_free_specification_and_of_its_own_corner(folder: Path, certificate: Path) -> None:
    run = robimp("check", certificate, "--spec", folder / "free.yaml")
    assert run.code == ExitCode.PROVEN and "of this specification" in run.out
    own = folder / "own.yaml"
    own.write_text(text(f"{{force: {corner(certificate)}}}"), encoding="utf-8")
    assert robimp("check", certificate, "--spec", own).code == ExitCode.PROVEN


def test_another_given_corner_and_any_other_key_are_refused_in_words(folder: Path, certificate: Path) -> None:
    said = refused(ExitCode.MISMATCH, "check", certificate, "--spec", folder / "given.yaml")
    assert "controller.filters.force" in said and "→ 50" in said
    said = refused(ExitCode.MISMATCH, "check", certificate, "--spec", folder / "derivative.yaml")
    assert "controller.filters.derivative: only in the specification" in said and "filters.force" not in said
    heavier = folder / "heavier.yaml"
    heavier.write_text(text("{force: free}").replace("damping: 0.2,", "damping: 0.21,"), encoding="utf-8")
    said = refused(ExitCode.MISMATCH, "check", certificate, "--spec", heavier)
    assert "plant.damping 0.2 → 0.21" in said and "filters.force" not in said


def test_a_comparison_that_leaves_the_corner_out_would_be_seen(
    certificate: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same judgement with a comparison that takes any corner for the one given: it accepts what has to be 6."""
    asked = canonical(parse_spec(text("{force: 50}")))
    assert judge("c", certificate.read_bytes(), asked, None, 60).exit_code is ExitCode.MISMATCH

    def careless(asked: Json, certified: Json) -> Json:
        controller = {**asked["controller"], "filters": certified["controller"]["filters"]}
        return {**asked, "controller": controller}

    monkeypatch.setattr(comparison, "as_certified", careless)
    assert judge("c", certificate.read_bytes(), asked, None, 60).exit_code is ExitCode.PROVEN


def tampered(certificate: Path, edit: Callable[[Json], object], seal: bool = True) -> bytes:
    content = json.loads(certificate.read_bytes())
    edit(content["spec"]["controller"]["filters"])
    if seal:
        content["spec_sha256"] = sha256(canonical_json(content["spec"])).hexdigest()
        body = {key: part for key, part in content.items() if key != "end"}
        content["end"]["body_sha256"] = sha256(canonical_json(body)).hexdigest()
    return json.dumps(content, ensure_ascii=False).encode()


@pytest.mark.parametrize(
    ("force", "code"),
    {"200": ExitCode.REFUTED, "1000": ExitCode.REFUTED, None: ExitCode.REFUTED, "free": ExitCode.INPUT,
     "0": ExitCode.INPUT, "-13": ExitCode.INPUT, "13.5": ExitCode.INPUT}.items(),
)  # fmt: skip
def test_a_tampered_corner_is_not_proven(force: str | None, code: ExitCode, certificate: Path) -> None:
    """Sealed again, with the free specification beside it: claims are about the corner, and it has to be a number."""
    asked = canonical(parse_spec(text("{force: free}")))
    found = judge("c", tampered(certificate, lambda filters: filters.update(force=force)), asked, None, 60)
    assert found.exit_code is (ExitCode.MISMATCH if force is None else code), found.message
    assert found.verdict.exit_code == code
    loose = tampered(certificate, lambda filters: filters.update(force=force), seal=False)
    assert judge("c", loose, asked, None, 60).exit_code is ExitCode.INPUT, "the digest does not match"


def test_a_certificate_without_the_filter_is_not_the_free_ones(certificate: Path) -> None:
    asked = canonical(parse_spec(text("{force: free}")))
    found = judge("c", tampered(certificate, lambda filters: filters.update(force=None)), asked, None, 60)
    assert "controller.filters.force: only in the specification" in found.message


# Python, orders, maps


def test_a_controller_that_is_handed_over_needs_its_corner(folder: Path) -> None:
    with pytest.raises(InputError, match="give the corner they were made for"):
        synthesize(folder / "free.yaml", controller=([2.5], [1]))


def test_each_order_finds_its_own_corner(folder: Path, tmp_path: Path) -> None:
    run = robimp("synth", folder / "free.yaml", "--orders", "0:1", "-o", tmp_path)
    assert run.code == ExitCode.PROVEN
    rows = json.loads((tmp_path / "orders.json").read_bytes())["orders"]
    assert [row["force_filter"] > 0 for row in rows] == [True, True]
    for row in rows:
        path = tmp_path / f"order-{row['order']}" / "certificate.json"
        assert float(Fraction(corner(path))) == row["force_filter"]
        assert f"force filter {row['force_filter']:.6g} rad/s" in run.out


def test_a_cell_of_a_map_keeps_its_corner_and_the_next_starts_from_it(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[Any] = []

    def spy(spec: Spec, **options: Any) -> pipeline.Result:
        seen.extend(options["starts"])
        return original(spec, **options)

    original = pipeline.synthesize
    monkeypatch.setattr(pipeline, "synthesize", spy)
    spec = load(folder / "free.yaml")
    first, written = solve_cell(Task((0, 0), spec))
    assert written is not None and first.status is Status.PROVEN and first.corner is not None
    assert seen == [] and first.corner == Fraction(json.loads(written)["spec"]["controller"]["filters"]["force"])
    kept = Cell.from_json(json.loads(json.dumps(first.to_json())))
    assert kept.corner == first.corner and kept.start is not None and kept.start.corner == first.corner
    older = {key: value for key, value in first.to_json().items() if key != "force_filter"}
    assert Cell.from_json(older).corner is None, "a journal from before is read"
    second, _ = solve_cell(Task((0, 1), spec, kept.start))
    assert (
        second.omega_B is not None and first.omega_B is not None and second.omega_B > first.omega_B * Fraction(99, 100)
    )
    ((law, omega_B),) = seen
    assert omega_B == float(first.omega_B) and len(law.denominator) == len(first.coefficients.denominator) + 1  # type: ignore[union-attr]
