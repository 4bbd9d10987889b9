"""Pages for the tests: certificates, what a parser finds in a page, and what would be fetched from elsewhere."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from robimp.synthesis.check import canonical_json
from robimp.synthesis.report.html.study import Study
from robimp.synthesis.report.html.write import render

DATA = Path(__file__).parents[1] / "data"
PAPER = DATA / "golden" / "haninger2016-paper.json"
EQ23 = DATA / "golden" / "haninger2016-eq23.json"
LINEAR = DATA.parents[1] / "examples" / "certificates" / "ut-sea.json"
STIFF = DATA / "must-reject" / "haninger2016-stiff.json"
LOWERED = DATA / "must-reject" / "haninger2016-paper--peak-lowered.json"
UNSTABLE = DATA / "must-reject" / "unstable-optimum.json"
WITHOUT = DATA / "must-reject" / "ideal-box--without-bandwidth.json"
GARBAGE = DATA / "must-reject" / "ideal-box--truncated.json"

VOID = {"meta", "link", "br", "hr", "img", "input", "source", "base"}
FETCHING = re.compile(r"""(?:@import|url\(\s*["']?(?!data:))""")
TYPESET = re.compile(r"<i>(\w)</i><sub>(\w+)</sub>")  # a symbol with an index: one word to a reader
ADDRESS = ("src", "href", "srcset", "action", "data", "poster", "xlink:href", "formaction")


@cache
def study(path: Path) -> Study:
    """A certificate, checked once for all tests of a process."""
    return Study.of(path.name, path.read_bytes())


@cache
def html(*paths: Path) -> str:
    """The page about certificates."""
    return render([study(path) for path in paths]).decode()


def changed(path: Path, change: Callable[[dict[str, Any]], None]) -> bytes:
    """A certificate with something else in it, and digests that fit."""
    content = json.loads(path.read_bytes())
    change(content)
    body = {key: value for key, value in content.items() if key != "end"}
    content["end"]["body_sha256"] = hashlib.sha256(canonical_json(body)).hexdigest()
    return json.dumps(content).encode()


@dataclass
class Page(HTMLParser):
    """Elements, their text, and whether every element was closed where it should be."""

    text: str
    elements: list[tuple[str, dict[str, str | None]]] = field(default_factory=list)
    said: str = ""
    scripts: list[str] = field(default_factory=list)
    styles: list[str] = field(default_factory=list)
    misnested: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.feed(TYPESET.sub(r"\1_\2", self.text))
        self.close()
        self.misnested += self.open

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attributes)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attributes)))

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            self.misnested.append(tag)

    def handle_data(self, data: str) -> None:
        inside = self.open[-1] if self.open else ""
        if inside in ("script", "style"):
            (self.scripts if inside == "script" else self.styles).append(data)
        else:
            self.said += f" {data.strip()}"

    def of_class(self, name: str) -> list[str]:
        return [tag for tag, attributes in self.elements if name in (attributes.get("class") or "").split()]

    @property
    def figures(self) -> list[dict[str, Any]]:
        """What the script draws."""
        drawn: list[dict[str, Any]] = json.loads(self.scripts[0])
        return drawn

    @property
    def fetched(self) -> list[str]:
        """Whatever a browser would ask somebody else for."""
        found = [str(a[key]) for _, a in self.elements for key in ADDRESS if key in a and not _local(a[key])]
        return found + [match.group() for style in self.styles for match in FETCHING.finditer(style)]


def _local(address: str | None) -> bool:
    return (address or "").startswith(("#", "data:"))
