"""Put what commands and code print now into pages, such as `python tests/docs/update.py README.md`; then read the diff.

Lines that fit stay as they are, with their `…`; times are elided.
"""

from __future__ import annotations

import re
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from pages import Block, Page, matches

TIME = re.compile(r"\b\d+(\.\d+)? (s|min)\b(?=$|[,;])", re.MULTILINE)


@dataclass(frozen=True)
class Change:
    """What has to stand below a command, or below code, instead of what is shown there."""

    line: int  # of the block
    command: str
    shown: str
    printed: str

    def applied(self, text: str) -> str:
        """The page with it."""
        start = sum(map(len, text.splitlines(True)[: self.line]))
        at = text.index(self.shown, text.index(self.command, start) + len(self.command))
        return text[:at] + self.printed + text[at + len(self.shown) :]


@dataclass
class Updated(Page):
    """A page that takes over what differs."""

    changes: list[Change] = field(default_factory=list)

    def compare(self, block: Block, what: str, shown: str, printed: str) -> None:
        """Note what differs."""
        if not matches(shown, printed):
            lines = "".join(_taken_over(shown.splitlines(), [line.rstrip() for line in printed.rstrip().split("\n")]))
            command = f"$ {what[1:-1]}\n" if what[0] == "`" else "```text\n"
            self.changes.append(Change(int(block.place.rpartition(":")[2]), command, shown, TIME.sub(r"… \2", lines)))


def _taken_over(shown: list[str], printed: list[str]) -> Iterator[str]:
    """Printed lines where shown ones differ, up to a line `…`; from there on, what is shown, if it fits."""
    start = shown.index("…") if "…" in shown else len(printed)
    old = shown[:start] + [""] * (start - len(shown))
    head = [was if matches(was, now) else now for was, now in zip(old, printed, strict=False)]
    fits = matches("\n".join(shown[start:]), "\n".join(printed[start:]))
    yield from (f"{line}\n" for line in head + (shown if fits else printed)[start:])


def main() -> None:
    """Every page named on the command line."""
    for name in sys.argv[1:]:
        path = Path(name).resolve()
        text = path.read_text(encoding="utf-8")
        with tempfile.TemporaryDirectory() as folder:
            page = Updated(Path(folder))
            page.follow(text, name)
        for change in reversed(page.changes):
            text = change.applied(text)
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
