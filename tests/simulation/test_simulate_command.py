"""`robimp simulate`: files, seeds, experiments."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))
from command_line import refused, robimp

from robimp.synthesis.errors import ExitCode

PAPER = Path(__file__).parents[1] / "data" / "golden" / "haninger2016-paper.json"


def test_writes_every_joint_and_finding_and_repeats_itself(tmp_path):
    run = robimp("simulate", PAPER, "--loads", "20", "--seed", "3", "-o", tmp_path)
    assert run.code == ExitCode.PROVEN and "20 joints drawn" in run.out and "AGREES" in run.out
    first = np.load(tmp_path / "joints.npz")
    content = json.loads((tmp_path / "simulation.json").read_text(encoding="utf-8"))
    assert first["loads"].shape == (20, 3) and not first["grew"].any()
    assert content["agrees"] and content["seed"] == 3 and content["drawn"] == 20
    assert any(finding["side"] == "outside" and finding["agrees"] for finding in content["findings"])
    robimp("simulate", PAPER, "--loads", "20", "--seed", "3", "-o", tmp_path / "again")
    second = np.load(tmp_path / "again" / "joints.npz")
    assert all((first[name] == second[name]).all() for name in first.files)


def test_repeats_an_experiment_of_the_paper(tmp_path):
    run = robimp("simulate", PAPER, "--experiment", "fig9", "-o", tmp_path)
    assert run.code == ExitCode.PROVEN and run.out.count("reproduced") == 4
    assert len(json.loads((tmp_path / "fig9.json").read_text(encoding="utf-8"))["curves"]) == 3


@pytest.mark.parametrize(
    ("arguments", "reason"), [(("--experiment", "fig13"), "expected one of fig9"), (("--loads", "-1"), "--loads")]
)
def test_refuses_what_it_does_not_know(arguments, reason):
    assert reason in refused(ExitCode.INPUT, "simulate", PAPER, *arguments)


def test_a_folder_that_cannot_be_written_is_refused_before_anything_runs(tmp_path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert "is not a folder" in refused(ExitCode.INPUT, "simulate", PAPER, "-o", tmp_path / "file" / "inside")
