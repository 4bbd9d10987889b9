"""`robimp simulate`: files, seeds, experiments."""

import json
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from certified import golden

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "evidence"))
from command_line import refused, robimp
from tampering import sealed, written

from robimp.synthesis.errors import ExitCode, InputError
from robimp.synthesis.simulation.adversary.population import Reality, population

PAPER = Path(__file__).parents[1] / "data" / "golden" / "haninger2016-paper.json"


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """One run, and where it wrote."""
    folder = tmp_path_factory.mktemp("first")
    return robimp("simulate", PAPER, "--loads", "20", "--seed", "3", "-o", folder), folder


def test_writes_every_joint_and_finding(first):
    run, folder = first
    assert run.code == ExitCode.PROVEN and "20 joints drawn" in run.out and "AGREES" in run.out
    joints = np.load(folder / "joints.npz")
    content = json.loads((folder / "simulation.json").read_text(encoding="utf-8"))
    assert joints["loads"].shape == (20, 3) and not joints["grew"].any()
    assert content["agrees"] and content["seed"] == 3 and content["drawn"] == 20
    assert any(finding["side"] == "outside" and finding["agrees"] for finding in content["findings"])


def test_every_bound_stands_beside_what_was_simulated(first):
    rows = {line[:24].strip(): line.split()[-1] for line in first[0].out.splitlines() if line.endswith("%")}
    assert {"peak sensitivity", "eq12 structured", "stability-free box"} <= set(rows)
    assert all(float(share.rstrip("%")) > 95 for share in rows.values())


def test_repeats_itself_and_says_what_the_certificate_leaves_out_for_information(first, tmp_path):
    faults = ("--friction-load", "0.05", "--stiction", "1.5", "--encoder", "1e-4", "--noise", "0.01", "--rate", "1000")
    run = robimp("simulate", PAPER, "--loads", "20", "--seed", "3", *faults, "-o", tmp_path, "--json")
    assert run.code == ExitCode.PROVEN
    content = json.loads(run.out, parse_constant=pytest.fail)
    extra = [finding for finding in content["findings"] if finding["claim"] == "not certified"]
    assert {(finding["side"], finding["agrees"]) for finding in extra} == {("information", None)}
    assert all("load friction 0.05" in finding["what"] and "1000 Hz" in finding["what"] for finding in extra)
    before, joints = np.load(first[1] / "joints.npz"), np.load(tmp_path / "joints.npz")
    assert all((before[name] == joints[name]).all() for name in before.files)
    assert (joints["real_loads"] == joints["loads"]).all()
    assert (joints["real_largest_angle"] < joints["largest_angle"]).all(), "friction brakes"


def resealed(folder, edit):
    """The certificate with a claim edited, and digests that match again."""
    content = json.loads(PAPER.read_bytes())
    edit({(claim["id"], claim["form"]): claim for claim in content["claims"]})
    file = folder / "resealed.json"
    file.write_bytes(written(sealed(content)))
    return file


def test_what_is_written_is_compared_not_what_a_prover_would_find(tmp_path):
    def weaker(claims):
        claims["stability-free", "box"]["margin"], claims["peak", "sensitivity"]["margin"] = "2", "19/10"

    run = robimp("simulate", resealed(tmp_path, weaker), "--loads", "4")
    rows = {line[:24].strip(): line.split()[-3:] for line in run.out.splitlines() if line.endswith("%")}
    assert run.code == ExitCode.PROVEN, "weaker than the truth is true"
    assert rows["peak sensitivity"][0] == "1.9" and float(rows["peak sensitivity"][2].rstrip("%")) < 90
    assert rows["stability-free box"][:2] == ["2", "3.71016"]


def test_a_level_of_refutation_that_still_holds_is_already_refused_by_the_checker(tmp_path):
    def tighter(claims):
        claims["stability-free", "hurwitz"].update(margin="4")
        claims["stability-free", "hurwitz"]["refuted_at"]["value"] = "9/2"

    text = refused(ExitCode.MISMATCH, "simulate", resealed(tmp_path, tighter), "--loads", "4")
    assert "stability-free hurwitz: its witness of tightness is false" in text


def test_repeats_an_experiment_of_the_paper(tmp_path):
    run = robimp("simulate", PAPER, "--experiment", "fig9", "-o", tmp_path)
    assert run.code == ExitCode.PROVEN and run.out.count("reproduced") == 4
    assert len(json.loads((tmp_path / "fig9.json").read_text(encoding="utf-8"))["curves"]) == 3


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("--experiment", "fig13"), "expected one of fig9"),
        (("--loads", "-1"), "--loads"),
        (("--loads", "1000000000"), "1000000"),
        (("--rate", "1e9", "--loads", "4"), "100000"),
        (("--rate", "0"), "--rate"),
        (("--rate", "-5"), "--rate"),
        (("--rate", "1e-9"), "--rate"),
        (("--rate", "nan"), "--rate"),
        (("--experiment", "fig9", "--loads", "10"), "leave out --loads"),
        (("--experiment", "fig9", "--friction-load", "0.1", "--rate", "500"), "leave out --friction-load, --rate"),
        (("--noise", "0.01"), "give its --rate"),
        (("--precision", "float"), "give its --rate"),
        (("--friction-load", "inf"), "must be finite"),
        (("--friction-load", "nan"), "--friction-load"),
        (("--stiction", "0.5"), "--stiction"),
        (("--friction-load", "0.1", "--loads", "0"), "--loads must not be 0"),
    ],
)
def test_refuses_what_it_does_not_know(arguments, reason):
    assert reason in refused(ExitCode.INPUT, "simulate", PAPER, *arguments)


def test_a_folder_that_cannot_be_written_is_refused_before_anything_runs(tmp_path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert "is not a folder" in refused(ExitCode.INPUT, "simulate", PAPER, "-o", tmp_path / "file" / "inside")


def test_an_experiment_on_a_certificate_that_check_refuses_ends_as_check_does(tmp_path):
    def bolder(claims):
        claims["peak", "sensitivity"].update(margin="1", refuted_at=None)

    file = resealed(tmp_path, bolder)
    code = robimp("check", file).code
    assert code != ExitCode.PROVEN
    assert str(file) in refused(ExitCode(code), "simulate", file, "--experiment", "fig9")


def test_the_papers_experiments_are_refused_on_another_joint():
    other = PAPER.parents[3] / "examples" / "certificates" / "ut-sea.json"
    assert "those of its own joint" in refused(ExitCode.INPUT, "simulate", other, "--experiment", "fig10")


def test_an_experiment_says_whose_numbers_and_which_controller_it_moves():
    run = robimp("simulate", PAPER.with_name("sampled-range.json"), "--experiment", "fig9")
    assert run.code == ExitCode.PROVEN
    assert "the paper's impedances" in run.out and "continuous one, though the certificate's is sampled" in run.out


def test_a_course_too_long_to_keep_is_refused_before_it_is_made():
    spec, C, *_ = golden("sampled-range")
    fast = spec.model_copy(update={"sampling": spec.sampling.model_copy(update={"rate": Fraction(10**9)})})
    with pytest.raises(InputError, match="sample slower"):
        population(fast, C, 4, 10.0, 0, lambda _: None, Reality(rate=1e9))


def test_the_help_shows_what_messages_advise():
    assert "--debug" in robimp("--help").out
