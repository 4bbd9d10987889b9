"""The benchmark is fair and cannot flatter: everybody meets the same inequalities and the same prover."""

from __future__ import annotations

import json
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from gridded import BACK_OFF, Gridded, Pair
from solvers import NAMES, paper_tuning, scipy_slsqp
from task import PROBLEMS, Candidate, Task, exact_q
from verdicts import judge
from worker import row

from robimp.synthesis import load
from robimp.synthesis.check import check_bytes
from robimp.synthesis.spec.model import Polynomials

ROOT = Path(__file__).parents[2]
RIVALS = ROOT / "benchmarks" / "rivals"
TRAP = ROOT / "examples" / "unstable-optimum.yaml"


def normalised(task: Task, numerator: list[float], denominator: list[float]) -> Pair:
    """A Q in powers of s as `Gridded` has it."""
    powers = task.omega_0 ** -np.arange(len(denominator))
    return np.array(numerator) * powers[len(denominator) - len(numerator) :], np.array(denominator) * powers


@pytest.fixture(scope="module")
def task() -> Task:
    return Task.of(PROBLEMS["haninger2016"], 4, 1.0)


def test_every_solver_and_every_problem_has_its_file() -> None:
    assert set(NAMES) == {path.stem for path in (RIVALS / "solvers").glob("*.py")} - {"__init__"}
    for name, file in PROBLEMS.items():
        assert load(file).name == name


def test_the_slow_torque_loop_is_the_joint_of_the_trap() -> None:
    ours, trap = load(PROBLEMS["slow-torque-loop"]), load(TRAP)
    assert ours.model_copy(update={"name": trap.name, "controller": trap.controller}) == trap


def test_the_stiffness_range_is_the_reference_joint_but_for_the_range() -> None:
    ours, reference = load(PROBLEMS["stiffness-range"]), load(PROBLEMS["haninger2016"])
    assert ours.impedance.stiffness == (Fraction("0.2"), 10)
    wish = ours.impedance.model_copy(update={"stiffness": reference.impedance.stiffness})
    assert ours.model_copy(update={"name": reference.name, "impedance": wish}) == reference


def test_the_papers_tuning_is_proven_as_the_example_is(task: Task) -> None:
    answer = paper_tuning.solve(task)
    assert answer.candidate is not None
    found = judge(task, answer.candidate)
    assert (found.outcome, found.checker) == ("proven", "exit 0")
    assert found.omega_B == pytest.approx(8.8757, abs=1e-3)


def test_the_bandwidth_a_solver_claims_is_never_what_it_is_credited_with(task: Task) -> None:
    boast = Candidate(exact_q([2000], [1, 70.75, 2500]), claimed=1000.0)
    assert judge(task, boast).omega_B == pytest.approx(8.8757, abs=1e-3)


def test_an_unstable_optimum_passes_the_grid_and_not_the_prover() -> None:
    task = Task.of(PROBLEMS["slow-torque-loop"], 4, 1.0)
    given = load(TRAP).controller.coefficients
    assert given is not None
    gridded = Gridded(task)
    Q = normalised(task, *([float(c) for c in part] for part in (given.numerator, given.denominator)))
    assert gridded.slack(Q).min() > BACK_OFF
    assert gridded.growth(Q) * task.omega_0 == pytest.approx(237, abs=1)
    found = judge(task, Candidate(given, gridded.omega_B(Q)))
    assert (found.outcome, found.omega_B, found.checker) == ("unstable", None, "exit 4")
    assert "+237" in found.why


def test_a_refuted_rival_is_told_which_claim_fails_where_and_by_how_much() -> None:
    task = Task.of(ROOT / "examples" / "haninger2016-stiff.yaml", 2, 1.0)
    answer = paper_tuning.solve(task)
    assert answer.candidate is not None
    found = judge(task, answer.candidate)
    assert found.outcome == "refuted" and found.omega_B is None
    assert "eq12 structured by 0.05" in found.why and "at 5" in found.why


