"""A Ctrl-C ends the command although something swallowed the exception it raised."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from robimp.synthesis.errors import ExitCode
from robimp.synthesis.interruption import Interruption, demand_none, remembered

EXAMPLES = Path(__file__).parents[1] / "examples"
MAIN = "from robimp.synthesis.cli import main\nmain()\n"
PRESSED_AND_SWALLOWED = """
import os, signal, sys, time
def pressed():
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(5)
def swallowing(genuine):
    def stub(*arguments, **options):
        try:
            pressed()
        except KeyboardInterrupt:
            print("swallowed", flush=True)
        return genuine(*arguments, **options)
    return stub
"""
STUBS = {
    "certify": "from robimp.synthesis import pipeline as home",
    "check_bytes": "from robimp.synthesis import recheck as home",
    "verify": "from robimp.synthesis import pipeline as home",
    "sampled_comparison": "from robimp.synthesis import pipeline as home",
    "fsync": "import os as home",
}


def run(script: str, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", PRESSED_AND_SWALLOWED + script + MAIN, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60)


def interrupted(done: subprocess.CompletedProcess[str]) -> bool:
    return done.returncode == ExitCode.UNDECIDED and done.stderr == "robimp: interrupted; no partial file was written\n"


@pytest.mark.parametrize("station", STUBS)
def test_a_press_swallowed_at_any_station_ends_the_synthesis(station: str, tmp_path: Path) -> None:
    stub = f"{STUBS[station]}\nhome.{station} = swallowing(home.{station})\n"
    done = run(stub, "synth", EXAMPLES / "haninger2016-paper.yaml", "-o", tmp_path / "out")
    assert interrupted(done) and done.stdout == "swallowed\n", done
    assert not list(tmp_path.rglob("*.json*"))


def test_a_press_swallowed_by_the_solver_ends_the_search(tmp_path: Path) -> None:
    stub = (
        "from robimp.synthesis.solve.nlp import Program\nfrom robimp.synthesis.solve import bound\n"
        "bound.bound = lambda *arguments, **options: None\n"
        "Program.solve = swallowing(lambda *arguments, **options: print('solve'))\n"
    )
    done = run(stub, "synth", EXAMPLES / "haninger2016.yaml", "-o", tmp_path / "out")
    assert interrupted(done) and done.stdout == "swallowed\nsolve\n", done
    assert not list(tmp_path.iterdir())


def test_a_press_lost_in_a_destructor_ends_the_synthesis(tmp_path: Path) -> None:
    stub = (
        "from robimp.synthesis import pipeline\ngenuine = pipeline.certify\n"
        "class Lost:\n    def __del__(self):\n        pressed()\n"
        "def certify(*arguments):\n    Lost()\n    print('lost', flush=True)\n    return genuine(*arguments)\n"
        "pipeline.certify = certify\n"
    )
    done = run(stub, "synth", EXAMPLES / "haninger2016-paper.yaml", "-o", tmp_path / "out")
    assert interrupted(done) and done.stdout == "lost\n", done
    assert not list(tmp_path.iterdir())


def test_a_press_swallowed_at_the_very_end_is_not_success(tmp_path: Path) -> None:
    stub = "from robimp.synthesis import spec\nspec.json_schema = swallowing(lambda: {})\n"
    done = run(stub, "schema")
    assert interrupted(done) and done.stdout.startswith("swallowed\n"), done


def test_without_a_press_nothing_is_demanded(tmp_path: Path) -> None:
    demand_none()
    done = run("", "synth", EXAMPLES / "haninger2016-paper.yaml", "-o", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, "")


def test_the_handler_before_is_put_back_and_the_press_forgotten() -> None:
    before = signal.getsignal(signal.SIGINT)
    assert before is signal.default_int_handler
    with remembered() as interruption:
        assert signal.getsignal(signal.SIGINT) is interruption
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
            signal.pause()
        assert interruption.pressed
        for _ in range(2):
            with pytest.raises(KeyboardInterrupt):
                demand_none()
    assert signal.getsignal(signal.SIGINT) is before
    demand_none()


def test_a_handler_of_somebody_else_stays() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with remembered() as interruption:
            assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN and not interruption.pressed
    finally:
        signal.signal(signal.SIGINT, before)


def test_other_threads_neither_set_a_handler_nor_miss_a_press() -> None:
    seen: list[object] = []

    def elsewhere() -> None:
        with remembered():
            seen.append(signal.getsignal(signal.SIGINT))
        try:
            demand_none()
        except KeyboardInterrupt:
            seen.append("interrupted")

    def in_a_thread() -> None:
        thread = threading.Thread(target=elsewhere)
        thread.start()
        thread.join()

    in_a_thread()
    assert seen == [signal.default_int_handler]
    with remembered() as interruption:
        interruption.pressed = True
        in_a_thread()
    assert seen[1:] == [interruption, "interrupted"] and isinstance(interruption, Interruption)
