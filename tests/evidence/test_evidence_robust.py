"""Edited and sealed certificates, arbitrary bytes, and joints written otherwise: small sizes of the full runs."""

from __future__ import annotations

import argparse
import ast
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import fuzzing
import metamorphic
import mutation
import pytest
import resealed
from mutants import Mutant, mutants, transplant

from robimp.synthesis.check import check_bytes
from robimp.synthesis.check.polynomials import product


def test_certificates_edited_and_sealed_again() -> None:
    found = resealed.examine(range(resealed.SMALL))
    assert found.faults == []
    assert found.counts["with the specification: exit code 6"] > 5


def test_an_edit_of_the_specification_never_passes_with_it() -> None:
    told = [resealed.edited(seed) for seed in range(400)]
    changed = [(what, after, before) for what, before, after in told if after["spec"] != before["spec"]]
    assert len(changed) > 50
    passed = sum(check_bytes(resealed.written(after)).exit_code == 0 for _, after, _ in changed[:60])
    assert passed > 0, "control: none is true of another joint, then --spec is not needed"


def test_readers_answer_whatever_the_bytes() -> None:
    found = fuzzing.examine(range(fuzzing.SMALL))
    assert found.faults == []
    assert found.counts["YAML: read"] > 5 and found.counts["JSON, sealed again: exit code 2"] > 5


def test_the_fuzz_notices_another_exception(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(fuzzing, "parse_spec", broken)
    assert any("ZeroDivisionError" in fault for fault in fuzzing.examine(range(8)).faults)


def test_joints_written_otherwise() -> None:
    found = metamorphic.examine(range(metamorphic.SMALL))
    assert found.faults == []
    assert found.counts["margins compared"] > 20 and found.counts["bigger weights"] > 0


def test_the_mutator_changes_one_thing_at_a_time(tmp_path: Path) -> None:
    file = tmp_path / "small.py"
    file.write_text("def f(a, b):\n    if a < b and not b:\n        demand(a)\n    return min(a, b) + 1\n")
    found = {(m.line, m.change) for m in mutants(file)}
    assert found >= {(2, "Lt to LtE"), (2, "And to Or"), (2, "not removed"), (2, "condition to True"), (3, "removed")}
    assert found >= {(4, "min to max"), (4, "Add to Sub"), (4, "1 to 2"), (4, "returns None")}
    sources = [m.source for m in mutants(file)]
    assert len(set(sources)) == len(sources)
    assert all(ast.parse(source) for source in sources)


def test_a_mutant_takes_the_place_of_the_checker_in_its_own_process_only() -> None:
    """Roots counted to the left that are not: the corpus's tests would say so at once."""
    file = mutation.CHECK / "polynomials.py"
    wrong = next(m for m in mutants(file) if m.place == "decays_faster" and m.change == "LtE to Gt")
    golden = (mutation.ROOT / "tests/data/golden/haninger2016-paper.json").read_bytes()

    def exit_code(mutant: Mutant | None) -> int:
        if mutant:
            transplant(mutant)
        return check_bytes(golden).exit_code

    answers = [code for _, code in mutation.in_forks([wrong, None], exit_code, 1, float("inf"))]
    assert answers[0] != answers[1] == exit_code(None) == 0


def test_every_mutant_has_a_name_of_its_own() -> None:
    for file in mutation.CHECK.rglob("*.py"):
        keys = [mutant.key for mutant in mutants(file, mutation.CHECK)]
        assert len(set(keys)) == len(keys)
    assert any("#2" in mutant.change for mutant in mutants(mutation.CHECK / "reader.py", mutation.CHECK))


@pytest.mark.parametrize(
    ("file", "text", "said"),
    [
        ("polynomials.py", "WORK_LIMIT = ", "NameError"),
        ("polynomials.py", "PRIME = ", "ImportError"),
        ("outcome.py", "UNREADABLE = ", "NameError"),
    ],
)
def test_an_assignment_that_is_removed_is_missed(file: str, text: str, said: str) -> None:
    """By what uses it, in its own file when it runs, or by another file's import."""
    gone = next(
        m for m in mutants(mutation.CHECK / file, mutation.CHECK) if m.change == "removed" and m.text.startswith(text)
    )

    def without(mutant: Mutant) -> str:
        try:
            transplant(mutant)
            product([1], [1])
        except (NameError, ImportError) as missed:
            return type(missed).__name__
        return "not missed"

    assert [answer for _, answer in mutation.in_forks([gone], without, 1, float("inf"))] == [said]


def test_a_process_that_dies_is_a_mutant_noticed() -> None:
    answers = mutation.in_forks([0, 1], lambda n: os.kill(os.getpid(), 9) if n else n, 2, float("inf"))
    assert sorted(map(str, dict(answers).values())) == ["0", "None"]


CLOCK = """
import time

import pytest

from robimp.synthesis.check.outcome import UNDECIDED, CheckError, tick


def test_the_clock():
    tick(time.monotonic() + 60)
    with pytest.raises(CheckError, match="time limit") as late:
        tick(0.0)
    assert late.value.code == UNDECIDED
"""


def mutated(tests: str, tmp_path: Path) -> subprocess.CompletedProcess[str]:
    """`mutation.py` over the checker's smallest module with these tests."""
    file, record = tmp_path / "test_clock.py", tmp_path / "tried.jsonl"
    file.write_text(tests, encoding="utf-8")
    command = [sys.executable, mutation.__file__, "--module", "outcome.py", "--tests", file, "--record", record]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, cwd=tmp_path)