def test_the_grid_sees_what_the_prover_sees(task: Task) -> None:
    """The paper's Q has slack on the rivals' grid and is proven; three times as fast it fails for both."""
    gridded = Gridded(task)
    slow, fast = (normalised(task, [0.8 * w**2], [1, 1.415 * w, w**2]) for w in (50, 150))
    assert gridded.slack(slow).min() > BACK_OFF and gridded.growth(slow) < 0
    proven = judge(task, gridded.candidate(slow))
    assert proven.outcome == "proven" and gridded.omega_B(slow) == pytest.approx(proven.omega_B, rel=0.03)
    assert gridded.slack(fast).min() < 0
    assert judge(task, gridded.candidate(fast)).outcome in ("refuted", "unstable")


def test_a_rival_within_its_time_limit_answers_with_what_it_believes(task: Task) -> None:
    answer = scipy_slsqp.solve(task, stable=True)
    assert "starts" in answer.note
    if answer.candidate is not None:
        assert judge(task, answer.candidate).outcome in ("proven", "refuted", "undecided")


def test_a_missing_package_is_a_skipped_row_that_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "dkpy", None)
    found = row("dkpy_dk", PROBLEMS["haninger2016"], 4, 1.0)
    assert found["outcome"] == "skipped" and "dkpy" in found["why"] and "bench" in found["why"]


def test_a_rival_that_dies_is_a_row_that_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def dies(_: Task) -> None:
        raise ZeroDivisionError("inside")

    monkeypatch.setattr(paper_tuning, "solve", dies)
    found = row("paper_tuning", PROBLEMS["haninger2016"], 4, 1.0)
    assert found["outcome"] == "failed" and "ZeroDivisionError" in found["why"]


def test_the_command_prints_a_table_and_writes_a_result(tmp_path: Path) -> None:
    options = ["--problem", "haninger2016", "--order", "4", "--solver", "paper_tuning", "--results", str(tmp_path)]
    done = subprocess.run(
        [sys.executable, str(RIVALS), *options, "--no-tutorial"],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    line = next(line for line in done.stdout.splitlines() if "paper_tuning" in line)
    assert "8.88" in line and "yes" in line
    written = json.loads((tmp_path / "haninger2016-order-4.json").read_text(encoding="utf-8"))
    assert written["rows"][0]["omega_B"] == pytest.approx(8.8757, abs=1e-3) and written["machine"]["cores"] >= 1


RESULTS = sorted((ROOT / "benchmarks" / "results").glob("*-order-*.json"))


@pytest.mark.parametrize("file", RESULTS, ids=[file.stem for file in RESULTS])
def test_nobody_is_credited_in_the_recorded_results_without_both_proofs(file: Path) -> None:
    rows = json.loads(file.read_text(encoding="utf-8"))["rows"]
    assert [r["solver"] for r in rows] == list(NAMES)
    for r in rows:
        assert (r.get("omega_B") is not None) == (r["outcome"] == "proven") == (r.get("checker") == "exit 0")


def test_the_recorded_best_rival_is_proven_again_and_robimp_is_not_below_it(task: Task) -> None:
    file = ROOT / "benchmarks" / "results" / "haninger2016-order-4.json"
    rows = {r["solver"]: r for r in json.loads(file.read_text(encoding="utf-8"))["rows"]}
    ours = rows.pop("robimp")
    best = max(rows.values(), key=lambda r: r.get("omega_B") or 0)
    assert ours["omega_B"] >= best["omega_B"] > 8.9
    Q = Polynomials(**{key: tuple(map(Fraction, best["Q"][key])) for key in ("numerator", "denominator")})
    assert judge(task, Candidate(Q, None)).omega_B == pytest.approx(best["omega_B"], rel=1e-6)


def test_the_checker_is_asked_about_the_rivals_controller_itself(task: Task, monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []

    def recording(data: bytes) -> object:
        seen.append(json.loads(data)["controller"]["Q"])
        return check_bytes(data)

    monkeypatch.setattr("verdicts.check_bytes", recording)
    judge(task, Candidate(exact_q([2000], [1, 70.75, 2500]), None))
    assert seen == [{"numerator": ["2000"], "denominator": ["1", "283/4", "2500"]}]
