"""A file is complete or absent, whatever happens while it is written."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from robimp.synthesis.errors import InputError
from robimp.synthesis.storage import bounded_bytes, demand_replaceable, demand_writable, discard, write_atomic


def names(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir())


def test_a_file_is_written_in_folders_that_are_made_for_it(tmp_path: Path) -> None:
    target = tmp_path / "a" / "b" / "file.json"
    write_atomic(target, b"content")
    assert target.read_bytes() == b"content"
    assert names(target.parent) == ["file.json"]
    assert target.stat().st_mode & 0o777 == 0o644


def test_a_file_is_replaced_whole(tmp_path: Path) -> None:
    target = tmp_path / "file.json"
    write_atomic(target, b"a long first content")
    write_atomic(target, b"short")
    assert target.read_bytes() == b"short"


@pytest.mark.parametrize("place", ["pipe", "link"])
def test_a_named_pipe_is_not_waited_for(tmp_path: Path, place: str) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("pipe")
    with pytest.raises(InputError, match="a named pipe, not a file"):
        bounded_bytes(tmp_path / place, 10)


def test_a_link_stays_a_link_and_its_file_is_written(tmp_path: Path) -> None:
    link = tmp_path / "latest.json"
    link.symlink_to(Path("runs") / "file.json")
    for content in (b"first", b"second"):
        write_atomic(link, content)
        assert link.is_symlink() and (tmp_path / "runs" / "file.json").read_bytes() == content
        assert names(tmp_path) == ["latest.json", "runs"] and names(tmp_path / "runs") == ["file.json"]


@pytest.mark.parametrize("step", ["fsync", "fdopen", "replace"])
@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()], ids=["full", "Ctrl-C"])
def test_a_failure_at_any_step_leaves_the_old_file_and_no_litter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str, error: BaseException
) -> None:
    target = tmp_path / "file.json"
    write_atomic(target, b"old")

    def fail(*_: object, **__: object) -> None:
        raise error

    owner = Path if step == "replace" else os
    with monkeypatch.context() as patched:
        patched.setattr(owner, step, fail)
        with pytest.raises(InputError if isinstance(error, OSError) else KeyboardInterrupt) as raised:
            write_atomic(target, b"new")
    if isinstance(error, OSError):
        assert str(raised.value) == f"{target}: cannot be written: No space left on device"
    assert target.read_bytes() == b"old"
    assert names(tmp_path) == ["file.json"]
    write_atomic(target, b"new")
    assert target.read_bytes() == b"new", "the same write succeeds when nothing fails"


def test_a_killed_writer_leaves_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "file.json"
    write_atomic(target, b"old")
    script = (
        "import os, sys, time\nfrom pathlib import Path\nfrom robimp.synthesis import storage\n"
        "def hang(_):\n    print('writing', flush=True)\n    time.sleep(60)\n"
        "os.fsync = hang\n"
        "storage.write_atomic(Path(sys.argv[1]), b'new' * 100000)\n"
    )
    with subprocess.Popen([sys.executable, "-c", script, str(target)], stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout is not None and writer.stdout.readline() == "writing\n"
        (part,) = (name for name in names(tmp_path) if name != "file.json")
        write_atomic(target, b"second")
        assert part in names(tmp_path), "a live process still holds it"
        writer.send_signal(signal.SIGKILL)
    assert target.read_bytes() == b"second"
    assert part in names(tmp_path), "nobody could clean up after kill −9"
    write_atomic(target, b"third")
    assert target.read_bytes() == b"third" and names(tmp_path) == ["file.json"]


def test_only_what_is_ours_is_cleaned_up(tmp_path: Path) -> None:
    target, elsewhere = tmp_path / "file.json", tmp_path / "elsewhere"
    elsewhere.write_bytes(b"mine")
    kept = [
        ".file.json.backup.part",
        ".other.json.robimp-abcd1234.part",
        ".file.json.robimp-abcd1234.parts",
        "file.json.robimp-abcd1234.part",
    ]
    for name in kept:
        (tmp_path / name).write_bytes(b"mine")
    (tmp_path / ".file.json.robimp-abandone.part").write_bytes(b"ours")
    (tmp_path / ".file.json.robimp-symlink1.part").symlink_to(elsewhere)
    os.mkfifo(tmp_path / ".file.json.robimp-fifo1234.part")
    (tmp_path / ".file.json.robimp-folder12.part").mkdir()
    kept += [f".file.json.robimp-{kind}.part" for kind in ("symlink1", "fifo1234", "folder12")]
    write_atomic(target, b"new")
    assert names(tmp_path) == sorted([*kept, "elsewhere", "file.json"]) and elsewhere.read_bytes() == b"mine"


def test_a_foreign_temporary_file_is_left_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    part = tmp_path / ".file.json.robimp-abcd1234.part"
    part.write_bytes(b"another user's")
    monkeypatch.setattr(os, "geteuid", lambda: part.stat().st_uid + 1)
    write_atomic(tmp_path / "file.json", b"new")
    assert part.exists()


def test_writers_of_one_file_do_not_clean_each_other_up(tmp_path: Path) -> None:
    target = tmp_path / "file.json"
    script = (
        "import sys\nfrom pathlib import Path\nfrom robimp.synthesis.storage import write_atomic\n"
        "for _ in range(150):\n    write_atomic(Path(sys.argv[1]), sys.argv[2].encode() * 1000)\n"
    )
    writers = [subprocess.Popen([sys.executable, "-c", script, str(target), letter]) for letter in "abc"]
    assert [writer.wait(timeout=60) for writer in writers] == [0, 0, 0]
    assert target.read_bytes() in [letter * 1000 for letter in (b"a", b"b", b"c")] and names(tmp_path) == ["file.json"]


@pytest.mark.parametrize("place", ["device", "folder", "below a file"])
def test_what_is_no_ordinary_file_is_not_replaced(tmp_path: Path, place: str) -> None:
    (tmp_path / "file").write_bytes(b"mine")
    (tmp_path / "folder").mkdir()
    targets = {"device": Path(os.devnull), "folder": tmp_path / "folder", "below a file": tmp_path / "file" / "x"}
    with pytest.raises(InputError, match="cannot be written"):
        demand_replaceable(targets[place])
    demand_replaceable(tmp_path / "file")
    demand_replaceable(tmp_path / "new")


def test_a_reader_sees_the_old_file_or_the_new_one(tmp_path: Path) -> None:
    target, end = tmp_path / "file.json", time.monotonic() + 0.5
    versions = [letter * 200_000 for letter in (b"a", b"b")]
    write_atomic(target, versions[0])
    script = (
        "import sys\nfrom pathlib import Path\nfrom robimp.synthesis.storage import write_atomic\n"
        "while True:\n    for c in b'ab':\n        write_atomic(Path(sys.argv[1]), bytes([c]) * 200000)\n"
    )
    seen = set()
    with subprocess.Popen([sys.executable, "-c", script, str(target)]) as writer:
        while time.monotonic() < end or len(seen) < 2:
            seen.add(target.read_bytes())
            assert time.monotonic() < end + 20, "the writer never wrote"
        writer.kill()
    assert seen == set(versions)


def test_places_that_cannot_be_written_are_refused_in_one_line(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_bytes(b"mine")
    (tmp_path / "folder.json").mkdir()
    for target in (file / "x.json", file / "deep" / "x.json", tmp_path / "folder.json", tmp_path / ("n" * 300)):
        with pytest.raises(InputError, match="cannot be written") as refusal:
            write_atomic(target, b"new")
        assert str(target) in str(refusal.value) and "\n" not in str(refusal.value)
    assert file.read_bytes() == b"mine"
    assert names(tmp_path) == ["file", "folder.json"]


def test_a_folder_is_judged_before_anything_is_computed(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_bytes(b"mine")
    for folder in (file, file / "deep" / "er", tmp_path / ("n" * 300)):
        with pytest.raises(InputError, match="cannot be written"):
            demand_writable(folder)
    demand_writable(tmp_path)
    demand_writable(tmp_path / "new" / "er")
    demand_writable(Path("out") / "relative")
    assert names(tmp_path) == ["file"], "looking makes nothing"


def test_a_folder_without_permission_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    demand_writable(tmp_path / "new")
    monkeypatch.setattr(os, "access", lambda place, mode: not (Path(place) == tmp_path and mode & os.W_OK))
    with pytest.raises(InputError, match="read-only"):
        demand_writable(tmp_path / "new")


def test_what_belongs_to_an_older_file_is_removed(tmp_path: Path) -> None:
    (tmp_path / "old.json").write_bytes(b"old")
    discard(tmp_path / "old.json", tmp_path / "missing.json", tmp_path / "no" / "folder.json")
    assert names(tmp_path) == []
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError, match="cannot be replaced"):
        discard(tmp_path / "folder")
