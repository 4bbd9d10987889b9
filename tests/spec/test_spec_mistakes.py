"""Mistakes people make (`mistakes.yaml`): exit code 2 and one line with file, line, column, the key and a remedy."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from command_line import Run, robimp
from ruamel.yaml import YAML

DATA: dict[str, Any] = YAML(typ="safe", pure=True).load(Path(__file__).with_name("mistakes.yaml"))
MISTAKES: list[dict[str, Any]] = DATA["mistakes"]
ADVICE = re.compile(
    r"\b(write|expected|add|use|did you mean|keep|close|indent|remove|save|give|swap|put|lower|change|multiply|widen|"
    r"leave|split|sort|belongs?|writes|begins?|check|whose forms are)\b"
)


def written(mistake: dict[str, Any]) -> bytes:
    """The specification with a mistake in it, as bytes of a file."""
    text = mistake.get("text", DATA["specification"])
    for right, wrong in mistake.get("edits", []):
        assert right in text, f"nothing to get wrong: {right!r}"
        text = text.replace(right, wrong, 1)
    text = mistake.get("begin", "") + text.replace("\n", mistake.get("newline", "\n"))
    return text.encode(mistake.get("encoding", "utf-8"))


def synth(content: bytes, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    monkeypatch.chdir(folder)
    Path("joint.yaml").write_bytes(content)
    return robimp("synth", "joint.yaml")


def missing(run: Run, mistake: dict[str, Any]) -> list[str]:
    """What a user who made this mistake is not told."""
    head, found = f"robimp: joint.yaml:{mistake['at']}: ", []
    if (run.code, run.out) != (2, ""):
        found.append(f"exit code {run.code}")
    if not run.err.startswith(head) or run.err.count("\n") != 1:
        found.append(f"one line with the place {mistake['at']}")
    if mistake["key"] not in run.err:
        found.append(f"the key {mistake['key']}")
    if mistake["remedy"] not in run.err or not ADVICE.search(mistake["remedy"]):
        found.append(f"the remedy {mistake['remedy']}")
    return found


@pytest.mark.parametrize("mistake", MISTAKES, ids=[each["mistake"] for each in MISTAKES])
def test_a_mistake_is_named_with_its_place_and_what_to_write(
    mistake: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = synth(written(mistake), tmp_path, monkeypatch)
    assert missing(run, mistake) == [], run.err
    assert not (tmp_path / "out").exists(), "nothing is written for a specification that cannot be read"


def test_there_are_many_mistakes_and_nearly_all_have_a_key() -> None:
    assert len(MISTAKES) >= 60
    assert len({each["mistake"] for each in MISTAKES}) == len(MISTAKES)
    assert sum(not each["key"] for each in MISTAKES) <= 6, "a file without a key in it: empty, two documents, no UTF-8"


def test_without_a_mistake_the_specification_is_accepted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given = "  coefficients: {numerator: [2000], denominator: [1, 70.75, 2500]}\n"
    mended = written({"edits": [["  order: 4\n", given]]})
    assert synth(mended, tmp_path, monkeypatch).code == 0


def test_a_message_that_leaves_something_out_is_seen() -> None:
    mistake = {"at": "7:12", "key": "plant.damping", "remedy": "write a number above 0"}
    good = "robimp: joint.yaml:7:12: plant.damping: expected a damping > 0; write a number above 0\n"
    assert missing(Run(2, "", good), mistake) == []
    assert missing(Run(1, "", good), mistake) == ["exit code 1"]
    for part in ("7:12", "plant.damping", "write a number above 0"):
        assert len(missing(Run(2, "", good.replace(part, "")), mistake)) == 1
    assert missing(Run(2, "", good), {**mistake, "remedy": "a damping"}) == ["the remedy a damping"]
