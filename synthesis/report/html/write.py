"""From certificates to the file: check, draw, render, write."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from ...interruption import demanding
from ...storage import write_atomic
from .chapter import chapter
from .comparison import comparison, names, rows
from .page import page
from .study import Study

if TYPE_CHECKING:
    from ...check import Verdict

Progress = Callable[[str], None]


def write_report(
    certificates: Mapping[str, bytes],
    path: Path,
    progress: Progress = lambda _: None,
    *,
    time_limit: float = 60.0,
    checked: Mapping[str, Verdict] = MappingProxyType({}),
) -> tuple[Verdict, ...]:
    """Re-check certificates and write one HTML file about them; several are compared.

    certificates: the bytes of each by the name to show. time_limit [s] for each check. checked: verdicts on these very
    bytes, by name, of certificates that were checked a moment ago: they are not again. Returns the checker's verdicts,
    in order: a page is written whatever they are, and says so. Raises: InputError for bytes that are no certificate,
    when nothing is written, or for a path that cannot be written.
    """
    studies, progress = [], demanding(progress)
    for name, data in certificates.items():
        if name not in checked:
            progress(f"re-checking {name}")
        studies.append(Study.of(name, data, time_limit=time_limit, verdict=checked.get(name)))
    write_atomic(path, render(studies, progress))
    return tuple(study.verdict for study in studies)


@np.errstate(all="ignore")
def render(studies: Sequence[Study], progress: Progress = lambda _: None) -> bytes:
    """The page about studied certificates."""
    chapters = []
    for study in studies:
        progress(f"drawing {study.file}")
        chapters.append(chapter(study))
    together = (comparison(studies), rows(studies)) if len(studies) > 1 else None
    return page(chapters, names(studies), together).encode()
