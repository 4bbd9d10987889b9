"""A map that ends in the middle, however it ends, and goes on: nothing finished is lost or done twice."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from maps import AXES, COMMAND, MAIN, here, lines, proven, robimp

from robimp.synthesis import ExitCode, InputError, MismatchError, map_plane
from robimp.synthesis.sweep.journal import NAME


def begun(small: Path, folder: Path, cells: int, *command: str) -> subprocess.Popen[str]:
    """A map in a process of its own, once some cells are done."""
    script = [sys.executable, "-c", MAIN, "map", str(small), *(command or COMMAND), "-o", str(folder)]
    process = subprocess.Popen(script, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60
    while not (folder / NAME).exists() or (folder / NAME).read_bytes().count(b"\n") < cells + 1:
        assert time.monotonic() < deadline and process.poll() is None
        time.sleep(0.02)
    return process


LONG = ("--stiffness", "2:8:2", "--damping", "0.3:0.6:6", "--processes", "2")


def children(pid: int) -> list[int]:
    return [int(word) for word in Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()]


@pytest.mark.skipif(sys.platform != "linux", reason="looks at /proc")
def test_killed_it_resumes_without_doing_a_finished_cell_again(small: Path, tmp_path: Path) -> None:
    folder = tmp_path / "map"
    process = begun(small, folder, 3, *LONG)
    workers = children(process.pid)
    process.kill()
    process.communicate()
    finished = lines(folder)[1:]
    assert 3 <= len(finished) < 12
    deadline = time.monotonic() + 20
    while any(Path(f"/proc/{pid}/cmdline").exists() and Path(f"/proc/{pid}/cmdline").read_bytes() for pid in workers):
        assert time.monotonic() < deadline, "workers outlive the map"
        time.sleep(0.05)
    done = robimp("map", small, *LONG, "-o", folder)
    assert done.returncode == 0, done.stderr
    cells = lines(folder)[1:]
    assert cells[: len(finished)] == finished and len(cells) == 12 == len({tuple(cell["cell"]) for cell in cells})


def test_ctrl_c_keeps_what_is_done_and_says_so(small: Path, tmp_path: Path) -> None:
    folder = tmp_path / "map"
    process = begun(small, folder, 2, *LONG)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30)
    assert process.returncode == ExitCode.UNDECIDED and out == ""
    assert "every finished cell is kept" in err and "interrupted" in err and "Traceback" not in err
    assert not (folder / "map.json").exists() and len(lines(folder)) >= 3


def test_a_second_map_in_the_same_folder_is_refused(small: Path, tmp_path: Path) -> None:
    process = begun(small, tmp_path / "map", 1, *LONG)
    try:
        done = robimp("map", small, *LONG, "-o", tmp_path / "map")
        assert done.returncode == ExitCode.INPUT and "another map is being written here" in done.stderr
        assert process.poll() is None
    finally:
        process.kill()
        process.communicate()


def test_a_finished_map_asks_no_worker(small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    executor = here(monkeypatch, proven)
    first = map_plane(small, AXES, tmp_path / "map")
    assert len(executor.tasks) == 6
    second = map_plane(small, AXES, tmp_path / "map")
    assert len(executor.tasks) == 6 and second.to_json() == first.to_json()


@pytest.mark.parametrize("torn", [b'{"cell": [1, 2], "sta', b"\x00\xff", b"{"])
def test_a_line_cut_short_is_dropped_and_its_cell_done_again(
    torn: bytes, small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    executor = here(monkeypatch, proven)
    whole = map_plane(small, AXES, tmp_path / "map")
    journal = tmp_path / "map" / NAME
    *kept, _, _ = journal.read_bytes().split(b"\n")
    journal.write_bytes(b"\n".join(kept) + b"\n" + torn)
    again = map_plane(small, AXES, tmp_path / "map")
    assert len(executor.tasks) == 7 and again.cells == whole.cells
    assert len(lines(tmp_path / "map")) == 7


def test_a_journal_of_another_map_is_refused_in_words(
    small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here(monkeypatch, proven)
    map_plane(small, AXES, tmp_path / "map")
    before = (tmp_path / "map" / NAME).read_bytes()
    other = {"impedance.stiffness": "2:9:2", "impedance.damping": "0.2:0.6:3"}
    with pytest.raises(MismatchError, match=r"axes\[0\].values\[1\] 8 → 9"):
        map_plane(small, other, tmp_path / "map")
    with pytest.raises(MismatchError, match=r"options.certificates false → true"):
        map_plane(small, AXES, tmp_path / "map", certificates=True)
    small.write_text(small.read_text(encoding="utf-8").replace("inertia: 0.05", "inertia: 0.06"), encoding="utf-8")
    with pytest.raises(MismatchError, match=r"plant.inertia 0.05 → 0.06"):
        map_plane(small, AXES, tmp_path / "map")
    assert (tmp_path / "map" / NAME).read_bytes() == before
    done = robimp("map", small, *COMMAND, "-o", tmp_path / "map")
    assert done.returncode == ExitCode.MISMATCH and "plant.inertia 0.05 → 0.06" in done.stderr


@pytest.mark.parametrize("line", [b"[]", b"{}", b'{"cell": [9, 9]}', b"no json", b"[" * 100_000])
def test_a_damaged_journal_is_refused_by_line(
    line: bytes, small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here(monkeypatch, proven)
    map_plane(small, AXES, tmp_path / "map")
    journal = tmp_path / "map" / NAME
    head, *rest = journal.read_bytes().split(b"\n")
    journal.write_bytes(b"\n".join([head, line, *rest]))
    with pytest.raises(InputError, match=f"{NAME}:2: not a line this program wrote"):
        map_plane(small, AXES, tmp_path / "map")
    journal.write_bytes(line + b"\n")
    with pytest.raises(InputError, match=f"{NAME}:1: not"):
        map_plane(small, AXES, tmp_path / "map")


def test_a_full_disk_keeps_what_is_done(small: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    executor = here(monkeypatch, proven)
    genuine, calls = os.fsync, []

    def fsync(handle: int) -> None:
        calls.append(handle)
        if len(calls) > 3:
            raise OSError(28, "No space left on device")
        genuine(handle)

    with monkeypatch.context() as full:
        full.setattr(os, "fsync", fsync)
        with pytest.raises(InputError, match="No space left"):
            map_plane(small, AXES, tmp_path / "map")
    assert len(lines(tmp_path / "map")) >= 3
    asked = len(executor.tasks)
    assert len(map_plane(small, AXES, tmp_path / "map").cells) == 6
    assert len(executor.tasks) <= asked + 4
