"""Maps end to end: what they hold, how they end, and that nothing finished is lost or done twice."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from maps import AXES, COMMAND, here, plane, proven, robimp

from robimp.synthesis import ExitCode, InputError, RobimpError, check, load, map_plane, synthesize
from robimp.synthesis.solve.search import REACHED, SAME
from robimp.synthesis.spec.model import Polynomials
from robimp.synthesis.storage import write_atomic
from robimp.synthesis.sweep import run as home
from robimp.synthesis.sweep.cell import Cell, Status, Task, solve_cell
from robimp.synthesis.sweep.figure import figure
from robimp.synthesis.sweep.picture import picture
from robimp.synthesis.sweep.result import Map
from robimp.synthesis.sweep.workers import Processes, workers

# ---- what a map holds


def test_two_processes_map_a_plane_and_every_cell_is_that_of_synthesize(small: Path, tmp_path: Path) -> None:
    folder = tmp_path / "map"
    done = robimp("map", small, *COMMAND, "-o", folder, "--certificates", "--json")
    assert (done.returncode, done.stderr) == (0, "")
    document = json.loads((folder / "map.json").read_bytes())
    assert document == json.loads(done.stdout)
    assert [cell["cell"] for cell in document["cells"]] == [[i, j] for i in range(2) for j in range(3)]
    assert document["counts"]["refuted"] > 0 and document["counts"]["proven"] > 0
    for cell in document["cells"]:
        if cell["cell"] not in ([0, 0], [1, 2]):
            continue
        alone = synthesize(plane(small).specs[tuple(cell["cell"])])
        assert cell["status"] == alone.outcome.value
        if cell["status"] == "proven":
            assert Fraction(cell["omega_B"]) == alone.omega_B
            assert check(folder / cell["certificate"]).exit_code == 0
        else:
            assert cell["omega_B"] is None and "eq12" in cell["reason"] and "certificate" not in cell
    assert (folder / "map.svg").read_bytes().startswith(b"<?xml") and (folder / "map.png").stat().st_size > 5000


def test_a_map_of_a_search_starts_each_cell_from_its_neighbour(
    small: Path, searched: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    coefficients = load(small).controller.coefficients

    def answer(task: Task) -> tuple[Cell, None]:
        if task.index == (0, 1):
            return Cell(task.index, Status.INFEASIBLE, cause="(12) structured"), None
        return Cell(task.index, Status.PROVEN, Fraction(sum(task.index) + 1), coefficients=coefficients), None

    executor = here(monkeypatch, answer)
    map_plane(searched, AXES, tmp_path / "map")
    starts = {task.index: task.start and task.start.omega_B for task in executor.tasks}
    assert starts == {(0, 0): None, (0, 1): 1, (1, 0): 1, (0, 2): 1, (1, 1): 2, (1, 2): 3}, "past the infeasible cell"


def test_rows_go_on_together_so_that_no_chain_of_neighbours_is_left_for_the_end(
    searched: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    executor = here(monkeypatch, proven)
    map_plane(searched, AXES, tmp_path / "map")
    assert [task.index for task in executor.tasks] == [(0, 0), (1, 0), (0, 1), (1, 1), (0, 2), (1, 2)]


def test_a_search_with_a_neighbours_start_is_no_worse_however_poor_the_neighbour(searched: Path) -> None:
    cold = synthesize(load(searched))
    poor = Polynomials(numerator=(Fraction(1),), denominator=(Fraction(1), Fraction(10), Fraction(100)))
    for start in (cold.coefficients, poor):
        warm = synthesize(load(searched), starts=[(start, 1.0)])
        assert float(warm.omega_B / cold.omega_B) >= (1 - SAME) * REACHED, "what the search calls the same"


def example(small: Path) -> Map:
    """A map with one cell of each kind."""
    kinds = [Status.PROVEN, Status.PROVEN, Status.REFUTED, Status.INFEASIBLE, Status.UNDECIDED, Status.ERROR]
    cells = {
        index: Cell(index, s, Fraction(k + 9)) if s is Status.PROVEN else Cell(index, s, None, f"cause {k}", f"why {k}")
        for k, (index, s) in enumerate(zip(plane(small), kinds, strict=True))
    }
    return Map(plane(small), cells)


def test_the_picture_has_a_sign_for_every_cell_and_a_reason_for_every_letter(small: Path) -> None:
    text = list(picture(example(small)))
    assert text[1].split("│")[1].split() == ["b", "c", "d"] and text[2].split("│")[1].split() == ["9", "9", "a"]
    assert [line for line in text if "why 3" in line and line.startswith("b: 1 cell infeasible, such as")]
    assert sum(line[0] in "abcd" and line[1] == ":" for line in text) == 4


def test_the_figure_names_every_cause_and_the_spring(small: Path) -> None:
    plain = figure(example(small), "svg").decode()
    assert all(f"cause {k}" in plain for k in range(2, 6))
    assert "K_{sp}" not in plain
    elastic = (
        "{type: series-elastic, motor_inertia: 0.01, motor_damping: 0.05, spring_stiffness: 4.8, "
        "torque_loop: {kp: 10, kd: 0.25, derivative_corner: 1000, feedforward: 1}}"
    )
    small.write_text(small.read_text(encoding="utf-8").replace("{type: ideal}", elastic), encoding="utf-8")
    assert "K_{sp}" in figure(example(small), "svg").decode()
    assert any("← K_sp" in line for line in picture(example(small)))


@pytest.mark.parametrize(
    ("statuses", "code"),
    [
        ({Status.PROVEN, Status.INFEASIBLE, Status.REFUTED}, ExitCode.PROVEN),
        ({Status.PROVEN, Status.UNDECIDED}, ExitCode.UNDECIDED),
        ({Status.UNDECIDED, Status.ERROR}, ExitCode.INTERNAL),
    ],
)
def test_infeasible_cells_are_answers_and_errors_are_not(small: Path, statuses: set[Status], code: ExitCode) -> None:
    cells = {k: v for k, v in example(small).cells.items() if v.status in statuses}
    assert Map(example(small).plane, cells).exit_code == code


def test_a_line_of_the_journal_is_the_cell(small: Path) -> None:
    coefficients = load(small).controller.coefficients
    for cell in [
        *example(small).cells.values(),
        Cell((3, 4), Status.PROVEN, Fraction(22, 7), "", "", 1.25, coefficients),
    ]:
        assert Cell.from_json(json.loads(json.dumps(cell.to_json()))) == cell


# ---- cells that fail


def test_one_of_the_cells_fails_and_the_rest_goes_on(
    small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def answer(task: Task) -> tuple[Cell, None]:
        if task.index == (0, 1):
            raise OSError("out of memory")
        return proven(task)

    here(monkeypatch, answer)
    found = map_plane(small, AXES, tmp_path / "map")
    assert found.exit_code is ExitCode.INTERNAL and found.counts[Status.PROVEN] == 5
    assert "out of memory" in found.cells[0, 1].reason
    executor = here(monkeypatch, proven)
    again = map_plane(small, AXES, tmp_path / "map")
    assert [task.index for task in executor.tasks] == [(0, 1)], "only what failed is tried again"
    assert again.exit_code is ExitCode.PROVEN


def test_whatever_happens_in_a_cell_stays_in_it(small: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from robimp.synthesis import InfeasibleError, UndecidedError, pipeline

    def raising(error: Exception) -> Callable[..., Any]:
        def stub(*_: Any, **__: Any) -> Any:
            raise error

        return stub

    for error, status, cause in [
        (InfeasibleError("no way", "(9) printed"), Status.INFEASIBLE, "(9) printed"),
        (UndecidedError("out of time"), Status.UNDECIDED, "undecided"),
        (InputError("contradiction"), Status.ERROR, "error"),
        (ZeroDivisionError("oops"), Status.ERROR, "ZeroDivisionError"),
    ]:
        monkeypatch.setattr(pipeline, "synthesize", raising(error))
        cell, certificate = solve_cell(Task((1, 2), load(small)))
        assert (cell.status, cell.cause, certificate) == (status, cause, None) and str(error) in cell.reason


def suicide(task: Task) -> tuple[Cell, None]:
    """Kills its worker at one cell: always, or only while a file is missing."""
    marker = Path(os.environ["MARKER"])
    if task.index == (0, 1) and not marker.exists():
        if os.environ["ONCE"] == "1":
            marker.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return Cell(task.index, Status.PROVEN, Fraction(1)), None


@pytest.mark.parametrize("once", [True, False])
def test_a_killed_worker_costs_its_cell_at_most(
    once: bool, small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MARKER", str(tmp_path / "marker"))
    monkeypatch.setenv("ONCE", "1" if once else "0")
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    monkeypatch.setattr(home, "solve_cell", suicide)
    found = map_plane(small, AXES, tmp_path / "map", processes=2)
    expected = dict.fromkeys(found.plane, Status.PROVEN) | ({} if once else {(0, 1): Status.ERROR})
    assert {index: cell.status for index, cell in found.cells.items()} == expected
    if not once:
        assert "worker died 2 times" in found.cells[0, 1].reason and found.exit_code is ExitCode.INTERNAL


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--stiffness", "1:2:3"], "two axes, 1 given"),
        (["--stiffness", "1:2:3", "--damping", "1:2:3", "--vary", "plant.inertia=1:2:3"], "two axes, 3 given"),
        (["--stiffness", "1:2", "--damping", "1:2:3"], "A:B:N"),
        (["--stiffness", "1:2:3", "--vary", "impedance.stiffness=1:2:3"], "two different keys"),
        (["--stiffness", "1:2:2", "--damping", "1:2:2", "--processes", "0"], "processes"),
        (["--stiffness", "1:2:2", "--damping", "1:2:2", "--dask", "tcp://127.0.0.1:1"], "dask"),
    ],
)
def test_commands_that_make_no_sense_are_refused_in_one_line(
    arguments: list[str], said: str, small: Path, tmp_path: Path
) -> None:
    done = robimp("map", small, *arguments, "-o", tmp_path / "map")
    assert done.returncode == ExitCode.INPUT and said in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_an_output_that_cannot_be_written_is_refused_at_once(small: Path, tmp_path: Path) -> None:
    write_atomic(tmp_path / "file", b"")
    done = robimp("map", small, *COMMAND, "-o", tmp_path / "file")
    assert done.returncode == ExitCode.INPUT and "is not a folder" in done.stderr


# ---- the processes


def environment(name: str) -> str | None:
    return os.environ.get(name)


def test_workers_have_one_blas_thread_and_leave_the_caller_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    main = sys.modules["__main__"]
    with Processes(1) as processes:
        for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
            assert processes.submit(environment, name).result() == "1"
    assert os.environ["OMP_NUM_THREADS"] == "7" and "OPENBLAS_NUM_THREADS" not in os.environ
    assert sys.modules["__main__"] is main


def test_there_are_as_many_processes_as_asked_for() -> None:
    for asked, given in ((1, 1), (3, 3), (None, os.cpu_count())):
        with workers(asked, None) as (executor, size):
            assert size == given and isinstance(executor, Processes)


def test_no_more_tasks_than_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    with Processes(1) as processes:
        first = processes.submit(time.sleep, 1)
        with pytest.raises(RobimpError, match="more tasks than processes"):
            processes.submit(time.sleep, 0)
        first.result()
        assert processes.submit(os.getpid).result() != os.getpid()


def test_a_script_without_a_guard_is_not_run_again_by_its_workers(small: Path, tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    axes = {"impedance.stiffness": "2:8:2", "impedance.damping": "0.4:0.6:2"}
    script.write_text(
        "from robimp.synthesis import map_plane\nprint('once', flush=True)\n"
        f"print(len(map_plane({str(small)!r}, {axes!r}, {str(tmp_path / 'map')!r}, processes=2).cells))\n",
        encoding="utf-8",
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60)
    assert (done.stdout, done.stderr) == ("once\n4\n", "")
