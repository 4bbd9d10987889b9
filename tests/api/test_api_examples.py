"""The examples in the docstrings of the public names run, and say what they say."""

from __future__ import annotations

import doctest
import inspect
from pathlib import Path
from typing import Any

import pytest

import robimp.synthesis
from robimp.synthesis import Polynomials

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
PARSER = doctest.DocTestParser()


def documented() -> dict[str, str]:
    """Docstrings by name: of functions, and of methods of types."""
    found: dict[str, Any] = {name: getattr(robimp.synthesis, name) for name in robimp.synthesis.__all__}
    texts = {name: (each.__call__ if inspect.ismodule(each) else each).__doc__ or "" for name, each in found.items()}
    return texts | {"Polynomials.to_control": Polynomials.to_control.__doc__ or ""}


TEXTS = documented()
WITH_EXAMPLE = sorted(name for name, text in TEXTS.items() if ">>>" in text)
FUNCTIONS = {name for name in robimp.synthesis.__all__ if name[0].islower()}


def failures(text: str, name: str) -> str:
    """What a docstring's examples print instead of what they promise."""
    said: list[str] = []
    test = PARSER.get_doctest(text, {}, name, None, None)
    doctest.DocTestRunner(optionflags=FLAGS, verbose=False).run(test, out=said.append)
    return "".join(said)


def test_every_function_has_an_example() -> None:
    assert set(WITH_EXAMPLE) >= FUNCTIONS


@pytest.mark.parametrize("name", WITH_EXAMPLE)
def test_an_example_runs_as_printed(name: str, folder: Path) -> None:
    assert failures(TEXTS[name], name) == ""


def test_an_example_that_prints_something_else_is_seen(folder: Path) -> None:
    wrong = TEXTS["load"].replace("rotary", "linear")
    assert "Expected" in failures(wrong, "load") and "rotary" in failures(wrong, "load")
    assert "FileNotFound" in failures(">>> open('absent').read()", "absent")
