"""Files that are either complete or absent."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from .errors import InputError, Location


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


def write_atomic(path: Path, data: bytes) -> None:
    """Write a file so that a crash at any moment leaves the old one or the new one, never a part.

    Raises: InputError when the folder cannot be made or written to.
    """
    temporary: str | None = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        Path(temporary).chmod(0o644)
        Path(temporary).replace(path)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", Location(str(path))) from error
    finally:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
