"""Files that are either complete or absent."""

from __future__ import annotations

import os
import re
import stat
import sys
import tempfile
from pathlib import Path
from typing import BinaryIO

from .errors import InputError, Location
from .interruption import demand_none

if sys.platform != "win32":
    import fcntl


def bounded_bytes(path: Path, most: int) -> bytes:
    """A file's content, or one byte more than allowed. Raises: InputError."""
    try:
        if Path(os.path.realpath(path)).is_fifo():  # it may have no other end; a pipe of the shell has no such path
            raise InputError("file: a named pipe, not a file", Location(str(path)))
        with path.open("rb") as stream:
            return stream.read(most + 1)
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"file: cannot be read: {reason}", Location(str(path))) from error


def demand_writable(folder: Path) -> None:
    """Refuse a folder that files cannot be written to before anything long is computed. Raises: InputError."""
    try:
        nearest = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", Location(str(folder))) from error
    if not nearest.is_dir():
        raise InputError(f"cannot be written: {nearest} is not a folder", Location(str(folder)))
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise InputError(f"cannot be written: {nearest} is read-only", Location(str(folder)))


def demand_replaceable(path: Path) -> None:
    """Refuse what is no ordinary file, which replacing would destroy (/dev/null!). Raises: InputError."""
    demand_writable(path.parent)
    if path.exists() and not path.is_file():
        raise InputError("cannot be written: exists and is no ordinary file", Location(str(path)))


def write_atomic(path: Path, data: bytes) -> None:
    """Write a file so that a crash at any moment leaves the old one or the new one, never a part.

    What a killed process left of an earlier write to the same file is removed. Raises: InputError when the folder
    cannot be made or written to; KeyboardInterrupt when Ctrl-C was pressed before, whoever swallowed it.
    """
    demand_none()
    temporary: str | None = None
    try:
        target = Path(os.path.realpath(path))  # a link stays one
        target.parent.mkdir(parents=True, exist_ok=True)
        _remove_abandoned(target)
        handle, temporary = _held_temporary(target)
        lock = os.dup(handle)  # holds the temporary file until it is in place: see _remove_abandoned
        try:
            with os.fdopen(handle, "wb") as file:
                _write_through(file, data)
            Path(temporary).chmod(0o644)
            demand_none()
            Path(temporary).replace(target)
        finally:
            os.close(lock)
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        raise InputError(
            f"cannot be written: {getattr(error, 'strerror', None) or error}", Location(str(path))
        ) from error
    finally:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)


def discard(*paths: Path) -> None:
    """Remove what an earlier run left, before a newer file is written that it does not belong to.

    A crash then leaves files of one run only: the old certificate alone, or the new one and what was written after it.
    Raises: InputError when one cannot be removed; KeyboardInterrupt when Ctrl-C was pressed before.
    """
    demand_none()
    for path in paths:
        try:
            path.unlink(missing_ok=True)
        except NotADirectoryError:  # its folder is a file: writing will say so
            continue
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise InputError(f"cannot be replaced: {reason}", Location(str(path))) from error


def _write_through(file: BinaryIO, data: bytes) -> None:
    file.write(data)
    file.flush()
    os.fsync(file.fileno())


def _prefix(path: Path) -> str:
    return f".{path.name}.robimp-"


def _held_temporary(path: Path) -> tuple[int, str]:
    """A new temporary file beside the target, locked: the lock ends with the process, even a killed one."""
    while True:
        handle, temporary = tempfile.mkstemp(prefix=_prefix(path), suffix=".part", dir=path.parent)
        if _locked(handle, wait=True) and os.fstat(handle).st_nlink == 0:  # removed between its making and the lock
            os.close(handle)
            continue
        return handle, temporary


def _remove_abandoned(path: Path) -> None:
    """Remove this target's temporary files that are ours by name and owner and that no live process holds."""
    ours = re.compile(re.escape(_prefix(path)) + r"[a-z0-9_]{8}\.part")
    for part in [entry for entry in path.parent.iterdir() if ours.fullmatch(entry.name)]:
        try:
            status = part.lstat()
            if not stat.S_ISREG(status.st_mode) or status.st_uid != os.geteuid():
                continue
            handle = os.open(part, os.O_RDWR | os.O_NOFOLLOW)
        except (OSError, AttributeError):  # gone meanwhile, or a system without owners: leave it
            continue
        try:
            if _locked(handle, wait=False):
                part.unlink(missing_ok=True)
        finally:
            os.close(handle)


def _locked(handle: int, *, wait: bool) -> bool:
    """Lock an open file; whether that succeeded. Not every file system can."""
    if sys.platform == "win32":
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError:
        return False
    return True
