"""From files to a page: which are certificates, which is a map, and that none of them is overwritten."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ...errors import ExitCode, InputError, Location
from ...storage import bounded_bytes, demand_replaceable
from .map_page import write_map_report
from .recorded import MAX_BYTES, is_map
from .write import write_report


@dataclass(frozen=True)
class Reported:
    """A file of a report: its outcome and, of a certificate, what the checker says."""

    file: str
    exit_code: ExitCode
    message: str


def report_files(
    files: Sequence[Path], path: Path, progress: Callable[[str], None] = lambda _: None, *, time_limit: float = 60.0
) -> tuple[Reported, ...]:
    """Write one HTML file about certificates, or about one map; time_limit [s] for each check.

    Raises: InputError for a file that is neither, or a path that cannot be written.
    """
    contents = {str(file): bounded_bytes(file, MAX_BYTES) for file in files}
    _demand_distinct(files, path)
    demand_replaceable(path)
    maps = [file for file, data in contents.items() if is_map(data)]
    if maps:
        if len(contents) > 1:
            raise InputError("is a map: report it alone", Location(maps[0]))
        code = write_map_report(contents[maps[0]], Path(maps[0]).name, path, progress)
        return (Reported(maps[0], code, ""),)
    verdicts = write_report(_shown(contents), path, progress, time_limit=time_limit)
    pairs = zip(contents, verdicts, strict=True)
    return tuple(Reported(file, ExitCode(verdict.exit_code), verdict.message) for file, verdict in pairs)


def _demand_distinct(files: Sequence[Path], path: Path) -> None:
    for file in files:
        if path.absolute() == file.absolute() or (path.exists() and path.samefile(file)):
            raise InputError(f"would overwrite {file}; name another file", Location(str(path)))


def _shown(contents: Mapping[str, bytes]) -> Mapping[str, bytes]:
    """Certificates by the name the page shows: the file's own where that tells them apart."""
    names = [Path(file).name for file in contents]
    if len(set(names)) < len(names):
        return contents
    return dict(zip(names, contents.values(), strict=True))
