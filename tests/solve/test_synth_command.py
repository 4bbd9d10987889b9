"""`robimp synth`: the seed reaches the search, and the checker's verdict the report."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from robimp.synthesis.errors import ExitCode

sys.path.insert(0, str(Path(__file__).parents[1]))
from command_line import refused, robimp

EXAMPLES = Path(__file__).parents[2] / "examples"
SPECS = Path(__file__).parents[1] / "data" / "golden" / "specs"
bound, search, study = (
    import_module(f"robimp.synthesis.{m}") for m in ("solve.bound", "solve.search", "report.html.study")
)


@pytest.mark.parametrize(("option", "seed"), [((), 0), (("--seed", "7"), 7)])
def test_the_seed_reaches_the_search(
    option: tuple[str, ...], seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []
    monkeypatch.setattr(bound, "bound", lambda *a, **k: None)
    monkeypatch.setattr(search.Search, "run", lambda self: seen.append(self.seed))
    refused(ExitCode.UNDECIDED, "synth", EXAMPLES / "haninger2016-eq23.yaml", "-o", tmp_path, *option)
    assert seen == [seed, seed], "the short search's, too"


@pytest.mark.parametrize("seed", ["-1", "one", "1.5"])
def test_a_seed_is_a_number(seed: str, tmp_path: Path) -> None:
    assert robimp("synth", EXAMPLES / "haninger2016-eq23.yaml", "-o", tmp_path, "--seed", seed).code == ExitCode.INPUT


def test_a_bound_the_solver_fails_at_does_not_stop_the_search(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    monkeypatch.setattr(bound.BandProgram, "largest_band", lambda *a, **k: bound.Failure.UNSOLVED)
    monkeypatch.setattr(search.Search, "run", lambda self: asked.append(self.ideal))
    refused(ExitCode.UNDECIDED, "synth", EXAMPLES / "haninger2016-eq23.yaml", "-o", tmp_path)
    assert asked == [None], "it begins without the bound's response"
    line = refused(ExitCode.UNDECIDED, "bound", EXAMPLES / "haninger2016-eq23.yaml")
    assert "no bound" in line and "vouches" in line


def test_a_search_that_finds_less_than_asked_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    genuine = search.Search._best
    monkeypatch.setattr(bound, "bound", lambda *a, **k: None)
    monkeypatch.setattr(
        search.Search, "_best", lambda self, p, o: None if p.structure.order == 3 else genuine(self, p, o)
    )
    spec = tmp_path / "three.yaml"
    text = (EXAMPLES / "haninger2016.yaml").read_text(encoding="utf-8")
    spec.write_text(text.replace("order: 4", "order: 3"), encoding="utf-8")
    said = robimp("synth", spec, "-o", tmp_path / "out").out
    assert "note: order 3 was asked for" in said and "this controller has order 2" in said
    assert "note: no bound to compare with" in said
    assert "note: order" not in robimp("synth", EXAMPLES / "haninger2016-eq23.yaml", "-o", tmp_path / "eq23").out


def test_what_is_stated_for_an_ideal_actuator_is_not_taken_for_the_joint(tmp_path: Path) -> None:
    """With half the torque the loop is stable, behind an ideal actuator it is not; (12) as printed speaks of that."""
    given = (SPECS / "unstable-behind-ideal.yaml").read_text(encoding="utf-8")
    speaks = "note: (9) speaks of an ideal actuator, behind which this controller is not stable"
    printed = "note: (12) as printed speaks of an ideal actuator"
    for changes, code, notes in (
        ((), ExitCode.REFUTED, (speaks,)),
        ((("-10, 80", "80"), ("-1, 100", "20, 100")), ExitCode.PROVEN, ()),
        ((("eq9: {}", "eq12: {form: paper, band: [1, 2]}"), ("-1, 100", "1, 100")), ExitCode.PROVEN, (printed,)),
    ):
        text = given
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        spec = tmp_path / "spec.yaml"
        spec.write_text(text, encoding="utf-8")
        run = robimp("synth", spec, "-o", tmp_path / str(code.value))
        said = " ".join(run.out.split())
        assert run.code == code and [note for note in (speaks, printed) if note in said] == list(notes)


def test_the_report_is_about_the_bytes_that_were_checked_and_they_are_checked_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recheck, checked = import_module("robimp.synthesis.recheck"), []
    genuine = recheck.check_bytes

    def check_bytes(data: bytes, **limits: Any) -> Any:
        checked.append(data)
        return genuine(data, **limits)

    monkeypatch.setattr(recheck, "check_bytes", check_bytes)
    monkeypatch.setattr(study, "check_bytes", check_bytes)
    assert robimp("synth", EXAMPLES / "haninger2016-paper.yaml", "-o", tmp_path).code == ExitCode.PROVEN
    assert checked == [(tmp_path / "certificate.json").read_bytes()]
    assert robimp("report", tmp_path / "certificate.json").code == ExitCode.PROVEN
    assert len(checked) == 2, "a report by itself trusts nobody"
