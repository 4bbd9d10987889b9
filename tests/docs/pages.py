"""Documentation that runs: every fenced block of a page, in the page's order, in a folder of its own.

| block | what happens |
|---|---|
| `console` | each line after `$ ` is a command; the lines below it, where there are any, are what it prints |
| `python` | runs; all of a page share one namespace; a `text` block right below is what it prints |
| any with `title="FILE"` | becomes that file; a specification (`robimp: 1`) must be accepted |
| `yaml` without a title | its sections, put into examples/haninger2016-paper.yaml, must be accepted |
| `diff` with `title="FILE"` | its `-` lines and context stand there once, and are replaced; `…`: rest of a line |
| after `<!-- not run: REASON -->` | nothing |

In what is compared, `…` stands for anything on a line, and a line of its own for any lines. A command must succeed
unless the next one is `echo $?`. Whatever else has a fence, or is indented as code, is an error: no block escapes.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest.mock import patch

from markdown_it import MarkdownIt
from ruamel.yaml import YAML

from robimp.synthesis import InputError, cli, parse

ROOT = Path(__file__).parents[2]
SOURCES = "<!-- in a copy of the sources -->"
NOT_RUN = re.compile(r"<!-- not run: (\S.*) -->")
TITLE = re.compile(r'title="([^"]+)"')
SHELL = set("|&;<>()$`*?#~\n")  # a command with none of these needs no shell


class WrongBlockError(AssertionError):
    """A block that does not do what its page says."""


@dataclass(frozen=True)
class Block:
    """A fenced block: its place, language, content, file name, and what the page says it prints."""

    place: str
    language: str
    text: str
    title: str | None = None
    output: str | None = None
    reason: str | None = None

    def wrong(self, message: str) -> WrongBlockError:
        """An error that names the place."""
        return WrongBlockError(f"{self.place}: {message}")


def blocks(text: str, name: str) -> list[Block]:
    """The blocks of a page. Raises: WrongBlockError for one that nothing would run."""
    found: list[Block] = []
    before = ""
    for token in MarkdownIt().enable("table").parse(text):
        if token.level and token.type not in ("fence", "code_block"):
            continue
        place = f"{name}:{token.map[0] + 1}" if token.map else name
        if token.type == "code_block":
            raise WrongBlockError(f"{place}: code by indentation; put it into a fence with its language")
        if token.type == "fence":
            language, title = token.info.split(" ")[0], TITLE.search(token.info)
            reason = NOT_RUN.search(before)
            block = Block(place, language, token.content, title and title[1], reason=reason and reason[1])
            if language == "text" and before == "python":
                block = found.pop()
                block = Block(block.place, "python", block.text, output=token.content)
            elif language not in ("console", "python", "yaml", "diff") and not (block.title or block.reason):
                raise block.wrong(f"nothing runs a block of {language or 'no language'}")
            found.append(block)
            before = language if not block.reason else ""
        elif token.type == "html_block":
            before = token.content
        elif token.type.endswith("_open"):
            before = ""
    return found


def matches(shown: str, printed: str) -> bool:
    """Whether what a page shows is what was printed, `…` and the width of columns aside."""
    pattern = ""
    for line in shown.rstrip().split("\n"):
        inside = "[^\n]*".join(map(re.escape, line.rstrip().split("…")))
        inside = re.sub(r"(?:\\ ){2,}", " {2,}", inside)
        pattern += r"(?:[^\n]*\n)*?" if line.strip() == "…" else inside + r"\n"
    return re.fullmatch(pattern, "".join(f"{line.rstrip()}\n" for line in printed.rstrip().split("\n"))) is not None


def commands(block: Block) -> Iterator[tuple[str, str, bool]]:
    """Commands of a console, what each shows below it, and whether it may fail because `echo $?` follows."""
    parts = re.split(r"^\$ ", block.text.replace("\\\n", ""), flags=re.MULTILINE)
    if parts[0].strip():
        raise block.wrong("begins with what is no command; commands follow `$ `")
    lines = [part.split("\n", 1) for part in parts[1:]]
    for (command, shown), following in zip(lines, [*lines[1:], None], strict=True):
        yield command, shown, following is not None and following[0] == "echo $?"


@dataclass
class Page:
    """A page that is being followed, in its folder."""

    folder: Path
    environment: dict[str, str] = field(default_factory=dict)
    namespace: dict[str, Any] = field(default_factory=lambda: {"__name__": "page"})
    status: int = 0

    def follow(self, text: str, name: str) -> int:
        """Run every block; how many were run. Raises: WrongBlockError at the first that does something else."""
        if text.startswith(SOURCES):
            self._copy_sources()
        else:  # pages are read where the repository is
            (self.folder / "examples").symlink_to(ROOT / "examples")
        run = [block for block in blocks(text, name) if block.reason is None]
        for block in run:
            self.run(block)
        return len(run)

    def run(self, block: Block) -> None:
        """One block. Raises: WrongBlockError."""
        if block.language == "diff":
            self._edit(block)
        elif block.title is not None:
            self._write(block)
        else:
            {"console": self._console, "python": self._python, "yaml": self._sections}[block.language](block)

    def _copy_sources(self) -> None:
        """The folders as they are in the repository, and found under their installed names by what a page starts."""
        names = self.folder / ".names" / "robimp"
        names.mkdir(parents=True)
        for folder in ("models", "synthesis", "examples"):
            shutil.copytree(ROOT / folder, self.folder / folder, ignore=shutil.ignore_patterns("*.svg", "frf"))
            (names / folder).symlink_to(self.folder / folder, target_is_directory=True)
        self.environment["PYTHONPATH"] = str(names.parent)

    def _write(self, block: Block) -> None:
        assert block.title is not None
        path = self.folder / block.title
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(block.text, encoding="utf-8")
        if block.language == "yaml" and "robimp: 1" in block.text and not self.environment:
            self._accepted(block, block.text)

    def _edit(self, block: Block) -> None:
        """Replace, in the file, the block's context with `-` lines by its context with `+` lines."""
        path = self.folder / str(block.title)
        text = path.read_text(encoding="utf-8")
        for hunk in re.split(r"^@@.*\n", block.text, flags=re.MULTILINE):
            lines = hunk.splitlines(True)
            old, new = (
                re.sub("…\n?", "", "".join(line[1:] for line in lines if line[:1] in kept)) for kept in (" -", " +")
            )
            if hunk and text.count(old) != 1:
                raise block.wrong(f"{block.title} holds this {text.count(old)} times:\n{old}")
            text = text.replace(old, new)
        path.write_text(text, encoding="utf-8")

    def _sections(self, block: Block) -> None:
        """A part of a specification: its sections in place of the example's."""
        whole = YAML(typ="rt").load((ROOT / "examples" / "haninger2016-paper.yaml").read_text(encoding="utf-8"))
        whole.update(YAML(typ="rt").load(block.text))
        stream = io.StringIO()
        YAML(typ="rt").dump(whole, stream)
        self._accepted(block, stream.getvalue())

    def _accepted(self, block: Block, text: str) -> None:
        with contextlib.chdir(self.folder):
            try:
                parse(text)
            except InputError as error:
                raise block.wrong(str(error)) from error

    def _python(self, block: Block) -> None:
        printed = io.StringIO()
        with contextlib.chdir(self.folder), contextlib.redirect_stdout(printed):
            try:
                exec(compile(block.text, block.place, "exec"), self.namespace)
            except Exception as error:
                raise block.wrong(f"{type(error).__name__}: {error}") from error
        if block.output is not None:
            self.compare(block, "it", block.output, printed.getvalue())

    def _console(self, block: Block) -> None:
        for command, shown, may_fail in commands(block):
            words = shlex.split(command) if not SHELL & set(command) else []
            inside = words[:1] == ["robimp"] and not self.environment
            printed = self._inside(words) if inside else self._outside(command)
            if self.status and not may_fail:
                raise block.wrong(f"`{command}` ends with {self.status}:\n{printed}")
            if shown.strip():
                self.compare(block, f"`{command}`", shown, printed)

    def compare(self, block: Block, what: str, shown: str, printed: str) -> None:
        """What a page shows with what was printed. Raises: WrongBlockError."""
        if not matches(shown, printed):
            raise block.wrong(f"{what} prints\n{printed}")

    def _inside(self, words: list[str]) -> str:
        """A robimp command in this process, which has the libraries loaded."""
        printed = io.StringIO()
        with (
            contextlib.chdir(self.folder),
            contextlib.redirect_stdout(printed),
            contextlib.redirect_stderr(printed),
            patch.object(sys, "argv", words),
            warnings.catch_warnings(),
        ):
            try:
                cli.main()
            except SystemExit as end:
                self.status = int(end.code or 0)
        return printed.getvalue()

    def _outside(self, command: str) -> str:
        path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
        done = subprocess.run(
            ["bash", "-c", f"(exit {self.status})\n{command}"],
            cwd=self.folder,
            env={**os.environ, "PATH": path, **self.environment},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=300,
        )
        self.status = done.returncode
        return done.stdout
