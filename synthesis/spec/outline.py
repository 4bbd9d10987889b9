"""A specification in a few lines: section by section, as it was written, numbers as short decimals."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from pydantic import BaseModel

from .exact import decimal_text

MOST_ITEMS = 8  # of a list


def outline(spec: BaseModel) -> Iterator[tuple[str, str]]:
    """Name and content of every section that says something."""
    for name, value in spec:
        if name not in ("robimp", "name") and value is not None:
            yield name, _text(value)


def _text(value: Any) -> str:
    if isinstance(value, Fraction):
        return decimal_text(value)
    if isinstance(value, BaseModel) and not _is_function(value):
        return ", ".join(f"{key} {_nested(item)}".rstrip() for key, item in value if _says(item))
    if isinstance(value, tuple):
        return f"[{', '.join(map(_text, value[:MOST_ITEMS]))}{', …' if len(value) > MOST_ITEMS else ''}]"
    return str(value)


def _nested(value: Any) -> str:
    text = _text(value)
    return f"({text})" if text and isinstance(value, BaseModel) and not _is_function(value) else text


def _says(value: Any) -> bool:
    """Whether there is anything to tell: a section says something, or is asked for by having no keys at all."""
    if not isinstance(value, BaseModel):
        return value is not None
    return not type(value).model_fields or any(_says(item) for _, item in value)


def _is_function(value: BaseModel) -> bool:
    """Rational functions write themselves."""
    return "numerator" in type(value).model_fields
