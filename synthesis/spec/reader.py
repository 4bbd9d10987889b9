"""YAML 1.2 bytes to a tree whose every node knows its line, column and dotted key.

Built on ruamel's event stream: no scalar is interpreted, so numbers stay the text that was written, and whatever makes
a YAML file mean more than it shows (aliases, tags, duplicate keys, several documents) is refused where it stands.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    MappingEndEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
)

from ..errors import InputError, Location
from .refusal import refusal
from .tree import MAX_DEPTH, Mapping, Node, Scalar, Sequence, joined

# Bounds on the text, before YAML sees it: the scanner's time grows with the square of some of them.
MAX_BYTES, MAX_LINES, MAX_LINE_LENGTH = 1_000_000, 20_000, 20_000


def read_tree(data: bytes, file: str) -> Node:
    """The one document in `data`.

    Raises:
        InputError: at the place of the first thing that cannot be read.
    """
    return _Reader(decode(data, file), file).document()


def decode(data: bytes, file: str) -> str:
    """UTF-8 text (a byte order mark is dropped) of bounded size.

    Raises:
        InputError: not UTF-8, or larger than any specification.
    """
    if len(data) > MAX_BYTES:
        raise InputError(f"expected at most {MAX_BYTES} bytes; found more: is this the right file?", Location(file))
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        column = error.start - data.rfind(b"\n", 0, error.start)
        message = f"expected UTF-8 text; found the byte 0x{data[error.start]:02x}; save the file as UTF-8"
        raise InputError(message, Location(file, line, column)) from None
    lines = text.split("\n")
    if len(lines) > MAX_LINES:
        raise InputError(f"expected at most {MAX_LINES} lines; found {len(lines)}", Location(file, MAX_LINES))
    for number, line_text in enumerate(lines, 1):
        if len(line_text) > MAX_LINE_LENGTH:
            message = f"expected lines of at most {MAX_LINE_LENGTH} characters; found {len(line_text)}; break the line"
            raise InputError(message, Location(file, number, MAX_LINE_LENGTH))
    return text


class _Reader:
    """A cursor over ruamel's events that knows the file they come from."""

    def __init__(self, text: str, file: str) -> None:
        self.text, self.file, self.last = text, file, Location(file, 1, 1)
        self.events = YAML(typ="safe", pure=True).parse(text)

    def document(self) -> Node:
        root: Node | None = None
        while (event := self.next()) is not None:
            if not isinstance(event, DocumentStartEvent):
                continue
            if root is not None:
                raise InputError("expected one document; found a second one; split the file here", self.place(event))
            if event.version not in (None, (1, 2)):
                raise InputError("expected YAML 1.2; remove the %YAML line", self.place(event))
            root = self.node(self.next(), None, 0)
        if root is None:
            message = "expected a specification; the file is empty; `robimp init` writes one to start from"
            raise InputError(message, Location(self.file, 1, 1))
        return root

    def next(self) -> Any:
        """The next event, None at the end; whatever the scanner objects to becomes one line of text."""
        try:
            event = next(self.events, None)
        except MarkedYAMLError as error:
            raise refusal(error, self.text, self.last) from None
        except YAMLError as error:  # a character YAML forbids; the reader knows only its position
            position = getattr(error, "position", 0)
            line = self.text.count("\n", 0, position) + 1
            column = position - self.text.rfind("\n", 0, position)
            message = "expected printable text; found a control character; remove it"
            raise InputError(message, Location(self.file, line, column)) from None
        except ValueError:  # chr() of an escape beyond Unicode, which the scanner does not check
            raise InputError("not valid YAML: an escape that is no character, near here", self.last) from None
        if event is not None:
            self.last = self.place(event)
        return event

    def place(self, event: Any, key: str | None = None) -> Location:
        return Location(self.file, event.start_mark.line + 1, event.start_mark.column + 1, key)

    def node(self, event: Any, key: str | None, depth: int, at: Location | None = None) -> Node:
        """The node that begins with `event`; a section, list or empty value is placed at its key `at`."""
        where = self.place(event, key)
        if isinstance(event, AliasEvent) or event.anchor is not None:
            raise InputError("anchors and aliases (&, *) are not accepted; write the value out", where)
        if getattr(event, "ctag", None) is not None:
            raise InputError("tags (!) are not accepted; write the plain value", where)
        if depth > MAX_DEPTH:
            raise InputError(f"expected at most {MAX_DEPTH} nested levels; found more", where)
        if isinstance(event, ScalarEvent):
            return Scalar(event.value, not event.style, where if event.value else at or where)
        if isinstance(event, SequenceStartEvent):
            return Sequence(tuple(self.items(key, depth)), at or where)
        return Mapping(dict(self.entries(key, depth)), at or where)

    def items(self, key: str | None, depth: int) -> Iterator[Node]:
        index = 0
        while not isinstance(event := self.next(), SequenceEndEvent):
            yield self.node(event, f"{key or ''}[{index}]", depth + 1)
            index += 1

    def entries(self, key: str | None, depth: int) -> Iterator[tuple[str, tuple[Location, Node]]]:
        seen: dict[str, int | None] = {}
        while not isinstance(event := self.next(), MappingEndEvent):
            name = self.node(event, key, depth + 1)
            if not isinstance(name, Scalar):
                raise InputError("expected a key; found a section or a list; keys are single words", name.where)
            at = self.place(event, joined(key, name.text))
            if name.text == "<<" and name.plain:
                raise InputError("merge keys (<<) are not accepted; write the keys out", at)
            if name.text in seen:
                raise InputError(f"the key is given twice, first in line {seen[name.text]}; keep one", at)
            seen[name.text] = at.line
            yield name.text, (at, self.node(self.next(), at.key, depth + 1, at))
