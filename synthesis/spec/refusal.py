"""What YAML's scanner objects to, for the person who wrote the text: where the mistake is and what to write instead."""

from __future__ import annotations

from typing import Any

from ruamel.yaml.error import MarkedYAMLError

from ..errors import InputError, Location
from .tree import shown

# Part of the scanner's message, and what to do; the first that fits.
_ADVICE = (
    ("'\\t'", "indent with spaces, not with a tab"),
    ("could not find expected ':'", "write `key: value`, with a space behind the colon"),
    ("mapping values are not allowed", "indent the keys of a section alike, and quote a text that holds a colon"),
    ("end of stream", "close the quote or the bracket"),
    ("expected ',' or ']'", "close the bracket with `]`, or put a comma between the items"),
    ("expected ',' or '}'", "close the brace with `}`, or put a comma between the keys"),
)


def refusal(error: MarkedYAMLError, text: str, last: Location) -> InputError:
    """The error as one line. text: of the file; last: the last place that could be read."""
    problem = " ".join(str(error.problem).split())
    problem = problem if problem.isprintable() else ascii(problem)
    advice = next((advice for part, advice in _ADVICE if part in problem), "check brackets, quotes and indentation")
    mark = _mark(error, problem)
    where = Location(last.file, mark.line + 1, mark.column + 1) if mark else last
    line = text.split("\n")[(where.line or 1) - 1 : where.line]
    found = f" in {shown(line[0].strip())}" if line and line[0].strip() else ""
    return InputError(f"not valid YAML{found}: {problem}; {advice}", where)


def _mark(error: MarkedYAMLError, problem: str) -> Any:
    """What never ends is a mistake where it begins, not where the scanner gives up."""
    begins, noticed = error.context_mark, error.problem_mark
    endless = "end of stream" in problem or "could not find expected ':'" in problem
    unclosed = problem.startswith("expected ',' or") and begins and noticed and begins.line != noticed.line
    return begins if begins and (endless or unclosed) else noticed
