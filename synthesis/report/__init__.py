"""What a person reads. The package can be called: `report(files, path)`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..errors import ExitCode


def write(
    files: str | Path | Sequence[str | Path], path: str | Path, *, time_limit: float = 60.0
) -> tuple[ExitCode, ...]:
    """Write one HTML file about certificates, each re-checked first, or about one map; `robimp report`.

    files: of certificates, several of which are compared, or one `map.json`. path: of the page. time_limit [s] for
    each check. Returns an exit code for each file: the page is written whatever it is, and says so.

    Raises: InputError for a file that is neither, or a path that cannot be written.

    >>> from robimp.synthesis import report
    >>> report("certificate.json", "report.html")
    (<ExitCode.PROVEN: 0>,)
    """
    from .html import report_files

    paths = [Path(file) for file in ([files] if isinstance(files, str | Path) else files)]
    return tuple(each.exit_code for each in report_files(paths, Path(path), time_limit=time_limit))


class _Report(ModuleType):
    """The package is its own main function, for `synthesis` hands it on under the folder's name."""

    __call__ = staticmethod(write)


sys.modules[__name__].__class__ = _Report
