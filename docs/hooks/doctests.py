"""Examples in docstrings, `>>> …` up to the next empty line, as code of the reference and not as quotations."""

from __future__ import annotations

import re
from typing import Any

import griffe

EXAMPLE = re.compile(r"^( *)>>> (?:.*\n?)(?:\1\S.*(?:\n|$))*", re.MULTILINE)


def fenced(docstring: str) -> str:
    """The text with a fence around every example."""
    return EXAMPLE.sub(lambda found: f"{found[1]}```pycon\n{found[0].rstrip()}\n{found[1]}```\n", docstring)


class Doctests(griffe.Extension):
    """Called by the reader of the sources with everything that has a docstring."""

    def on_object(self, *, obj: Any, **_: Any) -> None:
        """Fence the examples."""
        if not obj.is_alias and obj.docstring:
            obj.docstring.value = fenced(obj.docstring.value)
