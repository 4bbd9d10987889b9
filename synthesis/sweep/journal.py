"""The journal of a map: one line for what it is of, then one for every finished cell, each on the disk before the next.

Killed at any moment it holds every finished cell; a line that was being written is dropped and its cell done again.
The first line says whose journal it is, so that cells of another map are never taken for this one's.
"""

from __future__ import annotations

import json
import os
import sys
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

from ..errors import InputError, Location, MismatchError
from ..report.difference import differences
from ..storage import demand_writable
from .cell import Cell, Status
from .plane import Index, Plane

if sys.platform != "win32":
    import fcntl

NAME = "map.journal"


class Journal:
    """An open journal, locked against a second map in the same folder until it is closed or its process ends."""

    def __init__(self, folder: Path, plane: Plane, options: dict[str, Any]) -> None:
        """Open it, or begin one.

        Raises: InputError when it cannot be written, is no journal, or another map is writing it; MismatchError when
        it is the journal of another map.
        """
        self.path, self.plane = folder / NAME, plane
        header = {"robimp_map": 1, "robimp": version("robimp"), "options": options, **plane.to_json()}
        demand_writable(folder)
        self.new_folder = not folder.exists()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self.file: BinaryIO = self.path.open("a+b")
        except OSError as error:
            raise self._unusable(f"cannot be written: {error.strerror or error}") from error
        try:
            self._lock()
            self.finished = self._read(header)
        except BaseException:
            self.file.close()
            raise

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if not self.finished:  # nothing to keep: as if the map had not been begun
            with suppress(OSError):
                self.path.unlink()
                if self.new_folder:
                    self.path.parent.rmdir()
        self.file.close()

    def add(self, cell: Cell) -> None:
        """Keep a finished cell. Raises: InputError when the disk does not take it."""
        self._append(cell.to_json())
        self.finished[cell.index] = cell

    def _lock(self) -> None:
        if sys.platform == "win32":
            return
        try:
            fcntl.flock(self.file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise self._unusable("another map is being written here; wait for it, or give another --output") from None
        except OSError:  # a file system without locks
            return

    def _read(self, header: dict[str, Any]) -> dict[Index, Cell]:
        """The cells that are done; errors are not, so that they are tried again."""
        self.file.seek(0)
        *lines, torn = self.file.read().split(b"\n")
        if not lines:
            self._cut(0)
            self._append(header)
            return {}
        self._compare(self._parsed(lines[0], 1), header)
        cells: dict[Index, Cell] = {}
        for number, line in enumerate(lines[1:], 2):
            cell = self._cell(line, number)
            if cell.status is not Status.ERROR:
                cells[cell.index] = cell
        if torn:
            self._cut(self.file.tell() - len(torn))
        return cells

    def _compare(self, found: Any, header: dict[str, Any]) -> None:
        if not isinstance(found, dict) or "robimp_map" not in found:
            raise self._unusable("not the journal of a map; remove it, or give another --output", 1)
        if found == json.loads(json.dumps(header)):
            return
        named = [
            text.replace("in the certificate", "in the journal")
            for key in ("robimp_map", "robimp", "options", "spec", "axes")
            for text in differences(found.get(key), header[key], "request", "" if key == "spec" else key)
        ] or ["the cells' specifications differ"]
        raise MismatchError(
            f"{self.path} is the journal of another map (journal → this one): {'; '.join(named[:5])}; "
            "give another --output, or remove the folder"
        )

    def _cell(self, line: bytes, number: int) -> Cell:
        try:
            cell = Cell.from_json(self._parsed(line, number))
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise self._damaged(number) from error
        if cell.index not in self.plane.specs:
            raise self._damaged(number)
        return cell

    def _parsed(self, line: bytes, number: int) -> Any:
        try:
            return json.loads(line)
        except (ValueError, RecursionError):
            raise self._damaged(number) from None

    def _append(self, line: dict[str, Any]) -> None:
        try:
            self.file.write(json.dumps(line, ensure_ascii=True, allow_nan=False).encode() + b"\n")
            self.file.flush()
            os.fsync(self.file.fileno())
        except OSError as error:
            with suppress(OSError):
                self.file.close()  # what is left in the buffer is a torn line: dropped when the journal is read
            raise self._unusable(f"cannot be written: {error.strerror or error}") from error

    def _cut(self, size: int) -> None:
        self.file.truncate(size)
        self.file.seek(0, os.SEEK_END)

    def _damaged(self, number: int) -> InputError:
        return self._unusable("not a line this program wrote; remove the file to begin again", number)

    def _unusable(self, message: str, line: int | None = None) -> InputError:
        return InputError(message, Location(str(self.path), line))