def test_mutants_are_tried_by_the_tests_that_enter_them(tmp_path: Path) -> None:
    done = mutated(CLOCK, tmp_path)
    lines = [json.loads(line) for line in (tmp_path / "tried.jsonl").read_text(encoding="utf-8").splitlines()]
    by = {key: said for _, _, key, said in lines}
    comparison = next(said for key, said in by.items() if "tick" in key and "LtE to Gt" in key)
    assert comparison.endswith("test_the_clock"), "the test that failed"
    assert "survived" in by.values() and done.returncode == 1, "nobody asks for the other exit codes"
    counted = sum(int(n) for n in re.findall(r"(\d+) survived", done.stdout))  # explained or not
    assert counted == sum(said == "survived" for said in by.values())


def test_only_what_another_test_can_change_is_tried_again(tmp_path: Path) -> None:
    names = ["test_one.py", "test_other.py", "builder.py"]
    files = [tmp_path / name for name in names]
    given = argparse.Namespace(tests=[tmp_path], record=tmp_path / "tried.jsonl", slowest=1.0)
    by = {"outcome.py": "tests/check/test_one.py::test", "reader.py": mutation.SURVIVED, "joint.py": mutation.ENDED}

    def still_known() -> set[str]:
        return {key.split("`")[1] for key in mutation.Mutation(given).recorded()}

    def written(one: str, other: str, builder: str) -> None:
        for file, content in zip(files, (one, other, builder), strict=True):
            file.write_text(content, encoding="utf-8")

    written("", "", "")
    for file, said in by.items():
        mutation.Mutation(given).note(Mutant(file, 1, "place", "text", "change", ""), said)
    assert still_known() == set(by)
    written("", "another test", "")
    assert still_known() == {"outcome.py"}, "the test that noticed is the same"
    written("", "", "what they use")
    assert still_known() == set()
    written("", "", "")
    given.slowest = 2.0
    assert still_known() == {"outcome.py"}, "slower tests are asked, too"


def test_mutants_are_not_tried_by_tests_that_fail_without_them(tmp_path: Path) -> None:
    done = mutated(CLOCK.replace("== UNDECIDED", "!= UNDECIDED"), tmp_path)
    assert done.returncode != 0 and "fails without any change" in done.stdout + done.stderr
    assert not (tmp_path / "tried.jsonl").exists()


def test_a_piece_of_work_that_fails_is_no_answer(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(RuntimeError, match="not tried"):
        list(mutation.in_forks([0], lambda n: 1 // n, 1, float("inf")))
    assert "ZeroDivisionError" in capfd.readouterr().err
